// What a timeline keeps is what the journal wrote, and each fact is as its changes left it.

#include "cx/inspect/timeline.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "cx/engine/engine.h"
#include "cx/explain/fact_record.h"
#include "cx/journal/journal.h"

namespace cxlab::inspect {
namespace {

using testing::ElementsAreArray;
using testing::IsEmpty;

constexpr const char* kRules = R"(
(deftemplate job (slot id) (slot state (default OPEN)) (multislot log))
(deffacts jobs (job (id 1)) (job (id 2)) (count 0))
(defrule begin (go ?) ?j <- (job (state OPEN)) => (modify ?j (state BUSY) (log started)))
(defrule end (go ?now) ?j <- (job (id ?i) (state BUSY)) => (modify ?j (state DONE) (log started "at" ?now)) (assert (done ?i)))
(defrule clear ?d <- (done ?i) ?j <- (job (id ?i)) ?c <- (count ?n) => (retract ?d ?j ?c) (assert (count (+ ?n 1))))
(defrule again ?g <- (go ?) (not (job)) => (retract ?g) (assert (job (id 7))))
)";

/// All records of the environment, as the journal gave them.
class Copies final : public JournalListener {
 public:
  bool wants(std::string_view stream, RecordKind) const override { return stream == "env/main"; }
  void heard(const JournalRecord& record) override { records.push_back(record); }
  std::vector<JournalRecord> records;
};

/// A run of these rules, each second with a fact more.
struct Game {
  explicit Game(const std::string& rules = kRules, int seconds = 3) {
    journal.observe(timelines);
    journal.observe(copies);
    SimTime now{};
    EngineOptions options;
    options.journal = &journal;
    options.now = [&now] { return now; };
    const auto engine = *RuleEngine::create(std::move(options));
    const LoadReport loaded = engine->load_text(rules, "rules.clp", LoadMode::kConstructs);
    EXPECT_TRUE(loaded.ok()) << loaded.status().error().text();
    engine->reset();
    for (int i = 1; i <= seconds; ++i) {
      now = from_seconds(i);
      EXPECT_TRUE(engine->assert_string("(go " + std::to_string(i) + ")").ok());
      EXPECT_THAT(engine->run().errors, IsEmpty());
    }
  }
  const Timeline& timeline() { return timelines.of("env/main"); }
  const std::vector<JournalRecord>& records() const { return copies.records; }

  Timelines timelines;
  Copies copies;
  Journal journal;
};

RecordData nothing() {
  RecordData data;
  data.begin();
  return data;
}

bool is_about_a_fact(const JournalRecord& r) { return r.data.find("fact") && r.data.find("template"); }

TEST(Timeline, ARecordIsReadAsItWasWritten) {
  Game run;
  // Causes in streams of others, and a last record that has some.
  const RecordRef from =
      run.journal.write(run.journal.open_stream("node/box"), from_seconds(4), RecordKind::kInput, nothing());
  const StreamId main = run.journal.open_stream("env/main");
  const RecordRef first = run.journal.write(main, from_seconds(4), RecordKind::kInput, nothing(), std::vector{from});
  run.journal.write(main, from_seconds(5), RecordKind::kInput, nothing(), std::vector{first, from});

  const Timeline& timeline = run.timeline();
  ASSERT_EQ(timeline.end() - timeline.begin(), run.records().size());
  EXPECT_FALSE(timeline.has(timeline.end()));
  std::vector<std::uint64_t> firings;
  std::size_t causes = 0;
  for (const JournalRecord& r : run.records()) {
    ASSERT_TRUE(timeline.has(r.n));
    const JournalRecord read = timeline.read(r.n);
    EXPECT_EQ(read.stream, "env/main");
    EXPECT_EQ(read.n, r.n);
    EXPECT_EQ(read.t, r.t);
    EXPECT_EQ(read.kind, r.kind);
    EXPECT_TRUE(read.data == r.data) << r.n;
    EXPECT_EQ(read.causes, r.causes) << r.n;
    causes += r.causes.size();
    EXPECT_EQ(timeline.fact(r.n), is_about_a_fact(r) ? r.data.integer("fact") : 0);
    EXPECT_EQ(timeline.name(r.n), r.kind == RecordKind::kFire ? r.data.text("rule")
                                  : is_about_a_fact(r)        ? r.data.text("template")
                                                              : "");
    if (r.kind == RecordKind::kFire) firings.push_back(r.n);
  }
  EXPECT_GT(causes, run.records().size() / 2);
  EXPECT_EQ(timeline.firings(), firings);
}

TEST(Timeline, AFactIsAsEachOfItsChangesLeftItInWhateverOrderOneAsks) {
  Game run;
  std::map<std::uint64_t, std::string> expected;  // by record
  std::map<std::int64_t, std::vector<std::uint64_t>> changes;
  std::map<std::int64_t, FactCopy> facts;
  for (const JournalRecord& r : run.records()) {
    if (!is_about_a_fact(r)) continue;
    FactCopy& fact = facts[r.data.integer("fact")];
    if (r.kind == RecordKind::kAssert) fact = {};
    if (r.kind != RecordKind::kRetract) explain::apply(r, fact);
    expected[r.n] = fact.print();
    changes[r.data.integer("fact")].push_back(r.n);
  }
  ASSERT_TRUE(std::ranges::any_of(changes, [](const auto& c) { return c.second.size() == 4; }));
  for (const auto& [fact, records] : changes) EXPECT_THAT(run.timeline().changes(fact), ElementsAreArray(records));
  EXPECT_THAT(run.timeline().changes(999), IsEmpty());
  std::vector<std::uint64_t> order;
  for (const auto& [n, text] : expected) order.push_back(n);
  for (unsigned seed = 0; seed < 20; ++seed) {
    Game asked;
    std::ranges::shuffle(order, std::mt19937(seed));
    for (const std::uint64_t n : order)
      ASSERT_EQ(asked.timeline().fact_after(n).print(), expected[n]) << n << ' ' << seed;
  }
}

TEST(Timeline, TheEndOfATimeIsBehindAllThatHappenedUpToIt) {
  Game run;
  for (const double t : {-1.0, 0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 9.0}) {
    const auto up_to =
        std::ranges::count_if(run.records(), [&](const JournalRecord& r) { return r.t <= from_seconds(t); });
    EXPECT_EQ(run.timeline().end_of(from_seconds(t)), run.timeline().begin() + static_cast<std::uint64_t>(up_to)) << t;
  }
}

TEST(Timeline, RecordsOfTwoRunsAreTheSameWhereTheyDifferInNothing) {
  Game one, other, late(kRules, 4);
  for (const JournalRecord& r : one.records()) {
    EXPECT_TRUE(one.timeline().same(r.n, other.timeline())) << r.n;
    EXPECT_TRUE(one.timeline().same(r.n, late.timeline())) << r.n;
  }
  const auto differ = [](SimTime t, RecordKind kind, int value, const char* stream, int causes) {
    auto run = std::make_unique<Game>(kRules, 0);
    std::vector<RecordRef> from;
    for (int i = 0; i < 3; ++i)
      from.push_back(run->journal.write(run->journal.open_stream(stream), SimTime{}, RecordKind::kInput, nothing()));
    from.resize(static_cast<std::size_t>(causes));
    RecordData data;
    data.begin().field("value", value);
    run->journal.write(run->journal.open_stream("env/main"), t, kind, data, from);
    return run;
  };
  const SimTime t = from_seconds(1);
  const auto whole = differ(t, RecordKind::kInput, 1, "node/a", 2);
  const std::uint64_t n = whole->timeline().end() - 1;
  const auto is_same = [&](const std::unique_ptr<Game>& run) { return whole->timeline().same(n, run->timeline()); };
  EXPECT_TRUE(is_same(differ(t, RecordKind::kInput, 1, "node/a", 2)));
  EXPECT_FALSE(is_same(differ(t + SimTime{1}, RecordKind::kInput, 1, "node/a", 2))) << "another time";
  EXPECT_FALSE(is_same(differ(t, RecordKind::kError, 1, "node/a", 2))) << "another kind";
  EXPECT_FALSE(is_same(differ(t, RecordKind::kInput, 2, "node/a", 2))) << "other data";
  EXPECT_FALSE(is_same(differ(t, RecordKind::kInput, 1, "node/b", 2))) << "causes of another stream";
  EXPECT_FALSE(is_same(differ(t, RecordKind::kInput, 1, "node/a", 1))) << "a cause less";
  EXPECT_FALSE(is_same(differ(t, RecordKind::kInput, 1, "node/a", 3))) << "a cause more";
}

TEST(Timelines, TheStartIsWhatCameBeforeTheFirstTickAndOnlyForEnvironmentsThatWereThere) {
  Game run(kRules, 0);
  const std::uint64_t started = run.timeline().end();
  EXPECT_TRUE(run.timeline().is_of_start(started)) << "nothing has begun yet";
  run.timelines.start_is_over();
  const auto write = [&run](const char* stream) {
    return run.journal.write(run.journal.open_stream(stream), from_seconds(1), RecordKind::kInput, nothing()).n;
  };
  EXPECT_EQ(write("env/main"), started);
  EXPECT_TRUE(run.timeline().is_of_start(started - 1));
  EXPECT_FALSE(run.timeline().is_of_start(started));
  const std::uint64_t later = write("env/later");
  EXPECT_FALSE(run.timelines.of("env/later").is_of_start(later));
}

}  // namespace
}  // namespace cxlab::inspect
