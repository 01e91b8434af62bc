"""Runs a program with a limit on its CPU time, and notices when it first did something."""

import dataclasses
import os
import pathlib
import signal
import subprocess
import time

TICK = os.sysconf("SC_CLK_TCK")


@dataclasses.dataclass
class Ended:
    code: int = 0            # exit code, or minus the signal
    in_time: bool = True     # False: it was ended at its limit
    cpu: float = 0           # s, of all its processes
    wall: float = 0
    first_cpu: float = None  # s when the sign was first seen; None: never
    first_wall: float = None


def session_cpu(session):
    """CPU seconds of the living processes of a session and of their children that have been waited for."""
    ticks = 0
    for process in filter(str.isdigit, os.listdir("/proc")):
        try:
            fields = pathlib.Path("/proc", process, "stat").read_text().rpartition(")")[2].split()
        except OSError:  # it has ended meanwhile
            continue
        if int(fields[3]) == session:
            ticks += sum(map(int, fields[11:15]))
    return ticks / TICK


def run(command, log, cpu_limit, wall_limit, sign=lambda: False, core=None, folder=None, environment=None):
    """Runs `command`, which prints to the file `log`, in a session of its own that ends with it or at a limit (s).
    `sign()` is asked every few milliseconds until it is true."""
    ended, began = Ended(), time.monotonic()
    with open(log, "wb") as out:
        child = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=out, stderr=subprocess.STDOUT, start_new_session=True, cwd=folder,
                                 env={**os.environ, **(environment or {})}, preexec_fn=None if core is None else lambda: os.sched_setaffinity(0, {core}))
    usage, checked = None, 0.0
    while usage is None:
        process, status, used = os.wait4(child.pid, os.WNOHANG)
        if process:
            usage = used
            child.returncode = ended.code = os.waitstatus_to_exitcode(status)
        elapsed = time.monotonic() - began
        if ended.first_wall is None and sign():
            ended.first_wall = elapsed
            ended.first_cpu = usage.ru_utime + usage.ru_stime if usage else session_cpu(child.pid)
        if usage is None and elapsed - checked > 0.1:
            checked = elapsed
            ended.cpu = session_cpu(child.pid)
            if ended.cpu > cpu_limit or elapsed > wall_limit:
                ended.in_time = False
                os.killpg(child.pid, signal.SIGKILL)
        time.sleep(0.005)
    try:
        os.killpg(child.pid, signal.SIGKILL)  # what it left running
    except ProcessLookupError:
        pass
    ended.cpu, ended.wall = max(ended.cpu, usage.ru_utime + usage.ru_stime), time.monotonic() - began
    return ended
