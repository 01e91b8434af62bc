"""./dev without setting anything up: python3 -m unittest dev_test"""

import os
import pathlib
import shutil
import subprocess
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


class Dev(unittest.TestCase):
    def test_help_names_its_commands(self):
        for arguments in ((), ("help",), ("--help",)):
            done = dev(*arguments)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            for command in ("run", "test", "cxlab", "sanitize", "format", "fuzz", "path", "help", "--no-install", "--long", "--check"):
                self.assertIn(command, done.stdout)

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
            self.assertRegex(done.stderr, "TARGET SECONDS .*targets: configuration .*definition .*rules .*scenario stimuli")

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

    def test_failed_installation_is_reported(self):
        done = dev_on_a_bare_machine("test")
        self.assertEqual(done.returncode, 5)
        self.assertRegex(done.stderr, r"packages to install .* cmake ")
        self.assertIn("the installation failed", done.stderr)


if __name__ == "__main__":
    unittest.main()
