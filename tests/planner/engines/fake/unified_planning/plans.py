import enum


class PlanKind(enum.Enum):
    SEQUENTIAL_PLAN = 1


class Action:
    def __init__(self, name):
        self.name = name


class Call:
    def __init__(self, text):
        name, *self.actual_parameters = text.split()
        self.action = Action(name)


class Timed:
    def __init__(self, *steps):
        self.timed_actions = [(start, Call(text), duration) for start, text, duration in steps]


class Sequence:
    def __init__(self, *texts):
        self.actions = [Call(text) for text in texts]


class PartialOrder:
    def convert_to(self, kind, task):
        assert kind == PlanKind.SEQUENTIAL_PLAN
        return Sequence("go a b", "go b c")
