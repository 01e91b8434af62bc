// Rules that change the values of a running expression, and forms that are too large: the output or error of each.

#include <clips_ns/clips.h>

#include "tests/support/engine_test.h"

namespace clips {
extern "C" {
void SystemError(Environment*, const char*, int);
void ExitRouter(Environment*, int);
}
}  // namespace clips

namespace cxlab {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using testing::StartsWith;

/// What the rules of these tests share.
constexpr const char* kWorld = R"(
(defglobal ?*g* = (create$ a 1.25 c))
(deftemplate t (slot x) (multislot m))
(defclass A (is-a USER) (role concrete) (slot x) (multislot m))
(deffunction fresh () (create$ (gensym*) 9.75 (gensym*)))
(deffunction bind-g (?x) (bind ?*g* (fresh)) (fresh) ?x)
(deffunction pop () (bind ?x (nth$ 1 ?*g*)) (bind ?*g* (rest$ ?*g*)) ?x)
(deffunction put-m (?x) (send [i] put-m (fresh)) (fresh) ?x)
(deffunction gone (?x) (do-for-all-facts ((?f t)) TRUE (retract ?f)) (fresh) ?x)
(deffunction undone (?x) (do-for-all-instances ((?i A)) TRUE (unmake-instance ?i)) (fresh) ?x)
(deffunction undefined (?x) (undefglobal g) (fresh) ?x)
(defmessage-handler A twice () (create$ ?self:m (bind ?self:m x) ?self:m))
(defmessage-handler A kept () (bind ?l ?self:m) (bind ?self:m x) ?l)
(defmessage-handler A dynamic () (create$ (dynamic-get m) (bind ?self:m x)))
(deffacts facts (t (x 1) (m a 1.25 c)) (t (x 2) (m d 2.5)))
(definstances instances (i of A (x 1) (m a 1.25 c)))
)";

struct HostileTest : EngineTest {
  void SetUp() override {
    EngineOptions o = options();
    o.limits = &limits;
    engine_ = make(std::move(o));
  }
  void TearDown() override { engine_.reset(); }

  /// What an action of a rule prints.
  std::string printed(const std::string& action) {
    SetUp();
    output.clear();
    EXPECT_TRUE(engine().load_text(kWorld, "world.clp", LoadMode::kConstructs).ok());
    given("(defrule acts ?fact <- (t (x 1) (m $?l)) => " + action + ")");
    engine().reset();
    errors = engine().run(1).errors;
    return output["stdout"];
  }

  LimitsInUse limits;
  std::vector<RuleError> errors;
};

TEST_F(HostileTest, WhatAnExpressionHoldsStaysWhateverItsOtherPartsDo) {
  static const std::pair<const char*, const char*> kCases[] = {
      // lists of globals
      {"(foreach ?v ?*g* (bind-g 1) (printout t ?v \" \"))", "a 1.25 c "},
      {"(progn$ (?v ?*g*) (undefined 1) (printout t ?v \" \"))", "a 1.25 c "},
      {"(printout t (bind-g ?*g*))", "(a 1.25 c)"},
      {"(printout t (create$ ?*g* (pop) ?*g*))", "(a 1.25 c a 1.25 c)"},
      {"(printout t (str-cat (nth$ 1 ?*g*) (bind-g 1) (nth$ 2 ?*g*)))", "a19.75"},
      {"(printout t (insert$ ?*g* 1 (bind-g 1)))", "(1 a 1.25 c)"},
      {"(printout t (funcall create$ ?*g* (bind-g 1)))", "(a 1.25 c 1)"},
      {"(printout t (sort > ?*g* (bind-g 2) 1))", nullptr},
      {"(printout t (create$ (expand$ ?*g*) (bind-g 1)))", "(a 1.25 c 1)"},
      {"(bind ?x ?*g*) (bind-g 1) (printout t ?x)", "(a 1.25 c)"},
      {"(printout t (nth$ 2 (progn (bind-g (create$ 1 2.5)))))", "2.5"},
      {"(printout t (create$ ?*g* (progn (reset) 1)))", "(a 1.25 c 1)"},
      {"(printout t (create$ (eval \"?*g*\") (bind-g 1)))", "(a 1.25 c 1)"},
      {"(printout t (create$ ?*g* (progn (build \"(defglobal ?*g* = (create$ 7 8))\") (fresh) 1)))", "(a 1.25 c 1)"},
      {"(switch (nth$ 2 ?*g*) (case (progn (bind-g 1) 2.5) then (printout t no)) (case 1.25 then (printout t yes)))",
       "yes"},
      // slots of instances
      {"(foreach ?v (send [i] get-m) (put-m 1) (printout t ?v \" \"))", "a 1.25 c "},
      {"(printout t (create$ (send [i] get-m) (put-m 1)))", "(a 1.25 c 1)"},
      {"(printout t (length$ (send [i] twice)) (nth$ 2 (send [i] twice)))", "5x"},
      {"(printout t (send [i] kept))", "(a 1.25 c)"},
      {"(printout t (send [i] dynamic))", "(a 1.25 c x)"},
      {"(do-for-all-instances ((?i A)) TRUE (printout t (create$ ?i:m (put-m 1))))", "(a 1.25 c 1)"},
      {"(do-for-all-instances ((?i A)) TRUE (printout t (create$ ?i:m (undone 1))))", "(a 1.25 c 1)"},
      {"(printout t (create$ (send [i] get-m) (undone 1)))", "(a 1.25 c 1)"},
      {"(printout t (create$ (instance-address [i]) (undone 1)))", "(<Stale Instance-i> 1)"},
      {"(printout t (create$ (slot-replace$ [i] m 1 1 z) (send [i] get-m) (slot-delete$ [i] m 1 2) (send [i] get-m)))",
       nullptr},
      // facts and their slots
      {"(foreach ?v (fact-slot-value ?fact m) (gone 1) (printout t ?v \" \"))", "a 1.25 c "},
      {"(printout t (create$ (fact-slot-value ?fact m) (gone 1) ?l))", "(a 1.25 c 1 a 1.25 c)"},
      {"(printout t (create$ (find-all-facts ((?f t)) TRUE) (gone 1)))", nullptr},
      {"(foreach ?f (get-fact-list) (gone 1) (printout t (fact-existp ?f) \" \"))", "FALSE FALSE "},
      {"(foreach ?v ?l (modify ?fact (m (fresh))) (printout t ?v \" \"))", "a 1.25 c "},
      {"(do-for-all-facts ((?f t)) TRUE (printout t (create$ ?f:m (gone 1)) \" \"))", "(a 1.25 c 1) "},
      // what queries give
      {"(printout t (delayed-do-for-all-facts ((?v t)) TRUE (create$ a 0.5 ?v:x)))", "(a 0.5 2)"},
      {"(printout t (create$ (delayed-do-for-all-facts ((?v t)) TRUE (fresh)) (length$ (delayed-do-for-all-facts ((?v "
       "t)) TRUE "
       "(create$ 1.5 2.5 ?v:x)))))",
       nullptr},
      {"(delayed-do-for-all-facts ((?v t)) TRUE (create$))", ""},
      {"(printout t (delayed-do-for-all-instances ((?v A)) TRUE (create$ 0.5 ?v:m)))", "(0.5 a 1.25 c)"},
      {"(printout t (do-for-all-facts ((?v t)) TRUE (create$ 0.5 ?v:x)))", "(0.5 2)"},
      {"(printout t (do-for-fact ((?v t)) TRUE (create$ 0.5 ?v:x)) (do-for-instance ((?v A)) TRUE (create$ 0.5 ?v:m)))",
       "(0.5 1)(0.5 a 1.25 c)"},
  };
  for (const auto& [action, expected] : kCases) {
    const std::string first = printed(action);
    if (expected != nullptr) {
      EXPECT_EQ(first, expected) << action;
    }
    EXPECT_EQ(printed(action), first) << action;
    EXPECT_FALSE(limits.exceeded) << action;
  }
}

TEST_F(HostileTest, RestrictionsOfAQuerySeeTheQueriesAroundItAndNotItself) {
  EXPECT_EQ(
      printed("(do-for-all-facts ((?v t)) TRUE (do-for-all-facts ((?w (fact-relation ?v))) (eq ?v ?w) (printout t "
              "?w:x)))"),
      "12");
  EXPECT_EQ(printed("(do-for-all-instances ((?v A)) TRUE (any-instancep ((?w (class ?v))) (printout t ?w:x)))"), "1");
  EXPECT_EQ(
      printed("(do-for-all-facts ((?v t)) TRUE (any-factp ((?w (progn (gone 1) t))) TRUE) (printout t (fact-index "
              "?v)))"),
      "-1");
  for (const auto& [query, error] : {
           std::pair("(do-for-all-facts ((?v ?v)) TRUE 1)", "[FACTQURY1] The restrictions of fact-set query variables"),
           std::pair("(any-factp ((?v t) (?w (fact-relation ?v:x))) TRUE)", "[FACTQURY1]"),
           std::pair("(do-for-all-facts ((?v t)) TRUE (find-fact ((?w (fact-relation ?w))) TRUE))", "[FACTQURY1]"),
           std::pair("(any-instancep ((?v A) (?w (class ?v))) TRUE)", "[INSQUERY1]"),
           std::pair("(find-all-instances ((?v A) (?w (class ?v:x))) TRUE)", "[INSQUERY1]"),
           std::pair("(any-factp ((?v t (sym-cat \"(\" QDS \")\") t)) TRUE)", "Unable to find deftemplate '(QDS)'"),
           std::pair("(find-all-instances ((?v A (sym-cat \"(\" QDS \")\"))) TRUE)", "Unable to find class '(QDS)'"),
       }) {
    (void)printed(query);
    ASSERT_THAT(errors, Not(IsEmpty())) << query;
    EXPECT_THAT(errors[0].detail, HasSubstr(error)) << query;
  }
}

TEST_F(HostileTest, WhatIsDefinedAgainHasTheVariablesAndParametersOfItsLastForm) {
  given(
      "(defmethod m ((?x NUMBER)) 1)\n(defmethod m ((?x NUMBER)) (bind ?a 1) (bind ?b 2.5) (bind ?c 3) (bind ?d "
      "(create$ "
      "4 5)) (create$ ?a ?b ?c ?d))\n(deffunction f (?x) ?x)\n(deffunction calls () (f 1))\n(deffunction sorts () "
      "(sort f 3 1 (build \"(deffunction f (?x ?y ?z) (create$ ?x ?y ?z))\")))");
  const auto said_of = [&](const char* call) {
    const Expected<Value> value = engine().eval(call);
    std::string said = value.ok() ? value->print() : value.error().message;
    for (const RuleError& error : engine().take_errors()) said += '\n' + error.text();
    return said;
  };
  EXPECT_EQ(said_of("(m 7)"), "(1 2.5 3 4 5)");
  given("(deffunction f (?x ?y) (create$ ?x ?y))");
  EXPECT_THAT(said_of("(calls)"), HasSubstr("Function 'f' expected exactly 2 arguments"));
  EXPECT_THAT(said_of("(sorts)"), HasSubstr("Function 'f' expected exactly 3 arguments"));
  given("(deffunction f ($?x) (length$ ?x))");
  EXPECT_EQ(said_of("(calls)"), "1");
}

TEST_F(HostileTest, GenericFunctionsInUseStay) {
  EXPECT_EQ(
      printed("(printout t (progn (build \"(defmethod one ((?x NUMBER)) ?x)\") (eval \"(one (progn (undefgeneric *) "
              "1))\")))"),
      "");
  ASSERT_THAT(errors, Not(IsEmpty()));
  EXPECT_THAT(errors[0].text(), HasSubstr("Unable to delete generic function 'one'"));
  SetUp();
  given(
      "(defmethod two ((?x NUMBER)) (* 2 ?x))\n(deffunction calls (?x) (two ?x))\n(deffunction previews (?x) "
      "(preview-generic two (nth$ ?x (calls ?x))) ?x)");
  (void)engine().eval("(undefgeneric *)");
  EXPECT_FALSE(engine().eval("(calls 1)").ok());
  given("(defmethod two ((?x NUMBER)) (* 2 ?x))");
  EXPECT_EQ(engine().eval("(calls 4)")->as_integer(), 8);
  (void)engine().eval("(previews 1)");
  EXPECT_EQ(engine().eval("(calls 3)")->as_integer(), 6);
}

TEST_F(HostileTest, HandlersCannotForgeTheSlotsOfAModifyOrDuplicate) {
  constexpr const char* kHandlers =
      "(defmessage-handler A direct-modify around (?o) (printout t ?o) (override-next-handler 1094795585))\n"
      "(defmessage-handler A message-modify around (?o) (bind ?*g* ?o) (override-next-handler a))\n"
      "(defmessage-handler A direct-duplicate around (?n ?o) (override-next-handler ?n 1094795585))\n"
      "(defmessage-handler A message-duplicate around (?n ?o) (override-next-handler 1094795585 ?o))";
  SetUp();
  ASSERT_TRUE(engine().load_text(kWorld, "world.clp", LoadMode::kConstructs).ok());
  given(kHandlers);
  engine().reset();
  EXPECT_TRUE(engine().eval("(modify-instance [i] (x 7))").ok());
  EXPECT_EQ(output["stdout"], "<Pointer-C-(nil)>");  // no address, which would differ between runs
  EXPECT_EQ(engine().eval("(send [i] get-x)")->as_integer(), 7);
  EXPECT_TRUE(engine().eval("(message-modify-instance [i] (x 8))").ok());
  EXPECT_EQ(engine().eval("(send [i] get-x)")->as_integer(), 8);
  EXPECT_TRUE(engine().eval("(duplicate-instance [i] to j (x 9))").ok());
  EXPECT_EQ(engine().eval("(send [j] get-x)")->as_integer(), 9);
  EXPECT_FALSE(engine().eval("(message-duplicate-instance [i] to k (x 9))").ok());
  EXPECT_FALSE(engine().eval("(send [i] direct-modify ?*g*)").ok());
}

TEST_F(HostileTest, ModifyOfAFactThatTheValueOfItsSlotRetractsIsAnError) {
  for (const char* value : {"(x (progn (retract ?fact) 5))", "(x (gone 5))", "(m (progn (retract *) (create$ 5 6)))",
                            "(m q) (x (progn (retract ?fact) (fresh) 5))", "(m (gone 5))"}) {
    (void)printed("(modify ?fact " + std::string(value) + ")");
    ASSERT_THAT(errors, SizeIs(1)) << value;
    EXPECT_THAT(errors[0].text(), HasSubstr("The fact f-1 has been retracted")) << value;
    EXPECT_EQ(errors[0].rule, "acts");
  }
  (void)printed("(duplicate ?fact (x (gone 5)))");
  EXPECT_THAT(errors, IsEmpty());
  EXPECT_THAT(fact_texts("t"), ElementsAre("(t (x 5) (m a 1.25 c))"));
}

TEST_F(HostileTest, DuplicateOfASlotWithoutAValueIsAnError) {
  for (const char* slots : {"(x)", "(x 1 2)", "(m 1) (x)", "(x (create$ 1 2))"}) {
    (void)printed("(bind ?new (assert (t (x 9) (m a b)))) (duplicate ?new " + std::string(slots) + ")");
    ASSERT_THAT(errors, SizeIs(1)) << slots;
    EXPECT_THAT(errors[0].text(), HasSubstr("multifield value into the single field slot 'x'")) << slots;
  }
}

TEST_F(HostileTest, FunctionsOfTheirOwnFormAreNotCalledByName) {
  for (const char* call :
       {"(sort modify 1 100000000)", "(sort duplicate 1 64)", "(sort assert 3 1 2)", "(sort switch 3 1 2)",
        "(funcall \"(query-fact)\" 1)", "(funcall \"(query-fact-slot)\" 1)", "(funcall \"(query-instance)\" 1)",
        "(funcall \"(query-instance-slot)\" 1)", "(funcall \"(expansion-call)\")", "(funcall \"(get-loop-count)\" 1)",
        "(funcall \"(get-progn$-field)\")", "(funcall \"(get-progn$-index)\")", "(funcall \"(gnrc-current-arg)\" 1)",
        "(sort (sym-cat \"(query-fact)\") 3 1)", "(funcall (str-cat \"(direct\" \"-modify)\") 1)",
        "(funcall bind x 1)"}) {
    (void)printed(call);
    ASSERT_THAT(errors, SizeIs(1)) << call;
    EXPECT_THAT(errors[0].text(), HasSubstr("function without specialized parser")) << call;
  }
  EXPECT_EQ(printed("(printout t (sort > 3 1 2) (funcall + 1 2) (funcall \"create$\" a))"), "(1 2 3)3(a)");
}

TEST_F(HostileTest, NamesOfColonsAreNamesOfNothing) {
  for (const char* name : {"::", "MAIN::", "::i", "NONE::i", "a::b::c", ":::", "::::"}) {
    for (const char* call : {"(instance-existp [%])",
                             "(instance-address [%])",
                             "(send [%] print)",
                             "(unmake-instance [%])",
                             "(instance-existp %)",
                             "(class-existp %)",
                             "(ppdefrule %)",
                             "(undefrule %)",
                             "(undeftemplate %)",
                             "(deftemplate-slot-names %)",
                             "(set-current-module %)",
                             "(funcall % 1)",
                             "(sort % 1 2)",
                             "(focus %)",
                             "(get-defrule-list %)",
                             "(superclassp % A)",
                             "(subclassp A %)",
                             "(undefglobal %)",
                             "(defglobal-module %)",
                             "(get-method-restrictions % 1)",
                             "(undefmessage-handler % x)",
                             "(list-watch-items %)",
                             "(slot-existp % x)",
                             "(send [%] get-x)",
                             "(symbol-to-instance-name %)",
                             "(matches %)",
                             "(undefinstances %)",
                             "(undeffacts %)"}) {
      std::string text = call;
      text.replace(text.find('%'), 1, name);
      (void)printed(text);
      EXPECT_FALSE(limits.exceeded) << text;
    }
  }
  for (const char* name : {"::", "MAIN::", "::i", "a::b", "MAIN::a::b"}) {
    (void)printed("(make-instance [" + std::string(name) + "] of A)");
    ASSERT_THAT(errors, SizeIs(1)) << name;
    EXPECT_THAT(errors[0].text(), HasSubstr("Invalid module specifier")) << name;
  }
  for (const char* form :
       {"(defrule :: =>)", "(defrule MAIN:: =>)", "(deftemplate ::)", "(defclass MAIN::a::b (is-a USER))",
        "(deffunction ::x ())", "(defglobal MAIN:: ?*x* = 1)", "(defrule r (::x 1) =>)",
        "(defrule r (MAIN:: (x 1)) =>)", "(defrule r => (MAIN:: 1))", "(defrule r => (::f 1))",
        "(defmessage-handler :: x ())", "(definstances i ([::] of MAIN::))", "(defmodule ::)",
        "(defmethod :: ((?x MAIN::)))", "(deffacts f (MAIN:: 1))"})
    EXPECT_THAT(load_errors(form), Not(IsEmpty())) << form;
}

TEST_F(HostileTest, CardinalitiesThatNoListHasAreErrors) {
  for (const char* least :
       {"1000001", "300000000", "1152921504606846976", "2305843009213693952", "9223372036854775807", "-1"}) {
    EXPECT_THAT(load_errors("(deftemplate r (multislot m (cardinality " + std::string(least) + " ?VARIABLE)))"),
                ElementsAre(HasSubstr("Minimum 'cardinality' value must be")))
        << least;
    EXPECT_THAT(
        load_errors("(defclass R (is-a USER) (multislot m (cardinality " + std::string(least) + " ?VARIABLE)))"),
        Not(IsEmpty()))
        << least;
  }
  EXPECT_THAT(load_errors("(deftemplate r (multislot m (cardinality 1000 9223372036854775807)))"), IsEmpty());
  ASSERT_TRUE(engine().eval("(assert (r))").ok());
  EXPECT_THAT(engine().facts("r")[0].slot("m")->items(), SizeIs(1000));
}

std::string times(int n, const std::string& part) {
  std::string text;
  for (int i = 0; i < n; ++i) {
    std::string one = part;
    if (const std::size_t at = one.find('#'); at != std::string::npos) one.replace(at, 1, std::to_string(i));
    text += one;
  }
  return text;
}

TEST_F(HostileTest, AFormWithMorePartsThanClipsCountsIsAnErrorWhereItGetsTooLarge) {
  const int n = kWidestForm + 1;
  for (const std::string& form :
       {"(deffacts d\n(x" + times(n, " 1") + "))", "(defrule r\n(x" + times(n, " 1") + ") =>)",
        "(defrule r\n(x $?" + times(n, " 1|2") + ") =>)", "(deffunction f\n(" + times(n, " ?p#") + ") 1)",
        "(deftemplate t\n" + times(n, " (slot s#)") + ")",
        "(defrule r => (printout t\n(create$" + times(n, " 1") + ")))",
        "(defrule r =>\n" + times(n, "(bind ?x# 1)") + ")", "(defrule r\n" + times(n, "(a)") + " =>)",
        "(deffunction f (?x) (switch ?x\n" + times(n, "(case # then 1)") + "))",
        "(defglobal\n" + times(3 * n, " ?*g#* = 1") + ")", "(defclass C (is-a USER)\n" + times(n, "(slot s#)") + ")",
        "(defmethod m\n(" + times(n, "(?p# INTEGER)") + ") 1)",
        "(defmodule M\n" + times(n, "(export deftemplate a#)") + ")"}) {
    EXPECT_THAT(load_errors(form), ElementsAre("rules.clp:2: found a form with more than 30000 parts on one level"))
        << form.substr(0, 30);
  }
  const std::string wide = "(list" + times(n, " 1") + ")";
  const char* const kWide = "found a form with more than 30000 parts on one level";
  EXPECT_THAT(engine().eval("(assert-string \"" + wide + "\")").error().message, HasSubstr(kWide));
  EXPECT_THAT(engine().eval("(eval \"(length$ (create$" + times(n, " 1") + "))\")").error().message, HasSubstr(kWide));
  EXPECT_THAT(engine().eval("(build \"(deffacts d " + wide + ")\")").error().message, HasSubstr(kWide));
}

TEST_F(HostileTest, ListsMayBeLongerThanForms) {
  given(
      "(deffunction numbers (?n) (bind ?l (create$)) (loop-for-count 7 (bind ?l (create$ ?l ?n ?l))) ?l)\n"
      "(deffunction count ($?all) (length$ ?all))\n(defmethod counted ($?all) (length$ ?all))\n"
      "(defglobal ?*l* = (explode$ (implode$ (numbers 1))))\n"
      "(deffunction long () (bind ?l ?*l*) (while (< (length$ ?l) 70000) (bind ?l (create$ ?l ?l))) ?l)\n"
      "(defrule all (list $?all ?last) => (assert (found (length$ ?all) ?last)))");
  const std::int64_t length = engine().eval("(length$ (long))")->as_integer();
  EXPECT_GT(length, 70000);
  for (const char* call :
       {"(length$ (create$ (expand$ (long))))", "(count (expand$ (long)))", "(counted (expand$ (long)))",
        "(funcall count (expand$ (long)))", "(length$ (sort > (expand$ (long))))", "(+ (expand$ (long)))"})
    EXPECT_EQ(engine().eval(call)->as_integer(), length) << call;
  ASSERT_TRUE(engine().eval("(assert (list (long) 7))").ok());
  engine().run();
  EXPECT_THAT(fact_texts("found"), ElementsAre("(found " + std::to_string(length) + " 7)"));
}

TEST_F(HostileTest, APatternOfAnObjectHasMoreThan255Fields) {
  given(
      "(defclass B (is-a USER) (role concrete) (pattern-match reactive) (multislot m))\n(defrule r (object (is-a B) "
      "(m" +
      times(300, " ?v#") + ")) => (printout t ?v0 \" \" ?v255 \" \" ?v256 \" \" ?v299))\n(definstances i (b of B (m" +
      times(300, " #") + ")))");
  engine().reset();
  engine().run();
  EXPECT_EQ(output["stdout"], "0 255 256 299");
}

TEST_F(HostileTest, ReadingFormsTakesSteps) {
  limits.steps = 1'000'000;
  for (const std::string& form :
       {"(deffunction f (?x) (switch ?x " + times(4'000, "(case # then 1)") + "))",
        "(deffunction f () " + times(4'000, "(bind ?x# 1)") + ")",
        times(4'000, "(defglobal ?*g#* = 1)\n") + times(2'000, "(deffunction f# () ?*g1*)\n")}) {
    limits.exceeded.reset();
    SetUp();
    engine().begin_tick();
    (void)load_errors(form + "\n(defrule last =>)");
    ASSERT_TRUE(limits.exceeded) << form.substr(0, 40);
    EXPECT_THAT(limits.exceeded->message, HasSubstr("more than 1000000 steps"));
    EXPECT_FALSE(engine().has("defrule", "last"));
  }
}

TEST_F(HostileTest, DisorderThatClipsFindsIsABugAndNamesTheRule) {
  const auto add = [&](const char* name, auto function) {
    ASSERT_TRUE(engine().add_function({.name = name, .min_args = 0, .max_args = 0, .owner = "test"}, function).ok());
  };
  add("break-clips", [](Call& call) {
    clips::SystemError(call.engine().raw(), "TEST", 1);
    clips::ExitRouter(call.engine().raw(), 1);
    call.give_boolean(true);
  });
  given("(defrule breaks\n  =>\n  (break-clips)\n  (assert (after)))");
  engine().run();
  ASSERT_TRUE(limits.exceeded);
  EXPECT_EQ(limits.exceeded->kind, ErrorKind::kBug);
  EXPECT_THAT(limits.exceeded->text(), StartsWith("rules.clp:1: environment 'main': rule breaks: CLIPS found"));
  EXPECT_THAT(fact_texts("after"), IsEmpty());
}

}  // namespace
}  // namespace cxlab
