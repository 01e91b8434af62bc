// Expressions three deep and deeper over every function of CLIPS whose parts change what the others hold: facts,
// instances, globals, queries, definitions, modules, modes and files. An input is text: lines that are loaded one after
// the other into a world of constructs, with a few rules fired after each. The search writes and changes the lines by
// the tables below, so that most of them load. The world is made once, and each input has a copy of the process. The
// lines of one input of eight are played in a second environment, too: what both print, and what is left in them, must
// be the same.

#include <clips_ns/clips.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "cx/engine/engine.h"
#include "tests/fuzz/copy.h"
#include "tests/fuzz/folder.h"
#include "tests/fuzz/fuzz.h"

namespace fuzz_effects {
namespace {

using cxlab::LoadMode;
using cxlab::OnLoadError;
using cxlab::RuleEngine;

constexpr const char* kWorld = R"(
(defmodule MAIN (export ?ALL))
(defglobal ?*list* = (create$ a 1.25 "text" [r1]) ?*one* = 0.5 ?*fact* = FALSE ?*gone* = FALSE ?*instance* = FALSE)
(deffunction pop () (bind ?x (nth$ 1 ?*list*)) (bind ?*list* (rest$ ?*list*)) ?x)
(deftemplate order (slot id (default 1)) (slot state (default OPEN)) (multislot parts))
(deftemplate late (slot x (default-dynamic (pop))) (multislot y (default-dynamic ?*list*)))
(deftemplate typed (slot n (type INTEGER) (range 0 9)) (multislot m (type SYMBOL) (cardinality 1 3)))
(defclass THING (is-a USER) (role concrete) (slot owner) (multislot tags (default x y)))
(defclass ROBOT (is-a THING) (role concrete) (pattern-match reactive) (slot speed (default 1)) (multislot load)
  (slot shared (storage shared) (default 0)) (multislot many (storage shared)))
(defclass LATE (is-a ROBOT) (role concrete) (slot speed (default-dynamic (pop))) (multislot load (default-dynamic (create$ ?*list* (gensym*)))))
(deftemplate idle (slot x (default-dynamic (gensym*))) (multislot y (default a b)))
(defclass IDLE (is-a THING) (role concrete) (slot x (default-dynamic (gensym*))) (multislot y))
(defmessage-handler IDLE does (?x) ?x)
(defgeneric rests)
(defmethod rests 1 ((?x NUMBER)) ?x)
(deffunction first-of (?l) (nth$ 1 ?l))
(deffunction twice (?x) (create$ ?x ?x))
(deffunction rest-of ($?x) (rest$ $?x))
(deffunction swap (?x) (bind ?*list* (create$ (gensym*) 7.75)) ?x)
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
(make-instance l1 of LATE)
(bind ?*fact* (assert (order (id 3) (parts z 3.5))))
(bind ?*gone* (assert (order (id 4))))
(retract ?*gone*)
(bind ?*instance* (instance-address [r1]))
)";

/// Forms of functions with parsers of their own, and what changes things most. An '@' stands for any expression, a '#'
/// in a text for one whose quotes are escaped.
constexpr const char* kForms[] = {
    "(bind ?*list* @ @)",
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
    "(progn$ (?v @) @ (break))",
    "(loop-for-count (?v 1 2) (if @ then (break) else @))",
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
    "(modify ^ (id @))",
    "(modify ^ (id @) (parts @ @))",
    "(modify ?*fact* (id @) (parts @) (state DONE))",
    "(duplicate ^ (id @) (parts @))",
    "(duplicate ?*fact* (parts @))",
    "(retract @ @)",
    "(retract ^)",
    "(retract ?*fact*)",
    "(clear-orders)",
    "(clear-robots)",
    "(fact-slot-value ^ parts)",
    "(fact-slot-value ?*fact* parts)",
    "(make-instance r1 of ROBOT (speed @) (load @ @))",
    "(make-instance @ of ROBOT (load @) (many @))",
    "(make-instance of THING (tags @ @))",
    "(active-make-instance r1 of ROBOT (speed @) (load @ @))",
    "(initialize-instance | (speed @) (load @))",
    "(active-initialize-instance | (load @))",
    "(modify-instance | (speed @) (load @ @))",
    "(active-modify-instance ?*instance* (speed @) (load @))",
    "(message-modify-instance | (speed @) (load @))",
    "(active-message-modify-instance ?*instance* (load @) (many @))",
    "(duplicate-instance | to @ (speed @) (load @))",
    "(active-duplicate-instance [r1] to r3 (load @))",
    "(message-duplicate-instance | (load @))",
    "(active-message-duplicate-instance ?*instance* to r1 (load @))",
    "(unmake-instance @)",
    "(unmake-instance |)",
    "(unmake-instance *)",
    "(send | delete)",
    "(send | get-load)",
    "(send | put-load @)",
    "(send [r1] put-load @)",
    "(send [r1] put-many @)",
    "(send [r1] take @ @)",
    "(send | run @)",
    "(send | rename @)",
    "(send | print)",
    "(slot-insert$ | load 1 @)",
    "(slot-replace$ [r1] load 1 1 @)",
    "(slot-delete$ [r1] load 1 1)",
    "(slot-direct-insert$ load 1 @)",
    "(undefrule *)",
    "(undefglobal *)",
    "(undeffunction *)",
    "(undefmethod kind *)",
    "(undefclass ROBOT)",
    "(reset)",
    "(run 2)",
    "(clear)",
    R"x((printout t @ " " @ crlf))x",
    R"x((format t "%s %s%n" (str-cat @) (str-cat @)))x",
    "(println @ @)",
    "(timer @ @)",
    "(fact-index ^)",
    "(instance-address |)",
    "(symbol-to-instance-name @)",
    R"x((eval "#"))x",
    R"x((eval "(create$ ?*list* (pop) ?*list*)"))x",
    R"x((build "(deffunction twice (?x) (create$ ?x # ?x))"))x",
    R"x((build "(deffunction less (?a ?b) # (swap TRUE))"))x",
    R"x((build "(deffunction swap (?x) (bind ?*list* #) ?x)"))x",
    R"x((build "(deffunction does (?f ?i $?x) # ?x)"))x",
    R"x((build "(defglobal ?*list* = #)"))x",
    R"x((build "(defglobal ?*one* = (pop) ?*list* = (create$ # ?*list*))"))x",
    R"x((build "(defrule late (order (parts $?p)) (test (neq # FALSE)) => (bind ?*list* ?p))"))x",
    R"x((build "(defrule acts ?f <- (order (id ?a)) => #)"))x",
    R"x((build "(defrule tests (declare (salience (progn # 3))) (object (is-a ROBOT) (load $?l)) => #)"))x",
    R"x((build "(defmethod kind ((?x SYMBOL)) # (pop))"))x",
    R"x((build "(defmethod kind 2 ((?x LEXEME) $?rest) # ?rest)"))x",
    R"x((build "(defmessage-handler ROBOT run (?by) (unmake-instance ?self) ?self:load)"))x",
    R"x((build "(defmessage-handler ROBOT put-load around ($?x) # (call-next-handler))"))x",
    R"x((build "(defmessage-handler ROBOT delete before () #)"))x",
    R"x((build "(deftemplate order (slot id (default-dynamic #)) (slot state) (multislot parts))"))x",
    R"x((build "(defclass ROBOT (is-a THING) (role concrete) (pattern-match reactive) (slot speed (default-dynamic #)) (multislot load))"))x",
    R"x((build "(defclass LATE (is-a ROBOT) (role concrete) (slot speed (default-dynamic #)))"))x",
    R"x((build "(deffacts some (order (id #)) (list #))"))x",
    R"x((build "(definstances robots (r1 of ROBOT (load #)))"))x",
    R"x((build "(defmodule OTHER (import MAIN ?ALL))"))x",
    R"x((build "(defrule OTHER::there (order (parts $?p)) => (bind ?*list* ?p) #)"))x",
    R"x((assert-string "(order (id 9) (parts (create$ ?*list*)))"))x",
    R"x((assert-string "(order (id #) (parts #))"))x",
    "(make-instance r1 of LATE (speed @))",
    "(undefrule acts)",
    "(undefrule open)",
    "(undefmessage-handler ROBOT *)",
    "(undefmessage-handler ROBOT does)",
    "(undefmessage-handler * *)",
    "(undefgeneric kind)",
    "(undefgeneric *)",
    "(undefmethod kind 2)",
    "(undeftemplate order)",
    "(undeftemplate *)",
    "(undefclass *)",
    "(undefclass LATE)",
    "(undeffunction swap)",
    "(undeffunction less)",
    "(undefglobal list)",
    "(undeffacts *)",
    "(undefinstances *)",
    "(call-next-method)",
    "(override-next-method @)",
    "(override-next-method @ @)",
    "(next-methodp)",
    "(call-next-handler)",
    "(override-next-handler @)",
    "(next-handlerp)",
    "(preview-generic kind @)",
    "(preview-send ROBOT run)",
    "(set-fact-duplication @)",
    "(set-fact-duplication TRUE)",
    "(set-salience-evaluation every-cycle)",
    "(set-salience-evaluation when-activated)",
    "(set-strategy lex)",
    "(set-strategy mea)",
    "(set-strategy random)",
    "(set-reset-globals FALSE)",
    "(set-dynamic-constraint-checking TRUE)",
    "(set-sequence-operator-recognition TRUE)",
    "(set-class-defaults-mode conservation)",
    "(set-profile-percent-threshold @)",
    "(profile constructs)",
    "(profile off)",
    "(watch all)",
    "(watch facts)",
    "(watch instances)",
    "(watch methods)",
    "(unwatch all)",
    "(set-break acts)",
    "(remove-break)",
    "(refresh open)",
    "(refresh acts)",
    "(refresh-agenda *)",
    "(focus OTHER)",
    "(focus OTHER MAIN)",
    "(pop-focus)",
    "(clear-focus-stack)",
    "(set-current-module OTHER)",
    "(set-current-module MAIN)",
    "(halt)",
    "(matches open)",
    "(matches acts terse)",
    "(join-activity open)",
    "(agenda *)",
    "(dependencies ^)",
    "(dependents ^)",
    "(facts)",
    "(instances)",
    "(timetag ^)",
    "(describe-class ROBOT)",
    "(ppdefrule acts)",
    "(ppfact @ t TRUE)",
    "(list-defglobals *)",
    "(show-defglobals *)",
    "(list-focus-stack)",
    "(exit)",
    "(progn (release-mem) @)",
    R"x((save-facts "f" visible))x",
    R"x((save-facts "f" local order))x",
    R"x((load-facts "f"))x",
    R"x((bsave-facts "g"))x",
    R"x((bload-facts "g"))x",
    R"x((save-instances "i"))x",
    R"x((load-instances "i"))x",
    R"x((restore-instances "i"))x",
    R"x((bsave-instances "h"))x",
    R"x((bload-instances "h"))x",
    R"x((save "s"))x",
    R"x((load "s"))x",
    R"x((load* "s"))x",
    R"x((bsave "b"))x",
    R"x((bload "b"))x",
    R"x((progn (open "o" o "w") (printout o "#" crlf) (close o) (batch* "o")))x",
    R"x((progn (open "o" o "w") (printout o "(deffunction swap (?x) # ?x)" crlf) (close o) (load* "o")))x",
    R"x((progn (open "o" o "w") (printout o "(order (id #) (parts #))" crlf) (close o) (load-facts "o")))x",
    R"x((progn (open "o" o "w") (printout o "([r1] of ROBOT (load #))" crlf) (close o) (restore-instances "o")))x",
    R"x((progn (dribble-on "d") @ (dribble-off)))x",
    R"x((progn (open "o" o "w") @ (printout o @) (close)))x",
    // The second text may remove the construct that the first one names.
    "(undefclass IDLE)",
    "(undeftemplate idle)",
    "(undefgeneric rests)",
    R"x((build "(defclass IDLE (is-a USER) (role concrete) (slot z))"))x",
    R"x((build "(deftemplate idle (slot z (default #)))"))x",
    R"x((build "(defclass NEW (is-a IDLE) (role concrete) (slot x (default #)) (multislot y (source composite) (default #)))"))x",
    R"x((build "(defclass IDLE (is-a USER) (role concrete) (slot x (default (make-instance of IDLE))) (slot z (default #)))"))x",
    R"x((build "(defrule ranks (declare (salience (progn # 3))) (order (id ?x)) => #)"))x",
    "(class-slots IDLE (progn @ inherit))",
    "(class-superclasses IDLE (progn @ inherit))",
    "(list-defmessage-handlers IDLE (progn @ inherit))",
    "(slot-types IDLE (progn @ x))",
    "(slot-default-value IDLE (progn @ x))",
    "(slot-existp IDLE (progn @ x) (progn @ inherit))",
    "(superclassp THING (progn @ IDLE))",
    "(subclassp IDLE (progn @ THING))",
    "(message-handler-existp IDLE (progn @ does) (progn @ primary))",
    "(preview-send IDLE (progn @ does))",
    "(undefmessage-handler IDLE (progn @ does) (progn @ primary))",
    "(undefmethod rests (progn @ 1))",
    "(get-method-restrictions rests (progn @ 1))",
    "(call-specific-method rests (progn @ 1) @)",
    "(matches open (progn @ terse))",
    "(join-activity acts (progn @ terse))",
    "(watch message-handlers IDLE (progn @ does) (progn @ primary))",
    "(list-watch-items methods rests (progn @ 1))",
    "(deftemplate-slot-types idle (progn @ y))",
    "(deftemplate-slot-default-value idle (progn @ x))",
    "(deftemplate-slot-facet-value idle (progn @ x) (progn @ default-dynamic))",
    R"x((save-facts "f" local idle (progn @ order)))x",
    R"x((save-instances "i" visible IDLE (progn @ ROBOT)))x",
    "(ppfact 1 (progn @ t) @)",
    "(ppdefclass IDLE (progn @ nil))",
    "(fact-slot-value 1 (progn @ parts))",
    "(slot-replace$ [r1] (progn @ load) 1 1 @)",
    "(dynamic-put (progn @ load) @)",
    "(dynamic-get (progn @ load))",
    "(duplicate-instance [r1] to (progn @ r5) (load @))",
    "(make-instance of (progn @ IDLE) (y @))",
    "(assert (idle (y @)))",
};

/// With facts ?f and ?g in their later parts.
constexpr const char* kFactQueries[] = {
    "(do-for-all-facts ((?f order)) @ @)",
    "(do-for-all-facts ((?f order list) (?g order)) @ @)",
    "(delayed-do-for-all-facts ((?f order)) @ @)",
    "(delayed-do-for-all-facts ((?f order) (?g order)) @ (progn @ @))",
    "(do-for-fact ((?f order)) @ @)",
    "(any-factp ((?f order) (?g list)) @)",
    "(find-fact ((?f order)) @)",
    "(find-all-facts ((?f order) (?g order)) @)",
    "(do-for-all-facts ((?f order)) TRUE (modify ?f (id @) (parts @)))",
    "(do-for-all-facts ((?f order)) @ (retract ?f) @)",
    "(delayed-do-for-all-facts ((?f order)) TRUE (retract *) @ ?f:parts)",
    "(do-for-all-facts ((?f order list)) (retract ?f) @ (create$ ?f ?f:parts))",
    "(do-for-all-facts ((?f order)) TRUE (do-for-all-facts ((?g order)) TRUE (duplicate ?f (id @)) (retract ?g)) @)",
};

/// With instances ?i and ?j in their later parts.
constexpr const char* kInstanceQueries[] = {
    "(do-for-all-instances ((?i ROBOT)) @ @)",
    "(do-for-all-instances ((?i ROBOT THING) (?j THING)) @ @)",
    "(delayed-do-for-all-instances ((?i ROBOT)) @ @)",
    "(delayed-do-for-all-instances ((?i ROBOT) (?j ROBOT)) @ (progn @ @))",
    "(do-for-instance ((?i ROBOT)) @ @)",
    "(any-instancep ((?i ROBOT) (?j THING)) @)",
    "(find-instance ((?i ROBOT)) @)",
    "(find-all-instances ((?i THING) (?j ROBOT)) @)",
    "(do-for-all-instances ((?i ROBOT)) @ (unmake-instance ?i) @)",
    "(do-for-all-instances ((?i ROBOT)) TRUE (unmake-instance *) @ ?i:load)",
    "(do-for-all-instances ((?i ROBOT)) TRUE (do-for-all-instances ((?j THING)) @ (unmake-instance ?j)) @ ?i:load)",
    "(do-for-all-instances ((?i ROBOT)) TRUE (modify-instance ?i (speed @) (load @)) ?i:load)",
    "(delayed-do-for-all-instances ((?i THING)) (send ?i delete) @ ?i:tags)",
    "(do-for-all-instances ((?i ROBOT)) TRUE (make-instance of ROBOT (load @)) (break))",
};

constexpr const char* kValues[] = {"?*list*",
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
                                   "(assert (order (id 9) (parts k 8.5)))",
                                   "[l1]",
                                   "LATE",
                                   "IDLE",
                                   "idle",
                                   "rests",
                                   "OTHER",
                                   "does",
                                   "acts",
                                   "x",
                                   "t",
                                   "3",
                                   "2.25",
                                   "late"};

/// What an expression may name beside globals.
enum Scope : unsigned { kFacts = 1, kInstances = 2, kSelf = 4, kSlots = 8 };  // kSlots: ?f:parts, ?i:load

struct Place {
  unsigned scope;
  const char* text;
};

/// Where expressions stand. A '~' binds the variables that every expression may use: ?a, ?l and ?v.
constexpr Place kPlaces[] = {
    {kFacts, "(defrule acts ?f <- (order (id ?a) (parts $?l)) => (bind ?v ?l) @ (printout t ?a ?l ?v ?f crlf) @)"},
    {kFacts, "(defrule changes ?f <- (order (id ?a) (parts $?l)) => (bind ?v ?l) (modify ?f (id @) (parts @)) @)"},
    {kFacts,
     "(defrule depends (logical ?f <- (order (id ?a) (parts $?l))) => (bind ?v ?l) (assert (seen @)) @ (printout t ?l "
     "crlf))"},
    {kInstances,
     "(defrule sees ?i <- (object (is-a ROBOT) (load $?l) (speed ?a)) => (bind ?v ?a) @ (printout t ?a ?l ?v ?i "
     "crlf))"},
    {kInstances,
     "(defrule dies (logical ?i <- (object (is-a ROBOT) (load $?l))) => (bind ?v ?l) (bind ?a 1) (make-instance of "
     "THING (tags @)) @)"},
    {0, "(defrule tests (order (id ?a) (parts $?l)) (order (id ?v)) (test (neq @ FALSE)) => (printout t tests crlf))"},
    {0, "(defrule compares (order (id ?v)) (list $? ?a&:(neq @ a) $?l) => (printout t compares ?a crlf))"},
    {0,
     "(defrule returns (order (id ?v) (parts $?l)) (list ?a $?) (order (id =(progn @))) => (printout t returns ?a "
     "crlf))"},
    {0,
     "(defrule slots (order (id ?v) (parts $?l)) (object (is-a ROBOT) (load $?m&:(neq @ FALSE)) (speed ?a&:(neq @ "
     "FALSE))) => (printout t slots ?m crlf))"},
    {0,
     "(defrule lacks (order (id ?a) (parts $?l)) (order (id ?v)) (not (and (list $? ?x $?) (test (eq @ FALSE)))) => "
     "(printout t lacks crlf) @)"},
    {0,
     "(defrule each (order (id ?a) (parts $?l)) (order (id ?v)) (forall (order (id ?x)) (list $? ?y&:(neq @ a) $?)) => "
     "@)"},
    {0, "(defrule ranks (declare (salience (progn @ 5))) (order (id ?a) (parts $?l)) (list ?v $?) => @)"},
    {0,
     "(deftemplate dated (slot x (default-dynamic @)) (multislot y (default @)))\n(printout t (assert (dated)) "
     "(fact-slot-value (assert (dated (x 1))) y) crlf)"},
    {0,
     "(defclass LATE (is-a ROBOT) (role concrete) (slot speed (default-dynamic @)) (multislot load (default "
     "@)))\n(printout t (send (make-instance r3 of LATE (speed 2)) get-load) crlf)"},
    {0,
     "(defclass NEW (is-a LATE) (role concrete) (pattern-match reactive) (slot speed (default-dynamic @)) (multislot "
     "load (default-dynamic @)))\n(printout t (make-instance r1 of NEW) (make-instance n1 of NEW (speed @)) crlf)"},
    {0, "(deffacts later (order (id @) (parts @)) (list @))\n(reset)"},
    {0, "(definstances later (r1 of ROBOT (load @)) (of THING (owner @) (tags @)))\n(reset)"},
    {0, "(definstances active later (r1 of ROBOT (load @)) (l1 of LATE))\n(reset)"},
    {0, "(defglobal ?*one* = @ ?*list* = @)\n(reset)"},
    {0,
     "(deffunction does (?f ?i $?x) ~ @ @)\n(printout t (does ?*fact* ?*instance* ?*list*) (create$ ?*list* (does "
     "(pop) 1.25 a) ?*list*) crlf)"},
    {0,
     "(deffunction less (?f ?i) ~ @ (< (str-length (str-cat ?f)) (str-length (str-cat ?i))))\n(printout t (create$ "
     "?*list* (sort less ?*list* (create$ zzz 2.75 (gensym*)) ?*fact*) ?*list*) crlf)"},
    {0, "(deffunction swap (?f) ~ (if @ then (return @)) (bind ?*list* (create$ @ 7.75)) ?f)"},
    {0,
     "(deffunction twice (?f) ~ (create$ ?f @ ?f))\n(printout t (funcall twice ?*list*) (create$ (expand$ ?*list*) "
     "(twice ?*one*)) crlf)"},
    {kSelf,
     "(defmessage-handler ROBOT does (?f $?x) ~ @ @)\n(printout t (create$ ?*list* (send [r1] does ?*fact* ?*list*) "
     "(send [r2] does 1.25) ?*list*) crlf)"},
    {kSelf,
     "(defmessage-handler ROBOT run around (?f) ~ @ (call-next-handler) @ ?self:load)\n(printout t (send [r1] run 2.5) "
     "(send [r2] run a) crlf)"},
    {kSelf,
     "(defmessage-handler ROBOT put-load around ($?x) ~ @ (override-next-handler @) ?self:load)\n(printout t (send "
     "[r1] put-load 1 b) crlf)"},
    {kSelf,
     "(defmessage-handler THING put-owner before (?f) ~ @)\n(printout t (send [r1] rename 1.5) (send [t1] rename b) "
     "crlf)"},
    {kSelf,
     "(defmessage-handler ROBOT get-load before () ~ @)\n(printout t (create$ (send [r1] get-load) @ (send [r1] "
     "get-load)) crlf)"},
    {kSelf,
     "(defmessage-handler ROBOT direct-modify around ($?x) ~ @ (override-next-handler @) "
     "?self:load)\n(defmessage-handler "
     "ROBOT message-modify before ($?x) ~ @ (bind ?*one* ?x))\n(printout t (modify-instance [r1] (speed @)) "
     "(message-modify-instance [r2] (load @) (speed ?*one*)) crlf)"},
    {kSelf,
     "(defmessage-handler ROBOT direct-duplicate around ($?x) ~ @ (override-next-handler @ @))\n(defmessage-handler "
     "ROBOT "
     "message-duplicate around ($?x) ~ (call-next-handler) @)\n(printout t (duplicate-instance [r1] to r3 (speed @)) "
     "(message-duplicate-instance [r2] to r4 (load @)) crlf)"},
    {kSelf,
     "(defmessage-handler ROBOT delete before () ~ @)\n(defmessage-handler THING delete after () ~ @)\n(send [r1] "
     "delete)"},
    {kSelf,
     "(defmessage-handler ROBOT delete around () ~ @ (call-next-handler) ?self:load)\n(printout t (send [r2] delete) "
     "crlf)"},
    {kSelf,
     "(defmessage-handler ROBOT init after () ~ @)\n(defmessage-handler ROBOT create before () ~ @)\n(make-instance r1 "
     "of ROBOT (load a 1.5))"},
    {kSelf,
     "(defmessage-handler THING init around () ~ @ (call-next-handler) @)\n(make-instance t2 of THING (owner @))"},
    {0,
     "(defmethod kind ((?x MULTIFIELD LEXEME) (?f PRIMITIVE)) ~ @ (override-next-method ?f ?x))\n(printout t (kind "
     "?*list* ?*list*) (kind (pop) ?*list*) crlf)"},
    {0,
     "(defmethod kind ((?f LEXEME (neq @ FALSE)) (?x (neq ?f 1))) ~ @ (call-next-method))\n(printout t (kind a "
     "?*list*) (kind (pop) b) crlf)"},
    {0,
     "(defmethod kind ((?f NUMBER)) ~ (create$ ?*list* (call-next-method) @ ?*list*))\n(printout t (kind 1) (kind 2.5) "
     "crlf)"},
    {0, "(defmethod + ((?f LEXEME) (?x PRIMITIVE)) ~ @)\n(printout t (+ a ?*list*) (+ \"x\" (pop)) crlf)"},
    {kFacts,
     "(defmodule OTHER (import MAIN ?ALL))\n(defrule OTHER::there (declare (auto-focus TRUE)) ?f <- (order (id ?a) "
     "(parts $?l)) => (bind ?v ?l) @ (printout t ?l crlf) @)\n(set-current-module MAIN)\n(focus OTHER)"},
    {0, "(printout t @ crlf)"},
    {0, "(printout t @ ?*list* @ crlf)"},
    {0, "@"},
    {0, "@\n@"},
    {0, "(reset)"},
    {0, "(run 3)"},
};

constexpr std::string_view kBinds = "(bind ?a 1.5) (bind ?l (create$ 1 b)) (bind ?v ?*list*)";

/// A function as its arguments are written.
struct Function {
  std::string name;
  unsigned least = 0, most = 0;
  unsigned gives = 0;           ///< the types of its values, as bits of CLIPS
  std::vector<unsigned> types;  ///< of the arguments
};

/// The functions of CLIPS itself, so that none is forgotten. Those with separate parsers have forms above.
const std::vector<Function>& all_functions() {
  static const std::vector<Function> functions = [] {
    // They end the input on purpose, or tell what differs between environments: how much memory is in use.
    const std::set<std::string> left_out{"exit", "mem-used", "mem-requests", "release-mem"};
    constexpr unsigned kMost = 4;
    const auto engine = RuleEngine::create({});
    cxlab::fuzz::promise(engine.ok(), "there is an environment");
    std::vector<Function> made;
    for (clips::FunctionDefinition* f = clips::GetFunctionList((*engine)->raw()); f != nullptr; f = f->next) {
      std::string name = f->callFunctionName->contents;
      if (left_out.contains(name) || f->parser != nullptr) continue;
      if (name.starts_with('(')) name = "funcall \"" + name + '"';
      Function& function =
          made.emplace_back(Function{name,
                                     std::min<unsigned>(f->minArgs, kMost),
                                     std::min<unsigned>(f->maxArgs, std::max<unsigned>(f->minArgs + 1u, kMost)),
                                     f->unknownReturnValueType,
                                     {}});
      for (unsigned i = 1; i <= function.most; ++i)
        function.types.push_back(clips::GetNthRestriction((*engine)->raw(), f, i));
    }
    std::sort(made.begin(), made.end(), [](const Function& a, const Function& b) { return a.name < b.name; });
    return made;
  }();
  return functions;
}

/// The types that a value as it is written may have.
unsigned types_of(std::string_view value) {
  const char c = value.front();
  if (c == '?' || c == '(') return ~0u;
  if (c == '"') return clips::STRING_BIT;
  if (c == '[') return clips::INSTANCE_NAME_BIT;
  const bool number = (c >= '0' && c <= '9') || (c == '-' && value.size() > 1);
  if (!number) return value == "TRUE" || value == "FALSE" ? clips::SYMBOL_BIT | clips::BOOLEAN_BIT : clips::SYMBOL_BIT;
  return value.find_first_of(".e") == std::string_view::npos ? clips::INTEGER_BIT : clips::FLOAT_BIT;
}

class Writer {
 public:
  explicit Writer(unsigned seed) : random_(seed) {}

  std::size_t below(std::size_t n) { return random_() % n; }

  std::string place() {
    const Place& place = kPlaces[below(std::size(kPlaces))];
    return filled(place.text, place.scope, 4);
  }

  std::string expression(unsigned scope, int depth) {
    if (depth == 0) return value(scope, ~0u);
    switch (below(10)) {
      case 0: return value(scope, ~0u);
      case 1:
      case 2:
      case 3: return call(scope, depth);
      case 4: return filled(one_of(kFactQueries), scope | kFacts | kSlots, depth);
      case 5: return filled(one_of(kInstanceQueries), scope | kInstances | kSlots, depth);
      default: return filled(one_of(kForms), scope, depth);
    }
  }

  /// One that has `part` somewhere in it.
  std::string around(const std::string& part, unsigned scope) {
    std::string text = filled(one_of(kForms), scope, 2, &part);
    return text;
  }

 private:
  template <class Table>
  const char* one_of(const Table& table) {
    return table[below(std::size(table))];
  }

  std::string filled(std::string_view form, unsigned scope, int depth, const std::string* part = nullptr) {
    std::string text;
    for (const char c : form) {
      if (c == '@') {
        if (part != nullptr && below(2) == 0)
          text += *std::exchange(part, nullptr);
        else
          text += expression(scope, below(3) == 0 ? 0 : depth - 1);
      } else if (c == '#') {
        for (const char quoted : expression(scope, depth - 1)) {
          if (quoted == '"' || quoted == '\\') text += '\\';
          text += quoted;
        }
      } else if (c == '^') {
        text += fact(scope, depth - 1);
      } else if (c == '|') {
        text += instance(scope, depth - 1);
      } else if (c == '~') {
        text += kBinds;
      } else {
        text += c;
      }
    }
    return text;
  }

  std::string call(unsigned scope, int depth) {
    return call(all_functions()[below(all_functions().size())], scope, depth);
  }

  std::string call(const Function& function, unsigned scope, int depth) {
    std::string text = '(' + function.name;
    const std::size_t n = function.least + below(function.most - function.least + 1);
    for (std::size_t i = 0; i < n; ++i) text += ' ' + argument(scope, function.types[i], depth - 1);
    return text + ')';
  }

  /// Mostly of one of these types: an error ends the expression around it.
  std::string argument(unsigned scope, unsigned types, int depth) {
    switch (depth == 0 ? 0 : below(8)) {
      case 0:
      case 1:
      case 2: return value(scope, types);
      case 3:
      case 4: return "(progn " + expression(scope, depth - 1) + ' ' + value(scope, types) + ')';
      case 5: {
        for (int i = 0; i < 20; ++i)
          if (const Function& function = all_functions()[below(all_functions().size())]; (function.gives & types) != 0)
            return call(function, scope, depth);
        return value(scope, types);
      }
      default: return expression(scope, depth);
    }
  }

  std::string fact(unsigned scope, int depth) {
    if (depth > 0 && below(4) == 0) return "(progn " + expression(scope, depth - 1) + ' ' + fact(scope, 0) + ')';
    if ((scope & kFacts) != 0 && below(2) == 0) return "?f";
    static constexpr const char* kOnes[] = {
        "?*fact*", "?*fact*", "?*gone*", "(assert (order (id 9) (parts k 8.5)))", "(nth$ 1 (get-fact-list))", "1"};
    return below(8) == 0 ? expression(scope, depth) : one_of(kOnes);
  }

  std::string instance(unsigned scope, int depth) {
    if (depth > 0 && below(4) == 0) return "(progn " + expression(scope, depth - 1) + ' ' + instance(scope, 0) + ')';
    if ((scope & kInstances) != 0 && below(2) == 0) return "?i";
    if ((scope & kSelf) != 0 && below(2) == 0) return "?self";
    static constexpr const char* kOnes[] = {
        "?*instance*", "[r1]", "[r2]", "[l1]", "(instance-address [r2])", "(make-instance r1 of ROBOT (load q 5.5))"};
    return below(8) == 0 ? expression(scope, depth) : one_of(kOnes);
  }

  std::string value(unsigned scope, unsigned types) {
    if ((types & (clips::FACT_ADDRESS_BIT | clips::STRING_BIT)) == clips::FACT_ADDRESS_BIT) return fact(scope, 0);
    static constexpr const char* kOfFacts[] = {"?f:parts", "?f:id", "?f", "(fact-slot-value ?f parts)"};
    static constexpr const char* kOfInstances[] = {"?i:load", "?i:speed", "?i:tags", "?i", "(send ?i get-load)"};
    static constexpr const char* kOfSelf[] = {"?self", "?self:load", "?self:speed", "(dynamic-get load)"};
    if ((scope & kFacts) != 0 && below(4) == 0) return kOfFacts[(scope & kSlots) != 0 ? below(4) : 2 + below(2)];
    if ((scope & kInstances) != 0 && below(4) == 0)
      return kOfInstances[(scope & kSlots) != 0 ? below(5) : 3 + below(2)];
    if ((scope & kSelf) != 0 && below(4) == 0) return one_of(kOfSelf);
    if (below(6) == 0) return "?*list*";
    for (;;)
      if (const char* chosen = one_of(kValues); (types_of(chosen) & types) != 0) return chosen;
  }

  std::minstd_rand random_;
};

/// A part of a line: a word, or a list with its parentheses.
struct Part {
  std::size_t begin, end;
  unsigned scope;
};

/// The lists and words of a line where an expression can stand, but for what is inside of texts.
std::vector<Part> parts_of(std::string_view line) {
  std::vector<Part> parts;
  struct Open {
    std::size_t begin;
    unsigned scope;
    bool named = false, holds = false;
  };
  std::vector<Open> open;
  unsigned scope = 0;
  if (line.starts_with("(defmessage-handler")) scope = kSelf;
  std::size_t i = 0;
  const auto add = [&](std::size_t begin, std::size_t end) {
    if (open.empty() || open.back().holds) parts.push_back({begin, end, open.empty() ? scope : open.back().scope});
  };
  while (i < line.size()) {
    const char c = line[i];
    if (c == ' ') {
      ++i;
    } else if (c == '(') {
      open.push_back({i++, open.empty() ? scope : open.back().scope});
    } else if (c == ')') {
      if (open.empty()) return parts;
      const std::size_t begin = open.back().begin;
      open.pop_back();
      add(begin, ++i);
    } else {
      const std::size_t begin = i;
      if (c == '"') {
        for (++i; i < line.size() && line[i] != '"'; ++i)
          if (line[i] == '\\') ++i;
        i = std::min(i + 1, line.size());
      } else {
        i = std::min(line.find_first_of(" ()\"", i), line.size());
      }
      if (!open.empty() && !open.back().named) {
        const std::string_view name = line.substr(begin, i - begin);
        open.back().named = true;
        open.back().holds = !name.starts_with("def") && name != "order" && name != "list" && name != "object";
        if (name.find("do-for-") != std::string_view::npos || name.starts_with("find-") || name.starts_with("any-"))
          open.back().scope |= kSlots | (name.find("fact") != std::string_view::npos ? kFacts : kInstances);
      } else {
        add(begin, i);
      }
    }
  }
  return parts;
}

std::vector<std::string> lines_of(std::string_view text) {
  std::vector<std::string> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    if (end > 0) lines.emplace_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

std::string text_of(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + '\n';
  return text;
}

/// Writes the lines that fit; returns their size.
std::size_t put(std::vector<std::string> lines, std::uint8_t* data, std::size_t most) {
  std::string text = text_of(lines);
  while (text.size() > most && !lines.empty()) {
    lines.erase(lines.begin());
    text = text_of(lines);
  }
  std::copy(text.begin(), text.end(), data);
  return text.size();
}

/// Another expression in the place of one, one around or before it, or one of another place.
void change(std::vector<std::string>& lines, Writer& writer) {
  std::string& line = lines[writer.below(lines.size())];
  const std::vector<Part> parts = parts_of(line);
  if (parts.empty()) return;
  const Part part = parts[writer.below(parts.size())];
  std::string instead;
  switch (writer.below(6)) {
    case 5: {
      const std::string effect = writer.expression(part.scope, static_cast<int>(writer.below(4)));
      instead = "(progn " + effect + ' ' + line.substr(part.begin, part.end - part.begin) + ')';
      break;
    }
    case 0: instead = writer.around(line.substr(part.begin, part.end - part.begin), part.scope); break;
    case 1: {
      const std::string& other = lines[writer.below(lines.size())];
      const std::vector<Part> others = parts_of(other);
      if (others.empty()) return;
      const Part taken = others[writer.below(others.size())];
      instead = other.substr(taken.begin, taken.end - taken.begin);
      break;
    }
    default: instead = writer.expression(part.scope, static_cast<int>(writer.below(4)));
  }
  line.replace(part.begin, part.end - part.begin, instead);
}

/// The files of the run: those of a folder.
class Files : public cxlab::FileAccess {
 public:
  void clear() {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  cxlab::Expected<std::string> for_reading(const std::string& name) override {
    if (name.empty() || name.size() > 20 || name.find_first_of("/.") != std::string::npos)
      return cxlab::Error{cxlab::ErrorKind::kInput, "no file of the run", {}, 0, {}};
    return (folder_ / name).string();
  }
  cxlab::Expected<std::string> for_writing(const std::string& name) override { return for_reading(name); }

 private:
  std::filesystem::path folder_ = cxlab::fuzz::folder() / "effects";
};

/// An environment with kWorld, for one input.
class World {
 public:
  World() {
    limits_.steps = 200'000;
    limits_.memory = 200'000'000;
    limits_.disk = 1'000'000;
    cxlab::EngineOptions options;
    options.limits = &limits_;
    options.files = &files_;
    options.max_load_firings = 50;
    options.on_output = [this](std::string_view, std::string_view text) {
      if (said_.size() < 100'000) said_ += text;
    };
    auto made = RuleEngine::create(std::move(options));
    cxlab::fuzz::promise(made.ok(), "there is an environment");
    engine_ = std::move(*made);
    const cxlab::LoadReport loaded = engine_->load_text(kWorld, "world.clp", LoadMode::kBatch);
    cxlab::fuzz::promise(loaded.ok(),
                         "the world loads: " + (loaded.ok() ? std::string() : loaded.errors.front().text()));
  }

  /// What the lines print and leave behind.
  std::string play(const std::vector<std::string>& lines) {
    static const bool show = std::getenv("CXLAB_FUZZ_SHOW") != nullptr;
    files_.clear();
    for (const std::string& line : lines) {
      if (limits_.exceeded) break;
      if (show) std::fprintf(stderr, "%s\n", line.c_str());
      const cxlab::LoadReport report =
          engine_->load_text(line, "effects.clp", LoadMode::kBatch, OnLoadError::kKeepGoing);
      for (const cxlab::RuleError& error : report.errors) {
        if (show)
          std::fprintf(stderr, "  ; %s: %s\n", std::string(to_string(error.side)).c_str(), error.message.c_str());
        said_ += error.text() + '\n';
      }
      (void)engine_->run(20);
    }
    cxlab::fuzz::promise(
        !limits_.exceeded || limits_.exceeded->kind != cxlab::ErrorKind::kBug,
        "CLIPS finds its data in order: " + (limits_.exceeded ? limits_.exceeded->text() : std::string()));
    for (const cxlab::FactCopy& fact : engine_->facts()) said_ += fact.print() + '\n';
    for (const cxlab::FactCopy& instance : engine_->instances("MAIN")) said_ += instance.print() + '\n';
    for (const auto& [name, value] : engine_->globals()) said_ += name + " = " + value.print() + '\n';
    for (const cxlab::RuleError& error : engine_->take_errors()) said_ += error.text() + '\n';
    return std::move(said_);
  }

 private:
  Files files_;
  cxlab::LimitsInUse limits_;
  std::string said_;
  std::unique_ptr<RuleEngine> engine_;
};

/// Plays the lines in an environment that comes to its end, and does the same as the first one.
void compare(const std::vector<std::string>& lines, const std::string& first) {
  const std::string second = World().play(lines);
  if (first != second) {
    const auto [a, b] = std::mismatch(first.begin(), first.end(), second.begin(), second.end());
    const auto at = std::max<std::ptrdiff_t>(0, a - first.begin() - 200);
    std::fprintf(stderr, "first:\n%s\nsecond:\n%s\n", first.substr(static_cast<std::size_t>(at), 400).c_str(),
                 second.substr(static_cast<std::size_t>(at), 400).c_str());
  }
  cxlab::fuzz::promise(first == second, "two environments do the same");
}

}  // namespace

/// Counting how rare each thing is that an input covers would take a quarter of the time.
extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  static char entropic[] = "-entropic=0";
  static std::vector<char*> arguments(*argv, *argv + *argc);
  arguments.insert(arguments.begin() + 1, entropic);
  arguments.push_back(nullptr);
  *argv = arguments.data();
  ++*argc;
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed) {
  Writer writer(seed);
  std::vector<std::string> lines = lines_of(cxlab::fuzz::text_of(data, size));
  for (std::size_t i = 1 + writer.below(3); i > 0; --i) {
    const std::size_t kind = lines.empty() ? 0 : writer.below(8);
    if (kind <= 1) {
      for (std::string& line : lines_of(writer.place())) lines.push_back(std::move(line));
    } else if (kind == 2) {
      std::swap(lines[writer.below(lines.size())], lines[writer.below(lines.size())]);
    } else if (kind == 3 && lines.size() > 3) {
      lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(writer.below(lines.size())));
    } else {
      change(lines, writer);
    }
  }
  return put(std::move(lines), data, most);
}

extern "C" std::size_t LLVMFuzzerCustomCrossOver(const std::uint8_t* one, std::size_t one_size,
                                                 const std::uint8_t* other, std::size_t other_size, std::uint8_t* out,
                                                 std::size_t most, unsigned seed) {
  Writer writer(seed);
  std::vector<std::string> lines;
  for (std::string& line : lines_of(cxlab::fuzz::text_of(one, one_size)))
    if (writer.below(3) != 0) lines.push_back(std::move(line));
  for (std::string& line : lines_of(cxlab::fuzz::text_of(other, other_size)))
    if (writer.below(3) != 0) lines.push_back(std::move(line));
  return put(std::move(lines), out, most);
}

/// CLIPS forgets small blocks on errors of many functions. Stacks of each block, and 256 MB of freed blocks that each
/// input touches again, would take a third of the time; ASAN_OPTIONS=malloc_context_size=9 shows who made and freed a
/// block.
FUZZ_TARGET(effects, "detect_leaks=0:malloc_context_size=1:quarantine_size_mb=16") {
  const std::vector<std::string> lines = lines_of(cxlab::fuzz::text_of(data, size));
  if (lines.empty()) return 0;
  static const auto world = std::make_unique<World>();
  // The end of an environment touches all of its memory, which is then copied.
  const bool to_the_end = size % 8 == 0;
  cxlab::fuzz::in_copy([&] {
    const std::string said = world->play(lines);
    if (to_the_end) compare(lines, said);
  });
  return 0;
}

}  // namespace fuzz_effects
