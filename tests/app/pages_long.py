"""The blocks of pages that install, build or play for minutes (tests/support/played_pages.py)."""

import unittest

from played_pages import Pages


class Long(Pages, by="app_pages_long"):
    pass


if __name__ == "__main__":
    unittest.main()
