"""The commands of the README and of the page for contributors, as tests/app/tutorials.py plays those of the tutorials."""

import unittest

from tutorials import Pages


class FrontPages(Pages):
    def test_readme(self):
        self.play("../README.md", "/tmp/lab")

    def test_first_change(self):
        self.play("internals/first-change.md", "/tmp/change")


if __name__ == "__main__":
    unittest.main()
