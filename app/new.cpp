// cxlab new: folders that run, to begin from.

#include <cstdio>

#include "app/command.h"
#include "scenarios/share.h"

namespace cxlab::app {

namespace {

namespace fs = std::filesystem;

int copy_template(const std::string& kind, const std::string& folder, const std::string& next) {
  std::error_code error;
  if (fs::exists(folder, error) && !(fs::is_directory(folder, error) && fs::is_empty(folder, error)))
    return fail(Error{ErrorKind::kUsage, "is there already and not an empty folder", folder, 0, {}});
  const fs::path origin = find_share().docs / "templates" / kind;
  if (!fs::is_directory(origin, error)) return fail(Error{ErrorKind::kResource, "the files to begin from are missing", origin.string(), 0, {}});
  fs::create_directories(folder, error);
  if (!error) fs::copy(origin, folder, fs::copy_options::recursive, error);
  if (error) return fail(Error{ErrorKind::kResource, error.message(), folder, 0, {}});
  std::printf("%s\n", folder.c_str());
  std::fprintf(stderr, "next: cd %s; %s (README.md tells more)\n", folder.c_str(), next.c_str());
  return 0;
}

void add_kind(CLI::App& command, Action& action, const char* kind, const char* what, const std::string& next) {
  auto folder = std::make_shared<std::string>();
  CLI::App* sub = command.add_subcommand(kind, what);
  sub->footer(std::string("Example:\n  cxlab new ") + kind + " my_" + kind);
  sub->add_option("folder", *folder, "Where; must be new or empty")->required();
  sub->callback([=, &action] { action = [=] { return copy_template(kind, *folder, next); }; });
}

}  // namespace

void add_new(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand("new", "Makes files to begin from");
  command->require_subcommand(1);
  add_kind(*command, action, "agent", "An agent with configuration, rules, stories and scenario", "cxlab test; cxlab run scenario.yaml");
  const fs::path installed = find_share().prefix;
  const std::string prefix = installed.empty() ? "PREFIX (docs/install.md)" : installed.string();
  add_kind(*command, action, "plugin", "A plugin in C++ with its own messages, configuration, rules and a test, built outside of cxlab",
           "cmake -B build -D CMAKE_PREFIX_PATH=" + prefix + "; cmake --build build; ctest --test-dir build");
}

}  // namespace cxlab::app
