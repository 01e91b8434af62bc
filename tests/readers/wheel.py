"""The wheel, as people install it: into a virtual environment, and into a bare Debian 12. ./dev readers -R wheel"""

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
import unittest
import zipfile
from pathlib import Path

SOURCE = Path(os.environ["CXLAB_SOURCE_DIR"])
READERS = Path(os.environ["CXLAB_READERS"])
FIRST_GAME = """
import cxlab
print(cxlab.Episode("rcll/game", seed=7, tier="timed", until=300, out="first").run()["teams"]["CYAN"]["points"])
"""
ANSWERS = ["why", "first", "(order (id 1))", "--at", "300"]


def run(*command, **more):
    more.setdefault("timeout", 1200)
    return subprocess.run(list(map(str, command)), capture_output=True, text=True, **more)


class Wheel(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        scratch = tempfile.TemporaryDirectory()
        cls.addClassCleanup(scratch.cleanup)
        cls.scratch = Path(scratch.name)
        built = run(SOURCE / "dev", "wheel")
        assert built.returncode == 0, built.stdout + built.stderr
        cls.wheel = Path(built.stdout.split()[-1])

    def test_it_is_small_and_serves_all_versions_from_3_11_on(self):
        self.assertLess(self.wheel.stat().st_size, 60e6)
        self.assertRegex(self.wheel.name, r"-cp311-abi3-manylinux_2_\d+_x86_64\.whl$")
        names = zipfile.ZipFile(self.wheel).namelist()
        for name in ("cxlab/py.typed", "cxlab/_cxlab.pyi", "cxlab/bin/cxlab", "cxlab/share/cxlab/scenarios/rcll/game.yaml"):
            self.assertIn(name, names)
        self.assertFalse([name for name in names if "OSMesa" in name])

    def test_it_needs_no_newer_libc_than_its_name_says(self):
        unpacked = self.scratch / "unpacked"
        zipfile.ZipFile(self.wheel).extractall(unpacked)
        said = int(re.search(r"manylinux_2_(\d+)", self.wheel.name)[1])
        needed = {0}
        for library in [*unpacked.rglob("*.so*"), unpacked / "cxlab/bin/cxlab"]:
            symbols = run("readelf", "--version-info", library).stdout
            needed |= {int(minor) for minor in re.findall(r"GLIBC_2\.(\d+)", symbols)}
        self.assertLessEqual(max(needed), said)
        self.assertGreater(max(needed), 20)

    def test_it_works_in_a_virtual_environment_beside_other_packages(self):
        venv = self.scratch / "venv"
        self.assertEqual(run(sys.executable, "-m", "venv", venv).returncode, 0)
        installed = run(venv / "bin/pip", "install", "--quiet", self.wheel)
        self.assertEqual(installed.returncode, 0, installed.stderr)
        clean = {key: value for key, value in os.environ.items() if key not in ("PYTHONPATH", "CXLAB")}
        played = run(venv / "bin/python", "-c", "import ssl, sqlite3\n" + FIRST_GAME, cwd=self.scratch, env=clean)
        self.assertEqual(played.returncode, 0, played.stderr)
        answered = run(venv / "bin/cxlab", *ANSWERS, cwd=self.scratch, env=clean)
        self.assertIn("asserted at", answered.stdout)
        tested = run(venv / "bin/python", "-m", "unittest", "test_episode", cwd=SOURCE / "tests/python", env=clean)
        self.assertEqual(tested.returncode, 0, tested.stderr)
        self.assertNotIn("needs NumPy", tested.stderr)

    @unittest.skipUnless(os.geteuid() == 0, "needs root")
    def test_it_works_in_a_bare_debian_without_a_compiler(self):
        kept = READERS / "debian12"
        if not (kept / "whole").exists():
            shutil.rmtree(kept, ignore_errors=True)
            targets = ["$(REPO_URI)", "Codename: bookworm", "Created-By: Packages"]
            sources = run("apt-get", "indextargets", "--format", *targets).stdout.split()
            subprocess.run(["debootstrap", "--variant=minbase", "bookworm", kept, sources[0]], check=True, capture_output=True)
            (kept / "whole").touch()
        debian = self.scratch / "debian12"
        subprocess.run(["cp", "-a", kept, debian], check=True)

        def inside(command):
            mounts = f"mount --bind /proc {debian}/proc && mount --bind /dev {debian}/dev && exec chroot {debian} sh -c \"$0\""
            done = run("unshare", "--mount", "sh", "-c", mounts, f"cd /root && {command}")
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            return done.stdout

        for file in (self.wheel, "/etc/resolv.conf", "/etc/ssl/certs/ca-certificates.crt"):
            shutil.copy(file, debian / "root")
        shutil.copy("/etc/resolv.conf", debian / "etc/resolv.conf")
        certificates = "PIP_CERT=/root/ca-certificates.crt REQUESTS_CA_BUNDLE=/root/ca-certificates.crt CURL_CA_BUNDLE="
        inside("apt-get update && DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends python3-venv")
        inside("! command -v cc && python3 -m venv v")
        begin = time.monotonic()
        inside(f"{certificates} v/bin/pip install --quiet cxlab-*.whl")
        seconds = time.monotonic() - begin
        (debian / "root/game.py").write_text(FIRST_GAME)
        self.assertGreater(int(inside("v/bin/python game.py")), 0)
        self.assertIn("asserted at", inside("v/bin/cxlab why first '(order (id 1))' --at 300"))
        (debian / "root/draw.py").write_text('import cxlab\ncxlab.Episode("rcll/game", tier="timed").render()\n')
        self.assertIn("apt install libosmesa6", inside("v/bin/python draw.py 2>&1 || true"))
        print(json.dumps({"install_seconds": round(seconds, 1), "megabytes": round(self.wheel.stat().st_size / 1e6, 1)}))
        self.assertLess(seconds, 60)


if __name__ == "__main__":
    unittest.main()
