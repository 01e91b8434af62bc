"""Tests as rows: files, a command line, the exit code, and what stderr must say. Two rows at a time.

The list beside the rows, NAME.said.txt, holds the things that a row's message must name, not its wording. These are file and line, the option or key,
values in quotes (the found value and the nearest name), the code of CLIPS, and the output of the row's rules. `form_of` checks the form of each
message. `python3 NAME.py update` writes the list again after a message names other things on purpose; the commit says which and why."""

import concurrent.futures
import dataclasses
import functools
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

CXLAB = os.environ.get("CXLAB", "")
LIMIT_S = 60
STATE = os.path.join(tempfile.gettempdir(), f"cxlab-state-{os.getuid()}")  # what cxlab remembers of a user is no part of a row
LONGEST = 400  # characters of a line that count


@dataclasses.dataclass
class Row:
    name: str
    command: list  # arguments; {here} is the row's folder
    code: int
    files: dict = dataclasses.field(default_factory=dict)  # name: text, bytes, or function that is called with the path
    never: list = dataclasses.field(default_factory=list)  # texts that stand neither in the answer nor in a file of the run
    kept: dict = dataclasses.field(default_factory=dict)  # name of a file that there must be afterwards: a part of it
    leaves: tuple = ("out",)  # folders and files that the command may make or change
    stdin: str = ""
    alike: dict = dataclasses.field(default_factory=dict)  # texts that count as another: which of the two is chance of the build
    long: bool = False  # takes a second or more


def write(folder, files):
    for name, content in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if callable(content):
            content(path)
        elif isinstance(content, bytes):
            path.write_bytes(content)
        else:
            path.write_text(content.replace("{here}", str(folder)))


def state(folder, without):
    """Each file below the folder, with its content or what it is."""
    found = {}
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder)
        if name.parts[0] not in without:
            found[str(name)] = path.read_bytes() if path.is_file() else ("link" if path.is_symlink() else "folder")
    return found


def said(out, err, folder):
    """What a person is told, on one line: errors, else the log of the rules, else the end of the answer."""
    out, err = (re.sub(r"headers [0-9a-f]+", "headers N", re.sub(r"(?<!\d)\d+ ms", "N ms", text.replace(str(folder), "{here}"))) for text in (out, err))
    err = "\n".join(line for line in err.splitlines() if not line.startswith("working: "))  # it depends on the time
    lines = [line for line in err.splitlines() if line.startswith(("error", "errors:"))]
    lines = lines or [line for line in err.splitlines() if re.search(r"\] \[(error|warn)\] |\] \[main\]", line)]
    lines = lines or out.splitlines()[-3:] or err.splitlines()[-3:]
    return " / ".join(line.strip()[:LONGEST] for line in lines[-6:]).encode("unicode_escape").decode()


# What a message names: a code of CLIPS, file:line, an option, `found X`, a text in quotes, a signal.
NAMED = re.compile(r"\[[A-Z]+\d+\]|(?:[\w{}./-]*[\w}]\.\w+):\d+(?=:)|(?<![\w-])--[a-z][a-z-]*|(?<=found )(?!an? |no |the |')[^\s,;]+|(?<!\w)'[^']+'(?!\w)|"
                   r"(?<!\w)\"[^\"]+\"(?!\w)|\bSIG[A-Z]+\b")


def named(text):
    """The parts of a message that better wording leaves as they are. Rules of the row print with level info: these lines are kept whole."""
    parts = []
    for line in text.split(" / "):
        if printed := re.match(r"\[ *[\d.]+\] \[info\] \[main\] ?(.*)", line):
            parts.append(printed[1])
            continue
        subject = re.match(r"error: ([^\s:]+): ", line)
        parts += ([subject[1]] if subject else []) + [part for part in NAMED.findall(line)]
    return " ".join(dict.fromkeys(parts))


# What no message shows: the inside of the program.
INSIDE = re.compile(r"\bstd::(?!exception\b)|\b0x[0-9a-f]{6,}|\bTraceback\b|terminate called|Assertion .* failed|core dumped|\bbasic_string\b|\bnlohmann\b|\bYAML::|\bCLI::|\(null\)|\bnullptr\b")


def form_of(row, text):
    """The faults in the form of an error. An error is one line that says what was found, without internals of the program or a path of the machine."""
    lines = [line for line in text.split(" / ") if line.startswith("error")]
    if not lines:  # a story that fails, and a problem without a plan, are answers
        return [] if row.code in (0, 1, 10, 12, 23, 130, 143) or text.endswith(" failed") else ["no line begins with error:"]
    given = " ".join([*map(str, row.command), row.stdin, *row.files, *(content for content in row.files.values() if isinstance(content, str))])
    wrong = []
    for line in lines:
        message = re.sub(r"^errors?: ", "", line)
        if found := INSIDE.search(message):
            wrong.append(f"it shows the inside of the program: {found[0]}")
        wrong += [f"it shows a path of the machine: {path}" for path in re.findall(r"(?<![\w{}./~-])/(?:home|root|work|tmp|dev/shm|build|usr/src)/[\w./-]*", message) if path not in given]
        if len(message.split()) < 3:
            wrong.append("it is no sentence")
        if re.search(r"[,:(]$", message) and len(line) < LONGEST:
            wrong.append("it ends in the middle of a sentence")
    return wrong


@functools.cache
def options_of(command):
    done = subprocess.run([CXLAB, command, "--help"], capture_output=True, text=True, timeout=LIMIT_S)
    return set(re.findall(r"--[a-z][a-z-]*", done.stdout)) if done.returncode == 0 else None


def not_to_be_given(command, text):
    """Options that an error names, and that neither this command has nor the one that the error names with them."""
    if not (own := options_of(command[0]) if command and command[0].isalpha() else None):
        return []
    named = re.findall(r"(?<![\w'-])(--[a-z][a-z-]*)(?:=\S*| [A-Z]\S*| \S+=\S+)?(?: of cxlab ([a-z-]+))?", re.sub(r"found '[^']*'|there is no option '[^']*'", "", text))
    return [option for option, other in named if option not in ((options_of(other) if other else own) or ())]


def play_row(row, fixed):
    """What it said, and what is wrong beside that."""
    folder = pathlib.Path(tempfile.mkdtemp(prefix="cxlab-row-")).resolve()
    try:
        write(folder, {**fixed, **row.files})
        before = state(folder, row.leaves)
        command = [CXLAB, *(argument.replace("{here}", str(folder)) for argument in row.command)]
        environment = {**os.environ, "HOME": str(folder / "home"), "XDG_STATE_HOME": STATE}
        try:
            done = subprocess.run(command, cwd=folder, input=row.stdin.encode(), capture_output=True, timeout=LIMIT_S, env=environment)
        except subprocess.TimeoutExpired:
            return "", [f"it has not ended after {LIMIT_S} s"]
        out, err = done.stdout.decode(errors="backslashreplace"), done.stderr.decode(errors="backslashreplace")
        wrong = [] if done.returncode == row.code else [f"exit code {done.returncode}, expected {row.code}"]
        if row.never:
            files = [p for name in row.leaves for p in (folder / name).rglob("*") if p.is_file() and not p.is_symlink()]
            everything = out + err + "".join(p.read_bytes().decode(errors="replace") for p in files)
            wrong += [f"{text!r} came out" for text in row.never if text in everything]
        for name, part in row.kept.items():
            path = folder / name.replace("{here}", str(folder))
            if not path.is_file() or part not in path.read_text(errors="replace"):
                wrong.append(f"{name} has no {part!r}")
        errors = "\n".join(line for line in err.splitlines() if line.startswith("error"))
        wrong += [f"it names {option}, which cxlab {row.command[0]} has not" for option in not_to_be_given(row.command, errors)]
        after = state(folder, row.leaves)
        wrong += [f"{name} was changed" for name in sorted(before.keys() | after.keys()) if before.get(name) != after.get(name)]
        text = said(out, err, folder)
        for one, other in row.alike.items():
            text = text.replace(one, other)
        return text, wrong + form_of(row, text)
    finally:
        shutil.rmtree(folder)


def play(rows, fixed):
    """(row, what it said, what is wrong) of each."""
    only = re.compile(os.environ.get("CXLAB_ROWS", ""))
    rows = [row for row in rows if only.search(row.name)]
    with concurrent.futures.ThreadPoolExecutor(2) as workers:
        yield from ((row, *result) for row, result in zip(rows, workers.map(lambda row: play_row(row, fixed), rows)))


def read_list(file):
    """kind: {name of a row: text}"""
    kinds = {}
    for line in file.read_text().splitlines() if file.exists() else []:
        if line.startswith("# "):
            kinds[line[2:]] = {}
        elif line:
            name, text = line.split("\t")
            kinds[list(kinds)[-1]][name] = text
    return kinds


def tests_of(module, kinds, fixed, file):
    """A test case with a test for each kind of rows, and one for those of it that take long; `fixed` are files that all rows have."""
    file = pathlib.Path(file).with_suffix(".said.txt")
    expected = read_list(file)

    def test(self, kind, rows):
        names = [row.name for row in kinds[kind]]
        self.assertEqual(len(set(names)), len(names), "two rows have one name")
        self.assertEqual(set(names), set(expected.get(kind, ())), "the list has other rows; update writes it again")
        for row, text, wrong in play(rows, fixed):
            with self.subTest(row.name):
                self.assertFalse(wrong, f"{wrong}; it said: {text}")
                self.assertEqual(named(text), expected[kind][row.name], f"it said: {text}")

    def update():
        lines = []
        for kind, rows in kinds.items():
            lines.append(f"# {kind}")
            for row, text, wrong in play(rows, fixed):
                lines.append(f"{row.name}\t{named(text)}")
                if wrong:
                    print(f"{kind}: {row.name}: {wrong}: {text}", file=sys.stderr)
        file.write_text("\n".join(lines) + "\n")

    tests = {}
    for kind, rows in kinds.items():
        for length in ("short", "long"):
            if some := [row for row in rows if row.long == (length == "long")]:
                tests[f"test_{length}_{kind.replace(' ', '_')}"] = lambda self, kind=kind, some=some: test(self, kind, some)
    case = type("Rows", (unittest.TestCase,), {"__module__": module, **tests})
    return case, update


def main(update):
    update() if sys.argv[1:] == ["update"] else unittest.main(module="__main__")
