#include "lab/new_package.h"

#include <filesystem>

#include "cx/base/file.h"
#include "cx/plugins/bindings/names.h"
#include "scenarios/share.h"

namespace cxlab::lab {

namespace {

namespace fs = std::filesystem;

bool is_letter(char c) { return c >= 'a' && c <= 'z'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// The name nearest to `text` that a package can have.
std::string nearest_name(std::string_view text) {
  std::string name;
  for (char c : text) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    if (is_letter(c) || (is_digit(c) && !name.empty()))
      name += c;
    else if (!name.empty() && name.back() != '_')
      name += '_';
  }
  while (!name.empty() && name.back() == '_') name.pop_back();
  return name;
}

/// A package is named as ROS 2 wants it, so that the project can go there: lower case, no '_' at an end or twice in a
/// row. Empty if that name can be had, else why not.
std::string objection(const std::string& name) {
  const std::string nearest = nearest_name(name);
  if (name != nearest)
    return "its last part names the package: found '" + name +
           "', expected lower-case letters, digits and single '_', a letter first" +
           (nearest.empty() ? "" : ", as in '" + nearest + "'");
  if (name == "null") return "its last part names the package: found 'null', which is no name in YAML";
  std::error_code error;
  if (fs::is_directory(find_share().interfaces / name, error) || own_packages().contains(name))
    return "its last part names the package: '" + name + "' comes with cxlab, expected a name of its own";
  return {};
}

void replace_all(std::string& text, std::string_view from, std::string_view to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
}

/// Copies a file of the template `my_<kind>`, which becomes `name`.
Status copy_file(const fs::path& from, const fs::path& to, const std::string& kind, const std::string& name) {
  auto text = read_file(from);
  if (!text) return text.error();
  replace_all(*text, "{scenarios}", find_share().scenarios.string());
  replace_all(*text, "my_" + kind, name);
  replace_all(*text, cx::camel_case("my_" + kind), cx::camel_case(name));
  return write_file(to, *text);
}

}  // namespace

Status make_package(const std::string& kind, const std::string& variant, const std::string& folder) {
  fs::path path = fs::absolute(folder).lexically_normal();
  if (!path.has_filename()) path = path.parent_path();  // "DIR/"
  const std::string name = path.filename().string();
  if (const std::string why = objection(name); !why.empty()) return usage_error(why, folder);
  std::error_code error;
  if (fs::exists(path, error) && !(fs::is_directory(path, error) && fs::is_empty(path, error)))
    return usage_error("is there already and not an empty folder", folder);
  const fs::path origin = find_share().docs / "templates" / (variant.empty() ? kind : kind + '_' + variant);
  if (!fs::is_directory(origin, error)) return resource_error("the files to begin from are missing", origin.string());
  fs::create_directories(path, error);
  if (error) return resource_error(error.message(), folder);
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(origin)) {
    const fs::path to = path / entry.path().lexically_relative(origin);
    if (entry.is_directory())
      fs::create_directories(to, error);
    else if (Status s = copy_file(entry.path(), to, kind, name); !s)
      return s.error();
  }
  return {};
}

}  // namespace cxlab::lab
