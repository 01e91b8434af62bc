// What the engine writes into the journal, with causes.

#include "tests/support/engine_test.h"

namespace cxlab {
namespace {

using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

struct EngineJournal : EngineTest {
  void SetUp() override {
    EngineOptions o = options();
    o.journal = &sink;
    engine_ = make(std::move(o));
  }
  std::vector<std::uint64_t> causes(const KeptRecords::Record& record) {
    std::vector<std::uint64_t> list;
    for (const RecordRef& cause : record.causes) list.push_back(cause.n);
    return list;
  }
  KeptRecords sink;
};

TEST_F(EngineJournal, ADeliveryCausesAFactThatCausesAFiringThatCausesAFact) {
  given(
      "(deftemplate order (slot id) (slot state (default OPEN)))\n"
      "(defrule take ?o <- (order (id ?id) (state OPEN)) (idle) => (modify ?o (state TAKEN)) (assert (took ?id)))");
  EXPECT_THAT(sink.names(), ElementsAre("env/main"));
  now = from_seconds(2);
  engine().set_cause({StreamId{5}, 77});
  ASSERT_TRUE(engine().assert_fact("order", {{"id", Value::string("O1")}}).ok());  // record 0
  engine().clear_cause();
  ASSERT_TRUE(engine().assert_string("(idle)").ok());  // record 1
  engine().run();                                      // fire 2, modify 3, assert 4

  ASSERT_THAT(sink.all(), SizeIs(5));
  EXPECT_EQ(sink.all()[0].kind, RecordKind::kAssert);
  EXPECT_EQ(sink.all()[0].t, from_seconds(2));
  EXPECT_THAT(causes(sink.all()[0]), ElementsAre(77));
  EXPECT_THAT(sink.all()[0].data, HasSubstr("\"O1\"")) << "strings keep their quotes, symbols have none";
  EXPECT_THAT(causes(sink.all()[1]), IsEmpty());
  EXPECT_EQ(sink.all()[2].kind, RecordKind::kFire);
  EXPECT_THAT(causes(sink.all()[2]), ElementsAre(0, 1));
  EXPECT_EQ(sink.all()[3].kind, RecordKind::kModify);
  EXPECT_THAT(causes(sink.all()[3]), ElementsAre(2));
  EXPECT_THAT(sink.all()[3].data, HasSubstr("TAKEN"));
  EXPECT_THAT(sink.all()[3].data, Not(HasSubstr("O1"))) << "only what has changed";
  EXPECT_EQ(sink.all()[4].kind, RecordKind::kAssert);
  EXPECT_THAT(causes(sink.all()[4]), ElementsAre(2));
}

TEST_F(EngineJournal, OfSeveralCausesEachIsNamed) {
  const RecordRef both[] = {{StreamId{5}, 1}, {StreamId{5}, 2}};
  engine().set_cause({StreamId{5}, 3});
  ASSERT_TRUE(engine().assert_string("(a)").ok());
  engine().set_cause(both);
  ASSERT_TRUE(engine().assert_string("(b)").ok());
  engine().set_cause({StreamId{5}, 4});
  ASSERT_TRUE(engine().assert_string("(c)").ok());
  engine().clear_cause();
  ASSERT_TRUE(engine().assert_string("(d)").ok());
  ASSERT_THAT(sink.all(), SizeIs(4));
  EXPECT_THAT(causes(sink.all()[0]), ElementsAre(3));
  EXPECT_THAT(causes(sink.all()[1]), ElementsAre(1, 2));
  EXPECT_THAT(causes(sink.all()[2]), ElementsAre(4));
  EXPECT_THAT(causes(sink.all()[3]), IsEmpty());
}

TEST_F(EngineJournal, ValuesAreWrittenByTheirTypes) {
  given("(deftemplate all (slot a) (slot b) (slot c) (slot d) (multislot e))");
  ASSERT_TRUE(engine().assert_string("(all (a [i]) (b \"te\\\"xt\") (c word) (d -2) (e 1.5 [j] \"s\"))").ok());
  using std::string_view_literals::operator""sv;
  RecordData expected;
  expected.begin().field("fact", 1).field("template", "all").name("slots").open_map(5);
  expected.text_key("a").value("[i]"sv).text_key("b").value("\"te\"xt\""sv).text_key("c").value("word"sv);
  expected.text_key("d").value(std::int64_t{-2}).text_key("e").open_list(3).value(1.5).value("[j]"sv).value("\"s\""sv);
  ASSERT_THAT(sink.all(), SizeIs(1));
  EXPECT_EQ(sink.all()[0].data, expected.bytes());
}

TEST_F(EngineJournal, AFiringOnAChangedFactIsCausedByTheChange) {
  given("(deftemplate order (slot state))\n(defrule done (order (state DONE)) =>)");
  const auto index = engine().assert_fact("order", {{"state", Value::symbol("OPEN")}});
  const RuleEngine::Slot done[] = {{"state", Value::symbol("DONE")}};
  ASSERT_TRUE(engine().modify_fact(*index, done).ok());
  engine().run();
  ASSERT_THAT(sink.of(RecordKind::kFire), SizeIs(1));
  EXPECT_THAT(causes(sink.of(RecordKind::kFire)[0]), ElementsAre(1));
}

TEST_F(EngineJournal, AFactDecisionIsARecordOfItsOwnKind) {
  given("(deftemplate decision (slot what))\n(deftemplate decisions (slot what))");
  const auto index = engine().assert_fact("decision", {{"what", Value::symbol("wait")}});
  ASSERT_TRUE(engine().assert_fact("decisions", {{"what", Value::symbol("wait")}}).ok());
  const RuleEngine::Slot go[] = {{"what", Value::symbol("go")}};
  ASSERT_TRUE(engine().modify_fact(*index, go).ok());
  EXPECT_THAT(sink.of(RecordKind::kDecision), SizeIs(1));
  EXPECT_THAT(sink.of(RecordKind::kAssert), SizeIs(1));
  EXPECT_THAT(sink.of(RecordKind::kModify), SizeIs(1));
}

TEST_F(EngineJournal, NumbersOfFactsGoOnAfterAReset) {
  given("(deffacts f (a) (b))");
  engine().reset();
  engine().reset();
  const std::vector<FactCopy> facts = engine().facts();
  ASSERT_THAT(facts, SizeIs(2));
  EXPECT_EQ(facts[0].index, 1);
  EXPECT_EQ(facts[0].number, 3u);
  EXPECT_THAT(sink.of(RecordKind::kRetract), SizeIs(2));
}

TEST_F(EngineJournal, AModifyIntoADuplicateIsARetract) {
  given("(deftemplate order (slot id))");
  const auto first = engine().assert_fact("order", {{"id", Value::integer(1)}});
  ASSERT_TRUE(engine().assert_fact("order", {{"id", Value::integer(2)}}).ok());
  const RuleEngine::Slot two[] = {{"id", Value::integer(2)}};
  ASSERT_TRUE(engine().modify_fact(*first, two).ok());
  EXPECT_THAT(fact_texts(), ElementsAre("(order (id 2))"));
  EXPECT_THAT(sink.of(RecordKind::kModify), IsEmpty());
  EXPECT_THAT(sink.of(RecordKind::kRetract), SizeIs(1));
}

TEST_F(EngineJournal, AnAddressOfARetractedFactIsWrittenAsFactZero) {
  given("(deffunction keep (?f) (assert (there ?f)) (retract ?f) (assert (gone ?f)))");
  ASSERT_TRUE(engine().eval("(keep (assert (a)))").ok());
  const auto asserted = sink.of(RecordKind::kAssert);
  ASSERT_THAT(asserted, SizeIs(3));
  EXPECT_THAT(asserted[1].data, EndsWith(std::string("fact\1", 5)));
  EXPECT_THAT(asserted[2].data, EndsWith(std::string("fact\0", 5)));
}

TEST_F(EngineJournal, ErrorsAreRecordsCausedByTheFiring) {
  given("(deffacts f (a 0))\n(defrule bad (a ?x) => (/ 1 ?x))");
  engine().reset();
  engine().run();
  ASSERT_THAT(sink.of(RecordKind::kError), SizeIs(1));
  EXPECT_THAT(sink.of(RecordKind::kError)[0].data, HasSubstr("PRNTUTIL7"));
}

TEST_F(EngineJournal, AFunctionSeesTheFiringAsItsCause) {
  std::vector<RecordRef> seen;
  ASSERT_TRUE(engine()
                  .add_function({.name = "publish"},
                                [&](Call& call) {
                                  const auto cause = call.engine().cause();
                                  seen.assign(cause.begin(), cause.end());
                                })
                  .ok());
  given("(deffacts f (a))\n(defrule go (a) => (publish))");
  engine().reset();
  engine().run();
  ASSERT_THAT(seen, SizeIs(1));
  EXPECT_EQ(seen[0].n, 1u);
  EXPECT_EQ(sink.all()[1].kind, RecordKind::kFire);
}

// The same rules in two environments of one process, with handles and gensyms: the same bytes.
TEST_F(EngineJournal, TheRecordsHoldNothingOfTheProcess) {
  const auto play = [&] {
    KeptRecords own;
    EngineOptions o = options();
    o.journal = &own;
    auto played = make(std::move(o));
    EXPECT_TRUE(played
                    ->add_function({.name = "handle", .returns = "e"},
                                   [](Call& call) { call.give_handle(call.engine().new_handle()); })
                    .ok());
    EXPECT_TRUE(played
                    ->load_text("(deffacts f (n 0))\n(deftemplate t (slot h) (slot g) (slot f))\n"
                                "(defrule go ?f <- (n ?n&:(< ?n 50)) => (assert (t (h (handle)) (g (gensym*)) (f ?f))) "
                                "(retract ?f) (assert (n (+ ?n 1))))\n"
                                "(defrule pair (t (h ?a) (g ?g)) (t (h ?b&~?a)) => (assert (pair ?a ?b)))",
                                "r.clp", LoadMode::kConstructs)
                    .ok());
    played->reset();
    played->run();
    std::string bytes;
    for (const auto& record : own.all()) bytes += record.data + "\n";
    return bytes;
  };
  const std::string first = play();
  const auto other = make(options());
  ASSERT_TRUE(other->assert_string("(some facts that move the memory of CLIPS)").ok());
  EXPECT_EQ(play(), first);
  EXPECT_GT(first.size(), 50000u);
}

}  // namespace
}  // namespace cxlab
