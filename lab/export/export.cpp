#include "lab/export/export.h"

#include <algorithm>
#include <functional>
#include <memory>
#include <tuple>

#include "cx/base/file.h"
#include "cx/journal/run_folder.h"
#include "lab/export/foxglove_layout.h"
#include "lab/export/mcap_export.h"
#include "lab/export/parquet_file.h"
#include "lab/export/table_export.h"
#include "lab/export/trace_export.h"

namespace cxlab::lab {

namespace {

namespace fs = std::filesystem;

/// Files that are being made, under other names until all are whole, and the folders that are made for them.
class Parts {
 public:
  Status make(const fs::path& folder) {
    std::error_code none;
    std::vector<fs::path> missing;
    for (fs::path at = folder; !at.empty() && !fs::exists(at, none); at = at.parent_path()) missing.push_back(at);
    folders_.insert(folders_.end(), missing.rbegin(), missing.rend());
    return make_folder(folder);
  }
  /// The name under which it is made.
  fs::path begin(const fs::path& file, const std::string& format) {
    files_.push_back({file.string(), format});
    return part_of(files_.back().path);
  }
  /// Gives all their names, or takes them and their folders away.
  Status end(Status made) {
    for (const Exported::File& file : files_) {
      std::error_code none;
      if (made)
        made = put_in_place(Status(), part_of(file.path), file.path);
      else
        fs::remove(part_of(file.path), none);
    }
    std::error_code none;
    if (!made)
      for (auto folder = folders_.rbegin(); folder != folders_.rend(); ++folder) fs::remove(*folder, none);
    return made;
  }
  std::vector<Exported::File>& files() { return files_; }

 private:
  static fs::path part_of(const std::string& file) { return file + ".part"; }
  std::vector<Exported::File> files_;
  std::vector<fs::path> folders_;
};

std::string name_of(const Run& run) {
  std::error_code none;
  const std::string name = fs::weakly_canonical(run.folder, none).filename().string();
  return name.empty() ? "run" : name;
}

}  // namespace

Expected<Exported> export_run(const Run& run, const ExportOptions& options, const Host& host) {
  const int formats = options.mcap + options.trace + options.csv + options.parquet;
  const bool to_file = !options.out.empty() && formats == 1 && (options.mcap || options.trace);
  const fs::path out = options.out.empty() ? run.folder / "export" : options.out;
  const fs::path folder = to_file ? out.parent_path() : out;
  if (to_file && is_folder(out))
    return usage_error("--out: " + out.string() + " is a folder, expected the name of a file");
  const auto file_of = [&](const std::string& suffix) { return to_file ? out : folder / (name_of(run) + suffix); };

  Exported done;
  Parts parts;
  std::unique_ptr<McapExport> bag;
  std::unique_ptr<TraceExport> trace;
  std::vector<std::unique_ptr<TableExport>> tables;
  std::vector<PassListener*> listeners;

  const auto begin = [&]() -> Status {
    if (!folder.empty())
      if (Status s = parts.make(folder); !s) return s;
    if (options.mcap) {
      auto made = McapExport::create(run, options.stretch, options.pictures, parts.begin(file_of(".mcap"), "mcap"));
      if (!made) return made.error();
      bag = *std::move(made);
      const auto more = bag->listeners();
      listeners.insert(listeners.end(), more.begin(), more.end());
      if (run.manifest.spec.journal != JournalLevel::kFull)
        done.notes.push_back(
            "the run has no messages of the bus, because its journal has only decisions: cxlab run --journal full "
            "records them");
      if (!has_scenes(run)) done.notes.push_back("the run has no scene, so there are no poses and no markers");
    }
    if (options.trace) {
      auto made = TraceExport::create(run, options.stretch, parts.begin(file_of(".trace.json"), "trace"));
      if (!made) return made.error();
      trace = *std::move(made);
      listeners.push_back(trace.get());
      if (run.manifest.spec.journal != JournalLevel::kFull)
        done.notes.push_back(
            "the trace has no firings, because the journal has only decisions: cxlab run --journal full records them");
    }
    for (const auto& [wanted, format, create] :
         {std::tuple{options.csv, "csv", &create_csv}, {options.parquet, "parquet", &create_parquet}}) {
      if (!wanted) continue;
      const fs::path of_tables = formats == 1 && !options.out.empty() ? folder : folder / format;
      if (Status s = parts.make(of_tables); !s) return s;
      auto made = TableExport::create(
          run, options.stretch,
          [&parts, of_tables, format, create](const std::string& name, std::vector<TableColumn> columns) {
            return create(parts.begin(of_tables / (name + '.' + format), format), std::move(columns));
          });
      if (!made) return made.error();
      tables.push_back(*std::move(made));
      listeners.push_back(tables.back().get());
    }
    return {};
  };
  const auto complete = [&]() -> Status {
    if (bag)
      if (Status s = bag->close(); !s) return s;
    if (trace)
      if (Status s = trace->close(); !s) return s;
    for (const auto& table : tables)
      if (Status s = table->close(); !s) return s;
    if (bag) {
      const fs::path file = file_of(".mcap").replace_extension(".foxglove.json");
      if (Status s = write_file(parts.begin(file, "foxglove-layout"), foxglove_layout(bag->bag().topics())); !s)
        return s;
    }
    return {};
  };

  Status made = begin();
  if (made) made = pass_over(run, options.stretch, listeners, host);
  if (made && host.stopped()) made = resource_error("the export was stopped");
  if (made) made = complete();
  if (Status s = parts.end(std::move(made)); !s) return s.error();
  for (Exported::File& file : parts.files()) {
    std::error_code none;
    file.bytes = fs::file_size(file.path, none);
    if (file.format == "mcap") file.entries = bag->bag().file().messages();
    if (file.format == "trace") file.entries = trace->events();
    if (file.format != "csv" && file.format != "parquet") continue;
    for (const auto& table : tables)
      if (const auto rows = table->rows().find(fs::path(file.path).stem().string()); rows != table->rows().end())
        file.entries = rows->second;
  }
  done.files = std::move(parts.files());
  return done;
}

Json json_of(const Exported& exported) {
  Json files = Json::array();
  for (const Exported::File& file : exported.files)
    files.push_back({{"path", file.path}, {"format", file.format}, {"bytes", file.bytes}, {"entries", file.entries}});
  return {{"files", std::move(files)}, {"notes", exported.notes}};
}

}  // namespace cxlab::lab
