#include "cx/inspect/text.h"

#include <algorithm>
#include <cstdio>
#include <functional>
#include <set>

#include "cx/explain/names.h"

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
    text += "never on the agenda, with what they lack now:\n";
    for (const RuleUse* use : never) {
      text += "  " + use->rule + place(use->file, use->line) + '\n';
      if (use->unmet) text += "    condition " + std::to_string(use->unmet->number) + ": " + use->unmet->print() + '\n';
    }
  }
  return text;
}

// --- Trees

std::string line_of(const Derivation::Step& step) {
  std::string text;
  switch (step.kind) {
    case RecordKind::kAssert:
    case RecordKind::kDecision:
    case RecordKind::kModify:
    case RecordKind::kRetract:
      text = (step.index > 0 ? "f-" + std::to_string(step.index) + "  " : "") + step.text + "  " + done_by(step.kind) +
             " at " + seconds_text(step.t);
      break;
    case RecordKind::kFire:
      text = "rule " + step.text + place(step.file, step.line) + " at " + seconds_text(step.t);
      if (const std::string values = values_text(step.values); !values.empty()) text += "  " + values;
      break;
    case RecordKind::kControl:
      text = (step.planned ? "what if, at " : "a person at ") + seconds_text(step.t) + ": " + step.text;
      break;
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

void append(const Tree& tree, const std::string& before, std::string& out) {
  for (std::size_t i = 0; i < tree.branches.size(); ++i) {
    const bool last = i + 1 == tree.branches.size();
    // A chain of single causes stays where it is.
    out += before + (last ? "└─ " : "├─ ") + tree.branches[i].text + '\n';
    append(tree.branches[i], before + (last ? "   " : "│  "), out);
  }
}

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
  std::string out = tree.text + '\n';
  append(tree, "", out);
  return out;
}

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
