#include "cx/explain/pattern.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "cx/base/number_text.h"

namespace cxlab::explain {

namespace {

using Single = Constraint::Single;

std::string unquoted(std::string_view text) {
  text = text.substr(1, text.size() - (text.size() > 1 && text.ends_with('"') ? 2 : 1));
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\\' && i + 1 < text.size()) ++i;
    out += text[i];
  }
  return out;
}

/// A word or string of CLIPS as a value: `3`, `1.5`, `OPEN`, `"text"`, `[name]`.
Value constant_of(const Term& term) {
  const std::string& text = term.text;
  if (term.kind == Token::Kind::kString) return Value::string(unquoted(text));
  if (text.starts_with('[') && text.ends_with(']')) return Value::instance_name(text.substr(1, text.size() - 2));
  if (text.find_first_not_of("0123456789+-.eE") != text.npos) return Value::symbol(text);
  if (const auto whole = read_number<std::int64_t>(text)) return Value::integer(*whole);
  if (const auto real = read_number<double>(text)) return Value::number(*real);
  return Value::symbol(text);
}

/// Items of a pattern or slot that are constraints, read from the front.
class ConstraintReader {
 public:
  explicit ConstraintReader(std::span<const Term> items) : rest_(items) {}

  bool done() const { return rest_.empty(); }
  Expected<Constraint> next() {
    Constraint constraint;
    bool first = true;
    constraint.any_of.emplace_back();
    while (true) {
      auto single = next_single(constraint);
      if (!single) return single.error();
      const bool another = !done() && rest_.front().kind == Token::Kind::kConnective && !rest_.front().is("~");
      const bool alternative = another && rest_.front().is("|");
      // A variable that comes first holds beside all that follows: ?x&A|B is ?x&(A|B).
      if (first && single->kind == Single::Kind::kVariable && !single->negated && !alternative)
        constraint.variable = single->variable;
      else if (single->kind != Single::Kind::kAny)
        constraint.any_of.back().push_back(*std::move(single));
      first = false;
      if (!another) break;
      if (alternative) constraint.any_of.emplace_back();
      rest_ = rest_.subspan(1);
    }
    if (constraint.any_of.size() == 1 && constraint.any_of.front().empty()) constraint.any_of.clear();
    return constraint;
  }

 private:
  Expected<Single> next_single(Constraint& constraint) {
    Single single;
    for (; !done() && rest_.front().is("~"); rest_ = rest_.subspan(1)) single.negated = !single.negated;
    if (done()) return input_error("expected a value at the end of a pattern");
    const Term& term = rest_.front();
    rest_ = rest_.subspan(1);
    const bool word = term.kind == Token::Kind::kWord;
    if (word && (term.text == ":" || term.text == "=") && !done() && rest_.front().is_list()) {
      single.kind = term.text == ":" ? Single::Kind::kPredicate : Single::Kind::kReturnValue;
      single.expression = rest_.front();
      single.uses = variables_of(single.expression);
      rest_ = rest_.subspan(1);
    } else if (word && (term.text.starts_with('?') || term.text.starts_with("$?"))) {
      const bool many = term.text.starts_with('$');
      constraint.many = constraint.many || many;
      single.variable = term.text.substr(many ? 2 : 1);
      single.kind = single.variable.empty() ? Single::Kind::kAny : Single::Kind::kVariable;
    } else if (word || term.kind == Token::Kind::kString) {
      single.kind = Single::Kind::kConstant;
      single.constant = constant_of(term);
    } else {
      return input_error(found_expected(term.print(), "a value"));
    }
    return single;
  }

  std::span<const Term> rest_;
};

Expected<std::vector<Constraint>> read_constraints(std::span<const Term> items) {
  std::vector<Constraint> constraints;
  ConstraintReader reader(items);
  while (!reader.done()) {
    auto constraint = reader.next();
    if (!constraint) return constraint.error();
    constraints.push_back(*std::move(constraint));
  }
  return constraints;
}

/// As they stand in a list with that head.
std::string print_items(std::span<const Term> items) {
  Term list{Token::Kind::kOpen, {}, {Term{Token::Kind::kWord, "x", {}, 0}}, 0};
  list.items.insert(list.items.end(), items.begin(), items.end());
  const std::string text = list.print();
  return text.size() < 4 ? std::string() : text.substr(3, text.size() - 4);
}

template <class Test>
bool any_single(const Constraint& constraint, const Test& test) {
  return std::ranges::any_of(constraint.any_of,
                             [&](const auto& together) { return std::ranges::any_of(together, test); });
}
bool has_expression(const Constraint& constraint) {
  return any_single(constraint, [](const Single& single) {
    return single.kind == Single::Kind::kPredicate || single.kind == Single::Kind::kReturnValue;
  });
}
bool only_constants(const Constraint& constraint) {
  return !any_single(constraint, [](const Single& single) { return single.kind != Single::Kind::kConstant; });
}

/// Variables that constraints name, each once.
void add_variables(const std::vector<Constraint>& constraints, std::vector<std::string>& names) {
  const auto add = [&](const std::string& name) {
    if (!name.empty() && std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  };
  for (const Constraint& constraint : constraints) {
    add(constraint.variable);
    for (const auto& together : constraint.any_of)
      for (const Single& single : together) {
        add(single.variable);
        for (const std::string& name : single.uses) add(name);
      }
  }
}

/// The globals that expressions of the constraints name, each once.
std::vector<std::string> globals_in(const std::vector<Constraint>& constraints) {
  std::vector<std::string> names;
  for (const Constraint& constraint : constraints)
    for (const auto& together : constraint.any_of)
      for (const Single& single : together)
        for (std::string& name : explain::globals_of(single.expression))
          if (std::ranges::count(names, name) == 0) names.push_back(std::move(name));
  return names;
}

std::span<const Value> values_of(const Value& slot) {
  return slot.is(ValueType::kMultifield) ? std::span<const Value>(slot.items()) : std::span<const Value>(&slot, 1);
}

std::string print_values(const Value& slot) {
  std::string out;
  for (const Value& value : values_of(slot)) out += (out.empty() ? "" : " ") + value.print();
  return out;
}

}  // namespace

// --- Parsing

Expected<Pattern> Pattern::parse(const Term& term, const std::string& file) {
  const auto bad = [&](const std::string& what) { return input_error(what, file, term.line); };
  if (!term.is_list() || term.head().empty()) return bad("expected the name of a deftemplate first");
  Pattern pattern;
  pattern.template_name_ = term.head();
  if (const auto colons = pattern.template_name_.find("::"); colons != std::string::npos) {
    pattern.module_ = pattern.template_name_.substr(0, colons);
    pattern.template_name_.erase(0, colons + 2);
  }
  const std::span<const Term> items = std::span(term.items).subspan(1);
  const bool slots = !items.empty() && items.front().is_list();
  if (!slots) {
    auto constraints = read_constraints(items);
    if (!constraints) return bad(constraints.error().message);
    pattern.ordered_ = *std::move(constraints);
    pattern.ordered_text_ = print_items(items);
    return pattern;
  }
  for (const Term& item : items) {
    if (!item.is_list()) return bad("values between slots");
    if (item.head().empty()) return bad("expected the name of a slot");
    const std::span<const Term> values = std::span(item.items).subspan(1);
    auto constraints = read_constraints(values);
    if (!constraints) return bad(constraints.error().message);
    pattern.slots_.push_back({std::string(item.head()), *std::move(constraints), print_items(values)});
  }
  return pattern;
}

Expected<Pattern> Pattern::parse_plain(const std::string& text, const std::string& file, int line) {
  const auto bad = [&](const std::string& what) {
    return input_error("fact pattern " + text + ": " + what, file, line);
  };
  const FormReading reading = read_forms(text, file);
  if (!reading.errors.empty()) return bad(reading.errors.front().message);
  if (reading.forms.size() != 1 || !reading.forms[0].list) return bad("expected one pattern in parentheses");
  for (const Token& token : tokens_of(reading.forms[0]))
    if (token.kind == Token::Kind::kConnective)
      return bad("&, | and ~ are not understood here: " +
                 found_expected("one of them", "a value, or ? for any; ask once for each value"));
  const Term term = tree_of(reading.forms[0]);
  for (const Term& slot : term.items)
    for (const Term& value : slot.items)
      if (value.is_list()) return bad("a slot holds words, numbers, strings and ? only");
  if (term.items.size() < 2 && term.head().empty()) return bad("expected the name of a deftemplate first");
  auto pattern = parse(term, file);
  if (!pattern) return bad(pattern.error().message);
  pattern->loose_numbers_ = true;
  return pattern;
}

std::vector<std::string> Pattern::slot_names() const {
  std::vector<std::string> names;
  for (const Slot& slot : slots_) names.push_back(slot.name);
  return names;
}

std::size_t Pattern::count_in(const std::string& slot) const {
  return std::ranges::find(slots_, slot, &Slot::name)->constraints.size();
}

std::vector<std::pair<std::string, Value>> Pattern::constants() const {
  std::vector<std::pair<std::string, Value>> out;
  const auto add = [&out](const std::string& slot, const std::vector<Constraint>& constraints) {
    for (const Constraint& constraint : constraints)
      for (const auto& together : constraint.any_of)
        for (const Constraint::Single& single : together)
          if (single.kind == Constraint::Single::Kind::kConstant && !single.negated)
            out.emplace_back(slot, single.constant);
  };
  for (const Slot& slot : slots_) add(slot.name, slot.constraints);
  add("implied", ordered_);
  return out;
}

std::vector<std::string> Pattern::binds() const {
  std::vector<std::string> names;
  const auto add = [&](const std::vector<Constraint>& constraints) {
    for (const Constraint& constraint : constraints)
      if (!constraint.variable.empty() && std::ranges::count(names, constraint.variable) == 0)
        names.push_back(constraint.variable);
  };
  add(ordered_);
  for (const Slot& slot : slots_) add(slot.constraints);
  return names;
}

std::string Mismatch::print() const {
  if (!has_slot) return "there is no slot " + slot;
  const auto shown = [](const std::string& values) { return values.empty() ? "empty" : values; };
  return (slot == "implied" ? "its fields are " : slot + " is ") + shown(found) + ", not " + shown(expected);
}

std::string print(const std::vector<Mismatch>& mismatches) {
  std::string out;
  for (const Mismatch& mismatch : mismatches) out += (out.empty() ? "" : ", and ") + mismatch.print();
  return out;
}

// --- Matching

/// One way after the other in which values fulfil constraints. What needs variables that come later is checked last.
class Pattern::Matching {
 public:
  Matching(const Pattern& pattern, Bindings& bindings, Evaluator* evaluator, const std::function<bool()>& found)
      : pattern_(pattern), bindings_(bindings), evaluator_(evaluator), found_(found) {}

  bool all_slots(const FactCopy& fact, std::size_t slot) {
    if (const Value* implied = fact.slot("implied"))
      return pattern_.slots_.empty() && fields(pattern_.ordered_, values_of(*implied), [&] { return end(); });
    if (slot == pattern_.slots_.size()) return pattern_.ordered_.empty() && end();
    return one_slot(fact, pattern_.slots_[slot], [&] { return all_slots(fact, slot + 1); });
  }
  bool one_slot(const FactCopy& fact, const Slot& slot, const std::function<bool()>& then) {
    const Value* value = fact.slot(slot.name);
    if (!fact.classes.empty() && slot.name == "is-a")
      return slot.constraints.size() == 1 && one(slot.constraints.front(), *value, then, fact.classes);
    return value && fields(slot.constraints, values_of(*value), then);
  }
  bool fields(std::span<const Constraint> constraints, std::span<const Value> values,
              const std::function<bool()>& then) {
    if (constraints.empty()) return values.empty() && then();
    const Constraint& first = constraints.front();
    const auto rest = constraints.subspan(1);
    if (!first.many)
      return !values.empty() && one(first, values.front(), [&] { return fields(rest, values.subspan(1), then); });
    for (std::size_t size = 0; size <= values.size(); ++size) {
      const Value part = Value::multifield({values.begin(), values.begin() + static_cast<std::ptrdiff_t>(size)});
      if (one(first, part, [&] { return fields(rest, values.subspan(size), then); })) return true;
    }
    return false;
  }
  /// Checks the postponed constraints, then asks the caller.
  bool end() {
    for (const Later& later : later_)
      if (!holds(*later.constraint, later.value, *later.classes)) return false;
    return found_();
  }

 private:
  using Classes = std::vector<std::string>;
  inline static const Classes kNoClasses;
  struct Later {
    const Constraint* constraint;
    Value value;
    const Classes* classes;
  };

  /// `classes`: where the value is a class, that one and those that it inherits from.
  bool one(const Constraint& constraint, const Value& value, const std::function<bool()>& then,
           const Classes& classes = kNoClasses) {
    const std::size_t bound = bindings_.size();
    if (!constraint.variable.empty()) {
      if (const Value* known = bindings_.find(constraint.variable)) {
        if (!(*known == value)) return false;
      } else if (!bindings_.bind(constraint.variable, value)) {
        return false;
      }
    }
    bool done = false;
    if (only_constants(constraint)) {
      done = holds(constraint, value, classes) && then();
    } else {
      later_.push_back({&constraint, value, &classes});
      done = then();
      later_.pop_back();
    }
    bindings_.forget_beyond(bound);
    return done;
  }
  bool holds(const Constraint& constraint, const Value& value, const Classes& classes) {
    const auto& any = constraint.any_of;
    return any.empty() || std::any_of(any.begin(), any.end(), [&](const auto& together) {
             return std::all_of(together.begin(), together.end(),
                                [&](const Single& s) { return holds(s, value, classes); });
           });
  }
  bool holds(const Single& single, const Value& value, const Classes& classes) {
    switch (single.kind) {
      case Single::Kind::kAny: return true;
      case Single::Kind::kConstant:
        if (!classes.empty()) return (std::ranges::count(classes, single.constant.text()) > 0) != single.negated;
        return same(single.constant, value) != single.negated;
      case Single::Kind::kVariable: {
        const Value* known = bindings_.find(single.variable);
        return !known || (*known == value) != single.negated;
      }
      case Single::Kind::kPredicate:
      case Single::Kind::kReturnValue: break;
    }
    const auto unbound = [&](const std::string& name) { return bindings_.find(name) == nullptr; };
    if (!evaluator_ || std::any_of(single.uses.begin(), single.uses.end(), unbound)) return true;
    const auto result = evaluator_->value(single.expression, bindings_);
    if (!result) return false;
    const bool true_here = single.kind == Single::Kind::kPredicate ? result->is_true() : *result == value;
    return true_here != single.negated;
  }
  bool same(const Value& constant, const Value& value) const {
    if (constant == value) return true;
    if (!pattern_.loose_numbers_ || !constant.is_number() || !value.is_number()) return false;
    const double a = constant.as_number(), b = value.as_number();
    if (a == b) return true;
    // A value that was copied from a fact has the digits that CLIPS prints.
    return value.is(ValueType::kFloat) && std::abs(a - b) <= 1e-14 * std::abs(a) && print_float(a) == print_float(b);
  }

  const Pattern& pattern_;
  Bindings& bindings_;
  Evaluator* evaluator_;
  const std::function<bool()>& found_;
  std::vector<Later> later_;
};

bool Pattern::match(const FactCopy& fact, Bindings& bindings, Evaluator* evaluator,
                    const std::function<bool()>& found) const {
  // The module of a fact that the journal tells is not known.
  const bool of_other_module = !module_.empty() && !fact.module.empty() && fact.module != module_;
  if (fact.template_name != template_name_ || of_other_module) return false;
  return Matching(*this, bindings, evaluator, found).all_slots(fact, 0);
}

bool Pattern::matches(const FactCopy& fact, Evaluator* evaluator) const {
  Bindings bindings;
  return match(fact, bindings, evaluator, [] { return true; });
}

std::vector<Mismatch> Pattern::mismatches(const FactCopy& fact, const Bindings& bindings, Evaluator* evaluator) const {
  Bindings bound = bindings;
  const auto expected = [&](const std::vector<Constraint>& constraints, const std::string& text) {
    std::string out = text;
    std::vector<std::string> names;
    add_variables(constraints, names);
    const char* before = " with ";
    for (const std::string& name : names)
      if (const std::string value = bindings.print(name); !value.empty()) {
        out += before + ('?' + name) + " = " + value;
        before = ", ";
      }
    for (const std::string& name : globals_in(constraints))
      if (const auto value = evaluator ? evaluator->global(name) : Expected<Value>(input_error("unknown"))) {
        out += before + ('?' + name) + " = " + value->print();
        before = ", ";
      }
    return out;
  };
  if (const Value* implied = fact.slot("implied")) {
    if (match(fact, bound, evaluator, [] { return true; })) return {};
    return {{"implied", print_values(*implied), expected(ordered_, ordered_text_)}};
  }
  std::vector<const Slot*> order;
  for (const Slot& slot : slots_) order.push_back(&slot);
  // Slots with expressions come last: they may use variables that other slots bind.
  std::stable_partition(order.begin(), order.end(), [](const Slot* slot) {
    return std::none_of(slot->constraints.begin(), slot->constraints.end(), has_expression);
  });
  std::vector<const Slot*> failed;
  for (const Slot* slot : order) {
    std::optional<Bindings> extended;
    const std::function<bool()> keep = [&] {
      extended = bound;
      return true;
    };
    Matching matching(*this, bound, evaluator, keep);
    matching.one_slot(fact, *slot, [&] { return matching.end(); });
    if (extended)
      bound = *std::move(extended);
    else
      failed.push_back(slot);
  }
  std::sort(failed.begin(), failed.end());  // in the order of the pattern
  std::vector<Mismatch> out;
  for (const Slot* slot : failed) {
    const Value* value = fact.slot(slot->name);
    out.push_back(
        {slot->name, value ? print_values(*value) : "", expected(slot->constraints, slot->text), value != nullptr});
  }
  return out;
}

namespace {

/// Words that a person may have misspelt as one another.
std::ptrdiff_t near_words(const std::vector<Mismatch>& mismatches) {
  return std::ranges::count_if(mismatches, [](const Mismatch& mismatch) {
    const std::string expected = mismatch.expected.substr(0, mismatch.expected.find(' '));
    return !nearest_word(expected, {mismatch.found}).empty();
  });
}

/// Slots in which the fact is about something else: conditions before, or what is asked for, say what it should be.
std::ptrdiff_t others(const std::vector<Mismatch>& mismatches) {
  return std::ranges::count_if(mismatches, [](const Mismatch& mismatch) {
    const std::string expected = mismatch.expected.substr(0, mismatch.expected.find(' '));
    return expected.starts_with('?') && expected.find_first_of("&|:") == expected.npos;
  });
}

}  // namespace

Nearest nearest(const Pattern& pattern, std::span<const FactCopy* const> facts, const Bindings& bindings,
                Evaluator* evaluator) {
  Nearest best;
  std::pair<std::ptrdiff_t, std::ptrdiff_t> most;
  for (const FactCopy* fact : facts) {
    if (fact->template_name != pattern.template_name()) continue;
    std::vector<Mismatch> mismatches = pattern.mismatches(*fact, bindings, evaluator);
    if (best.fact && mismatches.size() > best.mismatches.size()) continue;
    const std::pair near{near_words(mismatches), -others(mismatches)};
    if (best.fact && mismatches.size() == best.mismatches.size() && near < most) continue;
    best = {fact, std::move(mismatches)};
    most = near;
  }
  return best;
}

}  // namespace cxlab::explain
