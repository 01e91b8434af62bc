#include "lab/story_run.h"

#include <cctype>

#include "cx/base/file.h"
#include "cx/base/json.h"
#include "cx/journal/run_folder.h"
#include "cx/testing/story_parts.h"
#include "lab/session.h"
#include "scenarios/begin.h"
#include "scenarios/shipped/catalogue.h"
#include "scenarios/story/world.h"

namespace cxlab::lab {

namespace fs = std::filesystem;

namespace {

constexpr const char* kScenario = "story/scenario.yaml";

/// "door-a-bell-opens" of "a bell opens" in door.story.yaml.
std::string folder_name(const testing::StorySpec& story) {
  constexpr std::size_t kLongest = 80;
  const std::string file = fs::path(story.file).filename().string();
  std::string out;
  for (const char c : file.substr(0, file.find('.')) + ' ' + story.name) {
    if (std::isalnum(static_cast<unsigned char>(c)))
      out += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    else if (!out.empty() && out.back() != '-')
      out += '-';
  }
  out.resize(std::min(out.size(), kLongest));
  while (out.ends_with('-')) out.pop_back();
  return out.empty() ? "story" : out;
}

story::Config world_of(const testing::StorySpec& story) {
  return {fs::absolute(story.file).lexically_normal().string(), story.name, story.line};
}

/// Whether the folder is that of a run of this story.
bool is_of(const fs::path& folder, const testing::StorySpec& story) {
  if (!is_file(folder / "manifest.json") || !is_file(folder / kScenario)) return false;
  const auto scenario = Scenario::load(folder / kScenario, shipped());
  if (!scenario || scenario->world.kind != &story::kWorld) return false;
  const auto& world = scenario->world.get<story::Config>();
  return world.file == world_of(story).file && world.story == story.name;
}

Expected<Scenario> scenario_of(const testing::StorySpec& story, const testing::StorySetup& setup,
                               const fs::path& folder) {
  const fs::path file = folder / kScenario;
  if (Status s = make_folder(file.parent_path()); !s) return s.error();
  Scenario scenario;
  scenario.set_world({&story::kWorld, world_of(story)});
  if (story.begins > SimTime::zero()) scenario.sections = {{&kBegin, Begin{story.begins}}};
  scenario.seed = story.seed;
  scenario.epoch = 0;
  scenario.tick = testing::kTick;
  scenario.duration = std::max(testing::end_of(story), testing::kTick);
  std::map<std::string, fs::path> packages = story.packages;
  packages.insert(setup.packages.begin(), setup.packages.end());
  for (const auto& [name, share] : packages)
    scenario.packages[name] = {fs::absolute(share).lexically_normal().string()};
  AgentSpec agent;
  agent.params = story.params;
  if (!story.config.empty()) {
    agent.config = fs::absolute(story.config).lexically_normal().string();
  } else {
    agent.config = "agent.yaml";
    const auto config = testing::config_for_rules(story);
    if (!config) return config.error();
    if (Status s = replace_file(file.parent_path() / agent.config, *config); !s) return s.error();
  }
  scenario.agents = {agent};
  const std::string text = scenario.to_yaml();
  if (Status s = replace_file(file, text); !s) return s.error();
  return Scenario::parse(text, file, shipped());
}

}  // namespace

Expected<fs::path> folder_for(const testing::StorySpec& story, const fs::path& runs) {
  const std::string name = folder_name(story);
  if (is_of(runs / name, story)) return runs / name;
  return make_numbered_folder(runs, name);
}

Status keep_run(const testing::StorySpec& story, const testing::StorySetup& setup, const fs::path& folder) {
  auto scenario = scenario_of(story, setup, folder);
  if (!scenario) return scenario.error();
  PlayOptions options;
  options.spec.journal = JournalLevel::kFull;
  options.out = folder.string();
  options.force = true;
  Host host;
  host.most = setup.limits;
  host.confine = true;
  auto session = Session::load(options, *std::move(scenario), host);
  if (!session) return session.error();
  while (true) {
    const auto step = (*session)->step((*session)->episode().next_tick());
    if (!step || step->over) break;
    (*session)->episode().flush();
  }
  (void)(*session)->close();
  return {};
}

}  // namespace cxlab::lab
