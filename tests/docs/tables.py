"""Tables of the reference pages agree with what the sources declare: keys, fields, codes, messages. Lists needs the program."""

import json
import os
import re
import subprocess
import unittest
from pathlib import Path

from markdown_pages import SOURCE

# (page, heading of the table, file of the declaration, name of its struct, prefix of the keys on the page)
SETTINGS = [
    ("scenario.md", "world", "scenarios/rcll/rules/config.h", "WorldConfig", ""),
    ("scenario.md", "timed", "sim/skills/timed_config.h", "TimedSkillsConfig", ""),
    ("rcll-protocol.md", "Settings", "scenarios/rcll/rules/config.h", "RefboxConfig", "refbox."),
    ("rcll-protocol.md", "league_client: an outside referee box", "scenarios/rcll/refbox/league_link.h", "LeagueClientConfig", ""),
    ("turtlesim.md", "Settings", "scenarios/turtlesim/config.h", "Config", ""),
]
SIMPLE = re.compile(r"-?[\d.]+|true|false|\"[^\"]*\"")


def read(name):
    return (SOURCE / name).read_text()


def section(page, heading):
    """The text below a heading of a page of the reference, up to the next heading of the same level or a higher one."""
    text = read(f"docs/reference/{page}")
    found = re.search(rf"^(#+) {re.escape(heading)}$", text, re.MULTILINE)
    assert found, f"docs/reference/{page} has no heading '{heading}'"
    rest = text[found.end():]
    end = re.search(rf"^#{{1,{len(found.group(1))}}} ", rest, re.MULTILINE)
    return rest[:end.start()] if end else rest


def tables(text):
    """Each table as (heads of its columns, rows of cells)."""
    for found in re.finditer(r"(?:^\|.*\|\n)+", text + "\n", re.MULTILINE):
        rows = [[cell.strip() for cell in re.split(r"(?<!\\)\|", line.strip()[1:-1])] for line in found.group(0).strip().split("\n")]
        yield rows[0], rows[2:]


def table(text, head):
    """The rows of the first table whose first column has this head."""
    for heads, rows in tables(text):
        if heads[0] == head:
            return rows
    raise AssertionError(f"there is no table with the head '{head}'")


def words(cell):
    """What stands in code in a cell."""
    return re.findall(r"`([^`]+)`", cell)


def body_of(text, struct):
    found = re.search(rf"^struct {struct} \{{\n(.*?)^\}};", text, re.MULTILINE | re.DOTALL)
    assert found, f"there is no struct {struct}"
    return found.group(1)


def declared(file, struct):
    """Key -> default as written, of those that the struct reads."""
    body = body_of(read(file), struct)
    members = re.findall(r"^  [\w:<>]+ ((?:\w+ = [^,;]+(?:, )?)+);", body, re.MULTILINE)
    defaults = {name: value for member in members for name, value in re.findall(r"(\w+) = ([^,;]+)", member)}
    return {key: defaults.get(variable, "") for key, variable in re.findall(r"keys(?:\.\w+)?\(\"(\w+)\", (\w+)", body)}


def literal(text):
    """A default as the pages write it: without quotes, numbers without a trailing point."""
    text = text.strip().strip("`").replace("'", "").strip('"')
    try:
        return float(text)
    except ValueError:
        return text


class Settings(unittest.TestCase):
    def test_each_key_is_in_its_table_with_its_default(self):
        for page, heading, file, struct, prefix in SETTINGS:
            shown = {}
            for name in ("Key", "Setting"):
                for heads, rows in tables(section(page, heading)):
                    if heads[0] == name:
                        for row in rows:
                            keys = words(row[0])
                            values = row[1].split(", ") if len(keys) > 1 and row[1].count(", ") == len(keys) - 1 else [row[1]] * len(keys)
                            shown.update(zip(keys, values))
            keys = {prefix + key: default for key, default in declared(file, struct).items()}
            with self.subTest(page=page, struct=struct):
                self.assertGreater(len(keys), 4)
                self.assertEqual(sorted(shown), sorted(keys))
            for key, default in keys.items():
                with self.subTest(page=page, key=key):
                    if SIMPLE.fullmatch(default):
                        self.assertEqual(literal(shown.get(key, "")), literal(default))

    def test_keys_of_a_scenario(self):
        reader = read("scenarios/read_scenario.cpp")
        read_scenario = reader[reader.index("if (const yaml::Value world = map.get(\"world\")"):]
        keys = set(re.findall(r"(?:get|read|read_word|require)\(\"(\w+)\"", read_scenario)) | {"schema", "tier", "timed", "planner", "bag", "faults"}
        shown = {key for row in table(section("scenario.md", "Keys"), "Key") for key in words(row[0])}
        self.assertEqual(sorted(shown), sorted(keys))

    def test_keys_of_the_pddl_manager(self):
        keys = set(re.findall(r"keys(?:\.\w+)?\(\"(\w+)\"", read("scenarios/pddl/node.cpp")))
        text = section("pddl-manager.md", "Settings")
        self.assertEqual(sorted(keys), sorted({key for row in table(text, "Key of the node") for key in words(row[0])}))
        cost = set(re.findall(r"keys(?:\.\w+)?\(\"(\w+)\"", body_of(read("planner/cost.h"), "PlanningCost")))
        self.assertEqual(sorted(cost), sorted({key for row in table(text, "Key of `planner`") for key in words(row[0])}))

    def test_keys_of_a_game_file(self):
        text = section("game-files.md", "Keys") + section("game-files.md", "Errors")
        for key in declared("scenarios/rcll/rules/config.h", "GameFile"):
            with self.subTest(key):
                self.assertRegex(text, rf"\b{key}:")

    def test_keys_of_a_story(self):
        reader = read("cx/testing/story_file.cpp")
        keys = set(re.findall(r"(?:get|has|require|read|read_seconds|read_word)\(\"(\w+)\"", reader))
        keys |= {key for group in re.findall(r"std::array\{([^}]*)\}", reader) for key in re.findall(r"\"(\w+)\"", group)}
        shown = set(words(re.sub(r"```.*?```", "", read("docs/reference/stories.md"), flags=re.DOTALL)))
        shown = {word for text in shown for word in re.findall(r"\w+", text)} | {"common", "stories"}
        self.assertGreater(len(keys), 30)
        self.assertEqual(sorted(keys - shown), [])


class Codes(unittest.TestCase):
    def test_error_codes_of_skills(self):
        codes = re.findall(r"= (\d+),", re.search(r"enum class SkillCode.*?\};", read("sim/skills/skill.h"), re.DOTALL).group(0))
        self.assertEqual([row[0] for row in table(section("skills.md", "Error codes"), "Code")], sorted(codes, key=int))

    def test_codes_of_check(self):
        codes = re.search(r"& codes\(\) \{.*?\}\};", read("cx/check/check.cpp"), re.DOTALL).group(0)
        named = re.findall(r"\{+\"([a-z-]+)\",", codes) + ["unused-allow"]
        self.assertEqual([words(row[0])[0] for row in table(section("check.md", "Codes"), "Code")], named)

    def test_parameters_of_the_planning_agent(self):
        rules = "".join(file.read_text() for folder in ("agent", "planning_agent") for file in sorted((SOURCE / "scenarios/rcll" / folder / "clips").rglob("*.clp")))
        asked = set(re.findall(r"\((?:ros-param-get-value|one-of|at-least [\d.]+) \"([\w.]+)\"", rules))
        shown = {words(row[0])[0] for row in table(section("planning-agent.md", "Parameters"), "Parameter")}
        of_the_rule_agent = {"choices.interval"}
        self.assertLessEqual(of_the_rule_agent, {name for name in asked if f"`{name}`" in read("docs/reference/learning.md")})
        self.assertEqual(sorted(shown), sorted(asked - of_the_rule_agent))


class Points(unittest.TestCase):
    def test_points_are_those_of_the_referee(self):
        constants = {name: [int(number) for number in re.findall(r"-?\d+", value)]
                     for name, value in re.findall(r"^constexpr std::int64_t (k\w+Points)(?:\[\])? ?=? ?\{?([^;]*?)\}?;", read("scenarios/rcll/rules/referee.cpp"), re.MULTILINE)}
        points = dict(table(section("rcll.md", "Points"), "Event"))
        rules = {row[0]: row[2] for row in table(section("rcll.md", "Rule sets"), "Case")}
        for event, name in (("delivery of C0, C1, C2, C3", "kDeliveryPoints"), ("each ring of a delivered product, of price 0, 1, 2", "kRingPoints"),
                            ("cap of a delivered product", "kCapPoints"), ("STORE or RETRIEVE", "kStoragePoints")):
            with self.subTest(event):
                self.assertEqual([int(number) for number in points[event].split(", ")], constants[name])
        for event, name in (("cap retrieved", "kBufferPoints"), ("base on a slide that has room", "kPaymentPoints")):
            self.assertEqual([int(points[event].split()[0])], constants[name])
        self.assertEqual(points["competitive order, first / second"], f"+{constants['kCompetitivePoints'][0]} / -{constants['kCompetitivePoints'][0]}")
        for case, name in (("instruction without a workpiece", "kNoWorkpiecePoints"), ("workpiece dropped", "kDropPoints"),
                           ("workpiece put on a machine of the other team", "kForeignMachinePoints")):
            self.assertEqual([int(rules[case].split(",")[0])], constants[name])


class Templates(unittest.TestCase):
    def test_slots_and_values_of_the_agents(self):
        rules = "".join(file.read_text() for folder in ("agent", "planning_agent") for file in sorted((SOURCE / "scenarios/rcll" / folder / "clips").rglob("*.clp")))
        slots, values = {}, {}
        for name, body in re.findall(r"^\(deftemplate ([\w-]+)(.*?)(?=^\(|\Z)", rules, re.MULTILINE | re.DOTALL):
            slots[name] = re.findall(r"\((?:multi)?slot ([\w-]+)", body)
            values.update({(name, slot): allowed.split() for slot, allowed in re.findall(r"\(slot ([\w-]+)[^\n]*\(allowed-values ([^)]*)\)", body)})
        for page in ("rcll-agent.md", "planning-agent.md"):
            for heads, rows in tables(section(page, "Templates")):
                for row in rows:
                    with self.subTest(page=page, row=row[0]):
                        if heads[0] == "Template" and "ordered fact" not in row[2]:
                            self.assertEqual([words(part) for part in row[2].split(";")], [slots[name] for name in words(row[0])])
                        elif heads[0] == "Slot":
                            slot, *names = words(row[0])
                            for name in names:
                                self.assertEqual(words(row[1]), values[name, slot])


class Messages(unittest.TestCase):
    def test_fields_and_types_of_the_game(self):
        shown, message = {}, ""
        rows = table(section("rcll-topics.md", "Messages"), "Message")
        for row in rows:
            message = (words(row[0]) or [message])[0]
            kinds = row[2].split(", ")
            fields = words(row[1])
            for field, kind in zip(fields, kinds * len(fields) if len(kinds) == 1 else kinds):
                shown[message, field] = kind.strip("`")
        for file in sorted((SOURCE / "cx/interfaces/rcll_interfaces/msg").glob("*.msg")):
            fields = re.findall(r"^([\w/]+(?:\[\])?) (\w+)(?: +[^#\s]+)?\s*(?:#.*)?$", file.read_text(), re.MULTILINE)
            there = {field: kind for (message, field), kind in shown.items() if message == file.stem}
            with self.subTest(file.stem):
                if there:
                    self.assertEqual(there, {field: kind for kind, field in fields})
                else:  # described in the row of a message that holds it
                    row = next(row for row in rows if row[2] == f"`{file.stem}[]`")
                    self.assertLessEqual({field for _, field in fields}, set(words(row[3])))

    def test_events_of_the_referee(self):
        rows = {word: " ".join(row[1:]) for row in table(section("journal.md", "The referee of the league"), "`event`") for word in words(row[0])}
        events = re.findall(r"^struct \w+ \{\n(?:(?!^\};).)*?kWords\{([^}]*)\};(.*?)^\};", read("scenarios/rcll/rules/event.h"), re.MULTILINE | re.DOTALL)
        self.assertGreater(len(events), 12)
        for names, body in events:
            for word in re.findall(r"\"([^\"]+)\"", names):
                with self.subTest(word):
                    self.assertIn(word, rows)
                    for field in re.findall(r"io(?:\.when)?\((?:[^\"]*, )?\"(\w+)\"", body):
                        self.assertIn(f"`{field}`", rows[word])


def cxlab(*arguments):
    return subprocess.run([os.environ["CXLAB"], *arguments], text=True, check=True, stdout=subprocess.PIPE).stdout


@unittest.skipUnless(os.environ.get("CXLAB"), "CXLAB names no program")
class Lists(unittest.TestCase):
    def test_functions_and_parameters_of_plugins(self):
        pages = {}
        for file in sorted((SOURCE / "docs/reference/plugins").glob("*.md")):
            text = file.read_text()
            if title := re.match(r"# (cx::\w+)\n", text):
                pages[title.group(1)] = text
        for plugin in json.loads(cxlab("doc", "--json")):
            if plugin["plugin"] not in pages:
                continue
            text = re.sub(r"```.*?```", "", pages.pop(plugin["plugin"]), flags=re.DOTALL)
            with self.subTest(plugin["plugin"]):
                shown = {name for call in words(text) for name in re.findall(r"^\(([a-z0-9-]+)[ )]", call)}
                functions = {function["name"] for function in plugin["functions"]}
                self.assertLessEqual(functions, shown)
                for heads, rows in tables(text):
                    if heads[0] == "Function":
                        in_table = {name for row in rows for call in words(row[0]) for name in re.findall(r"^\(([a-z0-9-]+)", call)}
                        self.assertLessEqual(in_table, functions | {"cx-shutdown"})
                parameters = {name for heads, rows in tables(text) if heads[0] == "Parameter" for row in rows for name in words(row[0])}
                self.assertLessEqual(set(plugin["parameters"]), parameters | {"plugin"})
        self.assertEqual(pages, {}, "pages of plugins that do not exist")

    def test_metrics(self):
        listed = set()
        for line in cxlab("list", "metrics").splitlines():
            unit, better, what, formula = re.fullmatch(r"(?:(\S+) +)?(more|less) +(.*): (.*)", line[11:].split(None, 1)[1]).groups()
            listed.add((line[11:].split()[0], unit or "", better, what, formula))
        shown = {(words(row[0])[0], row[1], row[2], row[3], words(row[4])[0]) for heads, rows in tables(read("docs/reference/metrics.md")) for row in rows}
        self.assertEqual(shown, listed)

    def test_kinds_of_faults_with_their_keys(self):
        listed = cxlab("list", "faults").splitlines()
        kinds = {}
        for name, keys in zip(listed[::2], listed[1::2]):
            own, chance = keys.strip().split("; at | ")
            kinds[name.split()[0]] = (set(own.split(", ")), chance.split(",")[0])
        shown = {words(row[0])[0]: ({key.replace("`", "").split(" ")[0] for key in row[1].split(", ")}, words(row[2])[0])
                 for row in table(section("scenario.md", "Kinds"), "Kind")}
        self.assertEqual(shown, kinds)


if __name__ == "__main__":
    unittest.main()
