"""Real kills of a sweep at random moments: what is left in the end is the table of a sweep that nobody disturbed.

$CXLAB_GAMES games of the league are played with three kills, 1,000 unless it says otherwise."""

import json
import os
import pathlib
import random
import signal
import sqlite3
import subprocess
import sys
import time
import unittest

from lab import CXLAB, GAME, SOURCE, Lab

SUITE = """scenarios: [easy/game.yaml, hard/game.yaml]
seeds: "1..6"
strategies: {three: [], one: ["world.robots=1"]}
"""
KILLS = 50


class SweepKills(Lab):
    def bench(self, out):
        return [CXLAB, "bench", str(self.folder / "suite.yaml"), "-j", "2", "--quiet", "--json", "--out", str(out)]

    def table(self, out):
        """The table of a sweep that is let be, without what the clock of the wall says."""
        for _ in range(100):
            done = subprocess.run(self.bench(out), capture_output=True, text=True, timeout=300)
            if done.returncode != 5:  # the last children of the killed sweep have not gone yet
                break
            time.sleep(0.1)
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = sorted((out / "rows").glob("*.json"))
        return {row.name: {k: v for k, v in json.loads(row.read_text()).items() if k != "played"} for row in rows}

    def test_the_table_is_that_of_an_undisturbed_sweep(self):
        self.write("suite.yaml", SUITE)
        self.write("easy/game.yaml", GAME)
        self.write("hard/game.yaml", GAME.replace("20", "60"))
        whole = self.table(self.folder / "whole")
        self.assertEqual(len(whole), 24)
        chance = random.Random(7)
        moments = []
        for number in range(KILLS):
            out = self.folder / f"killed-{number // 10}"
            process = subprocess.Popen(self.bench(out), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            time.sleep(chance.uniform(0.01, 0.5))
            process.send_signal(signal.SIGKILL if number % 5 else signal.SIGTERM)
            process.wait(20)
            moments.append(len(list((out / "rows").glob("*.json"))))
            if number % 10 == 9:
                self.assertEqual(self.table(out), whole)
        self.assertGreater(len(set(moments)), 5, "the kills came at the same moment")


class ManyGames(Lab):
    GAMES = int(os.environ.get("CXLAB_GAMES", 1000))

    def play(self, out, kill_after=None):
        """Plays on, and takes down how much memory the sweep has; whether it came to its end."""
        process = subprocess.Popen([CXLAB, "bench", str(self.folder / "suite.yaml"), "-j", "2", "--quiet", "--out", str(out)], stdout=subprocess.DEVNULL)
        begin, rows = time.monotonic(), 0
        while process.poll() is None:
            rows = len(os.listdir(out / "rows")) if (out / "rows").exists() else 0
            if kill_after is not None and rows >= kill_after:
                process.kill()
                process.wait()
                return False
            status = pathlib.Path(f"/proc/{process.pid}/status")
            try:
                self.memory.append((rows, int(next(line.split()[1] for line in status.read_text().splitlines() if line.startswith("VmRSS"))) / 1024))
            except (OSError, StopIteration):
                pass
            time.sleep(0.2)
        self.assertIn(process.returncode, (0, 5))
        self.wall += time.monotonic() - begin
        return process.returncode == 0

    def test_three_kills_of_many_games(self):
        self.write("suite.yaml", f'scenarios: [{SOURCE}/scenarios/rcll/game.yaml]\ntier: timed\nseeds: "1..{self.GAMES}"\nstrategies: {{agent: []}}\n')
        self.memory, self.wall = [], 0.0
        whole, killed = self.folder / "whole", self.folder / "killed"
        self.assertTrue(self.play(whole))
        memory, wall = self.memory, self.wall
        self.memory = []  # a sweep that goes on reads the program and its libraries first
        chance = random.Random(11)
        for after in sorted(chance.sample(range(self.GAMES // 20, self.GAMES), 3)):
            self.assertFalse(self.play(killed, after))
            time.sleep(1)
        self.assertTrue(self.play(killed))
        self.assertEqual((killed / "rows.csv").read_bytes(), (whole / "rows.csv").read_bytes())
        with sqlite3.connect(whole / "runs.sqlite") as index:
            self.assertEqual(index.execute("SELECT count(*), count(DISTINCT key), sum(completed) FROM runs").fetchone(), (self.GAMES,) * 3)
            games = index.execute("SELECT cpu_s, peak_rss_mb, wall_time_s FROM runs ORDER BY cell").fetchall()
        tenth = max(1, self.GAMES // 10)
        first, last = (sorted(rss for _, rss, _ in part)[tenth // 2] for part in (games[:tenth], games[-tenth:]))
        early, late = (max(mb for rows, mb in memory if low <= rows <= high) for low, high in ((tenth, 2 * tenth), (self.GAMES - tenth, self.GAMES)))
        print(f"{self.GAMES} games: {wall:.0f} s of wall time, {sum(cpu for cpu, _, _ in games):.0f} s of CPU; memory of the sweep {early:.1f} MB after a tenth, "
              f"{late:.1f} MB at the end; of a game {first:.1f} MB among the first, {last:.1f} MB among the last", file=sys.stderr)
        self.assertLess(late - early, 2 + self.GAMES * 0.01, "the sweep keeps no more than a row's figures, some kB")
        self.assertLess(last - first, 1 + self.GAMES * 0.003, "a game's process shares the pages of the rows that the sweep keeps, and needs nothing more")


if __name__ == "__main__":
    unittest.main()
