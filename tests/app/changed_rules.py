"""cxlab diff on games whose agents differ in one rule: it names the rule, and the first event that is another one.

The seed chooses the rule and the change; CXLAB_CHANGES is how many are played. By hand:
python3 -m unittest changed_rules; CXLAB_CHANGES=50 for all that docs/internals/tests-of-answers.md reports.
"""

import json
import os
import random
import re
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

CXLAB = os.environ["CXLAB"]
SOURCE = Path(os.environ["CXLAB_SOURCE_DIR"])
AGENT = SOURCE / "scenarios/rcll/agent"
SECONDS = "100"
COUNT = int(os.environ.get("CXLAB_CHANGES", "7"))


def forms(text, begin, end):
    """(from, to) of the lists and words that stand side by side in this part of a rule file."""
    at = begin
    while at < end:
        if text[at].isspace():
            at += 1
        elif text[at] == ";":
            at = text.index("\n", at)
        else:
            first, depth = at, 0
            while at < end:
                if text[at] == '"':
                    at = re.compile(r'"(\\.|[^"\\])*"', re.S).match(text, at).end() - 1
                elif text[at] == ";":
                    at = text.index("\n", at)
                depth += (text[at] == "(") - (text[at] == ")")
                at += 1
                if depth == 0 and (text[at - 1] == ")" or at == end or text[at].isspace() or text[at] in "()"):
                    break
            yield first, at


class Rule:
    """A rule of a file, taken apart: its conditions and its actions as parts of the text."""

    def __init__(self, text, begin, end):
        self.text, self.begin, self.end = text, begin, end
        parts = list(forms(text, begin + 1, end - 1))
        words = [text[a:b] for a, b in parts]
        self.name = words[1]
        arrow = words.index("=>")
        first = 2
        while first < arrow and (words[first].startswith('"') or words[first].startswith("(declare")):
            first += 1
        self.after_name = parts[first - 1][1]
        self.conditions = []
        at = first
        while at < arrow:
            begin_of_one = parts[at][0]
            if words[at].startswith("?") and words[at + 1] == "<-":
                at += 2
            self.conditions.append((begin_of_one, parts[at][1]))
            at += 1
        self.actions = parts[arrow + 1:]

    def replaced(self, begin, end, by):
        return self.text[:begin] + by + self.text[end:]


def rules_of(text):
    return [Rule(text, a, b) for a, b in forms(text, 0, len(text)) if text[a:b].startswith("(defrule")]


def drop_condition(rule, chance):
    if len(rule.conditions) > 1:
        return rule.replaced(*chance.choice(rule.conditions), "")


def drop_action(rule, chance):
    if len(rule.actions) > 1:
        return rule.replaced(*chance.choice(rule.actions), "")


def change_constant(rule, chance):
    end_of_conditions = rule.conditions[-1][1]
    numbers = list(re.compile(r"(?<=[ (])\d+(\.\d+)?(?=[ )])").finditer(rule.text, rule.begin, rule.end))
    symbols = list(re.compile(r"(?<=[ (|~])[A-Z][A-Z-]+(?=[)|&])").finditer(rule.text, rule.after_name, end_of_conditions))
    if not numbers + symbols:
        return None
    at = chance.choice(numbers + symbols)
    by = at[0] + "X" if at in symbols else str(float(at[0]) + 1 if "." in at[0] else int(at[0]) + 1)
    return rule.replaced(at.start(), at.end(), by)


def change_salience(rule, chance):
    return rule.replaced(rule.after_name, rule.after_name, f"\n  (declare (salience {chance.choice((-10, 10))}))")


def negate_condition(rule, chance):
    lists = [(a, b) for a, b in rule.conditions if rule.text[a] == "(" and not rule.text[a:b].startswith(("(test", "(not", "(or", "(exists"))]
    if lists:
        a, b = chance.choice(lists)
        return rule.replaced(a, b, f"(not {rule.text[a:b]})")


def rename(rule, _):
    name = rule.text.index(rule.name, rule.begin)
    return rule.replaced(name, name + len(rule.name), "other-" + rule.name)


def remove(rule, _):
    return rule.replaced(rule.begin, rule.end, "")


CHANGES = [drop_condition, change_constant, change_salience, drop_action, negate_condition, rename, remove]


class ChangedRules(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = Path(tempfile.mkdtemp(prefix="cxlab-changed-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        (cls.folder / "game.yaml").write_text((SOURCE / "scenarios/rcll/game.yaml").read_text())
        loaded = (AGENT / "params/agent.yaml").read_text()
        cls.files = [file for file in sorted((AGENT / "clips").glob("*.clp")) if f'"clips/{file.name}"' in loaded]
        # Rules that fire in the game: those of faults have nothing to do there.
        shutil.copytree(AGENT, cls.folder / "agent")
        cls.before = cls.play("before")
        fired = json.loads(cls.cxlab("rules", cls.before, "--json").stdout)["environments"][0]["rules"]
        cls.fired = {rule["rule"] for rule in fired if rule["fired"]}

    @classmethod
    def cxlab(cls, *arguments):
        return subprocess.run([CXLAB, *map(str, arguments)], capture_output=True, text=True, cwd=cls.folder, timeout=300)

    @classmethod
    def play(cls, name):
        """The folder of the game, or None if its rules do not load."""
        cls.cxlab("run", "game.yaml", "--tier", "timed", "--until", SECONDS, "--journal", "full", "--quiet", "--out", name)
        file = cls.folder / name / "result.json"
        result = json.loads(file.read_text()) if file.is_file() else {}
        loaded = result.get("stream_hashes") and not any(error["side"] == "load" for error in result["rule_errors"])
        return cls.folder / name if loaded else None

    def change(self, number):
        """Plays with another rule; the rule's name and the game, once a change gives rules that load."""
        chance = random.Random(f"change {number}")
        change = CHANGES[number % len(CHANGES)]
        while True:
            file = chance.choice(self.files)
            rules = [rule for rule in rules_of(file.read_text()) if rule.name in self.fired]
            if not rules:
                continue
            rule = chance.choice(rules)
            text = change(rule, chance)
            if text is None:
                continue
            (self.folder / "agent/clips" / file.name).write_text(text)
            game = self.play(f"after-{number}")
            shutil.copy(file, self.folder / "agent/clips" / file.name)
            if game:
                return change.__name__, rule.name, game
            shutil.rmtree(self.folder / f"after-{number}", ignore_errors=True)

    def first_difference(self, game):
        """The time of the first record of rules that differs between the two journals."""
        def lines(folder):
            with open(folder / "journal.jsonl") as file:
                return [line for line in file if line.startswith('{"stream":"env/agent"')]
        a, b = lines(self.before), lines(game)
        for one, other in zip(a, b):
            if one != other:
                return min(json.loads(one)["t"], json.loads(other)["t"]) / 1e9
        return None if len(a) == len(b) else json.loads(max(a, b, key=len)[min(len(a), len(b))])["t"] / 1e9

    def test_the_changed_rule_and_its_first_consequence_are_named(self):
        differ = named = 0
        for number in range(COUNT):
            change, rule, game = self.change(number)
            with self.subTest(number=number, change=change, rule=rule):
                done = self.cxlab("diff", self.before, game, "--json")
                self.assertIn(done.returncode, (0, 1), done.stderr)
                found = json.loads(done.stdout)
                names = {c["name"] for c in found["constructs"] if c["kind"] == "defrule"}
                self.assertEqual(names, {rule, "other-" + rule} if change == "rename" else {rule})
                self.assertEqual(len(found["constructs"]), len(names))
                at = self.first_difference(game)
                if at is None or at > found["compared_s"]:
                    self.assertIsNone(found["first"])
                else:
                    differ += 1
                    self.assertAlmostEqual(found["first"]["t_s"], at)
                    sides = found["first"]["a"], found["first"]["b"]
                    self.assertTrue(any(side["what"] for side in sides))
                    named += rule in json.dumps(sides)
            shutil.rmtree(game)
        print(f"{COUNT} changes: all rules are named; {differ} games differ, and in {named} of them what differs first names the rule, too")
        self.assertGreater(differ, COUNT // 2)


if __name__ == "__main__":
    unittest.main()
