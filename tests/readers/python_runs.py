"""Runs and sweeps as data frames of pandas, polars and Arrow, against the program's own answers. ./dev readers"""

import csv
import json
import os
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

import cxlab
import pandas
import polars
import pyarrow
from cxlab import tables

CXLAB = os.environ["CXLAB"]
SOURCE = Path(os.environ["CXLAB_SOURCE_DIR"])


def program(*arguments, codes=(0,)):
    done = subprocess.run([CXLAB, *map(str, arguments)], text=True, capture_output=True, timeout=600)
    assert done.returncode in codes, done.stdout + done.stderr
    return done.stdout


def answer(*arguments, codes=(0,)):
    return json.loads(program(*arguments, "--json", codes=codes))


class WithGame(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        scratch = tempfile.TemporaryDirectory()
        cls.addClassCleanup(scratch.cleanup)
        cls.scratch = Path(scratch.name)
        cls.folder = cls.scratch / "game"
        program("run", "rcll/game", "--tier", "timed", "--seed", 1, "--until", 700, "--journal", "full", "--quiet", "--out", cls.folder)
        program("export", cls.folder, "--csv", "-o", cls.scratch / "csv")
        cls.run_ = cxlab.Run(cls.folder)
        cls.addClassCleanup(cls.run_.close)

    def csv(self, name):
        """The rows of an exported table; empty cells are None."""
        with open(self.scratch / "csv" / f"{name}.csv", newline="") as file:
            return [{key: value if value != "" else None for key, value in row.items()} for row in csv.DictReader(file)]

    def same_cells(self, table, rows):
        """A table of Arrow, and rows of a CSV."""
        self.assertEqual(table.num_rows, len(rows))
        self.assertEqual(table.column_names, list(rows[0]))
        for column in table.column_names:
            for cell, text in zip(table.column(column).to_pylist(), (row[column] for row in rows), strict=True):
                if cell is None or text is None:
                    self.assertIn(cell, (None, ""), (column, text))
                    self.assertIsNone(text, column)
                else:
                    self.assertEqual(cell, type(cell)(text), column)


class Records(WithGame):
    def test_they_are_the_lines_of_the_journal(self):
        lines = [json.loads(line) for line in (self.folder / "journal.jsonl").read_text().splitlines()]
        table = self.run_.arrow.records()
        self.assertEqual(table.num_rows, len(lines))
        self.assertGreater(table.column("stream").num_chunks, 1, "the test has more than one batch")
        for row, line in zip(table.to_pylist(), lines, strict=True):
            data = json.loads(row.pop("data"))
            self.assertEqual(data, line["data"])
            wanted = {"stream": line["stream"], "n": line["n"], "t_ns": line["t"], "t_s": line["t"] / 1e9,
                      "kind": line["kind"], "cause": " ".join(line["cause"])}
            self.assertEqual(row, wanted)

    def test_they_are_those_of_the_export(self):
        self.same_cells(self.run_.arrow.records(), self.csv("records"))

    def test_filters_choose_rows(self):
        every = self.run_.records()
        for options, chosen in (
            ({"kind": "skill"}, every.kind == "skill"),
            ({"kind": ["skill", "referee"]}, every.kind.isin(["skill", "referee"])),
            ({"stream": "referee"}, every.stream == "referee"),
            ({"start": "1:00", "end": 200}, (every.t_s >= 60) & (every.t_s <= 200)),
            ({"kind": "fire", "start": 700}, (every.kind == "fire") & (every.t_s >= 700)),
        ):
            with self.subTest(options):
                self.assertGreater(chosen.sum(), 0)
                pandas.testing.assert_frame_equal(self.run_.records(**options), every[chosen].reset_index(drop=True))

    def test_batches_are_read_one_by_one(self):
        every = self.run_.arrow.records("assert")
        batches = list(self.run_.record_batches("assert"))
        self.assertEqual(pyarrow.Table.from_batches(batches), every)
        self.assertLess(max(batch.nbytes for batch in self.run_.record_batches()), 3 * 2**22)

    def test_fields_are_columns(self):
        skills = self.run_.records("skill", fields=True)
        plain = self.run_.records("skill")
        self.assertEqual(list(skills.columns[:6]), ["stream", "n", "t_ns", "t_s", "kind", "cause"])
        for name, value in json.loads(plain.data[0]).items():
            self.assertEqual(skills[name][0], value)
        ends = skills[skills.event == "end"]
        self.assertTrue((ends.code >= 0).all())
        self.assertEqual(str(ends.cancelled.dtype), "boolean")
        # A field that is called as a column of the record.
        points = self.run_.records("referee", fields=True).dropna(subset=["total"])
        self.assertEqual(set(points.kind), {"referee"})
        self.assertIn("delivery", set(points.data_kind))

    def test_a_damaged_journal_names_the_line(self):
        damaged = self.scratch / "damaged"
        shutil.copytree(self.folder, damaged)
        self.addCleanup(shutil.rmtree, damaged)
        lines = (damaged / "journal.jsonl").read_text().splitlines(keepends=True)
        lines[4999] = lines[4999].replace('"data":{', '"data":{"a":', 1)
        (damaged / "journal.jsonl").write_text("".join(lines))
        with self.assertRaises(cxlab.InputError) as caught:
            cxlab.Run(damaged).records()
        self.assertEqual(caught.exception.line, 5000)
        self.assertTrue(str(caught.exception.file).endswith("journal.jsonl"))


class Tables(WithGame):
    def test_skills_and_points_are_those_of_the_export(self):
        self.same_cells(self.run_.arrow.skills, self.csv("skills"))
        self.same_cells(self.run_.arrow.points, self.csv("points"))
        self.assertEqual(self.run_.points.total.iloc[-1], self.run_.result["teams"]["CYAN"]["points"])

    def test_questions_of_the_world_are_those_of_the_program(self):
        for question in self.run_.questions:
            for options, flags in (({}, ()), ({"at": "5:00"}, ("--at", 300)), ({"start": 100, "end": 400}, ("--from", 100, "--to", 400))):
                with self.subTest(question, options=options):
                    wanted = answer(question, self.folder, *flags)
                    found = self.run_.arrow.ask(question, **options)
                    self.assertEqual(found.at_s, wanted.pop("at_s"))
                    self.assertEqual(found.from_s, wanted.pop("from_s", 0))
                    self.assertEqual(found.notes, wanted.pop("notes"))
                    self.assertEqual(set(found), set(wanted))
                    for name, rows in wanted.items():
                        self.assertEqual([self.as_json(row) for row in found[name].to_pylist()], [self.flat(row) for row in rows])

    def flat(self, row):
        """A stretch has two columns."""
        out = {}
        for key, value in row.items():
            if isinstance(value, list):
                out[f"{key}_begin"], out[f"{key}_end"] = value
            elif value is not None:
                out[key] = value
        return out

    def as_json(self, row):
        return {key: value for key, value in row.items() if value is not None}

    def test_a_part_of_an_answer(self):
        steps = self.run_.ask("orders", 2)["steps"]
        self.assertGreater(len(steps), 3)
        self.assertEqual(list(self.run_.ask("orders", "2").table["order"]), [2])
        with self.assertRaises(cxlab.UsageError):
            self.run_.ask("waits", "robot9")

    def test_scene(self):
        wanted = answer("scene", self.folder, "--at", 100)["entities"]
        found = self.run_.arrow.scene(100)
        for one, row in zip(wanted, found.to_pylist(), strict=True):
            for key in ("id", "kind", "name", "state", "x", "y", "z", "yaw", "carried_by", "place"):
                self.assertEqual(row[key], one[key])
        self.assertEqual(len(self.run_.scene(what="robot")), 3)


class Rules(WithGame):
    def environment(self, *arguments):
        return answer(*arguments)["environments"][0]

    def test_facts(self):
        for at in (300, 700):
            wanted = self.environment("facts", self.folder, "order", "--at", at)["facts"]
            found = self.run_.facts(at, "order")
            self.assertEqual(list(found.fact), [fact["fact"] for fact in wanted])
            for row, fact in zip(found.to_dict("records"), wanted, strict=True):
                self.assertEqual(row["env"], "agent")
                for slot, value in fact["slots"].items():
                    value = value.strip('"') if isinstance(value, str) else value
                    self.assertEqual(list(row[slot]) if isinstance(value, list) else row[slot],
                                     [item.strip('"') for item in value] if isinstance(value, list) else value)
                first, last = fact["changes"][0], fact["changes"][-1]
                self.assertEqual(row["asserted_s"], first["t_s"])
                self.assertEqual(row["asserted_by"], "rule " + first["by"]["name"])
                if last is not first:
                    self.assertEqual((row["changed_s"], row["changed_by"]), (last["t_s"], "rule " + last["by"]["name"]))
                else:
                    self.assertTrue(pandas.isna(row["changed_s"]) and pandas.isna(row["changed_by"]))
        every = self.run_.facts(300)
        self.assertEqual(len(every), len(self.environment("facts", self.folder, "--at", 300)["facts"]))
        self.assertIn("(order (id 1)", " ".join(every.text))
        self.assertEqual(len(self.run_.facts(300, "(order (id 1))")), 1)

    def test_slots_have_the_types_of_their_values(self):
        orders = self.run_.facts(300, "order")
        self.assertEqual(str(orders.id.dtype), "int64")
        self.assertEqual(str(orders.begin.dtype), "float64")
        self.assertIn("C0", set(orders.complexity))

    def test_no_facts_are_a_table_without_rows(self):
        none = self.run_.facts(300, "(order (id 99))")
        self.assertEqual(len(none), 0)
        self.assertEqual(list(none.columns), list(self.run_.facts(300, "order").columns))
        self.assertIn("state", none.columns)

    def test_changes(self):
        wanted = self.environment("facts", self.folder, "order", "--from", 100, "--to", 300)["facts"]
        found = self.run_.changes("order", 100, 300)
        expected = [(change["t_s"], fact["fact"], change["what"]) for fact in wanted for change in fact["changes"] if 100 <= change["t_s"] <= 300]
        self.assertEqual(sorted(zip(found.t_s, found.fact, found.what)), sorted(expected))
        self.assertTrue(found.t_s.is_monotonic_increasing)

    def test_firings(self):
        wanted = self.environment("firings", self.folder, "order-begin")["firings"]
        found = self.run_.firings("order-begin")
        self.assertEqual(list(found.t_s), [one["t_s"] for one in wanted])
        self.assertEqual(list(found.id.astype(str)), [one["values"]["id"] for one in wanted])
        stretch = self.run_.firings(start=100, end=110)
        fired = self.run_.records("fire", start=100, end=110, stream="env/agent")
        self.assertEqual(len(stretch), len(fired))

    def test_agenda_and_rules(self):
        self.assertEqual(len(self.run_.agenda(300)), len(self.environment("agenda", self.folder, "--at", 300)["agenda"]))
        wanted = self.environment("rules", self.folder, "--at", 300)["rules"]
        found = self.run_.rules(300)
        self.assertEqual(list(found["rule"]), [one["rule"] for one in wanted])
        self.assertEqual(list(found.fired), [one["fired"] for one in wanted])
        for lacks, one in zip(found.lacks, wanted, strict=True):
            if "unmet" in one:
                self.assertIn(one["unmet"]["because"], lacks)

    def test_tables_of_explanations(self):
        why = self.run_.why("order-begin", 300)
        self.assertEqual(list(why.table.step), list(range(len(why.json[0]["steps"]))))
        lacking = self.run_.why_not("order-begin", 300).table
        self.assertEqual(list(lacking["rule"]), ["order-begin"])
        self.assertIn("(chosen", lacking.pattern[0])
        waiting = self.run_.why_not("(order (id 1))", 300).table
        self.assertIn("order-begin", set(waiting["rule"]))


class Frames(WithGame):
    def test_polars_and_arrow_have_the_same_cells(self):
        run = self.run_
        for ask in (lambda r: r.orders, lambda r: r.records("skill", fields=True), lambda r: r.facts(300, "order"),
                    lambda r: r.why("order-begin", 300).table, lambda r: r.points):
            arrow, frame = ask(run.arrow), ask(run.polars)
            self.assertIsInstance(arrow, pyarrow.Table)
            self.assertIsInstance(frame, polars.DataFrame)
            self.assertIsInstance(ask(run), pandas.DataFrame)
            self.assertEqual(frame.to_dicts(), arrow.to_pylist())

    def test_slots_that_are_called_as_a_column_get_another_name(self):
        with cxlab.Episode("turtlesim/goal") as episode:
            episode.build("(deftemplate odd (slot fact) (slot template) (slot more))")
            number = episode.assert_("(odd (fact 7) (template x) (more 8))")
            row = episode.facts("odd", frames="arrow").to_pylist()
        self.assertEqual(row, [{"fact": number, "template": "odd", "slot_fact": 7, "slot_template": "x", "more": 8}])

    def test_the_table_of_an_episode_has_the_slots_of_its_template_also_without_facts(self):
        with cxlab.Episode("turtlesim/goal") as episode:
            episode.build("(deftemplate odd (slot fact) (slot more))")
            columns = ["fact", "template", "slot_fact", "more"]
            for pattern in ("odd", "(odd (more 9))"):
                self.assertEqual(list(episode.facts(pattern).columns), columns)
            episode.assert_("(odd (fact 7))")
            self.assertEqual(list(episode.facts("odd").columns), columns)
            self.assertEqual(list(episode.facts("(odd (more 9))").columns), columns)
            episode.assert_("(said hello)")
            self.assertEqual(list(episode.facts("(said goodbye)").columns), ["fact", "template", "implied"])
            self.assertEqual(list(episode.facts().columns)[:2], ["fact", "template"])

    def test_whole_numbers_stay_whole(self):
        orders = self.run_.points
        self.assertTrue(orders.order.isna().any())
        self.assertEqual(str(orders.order.dtype), "Int64")

    def test_a_column_has_the_one_type_of_its_values(self):
        rows = [{"a": 1, "b": 1, "c": [1, 2], "d": True, "e": {"x": 1}, "f": 2**70},
                {"a": 2.5, "b": "x", "c": [], "d": None, "g": [1, "y"]}]
        table = tables.from_rows(rows, ("z",))
        self.assertEqual(table.column_names, ["z", "a", "b", "c", "d", "e", "f", "g"])
        self.assertEqual(table.to_pylist(), [
            {"z": None, "a": 1.0, "b": "1", "c": [1, 2], "d": True, "e": '{"x": 1}', "f": str(2**70), "g": None},
            {"z": None, "a": 2.5, "b": "x", "c": [], "d": None, "e": None, "f": None, "g": '[1, "y"]'}])

    def test_hostile_names_are_escaped_in_notebooks(self):
        hostile = self.scratch / "hostile"
        shutil.copytree(self.folder, hostile)
        text = (hostile / "journal.jsonl").read_text().replace("robot1", "<script>alert(1)<\\/script>").replace('"CYAN"', '"<img src=x onerror=y>"')
        text = text.replace('"skill":"transport"', '"skill":"<i>"')
        (hostile / "journal.jsonl").write_text(text)
        html = cxlab.Run(hostile)._repr_html_()
        self.assertIn("<svg", html)
        self.assertIn("&lt;script&gt;", html)
        self.assertIn("&lt;img", html)
        self.assertIn("&lt;i&gt;", html)
        self.assertNotIn("<i>", html)
        self.assertNotIn("<script", html)
        self.assertNotIn("<img", html)
        self.assertIn("<svg", self.run_._repr_html_())


class Sweeps(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        scratch = tempfile.TemporaryDirectory()
        cls.addClassCleanup(scratch.cleanup)
        cls.folder = Path(scratch.name) / "sweep"
        suite = {"scenarios": [SOURCE / "scenarios/rcll/game.yaml"], "tier": "timed", "seeds": "1..6",
                 "strategies": {"three": ["duration_s=150"], "None": ["duration_s=150", "world.robots=1"]},
                 "require": ["mean(points) >= 1"]}
        cls.sweep = cxlab.bench(suite, out=cls.folder, jobs=2)

    def test_tables_are_those_of_the_program(self):
        for name in tables_of_sweep():
            with self.subTest(name):
                wanted = answer("bench", "show", self.folder, "--table", name)[name]
                found = self.sweep.arrow.table(name).to_pylist()
                flat = []
                for row in wanted:
                    out = {}
                    for key, value in row.items():
                        out |= dict(zip((f"{key}_low", f"{key}_high"), value or (None, None), strict=True)) if key.endswith("_95") else {key: value}
                    flat.append(out)
                self.assertEqual(found, flat)
        other = self.sweep.table("differences", metric="skills", against="None")
        self.assertEqual(list(other.against), ["None"])

    def test_rows(self):
        rows = self.sweep.rows
        self.assertEqual(len(rows), 12)
        self.assertEqual(set(rows.strategy), {"three", "None"})
        by_hand = rows.groupby("strategy").points.mean()
        for row in self.sweep.scores.itertuples():
            self.assertAlmostEqual(row.mean, by_hand[row.strategy], places=9)
        self.assertEqual(self.sweep.polars.rows.height, 12)

    def test_a_file_with_an_empty_cell(self):
        file = self.folder.with_name("some.csv")
        file.write_text("scenario,strategy,game,seed,status,exit,points\ngame,None,,1,completed,0,1.5\ngame,NA,,2,crashed,70,\n")
        rows = cxlab.read_sweep(file).rows
        self.assertEqual(list(rows.strategy), ["None", "NA"])
        self.assertEqual(list(rows.game), ["", ""])
        self.assertEqual(list(rows.points.isna()), [False, True])
        self.assertEqual(str(rows.points.dtype), "float64")

    def test_two_sweeps(self):
        compared = cxlab.read_sweep(self.folder).compare(self.sweep)
        wanted = answer("bench", "compare", self.folder, self.folder, codes=(6,))
        self.assertEqual(compared.answer, wanted["answer"])
        self.assertEqual(list(compared.differences.difference), [row["difference"] for row in wanted["differences"]])

    def test_requirements_and_plot(self):
        self.assertEqual(set(self.sweep.requirements.requirement), {"mean(points) >= 1"})
        self.assertIn("<svg", self.sweep.plot("differences").svg)
        self.assertEqual(self.sweep.code, 6)

    def test_what_cannot_be_is_refused(self):
        for kind, text, call in (
            (cxlab.InputError, "rows.csv", lambda: cxlab.read_sweep("none")),
            (cxlab.UsageError, "scores", lambda: self.sweep.table("score")),
            (cxlab.CxlabError, "three", lambda: self.sweep.table("differences", against="thre")),
            (cxlab.UsageError, "out", lambda: cxlab.bench({"scenarios": []})),
            (cxlab.InputError, "no-such.yaml", lambda: cxlab.bench("no-such.yaml")),
        ):
            with self.subTest(text), self.assertRaises(kind) as caught:
                call()
            self.assertIn(text, str(caught.exception))


def tables_of_sweep():
    from cxlab.sweep import TABLES

    return TABLES


class Notebooks(unittest.TestCase):
    def execute(self, name):
        import nbclient
        import nbformat

        notebook = nbformat.read(SOURCE / "python/notebooks" / name, 4)
        for cell in notebook.cells:
            if cell.cell_type == "code":
                self.assertEqual((cell.outputs, cell.execution_count), ([], None), "outputs stay out of git")
        nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(SOURCE / "python/notebooks")}}).execute()
        return [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]

    def test_first_game(self):
        outputs = self.execute("first_game.ipynb")
        html = " ".join(output.data.get("text/html", "") for output in outputs if "data" in output)
        self.assertIn("points of CYAN", html)
        self.assertIn("<svg", html)
        self.assertIn("order-begin", " ".join(output.get("text", "") for output in outputs))

    def test_comparing_strategies(self):
        outputs = self.execute("comparing_strategies.ipynb")
        self.assertEqual(sum("image/svg+xml" in output.get("data", {}) for output in outputs), 2)
        self.assertIn("undecided", str(outputs))

    def test_training(self):
        said = " ".join(output.get("text", "") for output in self.execute("training.ipynb"))
        self.assertRegex(said, r"robot\d: \[.*'wait'\], preferred: ")
        self.assertRegex(said, r"rules +\[627 ")

    def test_python_agent(self):
        said = " ".join(output.get("text", "") for output in self.execute("python_agent.ipynb"))
        self.assertRegex(said, r"met 0 walls and was brought home [1-9]\d* times")
        self.assertIn("goal reached: True", said)

    def test_planning(self):
        outputs = self.execute("planning.ipynb")
        said = " ".join(output.get("text", "") for output in outputs)
        self.assertIn("up_time_triggered_validator VALID", said)
        self.assertIn("cxlab VALID", said)
        self.assertRegex(said, r"34\.\d+ s; no plan is shorter than 34\.000 s")
        self.assertEqual(sum("image/svg+xml" in output.get("data", {}) for output in outputs), 1)


class Examples(WithGame):
    def say(self, name, *arguments):
        import sys

        done = subprocess.run([sys.executable, SOURCE / "python/examples" / name, *map(str, arguments)], text=True, capture_output=True, timeout=300)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_ask_a_run(self):
        self.assertIn("what robots waited for", self.say("ask_a_run.py", self.folder))

    def test_compare_strategies(self):
        said = self.say("compare_strategies.py", SOURCE / "scenarios/rcll/game.yaml", self.scratch / "robots")
        self.assertRegex(said, r"two robots against three robots: .* points")


if __name__ == "__main__":
    unittest.main()
