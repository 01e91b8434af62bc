"""cxlab bench: grids, single cells, collected rows, the index, crashes and kills. python3 -m unittest sweeps"""

import csv
import html
import json
import os
import pathlib
import pty
import re
import shlex
import shutil
import signal
import sqlite3
import subprocess
import sys
import time
import xml.etree.ElementTree

from lab import CONFIG, CXLAB, SOURCE, Lab

RULES = """(defrule draw (time ?) => (assert (drawn (random))))
"""
SUITE = """scenarios: [scenarios/game.yaml]
seeds: [1, 2]
tags: [night]
strategies: {short: {set: [duration_s=1], tags: [quick]}}
grid: {duration_s: [2, 3]}
"""
GAME = """schema: 1
duration_s: 2
packages: {rules: ../rules}
agents:
  - config: ../agent.yaml
"""
# Goes on until somebody ends it.
ENDLESS = """schema: 1
duration_s: 1000000
packages: {rules: ../endless}
agents:
  - config: ../endless.yaml
"""


class Sweeps(Lab):
    def setUp(self):
        super().setUp()
        self.home = self.folder / "home"
        for name, text in (("agent.yaml", CONFIG), ("rules/rules.clp", RULES), ("scenarios/game.yaml", GAME), ("suite.yaml", SUITE)):
            self.write(f"home/{name}", text)

    def bench(self, *arguments, suite="suite.yaml", folder=None, code=0, before=()):
        done = subprocess.run([*before, CXLAB, "bench", suite, *map(str, arguments)], cwd=folder or self.home, text=True, timeout=120,
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        if code is not None:
            self.assertEqual(done.returncode, code, done.stderr + done.stdout)
        return done

    def rows(self, out):
        """By name of the file, without what is of the machine."""
        rows = {}
        for file in sorted((out / "rows").glob("*.json")):
            rows[file.name] = json.loads(file.read_text())
            self.assertEqual(list(rows[file.name])[-1], "played")
            del rows[file.name]["played"]
        return rows

    def query(self, out, sql):
        with sqlite3.connect(f"file:{out}/runs.sqlite?mode=ro", uri=True) as index:
            self.assertEqual(index.execute("PRAGMA integrity_check").fetchall(), [("ok",)])
            return index.execute(sql).fetchall()

    def test_cells_that_other_machines_play_are_those_of_one_sweep(self):
        self.bench("-j", 2, "--out", self.folder / "whole")
        cells = self.bench("--cells").stdout.splitlines()
        self.assertEqual(cells, [f"{i}\tgame {strategy} seed {seed}" for i, (strategy, seed) in
                                 enumerate(((s, n) for s in ("short", "duration_s=2", "duration_s=3") for n in (1, 2)), start=1)])
        # Two checkouts elsewhere; one of them plays its cells twice, and one cell is played on both.
        for name, ranges in (("a", ["1..3", "2"]), ("b", ["3", "4..5"])):
            shutil.copytree(self.home, self.folder / name / "checkout")
            for cell in ranges:
                done = self.bench("--cell", cell, "--out", "r", folder=self.folder / name / "checkout")
                self.assertTrue(all((self.folder / name / "checkout" / line).exists() for line in done.stdout.splitlines()), done.stdout)
            self.assertFalse((self.folder / name / "checkout/r/rows.csv").exists())
        sources = [self.folder / name / "checkout/r" for name in "ab"]
        done = self.bench("--collect", *sources, "--out", "r", code=1)
        self.assertIn("5 of 6 cells have a row; 5 rows were taken", done.stderr)
        self.assertRegex(done.stdout, r"\ngame +duration_s=2 +2/2 (.*\n)+game +duration_s=3 +1/2 ")
        self.assertIn("error: cell 6 has no row; cxlab bench suite.yaml --out r plays it", done.stderr)
        self.assertEqual(self.bench("--cell", 6, "--out", "r", "--json").returncode, 0)
        done = self.bench("--collect", *sources, "--out", "r")
        self.assertIn("6 of 6 cells have a row; 0 rows were taken", done.stderr)
        self.assertEqual((self.home / "r/rows.csv").read_bytes(), (self.folder / "whole/rows.csv").read_bytes())
        self.assertEqual(self.rows(self.home / "r"), self.rows(self.folder / "whole"))
        self.assertEqual(self.bench("--out", "r").stderr, "6 rows are current and kept\n")

    def test_rows_count_by_their_content(self):
        self.bench("--out", "r")
        whole = self.rows(self.home / "r")
        # The folder moves, and strategies and suite are called otherwise.
        moved = self.folder / "moved/deep"
        shutil.move(self.home, moved)
        (moved / "suites").mkdir()
        (moved / "suites/suite.yaml").write_text(SUITE.replace("scenarios/", "../scenarios/").replace("short:", "quickly:").replace("tags: [night]\n", ""))
        done = self.bench("--out", "../r", folder=moved / "suites")
        self.assertEqual(done.stderr, "6 rows are current and kept\n")
        self.assertEqual({row["key"] for row in self.rows(moved / "r").values()}, {row["key"] for row in whole.values()})
        self.assertEqual(self.query(moved / "r", "SELECT DISTINCT strategy FROM runs ORDER BY cell"), [("quickly",), ("duration_s=2",), ("duration_s=3",)])
        # Another content: nothing counts.
        (moved / "rules/rules.clp").write_text(RULES + "; changed\n")
        tables = {name: (moved / "r" / name).read_bytes() for name in ("rows.csv", "runs.sqlite", "index.html")}
        shutil.copy(moved / "suites/suite.yaml", moved / "suites/a suite.yaml")
        shutil.copytree(moved / "r", moved / "r 2")
        done = self.bench("--collect", "../r 2", "--out", "../r 2", suite="a suite.yaml", folder=moved / "suites", code=3)
        self.assertIn("To play these games again: cxlab bench 'a suite.yaml' --out '../r 2'; ", done.stderr)
        done = self.bench("--collect", "../r", "--out", "../r", folder=moved / "suites", code=3)
        self.assertIn("r/rows.csv: would lose 6 rows, because package://rules/rules.clp has changed since they were played; it stays as it is. "
                      "To play these games again: cxlab bench suite.yaml --out ../r; to collect only what is current: --out with another folder", done.stderr)
        self.assertEqual({name: (moved / "r" / name).read_bytes() for name in tables}, tables)
        done = self.bench("--collect", "../r", "--out", "../other", "--quiet", folder=moved / "suites", code=1)
        self.assertIn("rows are of games that this suite does not play", done.stderr, "also with --quiet")

    def test_a_folder_has_the_tables_of_one_suite(self):
        self.write("home/other/suite.yaml", SUITE.replace("scenarios/", "../scenarios/").replace("[1, 2]", "[1, 2, 3]").replace("{duration_s: [2, 3]}", "{duration_s: [2]}"))
        self.bench("--out", "r")
        rows = (self.home / "r/rows.csv").read_bytes()
        done = subprocess.run([CXLAB, "bench", "other/suite.yaml", "--out", "r"], cwd=self.home, text=True, capture_output=True, timeout=60)
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertIn(f"r/rows.csv: has 2 rows of games that other/suite.yaml does not play, as game duration_s=3 seed 1: it is a table of the suite "
                      f"{self.home.resolve()}/suite.yaml; expected --out with a folder of this suite's own", done.stderr)
        self.assertEqual((self.home / "r/rows.csv").read_bytes(), rows)
        # A suite that was edited takes its games out of its own tables, and says so.
        self.write("home/suite.yaml", SUITE.replace("[2, 3]", "[2]"))
        self.assertIn("r/rows.csv loses 2 rows of games that suite.yaml does not play, as game duration_s=3 seed 1; rows/*.json keeps them\n", self.bench("--out", "r").stderr)
        self.assertEqual(len((self.home / "r/rows.csv").read_text().splitlines()), 5)
        self.assertEqual(len(list((self.home / "r/rows").glob("game-duration_s_3-*.json"))), 2)

    def test_rows_are_missed_though_another_strategy_plays_the_same_games(self):
        strategies = lambda names: SUITE[:SUITE.index("strategies")] + f"strategies: {{{names}}}\n"
        self.write("home/other/suite.yaml", strategies("plain: []").replace("scenarios/", "../scenarios/"))
        self.write("home/suite.yaml", strategies("plain: [], set: [duration_s=2], twin: []"))
        self.bench("--out", "r")
        self.assertEqual(self.query(self.home / "r", "SELECT count(DISTINCT journal_hash), count(DISTINCT key) FROM runs WHERE seed = 1"), [(1, 2)])
        rows = (self.home / "r/rows.csv").read_bytes()
        for arguments in ([], ["--collect", "r"]):
            done = subprocess.run([CXLAB, "bench", "other/suite.yaml", *arguments, "--out", "r"], cwd=self.home, text=True, capture_output=True, timeout=60)
            self.assertEqual(done.returncode, 3, done.stderr)
            self.assertIn("r/rows.csv: has 4 rows of games that other/suite.yaml does not play, as game set seed 1: ", done.stderr)
            self.assertEqual((self.home / "r/rows.csv").read_bytes(), rows)
        # A strategy with another name loses nothing; one that is taken out does, also beside one that plays the same.
        self.write("home/suite.yaml", strategies("base: [], set: [duration_s=2], twin: []"))
        self.assertEqual(self.bench("--out", "r").stderr, "6 rows are current and kept\n")
        self.write("home/suite.yaml", strategies("base: [], set: [duration_s=2]"))
        self.assertIn("r/rows.csv loses 2 rows of games that suite.yaml does not play, as game twin seed 1; rows/*.json keeps them\n", self.bench("--out", "r").stderr)
        # Without the index nothing shows which rows have another name only.
        (self.home / "r/runs.sqlite").unlink()
        self.write("home/suite.yaml", strategies("renamed: [], set: [duration_s=2]"))
        self.assertIn("loses 2 rows", self.bench("--out", "r", "--quiet").stderr)

    def test_requirements_that_cannot_be_taken_away_are_a_loss_that_quiet_does_not_hide(self):
        (self.home / "r/requirements.json/of another").mkdir(parents=True)
        self.assertIn("r/requirements.json: Directory not empty", self.bench("--out", "r", "--quiet").stderr)
        self.assertTrue((self.home / "r/index.html").exists())

    def test_the_program_for_ray_says_what_is_missing(self):
        def play(*arguments, path):
            return subprocess.run([sys.executable, SOURCE / "docs/examples/ray/play_on_ray.py", *arguments], cwd=self.home, text=True, capture_output=True, timeout=60,
                                  env=os.environ | {"PYTHONPATH": str(path)})
        without = self.write("without/ray.py", "raise ModuleNotFoundError(\"No module named 'ray'\", name='ray')\n").parent
        self.assertIn("--cells-per-task", play("--help", path=without).stdout)
        done = play("suite.yaml", "--out", "r", path=without)
        self.assertEqual((done.returncode, done.stderr), (1, f"{sys.executable} has no Ray: pip install ray\n"))
        done = play("suite.yaml", "--out", "r", "--cxlab", "nocx", path=self.write("with/ray.py", "").parent)
        self.assertEqual((done.returncode, done.stderr), (1, "there is no program nocx; expected --cxlab with the path of cxlab, or cxlab on the PATH\n"))
        self.assertFalse((self.home / "r").exists())

    def test_seeds_can_be_chosen(self):
        self.bench("--seeds", "7..9", "--out", "r", "--quiet")
        self.assertEqual(sorted({row["seed"] for row in self.rows(self.home / "r").values()}), [7, 8, 9])
        for text, seeds in (("4", [4]), ("9,1,4", [9, 1, 4]), ("3..4,1, 8..9", [3, 4, 1, 8, 9])):
            self.bench("--seeds", text, "--out", "s", "--quiet")
            self.assertEqual([seed for (seed,) in self.query(self.home / "s", "SELECT seed FROM runs WHERE strategy = 'short' ORDER BY cell")], seeds)
        self.assertIn("--seeds: found seed 4 twice, expected each once", self.bench("--seeds", "1..5,4", code=2).stderr)
        self.assertIn("--seeds: found more seeds, expected at most 1000000", self.bench("--seeds", "1..600000,700000..1200000", code=2).stderr)
        self.assertIn("--seeds: found '[1,3]', expected a seed, a range \"0..29\", or several with commas between them", self.bench("--seeds", "[1,3]", code=2).stderr)
        self.assertIn("--seeds: found '9..7', expected a seed, a range", self.bench("--seeds", "9..7", code=2).stderr)
        self.assertIn("found '1..2000000', expected a range of at most 1000000 seeds", self.bench("--seeds", "1..2000000", code=2).stderr)
        self.write("home/suite.yaml", SUITE.replace("[1, 2]", '"1..2000000"'))
        self.assertIn("suite.yaml:2: seeds: found '1..2000000', expected a range of at most 1000000 seeds", self.bench(code=3).stderr)

    def test_rows_of_one_game_that_differ_are_reported(self):
        self.bench("--out", "a")
        shutil.copytree(self.home / "a", self.home / "b")
        file = next((self.home / "b/rows").glob("game-short-2-*.json"))
        file.write_text(re.sub(r'"journal_hash": "..', '"journal_hash": "00', file.read_text()))
        next((self.home / "b/rows").glob("game-short-1-*.json")).write_text("{")
        old = next((self.home / "b/rows").glob("game-duration_s_3-1-*.json"))
        old.write_text(re.sub(r'"program": "', '"program": "0', old.read_text()))
        done = self.bench("--collect", "a", "b", "--out", "c", code=1)
        self.assertRegex(done.stderr, r"error: cell 2: two rows of the same game differ, a/rows/game-short-2-\w+\.json and b/rows/game-short-2-\w+\.json; ")
        self.assertIn("\n1 row is of another build of cxlab", done.stderr)
        self.assertIn("\n1 file is not a row", done.stderr)
        (self.home / "b/rows.csv").unlink()
        shown = subprocess.run([CXLAB, "bench", "show", "b"], cwd=self.home, text=True, capture_output=True, timeout=60)
        self.assertEqual(shown.returncode, 3)
        self.assertRegex(shown.stderr, r"b/rows/game-short-1-\w+\.json: is not a row of a sweep, or is cut short; cxlab bench with its suite plays the game again\n$")
        self.assertEqual(self.query(self.home / "c", "SELECT count(*), count(DISTINCT cell) FROM runs"), [(6, 6)])

    def test_of_two_rows_of_a_game_the_first_counts_unless_only_the_second_was_played(self):
        self.bench("--out", "a")
        shutil.copytree(self.home / "a", self.home / "b")
        crashed = {"short-1": "ab", "short-2": "a", "duration_s_2-1": "b"}  # game: the folders in which it has no journal
        for game, folders in crashed.items():
            for name in folders:
                file = next((self.home / name / "rows").glob(f"game-{game}-*.json"))
                file.write_text(json.dumps(json.loads(file.read_text()) | {"journal_hash": "", "status": "failed", "errors": [f"crashed in {name}"]}))
        for first, second in ("ab", "ba"):
            self.bench("--collect", first, second, "--out", "of_" + first, code=1)
            rows = self.rows(self.home / ("of_" + first))
            errors = {game: [row["errors"] for name, row in rows.items() if name.startswith(f"game-{game}-")] for game in crashed}
            self.assertEqual(errors, {"short-1": [[f"crashed in {first}"]], "short-2": [[]], "duration_s_2-1": [[]]})

    def test_the_index_has_all_of_each_row(self):
        (self.home / ".git/refs/heads").mkdir(parents=True)
        (self.home / ".git/HEAD").write_text("ref: refs/heads/main\n")
        (self.home / ".git/refs/heads/main").write_text("0123456789abcdef0123456789abcdef01234567\n")
        self.write("home/rules/rules.clp", RULES + '(defrule told (time ?t&:(> ?t 2.2)) => (printout error "late" crlf))\n(defrule wrong (time ?t&:(> ?t 2.45)) => (/ 1 0))\n')
        self.bench("--out", "r", code=1)
        self.assertEqual(self.query(self.home / "r", "PRAGMA user_version"), [(1,)])
        self.assertEqual(self.query(self.home / "r", "SELECT cell, strategy, seed, status, completed, exit, sim_time_s FROM runs WHERE seed = 1 ORDER BY cell"),
                         [(1, "short", 1, "completed", 1, 0, 1.0), (3, "duration_s=2", 1, "completed", 1, 0, 2.0), (5, "duration_s=3", 1, "failed", 0, 4, 2.5)])
        self.assertEqual(self.query(self.home / "r", "SELECT DISTINCT value FROM parameters WHERE name = 'duration_s' ORDER BY cell"), [("2",), ("3",)])
        self.assertEqual(self.query(self.home / "r", "SELECT cell, tag FROM tags WHERE cell < 4"), [(1, "night"), (1, "quick"), (2, "night"), (2, "quick"), (3, "night")])
        messages = self.query(self.home / "r", "SELECT kind, text FROM messages WHERE cell = 5 ORDER BY number")
        self.assertEqual([kind for kind, _ in messages], ["error", "warning"])
        self.assertIn("wrong", messages[0][1])
        self.assertIn("late", messages[1][1])
        self.assertEqual(self.query(self.home / "r", "SELECT reason FROM runs WHERE cell = 5"), [(messages[0][1],)])
        shown = subprocess.run([CXLAB, "bench", "show", "r", "--table", "scores", "--metric", "sim_time_s"], cwd=self.home, text=True, capture_output=True, timeout=60)
        self.assertEqual(shown.returncode, 0, shown.stderr)
        self.assertRegex(shown.stderr, r"game, duration_s=3, 2 of 2 episodes: .*wrong")
        self.assertRegex(shown.stderr, r"game, duration_s=3, 2 of 2 episodes: .*late")
        self.assertNotIn("episodes", shown.stdout)
        self.write("home/completed.csv", (self.home / "r/rows.csv").read_text().replace(",failed,4,", ",completed,0,"))
        compared = subprocess.run([CXLAB, "bench", "compare", "completed.csv", "r", "--metric", "sim_time_s"], cwd=self.home, text=True, capture_output=True, timeout=60)
        self.assertEqual(compared.returncode, 1, compared.stderr)
        self.assertIn("cxlab bench page r shows these games with the commands that play them again\n", compared.stderr)
        self.assertEqual(self.query(self.home / "r", "SELECT DISTINCT agent_commit FROM runs"), [("0123456789abcdef0123456789abcdef01234567",)])
        for cpu, memory, wall, host in self.query(self.home / "r", "SELECT cpu_s, peak_rss_mb, wall_time_s, host FROM runs"):
            self.assertTrue(0 < cpu < 60 and 1 < memory < 5000 and 0 < wall < 60 and host, (cpu, memory, wall, host))
        self.assertIn(("wall_time_s", 1), self.query(self.home / "r", "SELECT name, of_machine FROM metrics"))
        # Columns are those of rows.csv and more; each row has its file.
        with open(self.home / "r/rows.csv", newline="") as table:
            header = next(csv.reader(table))
        self.assertNotIn("wall_time_s", header)
        columns = [name for _, name, *_ in self.query(self.home / "r", "PRAGMA table_info(runs)")]
        self.assertTrue(set(header) <= set(columns), (header, columns))
        for row, key in self.query(self.home / "r", "SELECT row, key FROM runs"):
            self.assertEqual(json.loads((self.home / "r" / row).read_text())["key"], key)
        # The command plays the game again, from any folder.
        command, journal = self.query(self.home / "r", "SELECT command, journal_hash FROM runs WHERE cell = 4")[0]
        self.assertEqual(shlex.split(command)[0], "cxlab")
        subprocess.run([CXLAB, *shlex.split(command)[1:], "--quiet", "--out", self.folder / "again"], cwd="/", check=True, stdout=subprocess.DEVNULL, timeout=60)
        self.assertEqual(json.loads((self.folder / "again/result.json").read_text())["journal_hash"], journal)

    def endless(self, rules):
        self.write("home/endless.yaml", CONFIG.replace('"rules"', '"rules"'))
        self.write("home/endless/rules.clp", rules)
        self.write("home/scenarios/endless.yaml", ENDLESS)
        self.write("home/suite.yaml", SUITE.replace("[scenarios/game.yaml]", "[scenarios/game.yaml, scenarios/endless.yaml]")
                   .replace("strategies: {short: {set: [duration_s=1], tags: [quick]}}\ngrid: {duration_s: [2, 3]}\n", "strategies: {plain: []}\n"))

    def test_an_episode_that_takes_too_long_is_a_row_and_the_others_go_on(self):
        self.endless("(defrule note (time ?) => )\n")
        done = self.bench("-j", 2, "--time-limit", 1, "--out", "r", code=1)
        self.assertIn("endless plain seed 1: crashed, exit 137; ended after 1 s of wall time, its limit", done.stderr)
        self.assertEqual(self.query(self.home / "r", "SELECT scenario, seed, status, completed, exit FROM runs"),
                         [("game", 1, "completed", 1, 0), ("game", 2, "completed", 1, 0), ("endless", 1, "crashed", 0, 137), ("endless", 2, "crashed", 0, 137)])
        self.assertEqual({row["errors"][0] for row in self.rows(self.home / "r").values() if row["status"] == "crashed"}, {"ended after 1 s of wall time, its limit"})
        # Rows of crashes are collected, and their games are played again.
        self.bench("--collect", "r", "--out", "c", code=1)
        self.assertEqual(self.query(self.home / "c", "SELECT count(*) FROM runs WHERE status = 'crashed'"), [(2,)])
        self.assertEqual((self.home / "c/rows.csv").read_bytes(), (self.home / "r/rows.csv").read_bytes())
        self.assertIn("2 rows are current and kept", self.bench("-j", 2, "--time-limit", 0.2, "--out", "c", code=1).stderr)

    def children(self, process):
        for _ in range(500):
            time.sleep(0.02)
            found = subprocess.run(["ps", "-o", "pid=", "--ppid", str(process.pid)], capture_output=True, text=True).stdout.split()
            if found:
                return list(map(int, found))
        self.fail("no episode is played")

    def test_a_killed_episode_is_a_row_with_its_reason(self):
        self.endless("(defrule note (time ?) => )\n")
        process = subprocess.Popen([CXLAB, "bench", "suite.yaml", "--cell", "3..4", "--out", "r"], cwd=self.home, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        for number in (signal.SIGKILL, signal.SIGSEGV):
            child = self.children(process)[0]
            time.sleep(0.5)
            os.kill(child, number)
            for _ in range(500):
                if not os.path.exists(f"/proc/{child}"):
                    break
                time.sleep(0.02)
        said = process.communicate(timeout=60)[1]
        self.assertEqual(process.returncode, 1, said)
        killed, crashed = (row for _, row in sorted(self.rows(self.home / "r").items()))
        self.assertEqual((killed["status"], killed["exit"], killed["errors"]), ("crashed", 137, ["killed by SIGKILL: the machine had no memory left, or somebody ended it"]))
        self.assertEqual(crashed["status"], "crashed")
        self.assertNotEqual(killed["key"], crashed["key"])
        self.assertIn("SIGSEGV", crashed["errors"][0])
        self.assertIn("endless plain seed 1: crashed, exit 137; killed by SIGKILL", said)

    def test_rules_that_take_all_memory_are_a_row_with_its_reason(self):
        self.endless('(deffunction grow (?a) (while TRUE (bind ?a (str-cat ?a ?a))))\n(defrule eat (time ?) => (grow "0123456789abcdef"))\n')
        self.bench("--memory", "50MB", "--out", "r", code=1)
        bad = [row for row in self.rows(self.home / "r").values() if row["scenario"] == "endless"]
        self.assertEqual(len(bad), 2)
        for row in bad:
            self.assertNotEqual(row["exit"], 0)
            self.assertIn("memory", row["errors"][0])

    def test_games_that_failed_at_a_limit_are_played_again_where_it_is_another(self):
        self.write("home/rules/rules.clp", "(defrule work (time ?) => (loop-for-count 5000 (random)))\n")
        self.bench("--steps", 2000, "--out", "r", code=1)
        self.assertEqual({(row["status"], row["allowance"]["steps"]) for row in self.rows(self.home / "r").values()}, {("failed", 2000)})
        for (command,) in self.query(self.home / "r", "SELECT command FROM runs"):
            again = subprocess.run([CXLAB, *shlex.split(command)[1:], "--out", "none"], cwd=self.home, text=True, capture_output=True, timeout=100)
            self.assertEqual(again.returncode, 4, command + again.stderr)
        self.assertIn("6 rows are current", self.bench("--steps", 2000, "--out", "r", code=1).stderr)
        self.assertEqual(len(self.bench("--cells", "--missing", "--out", "r").stdout.splitlines()), 6)
        self.bench("--out", "whole")
        done = self.bench("--collect", "r", "--out", "whole")
        self.assertNotIn("differ", done.stderr)
        self.assertEqual(self.query(self.home / "whole", "SELECT sum(completed) FROM runs"), [(6,)])
        self.assertNotIn("current", self.bench("--out", "r").stderr)
        self.assertEqual((self.home / "r/rows.csv").read_bytes(), (self.home / "whole/rows.csv").read_bytes())
        self.assertEqual(self.bench("--steps", 1_000_000_000, "--out", "r").stderr, "6 rows are current and kept\n")

    def test_seeds_have_64_bits(self):
        seeds = [0, 2**53 + 1, 2**63 - 1, 2**63, 2**64 - 2, 2**64 - 1]
        self.write("home/suite.yaml", SUITE[:SUITE.index("grid")].replace("[1, 2]", str(seeds)))
        self.bench("--out", "r")
        self.assertEqual([int(seed) for (seed,) in self.query(self.home / "r", "SELECT seed FROM runs ORDER BY cell")], seeds)
        page = (self.home / "r/index.html").read_text()
        self.assertIn(f"seed {2**64 - 1}", page)

    def test_kills_at_any_moment_change_nothing(self):
        self.write("home/suite.yaml", SUITE.replace("[1, 2]", '"1..6"'))
        self.bench("-j", 2, "--out", self.folder / "whole")
        command = [CXLAB, "bench", "suite.yaml", "-j", "2", "--quiet", "--out", "r"]
        for number, after in ((signal.SIGKILL, 0.15), (signal.SIGTERM, 0.3), (signal.SIGKILL, 0.22), (signal.SIGINT, 0.2), (signal.SIGKILL, 0.4)):
            process = subprocess.Popen(command, cwd=self.home, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            time.sleep(after)
            process.send_signal(number)
            process.wait(30)
            for file in (self.home / "r").glob("rows/*.json"):
                json.loads(file.read_text())  # each is whole
            if (self.home / "r/runs.sqlite").exists():
                self.query(self.home / "r", "SELECT * FROM runs")
        for _ in range(100):
            done = self.bench("-j", 2, "--out", "r", code=None)
            if done.returncode != 5:  # the last children of the killed sweep have ended
                break
            time.sleep(0.1)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual((self.home / "r/rows.csv").read_bytes(), (self.folder / "whole/rows.csv").read_bytes())
        self.assertEqual(self.rows(self.home / "r"), self.rows(self.folder / "whole"))
        self.assertEqual(self.query(self.home / "r", "SELECT count(*), count(DISTINCT key), sum(completed) FROM runs"), [(18, 18, 18)])
        self.assertEqual([file.name for file in (self.home / "r").rglob("*.part*")], [])

    def test_a_full_disk_ends_the_sweep_and_loses_nothing(self):
        # No file of more than 1 KiB: rows are longer.
        done = self.bench("--out", "r", code=5, before=["bash", "-c", 'ulimit -f 1; exec "$@"', "bash"])
        self.assertIn("is the disk full?", done.stderr)
        self.assertEqual(list((self.home / "r/rows").glob("*.json*")), [])
        self.bench("--out", "r")
        self.assertEqual(len(self.rows(self.home / "r")), 6)

    def test_progress_is_one_line_of_a_terminal(self):
        master, slave = pty.openpty()
        process = subprocess.Popen([CXLAB, "bench", "suite.yaml", "--out", "r"], cwd=self.home, stdout=subprocess.DEVNULL, stderr=slave)
        os.close(slave)
        said = b""
        while True:
            try:
                part = os.read(master, 4096)
            except OSError:
                break
            if not part:
                break
            said += part
        os.close(master)
        self.assertEqual(process.wait(60), 0)
        text = said.decode()
        self.assertNotIn("completed", text, "no line for an ordinary game")
        lines = [line for line in text.split("\r\x1b[K") if line.strip()]
        self.assertTrue(all("\n" not in line for line in lines), text)
        for line in lines:
            self.assertRegex(line, r"^\[[#.]{30}\] \d of 6 games, \d at play(, \d+:\d\d left)?$")
        self.assertTrue(text.endswith("\r\x1b[K") or not lines, "the line is taken away")
        # Elsewhere: a line each 10 s, and with -v one for each game.
        progress = r"^\d of 6 games, \d at play(, \d+:\d\d left)?$"
        games = [line for line in self.bench("-v", "-j", 1, "--out", "s").stderr.splitlines() if not re.match(progress, line)]
        self.assertEqual(len(games), 6, games)
        self.assertRegex(games[2], r"^\[3/6\] game duration_s=2 seed 1: completed, exit 0 \(\d+:\d\d left\)$")
        begin = time.monotonic()
        said = self.bench("--out", "t").stderr.splitlines()
        self.assertLessEqual(len(said), (time.monotonic() - begin) / 10, said)
        self.assertEqual(self.bench("--quiet", "--out", "u").stderr, "")

    def test_the_index_grows_and_a_kill_leaves_a_complete_one(self):
        self.write("home/suite.yaml", SUITE.replace("[1, 2]", '"1..200"'))
        process = subprocess.Popen([CXLAB, "bench", "suite.yaml", "--quiet", "--out", "r"], cwd=self.home, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        sizes = []
        for _ in range(3000):
            if (self.home / "r/runs.sqlite").exists():
                ((size,),) = self.query(self.home / "r", "SELECT count(*) FROM runs")
                if not sizes or size != sizes[-1]:
                    sizes.append(size)
                if len(sizes) == 4:
                    break
            time.sleep(0.01)
        process.kill()
        process.wait(30)
        self.assertEqual(len(sizes), 4)
        self.assertEqual(sizes, sorted(sizes))
        self.assertLess(sizes[-1], 600)
        self.assertEqual(list((self.home / "r").glob("runs.sqlite-*")), [], "no journal of SQLite's")
        with open(self.home / "r/rows.csv", newline="") as table:
            self.assertGreaterEqual(len(list(csv.DictReader(table))), sizes[-1])
        # The next start has the rows that came after it, too, before it has played anything.
        kept = len(self.rows(self.home / "r"))
        self.write("home/suite.yaml", SUITE.replace("[1, 2]", f'"1..200"').replace("duration_s: [2, 3]", "duration_s: [2, 1000000]"))
        for _ in range(200):
            process = subprocess.Popen([CXLAB, "bench", "suite.yaml", "--out", "r"], cwd=self.home, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
            said = process.stderr.readline()
            if "another sweep works in this folder" not in said:
                break
            process.wait(30)  # the last child of the killed sweep has not gone
            process.stderr.close()
            time.sleep(0.05)
        self.assertTrue(said.startswith(f"{kept} rows"), said)
        for _ in range(500):
            ((size,),) = self.query(self.home / "r", "SELECT count(*) FROM runs")
            if size >= kept:
                break
            time.sleep(0.02)
        process.kill()
        process.wait(30)
        process.stderr.close()
        self.assertGreaterEqual(size, kept)

    def test_cells_that_are_missing_are_listed(self):
        missing = lambda *arguments: [line.split("\t")[0] for line in self.bench("--cells", "--missing", "--out", "r", *arguments).stdout.splitlines()]
        self.assertEqual(missing(), ["1", "2", "3", "4", "5", "6"])
        self.bench("--cell", "2..4", "--out", "r")
        self.assertEqual(missing(), ["1", "5", "6"])
        self.assertEqual([cell["cell"] for cell in json.loads(self.bench("--cells", "--missing", "--json", "--out", "r").stdout)], [1, 5, 6])
        self.bench("--out", "r")
        self.assertEqual(missing(), [])
        self.write("home/rules/rules.clp", RULES + "; changed\n")
        self.assertEqual(len(missing()), 6)
        self.assertIn("--missing requires --cells", self.bench("--missing", code=2).stderr)

    def test_the_page_has_the_games_with_the_commands_that_play_them_again(self):
        self.bench("--out", "r")
        page = self.home / "r/index.html"
        text = lambda file=page: html.unescape(file.read_text())
        self.assertNotIn("its run", text())
        (build,) = {row["program"][:12] for row in map(json.loads, (file.read_text() for file in (self.home / "r/rows").glob("*.json")))}
        self.assertRegex(text(), f"(?s)build of cxlab.{{0,60}}{build}")
        show = lambda *arguments, code=0: subprocess.run([CXLAB, "bench", "page", *arguments], cwd=self.home, text=True, capture_output=True, timeout=120)
        done = show("r", "--play", "-j", "2")
        self.assertEqual((done.returncode, done.stdout), (0, "r/index.html\n"), done.stderr)
        self.assertNotIn("otherwise", done.stderr)
        links = re.findall(r'<a href="(games/[^"]*)">its run', text())
        self.assertEqual(len(links), 6)
        for link, journal in zip(sorted(links), [journal for (journal,) in self.query(self.home / "r", "SELECT journal_hash FROM runs ORDER BY row")], strict=True):
            self.assertTrue((page.parent / link).is_file())
            self.assertEqual(json.loads((page.parent / link).with_name("result.json").read_text())["journal_hash"], journal)
        # A command of the page plays its game, from any folder.
        command = re.search(r"<code>(cxlab run [^<]*)</code>", text())[1]
        words = shlex.split(command)
        shutil.rmtree(words[-1])
        subprocess.run([CXLAB, *words[1:], "--quiet"], cwd="/", check=True, stdout=subprocess.DEVNULL, timeout=60)
        self.assertTrue(os.path.exists(f"{words[-1]}/index.html"))
        # Elsewhere the links still lead there; a game that goes otherwise now is reported.
        self.assertEqual(show("r", "--out", "elsewhere.html").returncode, 0)
        for link in re.findall(r'<a href="([^"]*)">its run', text(self.home / "elsewhere.html")):
            self.assertTrue((self.home / link).is_file(), link)
        shutil.rmtree(self.home / "r/games")
        self.write("home/rules/rules.clp", RULES.replace("(random)", "(random) 1"))
        self.assertEqual(len(re.findall("goes otherwise now", show("r", "--play").stderr)), 6)
        # Two sweeps; and what cannot be used.
        self.bench("--out", "s")
        self.assertEqual(show("s", "r").returncode, 0)
        self.assertIn("Compared with r: ", (self.home / "s/index.html").read_text())
        for arguments, code, said in ((["r/rows.csv"], 2, "expected --out FILE.html"), (["nowhere", "--out", "x.html"], 3, "there is no such sweep"),
                                      (["nowhere"], 3, "nowhere: there is no such sweep; expected a folder of cxlab bench"),
                                      (["r", "--metric", "pints"], 3, "no row has a metric 'pints'"), (["r", "-j", "2"], 2, "--play")):
            with self.subTest(arguments=arguments):
                done = show(*arguments)
                self.assertEqual(done.returncode, code, done.stderr)
                self.assertIn(said, done.stderr)
        self.assertEqual(show("r/rows.csv", "--out", "table.html").returncode, 0)
        shutil.rmtree(self.home / "s/games", ignore_errors=True)
        self.write("home/other/rows.csv", re.sub("(?m)^game,", "other,", (self.home / "r/rows.csv").read_text()))
        done = show("s", "other", "--play")
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertIn("no scenario, strategy and game in common", done.stderr)
        self.assertFalse((self.home / "s/games").exists(), "nothing is played before")

    def test_four_commands_lead_from_a_suite_to_a_figure(self):
        section = (SOURCE / "docs/reference/sweep-statistics.md").read_text().split("### From a suite to a figure for a paper\n")[1]
        commands = [line.removeprefix("$ ") for line in section.split("```")[1].splitlines() if line.startswith("$ ")]
        self.assertEqual(len(commands), 4)
        self.write("bin/cxlab", f'#!/bin/sh\nexec "{CXLAB}" "$@"\n').chmod(0o755)
        self.write("home/suite.yaml", SUITE.replace("[1, 2]", '"1..12"'))
        for command in commands:
            done = subprocess.run(["bash", "-c", command], cwd=self.home, text=True, capture_output=True, timeout=120, env={**os.environ, "PATH": f"{self.folder}/bin:{os.environ['PATH']}"})
            self.assertEqual(done.returncode, 0, (command, done.stderr))
        figure = xml.etree.ElementTree.parse(self.home / "scores.svg").getroot()
        self.assertEqual(figure.tag, "{http://www.w3.org/2000/svg}svg")
        self.assertEqual(len(figure.findall("{*}circle[@class='game']")), 36)
        self.assertIn("\\begin{tabular}", (self.home / "differences.tex").read_text())
        self.assertTrue((self.home / "runs/paper/index.html").is_file())

    def test_wrong_uses_are_reported(self):
        for arguments, code, said in ((["--cell", "0"], 2, "--cell: found '0', expected the number of a cell, 1 to 6, or a range of them, as 1..6"),
                                      (["--cell", "7"], 2, "found '7'"), (["--cell", "x"], 2, "found 'x'"), (["--cell", "3..2"], 2, "found '3..2'"),
                                      (["--cell", "1..7"], 2, "found '1..7'"), (["--cell", "1.."], 2, "found '1..'"), (["--cell", "-1"], 2, "found '-1'"),
                                      (["--cell", "1", "--cells"], 2, "--cell"), (["--collect", "x", "--cell", "1"], 2, "--c"),
                                      (["--collect", "nowhere"], 3, "nowhere: expected a folder with the rows of a sweep"), (["--time-limit", "0"], 2, "--time-limit")):
            with self.subTest(arguments=arguments):
                done = self.bench(*arguments, "--out", "o", code=code)
                self.assertIn(said, done.stderr)
                self.assertFalse((self.home / "o/rows.csv").exists())
        # The job of a machine that lacks a file says so in its row.
        (self.home / "agent.yaml").unlink()
        self.bench("--cell", "2", "--out", "o", code=1)
        (row,) = self.rows(self.home / "o").values()
        self.assertEqual((row["status"], row["exit"]), ("failed", 3))
        self.assertIn("agent.yaml", row["errors"][0])

    def test_the_tasks_of_a_job_array_play_all_cells_once(self):
        (self.home / "suite.yaml").rename(self.home / "it's a suite.yaml")
        command = [CXLAB, "bench", "it's a suite.yaml"]
        run = lambda *arguments, **options: subprocess.run(arguments, cwd=self.home, text=True, capture_output=True, timeout=120, **options)
        self.assertEqual(run(*command, "--quiet", "--memory", "1GB", "--out", "whole").returncode, 0)
        done = run(*command, "--slurm", "--tasks", "4", "-j", "2", "--memory", "1GB", "--time-limit", "50", "--out", "r")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("r/slurm/cells.sh: 3 tasks of up to 2 cells\n", done.stdout)
        text = (self.home / "r/slurm/cells.sh").read_text()
        self.assertIn("\n#SBATCH --array=1-3\n", text)
        self.assertIn("\n#SBATCH --cpus-per-task=2\n", text)
        self.assertIn(" --time-limit 50 --memory 1000000000 --out ", text)
        for task in (1, 2, 3):
            done = run(self.home / "r/slurm/cells.sh", env={**os.environ, "SLURM_ARRAY_TASK_ID": str(task)})
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(len(done.stdout.splitlines()), 2)
        done = run(self.home / "r/slurm/collect.sh")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(self.rows(self.home / "r"), self.rows(self.home / "whole"))
        # What submits them: a stand-in for sbatch prints its arguments and a number.
        self.write("bin/sbatch", '#!/bin/sh\necho "$@" >> "$SAID"\necho "$(wc -l < "$SAID");cluster"\n').chmod(0o755)
        environment = {**os.environ, "PATH": f"{self.folder}/bin:{os.environ['PATH']}", "SAID": str(self.folder / "said")}
        done = run(self.home / "r/slurm/submit.sh", "--time=5", env=environment)
        self.assertEqual(done.stdout, "cells: job 1, table: job 2\n", done.stderr)
        scripts = self.home / "r/slurm"
        self.assertEqual((self.folder / "said").read_text().splitlines(), [f"--parsable --time=5 {scripts}/cells.sh", f"--parsable --dependency=afterany:1 --time=5 {scripts}/collect.sh"])
        self.assertIn("blanks", run(*command, "--slurm", "--out", "with blanks").stderr)
        self.assertIn("--tasks requires --slurm", run(*command, "--tasks", "2").stderr)

    def test_parameters_of_an_agent_are_set_one_by_one(self):
        self.write("home/suite.yaml", "scenarios: [scenarios/game.yaml]\nseeds: [1]\n"
                   "grid:\n  watch:\n    facts: [\"agents[0].params.clips_manager.main.watch=[facts]\"]\n    rules: [\"agents[0].params.clips_manager.main.watch=[rules]\"]\n  agents[0].params.clips_manager.gian: [1]\n")
        done = self.bench("--out", "r")
        self.assertIn("parameter 'gian' was set, but nothing reads it", done.stderr)
        self.assertEqual(self.query(self.home / "r", "SELECT strategy FROM runs"), [("watch=facts gian=1",), ("watch=rules gian=1",)])


if __name__ == "__main__":
    import unittest

    unittest.main()
