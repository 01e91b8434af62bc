from unified_planning import engines


class TypeManager:
    def RealType(self, lower_bound=None, upper_bound=None):
        return "real"

    def IntType(self, lower_bound=None, upper_bound=None):
        return "integer"


class Factory:
    def __init__(self, environment):
        self.environment = environment
        self.classes = {"aries": engines.Aries, "tamer": engines.Tamer}

    @property
    def engines(self):
        return list(self.classes)

    def add_engine(self, name, module, class_name):
        self.classes[name] = getattr(__import__(module, fromlist=["*"]), class_name)

    def engine(self, name):
        return self.classes[name]()

    def OneshotPlanner(self, name):
        return self.engine(name)

    AnytimePlanner = OneshotPlanner


class Environment:
    def __init__(self):
        self.type_manager = TypeManager()
        self.factory = Factory(self)


ENVIRONMENT = Environment()


def get_environment():
    return ENVIRONMENT
