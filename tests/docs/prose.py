#!/usr/bin/env python3
"""Finds wording that the project avoids.

It reads pages, comments and string literals of C++, comments and docstrings of CLIPS and Python, and comments of shell, CMake and YAML.
In tests only comments and docstrings of Python count, because their strings are data.

  tests/docs/prose.py [FILE ...]     lists the findings; without files: those of all, counted by file

As a test (python3 -m unittest prose) no file has more findings than its line in ceilings.txt allows, and a new file has none.

The words to avoid are the right column of a table in docs/reference/glossary.md; constructions are in RULES below.
"""

import ast
import re
import sys
import unittest
from collections import Counter
from functools import lru_cache
from pathlib import Path

from markdown_pages import LONGEST_SENTENCE, SOURCE, paragraphs, plain, sentences, tracked, words_of

# (name, pattern, remedy). A pattern is searched in one sentence, from which code is taken out.
RULES = [
    ("elliptical-of", r"^Of (?!course\b)", "begin with the subject, not with an elliptical 'Of'"),
    ("that-there-is", r"\bthat there (?:is|are|was|were)\b", "name the thing: 'that exists', 'the known names'"),
    ("subject-last", r"^(?:What|How|Which|Where|Who|Whether|When)\b[^?]* (?:says?|tells?|shows?|lists?|names?|reports?|decides?) (?:`[^`]*`|\w+)\.?$",
     "put the actor first: '`x` reports how ...'"),
    ("what-is-is", r"^What (?:is|was|has|goes|comes) [^?]*$", "begin with the noun: 'A running step completes', not 'What is under way ...'"),
    ("is-taken", r"\bis taken\.?$", "name the actor: 'cxlab uses it'"),
    ("like-of", r"\bas (?:\w+ )?of any other\b", "say it as a sentence of its own"),
]
LEFT_OUT = ("docs/reference/glossary.md", "third_party/", "lab/pages/", "tests/third_party/")
WITH_HASHES = (".py", ".sh", ".cmake", ".yaml", ".yml", "CMakeLists.txt", "dev", ".ci/run")


@lru_cache
def words_to_avoid():
    """(pattern, remedy) of each row of the glossary."""
    table = (Path(__file__).resolve().parents[2] / "docs/reference/glossary.md").read_text().partition("## Words to use and to avoid")[2]
    rows = re.findall(r"^\| (.+?) \| (.+?) \|$", table, re.MULTILINE)
    return [(re.compile(r"(?<!\w)(?:" + "|".join(re.escape(word.strip()).replace(r"\ ", r"\s+") for word in avoid.split(",")) + r")(?!\w)", re.IGNORECASE),
             use) for use, avoid in rows if (use, avoid) != ("Use", "Avoid")]


@lru_cache
def rules():
    return [(name, re.compile(pattern), remedy) for name, pattern, remedy in RULES]


def check_sentence(sentence):
    """(rule, what is wrong) for one sentence."""
    bare = re.sub(r"`[^`]*`", "`x`", sentence)
    if len(words_of(sentence)) > LONGEST_SENTENCE:
        yield "long-sentence", f"{len(words_of(sentence))} words: divide it"
    for pattern, use in words_to_avoid():
        for found in pattern.finditer(bare):
            yield "word", f"'{found.group(0)}': {use}"
    for name, pattern, remedy in rules():
        if pattern.search(bare):
            yield name, remedy


TOKEN = re.compile(r'//[^\n]*|/\*.*?\*/|R"\w*\(.*?\)\w*"|"(?:[^"\\\n]|\\.)*"|\'(?:[^\'\\\n]|\\.)+\'', re.DOTALL)


def texts_of_cpp(text):
    """(line, text) of comments, neighbouring lines joined, and of string literals without the commands of their examples."""
    comment, literal, last, marker = [], [], 0, ""

    def flush():
        for kind in (comment, literal):
            if kind:
                yield kind[0][0], " ".join(part for _, part in kind) if kind is comment else "".join(part for _, part in kind).partition("Examples:")[0]
                kind.clear()

    for found in TOKEN.finditer(text):
        token, line = found.group(0), text.count("\n", 0, found.start()) + 1
        between = text[last:found.start()]
        last = found.end()
        if between.strip() or between.count("\n") > 1:
            yield from flush()
        if token.startswith("//"):
            if literal:
                yield from flush()
            before, marker = marker, re.match(r"//[/!<]*", token).group(0)
            part = re.sub(r"^//[/!<]*\s?", "", token)
            if marker != before or not part.strip() or re.match(r"\s*(?:[-*]|\d+\.)\s|\s{2,}\S", part):
                yield from flush()
            comment.append((line, part.strip()))
        elif token.startswith('"'):
            if comment:
                yield from flush()
            literal.append((line, token[1:-1].replace("\\n", " ").replace('\\"', '"')))
        else:
            yield from flush()
    yield from flush()


def texts_of_clips(text):
    """(line, text) of comments and of strings with blanks."""
    comment = []
    for number, line in enumerate([*text.splitlines(), ""], 1):
        bare = line.strip()
        if bare.startswith(";"):
            comment.append((number, bare.lstrip("; ")))
            continue
        if comment:
            yield comment[0][0], " ".join(part for _, part in comment)
            comment = []
    for found in re.finditer(r'"((?:[^"\\]|\\.)*)"|;[^\n]*', text):
        if found.group(1):
            yield text.count("\n", 0, found.start()) + 1, " ".join(found.group(1).split())


def comments_with_hashes(text):
    """(line, text) of comments that begin with `#`; lines of their own are joined as long as they are not indented further."""
    comment = []
    for number, line in enumerate([*text.splitlines(), ""], 1):
        found = re.match(r"\s*#(?!!)\s?(.*)$", line)
        if comment and (not found or re.match(r"\s*(?:[-*]|\d+\.)\s|\s{2,}\S|$", found.group(1))):
            yield comment[0][0], " ".join(part for _, part in comment)
            comment = []
        if found:
            comment.append((number, found.group(1).strip()))
        elif behind := re.search(r"\s{2}# ([^'\"]+)$", line):
            yield number, behind.group(1)


def texts_of_python(text):
    """(line, text) of comments, and of the paragraphs and items of docstrings, without lines that are indented further, as those of a usage."""
    yield from comments_with_hashes(text)
    for node in ast.walk(ast.parse(text)):
        if not isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)):
            continue
        indented = re.compile(" " * (node.body[0].col_offset + 2 if node.body else 0))
        for paragraph in (ast.get_docstring(node, clean=False) or "").split("\n\n"):
            for part in re.split(r"^ *- ", paragraph, flags=re.MULTILINE):
                lines = part.splitlines() if part != paragraph else [line for line in part.splitlines() if not indented.match(line)]
                yield node.body[0].lineno, " ".join(" ".join(lines).split())


def by_hand(text):
    """The lines of C++ whose statement puts "found X, expected Y" together by itself, without the helpers of cx/base/expected.h."""
    begin = 0
    for statement in re.split(r"(?<=[;{}])\n", text):
        literals = [found for found in TOKEN.finditer(statement) if found.group(0).startswith('"')]
        for n, first in enumerate(literals):
            behind = [first.group(0).partition("found ")[2], *(one.group(0) for one in literals[n + 1:])]
            if re.search(r"\bfound ", first.group(0)) and any(re.search(r"(?:^\"|[,;] )expected ", one) for one in behind):
                yield text.count("\n", 0, begin + first.start()) + 1
        begin += len(statement) + 1


def texts_of(name, text):
    if name.endswith(".py"):
        return texts_of_python(text)
    if name.endswith(WITH_HASHES):
        return comments_with_hashes(text)
    if name.startswith("tests/"):
        sign = ";" if name.endswith(".clp") else "//"
        text = "\n".join(line if line.lstrip().startswith(sign) else "" for line in text.splitlines())
    return texts_of_clips(text) if name.endswith(".clp") else texts_of_cpp(text)


def findings(name):
    """(line, rule, what is wrong) for a file."""
    text = (SOURCE / name).read_text()
    if name.endswith(".md"):
        spoken = sentences(text)
    else:
        texts = texts_of(name, text)
        spoken = ((line, sentence) for line, spoken_text in texts if len(words_of(spoken_text)) > 3
                  for sentence in re.split(r"(?<=[.!?])\s+(?=[A-Z`'])|;\s", plain(spoken_text)) if sentence)
    if name.endswith((".cpp", ".h")) and not name.startswith(("tests/", "cx/base/expected.")):
        for line in by_hand(text):
            yield line, "found-expected", "call found_expected or found_text of cx/base/expected.h"
    for line, sentence in spoken:
        for rule, what in check_sentence(sentence):
            yield line, rule, what


def files():
    kinds = ("*.md", "*.cpp", "*.h", "*.clp", *("*" + kind if kind.startswith(".") else kind for kind in WITH_HASHES), "*/CMakeLists.txt")
    return [name for name in tracked(*kinds) if not name.startswith(LEFT_OUT) and not (name.startswith("tests/") and name.endswith(".md"))]


@lru_cache
def findings_of_all():
    return {name: list(findings(name)) for name in files()}


class Prose(unittest.TestCase):
    def test_no_file_gets_worse(self):
        from ceilings import Ceilings
        ceilings = Ceilings("prose")
        for name, found in findings_of_all().items():
            with self.subTest(name):
                text = "\n".join(f"{name}:{line}: {rule}: {what}" for line, rule, what in found)
                self.assertLessEqual(len(found), ceilings.of(name), f"more findings than before (tests/docs/ceilings.txt):\n{text}")

    def test_rules_find_what_they_are_for(self):
        for rule, sentence in [("elliptical-of", "Of any other word it is an error."), ("that-there-is", "A name that there is not fails."),
                               ("subject-last", "How far they are from the bound says `upper_bound.py`."), ("what-is-is", "What is running ends."),
                               ("is-taken", "The default is taken."), ("long-sentence", "word " * 31),
                               ("word", "It is drawn anew."), ("word", "The run Shall end."), ("like-of", "As of any other, it counts.".replace("As", "as"))]:
            self.assertIn(rule, [found for found, _ in check_sentence(sentence)], sentence)
        for sentence in ("The rules fire once.", "What is a tick?", "`anew` is a name.", "word " * 30):
            self.assertEqual(list(check_sentence(sentence)), [], sentence)

    def test_messages_put_together_by_hand_are_found(self):
        for source in ('f("found a, expected b");', 'f("found " + a +\n  "; expected b");', 'f("found ", a, b ? "; expected c" : "");'):
            self.assertEqual(list(by_hand("int a;\n" + source + "\n")), [2], source)
        for source in ('f(found_expected(a, "b"));', 'f("found nothing");\ng(", expected b");', '// "found a, expected b"', 'f("has a; expected b");'):
            self.assertEqual(list(by_hand(source + "\n")), [], source)

    def test_texts_are_found(self):
        source = '/// Runs it\n/// again.\nint a;  // later\nauto b = "it is "\n    "drawn";\n// One\n/// Two\n"Do. Examples: cxlab"'
        self.assertEqual(list(texts_of_cpp(source)), [(1, "Runs it again."), (3, "later"), (4, "it is drawn"), (6, "One"), (7, "Two"), (8, "Do. ")])
        self.assertEqual(list(texts_of_clips('; One\n; two.\n(defrule a "Do; it." =>)  ; "no\n')), [(1, "One two."), (3, "Do; it.")])
        shell = '# One\n# two.\nset(a b)  # later\n#   cxlab run\necho "x # y"\n'
        self.assertEqual(list(comments_with_hashes(shell)), [(1, "One two."), (3, "later"), (4, "cxlab run")])
        python = '"""Does it.\n\n  usage\n\n- One\n  item.\n- Two."""\ndef f():\n    """It\n    goes."""\n    return "a # b"\n'
        self.assertEqual([text for _, text in texts_of_python(python) if text], ["Does it.", "One item.", "Two.", "It goes."])
        self.assertEqual(list(texts_of("tests/a.cpp", '// One\n"two";\n')), [(1, "One")])
        self.assertEqual(list(texts_of("app/a.cpp", '// One\n"two";\n')), [(1, "One"), (2, "two")])
        self.assertGreater(len(words_to_avoid()), 10)
        self.assertEqual([text for _, text in paragraphs("a\nb\n\n| c |\n")], ["a b"])


def main():
    names = sys.argv[1:]
    for name in names:
        for line, rule, what in findings(name):
            print(f"{name}:{line}: {rule}: {what}")
    if names:
        return
    count, by_rule, by_kind = Counter(), Counter(), Counter()
    for name, found in findings_of_all().items():
        count[name] += len(found)
        by_kind[name.rpartition(".")[2]] += len(found)
        by_rule.update(rule for _, rule, _ in found)
    for name, number in count.most_common():
        if number:
            print(f"{number:5} {name}")
    print(f"{sum(count.values()):5} findings in {len(count)} files: {dict(by_kind)}, {dict(by_rule)}")


if __name__ == "__main__":
    main()
