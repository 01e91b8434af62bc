// cxlab new: folders that run, to begin from.

#include <cstdio>
#include <fstream>

#include "app/command.h"
#include "cx/journal/file_store.h"
#include "scenarios/share.h"

namespace cxlab::app {

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

/// "my_plugin": "MyPlugin".
std::string camel_case(std::string_view name) {
  std::string camel;
  bool first = true;
  for (const char c : name) {
    if (c != '_') camel += first && is_letter(c) ? static_cast<char>(c - 'a' + 'A') : c;
    first = c == '_';
  }
  return camel;
}

void replace_all(std::string& text, std::string_view from, std::string_view to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
}

/// Copies a file of the template `my_<kind>`, which becomes `name`.
Status copy_file(const fs::path& from, const fs::path& to, const std::string& kind, const std::string& name) {
  auto text = read_file(from);
  if (!text) return text.error();
  replace_all(*text, "my_" + kind, name);
  replace_all(*text, camel_case("my_" + kind), camel_case(name));
  std::ofstream out(to, std::ios::binary);
  out << *text;
  out.close();
  if (!out) return resource_error("cannot write this file", to.string());
  return {};
}

int copy_template(const std::string& kind, const std::string& folder, const std::string& next) {
  fs::path path = fs::absolute(folder).lexically_normal();
  if (!path.has_filename()) path = path.parent_path();  // "DIR/"
  const std::string name = path.filename().string();
  if (const std::string why = objection(name); !why.empty()) return fail(usage_error(why, folder));
  std::error_code error;
  if (fs::exists(path, error) && !(fs::is_directory(path, error) && fs::is_empty(path, error)))
    return fail(usage_error("is there already and not an empty folder", folder));
  const fs::path origin = find_share().docs / "templates" / kind;
  if (!fs::is_directory(origin, error))
    return fail(resource_error("the files to begin from are missing", origin.string()));
  fs::create_directories(path, error);
  if (error) return fail(resource_error(error.message(), folder));
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(origin)) {
    const fs::path to = path / entry.path().lexically_relative(origin);
    if (entry.is_directory())
      fs::create_directories(to, error);
    else if (Status s = copy_file(entry.path(), to, kind, name); !s)
      return fail(s.error());
  }
  std::printf("%s\n", folder.c_str());
  std::fprintf(stderr, "next: cd %s; %s (README.md tells more)\n", folder.c_str(), next.c_str());
  return 0;
}

void add_kind(CLI::App& command, Action& action, const char* kind, const char* what, const std::string& next) {
  auto folder = std::make_shared<std::string>();
  CLI::App* sub = command.add_subcommand(kind, what);
  sub->footer(std::string("Example:\n  cxlab new ") + kind + " my_" + kind);
  sub->add_option("folder", *folder, "Where; must be new or empty. Its last part is the name of the package")
      ->required();
  sub->callback([=, &action] { action = [=] { return copy_template(kind, *folder, next); }; });
}

}  // namespace

void add_new(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand("new", "Makes files to begin from");
  command->require_subcommand(1);
  add_kind(*command, action, "agent", "An agent with configuration, rules, stories and scenario",
           "cxlab test; cxlab run scenario.yaml");
  const fs::path installed = find_share().prefix;
  const std::string prefix = installed.empty() ? "PREFIX (docs/install.md)" : installed.string();
  add_kind(*command, action, "plugin",
           "A plugin in C++ with its own messages, configuration, rules and a test, built outside of cxlab",
           "cmake -B build -D CMAKE_PREFIX_PATH=" + prefix + "; cmake --build build; ctest --test-dir build");
}

}  // namespace cxlab::app
