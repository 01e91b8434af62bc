#include "cx/inspect/makers.h"

#include <algorithm>
#include <map>
#include <set>

#include "cx/check/patterns.h"
#include "cx/check/rule_base.h"
#include "cx/engine/form_reader.h"
#include "cx/explain/names.h"
#include "cx/inspect/layout.h"
#include "cx/inspect/text.h"

namespace cxlab::inspect {

namespace {

/// The first pattern of facts in a condition as it is written: `?f <- (job (id ?i))`, `(not (and (job) (free)))`.
struct Found {
  const Term* pattern = nullptr;
  bool negated = false;
};
Found pattern_in(const Term& term, bool negated = false) {
  if (!term.is_list()) return {};
  const std::string_view head = term.head();
  if (head == "test" || head == "object") return {};
  if (!check::is_group(head)) return {&term, negated};
  for (std::size_t i = 1; i < term.items.size(); ++i)
    if (const Found found = pattern_in(term.items[i], negated != (head == "not")); found.pattern) return found;
  return {};
}

/// The constructs of an engine as the files that they came from, each at its line.
std::vector<check::Source> sources_of(const RuleEngine& engine) {
  std::map<std::string, std::vector<const ConstructInfo*>> by_file;
  const std::vector<ConstructInfo> constructs = engine.constructs();
  for (const ConstructInfo& info : constructs) by_file[info.file].push_back(&info);
  std::vector<check::Source> sources;
  for (auto& [file, infos] : by_file) {
    std::ranges::stable_sort(infos, {}, &ConstructInfo::line);
    check::Source source{file, {}};
    int line = 1;
    for (const ConstructInfo* info : infos) {
      for (; line < info->line; ++line) source.text += '\n';
      source.text += info->text;
      line += static_cast<int>(std::ranges::count(info->text, '\n'));
    }
    sources.push_back(std::move(source));
  }
  return sources;
}

/// Whether a value that is written so can match the slot, as far as it is a constant.
bool may_match(const check::SlotConstraint& slot, std::span<const Term> values) {
  if (values.size() != 1 || !check::is_symbol(values.front())) return true;
  const std::string& value = values.front().text;
  return (slot.one_of.empty() || slot.one_of.contains(value)) && !slot.none_of.contains(value);
}

/// The wanted fact. A change must set one of the slots `differing`, in which the existing facts differ from the
/// pattern. It is empty if a fact matches the pattern by itself, or if no such fact exists.
struct Needed {
  check::PatternSlots pattern;
  std::set<std::string> differing;
};

/// Whether a fact or the changes of one, written from item `from` on, can fit. A change must set a slot that the
/// pattern asks for, else it makes no difference.
bool may_make(const Needed& needed, const Term& term, std::size_t from) {
  const check::PatternSlots& wanted = needed.pattern;
  const auto values = check::values_of(term, from);
  const auto is_set = [&](const std::string& slot) { return values.contains(slot); };
  if (from == 2 && !needed.differing.empty() && std::ranges::none_of(needed.differing, is_set)) return false;
  bool sets_any = false;
  for (const auto& [name, slot] : wanted.slots) {
    const auto set = values.find(name);
    if (set == values.end()) continue;
    sets_any = sets_any || !slot.any() || !slot.variable.empty();
    if (!may_match(slot, set->second)) return false;
  }
  return from < 2 || sets_any || wanted.slots.empty();
}

/// The `modify` at that line that a construct has.
const Term* modify_at(const Term& term, int line) {
  if (term.is_list() && term.line == line && (term.head() == "modify" || term.head() == "duplicate")) return &term;
  for (const Term& item : term.items)
    if (const Term* found = modify_at(item, line)) return found;
  return nullptr;
}

/// How a construct could do it; empty: it could not.
std::string how_of(const check::Touch& touch, const Needed& wanted, bool forbids) {
  if (touch.template_name != wanted.pattern.name) return {};
  switch (touch.how) {
    case check::How::kAssert: return !forbids && (!touch.term || may_make(wanted, *touch.term, 1)) ? "asserts" : "";
    case check::How::kModify: {
      const Term* term = modify_at(touch.by->tree, touch.place.line);
      if (forbids) return "changes";
      return !term || may_make(wanted, *term, 2) ? "changes" : "";
    }
    case check::How::kRetract: return forbids ? "retracts" : "";
    default: return {};
  }
}

/// The slots in which facts of the pattern's template differ from it; empty where one matches.
std::set<std::string> differing_slots(const RuleEngine& engine, const explain::Pattern& pattern,
                                      explain::Evaluator& evaluator) {
  std::set<std::string> slots;
  for (const FactCopy& fact : engine.facts(pattern.template_name())) {
    const auto mismatches = pattern.mismatches(fact, {}, &evaluator);
    if (mismatches.empty()) return {};
    for (const explain::Mismatch& one : mismatches) slots.insert(one.slot);
  }
  return slots;
}

/// The rules that have made, changed or taken away a fact of the template.
std::set<std::string> doers_of(const Timeline& timeline, const std::string& template_name) {
  std::set<std::string> doers;
  for (std::uint64_t n = timeline.begin(); n < timeline.end(); ++n) {
    if (timeline.fact(n) == 0 || timeline.name(n) != template_name) continue;
    for (const Timeline::Cause& cause : timeline.causes(n))
      if (!cause.stream && timeline.has(cause.n) && timeline.kind(cause.n) == RecordKind::kFire)
        doers.insert(timeline.name(cause.n));
  }
  return doers;
}

}  // namespace

std::optional<Makers> makers_of(const Inspector& inspector, const explain::UnmetCondition& unmet) {
  const std::vector<Form> forms = read_forms(unmet.text, {}).forms;
  Makers out;
  Term condition;
  Found found;
  for (const Form& form : forms) {  // `?f <- (...)` has words before the list
    condition = tree_of(form);
    if ((found = pattern_in(condition)).pattern) break;
  }
  if (!found.pattern) return std::nullopt;
  const auto wanted = check::slots_of(*found.pattern);
  const auto pattern = explain::Pattern::parse(*found.pattern);
  if (!wanted || !pattern) return std::nullopt;
  out.pattern = found.pattern->print();
  out.forbids = found.negated;

  RuleEngine& engine = inspector.engine();
  explain::Evaluator evaluator(engine, unmet.module);
  check::Outside outside;
  outside.open = true;
  const auto base = check::RuleBase::read(sources_of(engine), std::move(outside));
  if (!base) return std::nullopt;
  std::set<std::string> seen;
  const auto add = [&](const check::Construct& rule, const std::string& how, const std::string& through) {
    const std::string name = explain::with_module(rule.module, rule.name);
    if (!rule.is_rule() || !engine.has("defrule", name) || !seen.insert(name).second) return;
    Makers::Maker maker{name, inspector.shown_file(rule.place.source->file), rule.place.line, how, through, 0, {}, {}};
    for (const std::uint64_t n : inspector.timeline().firings())
      if (inspector.timeline().name(n) == name) {
        ++maker.fired;
        maker.last = inspector.timeline().time(n);
      }
    if (const ConstructInfo* info = engine.find_construct("defrule", name); info && engine.acting_call(*info).empty())
      maker.lacks = explain::unmet_condition(engine, *info);
    out.makers.push_back(std::move(maker));
  };
  const Needed needed{*wanted, out.forbids ? std::set<std::string>() : differing_slots(engine, *pattern, evaluator)};
  for (const check::Touch& touch : base->touches()) {
    const std::string how = how_of(touch, needed, out.forbids);
    if (how.empty()) continue;
    if (touch.by->is_rule()) {
      add(*touch.by, how, {});
      continue;
    }
    for (const check::Construct* user : base->users(touch.by->name)) add(*user, how, touch.by->name);
  }
  // A function that changes the fact it is given could do so to any: rules that have fired and never had it do so to
  // such a fact come last.
  const std::set<std::string> doers = doers_of(inspector.timeline(), pattern->template_name());
  std::ranges::stable_sort(out.makers, std::greater(), [&](const Makers::Maker& maker) {
    return std::pair(!maker.last || doers.contains(maker.rule), maker.last.value_or(SimTime::min()));
  });

  if (const auto made = inspector.last_made(*pattern, &evaluator)) {
    out.made = inspector.change(*made);
    out.matched = out.made->after;
    for (const std::uint64_t n : inspector.timeline().changes(static_cast<std::int64_t>(out.made->after.number))) {
      if (n <= *made || out.gone) continue;
      FactChange later = inspector.change(n);
      if (later.kind == RecordKind::kRetract || !pattern->matches(later.after, &evaluator))
        out.gone = std::move(later);
      else
        out.matched = std::move(later.after);
    }
  }
  if (unmet.fact_number > 0) {
    const auto changes = inspector.timeline().changes(static_cast<std::int64_t>(unmet.fact_number));
    if (!changes.empty()) out.changed = inspector.change(changes.back());
  }
  return out;
}

std::string Makers::text() const {
  std::string out;
  const auto line = [&out](const std::string& text, const std::string& indent = "  ") {
    out += laid_out(text, indent, indent + "  ");
  };
  if (changed)
    line(std::string(forbids ? "it was " : "the nearest fact was ") + done_by(changed->kind) + " at " +
         seconds_text(changed->t) + " by " + changed->by.text());
  // The nearest fact still stands, and fails in a test or beside the conditions before: the lines above say all of it.
  const bool is_nearest = changed && matched && !gone && matched->number == changed->after.number;
  if (made && !forbids && !is_nearest) {
    const auto when = [](const FactChange& change) {
      return std::string(done_by(change.kind)) + " at " + seconds_text(change.t) + " by " + change.by.text();
    };
    const std::string what = "the last fact that matched " + pattern, fact = matched->print(),
                      end = "was " + when(*made) + (gone ? ", and " + when(*gone) : "");
    if (const std::string sentence = what + ", " + fact + ", " + end; fits(sentence, "  ")) {
      line(sentence);
    } else {
      line(what + ':');
      line(fact, "    ");
      line(end, "    ");
    }
    if (gone && gone->kind != RecordKind::kRetract) line("to " + gone->after.print(), "    ");
  } else if (!made && !forbids) {
    line("no fact has matched " + pattern + " so far");
  }
  line(makers.empty()
           ? std::string("no rule ") + (forbids ? "takes such a fact away" : "makes such a fact")
           : std::string("rules that ") + (forbids ? "can take such a fact away:" : "can make such a fact:"));
  constexpr std::size_t kShown = 8;
  for (const Maker& maker : makers) {
    if (&maker == makers.data() + kShown) {
      line("and " + std::to_string(makers.size() - kShown) + " more", "    ");
      break;
    }
    line(maker.rule + " (" + maker.file + ':' + std::to_string(maker.line) + ") " + maker.how + " it" +
             (maker.through.empty() ? "" : " through " + maker.through) + "; " +
             (maker.last
                  ? "fired " + std::to_string(maker.fired) +
                        (maker.fired == 1 ? " time, at " : " times, the last time at ") + seconds_text(*maker.last)
                  : "has not fired"),
         "    ");
    if (maker.lacks)
      out += text_of(*maker.lacks, "lacks now condition " + std::to_string(maker.lacks->number), "      ");
  }
  return out;
}

}  // namespace cxlab::inspect
