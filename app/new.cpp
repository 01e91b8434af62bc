// cxlab new: folders that run, to begin from.

#include <cstdio>

#include "app/command.h"
#include "lab/new_package.h"
#include "scenarios/share.h"

namespace cxlab::app {

namespace {

int make(const std::string& kind, const std::string& variant, const std::string& folder, const std::string& next) {
  if (Status s = lab::make_package(kind, variant, folder); !s) return fail(s.error());
  std::printf("%s\n", folder.c_str());
  std::fprintf(stderr, "next: cd %s; %s (README.md says more)\n", folder.c_str(), next.c_str());
  return 0;
}

struct Kind {
  const char *word, *what;
  std::string next;  ///< commands that a person may try in the folder
};

CLI::App* add_kind(CLI::App& command, Action& action, const Kind& kind, std::shared_ptr<bool> league) {
  auto folder = std::make_shared<std::string>();
  CLI::App* sub = command.add_subcommand(kind.word, kind.what);
  sub->footer(std::string("Example:\n  cxlab new ") + kind.word + " my_" + kind.word);
  sub->add_option("folder", *folder, "Where; must be new or empty. Its last part is the name of the package")
      ->required()
      ->check([](const std::string& text) { return text.empty() ? "found '', expected a folder" : ""; });
  sub->callback([=, &action] { action = [=] { return make(kind.word, *league ? "rcll" : "", *folder, kind.next); }; });
  return sub;
}

}  // namespace

void add_new(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand("new", "Makes files to begin from");
  command->require_subcommand(1);
  auto league = std::make_shared<bool>(false);
  const Kind agent{"agent", "An agent with configuration, rules, stories and scenario",
                   "cxlab test; cxlab run scenario.yaml"};
  add_kind(*command, action, agent, league)
      ->add_flag("--rcll", *league, "One that plays the Logistics League: one robot, C0 orders");
  const std::filesystem::path installed = find_share().prefix;
  const std::string prefix = installed.empty() ? "PREFIX (docs/install.md)" : installed.string();
  const Kind plugin{"plugin",
                    "A plugin in C++ with its own messages, configuration, rules and a test, built outside of cxlab",
                    "cmake -B build -D CMAKE_PREFIX_PATH=" + prefix + "; cmake --build build; ctest --test-dir build"};
  add_kind(*command, action, plugin, league);
}

}  // namespace cxlab::app
