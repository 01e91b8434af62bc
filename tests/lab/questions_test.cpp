// Answers about a recorded game against the game itself: against what was seen in it while it was played, against the
// journal that it wrote, and against CLIPS. CXLAB_MOMENTS is how many moments of each game are asked, CXLAB_SECONDS how
// long the games are; without them two short games are, which tests/app/questions.py does not have.

#include <gmock/gmock.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <random>
#include <set>
#include <tuple>

#include "cx/base/number_text.h"
#include "cx/explain/why_not.h"
#include "cx/journal/journal_reader.h"
#include "folder.h"
#include "lab/moment.h"
#include "lab/run.h"
#include "lab/session.h"
#include "scenarios/shipped/catalogue.h"

namespace cxlab::lab {
namespace {

using inspect::Derivation;
using inspect::Doer;

int number_from(const char* variable, int otherwise) {
  const char* text = std::getenv(variable);
  return text ? std::atoi(text) : otherwise;
}

/// Addresses are only known to be some: the record of a fact has its number, the fact its index.
std::string text_of(const Value& value) {
  switch (value.type()) {
    case ValueType::kInteger: return std::to_string(value.as_integer());
    case ValueType::kFloat: return '#' + general_text(value.as_number(), 17);
    case ValueType::kString: return '"' + value.text() + '"';
    case ValueType::kInstanceName: return '[' + value.text() + ']';
    case ValueType::kHandle: return "an address";
    case ValueType::kFact: return "an address";
    case ValueType::kMultifield: {
      std::string text = "(";
      for (const Value& item : value.items()) text += text_of(item) + ' ';
      return text + ')';
    }
    default: return value.text();
  }
}

std::string text_of(const RecordValue& value) {
  if (const auto* integer = std::get_if<std::int64_t>(&value.value)) return std::to_string(*integer);
  if (const auto* number = std::get_if<double>(&value.value)) return '#' + general_text(*number, 17);
  if (const auto* text = std::get_if<std::string>(&value.value)) return *text;
  if (const auto* list = std::get_if<RecordValue::List>(&value.value)) {
    std::string text = "(";
    for (const RecordValue& item : *list) text += text_of(item) + ' ';
    return text + ')';
  }
  return std::holds_alternative<RecordValue::Map>(value.value) ? "an address" : "nothing";
}

using Slots = std::map<std::string, std::string>;
/// Facts by their number, with their template and slots.
using Facts = std::map<std::int64_t, std::pair<std::string, Slots>>;

void put(Facts& facts, const FactCopy& fact) {
  auto& [name, slots] = facts[static_cast<std::int64_t>(fact.number)];
  name = fact.template_name;
  for (const auto& [slot, value] : fact.slots) slots[slot] = text_of(value);
}

std::string text_of(const ActivationInfo& activation) {
  std::string text = activation.module + "::" + activation.rule + ' ' + std::to_string(activation.salience);
  for (const std::int64_t fact : activation.facts) text += " f-" + std::to_string(fact);
  return text;
}

/// An environment as it was seen at a moment of the game.
struct Sight {
  std::string name;
  std::vector<std::string> facts;  // with their indices, in order
  std::vector<std::string> agenda, focus, globals;
};

template <class Globals>
std::vector<std::string> texts_of_globals(const Globals& globals) {
  std::vector<std::string> texts;
  for (const auto& [name, value] : globals) texts.push_back(name + " = " + text_of(value));
  return texts;
}

std::string with_index(const FactCopy& fact) { return "f-" + std::to_string(fact.index) + ' ' + fact.print(); }

std::vector<std::string> texts_of(const std::vector<ActivationInfo>& agenda) {
  std::vector<std::string> texts;
  for (const ActivationInfo& one : agenda) texts.push_back(text_of(one));
  return texts;
}

/// What the journal says of an environment, up to a time.
class Ledger {
 public:
  struct Entry {
    SimTime t{};
    RecordKind kind{};
    std::string rule;               // of a firing
    std::set<std::uint64_t> own;    // causes in this stream
    std::set<std::string> outside;  // in others
  };

  Ledger(const std::filesystem::path& journal, std::string stream)
      : stream_(std::move(stream)), reader_(*JournalReader::open(journal)) {
    read();
  }
  void read_to(SimTime t) {
    for (; next_ && next_->t <= t; read()) add(*next_);
  }
  const Facts& facts() const { return facts_; }
  const Entry& entry(std::uint64_t n) const { return entries_.at(n); }
  /// The records about the fact of that number.
  const std::vector<std::uint64_t>& changes(std::int64_t fact) const { return changes_.at(fact); }
  const std::map<std::int64_t, std::vector<std::uint64_t>>& all_changes() const { return changes_; }

 private:
  void read() {
    auto record = reader_.next({.stream = stream_});
    ASSERT_TRUE(record) << record.error().text();
    next_ = *std::move(record);
  }
  void add(const JournalRecord& record) {
    Entry& entry = entries_[record.n];
    entry.t = record.t;
    entry.kind = record.kind;
    for (const JournalRecord::Cause& cause : record.causes)
      if (cause.stream == stream_)
        entry.own.insert(cause.n);
      else
        entry.outside.insert(cause.stream + ':' + std::to_string(cause.n));
    if (record.kind == RecordKind::kFire) entry.rule = record.data.text("rule");
    const std::int64_t fact = record.data.integer("fact");
    const bool is_set = record.kind == RecordKind::kAssert || record.kind == RecordKind::kModify ||
                        record.kind == RecordKind::kDecision;
    if (is_set || record.kind == RecordKind::kRetract) changes_[fact].push_back(record.n);
    if (record.kind == RecordKind::kRetract) facts_.erase(fact);
    if (!is_set) return;
    auto& [name, slots] = facts_[fact];
    name = record.data.text("template");
    for (const auto& [slot, value] : std::get<RecordValue::Map>(record.data.find("slots")->value))
      slots[slot] = text_of(value);
  }

  std::string stream_;
  JournalReader reader_;
  std::optional<JournalRecord> next_;
  std::map<std::uint64_t, Entry> entries_;
  std::map<std::int64_t, std::vector<std::uint64_t>> changes_;
  Facts facts_;
};

/// The text as the journal has it: it names folders of packages, because files may be elsewhere when it is read.
std::string as_recorded(std::string text) {
  const std::string folder = std::getenv("CXLAB_SOURCE_DIR") + std::string("/scenarios/rcll/planning_agent");
  for (std::size_t at; (at = text.find(folder)) != text.npos;)
    text.replace(at, folder.size(), "package://rcll_planning_agent");
  return text;
}

/// Agent and tier.
class AnswersTest : public FolderTest, public testing::WithParamInterface<std::tuple<std::string, std::string>> {
 public:
  void compare_facts_with_what_was_seen();
  void compare_facts_with_the_journal();
  void compare_why_with_the_journal();
  void compare_why_not_with_clips();

 protected:
  void SetUp() override {
    const int seconds = number_from("CXLAB_SECONDS", 40), moments = number_from("CXLAB_MOMENTS", 25);
    const bool short_one = (std::get<0>(GetParam()) == "game.yaml") == (std::get<1>(GetParam()) == "physics");
    if (!std::getenv("CXLAB_MOMENTS") && !short_one) GTEST_SKIP() << "a long one";
    std::mt19937 chance(20261127);
    while (static_cast<int>(times_.size()) < moments) times_.insert(SimTime(chance() % 10'000) * seconds * 100'000);
    play(seconds);
    auto run = lab::Run::open(path("run"));
    ASSERT_TRUE(run) << run.error().text();
    run_ = *std::move(run);
    begin();
  }
  /// All moments are ahead again.
  void begin() {
    auto opened = Moment::open(run_, {});
    ASSERT_TRUE(opened) << opened.error().text();
    moment_ = *std::move(opened);
    ledgers_.clear();
  }

  /// Those of all environments at that time.
  std::vector<inspect::Inspector> inspectors_at(SimTime t) {
    const Status reached = moment_->seek(t);
    EXPECT_TRUE(reached) << (reached ? "" : reached.error().text());
    auto inspectors = moment_->inspectors();
    EXPECT_TRUE(inspectors);
    return *std::move(inspectors);
  }
  Ledger& ledger_of(const std::string& environment) {
    const auto [at, fresh] = ledgers_.try_emplace(environment);
    if (fresh) at->second = std::make_unique<Ledger>(path("run/journal.jsonl"), "env/" + environment);
    at->second->read_to(moment_->t());
    return *at->second;
  }

  std::set<SimTime> times_;
  std::map<SimTime, std::vector<Sight>> seen_;  // in the game
  lab::Run run_;
  std::unique_ptr<Moment> moment_;

 private:
  void play(int seconds) {
    const auto& [file, tier] = GetParam();
    auto scenario =
        Scenario::load(std::getenv("CXLAB_SOURCE_DIR") + ("/scenarios/rcll/" + file), shipped(), {"tier=" + tier});
    ASSERT_TRUE(scenario) << scenario.error().text();
    PlayOptions options;
    options.spec.until = seconds;
    options.spec.journal = JournalLevel::kFull;
    options.out = path("run").string();
    auto session = Session::load(options, *std::move(scenario));
    ASSERT_TRUE(session) << session.error().text();
    for (const SimTime t : times_) {
      ASSERT_TRUE((*session)->step(t));
      for (cx::Environment* environment : (*session)->episode().environments()) {
        Sight& sight = seen_[t].emplace_back();
        const RuleEngine& engine = environment->engine();
        sight.name = environment->unique_name();
        for (const FactCopy& fact : engine.facts()) sight.facts.push_back(as_recorded(with_index(fact)));
        sight.agenda = texts_of(engine.agenda());
        sight.focus = engine.focus();
        sight.globals = texts_of_globals(engine.globals());
      }
    }
    ASSERT_TRUE((*session)->step(from_seconds(seconds)));
    const Played played = (*session)->close();
    ASSERT_FALSE(played.failure) << played.failure->text();
  }

  std::map<std::string, std::unique_ptr<Ledger>> ledgers_;
};

/// Also with the agenda, the focus and the globals.
void AnswersTest::compare_facts_with_what_was_seen() {
  std::size_t facts = 0, waiting = 0;
  for (const SimTime t : times_) {
    const auto inspectors = inspectors_at(t);
    const std::vector<Sight>& seen = seen_.at(t);
    ASSERT_EQ(inspectors.size(), seen.size());
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const inspect::Inspector& asked = inspectors[i];
      SCOPED_TRACE(asked.name() + " at " + std::to_string(to_seconds(t)) + " s");
      ASSERT_EQ(asked.name(), seen[i].name);
      const auto answer = asked.facts("");
      ASSERT_TRUE(answer);
      std::vector<std::string> found;
      for (const inspect::FactHistory& one : *answer) found.push_back(with_index(one.fact));
      ASSERT_EQ(found, seen[i].facts);
      ASSERT_EQ(texts_of(asked.agenda()), seen[i].agenda);
      ASSERT_EQ(asked.focus(), seen[i].focus);
      ASSERT_EQ(texts_of_globals(asked.globals()), seen[i].globals);
      facts += found.size();
      waiting += seen[i].agenda.size();
    }
  }
  EXPECT_GT(facts, times_.size() * 50);
  RecordProperty("facts", static_cast<int>(facts));
  RecordProperty("activations", static_cast<int>(waiting));
}

/// With all that changed them, and who did.
void AnswersTest::compare_facts_with_the_journal() {
  begin();
  for (const SimTime t : times_)
    for (const inspect::Inspector& asked : inspectors_at(t)) {
      SCOPED_TRACE(asked.name() + " at " + std::to_string(to_seconds(t)) + " s");
      const Ledger& journal = ledger_of(asked.name());
      const auto answer = asked.facts("");
      ASSERT_TRUE(answer);
      Facts found;
      for (const inspect::FactHistory& one : *answer) {
        put(found, one.fact);
        std::vector<std::uint64_t> changes;
        for (const inspect::FactChange& change : one.changes) {
          changes.push_back(change.n);
          const Ledger::Entry& entry = journal.entry(change.n);
          ASSERT_EQ(change.t, entry.t);
          std::set<std::string> rules;
          for (const std::uint64_t cause : entry.own)
            if (journal.entry(cause).kind == RecordKind::kFire) rules.insert(journal.entry(cause).rule);
          ASSERT_EQ(change.by.kind == Doer::Kind::kRule ? std::set{change.by.name} : std::set<std::string>(), rules);
        }
        ASSERT_EQ(changes, journal.changes(static_cast<std::int64_t>(one.fact.number)));
      }
      ASSERT_EQ(found, journal.facts());
    }
}

/// The steps of a derivation are the records of the journal with all their causes, and end outside of the rules.
void AnswersTest::compare_why_with_the_journal() {
  begin();
  std::mt19937 chance(35);
  std::map<std::string, SimTime> outside;  // records of other streams, with their times
  auto everything = JournalReader::open(path("run/journal.jsonl"));
  ASSERT_TRUE(everything);
  for (auto record = everything->next(); record && *record; record = everything->next())
    if (!(*record)->stream.starts_with("env/"))
      outside[(*record)->stream + ':' + std::to_string((*record)->n)] = (*record)->t;

  std::size_t steps = 0, from_outside = 0;
  for (const SimTime t : times_) {
    const auto inspectors = inspectors_at(t);
    const inspect::Inspector& asked = inspectors[chance() % inspectors.size()];
    const Ledger& journal = ledger_of(asked.name());
    // An existing fact, and any change of a fact, which may be retracted.
    const auto facts = asked.engine().facts();
    ASSERT_FALSE(facts.empty());
    const FactCopy& fact = facts[chance() % facts.size()];
    const auto found = asked.why("f-" + std::to_string(fact.index));
    ASSERT_TRUE(found) << found.error().text();
    ASSERT_EQ(found->steps.front().n, journal.changes(static_cast<std::int64_t>(fact.number)).back());
    ASSERT_EQ(found->steps.front().text, as_recorded(fact.print()));
    const auto some =
        std::next(journal.all_changes().begin(), static_cast<std::ptrdiff_t>(chance() % journal.all_changes().size()));
    for (const Derivation& derivation : {*found, asked.why(some->second[chance() % some->second.size()])}) {
      SCOPED_TRACE(derivation.steps.front().text + " at " + std::to_string(to_seconds(t)) + " s");
      std::set<std::uint64_t> known;
      for (const Derivation::Step& step : derivation.steps) {
        const Ledger::Entry& entry = journal.entry(step.n);
        ASSERT_EQ(step.t, entry.t);
        ASSERT_EQ(step.kind, entry.kind);
        ASSERT_TRUE(known.insert(step.n).second);
        std::set<std::uint64_t> because;
        for (const std::size_t i : step.because) because.insert(derivation.steps[i].n);
        ASSERT_EQ(because, entry.own) << step.text;
        ASSERT_EQ(step.outside ? std::set{*step.outside} : std::set<std::string>(), entry.outside) << step.text;
        if (step.kind == RecordKind::kFire) {
          ASSERT_EQ(step.text, entry.rule);
        }
        if (step.outside) {
          ASSERT_TRUE(outside.contains(*step.outside)) << *step.outside;
          ASSERT_LE(outside.at(*step.outside), step.t);
          ++from_outside;
        } else if (step.because.empty()) {
          ASSERT_TRUE(step.kind == RecordKind::kInput || !step.note.empty()) << step.text;
        }
      }
      steps += derivation.steps.size();
    }
  }
  EXPECT_GT(steps, times_.size() * 4);
  EXPECT_GT(from_outside, times_.size() / 4);
  RecordProperty("steps", static_cast<int>(steps));
}

/// The text of the first conditions of a rule.
std::string probe_of(const ConstructInfo& rule, const std::vector<explain::Condition>& conditions, std::size_t count) {
  std::string text = "(defrule " + rule.module + "::cxlab-probe";
  for (std::size_t i = 0; i < count; ++i) text += ' ' + conditions[i].text;
  return text + " =>)";
}

/// Rules that have the first conditions of a rule and no others: CLIPS says which of them would fire.
void AnswersTest::compare_why_not_with_clips() {
  begin();
  std::mt19937 chance(36);
  std::size_t held = 0, not_held = 0;
  for (const SimTime t : times_) {
    for (const inspect::Inspector& asked : inspectors_at(t)) {
      RuleEngine& engine = asked.engine();
      const auto there_before = engine.facts("time").size();
      asked.assert_time();
      std::vector<ConstructInfo> rules;
      for (const ConstructInfo& one : engine.constructs())
        if (one.kind == "defrule" && engine.acting_call(one).empty()) rules.push_back(one);
      for (int picked = 0; picked < 4; ++picked) {
        const ConstructInfo& rule = rules[chance() % rules.size()];
        SCOPED_TRACE(rule.name + " at " + std::to_string(to_seconds(t)) + " s");
        const auto conditions = explain::conditions_of(rule.text, rule.file, rule.line);
        ASSERT_TRUE(conditions);
        std::size_t first = 1;
        for (; first <= conditions->size(); ++first) {
          const Status built = engine.build(probe_of(rule, *conditions, first));
          ASSERT_TRUE(built) << built.error().text();
          const auto agenda = engine.agenda();
          const bool holds = std::ranges::any_of(agenda, [](const auto& a) { return a.rule == "cxlab-probe"; });
          ASSERT_TRUE(engine.undefine("defrule", rule.module + "::cxlab-probe"));
          if (!holds) break;
        }
        const auto unmet = explain::unmet_condition(engine, rule);
        if (first > conditions->size()) {
          ASSERT_FALSE(unmet) << unmet->print();
          ++held;
        } else {
          ASSERT_TRUE(unmet) << (*conditions)[first - 1].text;
          ASSERT_EQ(static_cast<std::size_t>(unmet->number), first) << unmet->print();
          ++not_held;
        }
      }
      if (there_before == 0)
        for (const FactCopy& time : engine.facts("time")) engine.retract(time.index);
    }
  }
  EXPECT_GT(not_held, times_.size());
  RecordProperty("held", static_cast<int>(held));
  RecordProperty("not held", static_cast<int>(not_held));
}

TEST_P(AnswersTest, AgreeWithTheGame) {
  for (const auto compare :
       {&AnswersTest::compare_facts_with_what_was_seen, &AnswersTest::compare_facts_with_the_journal,
        &AnswersTest::compare_why_with_the_journal, &AnswersTest::compare_why_not_with_clips})
    ASSERT_NO_FATAL_FAILURE((this->*compare)());
}

INSTANTIATE_TEST_SUITE_P(Games, AnswersTest,
                         testing::Combine(testing::Values("game.yaml", "planning.yaml"),
                                          testing::Values("timed", "physics")),
                         [](const auto& game) {
                           const std::string& file = std::get<0>(game.param);
                           return file.substr(0, file.find('.')) + '_' + std::get<1>(game.param);
                         });

}  // namespace
}  // namespace cxlab::lab
