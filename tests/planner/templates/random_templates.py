"""Random templates: what Jinja makes of them, and what the project's engine does.

python3 random_templates.py RENDERER SEED COUNT   exit 0 if all that Jinja can render is the same, 77 if Jinja is not installed

RENDERER reads one JSON object of templates a line and answers {"out": TEXT} or {"err": MESSAGE} a line.
"""

import json
import random
import re
import subprocess
import sys
import warnings

# Variables of the templates, by type; other names are undefined.
VARIABLES = {"number": ["n", "m"], "text": ["s", "t"], "list": ["l", "k"], "table": ["d"], "truth": ["y"]}
PRELUDE = "{% set n, m, s, t = 3, 2.5, 'aB c', 'one two' %}{% set l, k, y = [3, 1, 2], ['b', 'A', 'c'], true %}{% set d = {'b': 1, 'a': 'z'} %}"
LITERALS = {
    "number": ["1", "2", "0", "-1", "3.5", "0.5", "10", "100", "7"],
    "text": ["'a'", "'Bc'", "'x y'", "''", "'12'", "'a,b,c'", "'line\\nnext'", "' sp '", "'<i>'"],
    "list": ["[]", "[1,2,3]", "['b','A','a']", "(1,'q')", "range(3)", "range(1,8,3)", "[[1,2],[3]]", "['x','x','y']"],
    "table": ["{}", "{'a':1,'b':'z'}", "{'k':[1,2]}", "dict(a=1, b=2)", "{'k':'one','two':2}"],
    "truth": ["true", "false", "none"],
}
TABLES = ["[{'a':1,'b':2},{'a':3,'b':1}]", "[{'a':'x'},{'a':'Y'}]", "[{'a':1},{'b':2}]", "[{'a':2,'b':'q'},{'a':2,'b':'p'},{'a':1,'b':'r'}]"]
FILTERS = {  # by type of the operand: (filter, type of the result)
    "number": [("abs", "number"), ("float", "number"), ("int", "number"), ("round", "number"), ("round(1)", "number"),
               ("round(1,'floor')", "number"), ("round(0,'ceil')", "number"), ("string", "text"),
               ("default(5)", "number"), ("format", "number")],
    "text": [("capitalize", "text"), ("center(9)", "text"), ("default('D')", "text"), ("default('D',true)", "text"),
             ("first", "text"), ("last", "text"), ("float", "number"), ("float(2)", "number"), ("int", "number"),
             ("int(7)", "number"), ("int(3,16)", "number"), ("indent(2)", "text"), ("indent(2,true)", "text"), ("indent(1,blank=true)", "text"),
             ("length", "number"), ("count", "number"), ("list", "list"), ("lower", "text"), ("upper", "text"), ("replace('a','Z')", "text"),
             ("replace('a','Z',1)", "text"), ("reverse", "text"), ("string", "text"), ("title", "text"),
             ("trim", "text"), ("trim('a')", "text"), ("truncate(5)", "text"), ("truncate(5,true)", "text"), ("truncate(5,true,'~')", "text"),
             ("truncate(4,false,'',0)", "text"), ("wordcount", "number"), ("join('-')", "text"), ("sort|join", "text"), ("unique|list", "list")],
    "list": [("batch(2)|list", "list"), ("batch(2,'-')|list", "list"), ("first", "any"), ("last", "any"), ("join", "text"), ("join('-')", "text"),
             ("length", "number"), ("list", "list"), ("map('string')|list", "list"), ("map('upper')|list", "list"), ("map('int')|list", "list"),
             ("map('default','q')|list", "list"), ("reject|list", "list"), ("reject('string')|list", "list"), ("reject('in',[1,'a'])|list", "list"),
             ("select|list", "list"), ("select('number')|list", "list"), ("select('odd')|list", "list"), ("select('eq',1)|list", "list"),
             ("reverse|list", "list"), ("slice(2)|list", "list"), ("slice(2,'-')|list", "list"), ("sort", "list"), ("sort(reverse=true)", "list"),
             ("sort(case_sensitive=true)", "list"), ("string", "text"), ("sum", "number"), ("sum(start=3)", "number"),
             ("unique|list", "list"), ("unique(true)|list", "list"), ("max", "any"), ("min", "any"), ("default([])", "list")],
    "table": [("dictsort", "list"), ("dictsort(reverse=true)", "list"), ("dictsort(by='value')", "list"), ("dictsort(true)", "list"),
              ("items|list", "list"), ("length", "number"), ("list", "list"), ("string", "text"), ("first", "any"), ("join", "text")],
    "tables": [("groupby('a')|map('first')|list", "list"), ("join(', ',attribute='a')", "text"),
               ("map(attribute='a')|list", "list"), ("map(attribute='b',default=0)|list", "list"), ("max(attribute='a')", "table"),
               ("min(attribute='a')", "table"), ("rejectattr('b')|list", "list"), ("rejectattr('a','eq',1)|list", "list"), ("selectattr('b')|list", "list"),
               ("selectattr('a','gt',1)|list", "list"), ("selectattr('b','defined')|list", "list"), ("sort(attribute='a')", "list"),
               ("sort(attribute='a,b')", "list"), ("sum(attribute='a')", "number"), ("unique(attribute='a')|list", "list"), ("map('length')|list", "list")],
    "truth": [("string", "text"), ("default('D',true)", "any"), ("int", "number"), ("d(1)", "any")],
}
METHODS = {
    "text": [("upper()", "text"), ("strip()", "text"), ("split()", "list"), ("split('a')", "list"), ("split(' ',1)", "list"), ("replace('a','b')", "text"),
             ("startswith('a')", "truth"), ("endswith('c')", "truth"), ("count('a')", "number"), ("title()", "text"), ("zfill(4)", "text"),
             ("find('a')", "number"), ("join(['q','r'])", "text"), ("isdigit()", "truth"), ("center(6)", "text"), ("rjust(5)", "text"),
             ("ljust(5,'.')", "text"), ("splitlines()", "list"), ("lower()", "text"), ("lstrip('a')", "text"), ("rsplit('a')", "list"),
             ("isalpha()", "truth"), ("partition(' ')", "list"), ("swapcase()", "text")],
    "table": [("items()|list", "list"), ("keys()|list", "list"), ("values()|list", "list"), ("get('a')", "any"), ("get('q',5)", "any")],
    "list": [("count(1)", "number")],
    "number": [], "truth": [],
}
TESTS = {
    "number": ["odd", "even", "divisibleby 2", "eq 1", "gt 1", "ne 3", "le 2", "float", "integer"],
    "text": ["lower", "upper", "in 'abc'", "eq 'a'", "ne 'a'", "filter", "test"],
    "list": ["iterable", "sequence", "eq []"], "table": ["mapping", "iterable"], "truth": ["true", "false", "boolean", "none", "sameas none"],
}
ANY_TEST = ["defined", "undefined", "none", "number", "string", "mapping", "sequence", "iterable", "boolean", "callable", "true"]
LOOP = ["index", "index0", "revindex", "revindex0", "first", "last", "length", "depth", "depth0", "previtem", "nextitem",
        "cycle('p','q')", "changed(1)", "changed(loop.index)", "previtem is defined", "nextitem|default('none')"]
TYPES = ["number", "text", "list", "table", "truth"]


class Generator:
    def __init__(self, seed):
        self.random = random.Random(seed)
        self.macros = self.blocks = 0
        self.parts = False  # whether there is a template `part` to include and import
        self.captured = False  # in a macro, set, filter or recursive loop, where Jinja takes an include without context for text of the top level

    def pick(self, items):
        return self.random.choice(items)

    def expression(self, depth=0, kind=None):
        kind = kind or self.pick(TYPES)
        if kind == "any":
            kind = self.pick(TYPES + ["undefined"])
        if kind == "undefined":
            return self.pick(["nothing", "d.zz", "l[9]"])
        if depth > 3 or self.random.random() < 0.25:
            return self.pick(VARIABLES[kind]) if self.random.random() < 0.4 else self.pick(LITERALS[kind])
        part = lambda wanted: self.expression(depth + 1, wanted)
        if self.random.random() < 0.15:
            return f"({part(kind)} if {part('truth')} else {part(kind)})"
        ways = [(source, name) for source, filters in FILTERS.items() for name, result in filters if result == kind]
        if ways and self.random.random() < 0.45:
            source, name = self.pick(ways)
            return f"({self.pick(TABLES) if source == 'tables' else part(source)}|{name})"
        ways = [(source, name) for source, methods in METHODS.items() for name, result in methods if result == kind]
        if ways and self.random.random() < 0.3:
            source, name = self.pick(ways)
            return f"({part(source)}).{name}"
        if kind == "number":
            return f"({part(kind)} {self.pick(['+', '-', '*', '/', '//', '%'])} {part(kind)})"
        if kind == "text":
            return self.pick([f"({part('any')} ~ {part('any')})", f"({part(kind)} + {part(kind)})", f"('%s|%5s' % ({part('any')}, {part(kind)}))",
                              f"{part(kind)}[{self.pick(['0', '-1', ':1', '1:', '::2', '::-1'])}]", f"('{{}}-{{:>4}}'.format({part('number')}, {part(kind)}))"])
        if kind == "list":
            return self.pick([f"[{part('any')}, {part('any')}]", f"({part('any')}, {part('any')})", f"({part(kind)}|list + {part(kind)}|list)",
                              f"({part(kind)}|list)[{self.pick([':1', '1:', '::2', '::-1', '-2:'])}]"])
        if kind == "table":
            return self.pick([f"{{'a': {part('any')}, 'b': {part('any')}}}", f"dict(a={part('any')}, b={part('any')})"])
        test = self.pick(TYPES)
        return self.pick([f"({part('number')} {self.pick(['==', '!=', '<', '<=', '>', '>='])} {part('number')})",
                          f"({part('text')} {self.pick(['==', '<', 'in', 'not in'])} {part('text')})", f"({part('any')} in {part('list')})",
                          f"({part('any')} {self.pick(['and', 'or'])} {part('any')})", f"(not {part('any')})",
                          f"({part(test)} is {self.pick(['', 'not '])}{self.pick(TESTS[test])})", f"({part('any')} is {self.pick(ANY_TEST)})",
                          f"({part('number')} < {part('number')} <= {part('number')})"])

    def mark(self):
        return self.pick(["", "", "", "-", "+"])

    def statement(self, depth):
        body = lambda: self.body(depth + 1)

        def captured_body():
            before, self.captured = self.captured, True
            inner = self.body(depth + 1)
            self.captured = before
            return inner

        left, right = self.mark(), self.mark()
        tag = lambda inside: "{%" + left + " " + inside + " " + right + "%}"
        end = lambda inside: "{%" + self.mark() + " " + inside + " " + self.mark() + "%}"
        kind = 0 if depth > 2 else self.random.randrange(17)
        if kind == 14 and self.parts:
            return tag("include " + self.pick(["'part'", "'part'", "'part' with context"] + ([] if self.captured else ["'part' without context"])))
        if kind == 15 and self.parts:
            how = self.pick(["", "", " with context"])
            return tag("import 'part' as p" + how) + "{{ p.v }}{{ p.s is defined }}" if self.random.random() < 0.5 else \
                tag(f"from 'part' import v, s as {self.pick(['s', 'w'])}" + how) + "{{ v }}{{ s }}"
        if kind == 16:
            self.blocks += 1
            return self.block(f"in{self.blocks}", depth) + self.pick(["", "", "{{ self.in" + str(self.blocks) + "() }}"])
        if kind > 13:
            kind = 0
        if kind <= 2:
            return "{{" + self.pick(["", "-"]) + " " + self.expression() + " " + self.pick(["", "-"]) + "}}"
        if kind == 3:
            other = self.pick(["", end("else") + body(), end("elif " + self.expression(1)) + body() + end("else") + body()])
            return tag("if " + self.expression(1)) + body() + other + end("endif")
        if kind in (4, 5):
            target = self.pick(["a", "a", "b", "a, b"])
            over = self.expression(1, self.pick(["list", "list", "table", "text"]))
            if target == "a, b":
                over = self.expression(1, "table") + self.pick(["|items", ".items()", "|dictsort"])
            condition = self.pick(["", "", " if " + self.expression(2, "truth")])
            inside = "{{ loop." + self.pick(LOOP) + " }}"
            other = self.pick(["", "", end("else") + body()])
            return tag(f"for {target} in {over}{condition}") + body() + inside + other + end("endfor")
        if kind == 6:
            return tag(f"for x in {self.pick(['[[1,[2]],[3]]', '[1,[2,[3]]]', self.expression(2, 'list')])} recursive") + \
                "{{ loop.depth }}" + "{% if x is iterable and x is not string %}({{ loop(x) }}){% else %}" + captured_body() + \
                "{% endif %}" + end("endfor")
        if kind == 7:
            kind = self.pick(TYPES)
            return tag(f"set {self.pick(VARIABLES[kind])} = {self.expression(1, kind)}")
        if kind == 8:
            return tag("set " + self.pick(VARIABLES["text"]) + self.pick(["", "", " | upper", " | trim"])) + captured_body() + end("endset")
        if kind == 9:
            return tag(f"with {self.pick(VARIABLES['number'])} = {self.expression(1, 'number')}") + body() + end("endwith")
        if kind == 10:
            self.macros += 1
            name = f"m{self.macros}"
            if self.random.random() < 0.3:
                return tag(f"macro {name}(a)") + captured_body() + "{{ caller(a) }}" + end("endmacro") + \
                    "{% call(b) " + name + f"({self.expression(2)}) %}}" + captured_body() + "{% endcall %}"
            arguments = self.pick([self.expression(2), "", f"b={self.expression(2)}", f"1, {self.expression(2)}"])
            extra = self.pick(["", "{{ varargs }}", "{{ kwargs }}"])
            return tag(f"macro {name}(a, b={self.expression(2)})") + captured_body() + extra + end("endmacro") + "{{ " + name + f"({arguments}) }}}}"
        if kind == 11:
            return tag("filter " + self.pick(["upper", "indent(2)", "trim", "replace('a','q')", "title"])) + captured_body() + end("endfilter")
        if kind == 12:
            return "{% set ns = namespace(n=0) %}" + tag(f"for c in {self.expression(2, 'list')}") + "{% set ns.n = ns.n + 1 %}" + \
                end("endfor") + "{{ ns.n }}"
        return "{%" + self.pick(["", "-", "+"]) + " raw " + self.pick(["", "-"]) + "%}" + self.pick(["{{ n }}", "{% if %}", "x"]) + end("endraw") if self.random.random() < 0.5 else \
            "{#" + self.mark() + " {{ n }} " + self.pick(["", "-"]) + "#}"

    def body(self, depth=0):
        return "".join(self.pick([" ", "\n", "txt ", "<a>\n ", "", "  \n  "]) + self.statement(depth) for _ in range(self.random.randint(1, 3)))

    def block(self, name, depth=0):
        scoped = self.pick(["", "", " scoped"])
        before, self.captured = self.captured, False
        inner = self.body(depth + 1)
        self.captured = before
        if self.random.random() < 0.3:
            inner = "{{ super() if super is defined }}" + inner
        return "{%" + self.mark() + f" block {name}{scoped} " + self.mark() + "%}" + inner + "{% endblock %}"

    def templates(self):
        part = {}
        if self.random.random() < 0.4:
            seen = "".join(self.pick(["{{ a }}", "{{ n }}", "{{ t }}", "{{ loop.index if loop is defined else '-' }}", "{{ b is defined }}"]) for _ in range(3))
            part = {"part": seen + self.body(1) + "{% set v = " + self.expression(2) + " %}{% import 'none' as s %}", "none": ""}
            self.parts = True
        return {**part, **self.family()}

    def family(self):
        kind = self.random.random()
        if kind < 0.45:
            return {"main": PRELUDE + self.body()}
        if kind < 0.6:
            return {"main": PRELUDE + "{{ " + self.expression() + " }}"}
        base = PRELUDE + self.body() + self.block("one") + self.pick(["", "{% for a in [1,2] %}" + self.block("two") + "{% endfor %}"]) + \
            self.pick(["", "{{ self.one() }}"]) + self.body()
        if kind < 0.75:
            stands = self.pick(["{}", "{}", "{{% if y %}}{}{{% endif %}}", "{{% for a in k %}}{}{{% endfor %}}", "{{% with a = 5 %}}{}{{% endwith %}}"])
            return {"base": base, "main": self.pick(["", "before {{ 1 }}"]) + self.pick(["{% extends 'base' %}", "{% if true %}{% extends 'base' %}{% endif %}"]) +
                    self.pick([PRELUDE, ""]) + self.body() + stands.format(self.block("one")) + self.pick(["", self.block("two")])}
        if kind < 0.82:
            middle = "{% extends 'base' %}" + PRELUDE + self.block("one")
            return {"base": base, "mid": middle, "main": "{% extends 'mid' %}" + PRELUDE + self.block("one") + self.pick(["", self.block("two")])}
        if kind < 0.92:
            how = self.pick(["'part'", "'part' without context", "'part' with context", "['nope','part']", "'nope' ignore missing"])
            self.parts = False
            return {"part": self.pick(["", PRELUDE]) + self.body(), "main": PRELUDE + self.body() + "{% include " + how + " %}" + self.body()}
        self.parts = False
        part = PRELUDE + "{% set a = " + self.expression(2) + " %}{% macro m(x=1) %}" + self.body(1) + "{% endmacro %}"
        how = self.pick(["{% import 'part' as p %}{{ p.a }}{{ p.m(2) }}", "{% from 'part' import m, a as b %}{{ m() }}{{ b }}",
                         "{% from 'part' import m with context %}{{ m(n) }}"])
        return {"part": part, "main": PRELUDE + self.body() + how}


def jinja_says(jinja2, templates):
    environment = jinja2.Environment(loader=jinja2.DictLoader(templates), extensions=["jinja2.ext.do"])
    try:
        return environment.get_template("main").render()
    except RecursionError:
        raise
    except Exception:  # of any kind: Python's own for operands, Jinja's for syntax and names
        return None


# Texts that name objects of Python, and generators that Jinja leaves unread, are not compared.
NOT_COMPARED = re.compile(r"object at|<(?!i>)|bound method|built-in|dict_|Undefined|jinja2|function|Markup\(")


def main():
    try:
        import jinja2
    except ImportError:
        print("Jinja is not installed")
        return 77
    warnings.simplefilter("ignore")  # of Python about the code that Jinja writes
    renderer, seed, count = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    cases = []
    for number in range(count):
        templates = Generator(f"{seed}:{number}").templates()
        try:
            cases.append((number, templates, jinja_says(jinja2, templates)))
        except RecursionError:
            continue
    lines = "".join(json.dumps(templates) + "\n" for _, templates, _ in cases)
    answers = subprocess.run([renderer], input=lines, capture_output=True, text=True)
    if answers.returncode != 0:
        print(f"the renderer ended with {answers.returncode}: {answers.stderr}")
        return 1
    equal = failed = stricter = different = 0
    for (number, templates, wanted), line in zip(cases, answers.stdout.split("\n"), strict=False):
        found = json.loads(line)
        if wanted is not None and NOT_COMPARED.search(wanted.replace("<a>", "").replace("<A>", "")):
            continue
        if found.get("out") == wanted:
            equal += wanted is not None
            failed += wanted is None
            continue
        if wanted is None:  # what Python cannot do with a value need not be an error
            stricter += 1
            continue
        different += 1
        if different <= 20:
            print(f"{seed}:{number} {json.dumps(templates)}\n  Jinja: {wanted!r}\n  here:  {found}")
    print(f"{equal} texts are equal, {failed} fail in both, {stricter} fail in Jinja only, {different} differ")
    return 1 if different or equal < count // 10 else 0


if __name__ == "__main__":
    sys.exit(main())
