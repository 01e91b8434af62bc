"""The package of Python, read by mypy and ruff. ./dev readers -R python_types"""

import os
import subprocess
import sys
import unittest
from pathlib import Path

SOURCE = Path(os.environ["CXLAB_SOURCE_DIR"])
BUILD = Path(os.environ["CXLAB_BUILD_DIR"])
CONFIG = SOURCE / "python/pyproject.toml"


def run(*command, cwd):
    done = subprocess.run([sys.executable, "-m", *map(str, command)], cwd=cwd, capture_output=True, text=True, timeout=600)
    return done.returncode, done.stdout + done.stderr


class PythonTypes(unittest.TestCase):
    def test_mypy_finds_nothing_in_strict_mode(self):
        self.assertTrue((BUILD / "python/cxlab/_cxlab.pyi").exists(), "cmake --build build/release --target cxlab_python_stub")
        code, said = run("mypy", "--config-file", CONFIG, "--cache-dir", BUILD / "mypy", "-p", "cxlab", cwd=BUILD / "python")
        self.assertEqual(code, 0, said)

    def test_mypy_knows_the_types_of_what_a_program_uses(self):
        program = BUILD / "python/wrong_program.py"
        self.addCleanup(program.unlink)
        for expression, kind in (('cxlab.Episode("rcll/game").step().now', "float"), ("cxlab.learn.RCLLDispatchEnv()", "RCLLDispatchEnv")):
            with self.subTest(expression):
                program.write_text(f"import cxlab.learn\nwrong: str = {expression}\n")
                code, said = run("mypy", "--config-file", CONFIG, "--cache-dir", BUILD / "mypy", program.name, cwd=BUILD / "python")
                self.assertEqual(code, 1, said)
                self.assertIn(f'"{kind}"', said)

    def test_ruff_finds_nothing(self):
        code, said = run("ruff", "check", "--no-cache", "--config", CONFIG, SOURCE / "python/cxlab", cwd=SOURCE)
        self.assertEqual(code, 0, said)


if __name__ == "__main__":
    unittest.main()
