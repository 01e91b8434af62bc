"""cxlab bench show and compare, and requirements of suites, as a user types them."""

import csv
import io
import json
import random
import subprocess
import unittest
import xml.etree.ElementTree

from lab import CONFIG, CXLAB, Lab

COLUMNS = "scenario,strategy,game,seed,status,exit,points,late_s,journal_hash\n"
SUITE = """scenarios: [s.yaml]
seeds: "1..20"
strategies: {long: [], short: [duration_s=1], same: []}
"""


class SweepStatistics(Lab):
    def cxlab(self, *arguments, code=0):
        done = subprocess.run([CXLAB, *map(str, arguments)], cwd=self.folder, text=True, capture_output=True, timeout=200, stdin=subprocess.DEVNULL)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done

    def sweep(self, name, rows):
        """A rows.csv of (strategy, seed, points) of completed games."""
        lines = [f"game,{strategy},,{seed},completed,0,{points},{0.5 * seed},h\n" for strategy, seed, points in rows]
        self.write(f"{name}/rows.csv", COLUMNS + "".join(lines))

    def points(self, seed, mean, n=30):
        chance = random.Random(seed)
        return [5 * round(chance.gauss(mean, 60) / 5) for _ in range(n)]

    def test_two_sweeps_are_better_worse_or_undecided(self):
        old, noise = self.points(1, 600), self.points(2, 0)
        self.sweep("old", [("agent", seed, p) for seed, p in enumerate(old)])
        self.sweep("better", [("agent", seed, p + 60 + noise[seed] // 2) for seed, p in enumerate(old)])
        self.sweep("same", [("agent", seed, p + noise[seed] // 2) for seed, p in enumerate(old)])
        self.sweep("renamed", [("rules v2", seed, p + 60 + noise[seed] // 2) for seed, p in enumerate(old)])
        for now, answer, code in (("better", "better", 0), ("renamed", "better", 0), ("same", "undecided", 6), ("old", "undecided", 6)):
            self.assertIn(f"answer: {answer}\n", self.cxlab("bench", "compare", "old", now, code=code).stdout)
        self.assertIn("answer: worse\n", self.cxlab("bench", "compare", "better", "old", code=1).stdout)
        self.sweep("several", [(strategy, seed, p + 60) for strategy in ("rules v2", "rules v3") for seed, p in enumerate(old)])
        self.assertIn("agent is in the old sweep only", self.cxlab("bench", "compare", "old", "several", code=3).stderr)
        self.sweep("shifted", [("agent", seed + 10, p + 60) for seed, p in enumerate(old[10:])] + [("agent", 90, 600)])
        self.assertIn("game, agent: 20 games are in both sweeps, and 11 in one only", self.cxlab("bench", "compare", "old", "shifted").stdout)
        line = json.loads(self.cxlab("bench", "compare", "old", "better", "--json").stdout)["differences"][0]
        differences = [60 + noise[seed] // 2 for seed in range(30)]
        self.assertAlmostEqual(line["difference"], sum(differences) / 30)
        low, high = line["difference_95"]
        self.assertTrue(40 < low < line["difference"] < high < 80, line)
        self.assertEqual((line["games"], line["won"] + line["drawn"] + line["lost"], line["answer"]), (30, 30, "better"))
        # Less is better for lateness, which is the same in all.
        self.cxlab("bench", "compare", "old", "better", "--metric", "late_s", code=6)

    def test_less_is_better_where_the_world_says_so(self):
        lines = {name: "".join(f"game,agent,,{seed},completed,0,100,{late + seed % 3},h\n" for seed in range(12)) for name, late in (("old", 20), ("late", 30))}
        for name, text in lines.items():
            self.write(f"{name}/rows.csv", COLUMNS + text)
        answer = json.loads(self.cxlab("bench", "compare", "old", "late", "--metric", "late_s", "--json", code=1).stdout)
        self.assertEqual((answer["answer"], answer["differences"][0]["difference"], answer["differences"][0]["lost"]), ("worse", 10, 12))

    def test_a_game_that_only_the_old_sweep_completed_is_worse(self):
        self.sweep("old", [("agent", seed, 600 + seed) for seed in range(20)])
        self.sweep("new", [("agent", seed, 700 + seed) for seed in range(20)])
        text = (self.folder / "new/rows.csv").read_text().replace("game,agent,,7,completed,0,707", "game,agent,,7,crashed,70,")
        self.write("new/rows.csv", text)
        done = self.cxlab("bench", "compare", "old", "new", code=1)
        self.assertIn("game, agent: worse, because 1 game was not completed that the other side completed\nanswer: worse\n", done.stdout)
        self.assertEqual(done.stderr, "", "rows.csv alone has no commands")
        said = self.cxlab("bench", "compare", "new", "old", code=1).stdout
        self.assertIn("game, agent: 1 game was completed that the other side did not complete; they count in no difference\nanswer: worse\n", said)
        # All crash: there is no pair, and no lack of seeds.
        self.write("none/rows.csv", COLUMNS + "".join(f"game,agent,,{seed},crashed,137,,,\n" for seed in range(20)))
        said = self.cxlab("bench", "compare", "old", "none", code=1).stdout
        self.assertIn("game, agent: worse, because 20 games were not completed that the other side completed\nanswer: worse\n", said)
        self.assertNotIn("seeds", said)

    def test_an_agent_that_crashes_holds_no_requirement(self):
        self.write("s.yaml", "schema: 1\nduration_s: 2\npackages: {rules: rules}\nagents:\n  - config: agent.yaml\n")
        self.write("agent.yaml", CONFIG)
        self.write("rules/rules.clp", "(defrule bomb (time ?t&:(> ?t 0.5)) => (while TRUE do (bind ?x 1)))\n")
        self.write("release/rows.csv", COLUMNS.replace("points", "sim_time_s") + "".join(f"s,agent,,{seed},completed,0,2,1,h\n" for seed in (1, 2)))
        self.write("suite.yaml", "scenarios: [s.yaml]\nseeds: [1, 2]\nstrategies: {agent: []}\nearlier: {release: release}\n"
                                 "require: [not worse than release, not worse than release in sim_time_s by 10, mean(sim_time_s) >= 0]\n")
        said = self.cxlab("bench", "suite.yaml", "--out", "o", "--quiet", "--time-limit", "0.5", "-j", 2, code=1).stdout
        self.assertRegex(said, r"\nagent +not worse than release +worse +2 +- +- +0 ", "in the metric that the earlier sweep has")
        self.assertRegex(said, r"\nagent +not worse than release in sim_time_s by 10 +worse +2 +- +- +0 ")
        self.assertRegex(said, r"\nagent +mean\(sim_time_s\) >= 0 +worse +2 +- +- +0 ")
        self.assertIn("s, agent: worse, because 2 games were not completed that the other side completed\n", said)
        self.assertIn("s, agent: worse, because 2 games were not completed\n", said)
        self.assertRegex(said, r"\ns, agent: 'not worse than release in sim_time_s by 10' does not hold; seed 1 was not completed\n  cxlab run [^\n]*/s\.yaml [^\n]*--seed 1\n")
        self.assertNotIn("add seeds", said)

    def test_sweeps_of_other_scenarios_are_not_compared(self):
        self.sweep("old", [("agent", seed, 600) for seed in range(12)])
        text = (self.folder / "old/rows.csv").read_text()
        self.write("other/rows.csv", text.replace("game,agent", "game9,agent"))
        said = self.cxlab("bench", "compare", "old", "other", code=3).stderr
        self.assertIn("in common; game9, agent is in the new sweep only; game, agent is in the old sweep only; expected the same scenarios and seeds in both", said)
        self.write("both/rows.csv", text + text.removeprefix(COLUMNS).replace("game,agent", "game9,agent"))
        self.assertIn("game9, agent is in the new sweep only\n", self.cxlab("bench", "compare", "old", "both", code=6).stdout)

    def test_tables_are_written_in_four_ways(self):
        rows = [(name, seed, points) for name, mean in (("first_one", 600), ("50 % | all", 500)) for seed, points in enumerate(self.points(mean, mean))]
        self.sweep("s", rows)
        table = list(csv.DictReader(io.StringIO(self.cxlab("bench", "show", "s", "--format", "csv", "--table", "scores").stdout)))
        self.assertEqual([line["strategy"] for line in table], ["first_one", "50 % | all"])
        for line in table:
            points = sorted(p for name, _, p in rows if name == line["strategy"])
            self.assertAlmostEqual(float(line["mean"]), sum(points) / 30)
            self.assertEqual((float(line["median"]), float(line["min"]), float(line["max"])), ((points[14] + points[15]) / 2, points[0], points[-1]))
            self.assertAlmostEqual(float(line["iqm"]), sum(points[7:23]) / 16)
            self.assertTrue(float(line["mean_95_low"]) < float(line["mean"]) < float(line["mean_95_high"]))
        markdown = self.cxlab("bench", "show", "s", "--format", "markdown").stdout.splitlines()
        self.assertEqual(markdown[2:4], ["| strategy | games | mean | 95 % | median | 95 % | middle half | 95 % | least | most |", "|---|" + "---:|" * 9])
        self.assertTrue(markdown[5].startswith("| 50 % \\| all | 30/30 | "), markdown[5])
        latex = self.cxlab("bench", "show", "s", "--format", "latex", "--table", "differences").stdout.splitlines()
        self.assertEqual(latex[1], "\\begin{tabular}{llrrrrrrrrrrlr}")
        self.sweep("odd", [("[greedy]", 1, 500), ("*", 1, 400)])
        odd = self.cxlab("bench", "show", "odd", "--format", "latex", "--table", "scores").stdout
        self.assertIn("\n{}[greedy] & ", odd)
        self.assertIn("\n{}* & ", odd)
        self.assertRegex(latex[5], r"^50 \\% \| all & first\\_one & 30 & \$-\$\d+\.\d & \[\$-\$\d+\.\d, \$-\$\d+\.\d\] & .* & worse & -- \\\\$")
        profile = json.loads(self.cxlab("bench", "show", "s", "--json", "--table", "profile").stdout)["profile"]
        for line in profile:
            points = [p for name, _, p in rows if name == line["strategy"]]
            for key, share in line.items():
                if key.startswith("at_least_"):
                    self.assertAlmostEqual(share, sum(p >= float(key.removeprefix("at_least_")) for p in points) / 30)
        self.assertGreater(len(profile[0]), 5)
        twice = [self.cxlab("bench", "show", "s").stdout for _ in range(2)]
        self.assertEqual(*twice)

    def test_tables_for_programs_have_the_same_columns_whatever_the_rows_are(self):
        columns = COLUMNS.replace("late_s", "deliveries,points_ring")
        self.write("few.csv", columns + "game,first,,1,completed,0,30,,,h\n")
        self.write("many.csv", columns + "".join(f"{scenario},{name},,{seed},completed,0,{30 + seed},2,10,h\n" for scenario in ("game", "other") for name in ("first", "second") for seed in range(8)))
        for table in ("scores", "differences", "overview", "parts", "shares", "profile"):
            csvs = [self.cxlab("bench", "show", name, "--table", table, "--format", "csv").stdout for name in ("few.csv", "many.csv")]
            headers = [next(csv.reader(io.StringIO(text))) for text in csvs]
            self.assertEqual([header[:3] for header in headers], [["scenario", "strategy", "against" if table in ("differences", "shares") else "metric"]] * 2)
            if table != "profile":
                self.assertEqual(*headers, table)
            for header, text in zip(headers, csvs):
                self.assertEqual({len(line) for line in csv.reader(io.StringIO(text))}, {len(header)}, table)
            few, many = (json.loads(self.cxlab("bench", "show", name, "--table", table, "--json").stdout)[table] for name in ("few.csv", "many.csv"))
            for row in few:
                self.assertEqual(list(row)[:3], list(many[0])[:3])
                if table != "profile":
                    self.assertEqual(list(row), list(many[0]))
        header, line = self.cxlab("bench", "show", "few.csv", "--table", "scores", "--format", "csv").stdout.splitlines()
        self.assertEqual(header, "scenario,strategy,metric,games,mean,mean_95_low,mean_95_high,median,median_95_low,median_95_high,iqm,iqm_95_low,iqm_95_high,min,max")
        self.assertEqual(line, "game,first,points,1,30,,,30,,,30,,,30,30")

    def test_scenarios_may_have_different_figures(self):
        rows = [f"figures,{name},,{seed},completed,0,,,{seed % 3},{walls},h\n" for name, walls in (("first", 4), ("second", 2)) for seed in range(8)]
        rows += [f"game,{name},,{seed},completed,0,{points},{points},,,h\n" for name, points in (("first", 30), ("second", 50)) for seed in range(8)]
        self.write("s/rows.csv", COLUMNS.replace("late_s", "points_ring,touches,walls") + "".join(rows))
        show = lambda table, *arguments: json.loads(self.cxlab("bench", "show", "s", "--table", table, "--json", *arguments).stdout)[table]
        scenarios = ["figures", "figures", "game", "game"]
        self.assertEqual([(row["scenario"], row["metric"], row["games"], row["mean"]) for row in show("scores")],
                         [("figures", "walls", 8, 4), ("figures", "walls", 8, 2), ("game", "points", 8, 30), ("game", "points", 8, 50)])
        self.assertEqual([(row["games"], row["mean"], row["metric"]) for row in show("scores", "--metric", "points")], [(0, None, "points")] * 2 + [(8, 30, "points"), (8, 50, "points")])
        for arguments in ((), ("--metric", "points")):
            parts = show("parts", *arguments)
            self.assertEqual([(row["scenario"], row["points_ring"]) for row in parts], list(zip(scenarios, [None, None, 30, 50])))
        self.assertEqual([(row["scenario"], row["difference"], row["answer"]) for row in show("differences")], [("figures", -2, "better"), ("game", 20, "better")])
        (only,) = show("differences", "--metric", "points")
        self.assertEqual((only["scenario"], only["difference"], only["p_holm"]), ("game", 20, only["p"]))
        self.assertEqual([row["scenario"] for row in show("shares", "--metric", "points")], ["game"])
        self.assertEqual([(row["at_most_2"], row["at_most_4"], row["at_least_30"], row["at_least_50"]) for row in show("profile")],
                         [(0, 1, None, None), (1, 1, None, None), (None, None, 1, 0), (None, None, 1, 1)])
        each = "no row has a metric 'point'; figures has touches, walls; game has points, points_ring; did you mean 'points'?"
        for command in (("show", "s"), ("compare", "s", "s")):
            self.assertIn(each, self.cxlab("bench", *command, "--metric", "point", code=3).stderr)
        self.assertIn("figures, first: no row has a metric 'points'", self.cxlab("bench", "compare", "s", "s", "--metric", "points", code=6).stdout)
        # One scenario at a time.
        self.assertEqual([row["mean"] for row in show("scores", "--scenario", "figures")], [4, 2])
        self.assertTrue(self.cxlab("bench", "show", "s", "--scenario", "game").stdout.startswith("scores, points in game:\n"))
        for scenario, metric, other in (("figures", "walls", "game"), ("game", "points", "figures")):
            alone = self.cxlab("bench", "compare", "s", "s", "--scenario", scenario, code=6).stdout
            self.assertTrue(alone.startswith(f"differences, {metric} in {scenario}:\n"), alone)
            self.assertNotIn(f"{other}, first", alone, "it is not said to be in one of the sweeps only")
        for arguments in (("show", "s"), ("plot", "s", "out.svg"), ("compare", "s", "s")):
            self.assertIn("there is no scenario 'gane'; there are figures, game; did you mean 'game'?", self.cxlab("bench", *arguments, "--scenario", "gane", code=3).stderr)
        for kind in ("scores", "profile", "differences", "shares"):
            self.assertIn("the scenarios have different figures, walls and points; expected --scenario with one of them, or --metric", self.cxlab("bench", "plot", "s", "out.svg", "--kind", kind, code=3).stderr)
        for kind in ("scores", "profile", "differences", "shares", "parts"):
            self.cxlab("bench", "plot", "s", "out.svg", "--kind", kind, "--scenario", "game")
            one = (self.folder / "out.svg").read_text()
            self.assertNotIn("figures", one)
            self.cxlab("bench", "plot", "s", "out.svg", "--kind", kind, "--metric", "points")
            marks = lambda text: sum(text.count(mark) for mark in ('class="game"', 'class="better"', "<path", '<rect class="series'))
            self.assertGreater(marks(one), 0, kind)
            self.assertEqual(marks((self.folder / "out.svg").read_text()), marks(one), kind)
        # The page has a part for each scenario.
        self.cxlab("bench", "page", "s", "--metric", "points")
        page = (self.folder / "s/index.html").read_text()
        self.assertEqual(page.count("No completed game has a figure that could be compared."), 1)
        self.assertIn("no row has a metric 'point'", self.cxlab("bench", "page", "s", "--metric", "point", code=3).stderr)

    def test_an_overview_has_several_figures(self):
        lines = [f"game,{name},,{seed},completed,0,{points + seed},{0.5 * seed},h\n" for name, points in (("first", 600), ("second", 500)) for seed in range(12)]
        self.write("s/rows.csv", (COLUMNS + "".join(lines)).replace("late_s", "deliveries", 1))
        first, second = json.loads(self.cxlab("bench", "show", "s", "--table", "overview", "--json").stdout)["overview"]
        self.assertEqual((first["strategy"], first["mean"], first["min"], first["deliveries"], first["difference"]), ("first", 605.5, 600, 2.75, None))
        self.assertEqual((second["difference"], second["difference_95"]), (-100, [-100, -100]))

    def test_shares_are_those_of_the_same_game(self):
        rows = [("first", 1, 500), ("first", 2, 200), ("first", 3, 0), ("second", 1, 250), ("second", 2, 180), ("second", 3, 70)]
        self.sweep("s", rows)
        (second,) = json.loads(self.cxlab("bench", "show", "s", "--table", "shares", "--json").stdout)["shares"]
        for kind in ("scores", "differences", "profile", "parts", "shares"):
            for arguments in (("show", "s", "--table", kind), ("plot", "s", "x.svg", "--kind", kind)):
                self.assertIn("there is no strategy 'nope'; there are ", self.cxlab("bench", *arguments, "--against", "nope", code=3).stderr)
        self.assertEqual((second["strategy"], second["against"], second["games"]), ("second", "first", 2), "0 points are no measure")
        self.assertEqual((second["min"], second["max"]), (0.5, 0.9))
        self.assertAlmostEqual(second["share"], 0.7)
        self.assertLess(second["share_95"][0], 0.7)
        (first,) = json.loads(self.cxlab("bench", "show", "s", "--table", "shares", "--against", "second", "--json").stdout)["shares"]
        self.assertEqual((first["games"], first["min"], first["max"]), (3, 0, 2))
        self.assertNotIn("share", self.cxlab("bench", "show", "s").stdout.replace("share of games", ""), "only where it is asked for")
        self.cxlab("bench", "plot", "s", "out.svg", "--kind", "shares", "--against", "second")
        drawing = (self.folder / "out.svg").read_text()
        self.assertEqual(drawing.count('class="game"'), 3)
        self.assertIn("share of the points of second in the same game", drawing)

    def test_parts_are_points_by_kind(self):
        columns = COLUMNS.replace("late_s", "points_delivery,points_ring")
        self.write("s/rows.csv", columns + "game,first,,1,completed,0,30,20,10,h\ngame,first,,2,completed,0,10,10,0,h\n")
        (first,) = json.loads(self.cxlab("bench", "show", "s", "--table", "parts", "--json").stdout)["parts"]
        self.assertEqual((first["mean"], first["points_delivery"], first["points_ring"]), (20, 15, 5))
        self.assertNotIn("points_ring", self.cxlab("bench", "show", "s").stdout, "only where it is asked for")

    def test_a_strategy_without_a_completed_game_has_no_shares(self):
        lines = [f"game,first,,{seed},completed,0,{points},1,h\n" for seed, points in ((1, 100), (2, 200))]
        self.write("s/rows.csv", COLUMNS + "".join([*lines, "game,second,,1,failed,4,,,\n"]))
        rows = json.loads(self.cxlab("bench", "show", "s", "--table", "profile", "--json").stdout)["profile"]
        shares = {row["strategy"]: [value for column, value in row.items() if column.startswith("at_least_")] for row in rows}
        self.assertEqual((shares["first"][0], shares["first"][-1]), (1, 0.5))
        self.assertEqual(set(shares["second"]), {None})
        self.assertRegex(self.cxlab("bench", "show", "s", "--table", "profile").stdout, r"\nsecond( +-)+\n")

    def test_a_plot_shows_games_means_and_intervals(self):
        rows = [(name, seed, points) for name, mean in (("first", 600), ("<b> & c", 500)) for seed, points in enumerate(self.points(mean, mean))]
        self.sweep("s", rows)
        self.cxlab("bench", "plot", "s", "out.svg")
        svg = xml.etree.ElementTree.parse(self.folder / "out.svg").getroot()
        tag = "{http://www.w3.org/2000/svg}"
        circles = svg.findall(f"{tag}circle")
        self.assertEqual(len(circles), 62)
        texts = {text.text: text for text in svg.findall(f"{tag}text")}
        ticks = sorted((float(text), float(one.get("x"))) for text, one in texts.items() if one.get("class") == "axis")
        (low, left), (high, right) = ticks[0], ticks[-1]
        place = lambda points: left + (right - left) * (points - low) / (high - low)
        for name, y, below in (("first", "34", "40"), ("<b> & c", "54", "60")):
            points = [p for of, _, p in rows if of == name]
            (mean,) = [c for c in circles if c.get("cy") == y and c.get("r") == "4.5"]
            self.assertAlmostEqual(float(mean.get("cx")), place(sum(points) / 30), delta=0.2)
            drawn = sorted(float(c.get("cx")) for c in circles if c.get("cy") == below and c.get("r") == "2.5")
            self.assertEqual(len(drawn), 30)
            self.assertTrue(all(abs(d - place(p)) < 0.2 for d, p in zip(drawn, sorted(points))))
            (interval,) = [line for line in svg.findall(f"{tag}line") if line.get("y1") == y]
            self.assertTrue(float(interval.get("x1")) < float(mean.get("cx")) < float(interval.get("x2")))
            self.assertIn(name, texts)

    def test_requirements_end_a_sweep_that_is_answered(self):
        self.write("s.yaml", "schema: 1\nduration_s: 2\n")
        self.write("suite.yaml", SUITE + "require: ['long: not worse than short in sim_time_s', 'short: not worse than long in sim_time_s']\n")
        answer = json.loads(self.cxlab("bench", "suite.yaml", "--out", "o", "--quiet", "--json", code=1).stdout)
        self.assertEqual([(line["strategy"], line["answer"], line["after"]) for line in answer["requirements"]], [("long", "better", 12), ("short", "worse", 12)])
        self.write("alike.yaml", SUITE + "require: ['long: mean(sim_time_s) >= 1.5', 'long: not worse than same in sim_time_s by 0.1']\n")
        alike = json.loads(self.cxlab("bench", "alike.yaml", "--out", "alike", "--quiet", "--json").stdout)
        self.assertEqual([(line["answer"], line["after"]) for line in alike["requirements"]], [("better", 20), ("better", 20)], "not early while all games are alike")
        self.assertEqual((answer["games"], answer["planned"]), (12, 20))
        self.assertEqual(len((self.folder / "o/rows.csv").read_text().splitlines()), 1 + 3 * 12)
        every = json.loads(self.cxlab("bench", "suite.yaml", "--out", "o", "--quiet", "--json", "--all", code=1).stdout)
        self.assertEqual([line["games"] for line in answer["requirements"] + every["requirements"]], [12, 12, 20, 20])
        for line in answer["requirements"] + every["requirements"]:
            del line["games"]
        self.assertEqual((every["games"], every["requirements"]), (20, answer["requirements"]))
        self.cxlab("bench", "suite.yaml", "--out", "o", "--quiet", code=1)
        self.assertEqual(len((self.folder / "o/rows.csv").read_text().splitlines()), 1 + 3 * 20, "games that are there stay in the tables")
        said = self.cxlab("bench", "suite.yaml", "--out", "p", "--quiet", code=1).stdout
        self.assertIn("Answered after 12 of 20 games; --all plays the others, too.\n", said)
        self.assertRegex(said, r"\ns, short: 'short: not worse than long in sim_time_s' does not hold; the worst games: seed 1 \(-1\.0+\), seed 2 [^\n]*, seed 3 [^,\n]*\n"
                               r"  cxlab run [^\n]*duration_s=1[^\n]*\n")
        self.assertIn("not worse than long in sim_time_s", (self.folder / "p/index.html").read_text())

        self.write("kept.yaml", SUITE.replace("short: [duration_s=1], ", "") + "require: mean(sim_time_s) >= 1.5\n")
        self.cxlab("bench", "kept.yaml", "--out", "kept", "--quiet")
        self.write("equal.yaml", SUITE.replace("short: [duration_s=1], ", "") + "require: not worse than long in sim_time_s\n")
        self.cxlab("bench", "equal.yaml", "--out", "kept", "--quiet", code=6)
        self.write("few.yaml", SUITE.replace("1..20", "1..5") + "require: [mean(sim_time_s) >= 1.5, mean(sim_time_s) >= 1.6]\n")
        few = "s, long: found 5 games, expected at least 10 to answer anything; add seeds to the suite"
        self.assertEqual(self.cxlab("bench", "few.yaml", "--out", "few", "--quiet", code=6).stdout.count(few + "\n"), 1)
        self.assertEqual((self.folder / "few/index.html").read_text().count(few), 1)
        self.write("margin.yaml", SUITE.replace("short: [duration_s=1], ", "") + "require: not worse than long in sim_time_s by 0.1\n")
        self.cxlab("bench", "margin.yaml", "--out", "kept", "--quiet")
        self.write("before.yaml", SUITE.replace("same: []", "same: [duration_s=1]") + "earlier: {main: kept}\nrequire: not worse than main in sim_time_s\n")
        said = self.cxlab("bench", "before.yaml", "--out", "after", "--quiet", code=3).stderr
        self.assertFalse((self.folder / "after/rows").exists(), "nothing is played")
        self.assertIn("main has no strategy 'short' in s; there are long, same", said)
        self.write("one.yaml", SUITE.replace("same: []", "other: []") + "earlier: {main: kept}\nrequire: 'long: not worse than main in sim_time_s'\n")
        answer = json.loads(self.cxlab("bench", "one.yaml", "--out", "one", "--quiet", "--json", code=6).stdout)
        self.assertEqual([line["strategy"] for line in answer["requirements"]], ["long"], "main need not have the others")
        self.write("worse.yaml", SUITE.replace("{long: [], short: [duration_s=1], same: []}", "{long: [duration_s=1]}") + "earlier: {main: kept}\nrequire: not worse than main in sim_time_s\n")
        said = self.cxlab("bench", "worse.yaml", "--out", "after", "--quiet", code=1).stdout
        self.assertRegex(said, r"\nlong +not worse than main in sim_time_s +worse +12 +-1\.0")
        self.write("other.yaml", SUITE.replace("1..20", "21..40").replace("short: [duration_s=1], ", "") + "earlier: {main: kept}\nrequire: not worse than main in sim_time_s\n")
        said = self.cxlab("bench", "other.yaml", "--out", "other", "--quiet", code=3).stderr
        self.assertIn("main has no game of s that this suite plays", said)
        # Without rows.csv, as after a kill, rows/*.json are read.
        (self.folder / "kept/rows.csv").unlink()
        scores = json.loads(self.cxlab("bench", "show", "kept", "--metric", "sim_time_s", "--json").stdout)["scores"]
        self.assertEqual([(line["strategy"], line["games"], line["mean"]) for line in scores], [("long", 20, 2), ("same", 20, 2)])

    def test_what_cannot_be_used_is_refused_with_what_is_expected(self):
        self.write("s.yaml", "schema: 1\nduration_s: 2\n")
        self.sweep("s", [("a", 1, 600), ("b", 1, 500)])
        self.sweep("t", [("c", 1, 600), ("d", 1, 500)])
        self.sweep("other", [("a", 2, 600), ("b", 2, 500)])
        self.write("twice/rows.csv", COLUMNS + "game,a,,1,completed,0,1,1,h\n" * 2)
        self.write("text.csv", COLUMNS + "game,a,,one,completed,0,1,1,h\n")
        self.write("short.csv", COLUMNS + "game,a\n")
        self.write("abc.csv", COLUMNS + "game,a,,1,completed,0,abc,1,h\n")
        self.write("lines.csv", COLUMNS + '"ga\nme",a,,1,completed,0,1,1,h\n\ngame,a\n')
        self.write("nothing.csv", COLUMNS)
        self.write("crashed.csv", COLUMNS + "game,a,,1,crashed,70,,,\n")
        (self.folder / "empty").mkdir()
        for said, code, *arguments in (
                ("suite is required", 2, "bench"),
                ("nowhere: there is no such sweep", 3, "bench", "show", "nowhere"),
                ("empty: found no rows.csv and no rows/*.json", 3, "bench", "show", "empty"),
                ("twice/rows.csv: found two rows of game, a, seed 1, expected one", 3, "bench", "show", "twice"),
                ("text.csv:2: found 'one' as seed, expected a whole number from 0", 3, "bench", "show", "text.csv"),
                ("short.csv:2: found 2 fields, expected 9", 3, "bench", "show", "short.csv"),
                ("abc.csv:2: found 'abc' as points, expected a number, or nothing where there is none", 3, "bench", "show", "abc.csv"),
                ("no row has the parts of points; expected some of the columns points_delivery, points_ring", 3, "bench", "plot", "s", "out.svg", "--kind", "parts"),
                ("lines.csv:5: found 2 fields, expected 9", 3, "bench", "show", "lines.csv"),
                ("nothing.csv: found no row", 3, "bench", "show", "nothing.csv"),
                ("no row has a figure that could be compared: no game was completed; the column reason", 3, "bench", "show", "crashed.csv"),
                ("no row has a metric 'point'; there are points, late_s; did you mean 'points'?", 3, "bench", "show", "s", "--metric", "point"),
                ("there is no strategy 'c'", 3, "bench", "show", "s", "--against", "c"),
                ("expected --table with one of: scores, differences, profile, overview, parts, shares", 2, "bench", "show", "s", "--format", "csv"),
                ("expected one of", 2, "bench", "show", "s", "--format", "html"),
                ("out.png: the drawing is an SVG, expected a name that ends in .svg", 2, "bench", "plot", "s", "out.png"),
                ("there is no strategy 'c'", 3, "bench", "plot", "s", "out.svg", "--against", "c"),
                ("no row has a figure that could be compared", 3, "bench", "plot", "crashed.csv", "out.svg"),
                ("no scenario, strategy and game in common; game, c is in the new sweep only", 3, "bench", "compare", "s", "t"),
                ("game, a: the sweeps have no game in common", 3, "bench", "compare", "s", "other")):
            self.assertIn(said, self.cxlab(*arguments, code=code).stderr)
        for requirement, said in (
                ("mean(points) > 3", "expected '>=' or '<=' after the mean"),
                ("mean(points) >= many", "expected a number after '>='"),
                ("mean(points) >= nan", "expected a number after '>='"),
                ("mean() >= 3", "expected a metric in the brackets"),
                ("median(points) >= 3", "which is no requirement"),
                ("mean(point) >= 3", "has no metric 'point'"),
                ("not worse than", "which is no requirement"),
                ("not worse than long in point", "has no metric 'point'"),
                ("not worse than lomg", "(a sweep gets a name by 'earlier: {NAME: FOLDER}'); did you mean 'long'?"),
                ("not worse than long by -1", "expected a number of at least 0 after 'by'"),
                ("'sort: mean(sim_time_s) >= 3'", "there is no strategy 'sort'; there are long, short, same; did you mean 'short'?"),
                ("'long: not worse than long'", "no other strategy is compared with 'long'"),
                ("{a: b}", "found a map, expected a text"),
                ("[mean(sim_time_s) >= 3, mean(sim_time_s) >= 3]", "twice, expected it once")):
            self.write("suite.yaml", SUITE + f"require: {requirement}\n")
            done = self.cxlab("bench", "suite.yaml", "--out", "o", code=3)
            self.assertIn(said, done.stderr)
            self.assertIn("suite.yaml:4: ", done.stderr)
            self.assertFalse((self.folder / "o/rows").exists(), "nothing is played")
        self.write("suite.yaml", SUITE.replace("{long: [], short: [duration_s=1], same: []}", "{long: []}") + "require: not worse than long\n")
        self.assertIn("no other strategy is compared with 'long'", self.cxlab("bench", "suite.yaml", "--out", "o", code=3).stderr)
        self.write("suite.yaml", SUITE + "earlier: {main: nowhere}\nrequire: not worse than main\n")
        self.assertIn("suite.yaml:4: earlier: 'main': nowhere: there is no such sweep", self.cxlab("bench", "suite.yaml", "--out", "o", code=3).stderr)
        self.write("turtle.yaml", "schema: 1\nduration_s: 1\nworld: {kind: turtlesim}\n")
        self.write("suite.yaml", "scenarios: [rcll/game, turtle.yaml]\nseeds: [1]\nstrategies: {long: []}\nrequire: mean(point) >= 3\n")
        said = self.cxlab("bench", "suite.yaml", "--out", "o", code=3).stderr
        self.assertRegex(said, r"suite.yaml:4: 'mean\(point\) >= 3': the world of game has no metric 'point'; game has points, .*; turtle has .*walls.*; did you mean 'points'\?$")
        self.write("suite.yaml", "scenarios: [rcll/game, turtle.yaml]\nseeds: [1]\nstrategies: {long: []}\nrequire: mean(points) >= 3\n")
        said = self.cxlab("bench", "suite.yaml", "--out", "o", code=3).stderr
        self.assertRegex(said, r"the world of turtle has no metric 'points'; game has points, .*; turtle has .*walls.*; scenarios of different worlds need suites of their own for it$")
        self.write("suite.yaml", "scenarios: [turtle.yaml]\nseeds: [1]\ntier: timed\nstrategies: {long: []}\n")
        self.assertIn("suite.yaml:3: strategy 'long': tier=timed: ", self.cxlab("bench", "suite.yaml", "--out", "o", code=3).stderr)
        self.write("suite.yaml", SUITE + "earlier: {long: s}\nrequire: not worse than long\n")
        self.assertIn("'long' is the name of a strategy, too", self.cxlab("bench", "suite.yaml", "--out", "o", code=3).stderr)


if __name__ == "__main__":
    unittest.main()
