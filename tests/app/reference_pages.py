"""The blocks of the reference (tests/support/played_pages.py)."""

import unittest

from played_pages import Pages


class Reference(Pages, folder="reference"):
    pass


if __name__ == "__main__":
    unittest.main()
