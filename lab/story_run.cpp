#include "lab/story_run.h"

#include <algorithm>
#include <cctype>
#include <utility>

#include "cx/base/file.h"
#include "cx/journal/file_store.h"
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

/// Says of which story a folder keeps a run: FILE::NAME.
constexpr const char* kMark = "story/of.txt";

story::Config world_of(const testing::StorySpec& story) {
  return {fs::absolute(story.file).lexically_normal().string(), story.name, story.line};
}

std::string mark_of(const testing::StorySpec& story) {
  return fs::absolute(story.file).lexically_normal().string() + "::" + story.name + '\n';
}

bool has_mark(const fs::path& folder, const std::string& mark) {
  if (!is_file(folder / kMark)) return false;
  const auto text = read_file(folder / kMark);
  return text && *text == mark;
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
  scenario.tick = scenario.physics_step = story.tick;
  scenario.duration = std::max(testing::end_of(story), story.tick);
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

std::string run_name(const testing::StorySpec& story) {
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

Expected<fs::path> folder_for(const testing::StorySpec& story, bool alone, const fs::path& runs) {
  constexpr std::size_t kDigits = 8;
  const std::string name = run_name(story), mark = mark_of(story);
  fs::path folder = runs / name, other = runs / (name + '-' + content_hash(mark).substr(0, kDigits));
  if (!alone || (path_exists(folder) && !has_mark(folder, mark))) std::swap(folder, other);
  if (path_exists(folder) && !has_mark(folder, mark))
    return usage_error("the folder is there, and holds no run of this story; remove it", folder.string());
  if (std::error_code error; has_mark(other, mark)) fs::remove_all(other, error);
  if (Status s = make_folder((folder / kMark).parent_path()); !s) return s.error();
  if (Status s = replace_file(folder / kMark, mark); !s) return s.error();
  return folder;
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
