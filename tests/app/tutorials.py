"""The blocks of the tutorials, played one after the other (tests/support/played_pages.py)."""

import unittest
from importlib.util import find_spec

from played_pages import Pages


class Tutorials(Pages, folder="tutorials"):
    @unittest.skipUnless(find_spec("cxlab") and find_spec("numpy"), "needs the package of Python, and NumPy")
    def test_train_a_policy(self):
        self.play("docs/tutorials/train-a-policy.md")


if __name__ == "__main__":
    unittest.main()
