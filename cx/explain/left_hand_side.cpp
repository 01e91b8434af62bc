#include "cx/explain/left_hand_side.h"

#include <optional>

namespace cxlab::explain {

namespace {

using Kind = Condition::Kind;

std::optional<Kind> kind_of(std::string_view head) {
  if (head == "test") return Kind::kTest;
  if (head == "and" || head == "logical") return Kind::kAnd;
  if (head == "or") return Kind::kOr;
  if (head == "not") return Kind::kNot;
  if (head == "exists") return Kind::kExists;
  if (head == "forall") return Kind::kForall;
  return std::nullopt;
}

/// Reads conditions one after the other; `file` is that of the rule.
Expected<std::vector<Condition>> read(std::span<const Term> terms, const std::string& file) {
  std::vector<Condition> conditions;
  std::string fact_variable;
  std::size_t variable_begins = 0;
  for (std::size_t i = 0; i < terms.size() && !terms[i].is("=>"); ++i) {
    const Term& term = terms[i];
    if (!term.is_list()) {
      if (i + 1 < terms.size() && terms[i + 1].is("<-") && term.text.starts_with('?')) {
        fact_variable = term.text.substr(1);
        variable_begins = term.begin;
      }
      continue;  // the arrow, or the comment of the rule
    }
    if (term.head() == "declare") continue;
    Condition& condition = conditions.emplace_back();
    condition.text = (fact_variable.empty() ? "" : "?" + fact_variable + " <- ") + term.print();
    condition.line = term.line;
    condition.begin = fact_variable.empty() ? term.begin : variable_begins;
    condition.end = term.end;
    condition.fact_variable = std::exchange(fact_variable, {});
    const auto kind = kind_of(term.head());
    condition.kind = kind.value_or(Kind::kPattern);
    if (!kind) {
      auto pattern = Pattern::parse(term, file);
      if (!pattern) return pattern.error();
      condition.pattern = *std::move(pattern);
    } else if (kind == Kind::kTest) {
      if (term.items.size() == 2) condition.expression = term.items[1];
    } else {
      auto parts = read(std::span(term.items).subspan(1), file);
      if (!parts) return parts.error();
      condition.parts = *std::move(parts);
    }
  }
  return conditions;
}

}  // namespace

Expected<std::vector<Condition>> conditions_of(const std::string& defrule, const std::string& file, int line) {
  const FormReading reading = read_forms(defrule, file);
  if (!reading.errors.empty()) return reading.errors.front();
  if (reading.forms.empty() || reading.forms.front().head != "defrule")
    return input_error("expected a defrule", file, line);
  Form form = reading.forms.front();
  form.line = line;
  const Term rule = tree_of(form);
  return read(std::span(rule.items).subspan(std::min<std::size_t>(2, rule.items.size())), file);
}

}  // namespace cxlab::explain
