#include "cx/inspect/text.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <iterator>
#include <map>
#include <set>

#include "cx/base/number_text.h"
#include "cx/explain/names.h"
#include "cx/inspect/layout.h"

namespace cxlab::inspect {

namespace {

std::string padded(std::string text, std::size_t width) {
  if (text.size() < width) text.resize(width, ' ');
  return text;
}

std::string right(std::string text, std::size_t width) {
  return text.size() < width ? std::string(width - text.size(), ' ') + text : text;
}

std::string times(std::size_t n) { return n == 1 ? "once" : std::to_string(n) + " times"; }

std::string place(const std::string& file, int line) {
  return file.empty() ? std::string() : " (" + file + ':' + std::to_string(line) + ')';
}

/// The slots that differ, as "state = IDLE (was MOVING)".
std::string slots_that_differ(const FactCopy& before, const FactCopy& after) {
  std::string text;
  for (const auto& [name, value] : after.slots) {
    const Value* old = before.slot(name);
    if (old && old->print() == value.print()) continue;
    text += (text.empty() ? ": " : ", ") + name + " = " + value.print();
    if (old) text += " (was " + old->print() + ')';
  }
  return text;
}

std::string index_text(const FactCopy& fact) { return fact.index > 0 ? "f-" + std::to_string(fact.index) : "gone"; }

std::string in_short(const FactHistory& history) {
  const FactChange& first = history.changes.front();
  std::string text = "asserted at " + seconds_text(first.t) + " by " + first.by.text();
  const std::size_t changed =
      static_cast<std::size_t>(std::ranges::count(history.changes, RecordKind::kModify, &FactChange::kind));
  if (changed > 0) {
    const auto last =
        std::ranges::find(history.changes.rbegin(), history.changes.rend(), RecordKind::kModify, &FactChange::kind);
    text += "; changed " + times(changed) + (changed == 1 ? " at " : ", the last time at ") + seconds_text(last->t) +
            " by " + last->by.text();
  }
  if (!history.present) {
    const FactChange& last = history.changes.back();
    text += "; retracted at " + seconds_text(last.t) + " by " + last.by.text();
  }
  return text;
}

}  // namespace

const char* done_by(RecordKind kind) {
  return kind == RecordKind::kRetract ? "retracted" : kind == RecordKind::kModify ? "changed" : "asserted";
}

std::string seconds_text(SimTime t) {
  char text[40];
  std::snprintf(text, sizeof text, "%.3f s", std::max(0.0, to_seconds(t)));
  return text;
}

std::optional<std::string> seconds_in(const std::string& time) {
  const std::size_t colon = time.find(':'), whole = colon + 1, point = whole + 2;
  if (colon == time.npos) {
    const auto seconds = read_number<double>(time);
    return seconds && std::isfinite(*seconds) && *seconds >= 0 ? std::optional(time) : std::nullopt;
  }
  const auto digits = [&time](std::size_t from, std::size_t to) {
    return from < to && to <= time.size() &&
           std::ranges::all_of(time.substr(from, to - from), [](char c) { return c >= '0' && c <= '9'; });
  };
  const bool fraction = point < time.size();
  if (!digits(0, colon) || !digits(whole, point)) return std::nullopt;
  if (fraction && (time[point] != '.' || !digits(point + 1, time.size()))) return std::nullopt;
  const auto minutes = read_number<std::int32_t>(time.substr(0, colon));
  const auto seconds = read_number<std::int32_t>(time.substr(whole, 2));
  if (!minutes || !seconds || *seconds >= 60) return std::nullopt;
  return std::to_string(std::int64_t{60} * *minutes + *seconds) + time.substr(std::min(point, time.size()));
}

std::string values_text(const Values& values) {
  std::string text;
  for (const auto& [name, value] : values) text += (text.empty() ? "?" : " ?") + name + " = " + value;
  return text;
}

std::string text_of(const std::vector<FactHistory>& facts, bool changes) {
  std::string text;
  for (const FactHistory& history : facts) {
    text += padded(index_text(history.fact), 8) + history.fact.print() + '\n';
    if (!changes) {
      text += "        " + in_short(history) + '\n';
      continue;
    }
    const FactCopy* before = nullptr;
    for (const FactChange& change : history.changes) {
      text += right(seconds_text(change.t), 18) + "  " + padded(done_by(change.kind), 10) + "by " + change.by.text();
      if (change.kind == RecordKind::kModify && before) text += slots_that_differ(*before, change.after);
      text += '\n';
      before = &change.after;
    }
  }
  return text;
}

std::string text_of(const std::vector<ActivationInfo>& agenda, const std::vector<std::string>& focus) {
  std::string text;
  if (focus.size() > 1 || (focus.size() == 1 && focus.front() != "MAIN")) {
    text = "focus:";
    for (const std::string& module : focus) text += ' ' + module;
    text += '\n';
  }
  for (const ActivationInfo& a : agenda) {
    text += right(std::to_string(a.salience), 6) + "  " + explain::with_module(a.module, a.rule) + ':';
    for (const std::int64_t fact : a.facts) text += fact < 0 ? " *" : " f-" + std::to_string(fact);
    text += '\n';
  }
  return text;
}

std::string text_of(const std::vector<std::pair<std::string, Value>>& globals) {
  std::string text;
  for (const auto& [name, value] : globals) text += "?*" + name + "* = " + value.print() + '\n';
  return text;
}

std::string text_of(const std::vector<FiringCopy>& firings) {
  std::string text;
  for (const FiringCopy& firing : firings) {
    text += right(seconds_text(firing.t), 12) + "  " + firing.rule;
    if (const std::string values = values_text(firing.values); !values.empty()) text += "  " + values;
    text += '\n';
  }
  return text;
}

std::string text_of(const std::vector<RuleUse>& rules) {
  std::vector<const RuleUse*> fired, in_vain, never;
  std::size_t width = 4;
  for (const RuleUse& use : rules) {
    (use.fired > 0 ? fired : use.activated.value_or(0) > 0 ? in_vain : never).push_back(&use);
    width = std::max(width, use.rule.size());
  }
  std::ranges::stable_sort(fired, std::greater(), [](const RuleUse* use) { return use->fired; });
  std::string text;
  if (!fired.empty()) {
    text += padded("rule", width) + "     fired  on the agenda    first time     last time\n";
    for (const RuleUse* use : fired)
      text += padded(use->rule, width) + right(std::to_string(use->fired), 10) +
              right(use->activated ? std::to_string(*use->activated) : "-", 15) + right(seconds_text(*use->first), 14) +
              right(seconds_text(*use->last), 14) + '\n';
  }
  // What takes a rule off the agenda again and again is worth a question.
  constexpr std::int64_t kOften = 100, kSeldom = 20;
  std::vector<const RuleUse*> seldom = fired;
  std::erase_if(seldom, [](const RuleUse* use) {
    return use->activated.value_or(0) < kOften || *use->activated < kSeldom * use->fired;
  });
  if (!seldom.empty()) {
    text += "on the agenda, but hardly ever fired:\n";
    for (const RuleUse* use : seldom)
      text += "  " + use->rule + place(use->file, use->line) + ": " + std::to_string(*use->activated) +
              " times, and fired " + std::to_string(use->fired) + (use->fired == 1 ? " time\n" : " times\n");
  }
  if (!in_vain.empty()) {
    text += "on the agenda, but never fired:\n";
    for (const RuleUse* use : in_vain)
      text += "  " + use->rule + place(use->file, use->line) + ": " + std::to_string(*use->activated) +
              (use->activated == 1 ? " time\n" : " times\n");
  }
  if (!never.empty()) {
    // Many rules wait for facts that never came, of trouble say: those that lack more than a fact come first.
    std::map<std::string, std::vector<const RuleUse*>> by_reason;
    for (const RuleUse* use : never)
      if (use->unmet && use->unmet->none_there) by_reason[use->unmet->because].push_back(use);
    const auto is_grouped = [&](const RuleUse* use) {
      constexpr std::size_t kFewest = 3;
      return use->unmet && use->unmet->none_there && by_reason[use->unmet->because].size() >= kFewest;
    };
    text += "never on the agenda, with what they lack now:\n";
    for (const RuleUse* use : never) {
      if (is_grouped(use)) continue;
      text += "  " + use->rule + place(use->file, use->line) + '\n';
      if (use->unmet) text += text_of(*use->unmet, "condition " + std::to_string(use->unmet->number), "    ");
    }
    for (const auto& [reason, uses] : by_reason) {
      if (!is_grouped(uses.front())) continue;
      std::string list;
      for (const RuleUse* use : uses) list += (list.empty() ? "" : ", ") + use->rule + place(use->file, use->line);
      text +=
          "  " + std::to_string(uses.size()) + " rules for which " + reason + ":\n" + laid_out(list, "    ", "    ");
    }
  }
  return text;
}

std::string text_of(const explain::UnmetCondition& unmet, const std::string& begin, const std::string& indent) {
  const std::string deeper = indent + "  ", line = begin + ": " + unmet.print();
  if (fits(line, indent)) return indent + line + '\n';
  std::string text = laid_out(begin + (unmet.text.empty() ? "" : ": " + unmet.text), indent, deeper + "  ") +
                     laid_out(unmet.because, deeper, deeper + "  ");
  if (unmet.fact) text += laid_out(*unmet.fact, deeper, deeper + "  ");
  return text;
}

// --- Derivations

std::string line_of(const Derivation::Step& step) {
  std::string text;
  switch (step.kind) {
    case RecordKind::kAssert:
    case RecordKind::kDecision:
    case RecordKind::kModify:
    case RecordKind::kRetract:
      text = (step.index > 0 ? "f-" + std::to_string(step.index) + "  " : "") + step.text + "  ";
      if (step.asserted)
        text += "asserted at " + seconds_text(step.asserted->t) + " by " + step.asserted->by.text() + ", ";
      text += std::string(done_by(step.kind)) + " at " + seconds_text(step.t);
      break;
    case RecordKind::kFire:
      text = "rule " + step.text + place(step.file, step.line) + " at " + seconds_text(step.t);
      if (const std::string values = values_text(step.values); !values.empty()) text += "  " + values;
      break;
    case RecordKind::kControl:
      text = (step.by_program ? "the program at "
              : step.by_story ? "the story, at "
              : step.planned  ? "what if, at "
                              : "a person at ") +
             seconds_text(step.t) + ": " + step.text;
      break;
    case RecordKind::kError: text = "an error at " + seconds_text(step.t) + ": " + step.text; break;
    default: text = "from outside: " + step.text + " at " + seconds_text(step.t);
  }
  if (step.outside) text += ", from " + *step.outside;
  if (!step.note.empty()) text += ", by " + step.note;
  return text;
}

namespace {

/// A step that leads no further, such as the time that the executive asserts, says less than one that does.
bool leads_on(const Derivation::Step& step) { return !step.because.empty() || step.outside; }

class TreeMaker {
 public:
  TreeMaker(const Derivation& derivation, bool whole) : steps_(derivation.steps), whole_(whole) {}

  Tree follow(std::size_t index) {
    const Derivation::Step& step = steps_[index];
    Tree tree{line_of(step), {}};
    if (!followed_.insert(index).second) {
      if (!step.because.empty()) tree.text += "  (as above)";
      return tree;
    }
    if (step.kind == RecordKind::kFire) path_.push_back(step.text);
    const auto main =
        std::ranges::find_if(step.because, [&](std::size_t i) { return leads_on(steps_[i]) && !is_again(steps_[i]); });
    for (auto cause = step.because.begin(); cause != step.because.end(); ++cause)
      tree.branches.push_back(whole_ || cause == main ? follow(*cause) : glance(*cause));
    if (step.kind == RecordKind::kFire) path_.pop_back();
    return tree;
  }

 private:
  /// Whether the fact was made by a rule that stands above: rules that count or wait lead back to themselves, and say
  /// no more each time.
  bool is_again(const Derivation::Step& fact) const {
    return std::ranges::any_of(fact.because, [&](std::size_t i) {
      return steps_[i].kind == RecordKind::kFire && std::ranges::find(path_, steps_[i].text) != path_.end();
    });
  }
  Tree glance(std::size_t index) const {
    const Derivation::Step& step = steps_[index];
    Tree tree{line_of(step), {}};
    if (!step.because.empty()) {
      const Derivation::Step& by = steps_[step.because.front()];
      tree.text += by.kind == RecordKind::kFire ? " by rule " + by.text : " by " + by.text;
    }
    return tree;
  }

  const std::vector<Derivation::Step>& steps_;
  bool whole_;
  std::set<std::size_t> followed_;
  std::vector<std::string> path_;  // rules above
};

/// The lines of a tree: the first begins with `first`, those below it with `before`.
void append(const Tree& tree, const std::string& first, const std::string& before, std::string& out) {
  out += laid_out(tree.text, first, before + (tree.branches.empty() ? "   " : "│  "));
  for (std::size_t i = 0; i < tree.branches.size(); ++i) {
    const bool last = i + 1 == tree.branches.size();
    append(tree.branches[i], before + (last ? "└─ " : "├─ "), before + (last ? "   " : "│  "), out);
  }
}

/// The name of the template of a fact as it is printed.
std::string template_of(const std::string& fact) { return fact.substr(1, fact.find_first_of(" )") - 1); }

/// The firings of a derivation, numbered from the latest.
class FiringList {
 public:
  explicit FiringList(const Derivation& derivation) : steps_(derivation.steps) {
    std::vector<std::size_t> firings;
    for (std::size_t i = 0; i < steps_.size(); ++i)
      if (steps_[i].kind == RecordKind::kFire) firings.push_back(i);
    std::ranges::sort(firings, std::greater(), [&](std::size_t i) { return steps_[i].n; });
    firings_ = firings.size();
    for (const std::size_t firing : firings) {
      if (entry_of_.contains(firing)) continue;
      std::vector<std::size_t> entry = repeated(firing);
      if (entry.size() < kFewest) entry = {firing};
      for (const std::size_t one : entry) entry_of_.emplace(one, entries_.size());
      entries_.push_back(std::move(entry));
    }
  }

  std::string text() const {
    std::string out;
    const Derivation::Step& asked = steps_.front();
    if (asked.kind != RecordKind::kFire) out = laid_out(line_of(asked) + sources_text({0}, ", by"), "", "  ");
    if (entries_.empty()) return out;
    out += firings_ == 1 ? "one firing led to it" : std::to_string(firings_) + " firings led to it, the latest first";
    out +=
        ". \"from\" names the facts that a rule\n"
        "matched, each with the number of the firing that made it, or with what came from outside; facts\n"
        "that have neither stand at the end.\n";
    std::set<std::string> shown;  // rules, with their places
    for (std::size_t i = 0; i < entries_.size(); ++i) out += text_of_entry(i, shown);
    return out + text_of_others();
  }

 private:
  static constexpr std::size_t kFewest = 4;  // firings in one entry

  /// The firing that made or changed the fact of that step.
  std::optional<std::size_t> maker_of(std::size_t fact) const {
    for (const std::size_t by : steps_[fact].because)
      if (steps_[by].kind == RecordKind::kFire) return by;
    return std::nullopt;
  }

  /// The templates of the facts that it matched, each with the rule that made it.
  std::vector<std::pair<std::string, std::string>> causes_of(std::size_t firing) const {
    std::vector<std::pair<std::string, std::string>> out;
    for (const std::size_t fact : steps_[firing].because) {
      const auto maker = maker_of(fact);
      out.emplace_back(template_of(steps_[fact].text), maker ? steps_[*maker].text : std::string());
    }
    std::ranges::sort(out);
    return out;
  }

  /// The firing, and those before it of the same rule and for the same kinds of facts, each of which made a fact for
  /// the next one.
  std::vector<std::size_t> repeated(std::size_t firing) const {
    std::vector<std::size_t> out{firing};
    const auto causes = causes_of(firing);
    while (true) {
      std::set<std::size_t> before;
      for (const std::size_t fact : steps_[out.back()].because)
        if (const auto maker = maker_of(fact); maker && steps_[*maker].text == steps_[firing].text)
          before.insert(*maker);
      if (before.size() != 1 || entry_of_.contains(*before.begin()) || causes_of(*before.begin()) != causes) return out;
      out.push_back(*before.begin());
    }
  }

  std::string text_of_entry(std::size_t i, std::set<std::string>& shown) const {
    const std::vector<std::size_t>& entry = entries_[i];
    const Derivation::Step &last = steps_[entry.front()], &first = steps_[entry.back()];
    std::string head = last.text;
    if (shown.insert(last.text).second) head += place(last.file, last.line);
    Values telling;  // addresses of messages and facts say nothing
    std::ranges::copy_if(last.values, std::back_inserter(telling),
                         [](const auto& v) { return !v.second.starts_with('<'); });
    const std::string values = entry.size() == 1 ? values_text(telling) : std::string();
    if (entry.size() > 1)
      head += ' ' + times(entry.size()) + " since " + seconds_text(first.t) + ", each time after the time before";
    if (!values.empty()) head += "  " + values;
    const std::string indent(9, ' ');
    std::string out = laid_out(head, right(std::to_string(i + 1), 5) + "  " + seconds_text(last.t) + "  ", indent);
    if (const std::string from = sources_text(entry, "from"); !from.empty())
      out += laid_out(from, indent, indent + "  ");
    if (!last.note.empty()) out += indent + last.note + '\n';
    return out;
  }

  /// The facts that no rule made and that did not come from outside. Where there are many of one template, only how
  /// many.
  std::string text_of_others() const {
    std::vector<std::pair<std::string, std::vector<const Derivation::Step*>>> by_template;
    for (std::size_t i = 1; i < steps_.size(); ++i) {
      const Derivation::Step& step = steps_[i];
      if (step.note.empty() || step.kind == RecordKind::kFire) continue;
      const std::string name = template_of(step.text) + ", by " + step.note;
      auto known = std::ranges::find(by_template, name, [](const auto& one) { return one.first; });
      if (known == by_template.end()) known = by_template.insert(known, {name, {}});
      known->second.push_back(&step);
    }
    std::string out;
    for (auto& [name, steps] : by_template) {
      std::ranges::sort(steps, {}, &Derivation::Step::n);
      if (steps.size() < kFewest)
        for (const Derivation::Step* step : steps) out += laid_out(line_of(*step), "", "  ");
      else
        out += laid_out(std::to_string(steps.size()) + " facts of " + name + ", the first " + steps.front()->text +
                            " at " + seconds_text(steps.front()->t) + ", the last " + steps.back()->text + " at " +
                            seconds_text(steps.back()->t),
                        "", "  ");
    }
    return out;
  }

  /// What these firings matched, or what this fact came from: "from job 3, 7; result /robot1/pick (node/robot1:12)".
  std::string sources_text(const std::vector<std::size_t>& of, const std::string& begin) const {
    struct Sources {
      std::string label;
      std::vector<std::string> numbers, outside;
    };
    std::vector<Sources> all;
    const auto add = [&](const std::string& label, const std::string& number, const std::string& outside) {
      auto known = std::ranges::find(all, label, &Sources::label);
      if (known == all.end()) known = all.insert(known, {label, {}, {}});
      for (const auto& [text, list] : {std::pair(&number, &known->numbers), std::pair(&outside, &known->outside)})
        if (!text->empty() && std::ranges::find(*list, *text) == list->end()) list->push_back(*text);
    };
    for (const std::size_t step : of) {
      const bool is_fact = steps_[step].kind != RecordKind::kFire;
      for (const std::size_t fact : is_fact ? std::vector{step} : steps_[step].because) {
        const std::string label = is_fact ? "" : template_of(steps_[fact].text);
        if (const auto maker = maker_of(fact)) {
          const std::size_t entry = entry_of_.at(*maker);
          if (!is_fact && entry_of_.at(step) == entry) continue;
          const bool in_the_middle = entries_[entry].front() != *maker;
          add(label, std::to_string(entry + 1) + (in_the_middle ? " at " + seconds_text(steps_[*maker].t) : ""), {});
        } else if (!steps_[fact].because.empty()) {
          const Derivation::Step& by = steps_[steps_[fact].because.front()];
          const bool came = by.kind != RecordKind::kControl;
          add(came ? by.text : line_of(by), {}, by.outside.value_or(""));
        } else if (!is_fact) {
          add(label, {}, steps_[fact].outside.value_or(""));
        }
      }
    }
    std::string out;
    const auto listed = [](const std::vector<std::string>& texts) {
      std::string text;
      for (const std::string& one : texts) text += (text.empty() ? "" : ", ") + one;
      return text;
    };
    for (const Sources& source : all) {
      out += (out.empty() ? begin : ";") + (source.label.empty() ? "" : ' ' + source.label);
      if (!source.numbers.empty()) out += ' ' + listed(source.numbers);
      if (!source.outside.empty()) out += " (" + listed(source.outside) + ')';
    }
    return out;
  }

  const std::vector<Derivation::Step>& steps_;
  std::size_t firings_ = 0;
  std::vector<std::vector<std::size_t>> entries_;  // each with its firings, the latest first
  std::map<std::size_t, std::size_t> entry_of_;    // by firing
};

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (static_cast<unsigned char>(c) >= 0x20)
      out += c;
    else
      out += ' ';
  }
  return out;
}

}  // namespace

Tree tree_of(const Derivation& derivation, bool whole) { return TreeMaker(derivation, whole).follow(0); }

std::string text_of(const Tree& tree) {
  std::string out;
  append(tree, "", "", out);
  return out;
}

std::string whole_text(const Derivation& derivation) { return FiringList(derivation).text(); }

std::string svg_of(const Tree& tree) {
  constexpr int kRow = 30, kStep = 28, kLeft = 16, kBox = 22;
  constexpr double kLetter = 7.3;
  std::string boxes;
  int row = 0;
  double width = 0;
  const std::function<int(const Tree&, int)> draw = [&](const Tree& node, int depth) {
    const int x = kLeft + depth * kStep, y = kLeft + row++ * kRow;
    const double w = static_cast<double>(node.text.size()) * kLetter + 16;
    width = std::max(width, x + w);
    const bool rule = node.text.starts_with("rule ");
    const char* fill = rule ? "#dbe9ff" : node.branches.empty() ? "#eef6e6" : "#fff6d8";
    boxes += "<rect x='" + std::to_string(x) + "' y='" + std::to_string(y) + "' width='" +
             std::to_string(static_cast<int>(w)) + "' height='" + std::to_string(kBox) + "' rx='" + (rule ? "0" : "8") +
             "' fill='" + fill + "' stroke='#667'/><text x='" + std::to_string(x + 8) + "' y='" +
             std::to_string(y + 15) + "'>" + escaped(node.text) + "</text>\n";
    for (const Tree& branch : node.branches) {
      const int below = draw(branch, depth + 1);
      boxes += "<path d='M" + std::to_string(x + 10) + ' ' + std::to_string(y + kBox) + " V" +
               std::to_string(below + kBox / 2) + " H" + std::to_string(x + kStep) + "' fill='none' stroke='#667'/>\n";
    }
    return y;
  };
  draw(tree, 0);
  const std::string w = std::to_string(static_cast<int>(width) + kLeft);
  const std::string h = std::to_string(2 * kLeft + row * kRow);
  return "<svg xmlns='http://www.w3.org/2000/svg' width='" + w + "' height='" + h + "' viewBox='0 0 " + w + ' ' + h +
         "' font-family='monospace' font-size='12'>\n<rect width='100%' height='100%' fill='white'/>\n" + boxes +
         "</svg>\n";
}

}  // namespace cxlab::inspect
