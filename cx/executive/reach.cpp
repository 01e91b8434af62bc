#include "cx/executive/reach.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <string>

#include "cx/base/file.h"
#include "cx/executive/files.h"

namespace cxlab::cx {

namespace fs = std::filesystem;

namespace {

/// Definitions that are links, as colcon --symlink-install makes them: to files of the same name.
void add_definitions(const fs::path& folder, const std::string& extension, Wall& wall) {
  for_each_entry<fs::directory_iterator>(folder, [&](const auto& entry) {
    if (entry->path().extension() != extension) return;
    std::error_code broken;
    const fs::path target = fs::canonical(entry->path(), broken);
    if (!broken && target.filename() == entry->path().filename() && is_file(target)) wall.exact.push_back(target);
  });
}

/// Files of a package that are links to its source.
void add_sources(const fs::path& package, Wall& wall) {
  for_each_entry<fs::recursive_directory_iterator>(package, [&](const auto& entry) {
    std::error_code broken;
    if (!entry->is_symlink(broken) || !links_to_source(entry->path(), package)) return;
    if (const fs::path source = fs::canonical(entry->path(), broken); !broken) wall.exact.push_back(source);
  });
}

/// Somebody's folder with a configuration in it: what is hidden there is not meant.
void add_what_is_not_hidden(const fs::path& folder, Wall& wall) {
  std::error_code error;
  const fs::path real = fs::canonical(folder, error);
  if (error) return;
  wall.list.push_back(real);
  for_each_entry<fs::directory_iterator>(real, [&](const auto& entry) {
    std::error_code ignored;
    if (!is_hidden(entry->path().filename()) && !entry->is_symlink(ignored)) wall.exact.push_back(entry->path());
  });
}

}  // namespace

bool is_hidden(const fs::path& relative) {
  return std::ranges::any_of(
      relative, [](const fs::path& part) { return part.native().starts_with('.') && part != "." && part != ".."; });
}

bool holds_a_home(const fs::path& folder) {
  std::error_code error;
  const fs::path real = fs::weakly_canonical(fs::absolute(folder), error);
  if (error || !real.has_relative_path()) return true;
  const char* named = std::getenv("HOME");
  for (const fs::path& home : {fs::path(named ? named : ""), fs::path("/root"), fs::path("/home")}) {
    if (!home.is_absolute() || !home.has_relative_path()) continue;
    const fs::path from_there = fs::weakly_canonical(home, error).lexically_relative(real);
    if (!from_there.empty() && *from_there.begin() != "..") return true;
  }
  return false;
}

std::vector<fs::path> paths_in(const std::string& text) {
  constexpr const char* kEnd = " \t\r\n\"',;:()[]{}<>|";
  std::vector<fs::path> paths;
  for (std::size_t at = text.find('/'); at != text.npos;) {
    const std::size_t end = std::min(text.find_first_of(kEnd, at), text.size());
    if (at == 0 || std::strchr(kEnd, text[at - 1]) || text[at - 1] == '=')
      paths.emplace_back(text.substr(at, end - at));
    at = text.find('/', end);
  }
  return paths;
}

void add_package(const fs::path& folder, Wall& wall) {
  if (path_exists(folder / "package.xml")) {
    wall.read.push_back(folder);
    add_sources(folder, wall);
  } else {
    add_what_is_not_hidden(folder, wall);
  }
  for (const char* kind : {"msg", "srv", "action"}) add_definitions(folder / kind, std::string(".") + kind, wall);
  const fs::path share = folder.parent_path();  // of a prefix: libraries of its plugins lie beside it
  if (share.filename() == "share" && !holds_a_home(share.parent_path()))
    wall.read.push_back(share.parent_path() / "lib");
}

}  // namespace cxlab::cx
