#!/usr/bin/env python3
"""Exceptions of the tests of the documentation that still exist, each with its present size, which may only shrink.

  tests/docs/ceilings.py shrink     lowers each number of ceilings.txt to the present one, and removes what has reached its goal
  tests/docs/ceilings.py begin      writes the file again: only for a new rule, because a test passes then whatever is found
"""

import sys
from pathlib import Path

FILE = Path(__file__).with_name("ceilings.txt")


class Ceilings:
    """The exceptions of one kind: lines `kind file number`."""

    def __init__(self, kind):
        rows = [line.split() for line in FILE.read_text().splitlines() if line and not line.startswith("#")]
        self.numbers = {file: int(number) for row_kind, file, number in rows if row_kind == kind}

    def of(self, file):
        return self.numbers.get(file, 0)

    def all(self):
        return sorted(self.numbers)


def present():
    """(kind, file) -> number of what is found now."""
    import links
    import prose
    found = {}
    for page in links.pages():
        words, _, long = links.measure((links.SOURCE / page).read_text())
        if links.kind_of(page) != "reference" and words > links.MOST_WORDS:
            found["words", page] = words
        if long:
            found["sentences", page] = len(long)
    for file, findings in prose.findings_of_all().items():
        if findings:
            found["prose", file] = len(findings)
    return found


def main():
    if sys.argv[1:] not in (["shrink"], ["begin"]):
        sys.exit(__doc__)
    found = present()
    if sys.argv[1] == "shrink":
        before = {(kind, file): number for kind in ("words", "sentences", "prose") for file, number in Ceilings(kind).numbers.items()}
        found = {key: min(number, found[key]) for key, number in before.items() if key in found}
    head = "# Made by tests/docs/ceilings.py: words above 1,500, sentences above 30 words, findings of tests/docs/prose.py.\n"
    FILE.write_text(head + "".join(f"{kind} {file} {number}\n" for (kind, file), number in sorted(found.items())))


if __name__ == "__main__":
    main()
