// Expressions up to three deep over every function of CLIPS whose parts change what the others hold: facts, instances,
// globals, queries and definitions. Each byte chooses: first how many places, then for each of them where its
// expression stands (a rule, a test, a deffunction, a query, a handler, a method, a call of the host), and what it is.
// All of it happens twice, in two environments: what they print, and what is left in them, must be the same. With
// CXLAB_FUZZ_SHOW set it prints what it loads.

#include <clips_ns/clips.h>

#include <algorithm>
#include <iterator>
#include <set>
#include <string>
#include <vector>

#include "cx/engine/engine.h"
#include "tests/fuzz/fuzz.h"

/// CLIPS forgets small blocks on errors of many functions.
extern "C" const char* __asan_default_options() { return "detect_leaks=0"; }

namespace {

using cxlab::LoadMode;
using cxlab::OnLoadError;
using cxlab::RuleEngine;

constexpr const char* kWorld = R"(
(deftemplate order (slot id (default 1)) (slot state (default OPEN)) (multislot parts))
(deftemplate typed (slot n (type INTEGER) (range 0 9)) (multislot m (type SYMBOL) (cardinality 1 3)))
(defclass THING (is-a USER) (role concrete) (slot owner) (multislot tags (default x y)))
(defclass ROBOT (is-a THING) (role concrete) (pattern-match reactive) (slot speed (default 1)) (multislot load)
  (slot shared (storage shared) (default 0)) (multislot many (storage shared)))
(defglobal ?*list* = (create$ a 1.25 "text" [r1]) ?*one* = 0.5 ?*fact* = FALSE ?*gone* = FALSE ?*instance* = FALSE)
(deffunction first-of (?l) (nth$ 1 ?l))
(deffunction twice (?x) (create$ ?x ?x))
(deffunction rest-of ($?x) (rest$ $?x))
(deffunction swap (?x) (bind ?*list* (create$ (gensym*) 7.75)) ?x)
(deffunction pop () (bind ?x (nth$ 1 ?*list*)) (bind ?*list* (rest$ ?*list*)) ?x)
(deffunction clear-orders () (do-for-all-facts ((?f order)) TRUE (retract ?f)) (gensym*))
(deffunction clear-robots () (do-for-all-instances ((?i ROBOT)) TRUE (unmake-instance ?i)) (gensym*))
(deffunction less (?a ?b) (< (str-length (str-cat ?a)) (str-length (str-cat ?b))))
(defgeneric kind)
(defmethod kind ((?x NUMBER)) (bind ?*one* (+ ?x 0.5)) number)
(defmethod kind ((?x LEXEME) $?rest) (bind ?*list* ?rest) ?x)
(defmethod kind ((?x ROBOT)) (call-next-method))
(defmethod kind ((?x MULTIFIELD)) (swap ?x))
(defmessage-handler ROBOT run (?by) (bind ?self:speed ?by) ?self:load)
(defmessage-handler ROBOT take ($?what) (bind ?old ?self:load) (bind ?self:load ?what) ?old)
(defmessage-handler ROBOT put-load after ($?x) (bind ?*list* ?self:load))
(defmessage-handler ROBOT get-load around () (bind ?x (call-next-handler)) (swap ?x))
(defmessage-handler THING rename before (?x) (bind ?self:owner ?x))
(defmessage-handler THING rename primary (?x) (bind ?self:tags (create$ ?x ?self:tags)) (dynamic-get owner))
(defrule open (order (id ?id) (state OPEN) (parts $?a ?b $?)) (not (order (id ?c&:(> (str-length (str-cat ?c)) (str-length (str-cat ?id))))))
  (object (is-a ROBOT) (speed ?s)) => (bind ?*list* (create$ ?*list* ?b ?s)))
(defrule done ?f <- (order (state DONE) (parts $?p)) => (bind ?*list* ?p) (retract ?f))
(defrule fast ?i <- (object (is-a ROBOT) (speed 9) (load $?l)) => (send ?i put-load) (bind ?*list* ?l))
(defrule both (logical (order (id ?x) (parts $? b $?))) => (assert (seen ?x)))
(deffacts some (order (id 1) (parts a b c)) (order (id 2.5)) (time 1 2.5) (list p q "r"))
(definstances robots (r1 of ROBOT (load a 1 "x")) (r2 of ROBOT (speed 2.75) (tags)) (t1 of THING))
(reset)
(bind ?*fact* (assert (order (id 3) (parts z 3.5))))
(bind ?*gone* (assert (order (id 4))))
(retract ?*gone*)
(bind ?*instance* (instance-address [r1]))
)";

/// Forms of functions with parsers of their own, and what changes things most. An '@' stands for any expression.
constexpr const char* kForms[] = {"(bind ?*list* @ @)",
                                  "(bind ?*list* @)",
                                  "(bind ?*one* @)",
                                  "(bind ?*list*)",
                                  "(bind ?a @)",
                                  "(bind ?l @ @)",
                                  "(progn @ @)",
                                  "(if @ then @ else @)",
                                  "(foreach ?v @ @ @ ?v)",
                                  "(progn$ (?v @) @ ?v-index @ ?v)",
                                  "(loop-for-count (?v 1 3) @ @ ?v)",
                                  "(switch @ (case 1 then @) (case a then @) (default @))",
                                  "(return @)",
                                  "(break)",
                                  "(while @ @ (break))",
                                  "(create$ @ @ @)",
                                  "(create$ @ (swap @) @)",
                                  "(create$ @ (pop) @)",
                                  "(str-cat @ @ @)",
                                  "(create$ (expand$ @) @)",
                                  "(twice (expand$ @))",
                                  "(nth$ 1 @)",
                                  "(insert$ @ 1 @ @)",
                                  "(replace$ @ 1 1 @)",
                                  "(replace-member$ @ @ @)",
                                  "(subseq$ @ 1 2)",
                                  "(sort less @ @ @)",
                                  "(sort > @ @)",
                                  "(funcall twice @)",
                                  "(funcall kind @ @)",
                                  "(funcall @ @ @)",
                                  "(kind @)",
                                  "(kind @ @)",
                                  "(call-specific-method kind 2 @ @)",
                                  "(assert (order (id @) (state @) (parts @ @)))",
                                  "(assert (order (id @) (parts @)) (list @ @))",
                                  "(assert (typed (n @) (m @)))",
                                  "(assert (list @ @))",
                                  "(modify @ (id @))",
                                  "(modify @ (id @) (parts @ @))",
                                  "(modify ?*fact* (id @) (parts @) (state DONE))",
                                  "(duplicate @ (id @) (parts @))",
                                  "(duplicate ?*fact* (parts @))",
                                  "(retract @ @)",
                                  "(retract ?*fact*)",
                                  "(clear-orders)",
                                  "(clear-robots)",
                                  "(fact-slot-value @ parts)",
                                  "(fact-slot-value ?*fact* parts)",
                                  "(assert-string \"(order (id 9) (parts (create$ ?*list*)))\")",
                                  "(make-instance r1 of ROBOT (speed @) (load @ @))",
                                  "(make-instance @ of ROBOT (load @) (many @))",
                                  "(make-instance of THING (tags @ @))",
                                  "(active-make-instance r1 of ROBOT (speed @) (load @ @))",
                                  "(initialize-instance @ (speed @) (load @))",
                                  "(active-initialize-instance @ (load @))",
                                  "(modify-instance @ (speed @) (load @ @))",
                                  "(active-modify-instance ?*instance* (speed @) (load @))",
                                  "(message-modify-instance @ (speed @) (load @))",
                                  "(active-message-modify-instance ?*instance* (load @) (many @))",
                                  "(duplicate-instance @ to @ (speed @) (load @))",
                                  "(active-duplicate-instance [r1] to r3 (load @))",
                                  "(message-duplicate-instance @ (load @))",
                                  "(active-message-duplicate-instance ?*instance* to r1 (load @))",
                                  "(unmake-instance @)",
                                  "(unmake-instance *)",
                                  "(send @ delete)",
                                  "(send @ get-load)",
                                  "(send @ put-load @)",
                                  "(send [r1] put-load @)",
                                  "(send [r1] put-many @)",
                                  "(send [r1] take @ @)",
                                  "(send @ run @)",
                                  "(send @ rename @)",
                                  "(send @ print)",
                                  "(slot-insert$ @ load 1 @)",
                                  "(slot-replace$ [r1] load 1 1 @)",
                                  "(slot-delete$ [r1] load 1 1)",
                                  "(direct-slot-insert$ load 1 @)",
                                  "(eval \"(create$ ?*list* (pop) ?*list*)\")",
                                  "(build \"(deffunction twice (?x) (create$ ?x (gensym*) ?x))\")",
                                  "(build \"(deffunction less (?a ?b) (swap TRUE))\")",
                                  "(build \"(defglobal ?*list* = (create$ new list))\")",
                                  "(build \"(defrule late (order (parts $?p)) => (bind ?*list* ?p))\")",
                                  "(build \"(defmethod kind ((?x SYMBOL)) (pop))\")",
                                  "(build \"(defmessage-handler ROBOT run (?by) (unmake-instance ?self) ?self:load)\")",
                                  "(undefrule *)",
                                  "(undefglobal *)",
                                  "(undeffunction *)",
                                  "(undefmethod kind *)",
                                  "(undefclass ROBOT)",
                                  "(reset)",
                                  "(run 2)",
                                  "(clear)",
                                  "(printout t @ \" \" @ crlf)",
                                  "(format t \"%s %s%n\" (str-cat @) (str-cat @))",
                                  "(println @ @)",
                                  "(timer @ @)",
                                  "(fact-index @)",
                                  "(instance-address @)",
                                  "(symbol-to-instance-name @)"};

/// With facts ?f and ?g, or instances ?i and ?j, in their second and later parts.
constexpr const char* kFactQueries[] = {"(do-for-all-facts ((?f order)) @ @)",
                                        "(do-for-all-facts ((?f order list) (?g order)) @ @)",
                                        "(delayed-do-for-all-facts ((?f order)) @ @)",
                                        "(delayed-do-for-all-facts ((?f order) (?g order)) @ (progn @ @))",
                                        "(do-for-fact ((?f order)) @ @)",
                                        "(any-factp ((?f order) (?g list)) @)",
                                        "(find-fact ((?f order)) @)",
                                        "(find-all-facts ((?f order) (?g order)) @)"};
constexpr const char* kInstanceQueries[] = {"(do-for-all-instances ((?i ROBOT)) @ @)",
                                            "(do-for-all-instances ((?i ROBOT THING) (?j THING)) @ @)",
                                            "(delayed-do-for-all-instances ((?i ROBOT)) @ @)",
                                            "(delayed-do-for-all-instances ((?i ROBOT) (?j ROBOT)) @ (progn @ @))",
                                            "(do-for-instance ((?i ROBOT)) @ @)",
                                            "(any-instancep ((?i ROBOT) (?j THING)) @)",
                                            "(find-instance ((?i ROBOT)) @)",
                                            "(find-all-instances ((?i THING) (?j ROBOT)) @)"};

constexpr const char* kValues[] = {"?*list*",
                                   "?*list*",
                                   "?*one*",
                                   "?*fact*",
                                   "?*gone*",
                                   "?*instance*",
                                   "?a",
                                   "?l",
                                   "?v",
                                   "[r1]",
                                   "[r2]",
                                   "[t1]",
                                   "[nobody]",
                                   "[::]",
                                   "0",
                                   "1",
                                   "-1",
                                   "9223372036854775807",
                                   "-2.5",
                                   "1e308",
                                   "TRUE",
                                   "FALSE",
                                   "a",
                                   "*",
                                   "MAIN",
                                   "MAIN::order",
                                   "::",
                                   "order",
                                   "parts",
                                   "ROBOT",
                                   "load",
                                   "speed",
                                   "run",
                                   "primary",
                                   "kind",
                                   "twice",
                                   "swap",
                                   "open",
                                   "list",
                                   "robots",
                                   "depth",
                                   "all",
                                   "nil",
                                   "\"\"",
                                   "\"text\"",
                                   "\"(order (id 7))\"",
                                   "\"(bind ?*list* (create$))\"",
                                   "(create$)",
                                   "(create$ 3 a 1.75)",
                                   "(gensym*)",
                                   "(pop)",
                                   "(swap 2.25)",
                                   "(get-fact-list)",
                                   "(fact-slot-value ?*fact* parts)",
                                   "(send [r1] get-load)",
                                   "(assert (order (id 9) (parts k 8.5)))"};

class Choices {
 public:
  Choices(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
  bool left() const { return at_ < size_; }
  std::size_t below(std::size_t n) {
    std::size_t value = next();
    if (n > 256) value = value * 256 + next();
    return value % n;
  }

 private:
  std::size_t next() { return at_ < size_ ? data_[at_++] : 0; }

  const std::uint8_t* data_;
  std::size_t size_, at_ = 0;
};

/// Of CLIPS itself, so that none is forgotten.
const std::vector<std::string>& functions_of(const RuleEngine& engine) {
  static const std::vector<std::string> functions = [&] {
    // They end the input on purpose, or tell what differs between environments: how much memory is in use.
    const std::set<std::string> left_out{"exit", "while", "loop-for-count", "mem-used", "mem-requests", "release-mem"};
    std::vector<std::string> names;
    for (const clips::FunctionDefinition* f = clips::GetFunctionList(engine.raw()); f != nullptr; f = f->next) {
      const std::string name = f->callFunctionName->contents;
      if (left_out.contains(name)) continue;
      names.push_back(name.starts_with('(') ? "funcall \"" + name + '"' : name);
    }
    std::sort(names.begin(), names.end());
    return names;
  }();
  return functions;
}

class Writer {
 public:
  Writer(Choices& choices, const std::vector<std::string>& functions) : choices_(choices), functions_(functions) {}

  struct Scope {
    bool facts = false, instances = false, self = false;
  };

  std::string expression(const Scope& scope, int depth) {
    if (depth == 0) return value(scope);
    switch (choices_.below(8)) {
      case 0: return value(scope);
      case 1:
      case 2: return call(scope, depth);
      case 3: return filled(kFactQueries, {true, scope.instances, scope.self}, depth);
      case 4: return filled(kInstanceQueries, {scope.facts, true, scope.self}, depth);
      default: return filled(kForms, scope, depth);
    }
  }

 private:
  template <class Forms>
  std::string filled(const Forms& forms, const Scope& scope, int depth) {
    std::string text;
    for (const char c : std::string_view(forms[choices_.below(std::size(forms))])) {
      if (c == '@')
        text += expression(scope, depth - 1);
      else
        text += c;
    }
    return text;
  }

  std::string call(const Scope& scope, int depth) {
    std::string text = '(' + functions_[choices_.below(functions_.size())];
    for (std::size_t i = choices_.below(5); i > 0; --i) text += ' ' + expression(scope, depth - 1);
    return text + ')';
  }

  std::string value(const Scope& scope) {
    static constexpr const char* kOfFacts[] = {"?f", "?f:parts", "?f:id", "?f:implied"};
    static constexpr const char* kOfInstances[] = {"?i", "?i:load", "?i:speed", "?i:tags"};
    static constexpr const char* kOfSelf[] = {"?self", "?self:load", "?self:speed", "(dynamic-get load)"};
    const std::size_t chosen = choices_.below(std::size(kValues) + 12);
    if (chosen < std::size(kValues)) return kValues[chosen];
    const std::size_t special = chosen - std::size(kValues);
    if (special < 4) return scope.facts ? kOfFacts[special] : "?*list*";
    if (special < 8) return scope.instances ? kOfInstances[special - 4] : "?*fact*";
    return scope.self ? kOfSelf[special - 8] : "?*instance*";
  }

  Choices& choices_;
  const std::vector<std::string>& functions_;
};

/// Loads or calls the next expression where a byte says.
void play_one(RuleEngine& engine, Choices& choices) {
  static constexpr const char* kBinds = " (bind ?a 1.5) (bind ?l (create$ 1 b)) (bind ?v ?*list*) ";
  Writer writer(choices, functions_of(engine));
  const auto load = [&](const std::string& text) {
    static const bool show = std::getenv("CXLAB_FUZZ_SHOW") != nullptr;
    if (show) std::fprintf(stderr, "%s\n", text.c_str());
    (void)engine.load_text(text, "effects.clp", LoadMode::kBatch, OnLoadError::kKeepGoing);
  };
  switch (choices.below(8)) {
    case 0: {
      std::string rule = "(defrule acts ?f <- (order (id ?a) (parts $?l)) =>" + std::string(" (bind ?v ?l) ");
      rule += writer.expression({.facts = true}, 3);
      load(rule + " (printout t ?a ?l ?v ?f crlf) " + writer.expression({.facts = true}, 3) + ')');
      break;
    }
    case 1: {
      std::string rule = "(defrule sees ?i <- (object (is-a ROBOT) (load $?l) (speed ?a)) => (bind ?v ?a) ";
      rule += writer.expression({.instances = false}, 3);
      load(rule + " (printout t ?a ?l ?v ?i crlf))");
      break;
    }
    case 2:
      load("(defrule tests (order (id ?a) (parts $?l)) (order (id ?v)) (test " + writer.expression({}, 2) +
           ") => (printout t tests crlf))");
      break;
    case 3:
      load("(defrule compares (order (id ?v)) (list $? ?a&:" + writer.expression({}, 2) +
           " $?l) => (printout t compares ?a crlf))");
      break;
    case 4:
      load("(deffunction does (?f ?i $?x)" + std::string(kBinds) + writer.expression({}, 3) + ' ' +
           writer.expression({}, 3) + ')');
      load("(printout t (does ?*fact* ?*instance* ?*list*) (create$ ?*list* (does (pop) 1.25 a) ?*list*) crlf)");
      break;
    case 5:
      load("(defmessage-handler ROBOT does (?f $?x)" + std::string(kBinds) + writer.expression({.self = true}, 3) +
           ' ' + writer.expression({.self = true}, 3) + ')');
      load("(printout t (create$ ?*list* (send [r1] does ?*fact* ?*list*) (send [r2] does 1.25) ?*list*) crlf)");
      break;
    case 6:
      load("(defmethod kind ((?x LIST LEXEME) (?f PRIMITIVE))" + std::string(kBinds) + writer.expression({}, 3) +
           " (override-next-method ?f ?x))");
      load("(printout t (kind ?*list* ?*list*) (kind (pop) ?*list*) crlf)");
      break;
    default: load("(printout t " + writer.expression({}, 3) + " crlf)"); break;
  }
  (void)engine.run(20);
}

std::string play(Choices choices) {
  std::string said;
  cxlab::LimitsInUse limits;
  limits.steps = 200'000;
  limits.memory = 200'000'000;
  cxlab::EngineOptions options;
  options.limits = &limits;
  options.on_output = [&](std::string_view, std::string_view text) {
    if (said.size() < 100'000) said += text;
  };
  auto made = RuleEngine::create(std::move(options));
  cxlab::fuzz::promise(made.ok(), "there is an environment");
  RuleEngine& engine = **made;
  const cxlab::LoadReport world = engine.load_text(kWorld, "world.clp", LoadMode::kBatch);
  cxlab::fuzz::promise(world.ok(), "the world loads: " + (world.ok() ? std::string() : world.errors.front().text()));
  for (int i = 0; i < 12 && choices.left() && !limits.exceeded; ++i) play_one(engine, choices);
  for (const cxlab::FactCopy& fact : engine.facts()) said += fact.print() + '\n';
  for (const auto& [name, value] : engine.globals()) said += name + " = " + value.print() + '\n';
  for (const cxlab::RuleError& error : engine.take_errors()) said += error.text() + '\n';
  return said;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string first = play(Choices(data, size)), second = play(Choices(data, size));
  if (first != second) {
    const auto [a, b] = std::mismatch(first.begin(), first.end(), second.begin(), second.end());
    const auto at = std::max<std::ptrdiff_t>(0, a - first.begin() - 200);
    std::fprintf(stderr, "first:\n%s\nsecond:\n%s\n", first.substr(static_cast<std::size_t>(at), 400).c_str(),
                 second.substr(static_cast<std::size_t>(at), 400).c_str());
  }
  cxlab::fuzz::promise(first == second, "two environments do the same");
  return 0;
}
