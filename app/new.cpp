// cxlab new: folders that run, to begin from; games.

#include <cstdio>
#include <filesystem>
#include <optional>

#include "app/activity.h"
#include "app/arguments.h"
#include "app/command.h"
#include "app/console.h"
#include "cx/base/file.h"
#include "cx/base/number_text.h"
#include "cx/journal/run_folder.h"
#include "lab/new_package.h"
#include "lab/story_of_moment.h"
#include "scenarios/rcll/world.h"
#include "scenarios/share.h"

namespace cxlab::app {

namespace {

int make(const lab::NewPackage& package, const std::string& folder, const std::string& next) {
  if (Status s = lab::make_package(package, folder); !s) return fail(s.error());
  std::printf("%s\n", folder.c_str());
  std::fprintf(stderr, "next: cd %s; %s (README.md says more)\n", folder.c_str(), next.c_str());
  if (!package.continuous) return 0;
  const auto& [address, sha256] = *package.continuous;
  const char* const page = "(docs/how-to/test-in-ci.md)";
  if (address.empty())
    std::fprintf(stderr,
                 "note: ci/cxlab.txt does not say yet where the pipelines get cxlab: write the address and the SHA-256 "
                 "of a tarball into it %s\n",
                 page);
  else if (!address.starts_with("https://") && !address.starts_with("http://"))
    std::fprintf(stderr,
                 "note: ci/cxlab.txt names the file %s: the pipelines find it only if it is in the repository; name it "
                 "from the folder of the package, or write an address https://... %s\n",
                 address.c_str(), page);
  if (!address.empty() && sha256.empty())
    std::fprintf(stderr,
                 "note: ci/cxlab.txt has no SHA-256 yet, and the pipelines refuse the tarball without it: write what "
                 "sha256sum prints for the tarball %s\n",
                 page);
  return 0;
}

struct GameOptions {
  std::string file, scenario;
  std::optional<std::uint64_t> seed;
  std::vector<std::string> overrides;
  bool force = false;
};

Expected<Scenario> scenario_of(const GameOptions& options) {
  std::vector<Override> overrides(options.overrides.begin(), options.overrides.end());
  if (options.seed) overrides.emplace_back("seed=" + std::to_string(*options.seed), "--seed");
  if (options.scenario.empty())
    return Scenario::parse("schema: 1\nworld: {kind: rcll}\n", "game", catalogue(), overrides);
  const auto file = find_scenario(options.scenario);
  if (!file) return file.error();
  return Scenario::load(*file, catalogue(), overrides);
}

int make_game(const GameOptions& options) {
  auto scenario = scenario_of(options);
  if (!scenario) return fail(scenario.error());
  if (scenario->world.kind != &rcll::kWorld)
    return fail(
        input_error("world.kind: " + found_text(std::string(scenario->world.kind->name), "rcll"),
                    options.scenario.empty() ? Origin{} : Origin{options.scenario, scenario->world.origin.line}));
  if (path_exists(options.file) && !options.force)
    return fail(usage_error("there is a file already: choose another one, or --force", options.file));
  const auto game = rcll::game_of(*scenario);
  if (!game) return fail(game.error());
  if (Status s = write_output(options.file, to_yaml(*game)); !s) return fail(s.error());
  std::printf("%s\n", options.file.c_str());
  std::fprintf(stderr, "next: cxlab run rcll/game --set world.game=%s --seed %llu\n", options.file.c_str(),
               static_cast<unsigned long long>(scenario->seed));
  return 0;
}

struct StoryOptions {
  std::string run, environment, name, file;
  double at = 0, seconds = 10;
  std::vector<std::string> packages, prefixes;
  bool trust_programs = false, force = false;
};

int make_story(StoryOptions options) {
  auto run = lab::Run::open(options.run, catalogue(), options.trust_programs);
  if (!run) return fail(run.error());
  if (options.file.empty()) {
    const auto folder = std::filesystem::absolute(options.run).lexically_normal();
    const std::string name = (folder.has_filename() ? folder : folder.parent_path()).filename().string();
    options.file = name + "-at-" + general_text(options.at, 9) + ".story.yaml";
  }
  if (!options.file.ends_with(lab::kStoryEnding))
    return fail(usage_error("--out: " + found_text(options.file,
                                                   "a name that ends with .story.yaml, by which `cxlab "
                                                   "test FOLDER` finds it")));
  if (path_exists(options.file) && !options.force)
    return fail(usage_error("there is a file already: choose another one (--out), or --force", options.file));
  const auto named = lab::named_packages(options.packages);
  if (!named) return fail(named.error());
  auto installed = lab::installed_packages(options.prefixes);
  if (!installed) return fail(installed.error());
  Console console(true);
  const lab::Host host = console.host();
  const lab::MomentStory moment{from_seconds(options.at), options.seconds, options.environment, options.name, *named};
  doing("playing the rules of " + options.run + " again");
  auto story = lab::story_of(*run, moment, options.file, host);
  if (const int code = interrupted("no story was written")) return code;
  if (!story) return fail(story.error());
  if (Status s = make_folder_of(options.file); !s) return fail(s.error());
  lab::StoryPlan plan;
  plan.setup = {find_share().interfaces, false, *std::move(installed), host.limits(), own_packages()};
  const Status kept = lab::keep_what_holds(*story, options.file, plan, host);
  std::error_code ignored;
  if (!kept || signal_that_came() != 0) std::filesystem::remove(options.file, ignored);
  if (const int code = interrupted("no story was written")) return code;
  if (!kept) return fail(kept.error());
  for (const std::string& note : story->notes) std::fprintf(stderr, "note: %s\n", printable(note).c_str());
  std::printf("%s\n", options.file.c_str());
  std::fprintf(stderr, "it expects %d thing%s and passes now; next: cxlab test %s\n", story->expectations,
               story->expectations == 1 ? "" : "s", options.file.c_str());
  return 0;
}

void add_story(CLI::App& command, Action& action) {
  auto options = std::make_shared<StoryOptions>();
  CLI::App* sub =
      command.add_subcommand("story", "Write a story from a moment of a recorded run (docs/reference/stories.md)");
  sub->footer(
      "The story has the facts of that moment, and the answers of skills and the messages of the seconds after it.\n"
      "It expects what the agent did: goals, messages, firings, facts. It passes with the rules of the run.\n"
      "Exit code 1: nothing that a story can expect happened then.\n"
      "Examples:\n  cxlab new story runs/game-1 --at 312.4 --out stories/deliver.story.yaml\n"
      "  cxlab new story runs/game-1 --at 5:12 --for 30 --name 'the second order is delivered'");
  add_limit_options(*sub);
  sub->add_option("run", options->run, "Folder of the run")->required();
  time_option(sub->add_option("--at", options->at, "Time: 312.4, 5:12 or 5:12.4"))->required();
  sub->add_option("--for", options->seconds, "Seconds of the story after that time (default 10)")->check(positive());
  sub->add_option("--env", options->environment, "The environment, if the run has several");
  sub->add_option("--name", options->name, "Name of the story (default: run and time)");
  sub->add_option("--out", options->file, "The file (default: RUN-at-T.story.yaml in this folder)");
  once_each(sub->add_option("--package", options->packages, "NAME=DIR: where a package of the run is now"));
  add_prefix_option(*sub, options->prefixes);
  add_trust_programs(*sub, options->trust_programs);
  sub->add_flag("--force", options->force, "Overwrites a file");
  sub->callback([options, &action] { action = [options] { return make_story(*options); }; });
}

void add_game(CLI::App& command, Action& action) {
  auto options = std::make_shared<GameOptions>();
  CLI::App* sub =
      command.add_subcommand("game", "Write a game of the Logistics League: layout, ring prices, orders, down periods");
  sub->footer(
      "Examples:\n  cxlab new game game.yaml --seed 7\n  cxlab new game game.yaml --set world.complexities=[C0,C1]\n"
      "  cxlab run rcll/game --set world.game=game.yaml");
  sub->add_option("file", options->file, "The file (YAML; docs/reference/game-files.md has its keys)")->required();
  sub->add_option("--scenario", options->scenario,
                  "Scenario whose settings the game is drawn with (default: those of the league)");
  seed_number(sub->add_option("--seed", options->seed, "Seed of the draw, instead of the scenario's"));
  once_each(sub->add_option("--set", options->overrides, "Changes a value: a.b[0].c=VALUE (may be given often)"));
  sub->add_flag("--force", options->force, "Overwrites a file");
  sub->callback([options, &action] { action = [options] { return make_game(*options); }; });
}

struct Kind {
  const char *word, *what;
  std::string next;  ///< commands that a person may try in the folder
};

CLI::App* add_kind(CLI::App& command, Action& action, const Kind& kind, std::shared_ptr<lab::NewPackage> package) {
  auto folder = std::make_shared<std::string>();
  CLI::App* sub = command.add_subcommand(kind.word, kind.what);
  sub->footer(std::string("Example:\n  cxlab new ") + kind.word + " my_" + kind.word);
  sub->add_option("folder", *folder, "The folder, new or empty. Its last part is the name of the package")
      ->required()
      ->check([](const std::string& text) { return text.empty() ? found_text("", "a folder") : ""; });
  sub->callback([=, &action] { action = [=] { return make(*package, *folder, kind.next); }; });
  return sub;
}

void add_agent(CLI::App& command, Action& action) {
  auto package = std::make_shared<lab::NewPackage>("agent");
  CLI::App* sub = add_kind(command, action,
                           {"agent", "Write an agent with configuration, rules, stories and scenario",
                            "cxlab test; cxlab run scenario.yaml"},
                           package);
  sub->footer(
      "With --ci the folder also has pipelines for GitHub Actions (.github/workflows/agent.yml) and GitLab\n"
      "(.gitlab-ci.yml). They get cxlab from the place in ci/cxlab.txt, check the rules, and play the stories with\n"
      "coverage. They also play the suite suite.yaml with its requirements, and keep the pages\n"
      "(docs/how-to/test-in-ci.md).\n"
      "Examples:\n  cxlab new agent my_agent\n  cxlab new agent my_agent --rcll --ci\n"
      "  cxlab new agent my_agent --ci --cxlab https://files.example.org/cxlab-0.1.0-debian12-x86_64.tar.gz \\\n"
      "      --sha256 $(sha256sum cxlab-0.1.0-debian12-x86_64.tar.gz | cut -c 1-64)");
  sub->add_flag_callback(
      "--rcll", [package] { package->variant = "rcll"; }, "The agent plays the Logistics League: one robot, C0 orders");
  const auto tarball = [package]() -> lab::NewPackage::Tarball& {
    return package->continuous ? *package->continuous : package->continuous.emplace();
  };
  CLI::Option* ci =
      sub->add_flag_callback("--ci", tarball, "Pipelines for GitHub and GitLab, and a suite with requirements");
  sub->add_option_function<std::string>(
         "--cxlab", [=](const std::string& address) { tarball().address = address; },
         "Where the pipelines get the tarball of cxlab (docs/how-to/install.md)")
      ->needs(ci);
  sub->add_option_function<std::string>(
         "--sha256", [=](const std::string& hash) { tarball().sha256 = hash; }, "The SHA-256 of that tarball")
      ->needs(ci);
}

}  // namespace

void add_new(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand("new", "Makes files to begin from");
  command->require_subcommand(1);
  add_agent(*command, action);
  const std::filesystem::path installed = find_share().prefix;
  const std::string prefix = installed.empty() ? "PREFIX (docs/how-to/install.md)" : installed.string();
  const Kind plugin{
      "plugin", "Write a plugin in C++ with its own messages, configuration, rules and a test, built outside of cxlab",
      "cmake -B build -D CMAKE_PREFIX_PATH=" + prefix + "; cmake --build build; ctest --test-dir build"};
  add_kind(*command, action, plugin, std::make_shared<lab::NewPackage>("plugin"));
  add_game(*command, action);
  add_story(*command, action);
}

}  // namespace cxlab::app
