"""The blocks and commands on the pages: their options exist, and each block is played, or says why it cannot be.

  tests/docs/commands.py      counts the blocks by how they are played, and lists those that are not

tests/support/played_pages.py plays them, and describes the comments above a block.
"""

import re
import shlex
import unittest
from collections import Counter
from functools import lru_cache

from markdown_pages import FENCE, SOURCE, blank_code
from played_pages import ABOVE, Pages, blocks_of, blocks_on, pages

PROGRAMS = r"(?:cxlab|\./dev|\.ci/\w+|(?:tests|benchmarks)/[\w/]+\.(?:py|sh)|cmake|ctest|cpack|python3?|pip|ros2|colcon|docker|curl|git|tar|apt-get|apt|source|sh|cd|for|cat|export|alias|sqlite3|datasette|duckdb)"


@lru_cache
def declared():
    """Command -> its options, from the page that the program writes."""
    page = (SOURCE / "docs/reference/commands.md").read_text()
    found = {}
    for section in re.split(r"^## ", page, flags=re.MULTILINE)[1:]:
        name, _, body = section.partition("\n")
        if name.startswith("cxlab "):
            found[name.removeprefix("cxlab ")] = {option for cell in re.findall(r"^\| `(-[^`]*)` \|", body, re.MULTILINE) for option in cell.split(", ")}
    return found


def problem_of(command):
    """The fault of the name or an option of `cxlab ...`, or ""."""
    try:
        words = shlex.split(command, comments=True)[1:]
    except ValueError:
        words = command.split()[1:]
    if not words or words[0].startswith("-") or not re.fullmatch(r"[a-z][a-z-]*", words[0]):
        return ""
    name = " ".join(words[:2]) if " ".join(words[:2]) in declared() else words[0]
    if name not in declared() and not any(known.startswith(name + " ") for known in declared()):
        return f"there is no command '{name}'"
    options = {"-h", "--help"} | declared().get(name, set()) | {option for known in declared() if known.startswith(name + " ") for option in declared()[known]}
    for word in words[1:]:
        if word in ("--", "|", "&&", ";", ">", "||"):
            break
        option = re.match(r"--?[A-Za-z][\w-]*", word.lstrip("["))
        if option and option[0] not in options and not re.fullmatch(r"-[a-z]\d+", option[0]):
            return f"'{name}' has no option '{option[0]}'"
    return ""


def spoken(text):
    """All commands of cxlab on a page, also those within a sentence."""
    for block in blocks_of(text):
        for step in block.steps:
            for line in step.command.splitlines()[:1]:
                yield from re.findall(r"(?:^|[|;&] )(cxlab [^|;&]*)", line)
    for found in re.finditer(r"`(cxlab [a-z][^`]*)`", blank_code(text)):
        yield " ".join(found.group(1).split())


def without_prompt(text):
    """The lines of blocks that begin with a command and have no `$ ` before it, so that nothing plays them."""
    for fence in FENCE.finditer(text):
        body, language = fence.group(4), fence.group(3).strip()
        if language in ("bash", "sh", "console", "shell") or (not language and not re.search(r"^\$ ", body, re.MULTILINE)):
            command = re.search(rf"^\s*(?:\$ )?{PROGRAMS} .*", body, re.MULTILINE)
            if command:
                yield text.count("\n", 0, fence.start(4) + command.start()) + 1, command.group(0).strip()


def counted():
    """Number of blocks by how they are played, and what plays them."""
    return Counter((block.how(), "" if block.why_not else block.by or "the short tests") for page in pages() for block in blocks_on(page))


class Commands(unittest.TestCase):
    def test_names_and_options_exist(self):
        count = 0
        for page in pages():
            if page == "docs/reference/commands.md":
                continue
            for command in spoken((SOURCE / page).read_text()):
                count += 1
                with self.subTest(f"{page}: {command}"):
                    self.assertEqual(problem_of(command), "")
        self.assertGreater(count, 300, "the pages are read")

    def test_wrong_ones_are_found(self):
        for command in ("cxlab rnu a", "cxlab run a.yaml --sed 7", "cxlab bench show --tire x"):
            self.assertTrue(problem_of(command), command)
        for command in ("cxlab run a.yaml --seed 7 -v", "cxlab bench compare A B --json", "cxlab --help", "cxlab why-not RUN RULE [--at T]"):
            self.assertEqual(problem_of(command), "", command)

    def test_blocks_are_read(self):
        text = ("```\n$ cxlab run a \\\n  --seed 1\nseed 1\n$ cat <<END\n$x\nEND\n```\n\n<!-- first: mkdir b -->\n<!-- with 5 instead of 600 -->\n<!-- played by app_x -->\n"
                "```python\nf(600)\n```\n\n```\n600\n```\n\n<!-- not played: ROS -->\n```\n$ ros2\n```\n")
        one, two, three = blocks_of(text)
        self.assertEqual([(step.command, step.shown) for step in one.steps], [("cxlab run a --seed 1", ["seed 1"]), ("cat <<END\n$x\nEND\n", [])])
        self.assertEqual((two.first, two.instead, two.by, two.steps[0].shown, two.how()), (["mkdir b"], {"600": "5"}, "app_x", ["600"], "compared"))
        self.assertEqual((three.line, three.why_not, three.how()), (22, "ROS", "not played"))
        self.assertEqual(list(without_prompt("```\ncxlab run a\n```\n```sh\n$ cmake .\n```\n```\n$ cxlab b\ncxlab c\n```\n```yaml\ncat a\n```\n")),
                         [(2, "cxlab run a"), (5, "$ cmake .")])

    def test_each_block_can_be_played(self):
        for page in pages():
            for line, command in without_prompt((SOURCE / page).read_text()):
                with self.subTest(f"{page}:{line}: {command}"):
                    self.fail("no test plays it: write ``` above the block and `$ ` before the command, then what it prints (tests/support/played_pages.py)")

    def test_each_comment_above_a_block_is_understood(self):
        for page in pages():
            text = (SOURCE / page).read_text()
            for mark in re.finditer(r"<!-- *(?:first|with|not played|played)\b.*", text):
                with self.subTest(f"{page}:{text.count(chr(10), 0, mark.start()) + 1}: {mark.group(0)}"):
                    self.assertTrue(ABOVE.fullmatch(mark.group(0)) and re.match(r".*\n(?: *<!--.*-->\n)*```", text[mark.start():]),
                                    "write first:, with B instead of A, played by TEST, or not played: WHY, directly above the block")

    def test_a_test_plays_each_block(self):
        tests = "".join(file.read_text() for file in (SOURCE / "tests").glob("*/*.py"))
        folders, names = (set(re.findall(rf'\(Pages.*{key}="([^"]+)"', tests)) for key in ("folder", "by"))
        for page in pages():
            for block in blocks_on(page):
                with self.subTest(f"{page}:{block.line}"):
                    if block.by:
                        self.assertIn(block.by, names, "no test of that name plays pages")
                    elif not block.why_not:
                        self.assertTrue(page in folders or page.split("/")[-2 if page.count("/") == 1 else 1] in folders, "no test plays the pages of this folder")
        print("blocks of pages:", ", ".join(f"{number} {how}" + (f" ({by})" if by else "") for (how, by), number in sorted(counted().items())))


class Playing(Pages, folder="none of them"):
    """Blocks are played as a reader plays them, and a page that shows something else fails."""

    def setUp(self):
        self.prepare()

    def step(self, text, above=""):
        block, = blocks_of(f"{above}```\n{text}```\n")
        for step in block.steps:
            self.play_step(step, block)

    def test_what_a_page_shows_is_all_that_is_printed(self):
        for shown in ("one  two\nthree\n", "one...\nthree\n", "...\n", "one two three\n"):
            self.step(f"$ printf 'one two\\nthree\\n'\n{shown}")
        for shown in ("", "one two\n", "three\n", "one two\nfour\n", "one two\nthree\nfour\n"):
            with self.assertRaises(AssertionError, msg=shown):
                self.step(f"$ printf 'one two\\nthree\\n'\n{shown}")
        with self.assertRaises(AssertionError):
            self.step("$ echo one; false\none\n")

    def test_folder_and_variables_last(self):
        self.step("$ mkdir -p /tmp/a && cd /tmp/a\n$ export B=5\n$ touch c\n")
        self.step("$ ls && echo $B && pwd\nc\n5\n/tmp/a\n")

    def test_a_person_enters_lines_and_ends_programs(self):
        asks = "$ printf 'ask\ncxlab> '; while read line; do echo 2 $line; printf 'cxlab> '; done\n".replace("\n", "\\n", 1)
        self.step(asks + "ask\ncxlab> a\n2 a\ncxlab> b\n2 b\n")
        self.patience_s = 1
        with self.assertRaises(AssertionError):
            self.step(asks + "ask\ncxlab> a\n2 b\n")
        begins = """python3 -c 'import time; print("begun", flush=True); time.sleep(60)'"""  # a shell may miss a Ctrl-C before it waits
        self.step(f"$ {begins}\nbegun\n^C\n")
        with self.assertRaises(AssertionError):
            self.step("$ echo other\nbegun\n^C\n")
        self.step(f"$ {begins} &\nbegun\n$ echo on\non\n")

    def test_another_text_stands_in(self):
        self.step("$ echo 600\nit is 600\n".replace("echo 600", "echo it is 600"), "<!-- with 5 instead of 600 -->\n")
        with self.assertRaises(AssertionError):
            self.step("$ echo 700\n700\n", "<!-- with 5 instead of 600 -->\n")


def main():
    for (how, by), number in sorted(counted().items()):
        print(f"{number:4} {how:12} {by}")
    for page in pages():
        for block in blocks_on(page):
            if block.why_not:
                print(f"{page}:{block.line}: {block.why_not}")


if __name__ == "__main__":
    main()
