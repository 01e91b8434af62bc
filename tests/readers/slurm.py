"""cxlab bench --slurm on a real Slurm: a controller and a node that the test starts on this machine. ./dev readers"""

import getpass
import json
import os
import socket
import subprocess
import time
import unittest

from lab import CONFIG, CXLAB, Lab

SUITE = """scenarios: [game.yaml]
seeds: "1..8"
strategies: {plain: []}
grid: {duration_s: [3, 4]}
"""
CONF = """ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/none
CredType=cred/none
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
ReturnToService=2
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=sched_interval=1
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
NodeName={host} NodeAddr=127.0.0.1 CPUs={cpus} State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


def free_ports(count):
    sockets = [socket.socket() for _ in range(count)]
    for one in sockets:
        one.bind(("127.0.0.1", 0))
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports


class Slurm(Lab):
    def setUp(self):
        super().setUp()
        cluster = self.folder / "cluster"
        for name in ("state", "spool"):
            (cluster / name).mkdir(parents=True)
        conf = self.write("cluster/slurm.conf", CONF.format(folder=cluster, user=getpass.getuser(), host=socket.gethostname().split(".")[0], ports=free_ports(2), cpus=os.cpu_count()))
        self.environment = {**os.environ, "SLURM_CONF": str(conf)}
        for daemon in ("slurmctld", "slurmd"):
            process = subprocess.Popen([f"/usr/sbin/{daemon}", "-D", "-f", conf], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=self.environment)
            self.addCleanup(process.wait, 30)
            self.addCleanup(process.terminate)
        self.wait_for("the node is idle", lambda: self.ask("sinfo", "--noheader", "--format=%T").strip() in ("idle", "mixed"))
        self.agent("(defrule draw (time ?) => (assert (drawn (random))))\n")
        self.write("agent.yaml", CONFIG)
        self.write("game.yaml", "schema: 1\nduration_s: 2\npackages: {rules: rules}\nagents:\n  - config: agent.yaml\n")
        self.write("suite.yaml", SUITE)

    def ask(self, *command):
        return subprocess.run(command, env=self.environment, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=60).stdout

    def wait_for(self, what, holds):
        for _ in range(600):
            if holds():
                return
            time.sleep(0.2)
        logs = "".join(file.read_text()[-2000:] for file in (self.folder / "cluster").glob("*.log"))
        self.fail(f"{what}: not within two minutes\n{self.ask('squeue')}\n{logs}")

    def bench(self, *arguments, code=0):
        done = subprocess.run([CXLAB, "bench", "suite.yaml", *arguments], cwd=self.folder, text=True, timeout=120, capture_output=True)
        self.assertEqual(done.returncode, code, done.stderr)
        return done

    def submit(self):
        done = subprocess.run([self.folder / "r/slurm/submit.sh", "--time=5"], cwd="/", env=self.environment, text=True, timeout=60, capture_output=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r"^cells: job \d+, table: job \d+\n$")
        return done.stdout.split()[2].strip(",")

    def done(self):
        return self.ask("squeue", "--noheader").strip() == ""

    def rows(self, out):
        rows = {file.name: json.loads(file.read_text()) for file in (self.folder / out / "rows").glob("*.json")}
        return {name: {key: value for key, value in row.items() if key != "played"} for name, row in rows.items()}

    def test_an_array_of_jobs_gives_what_one_machine_does(self):
        self.bench("-j", "2", "--out", "whole")
        said = self.bench("--slurm", "--tasks", "7", "--out", "r").stdout
        self.assertIn("cells.sh: 6 tasks of up to 4 cells", said)
        self.submit()
        self.wait_for("all jobs have ended", self.done)
        table = (self.folder / "r/slurm/table.txt").read_text()
        self.assertIn("24 of 24 cells have a row", table)
        self.assertIn("duration_s=4", table)
        self.assertEqual((self.folder / "r/rows.csv").read_bytes(), (self.folder / "whole/rows.csv").read_bytes())
        self.assertEqual(self.rows("r"), self.rows("whole"))

    def test_what_a_cancelled_task_lacks_is_played_afterwards(self):
        self.bench("-j", "2", "--out", "whole")
        self.bench("--slurm", "--out", "r")
        job = self.submit()
        self.wait_for("some cells are played", lambda: len(self.rows("r")) >= 3 if (self.folder / "r/rows").exists() else False)
        self.ask("scancel", "--signal=KILL", "--full", job)
        self.ask("scancel", job)
        self.wait_for("all jobs have ended", self.done)
        self.assertIn("have no row", (self.folder / "r/slurm/table.txt").read_text())
        kept = self.bench("-j", "2", "--out", "r").stderr
        self.assertRegex(kept, r"^\d+ rows are current and kept")
        self.assertEqual(self.rows("r"), self.rows("whole"))


if __name__ == "__main__":
    unittest.main()
