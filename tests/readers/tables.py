"""pandas reads the tables and JSON that cxlab writes. ./dev readers"""

import json
import math
import sqlite3
import subprocess
import unittest

import pandas
from lab import CONFIG, CXLAB, SOURCE, Lab

SUITE = r"""scenarios: [empty.yaml, "e, \"x\"\ny.yaml"]
seeds: [1, 9007199254740993]
strategies:
  plain: []
  "a, \"b\"; c": [duration_s=2]
  "None": []
  "1e3": []
  "two\nlines": []
  "é\t'": []
  broken: ["packages={rules: rules}", "agents=[{config: agent.yaml}]"]
"""
STRATEGIES = ["plain", 'a, "b"; c', "None", "1e3", "two\nlines", "é\t'", "broken"]
FIGURES = ["real_time_factor", "wall_time_s", "sim_time_s", "plans"]
RULES = r"""(deftemplate decision (slot what) (slot number) (slot real) (multislot list))
(defrule decide "A fact that the journal keeps."
  (start 1)
  =>
  (assert (decision (what "a, \"b\"
<c> é") (number 9223372036854775807) (real 1e300) (list 0.1 (/ 1.0 3) 1))))
(defrule decide-more (start 2) => (assert (decision (what (format nil "%c%c" 1 200)) (real (* 1e308 10)) (number -9223372036854775808))))
(deffacts starts (start 1))
(defrule again (declare (salience -1)) (start 1) => (assert (start 2)))
"""


class Tables(Lab):
    def cxlab(self, *arguments, code=0):
        done = subprocess.run([CXLAB, *map(str, arguments)], cwd=self.folder, text=True, capture_output=True, timeout=300)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done.stdout

    def json(self, *arguments, code=0):
        """An answer, which is JSON without NaN, and its fields as pandas sees them."""
        answer = json.loads(self.cxlab(*arguments, "--json", code=code), parse_constant=self.fail)
        table = pandas.json_normalize(answer)
        self.assertEqual(len(table), len(answer) if isinstance(answer, list) else 1)
        return answer, table

    def integers(self, table, *columns):
        for column in columns:
            self.assertTrue(pandas.api.types.is_integer_dtype(table[column]), f"{column}: {table[column].dtype}")

    def real_numbers(self, table, *columns):
        for column in columns:
            self.assertTrue(pandas.api.types.is_float_dtype(table[column]), f"{column}: {table[column].dtype}")

    def test_rows_of_a_bench(self):
        self.write("empty.yaml", "schema: 1\nduration_s: 1\n")
        self.write('e, "x"\ny.yaml', "schema: 1\nduration_s: 1\n")
        self.write("agent.yaml", CONFIG)
        self.write("rules/rules.clp", "(defrule wrong (time ?) => (+ 1 (nth$ 1 (create$ one))))")
        self.write("suite.yaml", SUITE)
        lines, _ = self.json("bench", "suite.yaml", "-j", 2, "--out", "o", code=1)
        rows = pandas.read_csv(self.folder / "o/rows.csv", keep_default_na=False, na_values=[""])
        keys = [(scenario, strategy, seed) for scenario in ("empty", 'e, "x"\ny') for strategy in STRATEGIES for seed in (1, 9007199254740993)]
        self.assertEqual(list(zip(rows.scenario, rows.strategy, rows.seed)), keys)
        self.integers(rows, "seed", "exit")
        self.real_numbers(rows, *(figure for figure in FIGURES if figure in rows))
        self.assertEqual(rows.groupby("strategy").status.unique().map(list).to_dict(), {name: ["failed" if name == "broken" else "completed"] for name in STRATEGIES})
        self.assertTrue((rows.journal_hash.str.len() == 32).all())
        self.assertTrue(rows.game.isna().all())

        files = [pandas.read_json(path, typ="series", dtype=False) for path in (self.folder / "o/rows").glob("*.json")]
        self.assertEqual(sorted((f.scenario, f.strategy, f.seed, f.exit, f.journal_hash) for f in files),
                         sorted(zip(rows.scenario, rows.strategy, rows.seed, rows.exit, rows.journal_hash)))

        # The index has the same rows, with the figures of the machine.
        with sqlite3.connect(self.folder / "o/runs.sqlite") as database:
            index = pandas.read_sql("SELECT * FROM runs ORDER BY cell", database)
            messages = pandas.read_sql("SELECT * FROM messages JOIN runs USING (cell)", database)
        self.assertEqual(list(zip(index.scenario, index.strategy, index.seed)), keys)
        self.integers(index, "cell", "seed", "exit", "completed")
        self.real_numbers(index, *FIGURES, "cpu_s", "peak_rss_mb")
        self.assertTrue((index.cpu_s > 0).all())
        common = [column for column in rows if column not in ("game",)]
        pandas.testing.assert_frame_equal(index[common], rows[common], check_exact=True)
        self.assertEqual(set(messages[messages.kind == "error"].strategy), {"broken"})

        played = index[index.status == "completed"].groupby(["scenario", "strategy"])
        for line in lines:
            if line["strategy"] == "broken":
                self.assertEqual((line["episodes"], line["completed"]), (2, 0))
                continue
            of_line = played.get_group((line["scenario"], line["strategy"]))
            for figure in FIGURES:
                counts = [line[figure][name] for name in ("n", "mean", "min", "max")]
                expected = [len(of_line), of_line[figure].mean(), of_line[figure].min(), of_line[figure].max()]
                self.assertTrue(all(math.isclose(*pair, rel_tol=1e-12) for pair in zip(counts, expected)), (figure, counts, expected))

    def test_rows_of_games_by_their_files(self):
        self.write("game.yaml", "schema: 1\nworld: {kind: rcll, production_s: 20, overtime_s: 0}\ntier: timed\n")
        for name in ('a, "b"', "1", "NA"):
            self.cxlab("new", "game", f"games/{name}.yaml", "--seed", 3)
        self.write("suite.yaml", "scenarios: [game.yaml]\ngames: games\nstrategies: {none: []}\n")
        self.cxlab("bench", "suite.yaml", "--out", "o")
        rows = pandas.read_csv(self.folder / "o/rows.csv", keep_default_na=False, na_values=[""], dtype={"game": str})
        self.assertEqual(list(rows.game), ["1", "NA", 'a, "b"'])
        self.assertEqual(list(rows.status), ["completed"] * 3)

    def test_journal_of_rules(self):
        self.agent(RULES)
        self.cxlab("run", "scenario.yaml", "--quiet", "--out", "out", "--journal", "full")
        lines = (self.out / "journal.jsonl").read_text().splitlines()
        journal = pandas.read_json(self.out / "journal.jsonl", lines=True, precise_float=True)
        self.assertEqual(len(journal), len(lines))
        self.assertEqual(list(journal.columns), ["stream", "n", "t", "kind", "data", "cause"])
        self.integers(journal, "n", "t")
        for _, of_stream in journal.groupby("stream"):
            self.assertEqual(list(of_stream.n), list(range(len(of_stream))))
        self.assertTrue(journal.t.is_monotonic_increasing)
        decisions = pandas.json_normalize(journal[journal.kind == "decision"].data.tolist(), max_level=1)
        decisions = decisions.set_index("slots.number").sort_index()
        first, second = decisions.loc[9223372036854775807], decisions.loc[-9223372036854775808]
        self.assertEqual((first["slots.what"], first["slots.real"], first["slots.list"]), ('"a, "b"\n<c> é"', 1e300, [0.1, 1 / 3, 1]))
        self.assertEqual((second["slots.what"], second["slots.real"]), ('"\x01\ufffd"', "inf"))
        index = pandas.read_json(self.out / "files/index.jsonl", lines=True)
        self.assertIn("rules.clp", {name.split("/")[-1] for name in index.name})
        self.assertTrue(index.hash.map(lambda hash: (self.out / "files" / hash).is_file()).all())

    def test_a_game(self):
        result, table = self.json("run", SOURCE / "scenarios/rcll/game.yaml", "--tier", "timed", "--until", 200, "--seed", 1, "--journal", "full", "--out", "out")
        self.assertEqual(json.loads((self.out / "result.json").read_text(), parse_constant=self.fail), result)
        self.real_numbers(table, "sim_time_s", "real_time_factor")
        self.integers(table, "schema", "seed", "ticks", "plans")
        orders, deliveries, robots = (pandas.DataFrame(result[name]) for name in ("orders", "deliveries", "robots"))
        self.integers(orders, "id", "points")
        self.integers(robots, "skills", "failures")
        self.real_numbers(robots, "busy_s", "drive_s", "wait_s")
        self.assertEqual(list(robots.name), ["robot1", "robot2", "robot3"])
        journal = pandas.read_json(self.out / "journal.jsonl", lines=True)
        self.assertEqual(len(journal), len((self.out / "journal.jsonl").read_text().splitlines()))
        self.integers(journal, "n", "t")
        self.assertLessEqual(journal.t.max(), result["sim_time_s"] * 1e9)
        self.assertFalse(journal[["stream", "n", "t", "kind", "data"]].isna().any().any())
        scores = pandas.json_normalize(journal[(journal.kind == "referee")].data.tolist())
        points = scores[scores.event == "score"].points.sum() if "points" in scores else 0
        self.assertEqual(points, sum(team["points"] for team in result["teams"].values()))
        ends = pandas.json_normalize(journal[journal.kind == "skill"].data.tolist())
        self.assertEqual((ends.event == "start").sum() > 0, robots.skills.sum() > 0)
        report = json.loads((self.out / "report.json").read_text(), parse_constant=self.fail)
        skills = pandas.DataFrame(report["skills"])
        self.assertEqual(len(skills), len(report["skills"]))
        for command in (["replay", "out"], ["rerun", "out", "--out", "again"]):
            self.json(*command)

    def test_a_training(self):
        example = SOURCE / "docs/examples/rl"
        self.cxlab("env", example / "example.yaml", "--package", f"example={example}", "--with", "cx_rl_node", "--param", "cx_rl_node.max_episodes=20",
                   "--until", 300, "--quiet", "--out", "out")
        table = pandas.read_csv(self.out / "training.csv")
        self.assertEqual(len(table), len((self.out / "training.csv").read_text().splitlines()) - 1)
        self.assertEqual(list(table.columns), ["episode", "steps", "reward", "end"])
        self.integers(table, "episode", "steps")
        self.assertTrue(pandas.api.types.is_numeric_dtype(table.reward))
        self.assertTrue(table.episode.is_monotonic_increasing and not table.isna().any().any())
        json.loads((self.out / "model.json").read_text(), parse_constant=self.fail)

    def test_answers(self):
        self.write("r.clp", "(defrule go (start) => (assert (gone)))\n(defrule deaf (nothing) => (assert (heard)))\n")
        self.write("r.story.yaml", "- story: 'a, \"b\"'\n  rules: r.clp\n  given: [(start)]\n  expect: [{fires: go, within_s: 1}]\n- story: 'null'\n  rules: r.clp\n  expect: [{fires: go, within_s: 1}]\n")
        answer, _ = self.json("test", "--coverage", "c.info", code=1)
        stories, rules = pandas.DataFrame(answer["stories"]), pandas.DataFrame(answer["rules"])
        self.assertEqual(list(stories.passed), [True, False])
        self.real_numbers(stories, "wall_s", "sim_time_s")
        self.integers(rules, "line", "fired", "activated")
        planning = SOURCE / "docs/examples/planning"
        plan, _ = self.json("plan", planning / "domain.pddl", planning / "problem.pddl")
        steps = pandas.DataFrame(plan["steps"])
        self.assertEqual(len(steps), 2)
        self.json("validate", planning / "domain.pddl", planning / "problem.pddl", planning / "good.plan")
        self.json("validate", planning / "domain.pddl", planning / "problem.pddl", planning / "hasty.plan", code=1)
        self.json("doc")
        self.agent(RULES)
        self.cxlab("run", "scenario.yaml", "--quiet", "--out", "out")
        self.json("why-not", "out", "decide")


if __name__ == "__main__":
    unittest.main()
