"""Runs the examples that come with CLIPS: CLIPS=program EXAMPLES=folder python3 -m unittest examples"""

import os
import re
import subprocess
import unittest

CLIPS = os.environ["CLIPS"]
EXAMPLES = os.environ["EXAMPLES"]


ATAN2 = """[DFFNXPSR2] waltz.clp, Line 70: Deffunctions are not allowed to replace external functions.

ERROR:
(deffunction MAIN::atan2
   (
"""


def run(folder, *commands, complaint=""):
    """Gives what CLIPS prints for the commands in a folder of the examples; it must end with their end."""
    done = subprocess.run([CLIPS], cwd=os.path.join(EXAMPLES, folder), input="\n".join(commands) + "\n",
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (0, complaint), f"status {done.returncode}: {done.stderr!r}"
    return done.stdout


def load_and_run(folder, *files, answers=()):
    return run(folder, *[f'(load "{file}")' for file in files], "(watch statistics)", "(reset)", "(run)", *answers)


def firings(output):
    return int(re.search(r"(\d+) rules fired", output)[1])


class Benchmarks(unittest.TestCase):
    def test_manners_seats_its_guests_with_the_known_number_of_firings(self):
        for guests, expected in {8: 59, 16: 183, 32: 623, 64: 2271, 128: 8639}.items():
            with self.subTest(guests=guests):
                self.assertEqual(firings(run("manners", f'(batch "manners{guests}.bat")')), expected)

    def test_waltz_labels_its_drawings_with_the_known_number_of_firings(self):
        for regions, expected in {12: 3576, 25: 7164, 37: 10476, 50: 14064}.items():
            with self.subTest(regions=regions):
                # It defines atan2, which CLIPS now has itself.
                output = run("waltz", f'(batch "waltz{regions}.bat")', complaint=ATAN2)
                self.assertEqual(firings(output), expected)

    def test_river_is_crossed_in_two_ways(self):
        output = load_and_run("benchmarks", "river.clp")
        self.assertEqual(firings(output), 18515)  # as the file says
        self.assertEqual(output.count("Solution found"), 2)


class Puzzles(unittest.TestCase):
    def test_zebra_belongs_to_the_japanese(self):
        self.assertRegex(load_and_run("", "zebra.clp"), r"japanese +\| green +\| zebra")

    def test_farmer_has_two_ways_over_the_river(self):
        for file in ("dilemma1.clp", "dilemma2.clp", "dilemma3.clp"):
            with self.subTest(file=file):
                self.assertEqual(load_and_run("", file).count("Solution found"), 2)

    def test_monkey_eats_the_bananas(self):
        self.assertIn("Monkey eats the bananas.", load_and_run("", "mab.clp"))

    def test_gerald_and_donald_make_robert(self):
        output = load_and_run("", "wordgame.clp")
        gerald, donald, robert = map(int, re.search(r"(\d{6})\n \+ (\d{6})\n +-+\n = (\d{6})", output).groups())
        self.assertEqual(gerald + donald, robert)

    def test_sudoku_is_solved(self):
        output = load_and_run("sudoku", "sudoku.clp", "solve.clp", "output-simple.clp", "puzzles//grid3x3-p17.clp")
        solution = output[output.index("solution"):]
        cells = {(int(r), int(c)): int(v) for r, c, v in re.findall(r"row: (\d) column: (\d) value: (\d)", solution)}
        self.assertEqual(len(cells), 81)
        places = {key: set() for key in [(kind, i) for kind in ("row", "column", "box") for i in range(1, 10)]}
        for (row, column), value in cells.items():
            places["row", row].add(value)
            places["column", column].add(value)
            places["box", 1 + (row - 1) // 3 * 3 + (column - 1) // 3].add(value)
        self.assertTrue(all(values == set(range(1, 10)) for values in places.values()), places)

    def test_circuits_are_tabulated(self):
        output = load_and_run("circuit", "electrnc.clp", "circuit1.clp")
        self.assertRegex(output, r"\* +1 +\| +1 +0 *\n +\* +0 +\| +1 +1")


class ExpertSystems(unittest.TestCase):
    """Spare answers are harmless: they reach the command line, which shows them."""

    def test_animal_is_found_by_answers(self):
        self.assertIn("I think your animal is a bat.", load_and_run("", "animal.clp", answers=["yes"] * 9))

    def test_car_gets_a_repair(self):
        output = load_and_run("", "auto.clp", answers=["no"] * 9)
        self.assertRegex(output, r"Suggested Repair:\s+Charge the battery\.")

    def test_framingham_gives_a_risk(self):
        answers = ["55", "male", "no", "no", "120", "200", "50"]
        self.assertRegex(load_and_run("", "framingham.clp", answers=answers), r"cardiovascular risk is \d+%")

    def test_wines_are_chosen(self):
        output = load_and_run("", "wine.clp", answers=["unknown"] * 9)
        self.assertRegex(output, r"SELECTED WINES[\s\S]+Chardonnay +59%")


if __name__ == "__main__":
    unittest.main()
