import enum
import os
import subprocess
import time
from fractions import Fraction

from unified_planning.plans import PartialOrder, Sequence, Timed


class PlanGenerationResultStatus(enum.Enum):
    SOLVED_SATISFICING = 1
    UNSOLVABLE_PROVEN = 2
    UNSOLVABLE_INCOMPLETELY = 3
    TIMEOUT = 4
    MEMOUT = 5
    INTERNAL_ERROR = 6
    UNSUPPORTED_PROBLEM = 7


class Message:
    def __init__(self, message):
        self.message = message


class Result:
    def __init__(self, status, plan=None, messages=()):
        self.status, self.plan, self.log_messages = status, plan, list(map(Message, messages))


class Engine:
    features = {"DURATIVE", "INTEGER_FLUENTS"}
    skip_checks = False

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def supported_kind(self):
        return type("Kind", (), {"features": self.features})

    def solve(self, task, timeout=None):
        assert self.skip_checks
        return self.answer(task)

    def get_solutions(self, task, timeout=None):
        yield self.answer(task)
        yield Result(PlanGenerationResultStatus.SOLVED_SATISFICING, Timed((0, "go a b", Fraction(1, 2))))


class Aries(Engine):
    """Builds the tower of the blocksworld example; only whole numbers."""

    def answer(self, task):
        assert "REAL_FLUENTS" not in task.kind.features
        steps = [("unstack c a", 3), ("put-down c", 2), ("pick-up b", 2), ("stack b c", 3), ("pick-up a", 2), ("stack a b", 3)]
        timed, start = [], Fraction(0)
        for text, duration in steps:
            timed.append((start, text, Fraction(duration)))
            start += duration + Fraction(1, 100)
        return Result(PlanGenerationResultStatus.SOLVED_SATISFICING, Timed(*timed))


class Tamer(Engine):
    """Supports nothing, and finds nothing."""

    features = set()

    def answer(self, task):
        return Result(PlanGenerationResultStatus.UNSOLVABLE_PROVEN)


class Classical(Engine):
    def answer(self, task):
        return Result(PlanGenerationResultStatus.SOLVED_SATISFICING, Sequence("go a b", "stop"))


class Ordered(Engine):
    def answer(self, task):
        return Result(PlanGenerationResultStatus.SOLVED_SATISFICING, PartialOrder())


class Broken(Engine):
    def answer(self, task):
        raise RuntimeError("something\n broke")


class Sleepy(Engine):
    """Leaves a process behind that would go on for a minute; its number is in the file that SLEEPER names."""

    def answer(self, task):
        sleeper = subprocess.Popen(["sleep", "60"])
        with open(os.environ["SLEEPER"], "w") as out:
            out.write(str(sleeper.pid))
        time.sleep(60)


class Status(Engine):
    def answer(self, task):
        return Result(PlanGenerationResultStatus[os.environ["STATUS"]], None, ["the reason"])
