// cxlab new agent: a folder with an agent that runs, to begin from.

#include <cstdio>

#include "app/command.h"
#include "app/share.h"

namespace cxlab::app {

namespace {

namespace fs = std::filesystem;

int new_agent(const std::string& folder) {
  std::error_code error;
  if (fs::exists(folder, error) && !(fs::is_directory(folder, error) && fs::is_empty(folder, error)))
    return fail(Error{ErrorKind::kUsage, "is there already and not an empty folder", folder, 0, {}});
  const fs::path origin = find_share().docs / "templates/agent";
  if (!fs::is_directory(origin, error)) return fail(Error{ErrorKind::kResource, "the files to begin from are missing", origin.string(), 0, {}});
  fs::create_directories(folder, error);
  if (!error) fs::copy(origin, folder, fs::copy_options::recursive, error);
  if (error) return fail(Error{ErrorKind::kResource, error.message(), folder, 0, {}});
  std::printf("%s\n", folder.c_str());
  std::fprintf(stderr, "next: cd %s; cxlab test; cxlab run scenario.yaml (README.md tells more)\n", folder.c_str());
  return 0;
}

}  // namespace

void add_new(CLI::App& app, Action& action) {
  auto folder = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand("new", "Makes files to begin from");
  command->require_subcommand(1);
  CLI::App* agent = command->add_subcommand("agent", "An agent with configuration, rules, stories and scenario");
  agent->footer("Example:\n  cxlab new agent my_agent");
  agent->add_option("folder", *folder, "Where; must be new or empty")->required();
  agent->callback([folder, &action] { action = [folder] { return new_agent(*folder); }; });
}

}  // namespace cxlab::app
