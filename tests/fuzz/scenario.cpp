// YAML and scenarios: the first line is what --set is given, the rest is the file.

#include "scenarios/scenario.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cxlab;
  const std::string text = fuzz::text_of(data, size);
  const std::size_t line = text.find('\n');
  if (line == std::string::npos) return 0;
  std::vector<std::string> overrides;
  if (line > 0) overrides.push_back(text.substr(0, line));
  const auto scenario = Scenario::parse(text.substr(line + 1), "fuzz.yaml", overrides);
  if (!scenario) {
    fuzz::promise(!scenario.error().message.empty(), "an error says what it is");
    return 0;
  }
  fuzz::promise(scenario->tick > SimTime::zero() && scenario->tick % scenario->physics_step == SimTime::zero(),
                "a tick is a whole number of steps");
  for (const AgentSpec& agent : scenario->agents) (void)scenario->shares(agent);
  return 0;
}
