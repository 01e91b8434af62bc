// cxlab export: a recorded run in the formats of other tools.

#include "lab/export/export.h"

#include <cstdio>
#include <memory>
#include <optional>

#include "app/arguments.h"
#include "app/command.h"
#include "app/console.h"
#include "app/question.h"
#include "cx/base/json.h"

namespace cxlab::app {

namespace {

// Seconds between two pictures.
constexpr double kShortest = 0.1, kLongest = 100000;

struct ExportChoice {
  std::string run;
  std::optional<double> from, to, pictures;
  std::string size = "640x480";
  lab::ExportOptions options;
  bool json = false;
};

int export_it(const ExportChoice& choice) {
  lab::ExportOptions options = choice.options;
  if (!options.mcap && !options.trace && !options.csv && !options.parquet)
    return fail(usage_error("what is to be written is missing: --mcap, --trace, --csv or --parquet"));
  if (choice.from && choice.to && *choice.from > *choice.to) return fail(usage_error("--from is after --to"));
  const auto run = open_run(choice.run);
  if (!run) return fail(run.error());
  for (const auto& [time, option] : {std::pair{choice.from, "--from"}, std::pair{choice.to, "--to"}})
    if (time)
      if (Status s = run->reaches(from_seconds(*time)); !s) return fail(lab::about_option(s.error(), option));
  if (choice.from) options.stretch.from = from_seconds(*choice.from);
  if (choice.to) options.stretch.to = from_seconds(*choice.to);
  if (choice.pictures) options.pictures.every = from_seconds(*choice.pictures);
  read_size(choice.size, options.pictures.width, options.pictures.height);
  Console console(choice.json);
  const auto exported = lab::export_run(*run, options, console.host());
  console.clear();
  if (const int code = interrupted("nothing was written")) return code;
  if (!exported) return fail(exported.error());
  if (choice.json) {
    std::printf("%s\n", json_text(lab::json_of(*exported), 2).c_str());
    return 0;
  }
  for (const auto& file : exported->files) std::printf("%s\n", file.path.c_str());
  for (const std::string& note : exported->notes) std::fprintf(stderr, "note: %s\n", note.c_str());
  return 0;
}

}  // namespace

void add_export(CLI::App& app, Action& action) {
  auto choice = std::make_shared<ExportChoice>();
  CLI::App* command = app.add_subcommand(
      "export", "Write a recorded run in the formats of Foxglove, PlotJuggler, ROS 2, Perfetto, pandas and DuckDB");
  command->add_option("run", choice->run, "Folder of the run")->required();
  CLI::Option* mcap = command->add_flag(
      "--mcap", choice->options.mcap,
      "Messages, poses, markers, skills, events and log as a bag of ROS 2, and a layout for Foxglove");
  command->add_flag("--trace", choice->options.trace,
                    "Skills, states, orders and firings along time, for ui.perfetto.dev");
  command->add_flag("--csv", choice->options.csv, "Records, skills, points and the tables of the world, a file each");
  command->add_flag("--parquet", choice->options.parquet, "The same tables as Parquet");
  command
      ->add_option("--pictures", choice->pictures,
                   "With --mcap and physics: a topic with a picture every so many seconds")
      ->check(between(kShortest, kLongest))
      ->needs(mcap);
  command
      ->add_option("--camera", choice->options.pictures.camera,
                   "Camera of --pictures, as for cxlab render (default: the field)")
      ->needs("--pictures");
  command->add_option("--size", choice->size, "Size of pictures: WIDTHxHEIGHT")
      ->check(picture_size())
      ->capture_default_str()
      ->needs("--pictures");
  command->add_option("--out,-o", choice->options.out,
                      "The file, or a folder for several formats (default: the folder export of the run)");
  time_option(command->add_option("--from", choice->from, "Beginning of the stretch (default: the start of the run)"));
  time_option(command->add_option("--to", choice->to, "End of the stretch (default: the end of the run)"));
  command->add_flag("--json", choice->json, "Prints what was written, as JSON");
  command->footer(
      "Messages of the bus are in runs of cxlab run --journal full only (docs/how-to/export-a-run.md).\n"
      "Examples:\n  cxlab export runs/game-1 --mcap --trace --csv\n  cxlab export runs/game-1 --mcap --from 5:00 --to "
      "6:00 -o part.mcap");
  command->callback([choice, &action] { action = [choice] { return export_it(*choice); }; });
}

}  // namespace cxlab::app
