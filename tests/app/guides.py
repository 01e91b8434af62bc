"""The blocks of the how-to guides (tests/support/played_pages.py)."""

import unittest

from played_pages import Pages


class Guides(Pages, folder="how-to"):
    pass


if __name__ == "__main__":
    unittest.main()
