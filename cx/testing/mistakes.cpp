#include "cx/testing/mistakes.h"

#include <algorithm>
#include <cctype>
#include <memory>
#include <optional>
#include <set>

#include "cx/base/slip.h"
#include "cx/engine/template_names.h"
#include "cx/explain/names.h"
#include "cx/explain/pattern.h"
#include "cx/plugins/builtin.h"

namespace cxlab::testing {

namespace {

/// The objection of CLIPS to a fact, or to a pattern that no fact of its template can match. Its value may have another
/// type or may not be allowed, or a template with slots is written as an ordered fact. A separate engine, which has
/// only the templates, answers.
class Objections {
 public:
  explicit Objections(const RuleEngine& rules) {
    EngineOptions options;
    options.name = "patterns";
    auto made = RuleEngine::create(std::move(options));
    if (!made) return;
    engine_ = *std::move(made);
    for (const ConstructInfo& c : rules.constructs())
      if (c.kind == "deftemplate" || c.kind == "defmodule") (void)engine_->build(c.text);
  }
  /// Empty if there is nothing.
  std::string to_fact(const Term& fact) {
    if (!engine_ || !engine_->has("deftemplate", std::string(without_module(fact.head())))) return {};
    const auto asserted = engine_->assert_string(fact.print());
    return asserted ? "" : asserted.error().message;
  }
  /// Empty if there is nothing.
  std::string to_pattern(const std::string& pattern) {
    if (!engine_) return {};
    Term term = tree_of(read_forms(pattern, {}).forms.front());
    term.items.front().text = without_module(term.items.front().text);  // patterns of rules have no modules
    const std::string why = error_of(term);
    if (!why.starts_with("[CSTRNCHK1]")) return why;
    // A story compares 3 and 3.0 as numbers, CLIPS does not: slots by themselves, with all their numbers of one type.
    for (std::size_t i = 1; i < term.items.size(); ++i) {
      Term alone = term;
      if (term.items[i].is_list()) alone.items = {term.items[0], term.items[i]};
      if (!error_of(alone).empty() && !error_of(with_numbers(alone, ".0")).empty() &&
          !error_of(with_numbers(alone, "")).empty())
        return why;
    }
    return {};
  }

 private:
  std::string error_of(const Term& pattern) {
    static constexpr std::string_view kCodes[] = {"[CSTRNCHK1]", "[PRNTUTIL2]", "[PRNTUTIL5]", "[TMPLTDEF1]"};
    const Status built = engine_->build("(defrule pattern " + pattern.print() + " =>)");
    const std::string what = built ? "" : built.error().message;
    return std::ranges::any_of(kCodes, [&](std::string_view code) { return what.starts_with(code); }) ? what : "";
  }
  /// Whole numbers end with `end`: 3, 3.0.
  static Term with_numbers(Term term, const std::string& end) {
    const auto is_digits = [](std::string_view text) {
      return !text.empty() && text.find_first_not_of("0123456789") == std::string_view::npos;
    };
    for (Term& item : term.items) item = with_numbers(std::move(item), end);
    const std::size_t sign = term.text.starts_with('-') || term.text.starts_with('+') ? 1 : 0;
    const std::string whole = term.text.substr(0, std::min(term.text.find(".0"), term.text.size()));
    const bool number = term.kind == Token::Kind::kWord &&
                        is_digits(std::string_view(whole).substr(std::min(sign, whole.size()))) &&
                        (term.text == whole || term.text == whole + ".0");
    if (number) term.text = whole + end;
    return term;
  }

  std::unique_ptr<RuleEngine> engine_;
};

/// Whether a call asserts facts of a text that is computed, so that they may have any name. The names in a text that
/// stands there are words of the rules.
bool makes_facts_of_text(std::string_view text) {
  for (const std::string_view call : {"(assert-string ", "(eval "})
    for (std::size_t at = 0; (at = text.find(call, at)) != std::string_view::npos; at += call.size()) {
      const std::size_t argument = text.find_first_not_of(" \n\t", at + call.size());
      if (argument != std::string_view::npos && text[argument] != '"') return true;
    }
  return false;
}

/// Which templates the agent has, and which it may get.
class Templates {
 public:
  explicit Templates(const Play& play) : spec_(play.spec()), engine_(play.engine()) {
    names_ = template_names(engine_);
    for (const std::string_view fact : cx::builtin_facts()) names_.emplace_back(fact);
  }
  /// `ordered`: whether there may be ordered facts of that name.
  bool may_have(const std::string& name, bool ordered) const {
    if (std::ranges::count(names_, name) > 0) return true;
    const auto may_make = [&](const std::string& text) {
      const auto calls = [&](std::string_view function) { return has_word(text, function); };
      return has_word(text, name) || std::ranges::any_of(kMakers, calls) || (ordered && makes_facts_of_text(text));
    };
    return std::ranges::any_of(spec_.calls, may_make, &Line::text) ||
           std::ranges::any_of(engine_.constructs(), may_make, &ConstructInfo::text);
  }
  std::string guess(const std::string& name) const { return did_you_mean(name, names_); }
  bool is_misspelt(const std::string& name) const {
    constexpr std::size_t kShortest = 3;
    return name.size() >= kShortest && std::ranges::any_of(names_, [&](const auto& n) { return is_slip(name, n); });
  }

 private:
  /// Functions that may bring templates of any name while rules run.
  static constexpr std::string_view kMakers[] = {"(build", "(load",        "(load*", "(load-facts",
                                                 "(bload", "(bload-facts", "(batch", "(batch*"};

  /// Whether `word` stands there with nothing before or behind it that belongs to a word.
  static bool has_word(std::string_view text, std::string_view word) {
    const auto goes_on = [&](std::size_t at) {
      return at < text.size() && (std::isalnum(static_cast<unsigned char>(text[at])) != 0 ||
                                  std::string_view("-_*").find(text[at]) != std::string_view::npos);
    };
    for (std::size_t at = 0; (at = text.find(word, at)) != std::string_view::npos; ++at)
      if (!(at > 0 && !word.starts_with('(') && goes_on(at - 1)) && !goes_on(at + word.size())) return true;
    return false;
  }

  const StorySpec& spec_;
  const RuleEngine& engine_;
  std::vector<std::string> names_;
};

class Examination {
 public:
  /// `checked`: values are right.
  Examination(const Play& play, bool checked)
      : play_(play), spec_(play.spec()), engine_(play.engine()), checked_(checked) {
    mistakes_.errors = play.mistakes_in_messages();
    const auto add_word = [this](const std::string& word) {
      if (!word.empty()) handles_.push_back(word);
    };
    for (const StandIn& stand_in : spec_.stand_ins)
      for (const UnderWay& goal : stand_in.under_way) {
        add_word(goal.handle);
        if (stand_in.action) add_word(goal.id);
      }
    for (const GivenFact& fact : spec_.given) add_word(fact.as);
  }

  Mistakes all() {
    for (const GivenFact& fact : spec_.given) look_at_fact(fact.text, fact.line);
    for (const Step& step : spec_.steps)
      if (step.verb == Step::Verb::kAssert) look_at_fact(step.text, step.line);
    for (const Step& step : spec_.steps)
      if (step.verb == Step::Verb::kRetract) look_at_retract(step);
    for (const Expectation& e : spec_.expect) {
      if (e.kind == Kind::kFires || e.kind == Kind::kNotFires)
        look_at_rule(e);
      else if (e.kind == Kind::kGoal)
        look_at_goal(e);
      else if (e.kind != Kind::kPublished && !checked_)
        look_at_pattern(e);
    }
    std::ranges::stable_sort(mistakes_.errors, {}, &Error::line);
    return std::move(mistakes_);
  }

 private:
  using Kind = Expectation::Kind;

  void add(int line, const std::string& what) { mistakes_.errors.push_back(play_.at(line, what)); }
  void add(int line, const std::string& what, const Status& why) {
    if (!why) add(line, what + ": " + why.error().message);
  }

  /// Whether rules have, or may get, facts of that name.
  bool may_have(const std::string& name, bool ordered) {
    if (engine_.has("deftemplate", name)) return true;
    if (!templates_) templates_.emplace(play_);
    return templates_->may_have(name, ordered);
  }

  void look_at_fact(const std::string& text, int line) {
    const FormReading reading = read_forms(text, {});
    if (!reading.errors.empty()) return add(line, text + ": " + reading.errors.front().message);
    if (reading.forms.empty() || !reading.forms.front().list)
      return add(line, found_text(text, "a fact in parentheses"));
    if (reading.forms.size() > 1)
      return add(line, found_expected(reading.forms[1].text + " after " + reading.forms.front().text,
                                      "one fact: give each an entry of its own"));
    const std::vector<Token> tokens = tokens_of(reading.forms.front());
    const auto find = [&](const auto& is_wrong) {
      const auto token = std::ranges::find_if(tokens, is_wrong);
      return token == tokens.end() ? std::string() : std::string(token->text);
    };
    const auto refuse = [&](const std::string& word) {
      add(line, text + ": " + found_expected(word, "a value: a fact has no variables, and no &, | or ~"));
    };
    if (const auto word = find([](const Token& t) { return t.kind == Token::Kind::kConnective; }); !word.empty())
      return refuse(word);
    const Term term = tree_of(reading.forms.front());
    if (term.head().empty()) return add(line, found_text(text, "the name of a template first"));
    look_at_handles(text, term, line);
    const auto fact = explain::Pattern::parse_plain(text, spec_.file, line);
    if (!fact) return;  // it has expressions, or CLIPS objects to it when its time comes
    const std::string& name = fact->template_name();
    const bool is_ordered = fact->slot_names().empty();
    const std::string variable = find([](const Token& t) {
      const std::string_view word = t.text.substr(t.text.starts_with('$') ? 1 : 0);
      return t.kind == Token::Kind::kWord && word.starts_with('?') && !word.starts_with("?*");
    });
    if (is_ordered && !variable.empty()) return refuse(variable);
    if (engine_.has("deftemplate", name) || (!is_ordered && !may_have(name, false))) {
      const std::size_t told = mistakes_.errors.size();
      add(line, text, explain::check_names(*fact, engine_));
      if (mistakes_.errors.size() != told || is_ordered) return;
      if (!variable.empty()) return refuse(variable);
      if (!checked_) look_at_values(text, term, *fact, line);
      return;
    }
    if (!is_ordered || !given_.insert(name).second || may_have(name, false)) return;
    if (const std::string guess = templates_->guess(name); !guess.empty())
      mistakes_.notes.push_back(play_.at(line, text + ": no rule has facts '" + name + '\'' + guess).text());
  }

  /// Words such as <Fact-1> stand for facts that are given and for goals in progress.
  void look_at_handles(const std::string& text, const Term& term, int line) {
    for (const Term& item : term.items) look_at_handles(text, item, line);
    const std::string& word = term.text;
    if (term.kind != Token::Kind::kWord || word.size() < 3 || !word.starts_with('<') || !word.ends_with('>')) return;
    if (is_handle(word)) return;
    if (!word.starts_with("<Fact-") && !word.starts_with("<Pointer-") && did_you_mean(word, handles_).empty()) return;
    add(line, text + ": no fact or goal of this story is " + word +
                  (handles_.empty() ? "; name a fact that is given before: {fact: (...), as: " + word + '}'
                                    : "; known: " + some_of_and_nearest(word, handles_)));
  }

  /// Values of slots that are known before the play: no handles and no globals.
  void look_at_values(const std::string& text, Term term, const explain::Pattern& fact, int line) {
    std::erase_if(term.items, [this](const Term& slot) {
      const std::string printed = slot.is_list() ? slot.print() : std::string();
      return printed.find_first_of("<?") != std::string::npos ||
             std::ranges::any_of(handles_,
                                 [&](const std::string& handle) { return printed.find(handle) != printed.npos; });
    });
    if (!objections_) objections_ = std::make_unique<Objections>(engine_);
    if (const std::string why = objections_->to_fact(term); !why.empty())
      add(line, text + ": " + plain_objection(fact, engine_, why));
  }

  void look_at_retract(const Step& step) {
    const auto pattern = pattern_of(step.text, step.line);
    if (!pattern) return;
    if (engine_.has("deftemplate", pattern->template_name()))
      object_to_pattern(*pattern, "retract " + step.text, step.text, step.line);
    else if (!is_given(*pattern) && !may_have(*pattern))
      add(step.line, "retract " + step.text, explain::check_names(*pattern, engine_));
  }

  void look_at_pattern(const Expectation& e) {
    const auto pattern = pattern_of(e.text, e.line);
    if (!pattern) return;
    if (engine_.has("deftemplate", pattern->template_name()))
      object_to_pattern(*pattern, e.text, e.text, e.line);
    else if (!is_given(*pattern) && !may_have(*pattern) &&
             (!pattern->slot_names().empty() || templates_->is_misspelt(pattern->template_name())))
      add(e.line, e.text + " can match no fact", explain::check_names(*pattern, engine_));
  }

  /// None: it cannot be read.
  std::optional<explain::Pattern> pattern_of(const std::string& text, int line) {
    auto pattern = explain::Pattern::parse_plain(text, spec_.file, line);
    if (!pattern) {
      mistakes_.errors.push_back(pattern.error());
      return std::nullopt;
    }
    return *std::move(pattern);
  }

  void object_to_pattern(const explain::Pattern& pattern, const std::string& what, const std::string& text, int line) {
    if (!objections_) objections_ = std::make_unique<Objections>(engine_);
    if (const std::string why = objections_->to_pattern(text); !why.empty())
      add(line, what + " can match no fact: " + plain_objection(pattern, engine_, why));
  }

  bool is_handle(const std::string& word) const { return std::ranges::count(handles_, word) > 0; }

  bool may_have(const explain::Pattern& pattern) {
    return may_have(pattern.template_name(), pattern.slot_names().empty());
  }

  /// The story makes such ordered facts.
  bool is_given(const explain::Pattern& pattern) const {
    return pattern.slot_names().empty() && given_.contains(pattern.template_name());
  }

  void look_at_rule(const Expectation& e) {
    if (!engine_.find_construct("defrule", e.text))
      add(e.line, "there is no rule '" + e.text + '\'' +
                      did_you_mean(std::string(without_module(e.text)), explain::names_of(engine_, "defrule")));
  }

  void look_at_goal(const Expectation& e) {
    std::vector<std::string> served;
    for (const StandIn& stand_in : spec_.stand_ins) served.push_back(stand_in.name);
    for (const Step& step : spec_.steps)
      if (step.verb == Step::Verb::kStandIn) served.push_back(step.stand_in.name);
    if (std::ranges::count(served, e.text) == 0)
      add(e.line, "nobody serves " + e.text + did_you_mean(e.text, served) + " (skills: of the story)");
  }

  const Play& play_;
  const StorySpec& spec_;
  const RuleEngine& engine_;
  const bool checked_;
  std::vector<std::string> handles_;
  std::set<std::string> given_;  // names of ordered facts that no rule has
  std::optional<Templates> templates_;
  std::unique_ptr<Objections> objections_;
  Mistakes mistakes_;
};

}  // namespace

Mistakes mistakes_of(const Play& play, bool checked) { return Examination(play, checked).all(); }

bool makes_facts_of_text(const Play& play) {
  const std::vector<ConstructInfo> constructs = play.engine().constructs();
  return std::ranges::any_of(constructs, [](const ConstructInfo& c) { return makes_facts_of_text(c.text); });
}

}  // namespace cxlab::testing
