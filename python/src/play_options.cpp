#include "play_options.h"

#include "bindings.h"
#include "scenarios/share.h"
#include "scenarios/shipped/catalogue.h"

namespace cxlab::python {

Expected<Scenario> scenario_of(const std::string& name, const Assignments& assignments) {
  const auto file = find_scenario(name);
  if (!file) return file.error();
  std::vector<Override> overrides;
  for (const auto& [assignment, option] : assignments) overrides.emplace_back(assignment, option);
  return Scenario::load(*file, shipped(), overrides);
}

lab::PlayOptions play_options(std::optional<double> until, const std::string& journal, const std::string& out,
                              bool force) {
  lab::PlayOptions options;
  options.spec.until = until;
  if (auto level = named(options.spec.journal, kJournalLevels); !level.set(journal))
    raise(usage_error(found_text(journal, "none, decisions or full"), "journal"));
  options.out = out.empty() ? "none" : out;
  options.force = force;
  options.command = {"python"};
  return options;
}

}  // namespace cxlab::python
