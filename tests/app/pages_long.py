"""The blocks of pages that install, build or play for minutes (tests/support/played_pages.py)."""

import unittest

from played_pages import SOURCE, Pages


class Long(Pages, by="app_pages_long"):
    def test_tutorials_compare_two_strategies(self):
        folder = self.play("docs/tutorials/compare-two-strategies.md")
        self.assertEqual((folder / "compare/strategies.svg").read_text(), (SOURCE / "docs/pictures/strategies.svg").read_text(), "the picture is old")


if __name__ == "__main__":
    unittest.main()
