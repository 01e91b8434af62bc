"""Plays the blocks of pages: each command prints what its page shows, and each block of Python runs.

A block has no language, or the language python. In the first, a line that begins with `$ ` is a command, and the lines below are what it prints:

- `...` stands for anything, and blanks for any blanks.
- A line `cxlab> ...` is what a person enters on a terminal; Ctrl-D follows the last one.
- `^C` at the end: the command goes on until then, and Ctrl-C ends it.
- A command that ends with `&` goes on while the others are played.
- `<<END` takes the lines up to END.

A block of Python prints what the block directly below shows, if that has no command. All blocks of a page share the folder, variables and names.
Comments above a block say how it is played:

  <!-- first: COMMAND -->             makes what a reader has already
  <!-- with B instead of A -->        another text in its commands, and in what they print
  <!-- played by TEST -->             the test of CTest that plays it; without it: the short ones of tests/app
  <!-- not played: WHY -->            what it needs cannot be had here
"""

import json
import os
import pty
import re
import select
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from dataclasses import dataclass, field, replace
from pathlib import Path

SOURCE = Path(os.environ.get("CXLAB_SOURCE_DIR", Path(__file__).resolve().parents[2]))
FENCE = re.compile(r"^((?: *<!--[^\n]*-->\n)*)(```|~~~)([^\n`]*)\n(.*?)^\2[ \t]*$", re.MULTILINE | re.DOTALL)
ABOVE = re.compile(r"<!-- (?:first: (?P<first>.*?)|with (?P<new>.*?) instead of (?P<old>.*?)|played by (?P<by>\w+)|not played: (?P<why>.*?)) -->")
PROMPT = "cxlab> "
# Blocks of Python, one a line as JSON; after each a line with its end.
NOTEBOOK = """
import json, sys, traceback
names = {"__name__": "__main__"}
for line in sys.stdin:
    try:
        exec(compile(json.loads(line), "<block>", "exec"), names)
        end = 0
    except BaseException:
        traceback.print_exc(file=sys.stdout)
        end = 1
    print(f"\\n<<end {end}>>", flush=True)
"""


def pattern_of(lines):
    """What an output must match."""
    text = r"\s*".join(".*?".join(r"\s+".join(map(re.escape, part.split())) for part in line.split("...")) for line in lines)
    return re.compile(r"\s*" + text + r"\s*", re.DOTALL)


@dataclass
class Step:
    """A command of bash or a block of Python, what is entered, and what it prints."""
    command: str
    shown: list = field(default_factory=list)
    python: bool = False

    def pattern(self):
        return pattern_of([line for line in self.shown if line != "^C"])

    def by_prompt(self):
        """The lines before the first one that is entered, and from each of those on."""
        parts = [[]]
        for line in self.shown:
            if line.startswith(PROMPT):
                parts.append([])
            parts[-1].append(line)
        return parts


@dataclass
class Block:
    line: int
    steps: list
    first: list
    instead: dict
    by: str  # "": the short tests
    why_not: str

    def how(self):
        """Its class, as the count of all blocks has them."""
        if self.why_not:
            return "not played"
        compares = [step.shown != ["..."] and not (step.python and not step.shown) for step in self.steps]
        return "compared" if all(compares) else "compared in part" if any(compares) else "exit code"


def steps_of(text):
    for command in re.split(r"^\$ ", re.sub(r"\\\n\s*", "", text), flags=re.MULTILINE)[1:]:
        line, _, output = command.partition("\n")
        if line.endswith(("<<END", "<<'END'")):
            document, _, output = output.partition("END\n")
            line += f"\n{document}END\n"
        yield Step(line, output.splitlines())


def blocks_of(text):
    """The blocks of a page that have something to play."""
    found, last = [], None
    for fence in FENCE.finditer(text):
        above, _, language, body = fence.groups()
        python, plain = language.strip() == "python", not language.strip()
        if plain and last and not text[last.end():fence.start()].strip() and not re.search(r"^\$ ", body, re.MULTILINE):
            found[-1].steps[-1].shown = body.splitlines()
        steps = [Step(body, python=True)] if python else list(steps_of(body)) if plain else []
        last = fence if python else None
        if steps:
            marks = [mark.groupdict() for mark in ABOVE.finditer(above)]
            pick = lambda name: [mark[name] for mark in marks if mark[name]]
            found.append(Block(text.count("\n", 0, fence.start(2)) + 1, steps, pick("first"), dict(zip(pick("old"), pick("new"))),
                               "".join(pick("by")), "".join(pick("why"))))
    return found


def blocks_on(page):
    return blocks_of((SOURCE / page).read_text())


def pages():
    """The pages of the documentation, as paths of the project."""
    listed = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard", "README.md", "CONTRIBUTING.md", "benchmarks/README.md", "docs/*.md"],
                            cwd=SOURCE, text=True, check=True, stdout=subprocess.PIPE).stdout.split()
    return sorted(name for name in listed if not name.startswith(("docs/templates/", "docs/examples/")) and (SOURCE / name).is_file())


class Pages(unittest.TestCase):
    """A test for each page below `folder` that has blocks which the CTest test `by` plays. A method of its name may call play() and look further."""
    programs = [Path(os.environ["CXLAB"]).parent] if "CXLAB" in os.environ else []
    python = sys.executable
    maxDiff = None
    patience_s = 60  # until a program that a person talks to prints more

    def __init_subclass__(cls, folder="", by="", **more):
        super().__init_subclass__(**more)
        cls.by = by
        for page in pages():
            name = "test_" + re.sub(r"\W", "_", page.removeprefix("docs/").removeprefix(folder + "/").removesuffix(".md"))
            if page.startswith(folder) or page.startswith(f"docs/{folder}/"):
                if not hasattr(cls, name) and any(block.by == by and not block.why_not for block in blocks_on(page)):
                    setattr(cls, name, lambda self, page=page: self.play(page) and None)

    def play(self, page):
        """Plays the blocks of the page. Returns the folder that stands for /tmp."""
        self.prepare()
        for block in blocks_on(page):
            if block.by == self.by and not block.why_not:
                for command in block.first:
                    self.play_step(Step(command, ["..."]), replace(block, instead={}))
                for step in block.steps:
                    with self.subTest(f"{page}:{block.line}: {step.command}"):
                        self.play_step(step, block)
        return self.tmp

    def prepare(self):
        """Makes the folder of a page, with links to the folders of the project, in which no page writes."""
        self.folder = Path(tempfile.mkdtemp(prefix="cxlab-page-"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.work, self.tmp, self.state = self.folder / "work", self.folder / "tmp", self.folder / "state"
        for made in (self.work, self.tmp, self.folder / "home"):
            made.mkdir()
        for file in SOURCE.iterdir():
            if file.name not in ("runs", "dist", ".git"):
                shutil.copy(file, self.work) if file.is_file() else (self.work / file.name).symlink_to(file)
        (self.work / "dev").write_text(f'#!/bin/sh\nexec {SOURCE}/dev "$@"\n')  # it works in its own folder
        (self.work / "dev").chmod(0o755)
        self.state.write_text(f"cd {self.work}\n")
        home = Path.home()
        self.environment = {"XDG_CACHE_HOME": str(home / ".cache"), "XDG_CONFIG_HOME": str(home / ".config"), **os.environ, "HOME": str(self.folder / "home"),
                            "PATH": ":".join(map(str, [*self.programs, Path(self.python).parent, os.environ["PATH"]]))}
        self.notebook = None

    def play_step(self, step, block):
        step = Step(step.command, list(step.shown), step.python)
        for old, new in block.instead.items():
            self.assertIn(old, "\n".join(line for one in block.steps for line in (one.command, *one.shown)), "the page no longer has what another text stands in for")
            step.command, step.shown = step.command.replace(old, new), [line.replace(old, new) for line in step.shown]
        command = re.sub(r"(?<![\w.])/tmp/", f"{self.tmp}/", step.command)
        if step.python:
            said = self.play_python(command)
        elif command.endswith("&") or step.shown[-1:] == ["^C"]:
            return self.play_until_shown(command.rstrip("& "), step)
        elif len(step.by_prompt()) > 1:
            return self.play_on_terminal(command, step)
        else:
            done = subprocess.run(self.bash(command), env=self.environment, text=True, timeout=1800, stdin=subprocess.DEVNULL,
                                  stdout=subprocess.PIPE, stderr=subprocess.PIPE)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            said = done.stdout
        said = self.as_on_pages(said)
        if not step.pattern().fullmatch(said) and (step.shown or not step.python):
            self.fail(f"it prints\n{said}\nand the page shows\n" + "\n".join(step.shown))

    def as_on_pages(self, text):
        return text.replace(f"{self.tmp}/", "/tmp/").replace(str(self.folder / "home"), "~").replace(f"{self.work}/", "")

    def bash(self, command):
        """The command after those before it: in their folder, with their variables."""
        save = f"{{ echo cd \"$(printf %q \"$PWD\")\"; export -p; }} > {self.state}"
        return ["bash", "-c", f"source {self.state}; trap '{save}' EXIT\n{command}"]

    def play_python(self, code):
        """In the one process of the page."""
        if not self.notebook:
            if subprocess.run([self.python, "-c", "import cxlab, numpy"], env=self.environment, stderr=subprocess.DEVNULL).returncode:
                (self.fail if self.by else self.skipTest)("needs the package of Python, and NumPy")
            self.notebook = subprocess.Popen([self.python, "-c", NOTEBOOK], cwd=self.work, env=self.environment, text=True,
                                             stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
            self.addCleanup(lambda: (self.notebook.stdin.close(), self.notebook.wait(30), self.notebook.stdout.close()))
        self.notebook.stdin.write(json.dumps(code) + "\n")
        self.notebook.stdin.flush()
        said = ""
        while not (end := re.search(r"\n<<end (\d)>>\n$", said)):
            line = self.notebook.stdout.readline()
            self.assertTrue(line, "Python has ended: " + said)
            said += line
        self.assertEqual(end[1], "0", said)
        return said[:end.start()]

    def play_on_terminal(self, command, step):
        """As a person does: waits for what the page shows and a prompt, enters the next line, and Ctrl-D after the last."""
        person, terminal = pty.openpty()
        self.addCleanup(os.close, person)
        process = subprocess.Popen(self.bash(command), env={**self.environment, "TERM": "dumb"}, stdin=terminal, stdout=terminal, stderr=subprocess.DEVNULL, start_new_session=True)
        self.addCleanup(lambda: (process.kill(), process.wait()))
        os.close(terminal)
        parts = step.by_prompt()
        for part, following in zip(parts, [*parts[1:], None]):
            shown = pattern_of([*part, PROMPT])
            said = PROMPT if part[:1] and part[0].startswith(PROMPT) else ""
            while not shown.fullmatch(said):
                if not select.select([person], [], [], self.patience_s)[0]:
                    self.fail(f"it prints\n{said}\nand the page shows\n" + "\n".join(part))
                said += os.read(person, 65536).decode().replace("\r", "")
                said = said.replace(PROMPT + "\033[K", "")  # a line that comes while the prompt stands
            os.write(person, (following[0].removeprefix(PROMPT) + "\n" if following else "\x04").encode())
        self.assertEqual(process.wait(60), 0)

    def play_until_shown(self, command, step):
        """Starts it, and waits until it has printed what the page shows. Ctrl-C ends it: now, or after the page."""
        log = tempfile.TemporaryFile("w+")
        self.addCleanup(log.close)
        process = subprocess.Popen(self.bash("exec " + command), env=self.environment, stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT, start_new_session=True,
                                   preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
        end = time.monotonic() + 60

        def said():
            log.seek(0)
            return self.as_on_pages(log.read())

        def stop():
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGINT)
            return process.wait(60)

        if step.shown[-1:] != ["^C"]:
            self.addCleanup(stop)
        try:
            while not step.pattern().search(said()):
                self.assertLess(time.monotonic(), end, "it prints\n" + said())
                self.assertIsNone(process.poll(), "it has ended: " + said())
                time.sleep(0.02)
        finally:
            code = stop() if step.shown[-1:] == ["^C"] else 0
        self.assertIn(code, (0, 6, 130, -signal.SIGINT), said())
