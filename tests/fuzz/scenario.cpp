// YAML and scenarios: the first line is what --set is given, the rest is the file.

#include "scenarios/shipped/catalogue.h"
#include "tests/fuzz/fuzz.h"

namespace fuzz_scenario {

FUZZ_TARGET(scenario) {
  using namespace cxlab;
  const std::string text = fuzz::text_of(data, size);
  const std::size_t line = text.find('\n');
  if (line == std::string::npos) return 0;
  std::vector<Override> overrides;
  if (line > 0) overrides.push_back(text.substr(0, line));
  const auto scenario = Scenario::parse(text.substr(line + 1), "fuzz.yaml", shipped(), overrides);
  if (!scenario) {
    fuzz::promise(!scenario.error().message.empty(), "an error says what it is");
    return 0;
  }
  fuzz::promise(scenario->tick > SimTime::zero() &&
                    (scenario->world.kind->any_tick || scenario->tick % scenario->physics_step == SimTime::zero()),
                "a tick is a whole number of steps");
  for (const AgentSpec& agent : scenario->agents) (void)scenario->shares(agent);
  const std::string copy = scenario->to_yaml();
  const auto again = Scenario::parse(copy, "fuzz.yaml", shipped());
  fuzz::promise(again.ok() && again->to_yaml() == copy, "what is written is read again");
  return 0;
}

}  // namespace fuzz_scenario
