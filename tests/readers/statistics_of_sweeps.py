"""cxlab bench show and compare beside SciPy, on random sweeps."""

import csv
import io
import json
import random
import subprocess
import unittest

import numpy
from scipy import stats

from lab import CXLAB, Lab

COLUMNS = "scenario,strategy,game,seed,status,exit,points,journal_hash\n"


def iqm(values, axis=-1):
    return stats.trim_mean(values, 0.25, axis=axis)


class Statistics(Lab):
    def show(self, *arguments):
        return json.loads(subprocess.run([CXLAB, "bench", *map(str, arguments), "--json"], cwd=self.folder, text=True, capture_output=True, timeout=100).stdout)

    def sweeps(self):
        """Points of two strategies in the same games: few and many games, skewed, with ties, far apart."""
        chance = random.Random(11)
        for n in (12, 15, 40):
            for step, shift, tail in ((1, 0, 0), (5, 20, 0), (20, 10, 80)):
                games = [[step * round((600 + chance.gauss(0, 50) - chance.expovariate(1) * tail + shift * k) / step) for _ in range(n)] for k in range(2)]
                yield numpy.array(games, dtype=float)

    def test_figures_are_those_of_scipy(self):
        for first, second in self.sweeps():
            n = len(first)
            lines = [f"game,{name},,{seed},completed,0,{points},h\n" for name, games in (("a", first), ("b", second)) for seed, points in enumerate(games)]
            self.write("s/rows.csv", COLUMNS + "".join(lines))
            tables = self.show("show", "s")
            level = 2 * stats.norm.cdf((1 + 1 / n) * numpy.sqrt(n / (n - 1)) * stats.t.ppf(0.975, n - 1)) - 1
            for line, points in zip(tables["scores"], (first, second)):
                for key, statistic in (("mean", numpy.mean), ("median", numpy.median), ("iqm", iqm)):
                    self.assertAlmostEqual(line[key], statistic(points), places=9)
                of_scipy = [stats.bootstrap((points,), numpy.mean, confidence_level=level, n_resamples=29999, method="BCa", rng=k).confidence_interval for k in range(2)]
                chance = 0.4 * numpy.std(points) / numpy.sqrt(n)  # of the ends of 10,000 draws, for few points
                for interval in of_scipy:
                    self.assertLess(abs(line["mean_95"][0] - interval.low), chance, (n, line, interval))
                    self.assertLess(abs(line["mean_95"][1] - interval.high), chance, (n, line, interval))
            differences = second - first
            line = tables["differences"][0]
            self.assertAlmostEqual(line["difference"], differences.mean(), places=9)
            self.assertAlmostEqual(line["effect"], differences.mean() / differences.std(ddof=1), places=9)
            self.assertAlmostEqual(line["improvement"], stats.mannwhitneyu(second, first).statistic / n / n, places=9)
            exact = n <= 15
            p = stats.permutation_test((differences,), numpy.mean, permutation_type="samples", n_resamples=numpy.inf if exact else 99999, rng=1).pvalue
            self.assertAlmostEqual(line["p"], p, delta=1e-12 if exact else 4 * numpy.sqrt(p * (1 - p) / 1e5) * 2 + 1e-5)
            self.assertEqual((line["won"], line["drawn"], line["lost"]), ((differences > 0).sum(), (differences == 0).sum(), (differences < 0).sum()))
            profile = tables["profile"][1]
            for key, share in profile.items():
                if key.startswith("at_least_"):
                    self.assertAlmostEqual(share, (second >= float(key.removeprefix("at_least_"))).mean())

    def test_the_games_that_are_missing_give_the_power(self):
        chance = random.Random(3)
        first = [chance.gauss(0, 1) for _ in range(20)]
        second = [f + chance.gauss(0.35, 1) for f in first]
        self.write("s/rows.csv", COLUMNS + "".join(f"game,{name},,{seed},completed,0,{p},h\n" for name, games in (("a", first), ("b", second)) for seed, p in enumerate(games)))
        line = self.show("show", "s", "--table", "differences")["differences"][0]
        self.assertEqual(line["answer"], "undecided")
        n = 20 + line["more_games"]
        limit = stats.t.ppf(1 - 0.02, n - 1)
        power = stats.nct.sf(limit, n - 1, abs(line["effect"]) * numpy.sqrt(n))
        self.assertAlmostEqual(power, 0.8, delta=0.03)

    def test_csv_is_read_with_all_digits(self):
        self.write("s/rows.csv", COLUMNS + "".join(f"game,a,,{seed},completed,0,{1 / (seed + 3)},h\n" for seed in range(9)))
        text = subprocess.run([CXLAB, "bench", "show", "s", "--table", "scores", "--format", "csv"], cwd=self.folder, text=True, capture_output=True, timeout=100).stdout
        line = next(csv.DictReader(io.StringIO(text)))
        self.assertAlmostEqual(float(line["mean"]), sum(1 / (seed + 3) for seed in range(9)) / 9, places=15)


if __name__ == "__main__":
    unittest.main()
