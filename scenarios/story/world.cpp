#include "scenarios/story/world.h"

#include <algorithm>

#include "cx/testing/story_parts.h"
#include "scenarios/acting_stage.h"
#include "scenarios/begin.h"

namespace cxlab::story {

namespace {

class StoryStage final : public ActingStage {
 public:
  static Expected<std::unique_ptr<Stage>> create(const StageSetup& setup) {
    const Config& config = setup.scenario.world.get<Config>();
    auto stories = testing::read_stories(setup.scenario.world_files.at("file").path);
    if (!stories) return stories.error();
    std::vector<std::string> names;
    for (testing::StorySpec& spec : *stories) {
      names.push_back(spec.name);
      if (spec.name != config.story || (config.line > 0 && spec.line != config.line)) continue;
      spec.seed = setup.scenario.seed;
      std::unique_ptr<StoryStage> stage(new StoryStage(std::move(spec), setup));
      if (const auto mistakes = testing::set_up(*stage->stand_ins_, stage->spec_); !mistakes.empty())
        return mistakes.front();
      return std::unique_ptr<Stage>(std::move(stage));
    }
    return input_error("story: there is no story '" + config.story + "' in " + config.file +
                       did_you_mean(config.story, names));
  }

 private:
  StoryStage(testing::StorySpec spec, const StageSetup& setup) : spec_(std::move(spec)) {
    auto stand_ins = std::make_unique<testing::StandIns>(setup.bus, setup.sink, spec_.seed, spec_.faults);
    stand_ins_ = stand_ins.get();
    servers.push_back(std::make_unique<testing::StorySteps>(spec_, *stand_ins));
    servers.push_back(std::move(stand_ins));
    control = std::make_unique<testing::StoryFacts>(spec_);
  }

  testing::StorySpec spec_;
  testing::StandIns* stand_ins_ = nullptr;
};

constexpr std::string_view kFiles[]{"file"};
constinit const SectionKind* const kReads[]{&kBegin};

}  // namespace

constinit const WorldKind kWorld{
    .name = "story",
    .what = "stand-ins for skills and services, facts and messages, as a story says (docs/reference/stories.md)",
    .settings = settings_of<Config>(),
    .reads = kReads,
    .files = kFiles,
    .make_stage = StoryStage::create,
};

}  // namespace cxlab::story
