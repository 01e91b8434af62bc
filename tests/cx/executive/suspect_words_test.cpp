// Mistakes in rules that CLIPS accepts silently: misspelt names, and constructs that replace others.

#include "tests/support/lab.h"

namespace cxlab::cx {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// The warnings of an agent with these rules, in one file.
std::vector<std::string> warnings_of(const std::string& rules) {
  Lab lab;
  lab.agent(rules);
  lab.run_up();
  std::vector<std::string> said;
  for (const Error& warning : lab.manager->warnings()) {
    EXPECT_EQ(lab.log.with(warning.text()).size(), 1u);
    said.push_back(std::to_string(warning.line) + ": " + warning.message);
  }
  return said;
}

constexpr const char* kJobs =
    "(deftemplate job (slot id) (slot step (default GO-FETCH)))\n"
    "(defrule fetch ?j <- (job (step GO-FETCH)) => (modify ?j (step FETCH)))\n"
    "(defrule put ?j <- (job (step FETCH)) => (modify ?j (step GO-PUT)))\n";

TEST(SuspectWords, ASymbolThatNothingGivesHasTheNearestName) {
  EXPECT_THAT(warnings_of(std::string(kJobs) + "(defrule late (job (step FECTH)) => )"),
              ElementsAre("4: nothing gives slot 'step' of 'job' the symbol FECTH, did you mean 'FETCH'?"));
  EXPECT_THAT(warnings_of(std::string(kJobs) + "(defrule late (job (step ~FECTH)) => )"),
              ElementsAre(HasSubstr("FECTH, did you mean 'FETCH'?")));
  EXPECT_THAT(warnings_of("(deftemplate a (slot state (allowed-symbols OPEN CLOSED)))\n(deftemplate b (slot state))\n"
                          "(deffacts f (b (state WAITING)))\n(defrule r (b (state\nWAITNG)) =>)"),
              ElementsAre("5: nothing gives slot 'state' of 'b' the symbol WAITNG, did you mean 'WAITING'?"));
}

TEST(SuspectWords, SymbolsThatMayComeFromOutsideAreLeftAlone) {
  EXPECT_THAT(warnings_of(kJobs), IsEmpty());
  // Not near, short, of a family, given by a call, a text or a test.
  EXPECT_THAT(warnings_of(std::string(kJobs) + "(defrule a (job (step EXPLORE)) =>) (defrule b (job (step FET)) =>)"),
              IsEmpty());
  EXPECT_THAT(warnings_of("(deftemplate ring (slot colour))\n(deffacts f (ring (colour RING-1)))\n"
                          "(defrule a (ring (colour RING-2)) =>)"),
              IsEmpty());
  EXPECT_THAT(warnings_of(std::string(kJobs) + "(deffunction next () FETCHED)\n(defrule a (job (step FETCHED)) =>)"),
              IsEmpty());
  EXPECT_THAT(
      warnings_of(std::string(kJobs) +
                  "(defrule more => (assert-string \"(job (step FETCHED))\"))\n(defrule a (job (step FETCHED)) =>)"),
      IsEmpty());
}

TEST(SuspectWords, AnOrderedFactThatNobodyReadsHasTheNearestName) {
  const std::string reads = "(defrule begin (chosen ?id) => (println ?id))\n";
  EXPECT_THAT(warnings_of(reads + "(defrule choose => (assert (choosen 1)))"),
              ElementsAre("2: no rule reads the facts 'choosen' that are asserted here, did you mean 'chosen'?",
                          "1: nothing asserts the facts 'chosen' that this pattern reads, did you mean 'choosen'?"));
  EXPECT_THAT(
      warnings_of(reads + "(defrule choose => (assert (chosen 1)))\n(defrule other => (assert (remembered 1)))"),
      IsEmpty());
  EXPECT_THAT(
      warnings_of(reads + "(defrule choose => (assert (chosen 1) (choosen 1)) (do-for-fact ((?c choosen)) TRUE))"),
      IsEmpty());
}

TEST(DefinedTwice, IsToldWithBothPlaces) {
  const auto twice = [](const std::string& one, const std::string& other) {
    std::vector<std::string> said = warnings_of(one + '\n' + other);
    for (std::string& text : said)
      if (const auto at = text.find(" in /"); at != text.npos) text.replace(at + 4, text.rfind('/') - at - 3, "");
    return said;
  };
  const auto replaces = [](const std::string& what) {
    return "2: " + what + " is defined already in rules.clp:1; this definition replaces it";
  };
  EXPECT_THAT(twice("(defrule a => )", "(defrule a (b) => )"), ElementsAre(replaces("defrule 'a'")));
  EXPECT_THAT(twice("(deffunction f (?x) 1)", "(deffunction f (?x) 2)"), ElementsAre(replaces("deffunction 'f'")));
  EXPECT_THAT(twice("(deftemplate t (slot a))", "(deftemplate t (slot b))"), ElementsAre(replaces("deftemplate 't'")));
  EXPECT_THAT(twice("(defglobal ?*a* = 1 ?*b* = 2)", "(defglobal ?*b* = 3)"),
              ElementsAre(replaces("defglobal '?*b*'")));
  EXPECT_THAT(twice("(defclass C (is-a USER))", "(defclass C (is-a USER) (slot x))"),
              ElementsAre(replaces("defclass 'C'")));
  EXPECT_THAT(twice("(deffacts f (a))", "(deffacts f (b))"), ElementsAre(replaces("deffacts 'f'")));
  EXPECT_THAT(twice("(defmethod m ((?x INTEGER)) 1)", "(defmethod m ((?y INTEGER)) 2)"),
              ElementsAre(replaces("defmethod 'm' (INTEGER)")));
  EXPECT_THAT(twice("(defmethod m ((?x INTEGER)) 1)", "(defmethod m ((?x FLOAT)) 2)"), IsEmpty());
  EXPECT_THAT(twice("(deffunction later (?x))", "(deffunction later (?x) 2)"), IsEmpty()) << "a declaration";
  EXPECT_THAT(twice("(defmodule A) (defrule a =>)", "(defmodule B) (defrule a =>)"), IsEmpty());
}

TEST(DefinedTwice, IsNoMistakeOfRulesThatBuild) {
  Lab lab;
  lab.agent("(defrule a =>)\n(defrule b => (build \"(defrule a (x) =>)\"))");
  lab.run_up();
  EXPECT_THAT(lab.manager->warnings(), IsEmpty());
}

}  // namespace
}  // namespace cxlab::cx
