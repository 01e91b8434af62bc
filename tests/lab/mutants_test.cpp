#include "lab/mutants.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "cx/engine/form_reader.h"

namespace cxlab::lab {
namespace {

constexpr const char* kTemplates =
    "(deftemplate door (slot name) (slot state (allowed-symbols CLOSED LOCKED OPEN)) (slot width))\n";

std::vector<Mutant> mutants_in(const std::string& text) {
  return mutants_of({{"templates.clp", kTemplates, false}, {"a.clp", text}});
}

/// "change: what", sorted.
std::vector<std::string> changes_of(const std::string& text) {
  std::vector<std::string> out;
  for (const Mutant& mutant : mutants_in(text))
    out.push_back(std::string(to_string(mutant.change)) + ": " + mutant.what());
  std::ranges::sort(out);
  return out;
}

using Changes = std::vector<std::string>;

TEST(Mutants, ConditionIsDroppedAndNegated) {
  EXPECT_EQ(changes_of("(defrule r \"What it is for.\" (bell) (lamp) => (halt))"),
            (Changes{"action: without (halt)", "condition: without (bell)", "condition: without (lamp)",
                     "negation: (bell) -> (not (bell))", "negation: (lamp) -> (not (lamp))"}));
}

TEST(Mutants, FactOfAVariableIsDroppedWithItsVariable) {
  EXPECT_EQ(changes_of("(defrule r ?b <- (bell) => (retract ?b))"),
            (Changes{"action: without (retract ?b)", "condition: without ?b <- (bell)"}));
}

TEST(Mutants, GroupsOfConditions) {
  EXPECT_EQ(changes_of("(defrule r (not (bell)) => (halt))"),
            (Changes{"action: without (halt)", "condition: without (not (bell))", "negation: (bell) -> (not (bell))",
                     "negation: (not (bell)) -> (bell)"}));
  const Changes group = changes_of("(defrule r (exists (or (bell) (lamp))) => (halt))");
  for (const char* change : {"connective: (or (bell) (lamp)) -> (and (bell) (lamp))", "condition: without (lamp)",
                             "negation: (exists (or (bell) (lamp))) -> (not (or (bell) (lamp)))"})
    EXPECT_EQ(std::ranges::count(group, change), 1) << change;
}

TEST(Mutants, ValuesOfASlotAreOthersOfThatSlot) {
  EXPECT_EQ(
      changes_of("(defrule r (door (state OPEN|LOCKED)) => (halt))"),
      (Changes{"action: without (halt)", "condition: without (door (state OPEN|LOCKED))",
               "constraint: (state OPEN|LOCKED) -> (state LOCKED)", "constraint: (state OPEN|LOCKED) -> (state OPEN)",
               "negation: (door (state OPEN|LOCKED)) -> (not (door (state OPEN|LOCKED)))",
               "symbol: (state OPEN|LOCKED) -> (state CLOSED|LOCKED)",
               "symbol: (state OPEN|LOCKED) -> (state OPEN|CLOSED)"}));
}

TEST(Mutants, ConstraintsOfASlot) {
  const Changes changes = changes_of("(defrule r (door (name ?n) (state ?s&~OPEN) (width 12)) (seen ?n ?s) => (halt))");
  const Changes expected{
      "constraint: (door (name ?n) (state ?s&~OPEN) (width 12)) -> (door (name ?n) (state ?s&~OPEN))",
      "constraint: (door (name ?n) (state ?s&~OPEN) (width 12)) -> (door (state ?s&~OPEN) (width 12))",
      "constraint: (seen ?n ?s) -> (seen ? ?s)",
      "constraint: (seen ?n ?s) -> (seen ?n ?)",
      "constraint: (state ?s&~OPEN) -> (state ?s)",
      "negation: (state ?s&~OPEN) -> (state ?s&OPEN)",
      "negation: (width 12) -> (width ~12)",
      "number: (width 12) -> (width 24)",
      "symbol: (state ?s&~OPEN) -> (state ?s&~CLOSED)"};
  for (const std::string& change : expected) EXPECT_EQ(std::ranges::count(changes, change), 1) << change;
  EXPECT_EQ(std::ranges::count_if(changes, [](const auto& c) { return c.starts_with("constraint"); }), 5);
}

TEST(Mutants, VariableThatStandsOnceDemandsNothing) {
  for (const std::string& change : changes_of("(defrule r (door (name ?n)) (seen ?m) => (halt))"))
    EXPECT_FALSE(change.starts_with("constraint")) << change;
}

TEST(Mutants, DroppedAlternativeAfterAVariableKeepsTheVariable) {
  const Changes changes = changes_of("(defrule r (door (state ?s&OPEN|CLOSED)) => (printout t ?s crlf))");
  EXPECT_EQ(std::ranges::count(changes, "constraint: (state ?s&OPEN|CLOSED) -> (state ?s&CLOSED)"), 1);
  EXPECT_EQ(std::ranges::count(changes, "constraint: (state ?s&OPEN|CLOSED) -> (state ?s&OPEN)"), 1);
}

struct Expression {
  const char* text;
  Changes changes;  ///< but for actions
};

TEST(Mutants, Expressions) {
  const Expression table[] = {
      {"(< ?x 3)",
       {"comparison: (< ?x 3) -> (<= ?x 3)", "comparison: (< ?x 3) -> (>= ?x 3)", "number: (< ?x 3) -> (< ?x 4)"}},
      {"(>= ?x ?y)", {"comparison: (>= ?x ?y) -> (< ?x ?y)", "comparison: (>= ?x ?y) -> (> ?x ?y)"}},
      {"(eq ?x TRUE)", {"comparison: (eq ?x TRUE) -> (neq ?x TRUE)", "symbol: (eq ?x TRUE) -> (eq ?x FALSE)"}},
      {"(eq ?x LOCKED)", {"comparison: (eq ?x LOCKED) -> (neq ?x LOCKED)", "symbol: (eq ?x LOCKED) -> (eq ?x OPEN)"}},
      {"(eq ?x what)", {"comparison: (eq ?x what) -> (neq ?x what)", "symbol: (eq ?x what) -> (eq ?x not-what)"}},
      {"(+ ?x 2.5)", {"arithmetic: (+ ?x 2.5) -> (- ?x 2.5)", "number: (+ ?x 2.5) -> (+ ?x 5.0)"}},
      {"(+ ?x 0.0)", {"arithmetic: (+ ?x 0.0) -> (- ?x 0.0)", "number: (+ ?x 0.0) -> (+ ?x 1.0)"}},
      {"(- ?x -30)", {"arithmetic: (- ?x -30) -> (+ ?x -30)", "number: (- ?x -30) -> (- ?x -60)"}},
      {"(and ?a (ready ?b))",
       {"connective: (and ?a (ready ?b)) -> (or ?a (ready ?b))", "negation: (ready ?b) -> (not (ready ?b))"}},
      {"(not (ready ?b))", {"negation: (not (ready ?b)) -> (ready ?b)"}},
      {"(max ?a ?b)", {"arithmetic: (max ?a ?b) -> (min ?a ?b)"}},
      {"(str-cat ?a \"-IN\")", {"symbol: (str-cat ?a \"-IN\") -> (str-cat ?a \"\")"}},
      {"(any-factp ((?d door)) (eq ?d:name ?a))", {"comparison: (eq ?d:name ?a) -> (neq ?d:name ?a)"}},
      {"(fact-slot-value ?f state)", {}},
      {"(format nil \"%d\" ?a)", {}},
      {"(printout t \"a\" 3 crlf)", {}},
      {"(modify ?d (state OPEN) (width 1))",
       {"number: (width 1) -> (width 2)", "slot: without (state OPEN)", "slot: without (width 1)",
        "symbol: (state OPEN) -> (state CLOSED)"}},
      {"(assert (door (state OPEN)) (bell 1))",
       {"number: (bell 1) -> (bell 2)", "symbol: (state OPEN) -> (state CLOSED)"}},
  };
  for (const Expression& row : table) {
    Changes found;
    for (const std::string& change : changes_of(std::string("(deffunction f (?x ?y ?a ?b ?d ?f) ") + row.text + ")"))
      if (!change.starts_with("action")) found.push_back(change);
    EXPECT_EQ(found, row.changes) << row.text;
  }
}

TEST(Mutants, ActionsOfBranchesAreDropped) {
  EXPECT_EQ(changes_of("(deffunction f (?x) (if (ready ?x) then (one) else (two) (three)) (four))"),
            (Changes{"action: without (four)", "action: without (if (ready ?x) then (one) else (two) (three))",
                     "action: without (one)", "action: without (three)", "action: without (two)",
                     "negation: (ready ?x) -> (not (ready ?x))"}));
}

TEST(Mutants, SalienceIsTurnedRound) {
  const Changes changes = changes_of(
      "(defrule r (declare (salience 10)) (bell) => (halt))\n"
      "(defrule s (declare (salience ?*LATE*)) (bell) => (halt))");
  EXPECT_EQ(std::ranges::count(changes, "salience: (salience 10) -> (salience -10)"), 1);
  EXPECT_EQ(std::ranges::count(changes, "salience: (salience ?*LATE*) -> (salience (- 0 ?*LATE*))"), 1);
}

TEST(Mutants, GlobalsAreChangedByThemselves) {
  const std::vector<Mutant> mutants = mutants_in("(defglobal ?*A* = 1 ?*B* = (* 2 ?*A*))");
  ASSERT_EQ(mutants.size(), 3u);
  EXPECT_EQ(mutants[0].construct, "?*A*");
  EXPECT_EQ(mutants[1].construct, "?*B*");
}

TEST(Mutants, CommentsSpareLinesRulesAndReports) {
  EXPECT_EQ(changes_of("(defrule r\n  (bell) ; mutate: skip\n  ; mutate: skip - the other agent needs it\n  (lamp)\n  "
                       "=>\n  (halt))"),
            (Changes{"action: without (halt)"}));
  EXPECT_TRUE(changes_of("; mutate: skip\n; for people\n(defrule r (bell) => (halt))").empty());
  EXPECT_EQ(
      changes_of("(deffunction tell (?x) (assert (told 1))) ; mutate: skip\n(defrule r (bell) => (tell 3) (halt))"),
      (Changes{"action: without (halt)", "condition: without (bell)", "negation: (bell) -> (not (bell))"}));
  EXPECT_EQ(changes_of("(deffunction f () (g \"; mutate: skip\"))"),
            (Changes{"symbol: (g \"; mutate: skip\") -> (g \"\")"}));
}

TEST(Mutants, ActionsAreThoseBehindTheArrow) {
  for (const Mutant& mutant : mutants_in("(defrule r (bell 1) => (assert (a 1)))"))
    EXPECT_EQ(mutant.acts, mutant.before.find("(a 1)") != std::string::npos) << mutant.what();
  for (const Mutant& mutant : mutants_in("(deffunction f () (g 1) (h 2))")) EXPECT_FALSE(mutant.acts);
}

constexpr const char* kRules = R"(; the doors of the house
(defglobal ?*WAIT* = 10.0)
(deffunction late (?now ?since) (> (- ?now ?since) ?*WAIT*))
(defrule open "A bell rings: open."
  (declare (salience 5))
  ?b <- (bell ?n&~0)   ; (not this one)
  ?d <- (door (name ?n) (state CLOSED|LOCKED))
  (not (and (guard ?g) (awake ?g)))
  =>
  (retract ?b)
  (modify ?d (state OPEN) (width (+ ?n 1))))
(defrule slam (time ?t) (door (state OPEN) (width ?w)) (test (late ?t ?w)) => (assert (slammed)))
)";

TEST(Mutants, EachIsAnotherTextOfFormsWithANameOfItsOwn) {
  const std::vector<Mutant> mutants = mutants_in(kRules);
  std::set<std::string> texts, ids;
  for (const Mutant& mutant : mutants) {
    const std::string text = mutated(kRules, mutant);
    EXPECT_NE(text, kRules);
    EXPECT_TRUE(texts.insert(text).second) << mutant.what();
    EXPECT_TRUE(ids.insert(mutant.id).second) << mutant.what();
    const FormReading read = read_forms(text, "a.clp");
    EXPECT_TRUE(read.errors.empty()) << mutant.what();
    EXPECT_EQ(read.forms.size(), 4u) << mutant.what();
  }
  EXPECT_GT(mutants.size(), 30u);
}

TEST(Mutants, NamesStayWhereOtherPartsOfTheFileChange) {
  const std::string before = "(defrule a (bell) => (halt))\n", after = "(defrule b (lamp) => (halt) (halt))\n";
  std::set<std::string> alone, among;
  for (const Mutant& mutant : mutants_in(before)) alone.insert(mutant.id);
  for (const Mutant& mutant : mutants_in(after + '\n' + before)) among.insert(mutant.id);
  EXPECT_TRUE(std::ranges::includes(among, alone));
}

TEST(Mutants, DiffHasTheLinesAround) {
  const RuleText file{"a.clp", kRules};
  for (const Mutant& mutant : mutants_of({{"templates.clp", kTemplates, false}, file}))
    if (mutant.what() == "without (retract ?b)") {
      EXPECT_EQ(mutant.line, 10);
      EXPECT_EQ(diff_of(file, mutant),
                "--- a.clp\n+++ a.clp\n@@ -8,5 +8,5 @@ defrule open\n   (not (and (guard ?g) (awake ?g)))\n   =>\n"
                "-  (retract ?b)\n+  \n   (modify ?d (state OPEN) (width (+ ?n 1))))\n"
                " (defrule slam (time ?t) (door (state OPEN) (width ?w)) (test (late ?t ?w)) => (assert (slammed)))\n");
      return;
    }
  FAIL() << "no mutant drops (retract ?b)";
}

TEST(Mutants, RulesThatUseAFunctionOrGlobalAreFoundThroughOthers) {
  const std::vector<RuleText> files{{"a.clp", kRules}};
  for (const Mutant& mutant : mutants_of(files)) {
    const std::vector<std::string> expected =
        mutant.kind == "defrule" ? std::vector{mutant.construct} : std::vector<std::string>{"slam"};
    EXPECT_EQ(rules_that_use(files, mutant), expected) << mutant.what();
  }
}

TEST(Mutants, RulesThatUseAFunctionAreFoundWhereverItStands) {
  const std::vector<RuleText> files{{"a.clp",
                                     "(defrule first (x) => (outer))\n(deffunction outer () (middle))\n"
                                     "(deffunction middle () (inner))\n(deffunction inner () (+ 1 2))\n"
                                     "(defrule second (x) => (assert (y)))\n"}};
  int seen = 0;
  for (const Mutant& mutant : mutants_of(files)) {
    if (mutant.construct != "inner") continue;
    ++seen;
    EXPECT_EQ(rules_that_use(files, mutant), std::vector<std::string>{"first"}) << mutant.what();
  }
  EXPECT_GT(seen, 0);
}

}  // namespace
}  // namespace cxlab::lab
