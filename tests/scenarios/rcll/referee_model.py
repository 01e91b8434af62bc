"""The referee box of the league as a model, to play beside a recorded game (referee_games.py).

Written from the rules of the league and not from the C++ that it checks. Only what comes from outside is taken from the
journal (of level full): instructions, what robots and people put down and take away, reports, faults. States, breaks,
points, verdicts, answers, lights and loads are worked out here and compared, one by one.
"""
import collections
import json
import math
import re

TICK = 0.02
BELT_IN, BELT_OUT, DISPENSE, STORE = 1.538, 2.656, 1.1, 17.5
OPERATE = {"CS": 17.5, "RS": 17.308}
GATE = {1: 3.746, 2: 4.746, 3: 3.983}
RINGS_OF = {"RS1": ("RING_ORANGE", "RING_GREEN"), "RS2": ("RING_BLUE", "RING_YELLOW")}
CAP_OF = {"CS1": "CAP_GREY", "CS2": "CAP_BLACK"}
WORTH = {"C0": 20, "C1": 30, "C2": 50, "C3": 100}
STORED = [f"BASE_{base} CAP_{cap}" for base in ("RED", "SILVER", "BLACK") for cap in ("GREY", "BLACK")]
BUSY = ("PREPARED", "PROCESSING", "PROCESSED")
# Red, yellow, green: 0 off, 1 on, B blinks.
LIGHTS = {"IDLE": "001", "PREPARED": "00B", "PROCESSING": "011", "PROCESSED": "011", "READY-AT-OUTPUT": "01B",
          "WAIT-IDLE": "0BB", "BROKEN": "BB0", "DOWN": "100"}
# While teams explore, by the judgement of a machine's reported zone and rotation; by the rulebook of an idle one.
EXPLORED = {(None, None): "010", (True, None): "0B0", (False, None): "110", (True, False): "1B0"}
# What a reason of the journal must contain, by that of the model.
REASONS = {"stuck": "stuck for 20 s", "reset": "reset", "fault": "fault", "fourth": "fourth", "second": "instructed while"}
ANSWERS = {"stuck": 202, "refused": 103, "piece": 103}
ZONES = {f"{half}_Z{column}{row}" for half in "CM" for column in range(1, 8) for row in range(1, 9)}
NEVER = math.inf


def grid(t):
    """The tick at which something due at t happens."""
    return NEVER if t == NEVER else math.ceil(t / TICK - 1e-6) * TICK


class Machine:
    def __init__(self, game, name, zone, rotation):
        self.game, self.name, self.kind, self.number = game, name, name[2:4], name[2:]
        self.team = {"C": "CYAN", "M": "MAGENTA"}[name[0]]
        self.zone, self.rotation = zone, rotation
        self.x, self.y = (int(zone[3]) - 0.5) * (1 if zone[0] == "C" else -1), int(zone[4]) - 0.5
        self.state = self.hidden = "IDLE"  # `hidden`: what DOWN hides
        self.side = "OUTPUT"               # where it shows what is ready
        self.goal = self.work = None       # `work`: what the hardware does, and when that ends
        self.at = self.since = 0.0         # of the last look, of the phase
        self.belt = {"INPUT": None, "MIDDLE": None, "OUTPUT": None}
        self.downs, self.down_since, self.up = [], None, -1
        self.load = 0                      # unused payments, a buffered cap
        self.paid = 0                      # payments so far
        self.refused_at = None             # payments so far, and those unused, when a ring was not paid for last
        self.said = (None, None)           # of zone and rotation: right or wrong
        self.slots = {(shelf, 1): product.split() for shelf, product in enumerate(STORED)}
        self.first = set(self.slots)  # where those lie that were there at the beginning
        self.seen, self.breaks, self.loads, self.findings = [(-9, "IDLE")], [], [(-9, 0)], [(-9, self.said)]

    # --- States

    def show(self, t):
        state = "DOWN" if self.is_down(t) else self.hidden
        if state != self.state:
            self.state = state
            self.seen.append((t, state))

    def enter(self, t, state):
        self.hidden = state
        self.show(t)

    def step(self, t, state, what=None, seconds=0):
        self.since, self.work = t, (what, grid(t + seconds)) if what else None
        self.enter(t, state)

    def take(self, t, load):
        self.load = load
        self.loads.append((t, load))

    def is_down(self, t):
        return self.game.begin - 1e-9 <= t and any(a <= t + 1e-9 and t < grid(b) - 1e-9 for a, b in self.downs)

    def follow_down(self, t):
        """After it the 20 s of a phase are longer by it; by the rulebook the hardware stood still."""
        if self.is_down(t):
            self.down_since = t if self.down_since is None else self.down_since
        elif self.down_since is not None:
            took, self.down_since, self.up = t - self.down_since, None, t
            self.since += took if self.hidden in BUSY else 0
            if self.game.book and self.work:
                self.work = (self.work[0], self.work[1] + took)

    def break_down(self, t, reason):
        self.game.score(t, self.team, "payment" if self.kind == "RS" else "buffer", -2 * self.load)
        if reason == "stuck" and self.game.book and self.work and self.work[0] in ("in", "gate") and not any(self.belt.values()):
            self.game.score(t, self.team, "penalty", -1)
        self.breaks.append((t, reason))
        if self.goal:
            unpaid = reason == "stuck" and self.kind == "RS" and self.hidden == "PREPARED" and self.work is None
            self.game.answer(self.goal, t, 103 if unpaid else ANSWERS.get(reason, 1))
        self.goal = self.work = None
        self.since, self.belt = t, dict.fromkeys(self.belt)
        self.seen.append((t, "BROKEN"))
        self.state = self.hidden = "BROKEN"
        self.show(t)

    # --- What comes from outside

    def side_of(self, position):
        turn = math.radians(self.rotation)
        along = (position[0] - self.x) * math.cos(turn) + (position[1] - self.y) * math.sin(turn)
        return "INPUT" if along > 0.08 else "OUTPUT" if along < -0.08 else "MIDDLE"

    def lose(self, piece):
        self.belt = {side: None if there == piece else there for side, there in self.belt.items()}
        if self.work and self.work[0] in ("in", "gate") and not self.belt["INPUT"] and not self.belt["MIDDLE"]:
            self.work = (self.work[0], NEVER)

    def pay(self, t):
        """The referee box looks at DOWN alone, and not at what that hides."""
        if self.hidden == "BROKEN" and (self.game.book or self.state == "BROKEN" or self.load == 3):
            return
        if self.load == 3:
            return self.break_down(t, "fourth")
        self.paid += 1
        self.take(t, self.load + 1)
        self.game.score(t, self.team, "payment", 2)

    def known(self, t):
        return not self.game.explores(t) or self.said == (True, True)

    def report(self, t, zone, rotation):
        """The first zone counts, and the first rotation once the zone is right."""
        points, (of_zone, of_rotation) = [], self.said
        if zone and of_zone is None:
            of_zone = zone == self.zone
            points.append(1 if of_zone else -1)
        if rotation >= 0 and of_zone and of_rotation is None:
            of_rotation = rotation == self.rotation
            points.append(1 if of_rotation else -1)
        self.said = (of_zone, of_rotation)
        self.findings.append((t, self.said))
        return points

    def instruct(self, t, goal):
        """The code of the answer, None while it works."""
        operation = goal["operation"]
        if not self.game.production(t):
            return 209
        if operation == "RESET":
            if self.hidden == "BROKEN":
                return 209
            self.break_down(t, "reset")
            return 0
        if not self.known(t):
            return 209
        if self.state != "IDLE":
            if self.game.book and self.state not in ("BROKEN", "DOWN"):
                self.break_down(t, "second")
            return 209
        if operation == "CHANGE_INFO" and (goal["shelf"], goal["slot"]) not in self.slots and goal["shelf"] < 6:
            return 103
        if self.refuses(goal) or self.refuses_unpaid(goal):
            self.break_down(t, "refused")
            return 103
        if operation == "CHANGE_INFO":
            return 0
        self.goal, self.side = goal, goal["side"] if self.kind == "BS" else "OUTPUT"
        takes_in = self.kind == "CS" or operation == "STORE" or self.kind == "RS" and self.is_paid()
        self.step(t, "PREPARED", "in" if takes_in else None, NEVER)
        self.look(t)
        return None

    def refuses(self, goal):
        operation = goal["operation"]
        if self.kind == "BS":
            colors = ("BASE_RED", "BASE_BLACK", "BASE_SILVER")
            return goal["side"] not in ("INPUT", "OUTPUT") or goal["base_color"] not in colors
        if self.kind == "CS":
            return operation != ("RETRIEVE_CAP", "MOUNT_CAP")[self.load]
        if self.kind == "RS":
            return goal["ring_color"] not in RINGS_OF[self.number]
        if self.kind == "DS":
            return goal["order_id"] != 0 and goal["order_id"] not in self.game.orders
        place = (goal["shelf"], goal["slot"])
        return (operation not in ("STORE", "RETRIEVE", "CHANGE_INFO") or place[0] > 5 or place[1] > 7
                or (place in self.slots) == (operation == "STORE"))

    def is_paid(self):
        return self.load >= self.game.price[self.goal["ring_color"]]

    def refuses_unpaid(self, goal):
        """The referee box lets the second instruction in a row wait for payments."""
        if self.kind != "RS" or self.load >= self.game.price[goal["ring_color"]]:
            return False
        again, self.refused_at = self.refused_at == (self.paid, self.load), (self.paid, self.load)
        return self.game.book or not again

    # --- What follows by itself

    def next_time(self):
        times = [self.work[1]] if self.work else []
        if self.hidden in BUSY:
            times += [grid(self.since + 20) + TICK, self.since + TICK]
        if self.hidden == "PREPARED" and self.kind == "DS":
            times.append(self.game.window(self.goal))
        times += [self.since + {"WAIT-IDLE": 5, "BROKEN": 30}.get(self.hidden, 0), self.up + TICK]
        times += [x for down in self.downs for x in down]
        return min((grid(x) for x in times if x < NEVER and grid(x) > self.at + 1e-9), default=NEVER)

    def run_to(self, t):
        while (due := self.next_time()) < t + 1e-9:
            self.at = due
            self.look(due)
        self.at = t
        self.look(t)

    def look(self, t):
        if not self.game.production(t):
            return
        before = None
        while before != (before := (self.hidden, self.work, self.state)):
            self.follow_down(t)
            if not (self.game.book and self.is_down(t)):
                self.run_hardware(t)
            self.show(t)
            if self.is_down(t) or self.up > t - TICK / 2:
                continue  # a state that DOWN hid is seen once before it goes on
            if self.hidden == "BROKEN" and t >= self.since + 30 - 1e-9:
                self.take(t, 0)
                self.enter(t, "IDLE")
            elif self.hidden == "WAIT-IDLE" and t >= self.since + 5 - 1e-9:
                self.enter(t, "IDLE")
            elif self.hidden in BUSY + ("READY-AT-OUTPUT",):
                self.proceed(t)
                waits = self.game.book and self.kind == "DS" and self.hidden == "PREPARED"
                if self.hidden in BUSY and t > self.since + 20 + 1e-9 and not waits:
                    self.break_down(t, "stuck")

    def run_hardware(self, t):
        what, end = self.work or (None, NEVER)
        if what in ("in", "gate") and end == NEVER and (self.belt["INPUT"] or self.belt["MIDDLE"]):
            if what == "gate":
                self.fill_middle()
                end = t + GATE[self.game.orders.get(self.goal["order_id"], {"delivery_gate": 1})["delivery_gate"]]
            else:
                end = t + BELT_IN
            self.work = (what, self.game.really(self, what, t, grid(end)))
        elif end <= t + 1e-9:
            if what == "operate" and self.kind == "SS" and (front := self.blocker()):
                if (place := self.game.moved(t, self, front)) is None:
                    return
                self.slots[place] = self.slots.pop(front)
                self.first = {place if slot == front else slot for slot in self.first}
                what = "move"
            elif self.gives(what):
                if self.belt["MIDDLE"]:
                    return  # something lies there
                place = (self.goal["shelf"], self.goal["slot"])
                stored = self.kind == "SS" and place not in self.first
                piece = self.belt["MIDDLE"] = self.game.comes_out(t, self.name, "storage" if stored else "dispenser")
                self.game.parts[piece] = [self.goal["base_color"]] if self.kind == "BS" else self.slots.pop(place)
                if self.kind == "SS" and place in self.first:
                    self.first.remove(place)
                    self.game.from_storage.add(piece)
            elif what == "operate" and self.kind != "SS" and not self.fits():
                return self.break_down(t, "piece")
            elif what == "in":
                self.fill_middle()
            elif what == "out":
                self.belt[self.side], self.belt["MIDDLE"] = self.belt["MIDDLE"], None
                if self.side == "OUTPUT":
                    self.fill_middle()  # it is one belt
            self.work = (what + " done", NEVER)

    def fill_middle(self):
        if not self.belt["MIDDLE"]:
            self.belt["MIDDLE"], self.belt["INPUT"] = self.belt["INPUT"], None

    def blocker(self):
        """The filled slot before the one that is asked for."""
        front = (self.goal["shelf"], self.goal["slot"] - 1)
        return front if self.goal["slot"] % 2 and front in self.slots else None

    def gives(self, what):
        return what == "operate" and (self.kind == "BS" or self.goal["operation"] == "RETRIEVE")

    def fits(self):
        """Whether cap or ring go on the piece, or a cap comes off it."""
        parts = self.game.parts[self.belt["MIDDLE"]]
        capped = parts[-1].startswith("CAP")
        return capped if self.goal["operation"] == "RETRIEVE_CAP" else not capped and (self.kind == "CS" or len(parts) < 4)

    def proceed(self, t):
        done = self.work[0] if self.work and self.work[0].endswith(" done") else None
        if self.hidden == "READY-AT-OUTPUT":
            if not self.belt[self.side]:
                self.step(t, "WAIT-IDLE")
        elif self.hidden == "PREPARED":
            self.prepared(t, done)
        elif self.hidden == "PROCESSING" and done:
            self.processed(t)
        elif self.hidden == "PROCESSED" and (self.kind == "DS" or self.goal["operation"] == "STORE"):
            if t > self.since + 1e-9:
                self.goal = None
                self.step(t, "WAIT-IDLE")
        elif done == "out done" and self.belt[self.side]:
            self.game.answer(self.goal, t, 0)
            self.goal = None
            self.step(t, "READY-AT-OUTPUT")

    def prepared(self, t, done):
        if self.kind == "DS":
            if t >= self.game.window(self.goal) - 1e-9:
                self.step(t, "PROCESSING", "gate", NEVER)
        elif self.kind == "BS":
            self.step(t, "PROCESSING", "operate", DISPENSE)
        elif self.kind == "RS" and self.work is None:
            if self.is_paid():
                self.work = ("in", NEVER)
                self.run_hardware(t)
        elif done or self.goal["operation"] == "RETRIEVE":
            if self.kind == "RS":
                self.take(t, self.load - self.game.price[self.goal["ring_color"]])
            self.step(t, "PROCESSING", "operate", OPERATE.get(self.kind, STORE))

    def processed(self, t):
        game, piece, operation = self.game, self.belt["MIDDLE"], self.goal["operation"]
        if self.kind == "DS":
            self.belt["MIDDLE"] = None
            game.deliver(t, self.team, self.goal["order_id"], piece)
        elif self.kind == "SS":
            if self.work[0] == "move done":
                return self.step(t, "PROCESSING", "operate", STORE)
            if operation == "STORE":
                self.slots[self.goal["shelf"], self.goal["slot"]] = game.parts[piece]
                self.belt["MIDDLE"] = None
            game.score(t, self.team, "penalty", -5)
        elif operation == "RETRIEVE_CAP":
            game.parts[piece] = game.parts[piece][:-1]
            self.take(t, 1)
            game.score(t, self.team, "buffer", 2)
        elif self.kind != "BS":
            if self.kind == "CS":
                game.capped[piece] = t
            game.parts[piece] = game.parts[piece] + [self.goal["ring_color"] if self.kind == "RS" else CAP_OF[self.number]]
            self.take(t, 0 if self.kind == "CS" else self.load)
        if self.kind == "DS" or operation == "STORE":
            game.answer(self.goal, t, 0)
            return self.step(t, "PROCESSED")
        self.step(t, "PROCESSED", "out", BELT_OUT)
        self.work = ("out", game.really(self, "out", t, self.work[1]))


class Game:
    def __init__(self, folder):
        """The game of a run whose settings of the world are all among its overrides."""
        overrides = dict(o.split("=", 1) for o in json.loads((folder / "manifest.json").read_text())["overrides"])
        self.result = json.loads((folder / "result.json").read_text())
        world = lambda key, default: json.loads(overrides.get("world." + key, default))
        self.book = overrides.get("world.rules") == "rulebook"
        self.physics = self.result["tier"] == "physics"
        self.begin, self.explored = world("setup_s", "0"), 180 if world("exploration", "false") else 0
        self.teams = {"BOTH": ["CYAN", "MAGENTA"]}.get(overrides.get("world.team"), ["CYAN"])
        self.parts, self.from_storage, self.served = {}, set(), set()
        self.scores, self.verdicts, self.answers, self.problems = [], [], {}, []
        self.entries, self.types, self.cycles = (collections.Counter() for _ in range(3))
        self.reported = collections.defaultdict(list)  # by team and type: machines, None for a wrong entry of the type
        self.capped, self.owes_cap = {}, {}  # when pieces got their caps; since when the cap of a surplus product counts
        self.read_game((folder / "game.yaml").read_text())
        self.records = []
        for line in (folder / "journal.jsonl").open():
            if line.startswith(('{"stream":"referee"', '{"stream":"faults"')) or '"kind":"bus"' in line and (
                    "/instruct_machine" in line or '/machine_info","seq"' in line or '/machine_report","seq"' in line):
                record = json.loads(line)
                self.records.append((round(record["t"] / 1e9, 6), record["stream"], record["data"]))
        # What happens to the machines comes before what they are told at that tick.
        self.records.sort(key=lambda r: (r[0], r[1] != "faults" and r[2].get("from") != "gripper"))
        self.end = next(t for t, _, d in self.records if d.get("phase") == "POST_GAME")

    def read_game(self, text):
        found = re.findall(r"machine: (\S+)\n +zone: (\S+)\n +rotation: (\d+)", text)
        self.machines = {name: Machine(self, name, zone, int(turn)) for name, zone, turn in found}
        self.price = {ring: int(price) for ring, price in re.findall(r"  (RING_\w+): (\d)\n", text)}
        self.orders = {}
        for number, block in enumerate(re.findall(r"complexity: C\d.*?competitive: \w+", text, re.S), 1):
            order = {key: float(value) for key, value in re.findall(r"(activate_at|delivery_begin|delivery_end): (\S+)", block)}
            order.update({key: int(value) for key, value in re.findall(r"(delivery_gate|quantity): (\d+)", block)})
            order["complexity"], order["competitive"] = block[12:14], "competitive: true" in block
            order["parts"] = [word for prefix in ("BASE", "RING", "CAP") for word in re.findall(rf"{prefix}_\w+", block)]
            self.orders[number] = order
        if "\novertime:" in text:
            self.orders[number]["overtime"] = True
        for machine, begin, end in re.findall(r"machine: (\w+)\n +begin_s: (\S+)\n +end_s: (\S+)", text):
            for team in "CM":
                self.machines[f"{team}-{machine}"].downs.append((self.begin + float(begin), self.begin + float(end)))

    def production(self, t):
        return self.begin - 1e-9 <= t < self.end - 1e-9

    def explores(self, t):
        return t - self.begin <= self.explored and self.explored

    def window(self, goal):
        return self.begin + self.orders[goal["order_id"]]["delivery_begin"] if goal["order_id"] else 0

    def really(self, machine, what, begin, end):
        """In physics a belt takes as long as it takes: when the journal says so, within a second."""
        state = {"in": "PROCESSING", "out": "READY-AT-OUTPUT", "gate": "PROCESSED"}[what]
        return next((t for t, _, d in self.records if self.physics and d.get("event") == "machine" and t > begin
                     and d["machine"] == machine.name and d["state"] == state and abs(t - end) < 1), end)

    def score(self, t, team, kind, points, order=None):
        if points:
            self.scores.append((t, team, kind, points, order))

    def answer(self, goal, t, code):
        self.answers[goal["id"]] = (t, code)

    def comes_out(self, t, name, source="dispenser"):
        for at, _, d in self.records:
            if abs(at - t) < 0.05 and d.get("from") == source and d["from_name"] == name and d["to"] == "belt":
                return d["piece"]
        self.problems.append(f"{t:.2f} {name}: nothing comes out")
        return -1

    def moved(self, t, machine, front):
        """Where the storage puts what lay in front."""
        for at, _, d in self.records:
            if abs(at - t) < 0.05 and d.get("event") == "relocated" and d["machine"] == machine.name:
                place = (d["shelf"], d["slot"])
                if place in machine.slots or place[1] % 2 and (place[0], place[1] - 1) in machine.slots or (
                        d["from_shelf"], d["from_slot"]) != front or d["product"].split() != machine.slots[front]:
                    self.problems.append(f"{t:.2f} {machine.name}: moved {d}")
                return place
        return None

    def deliver(self, t, team, number, piece):
        if number == 0:
            return
        order, now = self.orders[number], t - self.begin
        begin, end = order["delivery_begin"], order["delivery_end"]
        count = sum(v[4] for v in self.verdicts if v[1:3] == (team, number))
        others = sum(v[4] for v in self.verdicts if v[1] != team and v[2] == number)
        correct = (now >= max(begin, order["activate_at"]) - 1e-9 and self.parts[piece] == order["parts"]
                   and count < order["quantity"] and not (self.book and piece in self.from_storage
                                                         and (team in self.served or "overtime" in order)))
        points = []
        if correct:
            worth, steps = WORTH[order["complexity"]], 5 if self.book else 4
            late = min(steps, max(0, math.ceil((now - end) / ((end - begin) / steps) - 1e-9)))
            less = int(late / steps * 0.75 * worth + 1e-9)
            points = [("delivery", worth), ("late", -less), ("cap", 10)]
            points += [("ring", (5, 10, 20)[self.price[ring]]) for ring in order["parts"][1:-1]]
            if order["competitive"] and not count:
                points.append(("competitive", 10 if not others else -min(10, worth - less) if self.book else -10))
            if piece in self.from_storage:
                self.served.add(team)
                self.owes_cap[team, number] = t
        elif (not self.book and now >= max(begin, order["activate_at"]) - 1e-9 and self.parts[piece] == order["parts"]
              and self.capped.get(piece, -1) > self.owes_cap.get((team, number), NEVER)):
            del self.owes_cap[team, number]
            points = [("cap", 10)]
        for kind, value in points:
            self.score(t, team, kind, value, number)
        self.verdicts.append((t, team, number, piece, correct, sum(value for _, value in points)))

    # --- The game

    def team_of(self, robot):
        return "MAGENTA" if int(robot[5:]) > 3 else self.teams[0]

    def told(self, name):
        return {"cyan": "CYAN", "magenta": "MAGENTA"}.get(name.split("/")[1], self.teams[0])

    def play(self):
        struck = collections.defaultdict(list)
        for t, stream, d in self.records:
            if stream == "faults" and d["fault"].startswith("instruction_"):
                struck[t, d["machine"]].append(d)
            elif d.get("fault") == "machine_down":
                self.machines[d["machine"]].downs.append((t, t + d["seconds"]))
        late = []
        for t, stream, d in self.records:
            while late and late[0][0] < t - 1e-9:
                self.hear(*late.pop(0)[::2])
            before_machines = stream == "faults" or d.get("from") == "gripper"
            for machine in self.machines.values():
                machine.run_to(t - TICK if before_machines else t)
            while late and late[0][0] <= t + 1e-9:
                self.hear(*late.pop(0)[::2])
            if d.get("op") == "goal":
                goal, faults = dict(d["goal"], id=d["goal_id"], team=self.told(d["name"])), struck[t, d["goal"]["machine"]]
                if any(f["fault"] == "instruction_lost" for f in faults):
                    self.answer(goal, t + 10, 2)
                elif faults:
                    late = sorted([*late, (grid(t + sum(f["seconds"] for f in faults)), len(late), goal)], key=lambda x: x[:2])
                else:
                    self.hear(t, goal)
            elif d.get("op") == "publish" and d["name"].endswith("/machine_report"):
                for entry in d["msg"]["machines"] if d["msg"]["team_color"] in ("", self.told(d["name"])) else ():
                    self.report(t, self.told(d["name"]), entry)
            elif d.get("fault") == "machine_breaks" and d["acted"]:
                self.machines[d["machine"]].break_down(t, "fault")
            elif d.get("event") == "piece":
                self.piece(t, d)
            elif d.get("event") == "maintenance" and d["state"] == "begin":
                self.cycles[d["robot"]] += 1
                self.score(t, d["team"], "penalty", -5 * (self.cycles[d["robot"]] == 2))

    def hear(self, t, goal):
        machine = self.machines.get(goal["machine"])
        if machine:
            machine.run_to(t)
        code = 203 if machine is None else 101 if machine.team != goal["team"] else machine.instruct(t, goal)
        if code is not None:
            self.answer(goal, t, code)

    def may_report(self, team, kind, machine):
        """The referee box: as many machines of a type as the team has."""
        of_type = self.reported[team, kind]
        if machine is None or machine not in of_type:
            if len(of_type) == sum((m.team, m.kind) == (team, kind) for m in self.machines.values()):
                return False
            of_type.append(machine)
        return True

    def report(self, t, team, entry):
        if not self.explores(t) or not self.production(t) or self.book and self.entries[team] == 14:
            return
        named, of_type, points = self.machines.get(entry["name"]), (team, entry["type"]), []
        mine = [m for m in self.machines.values() if (m.team, m.kind) == of_type]
        if named:
            if not self.book and not self.may_report(team, named.kind, named):
                return
            sensible = named.team == team and (not entry["zone"] or entry["zone"] in ZONES)
            points = named.report(t, entry["zone"], entry["rotation"]) if sensible else []
            self.entries[team] += bool(points)
        elif not entry["name"] and mine and entry["zone"] in ZONES and not self.types[of_type, entry["zone"]]:
            there = [m for m in self.machines.values() if m.kind == entry["type"] and m.zone == entry["zone"]
                     and (m.team == team or not self.book)]
            if self.types[of_type] == len(mine) if self.book else not self.may_report(*of_type, there[0] if there else None):
                return
            self.entries[team] += 1
            self.types.update([of_type, (of_type, entry["zone"])])
            points = [] if there else [-1]
        for value in points:
            self.score(t, team, "exploration", value)

    def piece(self, t, d):
        piece, source, target = d["piece"], d["from"], d["to"]
        if source == "dispenser" and target == "slot":
            self.parts[piece] = ["BASE_CLEAR", CAP_OF[d["from_name"][2:]]]
        foreign = (self.book and source == "gripper" and target in ("belt", "slide") and
                   self.machines[d["to_name"].removesuffix("-SLIDE")].team != self.team_of(d["from_name"]))
        if source == "gripper" and self.book and self.production(t):
            if target == "floor":
                self.score(t, self.team_of(d["from_name"]), "penalty", -10)
            elif foreign:
                self.score(t, self.team_of(d["from_name"]), "penalty", -20)
        if source == "gripper" and target == "belt":
            machine = self.machines[d["to_name"]]
            machine.belt[machine.side_of(d["position"])] = piece
            machine.look(t)
        elif source == "gripper" and target == "slide" and not foreign:
            counted = (at for at, _, r in self.records if r.get("kind") == "payment" and t <= at < t + 0.3)
            self.machines[d["to_name"][:-6]].pay(next(counted, t) if self.physics else t)
        elif source == "belt" and target in ("gripper", "floor"):
            self.machines[d["from_name"]].lose(piece)
            self.machines[d["from_name"]].look(t)

    # --- What differs

    def compare(self):
        told = collections.defaultdict(list)
        for t, _, d in self.records:
            event = d.get("event")
            if event == "machine":
                told[d["machine"]].append((t, d["state"]))
            elif event == "broken":
                told["breaks of " + d["machine"]].append((t, d["reason"]))
            elif event == "score":
                told["points"].append((t, d["team"], d["kind"], d["points"], d.get("order")))
            elif event == "delivery":
                told["deliveries"].append((t, d["team"], d["order"], d["piece"], d["correct"], d["points"]))
            elif event == "order":
                told["orders"].append((t, d["order"]))
            elif d.get("op") == "result":
                told["answers"].append((t, d["goal_id"], d["result"]["error_code"]))
            elif d.get("op") == "publish" and d["name"].endswith("/machine_info"):
                self.look_at(t, d["msg"]["machines"])
        for name, machine in self.machines.items():
            self.in_turn(name, machine.seen[1:], told[name])
            self.in_turn("breaks of " + name, machine.breaks, told["breaks of " + name],
                         lambda want, have: REASONS.get(want[0], "") in have[0])
        self.in_turn("deliveries", self.verdicts, told["deliveries"])
        self.as_sets("points", self.scores, told["points"])
        due = [(self.begin + order["activate_at"], number) for number, order in self.orders.items()]
        self.as_sets("orders", [o for o in due if o[0] < self.end], told["orders"])
        last = self.end - 0.1
        self.as_sets("answers", [(t, goal, code) for goal, (t, code) in self.answers.items() if t < last],
                     [a for a in told["answers"] if a[0] < last])
        for team, of_team in self.result["teams"].items():
            if of_team["points"] != (points := sum(s[3] for s in self.scores if s[1] == team)):
                self.problems.append(f"{team} has {of_team['points']} points, not {points}")
        return self.problems

    def in_turn(self, what, want, have, same=lambda want, have: want == have):
        for i in range(max(len(want), len(have))):
            w, h = (x[i] if i < len(x) else None for x in (want, have))
            if not (w and h) or abs(w[0] - h[0]) > self.slack() or not same(w[1:], h[1:]):
                a, b = max(i - 1, 0), i + 1
                return self.problems.append(f"{what}: by the rules {want[a:b]}, in the journal {have[a:b]}")

    def as_sets(self, what, want, have):
        left = list(have)
        for w in want:
            there = next((h for h in left if abs(h[0] - w[0]) < 0.05 and h[1:] == w[1:]), None)
            left.remove(there) if there else self.problems.append(f"{what}: {w} is missing")
        self.problems += [f"{what}: {h} is too much" for h in left]

    def slack(self):
        return 0.05 if self.physics else TICK * 1.05

    def look_at(self, t, machines):
        def around(values):
            """What holds at t, or within two ticks."""
            return {x for at, x in values if abs(at - t) < 0.045} | {[x for at, x in values if at <= t - 0.035][-1]}
        for said in machines:
            machine = self.machines[said["name"]]
            lights = {LIGHTS[said["state"]]}
            if self.explored and (said["state"] == "IDLE" or not self.book) and t - self.begin < 180.03:
                found = {LIGHTS[said["state"]] if x == (True, True) else EXPLORED[x] for x in around(machine.findings)}
                lights = found | lights if t - self.begin > 179.97 else found
            if t < self.begin + 0.03:
                lights = {"111", "000"} | lights  # set-up, and before it
            if t > self.end - 0.05:
                lights = {"B00"} | lights
            shown = "".join({"OFF": "0", "ON": "1", "BLINK": "B"}[light["state"]] for light in said["lights"])
            loads = around(machine.loads)
            states = around(machine.seen)
            if said["state"] not in states or shown not in lights or said["loaded_with"] not in loads:
                have = f"{said['name']}: {said['state']} {shown} with {said['loaded_with']}"
                return self.problems.append(f"{t:.2f} {have}, by the rules {states} {lights} with {loads}")
