"""The commands of the how-to guides, as tests/app/tutorials.py plays those of the tutorials."""

import re
import unittest
from pathlib import Path

from tutorials import SOURCE, Pages, steps


class Guides(Pages):
    def test_debug_by_symptom(self):
        self.play("how-to/debug-by-symptom.md", "/tmp/debug")

    def test_write_a_rule(self):
        self.play("how-to/write-a-rule.md", "/tmp/rule")

    def test_test_rules(self):
        self.play("how-to/test-rules.md", "/tmp/door")

    def test_test_in_ci(self):
        self.play("how-to/test-in-ci.md", "/tmp/ci")

    def test_write_a_strategy(self):
        self.play("how-to/write-a-strategy.md", "/tmp/plans")

    def test_use_game_files(self):
        self.play("how-to/use-game-files.md", "/tmp/games")

    def test_try_what_if(self):
        self.play("how-to/try-what-if.md", "/tmp/whatif")

    def test_attach(self):
        self.play("how-to/attach.md", "/tmp/attach")

    def test_export_a_run(self):
        self.play("how-to/export-a-run.md", "/tmp/export")

    def test_make_a_film(self):
        self.play("how-to/make-a-film.md", "/tmp/film")

    def test_profile_rules(self):
        self.play("how-to/profile-rules.md", "/tmp/profile")

    def test_run_a_sweep_on_slurm_or_ray(self):
        self.play("how-to/run-a-sweep-on-slurm-or-ray.md", "/tmp/cells")

    def test_move_to_ros2(self):
        self.play("how-to/move-to-ros2.md", "/tmp/ros")

    def test_measure_stories(self):
        self.play("how-to/measure-stories.md", "/tmp/none")

    def test_no_page_is_left_out(self):
        folders = [SOURCE / "docs" / name for name in ("tutorials", "how-to", "reference", "explanation", "internals")]
        shown = {str(page.relative_to(SOURCE / "docs")) for folder in folders for page in folder.rglob("*.md") if any(steps(page))}
        text = "".join(file.read_text() for file in Path(__file__).parent.glob("*.py"))
        self.assertEqual(set(re.findall(r'self\.play\("([^"]+\.md)"', text)), shown | {"../README.md"})


if __name__ == "__main__":
    unittest.main()
