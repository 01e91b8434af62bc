#pragma once
// Answers of an inspector as JSON: those of `--json`, of `cxlab view` and of the control protocol
// (docs/reference/questions.md).

#include <string>
#include <utility>
#include <vector>

#include "cx/base/json.h"
#include "cx/explain/why_not.h"
#include "cx/inspect/inspector.h"
#include "cx/inspect/makers.h"
#include "cx/inspect/users.h"

namespace cxlab::lab {

/// A number, a list, or the text of any other value.
Json to_json(const Value& value);
/// {"VARIABLE": "VALUE"}.
Json to_json(const inspect::Values& values);
/// "FILE:LINE"; null where there is no file.
Json place_json(const std::string& file, int line);

// --- Each answer is an object that is merged into that of its environment
Json facts_json(const std::vector<inspect::FactHistory>& facts);
Json agenda_json(const std::vector<ActivationInfo>& agenda, const std::vector<std::string>& focus);
Json globals_json(const std::vector<std::pair<std::string, Value>>& globals);
Json firings_json(const std::vector<inspect::FiringCopy>& firings);
Json rules_json(const std::vector<inspect::RuleUse>& rules);
Json why_json(const inspect::Derivation& derivation);
/// Which rules wait for a fact, or could make it.
Json future_json(const inspect::FactFuture& future);

Json to_json(const inspect::Makers& makers);
Json to_json(const std::vector<explain::ConditionNow>& conditions);
/// "condition 2: (order (id 3)): there is no fact of order".
std::string to_text(const explain::UnmetCondition& lacks);

}  // namespace cxlab::lab
