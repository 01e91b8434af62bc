// Lists of stimuli.

#include "scenarios/scenario.h"
#include "tests/fuzz/fuzz.h"

namespace fuzz_stimuli {

FUZZ_TARGET(stimuli) {
  using namespace cxlab;
  const auto document = yaml::Document::parse(fuzz::text_of(data, size), "fuzz.yaml");
  if (!document) return 0;
  const auto stimuli = read_stimuli(document->root());
  if (!document->status()) return 0;
  for (std::size_t i = 0; i < stimuli.size(); ++i) {
    fuzz::promise(i == 0 || stimuli[i - 1].at <= stimuli[i].at, "stimuli come in order of time");
    fuzz::promise(stimuli[i].origin.line > 0, "a stimulus knows its line");
  }
  return 0;
}

}  // namespace fuzz_stimuli
