"""The commands on the pages: their options exist, and a test plays them or a mark says why not. python3 -m unittest commands

tests/app/tutorials.py, guides.py, reference_pages.py and front_pages.py play blocks whose lines begin with `$` and compare what they print, and tests/app/examples.py plays the runs of shipped files.
This test plays the other lines that begin with `cxlab`, in a folder with a game, a small sweep, and the files of docs/examples/planning; it
fills in placeholders such as RUN. A comment above a block,
`<!-- not played: WHY -->`, excepts it; `<!-- played in part: WHY -->` excepts the commands that the test cannot play.
"""

import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import unittest
from functools import lru_cache
from pathlib import Path

from markdown_pages import FENCE, SOURCE, blank_code, markdown_files, words_of

CXLAB = os.environ.get("CXLAB", "")
PROGRAMS = r"(?:cxlab|\./dev|\.ci/\w+|(?:tests|benchmarks)/[\w/]+\.(?:py|sh)|cmake|ctest|python3?|pip|ros2|colcon|docker|curl|git|tar|apt-get|apt|source|sh|cd|for|cat|export|alias|sqlite3|datasette|duckdb)"
MARK = re.compile(r"<!-- (not played|played in part): \S.* -->\s*\Z")
# They wait for a person, a server or another program, or take minutes.
WAITS = {"view", "mutate", "completion"}
# What the test puts in the place of a placeholder.
PUT_IN = [(r"RUN RUN\b", "runs/before runs/after"), (r"\bRUN\b", "runs/game-1"), (r" \[(?:WHAT|RULE)\]", ""), (r"FACT\|PATTERN\|RULE|\bRULE\b", "order-begin"),
          (r"FACT\|PATTERN", "'(order)'"), (r"--at T\b", "--at 5:12"), (r"\bF\.png\b", "picture.png")]
SUITE = """scenarios: [scenarios/rcll/game.yaml]
tier: timed
seeds: "1..5"
strategies: {three: ["world.production_s=60"], greedy: ["world.production_s=60", "world.robots=2"]}
"""
STORIES = re.compile(r"cxlab test (?:scenarios|docs)/[\w/.-]+$")  # the test `stories` plays them
PLACEHOLDER = re.compile(r"(?:^|[\s'\"/=])[A-Z][A-Z_]+(?:$|[\s.'\"/=])|\[[A-Z-]|\.\.\.|<|\||\$|>|&|~")


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


def blocks(text):
    """(line, commands, mark or "") of each block with commands. `$ ` before a command stays."""
    for fence in FENCE.finditer(text):
        body = re.sub(r"\\\n\s*", "", fence.group(4))
        body = re.sub(r" <<'?END'?\n.*?^\s*END$", "", body, flags=re.DOTALL | re.MULTILINE)
        commands = [line.strip() for line in body.splitlines() if re.match(rf"\s*(?:\$ |{PROGRAMS} )", line)]
        played = [line for line in commands if line.startswith("$ ")]
        commands = played or commands  # what follows a command with `$` is what it prints
        if commands and fence.group(3).strip() in ("", "bash", "sh", "console", "text") and not fence.group(3).strip() == "text":
            yield text.count("\n", 0, fence.start()) + 1, commands, (MARK.search(text[:fence.start()]) or [""] * 2)[1]


def spoken(text):
    """All commands of cxlab on a page, also those within a sentence."""
    for _, commands, _ in blocks(text):
        yield from (bare(command) for command in commands if bare(command).startswith("cxlab "))
    for found in re.finditer(r"`(cxlab [a-z][^`]*)`", blank_code(text)):
        yield " ".join(found.group(1).split())


def pages():
    return [name for name in markdown_files() if name == "README.md" or name == "CONTRIBUTING.md" or
            (name.startswith("docs/") and not name.startswith(("docs/templates/", "docs/examples/")) and name != "docs/reference/commands.md")]


@lru_cache
def played_elsewhere():
    """The pages whose blocks with `$` tests of tests/app play, and the commands that tests/app/examples.py plays."""
    text = "".join(file.read_text() for file in (SOURCE / "tests/app").glob("*.py"))
    tutorials = {os.path.normpath(f"docs/{page}") for page in re.findall(r'self\.play\("([^"]+\.md)"', text)}
    sys.path.insert(0, str(SOURCE / "tests/app"))
    import examples
    return tutorials, {command for command in examples.on_pages() if not re.search("--snapshot|--set|game.yaml$", command)}


def bare(command):
    """A command without its comment and its way to be written."""
    command = re.sub(r"\s+#\s.*$", "", command.removeprefix("$ "))
    return re.sub(r"^\./dev run(?= |$)", "cxlab run", re.sub(r"^\./dev cxlab ", "cxlab ", command)).strip()


def filled(command):
    for placeholder, text in PUT_IN:
        command = re.sub(placeholder, text, command)
    return command


def can_be_played(command):
    if re.match(r"cxlab attach (?!.* -c )|cxlab bench (?!suite\.yaml|show|plot|page|compare)|.* --(?:video|physics) ?|.*--collect ", command):
        return False
    words = command.split()
    return command.startswith("cxlab ") and len(words) > 1 and words[1] not in WAITS and words[1] in {name.split()[0] for name in declared()} and \
        not PLACEHOLDER.search(command) and not re.search(r"--(?:break|control|realtime|sockets|bag|slurm|watch|trust-programs|with pddl_manager --param)\b", command)


def is_there(command, folder):
    """Whether the folder has all that the command reads; shipped scenarios have names such as rcll/game."""
    reads = [word for word in shlex.split(command)[2:] if re.search(r"\.(?:yaml|pddl|plan|clp|mcap)$|^runs/|/", word) and "=" not in word and not word.startswith(("(", "'"))]
    writes = re.search(r"(?:--out|-o|--svg|--html|--trace|--junit|--lcov|--coverage|--coverage-page|--video|--graph) (\S+)", command)
    reads = [word for word in reads if not writes or word != writes.group(1)]
    if words_of(command)[1:2] == ["new"]:
        return all((folder / word).exists() for word in reads if word.startswith("runs/"))
    return bool(reads) and all((folder / word).exists() or re.fullmatch(r"(?:rcll|turtlesim)/\w+", word) for word in reads)


def left_over(page):
    """(line, command, mark) of what no other test plays, without blocks that are not to be played."""
    tutorials, examples_played = played_elsewhere()
    rest = []
    for line, commands, mark in blocks((SOURCE / page).read_text()):
        for command in commands:
            done = mark == "not played" or (command.startswith("$ ") and page in tutorials)
            if not done:
                try:
                    done = shlex.join(shlex.split(bare(command))) in examples_played or bool(STORIES.match(bare(command)))
                except ValueError:
                    pass
            if not done:
                rest.append((line, bare(command), mark))
    return rest


class Commands(unittest.TestCase):
    def test_names_and_options_exist(self):
        count = 0
        for page in [*pages(), "benchmarks/README.md"]:
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
        text = "```\ncxlab run a \\\n  --seed 1   # c\nno\n```\n\n<!-- not played: why -->\n```\n$ cxlab why\ncxlab says\n```\n"
        self.assertEqual(list(blocks(text)), [(1, ["cxlab run a --seed 1   # c"], ""), (8, ["$ cxlab why"], "not played")])
        self.assertEqual(bare("./dev cxlab why a   # b"), "cxlab why a")

    def test_each_is_played_or_marked(self):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            for shipped in ("docs", "scenarios", "benchmarks"):
                (folder / shipped).symlink_to(SOURCE / shipped)
            for file in (SOURCE / "docs/examples/planning").iterdir():
                shutil.copy(file, folder)
            (folder / "suite.yaml").write_text(SUITE)
            call = lambda *words: subprocess.run([CXLAB, *words], cwd=folder, text=True, timeout=120, stdin=subprocess.DEVNULL,
                                                 stdout=subprocess.PIPE, stderr=subprocess.PIPE)
            for command in ("run rcll/game --tier timed --quiet --out made/game-1", "run rcll/game --tier timed --quiet --seed 2 --out made/before",
                            "bench suite.yaml --quiet --out made/strategies"):
                made = call(*command.split())
                self.assertEqual(made.returncode, 0, made.stderr)
            played = 0
            for page in pages():
                rest = [(line, filled(command), mark) for line, command, mark in left_over(page)]
                if any(can_be_played(command) for _, command, _ in rest):  # copies take longer than the commands
                    shutil.rmtree(folder / "runs", ignore_errors=True)
                    shutil.copytree(folder / "made", folder / "runs")
                    sweep = "sweep" in page
                    for before in ("before", "after"):
                        shutil.copytree(folder / ("made/strategies" if sweep else "made/before"), folder / "runs" / before, dirs_exist_ok=True)
                for line, command, mark in rest:
                    if not (can_be_played(command) and is_there(command, folder)):
                        with self.subTest(f"{page}:{line}: {command}"):
                            self.assertTrue(mark, "no test plays it: write `$ ` and play the page in tests/app/tutorials.py, or <!-- not played: WHY --> above")
                        continue
                    words = shlex.split(command)[1:]
                    if words[0] == "run":
                        words += ["--quiet", "--force"] + ([] if {"--until", "--out"} & set(words) else ["--until", "200"]) + ([] if "--tier" in words or "turtlesim" in command or "docs/" in command else ["--tier", "timed"])
                    done = call(*words)
                    played += 1
                    with self.subTest(f"{page}:{line}: {command}"):
                        no = words[0] in ("validate", "why-not", "why", "diff", "test", "bench", "rerun")  # an answer, too
                        self.assertIn(done.returncode, (0, 1, 6) if no else (0,), done.stdout[-2000:] + done.stderr)
        self.assertGreater(played, 15)


def main():
    for page in pages():
        for line, command, mark in left_over(page):
            if not mark and not can_be_played(filled(command)):
                print(f"{page}:{line}: {command}")


if __name__ == "__main__":
    main()
