#include "cx/executive/files.h"

#include "cx/base/file.h"
#include "cx/base/remedy.h"
#include "cx/executive/reach.h"

namespace cxlab::cx {

namespace fs = std::filesystem;

namespace {

/// A folder, a pipe or a device, whatever links lead to it.
bool is_special(const fs::path& path) {
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  return fs::exists(status) && !fs::is_regular_file(status);
}

/// The kind of a file that is not a regular one.
std::string what_it_is(const fs::path& path) {
  std::error_code ignored;
  switch (fs::status(path, ignored).type()) {
    case fs::file_type::directory: return "a folder";
    case fs::file_type::fifo: return "a pipe";
    case fs::file_type::socket: return "a socket";
    default: return "a device";
  }
}

bool leaves(const fs::path& relative) {
  return relative.is_absolute() || (!relative.empty() && *relative.begin() == "..");
}

/// `path` relative to `folder`, if it lies there.
bool below(const fs::path& path, const fs::path& folder, fs::path& relative) {
  relative = path.lexically_relative(folder);
  return !relative.empty() && !leaves(relative);
}

}  // namespace

bool really_below(const fs::path& file, const fs::path& folder) {
  std::error_code error;
  const fs::path real = fs::weakly_canonical(file, error);
  if (error) return false;
  const fs::path real_folder = fs::weakly_canonical(folder, error);
  fs::path relative;
  return !error && below(real, real_folder, relative);
}

bool links_to_source(const fs::path& file, const fs::path& package) {
  std::error_code error;
  fs::path source = fs::canonical(file, error);
  if (error) return false;
  const fs::path relative = file.lexically_relative(package);
  for (auto part = relative.end(); part != relative.begin(); source = source.parent_path())
    if (*--part != source.filename()) return false;
  return fs::equivalent(package / "package.xml", source / "package.xml", error) && !error;
}

fs::path outside_name(const fs::path& path) {
  fs::path name;
  for (const fs::path& part : path.lexically_normal().relative_path()) name /= part == ".." ? fs::path("up") : part;
  return name;
}

Files::Files(Options options) : options_(std::move(options)) {
  for (auto& [name, package] : options_.packages) {
    package.folder = fs::absolute(package.folder).lexically_normal();
    if (!package.folder.has_filename()) package.folder = package.folder.parent_path();
    if (package.share.empty()) package.share = package.folder.string();
  }
  if (!options_.run_folder.empty()) options_.run_folder = fs::absolute(options_.run_folder).lexically_normal();
}

Expected<std::string> Files::share_directory(std::string_view package) const {
  const auto found = options_.packages.find(std::string(package));
  if (found != options_.packages.end()) return found->second.share;
  const std::string name(package), near = did_you_mean(name, packages());
  if (name.empty() || name.find('/') != name.npos) return input_error("'" + name + "' is no name of a package");
  return input_error("package '" + name + "' not found" +
                     (near.empty()
                          ? "; say where it is: packages: {" + name + ": DIR} in the scenario or story, or --package " +
                                name + "=DIR of cxlab env, check, test and mutate"
                          : near));
}

Expected<std::string> Files::prefix(std::string_view package) const {
  auto share = share_directory(package);
  if (!share) return share;
  const fs::path path(*share);
  if (path.filename() == package && path.parent_path().filename() == "share")
    return path.parent_path().parent_path().string();
  return share;
}

std::vector<std::string> Files::packages() const {
  std::vector<std::string> out;
  for (const auto& [name, package] : options_.packages) out.push_back(name);
  return out;
}

std::vector<fs::path> Files::folders() const {
  std::vector<fs::path> out;
  for (const auto& [name, package] : options_.packages) {
    out.push_back(package.folder);
    if (!package.rest.empty()) out.push_back(package.rest);
  }
  return out;
}

bool Files::find_in(const std::string& package, const fs::path& relative, FoundFile& out) const {
  const fs::path normal = relative.lexically_normal();
  if (leaves(normal)) return false;
  const Package& known = options_.packages.at(package);
  out.logical_name = package + '/' + normal.generic_string();
  fs::path rest;
  const bool installed = below(normal, fs::path("clips") / package, rest);
  for (const fs::path& folder : {known.folder, known.rest}) {
    if (folder.empty()) continue;
    for (const fs::path& place : {normal, installed ? "clips" / rest : fs::path()})
      if (!place.empty() && is_file(folder / place)) {
        out.path = folder / place;
        return true;
      }
  }
  out.path = known.folder / (installed ? "clips" / rest : normal);
  return false;
}

Expected<FoundFile> Files::resolve(const std::string& file, const std::vector<std::string>& packages) const {
  const fs::path path(file);
  FoundFile found;
  if (path.is_absolute()) {
    for (const auto& [name, package] : options_.packages) {
      fs::path relative;
      if (below(path.lexically_normal(), package.share, relative) && find_in(name, relative, found)) return found;
    }
    if (const fs::path real = outside(path); is_file(real)) return FoundFile{real, path.filename().string()};
  }
  for (const std::string& package : packages) {
    if (auto share = share_directory(package); !share)
      return input_error("Cannot resolve file " + file + ": " + share.error().message);
    if (find_in(package, path, found)) return found;
  }
  std::string message = "Cannot resolve file " + file;
  for (const std::string& package : packages)
    if (!find_in(package, path, found) && is_special(found.path))
      return input_error(message + ": " + found.path.string() + " is " + what_it_is(found.path) + ", expected a file");
  if (packages.empty()) message += ": no pkg_share_dirs to look in";
  for (std::size_t i = 0; i < packages.size(); ++i)
    message += (i == 0 ? ": not in " : ", ") + options_.packages.at(packages[i]).share;
  return input_error(std::move(message));
}

Expected<std::map<std::string, FoundFile>> Files::list(const std::string& folder,
                                                       const std::vector<std::string>& packages,
                                                       std::string_view extension, bool for_rules) const {
  struct Place {
    fs::path path, logical_name;
  };
  std::vector<Place> places;
  const bool anywhere = !for_rules || options_.trust_rules;
  const auto add = [&](const std::string& package, const fs::path& relative) {
    const Package& known = options_.packages.at(package);
    for (const fs::path& share : {known.folder, known.rest})
      if (const fs::path path = share / relative; !share.empty() && (anywhere || really_below(path, share)))
        places.push_back({path, package / relative});
  };
  const fs::path asked = fs::path(folder).lexically_normal();
  if (asked.is_absolute()) {
    fs::path relative;
    for (const auto& [name, package] : options_.packages)
      if (below(asked, package.share, relative)) add(name, relative);
    if (anywhere) places.push_back({outside(asked), {}});
  }
  for (const std::string& package : packages) {
    if (auto share = share_directory(package); !share)
      return input_error("Cannot resolve folder " + folder + ": " + share.error().message);
    if (!asked.is_absolute() && !leaves(asked)) add(package, asked);
  }
  bool exists = false;
  for (const Place& place : places) {
    std::error_code error;
    if (!fs::is_directory(place.path, error)) continue;
    exists = true;
    if (fs::directory_iterator(place.path, error); error && !options_.trust_rules)  // behind a wall: a link leads there
      return input_error("reading '" + place.path.string() +
                         "' is refused: rules read only files of packages, and those that rules of this run wrote (" +
                         kTrustRemedy + ')')
          .with_code(kRefused);
    std::map<std::string, FoundFile> out;
    for (fs::recursive_directory_iterator file(place.path, fs::directory_options::skip_permission_denied, error), end;
         !error && file != end; file.increment(error)) {
      if (file->path().extension() != extension || !is_file(file->path())) continue;
      const std::string name = file->path().lexically_relative(place.path).generic_string();
      out[name] = {file->path(), (place.logical_name / name).lexically_normal().generic_string()};
    }
    if (!out.empty()) return out;  // the folder of a submodule that was not checked out is empty
  }
  if (exists) return std::map<std::string, FoundFile>();
  std::string message = "Cannot resolve folder " + folder;
  for (std::size_t i = 0; i < packages.size(); ++i)
    message += (i == 0 ? ": not in " : ", ") + options_.packages.at(packages[i]).share;
  if (!anywhere)
    message +=
        std::string(packages.empty() ? ": " : "; ") + "rules name folders of packages only (" + kTrustRemedy + ')';
  return input_error(std::move(message));
}

Expected<std::string> Files::read(const FoundFile& file) const {
  if (options_.on_read)
    if (Status s = options_.on_read(file.logical_name, file.path); !s) return s.error();
  if (is_special(file.path))
    return input_error("is " + what_it_is(file.path) + ", expected a file", file.path.string());
  return read_file(content_of(file.path));
}

fs::path Files::content_of(const fs::path& path) const {
  const auto other = options_.instead.find(path.lexically_normal());
  return other == options_.instead.end() ? path : other->second;
}

fs::path Files::outside(const fs::path& path) const {
  return options_.outside.empty() ? path : options_.outside / outside_name(path);
}

fs::path Files::written(const fs::path& path) const {
  return options_.run_folder / "written" / path.lexically_normal().relative_path();
}

fs::path Files::asked_for(const std::string& path) const {
  const fs::path asked = fs::path(path).lexically_normal();
  fs::path relative;
  const bool recorded = !options_.recorded_folder.empty() && !options_.run_folder.empty() && asked.is_absolute() &&
                        below(asked, options_.recorded_folder, relative);
  return recorded ? options_.run_folder / relative : asked;
}

Expected<FoundFile> Files::find_for_rules(const std::string& path) const {
  auto found = find_where_rules_read(path);
  if (found && !options_.trust_rules && is_special(found->path))
    return input_error("reading '" + path + "' is refused: it is not a regular file");
  return found;
}

Expected<FoundFile> Files::find_where_rules_read(const std::string& path) const {
  const fs::path asked = asked_for(path);
  FoundFile found;
  if (!options_.run_folder.empty() && !leaves(asked.relative_path())) {
    found = {written(asked), "written/" + asked.relative_path().generic_string()};
    if (is_file(found.path) && really_below(found.path, options_.run_folder)) return found;
  }
  if (asked.is_absolute()) {
    for (const auto& [name, package] : options_.packages) {
      fs::path relative;
      if (!below(asked, package.share, relative) || (is_hidden(relative) && !options_.trust_rules)) continue;
      if (!find_in(name, relative, found) || really_below(found.path, package.folder) ||
          links_to_source(found.path, package.folder) ||
          (!package.rest.empty() && really_below(found.path, package.rest)))
        return found;
    }
    // What cxlab records there differs from run to run: folder, command, machine.
    fs::path relative;
    const fs::path by_rules = options_.run_folder / "written";
    if (!options_.run_folder.empty() && below(asked, by_rules, relative) && really_below(asked, by_rules))
      return FoundFile{asked, "run/written/" + relative.generic_string()};
  }
  if (options_.trust_rules) return FoundFile{outside(asked), asked.filename().string()};
  return input_error("reading '" + path +
                     "' is refused: rules read only files of packages, and those that rules of this run wrote (" +
                     kTrustRemedy + ')');
}

std::string Files::journal_name(const std::string& path) const {
  const fs::path normal = fs::path(path).lexically_normal();
  if (!normal.is_absolute()) return path;
  // Folders may lie in each other: the file is of the innermost one, as it is in a replay.
  std::string found = normal.filename().string();
  std::size_t longest = 0;
  const auto look_in = [&](const fs::path& folder, const std::string& name) {
    fs::path relative;
    if (folder.native().size() <= longest || !below(normal, folder, relative)) return;
    found = name + '/' + relative.generic_string();
    longest = folder.native().size();
  };
  for (const auto& [name, package] : options_.packages) {
    look_in(package.folder, name);
    if (!package.rest.empty()) look_in(package.rest, name);
    look_in(package.share, name);
  }
  look_in(options_.run_folder, "run");
  return found;
}

Expected<std::string> Files::for_reading(const std::string& path) {
  auto found = find_for_rules(path);
  if (!found) return found.error();
  if (options_.on_read && is_file(found->path))
    if (Status s = options_.on_read(found->logical_name, found->path); !s) return s.error();
  return content_of(found->path).string();
}

Expected<std::string> Files::for_writing(const std::string& path) {
  if (options_.trust_rules && options_.outside.empty()) return path;
  const fs::path asked = asked_for(path);
  if (options_.run_folder.empty())
    return input_error("writing '" + path + "' is refused: the run has no folder to write to");
  if (leaves(asked.relative_path()))
    return input_error("writing '" + path + "' is refused: it leaves the run's folder");
  fs::path target = written(asked);
  fs::path relative;
  if (asked.is_absolute() && below(asked, options_.run_folder / "written", relative)) target = asked;
  if (!really_below(target, options_.run_folder))
    return input_error("writing '" + path + "' is refused: a link leads out of the run's folder");
  std::error_code error;
  fs::create_directories(target.parent_path(), error);
  if (error)
    return Error{
        ErrorKind::kResource, "cannot make the folder: " + error.message(), target.parent_path().string(), 0, {}};
  return target.string();
}

}  // namespace cxlab::cx
