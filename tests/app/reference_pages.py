"""The commands of pages of the reference that show what they print, as tests/app/tutorials.py plays those of the tutorials."""

import unittest

from tutorials import Pages


class Reference(Pages):
    def test_questions(self):
        self.play("reference/questions.md", "runs")

    def test_check(self):
        self.play("reference/check.md", "/tmp/check")

    def test_errors(self):
        self.play("reference/errors.md", "/tmp/errors")

    def test_pddl(self):
        self.play("reference/pddl.md", "/tmp/pddl")

    def test_planner(self):
        self.play("reference/planner.md", "/tmp/planner")

    def test_validate(self):
        self.play("reference/validate.md", "/tmp/validate")

    def test_pddl_manager(self):
        self.play("reference/pddl-manager.md", "/tmp/none")

    def test_planning_agent(self):
        self.play("reference/planning-agent.md", "/tmp/plans")


if __name__ == "__main__":
    unittest.main()
