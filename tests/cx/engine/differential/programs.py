"""CLIPS programs for differential.py: generated ones, and all rules that come with cxlab. Each is (name, constructs, commands)."""

import json
import pathlib
import re
import subprocess

SOURCE = pathlib.Path(__file__).parents[4]


class Chance:
    """The same numbers with every Python."""

    def __init__(self, seed):
        self.state = (seed * 2654435761 + 12345) & 0xFFFFFFFFFFFFFFFF

    def below(self, n):
        self.state = (self.state * 6364136223846793005 + 1442695040888963407) & 0xFFFFFFFFFFFFFFFF
        return (self.state >> 33) % n

    def of(self, values):
        return values[self.below(len(values))]

    def often(self, percent):
        return self.below(100) < percent

    def some(self, low, high, make):
        return [make() for _ in range(low + self.below(high - low + 1))]


WATCHED = ["(watch facts)", "(watch rules)", "(watch activations)"]
AFTER = ["(facts)", "(agenda)", "(show-defglobals)"]
SYMBOLS = ["red", "blue", "nil", "TRUE", "x-1"]


class Facts:
    """Rules over three templates and ordered facts, with every conditional element."""

    def __init__(self, seed):
        self.c = Chance(seed)
        self.names = 0

    def number(self):
        return str(self.c.below(4))

    def variable(self, bound):
        return self.c.of(bound) if bound else None

    def constraint(self, bound, new):
        """A constraint of an INTEGER slot."""
        c = self.c
        kind = c.below(9)
        known = self.variable(bound)
        if kind == 0 or (kind > 4 and not known):
            return self.number()
        if kind == 1:
            return f"{self.number()}|{self.number()}"
        if kind == 2:
            return f"~{self.number()}"
        if kind in (3, 4):
            return new()
        if kind == 5:
            return f"{new()}&:({c.of(['<', '>', '<>', '>='])} {known} {self.number()})"
        if kind == 6:
            return f"{new()}&~{known}"
        if kind == 7:
            return f"=(mod (+ {known} 1) 4)"
        return known

    def pattern(self, bound, introduces=True):
        """A pattern and the variables that it binds."""
        c = self.c
        made = []

        def new():
            self.names += 1
            name = f"?v{self.names}"
            made.append(name)
            return name

        if c.often(25):
            parts = c.some(1, 3, lambda: c.of([self.number(), "$?", "?", new() if not made else self.number()]))
            text = f"(list {' '.join(parts)})"
        else:
            t = c.below(3)
            slots = []
            if c.often(80):
                slots.append(f"(a {self.constraint(bound, new)})")
            if c.often(50):
                slots.append(f"(b {c.of(SYMBOLS[:2] + ['~red', 'red|nil', '?'])})")
            if c.often(30):
                slots.append(f"(c {c.of(['$?', '$? 1 $?', '? $?', '0 1', '$? ?'])})")
            text = f"(t{t} {' '.join(slots)})"
        if introduces:
            # A variable inside of a not, exists or forall is not seen outside of it; one behind & | ~ alone binds nothing.
            bound += [v for v in made if re.search(r"[( ]" + re.escape(v) + r"(?![0-9])", text)]
        return text

    def element(self, bound, depth=0):
        c = self.c
        kind = c.below(14 if depth < 2 else 8)
        if kind < 8:
            return self.pattern(bound)
        if kind == 8 and bound:
            return f"(test ({c.of(['<', '=', '<>'])} {c.of(bound)} {self.number()}))"
        inner = list(bound)
        if kind in (8, 9, 10):
            return f"(not {self.pattern(inner) if c.often(60) else '(and ' + self.pattern(inner) + ' ' + self.pattern(inner) + ')'})"
        if kind == 11:
            return f"(exists {' '.join(c.some(1, 2, lambda: self.pattern(inner)))})"
        if kind == 12:
            return f"(forall {self.pattern(inner)} {' '.join(c.some(1, 2, lambda: self.pattern(inner)))})"
        first, second = list(bound), list(bound)
        return f"(or {self.element(first, depth + 1)} {self.element(second, depth + 1)})"

    def action(self, bound, addresses):
        c = self.c
        value = lambda: c.of(bound) if bound and c.often(60) else self.number()
        kind = c.below(9)
        if kind in (0, 1):
            return f"(assert (t{c.below(3)} (a (mod (+ {value()} 1) 5)) (b {c.of(SYMBOLS)})))"
        if kind == 2:
            return f"(assert (list {value()} {c.of(SYMBOLS)} {value()}))"
        if kind == 3 and addresses:
            address, template = c.of(addresses)
            if template.startswith("t"):
                return f"(modify {address} (a (mod (+ {value()} 1) 6)) (b {c.of(SYMBOLS)}))"
        if kind in (3, 4) and addresses:
            return f"(retract {c.of(addresses)[0]})"
        if kind == 5:
            return f"(if (> {value()} 1) then (printout t high crlf) else (assert (list low {value()})))"
        if kind == 6:
            return f"(loop-for-count (?i 1 {value()}) do (printout t ?i \" \"))"
        if kind == 7:
            return f"(bind ?*sum* (+ ?*sum* {value()}))"
        return f"(printout t {value()} \" \" {c.of(SYMBOLS)} crlf)"

    def rule(self, n):
        c = self.c
        bound, addresses, elements = [], [], []
        for _ in range(1 + c.below(4)):
            if c.often(30):
                pattern = self.pattern(bound)
                self.names += 1
                addresses.append((f"?f{self.names}", pattern[1:].split()[0].strip("()")))
                elements.append(f"?f{self.names} <- {pattern}")
            else:
                elements.append(self.element(bound))
        if c.often(10):
            elements = [f"(logical {elements[0]})"] + elements[1:] if "<-" not in elements[0] else elements
        salience = f"(declare (salience {c.below(7) - 3})) " if c.often(40) else ""
        # Only variables of patterns that all alternatives have are safe to use; others are errors that both must report.
        actions = c.some(1, 3, lambda: self.action(bound, addresses))
        return f"(defrule r{n} {salience}{' '.join(elements)}\n  =>\n  {' '.join(actions)})"

    def fact(self):
        c = self.c
        if c.often(25):
            return f"(list {' '.join(c.some(1, 3, self.number))})"
        return f"(t{c.below(3)} (a {self.number()}) (b {c.of(SYMBOLS)}) (c {' '.join(c.some(0, 3, self.number))}))"

    def program(self):
        c = self.c
        constructs = [f"(deftemplate t{i} (slot a (type INTEGER)) (slot b (default {c.of(SYMBOLS)})) (multislot c))" for i in range(3)]
        constructs.append("(defglobal ?*sum* = 0)")
        constructs.append("(deffacts start " + " ".join(c.some(2, 6, self.fact)) + ")")
        constructs += [self.rule(i) for i in range(3 + c.below(6))]
        commands = [f"(set-strategy {c.of(['depth', 'breadth', 'lex', 'mea', 'complexity', 'simplicity'])})"] + WATCHED + ["(reset)", "run 40"]
        for _ in range(2 + c.below(3)):
            commands += [f"(assert {self.fact()})" for _ in range(1 + c.below(2))] + ["run 30"]
        return constructs, commands + AFTER


class Expressions:
    """Functions of CLIPS with arguments of all types, right and wrong ones."""

    # Name, then the types of its arguments: n number, i integer, s string, y symbol, m multifield, b boolean, v any; + more
    FUNCTIONS = """+ n n +|- n n +|* n n +|/ n n|div i i|mod i i|max n n +|min n n +|abs n|float n|integer n|sqrt n|** n n|exp i|log n
    log10 n|round n|sin n|cos n|tan n|atan n|atan2 n n|deg-rad n|rad-deg n|pi|acos n|asin n|sinh n|cosh n|tanh n
    = n n|<> n n|< n n +|> n n|<= n n|>= n n|eq v v|neq v v|and b b|or b b|not b
    numberp v|floatp v|integerp v|lexemep v|stringp v|symbolp v|multifieldp v|evenp i|oddp i|pointerp v
    str-cat v v +|sym-cat v v|sub-string i i s|str-index s s|upcase s|lowcase s|str-compare s s|str-length s|string-to-field s
    eval s|str-replace s s s|str-byte-length s
    create$ v v +|nth$ i m|member$ v m|subsetp m m|delete$ m i i|explode$ s|implode$ m|subseq$ m i i|replace$ m i i v|insert$ m i v
    first$ m|rest$ m|length$ m|delete-member$ m v|replace-member$ m v v|expand$ m|intersection$ m m +|union$ m m +|difference$ m m +
    sort > m|length$ s|if b then v else v|progn v v|nth$ i s|foreach-x m
    (format) s|switch-x i|loop-x i|while-x i|do-x m""".replace("\n", "|")

    def __init__(self, seed):
        self.c = Chance(seed)
        self.functions = [f.split() for f in self.FUNCTIONS.split("|") if f.strip()]

    def literal(self, kind):
        c = self.c
        if kind == "v" or c.often(4):
            kind = c.of("nisymb")
        if kind == "n":
            return c.of(["0", "1", "-3", "2.5", "-0.5", "1e3", "7", "100", "3.0", "0.1"])
        if kind == "i":
            return c.of(["0", "1", "2", "3", "-1", "5"])
        if kind == "s":
            return c.of(['""', '"abc"', '"a b 1 2.5"', '"\\"q\\""', '"(+ 1 2)"', '"ä"', '"b"', '"%d"'])
        if kind == "y":
            return c.of(["red", "nil", "TRUE", "crlf", "abc"])
        if kind == "b":
            return c.of(["TRUE", "FALSE"])
        return c.of(["(create$)", "(create$ 1 2 3)", "(create$ a \"b\" 2.5)", "(create$ 3 1 2 1)", "(create$ x)"])

    def call(self, depth):
        c = self.c
        name, *types = c.of(self.functions)
        more = types[-1:] == ["+"]
        if more:
            types = types[:-1] + [types[-2]] * c.below(3)
        arguments = [t if t in (">", "then", "else") else self.value(t, depth - 1) for t in types]
        if name == "(format)":
            directive = c.of(["%d", "%5d", "%-5d|", "%f", "%.2f", "%8.3e", "%g", "%s", "%10s|", "%-6s|", "%c", "%x", "%o", "%%", "%5.1f%n"])
            return f"(format nil \"<{directive}>\" {self.literal(c.of('nisyv'))})"
        if name == "foreach-x":
            return f"(foreach ?x {arguments[0]} (printout t ?x \"@\" ?x-index \" \"))"
        if name == "do-x":
            return f"(progn$ (?y {arguments[0]}) (if (numberp ?y) then (return ?y)))" if c.often(50) else f"(progn$ (?y {arguments[0]}) (printout t ?y \",\"))"
        if name == "switch-x":
            return f"(switch {arguments[0]} (case 1 then one) (case 2 then two) (default {self.value('v', 0)}))"
        if name == "loop-x":
            return f"(loop-for-count (?k 0 {arguments[0]}) do (if (> ?k 2) then (break)) (printout t ?k))"
        if name == "while-x":
            return f"(while (< ?*n* {c.of(['2', '5', 'red', '4.5'])}) do (bind ?*n* (+ ?*n* 1)))"
        return f"({' '.join([name] + arguments)})"

    def value(self, kind, depth):
        return self.call(depth) if depth > 0 and self.c.often(45) else self.literal(kind)

    def program(self):
        c = self.c
        constructs = ["(defglobal ?*n* = 0)",
                      "(deffunction fact (?n) (if (<= ?n 1) then 1 else (* ?n (fact (- ?n 1)))))",
                      "(deffunction all ($?all) (length$ ?all))",
                      "(defmethod kind ((?x INTEGER)) integer)", "(defmethod kind ((?x NUMBER)) (str-cat number \"/\" (call-next-method)))"
                      if c.often(20) else "(defmethod kind ((?x NUMBER)) number)",
                      "(defmethod kind ((?x LEXEME) (?y (> ?y 1))) two)", "(defmethod kind ((?x STRING)) string)"]
        commands = []
        for _ in range(40):
            commands.append(f"(println (implode$ (create$ {self.call(3)})))" if c.often(30) else f"(println {self.call(3)})")
        for _ in range(6):
            commands.append(f"(println (kind {self.literal('v')}))")
            commands.append(f"(println (fact {c.below(12)}) (all {self.value('m', 1)} {self.literal('v')}))")
        return constructs, commands + ["(show-defglobals)"]


class Objects:
    """Classes that inherit, message-handlers of all kinds, patterns of objects."""

    def __init__(self, seed):
        self.c = Chance(seed)

    def program(self):
        c = self.c
        number = lambda: str(c.below(5))
        constructs = ["(defclass A (is-a USER) (role concrete) (pattern-match reactive) (slot x (default 1)) (multislot m))",
                      f"(defclass B (is-a A) (role concrete) (pattern-match reactive) (slot y (default {number()})) (slot x (source composite) (default 2)))",
                      "(defclass C (is-a USER) (role concrete) (pattern-match reactive) (slot z (default-dynamic (gensym))))"
                      .replace("(gensym)", "(+ 1 1)"),
                      f"(defclass D (is-a {c.of(['A C', 'B C', 'C B'])}) (role concrete) (pattern-match reactive) (slot w (visibility public) (access {c.of(['read-write', 'initialize-only'])})))",
                      "(defglobal ?*log* = 0)"]
        for i in range(2 + c.below(4)):
            of = c.of("ABCD")
            kind = c.of(["primary", "before", "after", "around"])
            message = c.of(["show", "grow", "put-x", "init"] if of != "C" else ["show", "grow", "init"])
            if message in ("put-x", "init") and kind == "primary":
                kind = "after"
            arguments = "(?v)" if message in ("put-x", "grow") else "()"
            body = f"(printout t {of} \" {kind} {message} \" (instance-name ?self) crlf)"
            if kind == "around":
                body += " (call-next-handler)"
            if message == "grow" and kind == "primary":
                body += f" (bind ?*log* (+ ?*log* ?v)) {'(call-next-handler)' if c.often(30) else ''}"
                if of != "C":
                    body += " (bind ?self:x (+ ?self:x ?v))"
            constructs.append(f"(defmessage-handler {of} {message} {kind} {arguments} {body})")
        constructs.append("(definstances start " + " ".join(
            f"(i{i} of {c.of('ABCD')})" for i in range(3 + c.below(3))) + ")")
        for i in range(2 + c.below(4)):
            patterns = [f"(object (is-a {c.of('ABCD')}) (name ?n))" if c.often(50) else
                        f"(object (is-a {c.of('AB')}) (x ?x&:(> ?x {number()})))",
                        c.of(["", f"(not (object (is-a {c.of('AB')}) (x {number()})))", f"?o <- (object (is-a A) (m $? {number()} $?))",
                              "(exists (object (is-a C)))"])]
            actions = [f"(printout t r{i} \" fires\" crlf)"]
            if "?o <-" in patterns[1]:
                actions.append(c.of(["(send ?o delete)", "(unmake-instance ?o)", "(modify-instance ?o (m))", "(printout t (instance-name ?o) crlf)"]))
            constructs.append(f"(defrule r{i} {' '.join(patterns)} => {' '.join(actions)})")
        commands = ["(watch instances)", "(watch rules)", "(watch activations)", "(watch slots)", "(reset)", "run 20"]
        for _ in range(8 + c.below(6)):
            i = c.below(6)
            commands.append(c.of([
                f"(send [i{i}] grow {number()})", f"(send [i{i}] put-x {number()})", f"(make-instance j{c.below(3)} of {c.of('ABCD')} (x {number()}))",
                f"(send [i{i}] show)", f"(println (send [i{i}] get-x))", f"(modify-instance [i{i}] (x {number()}))", f"(send [i{i}] print)",
                f"(duplicate-instance [i{i}] to k{c.below(2)} (x 3))", f"(unmake-instance [i{i}])", f"(send [i{i}] put-m {number()} {number()})",
                f"(println (class [i{i}]) (instancep [i{i}]))", "(println (find-all-instances ((?a A)) (> ?a:x 1)))",
                f"(println (any-instancep ((?b B)) (= ?b:x {number()})))", "(do-for-all-instances ((?a A ) (?c C)) TRUE (println ?a ?c))",
                f"(println (class-slots {c.of('ABCD')} inherit) (superclassp A {c.of('BCD')}) (slot-default-value B x))"]))
            if c.often(30):
                commands.append("run 10")
        return constructs, commands + ["run 20", "(instances)", "(agenda)", "(show-defglobals)"]


class Modules:
    """Modules with focus, salience of all kinds, defaults and allowed values, queries of facts, generic functions."""

    def __init__(self, seed):
        self.c = Chance(seed)

    def program(self):
        c = self.c
        constructs = ["(defmodule MAIN (export ?ALL))",
                      "(deftemplate MAIN::job (slot id (type INTEGER) (range 0 9)) (slot state (allowed-values open busy done) (default open)) (multislot tags (cardinality 0 3)))",
                      "(defglobal MAIN ?*high* = 50)",
                      "(defmodule WORK (import MAIN ?ALL) (export deftemplate note))", "(deftemplate WORK::note (slot text (type STRING SYMBOL)))",
                      "(defmodule CHECK (import MAIN ?ALL) (import WORK deftemplate note))",
                      "(deffacts MAIN::jobs " + " ".join(f"(job (id {i}) (tags {' '.join(c.some(0, 3, lambda: c.of(SYMBOLS)))}))" for i in range(2 + c.below(3))) + ")"]
        for i in range(3 + c.below(4)):
            module = c.of(["MAIN", "WORK", "CHECK"])
            salience = c.of(["", "(declare (salience ?*high*))", f"(declare (salience {c.below(100)}))",
                             "(declare (salience (- ?*high* 10)) )", "(declare (auto-focus TRUE))"])
            condition = c.of([f"?j <- (job (id ?id) (state {c.of(['open', 'busy', '~done'])}))", "(job (id ?id) (tags $? red $?)) ?j <- (job (id ?id))",
                              "?j <- (job (id ?id) (state open)) (not (job (id ?other&:(< ?other ?id)) (state open)))"])
            action = c.of(["(modify ?j (state busy))", "(modify ?j (state done))", f"(focus {c.of(['WORK', 'CHECK', 'MAIN'])})", "(return)",
                           "(bind ?*high* (- ?*high* 5)) (modify ?j (state busy))", "(pop-focus)", "(halt)", "(retract ?j)",
                           "(assert (note (text \"seen\")))" if module != "MAIN" else "(printout t main crlf)"])
            constructs.append(f"(defrule {module}::r{i} {salience} {condition} => (printout t r{i} \" \" ?id \" \" (get-current-module) crlf) {action})")
        commands = ["(watch rules)", "(watch focus)", "(watch facts)", "(watch globals)",
                    f"(set-salience-evaluation {c.of(['when-defined', 'when-activated', 'every-cycle'])})", "(reset)",
                    f"(focus {c.of(['WORK CHECK', 'CHECK', 'MAIN WORK', 'CHECK WORK MAIN'])})", "(list-focus-stack)", "run 30"]
        for _ in range(6 + c.below(6)):
            commands.append(c.of([
                f"(assert (job (id {c.below(12)}) (state {c.of(['open', 'busy', 'lost'])})))", "run 10", "(refresh-agenda *)", "(focus WORK)", "(clear-focus-stack)",
                "(do-for-all-facts ((?j job)) (eq ?j:state open) (modify ?j (state busy)))", "(println (length$ (find-all-facts ((?j job)) (> ?j:id 1))))",
                "(println (any-factp ((?j job) (?k job)) (< ?j:id ?k:id)))", "(do-for-fact ((?j job)) TRUE (println (fact-slot-value ?j id)) (retract ?j))",
                "(delayed-do-for-all-facts ((?j job)) TRUE (retract ?j))", "(println (deftemplate-slot-names job) (deftemplate-slot-default-value job state))",
                "(println (deftemplate-slot-range job id) (deftemplate-slot-allowed-values job state))", "(rules *)", "(list-defglobals *)",
                f"(undefrule r{c.below(4)})", f"(refresh r{c.below(4)})", f"(matches r{c.below(5)} terse)", "(println (get-focus-stack))",
                f"(set-break r{c.below(4)})", "(show-breaks)", "(duplicate 1 (state done))", "(save-facts-x)", f"(ppdefrule WORK::r{c.below(5)})",
                "(dependents 1)", "(println (fact-index (nth$ 1 (find-fact ((?j job)) TRUE))))", "(set-fact-duplication TRUE)", f"(remove-break r{c.below(4)})"]))
        return constructs, commands + ["run 30", "(facts MAIN)", "(agenda *)", "(list-focus-stack)", "(show-defglobals *)"]


def plugins(program):
    """All functions and constructs of plugins, from cxlab doc."""
    doc = json.loads(subprocess.run([program, "doc", "--json"], check=True, capture_output=True, text=True).stdout)
    functions, constructs = set(), []
    for plugin in doc:
        functions |= {f["name"] for f in plugin["functions"]}
        constructs += [c["text"] for c in plugin["constructs"]]
    return sorted(functions), constructs


def files():
    """The rule files that come with cxlab, by program: agents whole, of the rest each file."""
    rcll = "scenarios/rcll/agent/clips/"
    groups = {"rcll": [rcll + f + ".clp" for f in
                       ["facts", "skills", "refbox", "jobs", "robots", "exploration", "payments", "cap-stations", "orders", "products",
                        "shared-machines", "recovery", "maintenance"]],
              "hypothesis": ["scenarios/turtlesim/agents/clips/" + f + ".clp" for f in ["straight", "hypothesis"]],
              "pddl": ["cx/packages/cx_pddl_clips/clips/deftemplates.clp", "cx/packages/cx_pddl_clips/clips/pddl.clp"]}
    known = {f for group in groups.values() for f in group}
    for folder in ("cx", "docs", "scenarios"):
        for path in sorted((SOURCE / folder).rglob("*.clp")):
            name = str(path.relative_to(SOURCE))
            if name not in known:
                groups[name] = [name]
    return groups


def value_of(c, slot):
    kind = re.search(r"\(type ([^)]*)\)", slot)
    allowed = re.search(r"\(allowed-(?:values|symbols|strings) ([^)]*)\)", slot)
    if allowed:
        return c.of(allowed[1].split())
    kind = kind[1].split()[0] if kind else "SYMBOL"
    return {"INTEGER": str(c.below(4)), "FLOAT": c.of(["0.0", "1.5", "20.0"]), "STRING": c.of(['""', '"robot1"', '"C-BS"']),
            "NUMBER": str(c.below(3)), "SYMBOL": c.of(["IDLE", "robot1", "TRUE", "FALSE", "nil", "C-BS", "OPEN"])}.get(kind)


def forms(text):
    """The forms of a file, as texts, without comments."""
    out, depth, at, start = [], 0, 0, 0
    clean, in_text = [], False
    i = 0
    while i < len(text):
        ch = text[i]
        if in_text and ch == "\\":
            clean.append(text[i:i + 2])
            i += 2
            continue
        if ch == '"':
            in_text = not in_text
        if ch == ";" and not in_text:
            while i < len(text) and text[i] != "\n":
                i += 1
            continue
        clean.append(ch)
        i += 1
    text = "".join(clean)
    in_text = False
    while at < len(text):
        ch = text[at]
        if in_text and ch == "\\":
            at += 2
            continue
        if ch == '"':
            in_text = not in_text
        elif not in_text and ch == "(":
            if depth == 0:
                start = at
            depth += 1
        elif not in_text and ch == ")":
            depth -= 1
            if depth == 0:
                out.append(text[start:at + 1])
        at += 1
    return out


def among_plugins(seed, names, functions, constructs):
    """Rules of files, with functions of plugins that return symbols, and facts of all their templates by chance."""
    c = Chance(seed)
    made = ["(deffunction now () 12.5)", "(deffunction cx-shutdown () TRUE)"]
    made += [f"(deffunction {f} ($?arguments) {c.of(['FALSE', 'TRUE', '(create$)', '5', 'IDLE'])})" for f in functions if f not in ("now", "cx-shutdown")]
    made += constructs
    commands = []
    for name in names:
        for form in forms((SOURCE / name).read_text()):
            (made if form.startswith("(def") else commands).append(" ".join(form.split()) if not form.startswith("(def") else form)
    commands = [c_ for c_ in commands if not re.match(r"\((load|batch|bload|unwatch|watch|path-)", c_)]
    facts = []
    for form in made:
        head = re.match(r"\(deftemplate\s+(\S+)", form)
        if not head:
            continue
        slots = re.findall(r"\((slot|multislot)\s+([^\s()]+)((?:\s*\([^()]*\))*)", form)
        for _ in range(3):
            chosen = []
            for kind, slot, rest in slots:
                value = value_of(c, rest)
                if value is not None and c.often(70):
                    chosen.append(f"({slot} {value})")
            facts.append(f"(assert ({head[1]} {' '.join(chosen)}))")
    play = ["(reset)"] + commands + ["run 30"]
    for i in range(12):
        play += [c.of(facts) if facts else "(assert (start))" for _ in range(4)] + [f"(assert (time {i}.5))", "run 30"]
    return made, WATCHED + play + AFTER


def generated():
    for kind, make, count in (("facts", Facts, 90), ("expressions", Expressions, 35), ("objects", Objects, 40), ("modules", Modules, 35)):
        for seed in range(count):
            yield (f"{kind}-{seed}", *make(seed).program())


def shipped(program):
    """`program` is cxlab."""
    functions, constructs = plugins(program)
    for group, names in files().items():
        for seed in range(4 if len(names) > 1 else 1):
            yield (f"{group}-{seed}", *among_plugins(seed, names, functions, constructs))
