"""./dev without setting anything up: python3 -m unittest dev_test"""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(os.environ["CXLAB_SOURCE_DIR"])


def dev(*arguments, root=ROOT, **environment):
    return subprocess.run([root / "dev", *arguments], env={**os.environ, **environment}, text=True, timeout=50,
                          stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE)


def dev_on_a_bare_machine(*arguments):
    """A copy of ./dev where dpkg-query knows no package, cargo is not there, and nothing can be installed."""
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        shutil.copy(ROOT / "dev", root / "dev")
        programs = root / "bin"
        programs.mkdir()
        for name in ("bash", "dirname", "id", "mkdir", "tail"):
            (programs / name).symlink_to(shutil.which(name))
        for name in ("dpkg-query", "cargo", "sudo", "sh"):
            (programs / name).write_text(f"#!{shutil.which('bash')}\nexit 1\n")
            (programs / name).chmod(0o755)
        return dev(*arguments, root=root, PATH=str(programs), CXLAB_DOWNLOADS=str(root / "downloads"))


def dev_with_a_compiler(build, *arguments, free=0, built="cxlab", **environment):
    """A copy of ./dev on a machine that has all packages, where cmake prints the text of a build and ends with its code.
    There ctest prints where tests write, and a file system has that many GB free. The program `built` is there. The result
    has `calls`: what cmake built and what the program played, in their order."""
    text, code = build
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        shutil.copy(ROOT / "dev", root / "dev")
        (root / "build/release").mkdir(parents=True)
        (root / "build/release/build.ninja").touch()
        (root / "build/release/.ninja_log").touch()
        (root / "text").write_text(text)
        programs = root / "bin"
        programs.mkdir()
        for name, script in {"cmake": f'echo "${{@:3}}" >>{root}/calls; cat {root}/text; exit {code}', "ctest": 'test -d "$TMPDIR" && echo "$TMPDIR"',
                             "df": f"echo Avail; echo {free}", "rustc": "exit 0", "cargo": "echo cargo 1.90.0",
                             "dpkg-query": 'for p in "$@"; do echo "installed $p"; done'}.items():
            (programs / name).write_text(f"#!{shutil.which('bash')}\n{script}\n")
            (programs / name).chmod(0o755)
        program = root / "build/release" / built
        program.write_text(f"#!{shutil.which('bash')}\necho played \"$@\" | tee -a {root}/calls\n[[ $* != *fail* ]] || exit 2\n")
        program.chmod(0o755)
        done = dev(*arguments, root=root, PATH=f"{programs}:{os.environ['PATH']}", **environment)
        done.calls = (root / "calls").read_text().replace(folder, "").splitlines()
        return done


class Dev(unittest.TestCase):
    def test_tests_write_to_memory_if_there_is_room(self):
        def written_to(free, own=""):
            return dev_with_a_compiler(("", 0), "test", free=free, TMPDIR=own).stdout.strip()
        self.assertEqual(written_to(3), "")
        self.assertEqual(written_to(4, "/"), "/")
        if os.access("/dev/shm", os.W_OK):
            used = written_to(4)
            self.assertRegex(used, "^/dev/shm/cxlab-test-")
            self.assertFalse(os.path.exists(used), "it is left behind")

    def test_build_that_works_is_silent(self):
        done = dev_with_a_compiler(("[1/2] Building a.o\n[2/2] Linking cxlab\n", 0), "cxlab", "list")
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "played list\n", ""))

    def test_first_run_plays_before_all_is_built(self):
        done = dev_with_a_compiler(("", 0), "run", "--seed", "7", built="cxlab_first")
        played = "played run /scenarios/rcll/game.yaml --seed 7"
        self.assertEqual(done.calls, ["--target cxlab_first", played, "--target cxlab"])
        self.assertEqual(done.returncode, 0)
        failed = dev_with_a_compiler(("", 0), "run", "--fail", built="cxlab_first")
        self.assertEqual((failed.returncode, failed.calls[-1]), (2, "played run /scenarios/rcll/game.yaml --fail"))

    def test_run_of_what_may_need_all_builds_all(self):
        for arguments in [("a.yaml",), ("--set", "seed=3"), ("--set=seed=3",), ("a.yaml", "--seed", "7")]:
            self.assertEqual(dev_with_a_compiler(("", 0), "run", *arguments, built="cxlab_first").calls, ["--target cxlab"])
        self.assertEqual(dev_with_a_compiler(("", 0), "run").calls, ["--target cxlab", "played run /scenarios/rcll/game.yaml"])

    def test_verbose_shows_the_lines_of_the_build_and_reaches_the_program(self):
        done = dev_with_a_compiler(("[1/2] Building a.o\n", 0), "run", "a.yaml", "-v")
        self.assertEqual((done.returncode, done.stdout), (0, "played run a.yaml -v\n"))
        self.assertEqual(done.stderr, "[1/2] Building a.o\n")

    def test_build_that_fails_shows_why(self):
        text = "[1/2] Building a.o\nFAILED: b.o\nb.cpp:3:1: error: no such thing\n[2/2] Building c.o\nninja: build stopped\n"
        done = dev_with_a_compiler((text, 1), "run")
        self.assertEqual((done.returncode, done.stdout), (5, ""))
        self.assertEqual(done.stderr, "FAILED: b.o\nb.cpp:3:1: error: no such thing\nninja: build stopped\n"
                                      "./dev: the build failed; all of its lines are in build/build.log\n")

    def test_help_names_its_commands(self):
        for arguments in ((), ("help",), ("--help",)):
            done = dev(*arguments)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            for command in ("run", "test", "cxlab", "sanitize", "format", "fuzz", "readers", "docs", "path", "help", "--no-install", "--long", "--check"):
                self.assertIn(command, done.stdout)

    def test_docs_has_one_option(self):
        done = dev("docs", "--open")
        self.assertEqual((done.returncode, done.stderr), (2, "./dev: docs has one option: --serve\n"))

    def test_path_is_where_the_program_is_built(self):
        self.assertEqual(dev("path").stdout, f"{ROOT}/build/release/cxlab\n")

    def test_unknown_command_is_a_usage_error(self):
        done = dev("fly")
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        self.assertIn("unknown command 'fly'", done.stderr)

    def test_format_lists_the_files_that_differ_and_formats_them(self):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            shutil.copy(ROOT / "dev", root)
            shutil.copy(ROOT / ".clang-format", root)
            for part in ("cmake", "third_party/clang_format"):
                shutil.copytree(ROOT / part, root / part)
            (root / "wrong.cpp").write_text("int  x ;\n")
            (root / "right.h").write_text("int y;\n")
            done = dev("format", "--check", root=root)
            self.assertEqual((done.returncode, done.stdout), (1, "./wrong.cpp\n"), done.stderr)
            self.assertIn("1 file is not formatted", done.stderr)
            self.assertEqual(dev("format", root=root).returncode, 0)
            self.assertEqual((root / "wrong.cpp").read_text(), "int x;\n")
            self.assertEqual(dev("format", "--check", root=root).returncode, 0)

    def test_format_refuses_other_options(self):
        done = dev("format", "--chek")
        self.assertEqual((done.returncode, done.stdout), (2, ""))

    def test_fuzz_names_its_targets(self):
        for arguments in ((), ("rules",), ("rules", "soon"), ("ruels", "5")):
            done = dev("fuzz", *arguments)
            self.assertEqual((done.returncode, done.stdout), (2, ""))
            self.assertRegex(done.stderr, "TARGET SECONDS .*targets: .*configuration .*definition .*rules .*scenario .*stimuli")

    def test_fuzz_without_clang_says_what_to_install(self):
        with tempfile.TemporaryDirectory() as folder:
            for name in ("bash", "dirname"):
                (pathlib.Path(folder) / name).symlink_to(shutil.which(name))
            done = dev("fuzz", "rules", "5", PATH=folder)
        self.assertEqual(done.returncode, 5)
        self.assertIn("apt-get install clang-16", done.stderr)

    def test_no_install_prints_the_command_that_installs(self):
        done = dev_on_a_bare_machine("test", "--no-install")
        self.assertEqual(done.returncode, 5)
        self.assertRegex(done.stdout, r"^apt-get update; .*apt-get install -y .* cmake .* cargo-web\n$")

    def test_readers_want_more_packages(self):
        done = dev_on_a_bare_machine("readers", "--no-install")
        self.assertEqual(done.returncode, 5)
        self.assertRegex(done.stdout, r" cmake .* libcapture-tiny-perl .* python3-venv")

    def test_readers_that_are_missing_are_an_error_with_the_remedy(self):
        for arguments, command in ((["plans"], "./dev readers"), (["--torch", "plans"], "./dev readers --torch")):
            with self.subTest(command), tempfile.TemporaryDirectory() as folder:
                done = subprocess.run([sys.executable, ROOT / "tests/readers/with_readers.py", *arguments], env={**os.environ, "CXLAB_READERS": folder},
                                      text=True, capture_output=True, timeout=50)
                self.assertEqual((done.returncode, done.stdout), (1, ""))
                self.assertIn(f": {command} fetches the readers", done.stderr)

    def test_failed_installation_is_reported(self):
        done = dev_on_a_bare_machine("test")
        self.assertEqual(done.returncode, 5)
        self.assertRegex(done.stderr, r"packages to install .* cmake ")
        self.assertIn("the installation failed", done.stderr)


if __name__ == "__main__":
    unittest.main()
