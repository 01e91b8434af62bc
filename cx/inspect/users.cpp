#include "cx/inspect/users.h"

#include <algorithm>
#include <functional>

#include "cx/explain/fact_record.h"
#include "cx/explain/left_hand_side.h"
#include "cx/explain/names.h"
#include "cx/explain/pattern.h"
#include "cx/explain/why_not.h"
#include "cx/inspect/layout.h"
#include "cx/inspect/text.h"

namespace cxlab::inspect {

namespace {

using explain::Condition;

/// A pattern of a rule, and whether facts that match it keep the rule from firing.
struct Place {
  const Condition* condition = nullptr;
  bool forbids = false;
  bool binds = true;  // its variables are those of the rule, not of a `not`, `exists` or `forall`
};

void find_patterns(const Condition& condition, Place place, std::vector<Place>& out) {
  using Kind = Condition::Kind;
  place.condition = &condition;
  if (condition.kind == Kind::kPattern && !condition.pattern.is_object()) out.push_back(place);
  place.forbids = place.forbids != (condition.kind == Kind::kNot);
  place.binds = place.binds && (condition.kind == Kind::kAnd || condition.kind == Kind::kOr);
  for (const Condition& part : condition.parts) find_patterns(part, place, out);
}

/// Values that the variables of the condition have for this fact, so that a rule is asked about it alone.
explain::Wanted wanted_for(const Condition& condition, const FactCopy& fact) {
  explain::Wanted wanted;
  if (!condition.fact_variable.empty()) wanted.emplace(condition.fact_variable, "f-" + std::to_string(fact.index));
  explain::Bindings bindings;
  condition.pattern.match(fact, bindings, nullptr, [&] {
    for (const auto& [name, value] : bindings)
      if (value.is_number() || value.is_text()) wanted.emplace(name, value.is_text() ? value.text() : value.print());
    return true;
  });
  return wanted;
}

class Users {
 public:
  Users(const Inspector& inspector, const FactHistory& history) : inspector_(inspector), fact_(history.fact) {
    since_ = history.changes.back().n;
  }

  void add_all(FactFuture& out) {
    // A copy: to look for what a rule lacks defines functions for a while.
    for (const ConstructInfo& info : inspector_.engine().constructs())
      if (info.kind == "defrule" && inspector_.engine().has("defrule", info.module + "::" + info.name)) add(info, out);
  }

 private:
  void add(const ConstructInfo& rule, FactFuture& out) {
    const auto conditions = explain::conditions_of(rule.text, rule.file, rule.line);
    if (!conditions) return;
    std::vector<Place> places;
    for (const Condition& condition : *conditions) find_patterns(condition, {}, places);
    std::erase_if(places,
                  [&](const Place& place) { return place.condition->pattern.template_name() != fact_.template_name; });
    const auto matching = [&](bool forbids) {
      return std::ranges::find_if(places, [&](const Place& place) {
        return place.forbids == forbids && place.condition->pattern.matches(fact_);
      });
    };
    if (const auto place = matching(false); place != places.end()) {
      FactUser user = user_of(rule, *place->condition);
      count_firings(user);
      if (inspector_.engine().acting_call(rule).empty())
        user.lacks = explain::unmet_condition(inspector_.engine(), rule,
                                              place->binds ? wanted_for(*place->condition, fact_) : explain::Wanted());
      out.waiting.push_back(std::move(user));
    } else if (const auto other = matching(true); other != places.end()) {
      out.forbidden.push_back(user_of(rule, *other->condition));
    } else {
      for (const Place& one : places) {
        const auto mismatches = one.condition->pattern.mismatches(fact_);
        if (one.forbids || mismatches.size() != 1) continue;
        FactUser user = user_of(rule, *one.condition);
        user.differs = mismatches.front().print();
        out.nearly.push_back(std::move(user));
        break;
      }
    }
  }

  FactUser user_of(const ConstructInfo& rule, const Condition& condition) const {
    FactUser user;
    user.rule = explain::with_module(rule.module, rule.name);
    user.file = inspector_.shown_file(rule.file);
    user.line = rule.line;
    user.condition = condition.text;
    return user;
  }

  void count_firings(FactUser& user) const {
    const Timeline& timeline = inspector_.timeline();
    const auto& all = timeline.firings();
    for (auto n = std::ranges::upper_bound(all, since_); n != all.end(); ++n) {
      if (timeline.name(*n) != user.rule) continue;
      const std::vector<std::int64_t> facts = explain::facts_of_firing(timeline.read(*n).data);
      if (std::ranges::find(facts, static_cast<std::int64_t>(fact_.number)) == facts.end()) continue;
      ++user.fired;
      user.last = timeline.time(*n);
    }
  }

  const Inspector& inspector_;
  const FactCopy& fact_;
  std::uint64_t since_ = 0;  // the record of its last change
};

}  // namespace

Expected<FactFuture> future_of(const Inspector& inspector, const std::string& what) {
  auto found = inspector.facts(what);
  if (!found) return found.error();
  FactFuture out;
  if (!found->empty()) {
    out.fact = *std::ranges::max_element(*found, {}, [](const FactHistory& one) { return one.changes.back().n; });
    Users(inspector, *out.fact).add_all(out);
    return out;
  }
  if (!what.starts_with('(')) return negative("there is no fact of '" + what + "' at that time");
  explain::UnmetCondition missing;
  missing.text = what;
  const auto pattern = explain::Pattern::parse_plain(what, {}, 0);
  const std::vector<FactCopy> facts = inspector.engine().facts(pattern->template_name());
  std::vector<const FactCopy*> pointers;
  for (const FactCopy& fact : facts) pointers.push_back(&fact);
  if (const explain::Nearest nearest = explain::nearest(*pattern, pointers); nearest.fact) {
    out.nearest = nearest.fact->print() + ": " + explain::print(nearest.mismatches);
    missing.fact_number = nearest.fact->number;
  }
  out.makers = makers_of(inspector, missing);
  return out;
}

std::string FactFuture::text() const {
  std::string out;
  const auto place = [](const FactUser& user) {
    return user.rule + " (" + user.file + ':' + std::to_string(user.line) + ')';
  };
  const auto line = [&out](const std::string& text, const std::string& indent) {
    out += laid_out(text, indent, indent + "    ");
  };
  if (!fact) {
    out = "no fact matches it now\n";
    if (!nearest.empty()) line("the nearest one is " + nearest, "  ");
    return makers ? out + makers->text() : out;
  }
  const FactChange& last = fact->changes.back();
  line("f-" + std::to_string(fact->fact.index) + "  " + fact->fact.print(), "");
  out += std::string("  ") + done_by(last.kind) + " at " + seconds_text(last.t) + " by " + last.by.text() + '\n';
  if (waiting.empty()) out += "  no rule needs such a fact\n";
  if (!waiting.empty()) out += "  rules that need such a fact:\n";
  for (const FactUser& user : waiting) {
    out += "    " + place(user);
    if (user.fired > 0)
      out += " fired for it " +
             (user.fired == 1 ? std::string("once, at ") : std::to_string(user.fired) + " times, the last time at ") +
             seconds_text(*user.last);
    else
      out += " has not fired for it" + std::string(fact->changes.size() > 1 ? " since then" : "");
    out += '\n';
    if (user.lacks)
      out += text_of(*user.lacks, "lacks condition " + std::to_string(user.lacks->number), "      ");
    else if (user.fired == 0)
      out += "      all its conditions hold\n";
  }
  if (!nearly.empty()) out += "  rules that need another value in it:\n";
  for (const FactUser& user : nearly) line(place(user) + ": " + user.differs, "    ");
  if (!forbidden.empty()) out += "  rules that it keeps from firing, for the same values:\n";
  for (const FactUser& user : forbidden) line(place(user) + ": " + user.condition, "    ");
  return out;
}

}  // namespace cxlab::inspect
