"""Questions about a run in Python, without any package: texts, JSON, errors, and the process that answers."""

import contextlib
import copy
import gc
import json
import os
import pickle
import re
import shutil
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

import cxlab
from cxlab import jupyter
from cxlab._asking import error_said
from cxlab.run import seconds_of

CXLAB = os.environ["CXLAB"]
HOSTILE = "<script>alert(1)</script>"


def program(*arguments, code=0):
    done = subprocess.run([CXLAB, *map(str, arguments)], text=True, capture_output=True, timeout=120)
    assert done.returncode == code, done.stdout + done.stderr
    return done.stdout


def is_alive(pid):
    try:
        with open(f"/proc/{pid}/stat") as stat:
            return stat.read().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False


def ends(pid):
    """Whether a process ends within some seconds."""
    for _ in range(200):
        if not is_alive(pid):
            return True
        time.sleep(0.05)
    return False


SCRATCH = tempfile.TemporaryDirectory()
GAME = Path(SCRATCH.name) / "game"


def setUpModule():
    unittest.addModuleCleanup(SCRATCH.cleanup)
    program("run", "rcll/game", "--tier", "timed", "--seed", 1, "--until", 130, "--quiet", "--out", GAME)


class WithGame(unittest.TestCase):
    """Each test opens the one game of this module."""

    folder = GAME

    def setUp(self):
        self.run_ = cxlab.Run(GAME)
        self.addCleanup(self.run_.close)


class Times(unittest.TestCase):
    def test_times_are_written_as_for_the_program(self):
        for text, seconds in (
            (312.4, 312.4),
            (7, 7.0),
            ("312.4", 312.4),
            ("5:12", 312.0),
            ("5:12.4", 312.4),
            ("0:05", 5.0),
        ):
            self.assertAlmostEqual(seconds_of(text), seconds, places=9, msg=text)
        self.assertIsNone(seconds_of(None))

    def test_what_is_no_time_says_how_one_is_written(self):
        for none in (
            "",
            "now",
            "5:60",
            "1:2:3",
            "5:",
            ":5",
            "5:123",
            "1e3",
            "1_0",
            1e9,
            -1,
            "-1",
            float("nan"),
            float("inf"),
            True,
            [3],
        ):
            with self.assertRaisesRegex(cxlab.UsageError, "5:12.4", msg=none):
                seconds_of(none)


class Errors(unittest.TestCase):
    def test_the_error_of_a_program_has_its_file_and_line(self):
        error = error_said(3, "a note\nerror: a/b.clp:12: slot 'colour' does not exist\n")
        self.assertEqual((error.code, error.file, error.line), (3, "a/b.clp", 12))
        self.assertEqual(str(error), "a/b.clp:12: slot 'colour' does not exist")
        self.assertIsInstance(error, cxlab.InputError)

    def test_a_sentence_with_a_colon_names_no_file(self):
        error = error_said(2, "error: --at: found x, expected a time\n")
        self.assertIsInstance(error, cxlab.UsageError)
        self.assertEqual(error.message, "at: found x, expected a time")

    def test_options_of_the_program_are_arguments_and_its_commands_stay(self):
        error = error_said(2, "error: it is in use; --trust-programs would do\ncxlab rerun --help says more\n")
        self.assertEqual(error.message, "it is in use; trust_programs would do")
        self.assertEqual(error_said(2, "error: cxlab doctor --fix mends it").message, "cxlab doctor --fix mends it")
        self.assertEqual(error_said(2, "error: found x--y, expected ---").message, "found x--y, expected ---")

    def test_a_signal_is_no_answer(self):
        self.assertIn("signal 9", str(error_said(-9, "")))


class Questions(WithGame):
    def answer(self, *arguments):
        return json.loads(program(*arguments, "--json"))

    def test_why_is_the_answer_of_the_program(self):
        for at in ("1:50", 130):
            why = self.run_.why("order-begin", at=at)
            wanted = self.answer("why", self.folder, "order-begin", "--at", at)["environments"]
            self.assertEqual(why.json, wanted)

        def words(text):  # the program breaks lines
            return re.sub(r"[│├└─\s]+", " ", text).strip()

        printed = program("why", self.folder, "order-begin").partition("\n")[2]
        self.assertEqual(words(str(self.run_.why("order-begin"))), words(printed))

    def test_why_not_is_the_answer_of_the_program(self):
        for what in ("product-deliver", "(order (id 1))", "(delivered)"):
            not_yet = self.run_.why_not(what, at=100)
            wanted = self.answer("why-not", self.folder, what, "--at", 100)
            parts = wanted.get("environments") or [{"explanations": wanted["explanations"]}]
            self.assertEqual(not_yet.text, str(not_yet))
            self.assertTrue(not_yet.text)
            for found, part in zip(not_yet.json, parts, strict=True):
                for key in part:
                    if key == "explanations":
                        for one, other in zip(found[key], part[key], strict=True):
                            self.assertEqual({name: one.get(name) for name in other}, other)
                    else:
                        self.assertEqual(found.get(key), part[key], (what, key))
            self.assertTrue(str(not_yet).strip())
        lacking = self.run_.why_not("product-deliver", at=100)
        self.assertIn("lacks condition", str(lacking))
        self.assertIn(lacking.json[0]["explanations"][0]["first_unmet"]["because"], str(lacking))

    def test_globals_and_source(self):
        wanted = self.answer("globals", self.folder, "--at", 50)["environments"][0]["globals"]
        self.assertEqual(self.run_.globals(at=50), wanted)
        self.assertTrue(self.run_.source("order-begin").startswith("(defrule order-begin"))

    def test_time_goes_back_as_well(self):
        later, earlier, again = (self.run_.globals(at=at)["last-id"] for at in (120, 10, 120))
        self.assertEqual(later, again)
        self.assertLess(earlier, later)

    def test_questions_of_the_world_are_members(self):
        self.assertIn("orders", self.run_.questions)
        for name in self.run_.questions:
            self.assertIn(name, dir(self.run_))
        with self.assertRaisesRegex(AttributeError, "did you mean 'orders'"):
            _ = self.run_.ordrs
        self.assertFalse(hasattr(self.run_, "_repr_svg_"))

    def test_result_and_manifest_are_the_files(self):
        self.assertEqual(self.run_.result, json.loads((self.folder / "result.json").read_text()))
        self.assertEqual(self.run_.manifest, json.loads((self.folder / "manifest.json").read_text()))
        self.assertIn("seed 1", repr(self.run_))


class WrongQuestions(WithGame):
    def refuses(self, kind, text, call):
        with self.assertRaises(kind) as caught:
            call()
        self.assertIn(text, str(caught.exception))

    def test_names_that_do_not_exist_name_the_nearest(self):
        run = self.run_
        for kind, text, call in (
            (cxlab.InputError, "did you mean 'order-begin'", lambda: run.why_not("order-begn")),
            (cxlab.InputError, "order", lambda: run.why("(ordr (id 1))")),
            (cxlab.InputError, "colour", lambda: run.why("(order (colour RED))")),
            (cxlab.InputError, "f-999999", lambda: run.why("f-999999")),
            (cxlab.InputError, "did you mean 'agent'", lambda: run.why("order-begin", env="agnt")),
            (cxlab.InputError, "did you mean 'orders'", lambda: run.ask("ordrs")),
            (cxlab.UsageError, "did you mean 'skill'", lambda: run.records("skil")),
            (cxlab.InputError, "did you mean 'referee'", lambda: run.records(stream="refere")),
            (cxlab.UsageError, "polars", lambda: cxlab.Run(self.folder, frames="panda")),
        ):
            with self.subTest(text):
                self.refuses(kind, text, call)

    def test_times_after_the_end_are_refused(self):
        for call in (
            lambda: self.run_.why("order-begin", at=131),
            lambda: self.run_.globals(130.01),
            lambda: self.run_.ask("orders", at="2:11"),
            lambda: self.run_.records(start=500),
            lambda: self.run_.scene(at=500),
        ):
            self.refuses(cxlab.UsageError, "the run ends at 130 s", call)
        for call in (self.run_.records, lambda **stretch: self.run_.ask("orders", **stretch)):
            self.refuses(cxlab.UsageError, "start is after end", lambda call=call: call(start=20, end=10))
        self.refuses(cxlab.UsageError, "start is after the end", lambda: self.run_.ask("orders", start=500))

    def test_after_an_error_the_next_question_is_answered(self):
        self.refuses(cxlab.InputError, "no-such-rule", lambda: self.run_.why_not("no-such-rule"))
        self.assertIn("order-begin", str(self.run_.why("order-begin")))

    def test_folders_that_are_no_run(self):
        with tempfile.TemporaryDirectory() as empty:
            for folder in (empty, Path(empty) / "none"):
                self.refuses(cxlab.InputError, str(folder), lambda folder=folder: cxlab.Run(folder))

    def test_a_damaged_manifest_is_named(self):
        with tempfile.TemporaryDirectory() as scratch:
            damaged = Path(scratch) / "run"
            shutil.copytree(self.folder, damaged)
            (damaged / "manifest.json").write_text("{")
            self.refuses(cxlab.InputError, "manifest.json", lambda: cxlab.Run(damaged))


class Process(WithGame):
    def asked(self):
        self.run_.globals(at=20)
        pid = self.run_._asking.pid
        self.assertTrue(is_alive(pid))
        return pid

    def test_it_begins_with_the_first_question_and_stays(self):
        self.assertIsNone(self.run_._asking.pid)
        first = self.asked()
        self.assertEqual(self.asked(), first)

    def test_closing_ends_it_and_the_next_question_begins_another(self):
        first = self.asked()
        self.run_.close()
        self.assertTrue(ends(first))
        self.assertNotEqual(self.asked(), first)

    def test_it_ends_with_the_object(self):
        run = cxlab.Run(self.folder)
        run.globals(at=20)
        pid = run._asking.pid
        other_frames = run.polars  # the same process
        del run
        gc.collect()
        self.assertTrue(is_alive(pid))
        del other_frames
        gc.collect()
        self.assertTrue(ends(pid))

    def test_it_ends_with_the_interpreter_however_that_ends(self):
        for end in ("pass", "os.kill(os.getpid(), 9)"):
            ask = f"r = cxlab.Run({str(self.folder)!r}); r.globals(at=20); print(r._asking.pid, flush=True)"
            code = f"import cxlab, os; {ask}; {end}"
            done = subprocess.run([sys.executable, "-c", code], text=True, capture_output=True, timeout=60)
            self.assertTrue(ends(int(done.stdout)), end)

    def test_a_process_that_dies_is_an_error_and_the_next_question_begins_another(self):
        pid = self.asked()
        os.kill(pid, 9)
        with self.assertRaisesRegex(cxlab.CxlabError, "signal 9"):
            self.run_.globals(at=20)
        self.assertNotEqual(self.asked(), pid)

    def test_a_copy_of_the_interpreter_leaves_it_alone(self):
        pid = self.asked()
        copy_of_this = os.fork()
        if copy_of_this == 0:
            self.run_.globals(at=20)
            other = self.run_._asking.pid
            self.run_.close()
            os._exit(0 if other != pid and ends(other) else 1)
        self.assertEqual(os.waitpid(copy_of_this, 0)[1], 0)
        time.sleep(0.2)
        self.assertTrue(is_alive(pid))
        self.assertEqual(self.asked(), pid)


class RunThatWasKilled(unittest.TestCase):
    def test_it_is_asked_up_to_where_its_log_ends(self):
        with tempfile.TemporaryDirectory() as scratch:
            killed = Path(scratch) / "killed"
            shutil.copytree(GAME, killed)
            begun = {"status": "failed", "reason": {"code": "unfinished", "message": "is being played"}}
            result = json.loads((killed / "result.json").read_text())
            (killed / "result.json").write_text(json.dumps(result | begun | {"sim_time_s": 0, "stream_hashes": {}}))
            with cxlab.Run(killed) as run:
                self.assertEqual(
                    run.globals(), json.loads(program("globals", GAME, "--json"))["environments"][0]["globals"]
                )
                self.assertLess(run.globals(at=10)["last-id"], run.globals()["last-id"])
                self.assertIn("unfinished", str(run.result))


class RunInProgress(unittest.TestCase):
    def test_it_is_asked_about_now(self):
        with tempfile.TemporaryDirectory() as scratch, contextlib.ExitStack() as at_the_end:
            folder = Path(scratch) / "live"
            command = [
                CXLAB,
                "run",
                "rcll/game",
                "--tier",
                "timed",
                "--realtime",
                "--control",
                "--quiet",
                "--out",
                folder,
            ]
            game = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            at_the_end.callback(game.wait)
            at_the_end.callback(game.terminate)
            while not (folder / "control.sock").exists():
                self.assertIsNone(game.poll())
                time.sleep(0.05)
            with cxlab.Run(folder) as run:
                self.assertEqual(run.environments, ["agent"])
                self.assertEqual(run.globals()["GAME"], 1200.0)
                with self.assertRaisesRegex(cxlab.InputError, "being played"):
                    run.globals(at=1)
            self.assertIsNone(game.poll())


class Notebook(WithGame):
    def test_texts_of_a_run_are_escaped(self):
        with tempfile.TemporaryDirectory() as scratch:
            hostile = Path(scratch) / HOSTILE.replace("/", "∕")
            shutil.copytree(self.folder, hostile)
            result = json.loads((hostile / "result.json").read_text())
            result["scenario"] = HOSTILE
            result["teams"] = {HOSTILE: {"points": HOSTILE}}
            result["reason"] = {"code": "x", "message": HOSTILE}
            (hostile / "result.json").write_text(json.dumps(result))
            html = cxlab.Run(hostile)._repr_html_()
        self.assertIn("&lt;script&gt;", html)
        self.assertNotIn("<script", html)
        for made in (jupyter.text_html(HOSTILE), jupyter.link_html(HOSTILE), jupyter.link_html('"onclick="')):
            self.assertNotIn("<script", made)
            self.assertNotIn('""', made)

    def test_a_card_has_how_the_run_ended(self):
        html = self.run_._repr_html_()
        for part in ("stopped", "130 s", "points of CYAN", str(self.run_.result["teams"]["CYAN"]["points"])):
            self.assertIn(part, html)


class WhatIf(WithGame):
    def test_a_rerun_is_a_run_that_goes_on_otherwise(self):
        out = Path(SCRATCH.name) / "otherwise"
        other = cxlab.rerun(
            self.run_, at="1:40", then="(defrule say-so (time ?) (not (said)) => (assert (said)))", until=120, out=out
        )
        self.assertTrue(other.same)
        self.assertEqual(other.folder, out)
        self.assertEqual(other.result["sim_time_s"], 120)
        self.assertIn("say-so", other.answer["changes"][0]["what"])
        self.assertIn("say-so", str(other.why("(said)")))
        other.close()

    def test_a_rerun_without_a_change_is_the_same(self):
        again = cxlab.rerun(self.folder, out=Path(SCRATCH.name) / "again")
        self.assertTrue(again.same)
        self.assertEqual(again.result["journal_hash"], self.run_.result["journal_hash"])

    def test_a_folder_in_use_is_written_into_by_force(self):
        out = Path(SCRATCH.name) / "in-use"
        out.mkdir()
        (out / "file").touch()
        with self.assertRaisesRegex(cxlab.UsageError, "; force writes"):
            cxlab.rerun(self.run_, at=10, until=11, out=out)
        self.assertTrue(cxlab.rerun(self.run_, at=10, until=11, out=out, force=True).same)

    def test_a_mistake_in_rules_that_are_no_file_names_the_argument(self):
        with self.assertRaises(cxlab.InputError) as caught:
            cxlab.rerun(self.run_, at=10, then="; none\n(defrule a", out=Path(SCRATCH.name) / "refused")
        self.assertEqual((caught.exception.file, caught.exception.line), ("then", 2))

    def test_what_cannot_be_is_refused(self):
        out = Path(SCRATCH.name) / "refused"
        for kind, text, options in (
            (cxlab.UsageError, "begin with '('", {"at": 10, "then": "no-such-file.clp"}),
            (cxlab.UsageError, "expected at T", {"assert_": "(a)"}),
            (cxlab.InputError, "no-such", {"at": 10, "assert_": "(no-such (slot 1))"}),
        ):
            with self.subTest(text), self.assertRaises(kind) as caught:
                cxlab.rerun(self.run_, out=out, **options)
            self.assertIn(text, str(caught.exception))
            shutil.rmtree(out, ignore_errors=True)


class Copies(WithGame):
    def test_a_copy_answers_the_same_in_a_process_of_its_own(self):
        text = str(self.run_.why("order-begin"))
        for copied in (copy.copy(self.run_), copy.deepcopy(self.run_), pickle.loads(pickle.dumps(self.run_.arrow))):
            self.addCleanup(copied.close)
            self.assertEqual(str(copied.why("order-begin")), text)
            self.assertNotEqual(copied._asking.pid, self.run_._asking.pid)
            self.assertEqual(copied.result, self.run_.result)
        self.assertEqual(copied._frames, "arrow")

    def test_an_explanation_goes_to_another_process(self):
        answer = self.run_.why("order-begin")
        self.assertEqual(str(pickle.loads(pickle.dumps(answer))), str(answer))


class Suites(unittest.TestCase):
    def test_a_suite_names_scenarios_that_come_with_the_program(self):
        suite = {"scenarios": ["rcll/game"], "tier": "timed", "seeds": [1], "strategies": {"a": []}}
        sweep = cxlab.bench(suite, out=Path(SCRATCH.name) / "suite")
        self.assertEqual(len((sweep.folder / "rows.csv").read_text().splitlines()), 2)

    def test_a_mistake_in_a_suite_that_is_no_file_names_the_argument(self):
        for wrong, says in (
            ({"seed": "1"}, "did you mean 'seeds'"),
            ({"scenarios": ["nowhere.yaml"]}, str(Path("nowhere.yaml").absolute())),
        ):
            with self.subTest(wrong), self.assertRaisesRegex(cxlab.InputError, re.escape(says)) as caught:
                cxlab.bench({"scenarios": ["rcll/game"], "seeds": [1], "strategies": {"a": []}, **wrong}, out=Path(SCRATCH.name) / "wrong")
            self.assertEqual(caught.exception.file, "suite")


class Pages(WithGame):
    def test_view_serves_until_it_is_closed(self):
        with self.run_.view() as view:
            self.assertRegex(view.url, r"^http://127\.0\.0\.1:\d+/\?token=|^http://127\.0\.0\.1:\d+/")
            pid = view.pid
            self.assertTrue(is_alive(pid))
        self.assertFalse(is_alive(pid))

    def test_export_names_its_files(self):
        files = self.run_.export("trace", out=Path(SCRATCH.name) / "t.json")
        self.assertEqual([file.name for file in files], ["t.json"])
        json.loads(files[0].read_text())
        with self.assertRaises(cxlab.UsageError):
            self.run_.export()


if __name__ == "__main__":
    unittest.main()
