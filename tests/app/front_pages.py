"""The blocks of the README, and of the pages that explain and that are for builders (tests/support/played_pages.py)."""

import unittest

from played_pages import Pages


class Readme(Pages, folder="README.md"):
    pass


class Benchmarks(Pages, folder="benchmarks"):
    pass


class Explanation(Pages, folder="explanation"):
    pass


class Internals(Pages, folder="internals"):
    pass


if __name__ == "__main__":
    unittest.main()
