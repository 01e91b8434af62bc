"""The blocks of pages that need packages of Python or other programs (tests/support/played_pages.py). ./dev readers -R pages"""

import unittest

from played_pages import Pages


class WithReaders(Pages, by="readers_pages"):
    pass


if __name__ == "__main__":
    unittest.main()
