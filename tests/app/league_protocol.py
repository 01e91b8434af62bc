"""The protocol of the league: the small shipped agent plays with it, and a program outside speaks it over sockets.
That program uses Python's protobuf and cryptography, and frames written here."""

import json
import pathlib
import random
import re
import shutil
import signal
import socket
import struct
import subprocess
import tempfile
import time
import unittest

from google.protobuf import descriptor_pb2, descriptor_pool, message_factory

import protobuf_peers as wire
from lab import CXLAB, SOURCE

EXAMPLE = SOURCE / "docs/examples/league"
PROTOS = SOURCE / "cx/packages/rcll_protobuf_msgs/rcll-protobuf-msgs"


def run(*args, cwd):
    return subprocess.run([CXLAB, *args], cwd=cwd, text=True, timeout=100, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)


# --- Messages

def read_protos():
    """All messages of the .proto files: classes by name."""
    kinds = descriptor_pb2.FieldDescriptorProto
    scalars = {name: getattr(kinds, "TYPE_" + name.upper())
               for name in ("string", "bool", "float", "uint32", "uint64", "int64", "int32", "double")}
    labels = {name: getattr(kinds, "LABEL_" + name.upper()) for name in ("required", "optional", "repeated")}
    file = descriptor_pb2.FileDescriptorProto(name="all.proto", package="llsf_msgs")
    enums, fields = set(), []

    def read(tokens, message, scope):
        while tokens and tokens[0] != "}":
            word = tokens.pop(0)
            if word in ("message", "enum"):
                name = tokens.pop(0)
                assert tokens.pop(0) == "{"
                if word == "message":
                    read(tokens, (message.nested_type if message else file.message_type).add(name=name), [*scope, name])
                else:
                    enums.add(".".join([*scope, name]))
                    values = (message or file).enum_type.add(name=name)
                    while tokens[0] != "}":
                        value, equals, number, end = tokens[:4]
                        assert (equals, end) == ("=", ";"), tokens[:4]
                        values.value.add(name=value, number=int(number))
                        del tokens[:4]
                assert tokens.pop(0) == "}"
            elif word in labels:
                type_name, name, equals, number = tokens[:4]
                assert equals == "="
                del tokens[:tokens.index(";") + 1]
                field = message.field.add(name=name, number=int(number), label=labels[word])
                fields.append((field, type_name, scope))
            else:  # syntax, package, import
                del tokens[:tokens.index(";") + 1]

    for path in sorted(PROTOS.glob("*.proto")):
        text = re.sub("//.*", "", path.read_text())
        read(re.findall(r'"[^"]*"|[\w.]+|[{}=;\[\]]', text), None, ["llsf_msgs"])
    for field, type_name, scope in fields:
        if type_name in scalars:
            field.type = scalars[type_name]
            continue
        full = next((name for name in (".".join([*scope, type_name]), "llsf_msgs." + type_name) if name in enums), None)
        field.type = kinds.TYPE_ENUM if full else kinds.TYPE_MESSAGE
        field.type_name = "." + (full or "llsf_msgs." + type_name)
    pool = descriptor_pool.DescriptorPool()
    pool.Add(file)
    classes = {}
    for message in file.message_type:
        descriptor = pool.FindMessageTypeByName("llsf_msgs." + message.name)
        classes[message.name] = (message_factory.GetMessageClass(descriptor) if hasattr(message_factory, "GetMessageClass")
                                 else message_factory.MessageFactory(pool).GetPrototype(descriptor))
    return classes


CLASSES = read_protos()


def key_of(descriptor):
    numbers = descriptor.enum_types_by_name["CompType"].values_by_name
    return numbers["COMP_ID"].number, numbers["MSG_TYPE"].number


BY_KEY = {key_of(c.DESCRIPTOR): c for c in CLASSES.values() if "CompType" in c.DESCRIPTOR.enum_types_by_name}
CBC = 2  # aes-128-cbc


class Peer:
    """A UDP socket of a program outside: it hears on a port of the referee box's choice."""

    def __init__(self, send, receive, cipher=0):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", receive))
        self.to = ("127.0.0.1", send)
        self.cipher = cipher

    def say(self, message, phrase=b"randomkey"):
        self.raw(wire.frame(message, self.cipher, phrase, key_of(message.DESCRIPTOR)))

    def raw(self, data):
        self.socket.sendto(data, self.to)

    def hear(self, wanted, seconds=20):
        """The next message that `wanted` accepts."""
        end = time.monotonic() + seconds
        while True:
            self.socket.settimeout(max(0.001, end - time.monotonic()))
            data = self.socket.recv(65536)
            head, payload = data[:8], data[8:]
            assert head == struct.pack(">BBBBI", 2, self.cipher, 0, 0, len(payload)), head
            if self.cipher:
                decryptor, pad = wire.engine(self.cipher, b"randomkey", payload[:16]).decryptor(), wire.padding.PKCS7(128).unpadder()
                payload = pad.update(decryptor.update(payload[16:]) + decryptor.finalize()) + pad.finalize()
            message = BY_KEY[struct.unpack(">HH", payload[:4])].FromString(payload[4:])
            if wanted(message):
                return message


def of_type(name):
    return lambda message: message.DESCRIPTOR.name == name


def free_shift():
    """To be added to all ports, so that nobody has them."""
    udp = [4441, 4442, 4444, 4445, 4446, 4447, *range(2116, 2119), *range(2126, 2129)]
    while True:
        shift = random.randrange(10000, 50000)
        try:
            held = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in udp]
            for held_one, port in zip(held, udp):
                held_one.bind(("127.0.0.1", port + shift))
            socket.create_server(("127.0.0.1", 4444 + shift)).close()
            return shift
        except OSError:
            pass
        finally:
            for held_one in held:
                held_one.close()


class Game(unittest.TestCase):
    """A game of the timed tier on sockets, in a folder of its own."""

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="cxlab-league-"))
        self.addCleanup(shutil.rmtree, self.folder)
        self.shift = free_shift()

    def start(self, world, refbox=""):
        (self.folder / "game.yaml").write_text(
            f"schema: 1\nworld: {{kind: rcll, information: league, complexities: [C0], down: false, {world}\n"
            f"  refbox: {{{refbox}port_shift: {self.shift}}}}}\ntier: timed\n")
        self.log = open(self.folder / "log", "w+")
        self.addCleanup(self.log.close)
        self.game = subprocess.Popen([CXLAB, "run", "game.yaml", "--sockets", "--until", "200", "--out", "out"],
                                     cwd=self.folder, stdout=subprocess.DEVNULL, stderr=self.log)
        self.addCleanup(self.game.wait)
        self.addCleanup(self.game.kill)


class Outside(Game):
    """A program outside is the agent of a game that has none."""

    def setUp(self):
        super().setUp()
        shift = self.shift
        self.public = Peer(4445 + shift, 4444 + shift)
        self.cyan = Peer(4446 + shift, 4441 + shift, CBC)
        self.robot = Peer(2126 + shift, 2116 + shift)
        self.stream_port = 4444 + shift
        for peer in (self.public, self.cyan, self.robot):
            self.addCleanup(peer.socket.close)
        self.start("", "team_cyan: Pythons, ")

    def test_short_plays(self):
        state = self.public.hear(of_type("GameState"))
        self.assertEqual((state.team_cyan, state.phase, state.state), ("Pythons", 30, 2))
        self.assertGreater(self.public.hear(of_type("OrderInfo")).orders[0].delivery_period_end, 0)
        self.assertEqual(self.public.hear(of_type("BeaconSignal")).peer_name, "RefBox")
        info = self.cyan.hear(of_type("MachineInfo"))
        self.assertEqual(sorted(machine.name for machine in info.machines),
                         ["C-BS", "C-CS1", "C-CS2", "C-DS", "C-RS1", "C-RS2", "C-SS"])
        self.assertEqual(len(self.cyan.hear(of_type("RingInfo")).rings), 4)

        prepare = CLASSES["PrepareMachine"](team_color=0, machine="C-BS", sent_at=int(time.time()))
        prepare.instruction_bs.side, prepare.instruction_bs.color = 2, 1
        for peer, phrase in ((self.public, b""), (self.cyan, b"another")):
            peer.say(prepare, phrase)  # not there, not with that key
        self.cyan.raw(b"\2\2\0\0\0\0\0\4abcd")
        with self.subTest("nothing comes of it"), self.assertRaises(TimeoutError):
            self.cyan.hear(lambda m: of_type("MachineInfo")(m) and any(x.state != "IDLE" for x in m.machines), 1)
        self.cyan.say(prepare)
        for wanted in ("PROCESSING", "READY-AT-OUTPUT"):
            self.cyan.hear(lambda m: of_type("MachineInfo")(m) and any(
                x.name == "C-BS" and x.state == wanted for x in m.machines))

        task = CLASSES["AgentTask"](team_color=0, task_id=7, robot_id=1)
        task.move.waypoint = "C_Z52"
        self.robot.say(task)
        self.assertEqual(self.robot.hear(lambda m: of_type("BeaconSignal")(m) and m.HasField("task")).task.task_id, 7)
        answer = self.robot.hear(of_type("AgentTask"))
        self.assertEqual((answer.task_id, answer.successful, answer.error_code), (7, True, 0))

        flood = wire.frame(prepare, CBC, b"another", key_of(prepare.DESCRIPTOR))
        for peer in (self.public, self.cyan):
            for _ in range(2000):
                peer.raw(flood)
        with socket.create_connection(("127.0.0.1", self.stream_port), 20) as controller:
            controller.sendall(wire.frame(CLASSES["SetTeamName"](team_name="Snakes", team_color=0), key=(2000, 82)))
            self.public.hear(lambda m: of_type("GameState")(m) and m.team_cyan == "Snakes")
        self.game.send_signal(signal.SIGINT)
        self.assertEqual(self.game.wait(30), 130, (self.folder / "log").read_text())
        said = (self.folder / "log").read_text()
        for text in ("public channel: found a llsf_msgs.PrepareMachine", "channel of CYAN: Decryption failed"):
            self.assertIn(text, said)
        result = json.loads((self.folder / "out/result.json").read_text())
        self.assertIs(result["deterministic"], False)
        self.assertEqual(result["robots"][0]["skills"], 1)


class Stream:
    """A controller of the referee box: frames over TCP."""

    def __init__(self, port):
        self.socket = socket.create_connection(("127.0.0.1", port), 20)
        self.bytes = b""

    def say(self, name, **fields):
        message = CLASSES[name](**fields)
        self.socket.sendall(wire.frame(message, key=key_of(message.DESCRIPTOR)))

    def hear(self, name, wanted=lambda message: True, seconds=20):
        end = time.monotonic() + seconds
        while True:
            if len(self.bytes) >= 8 and len(self.bytes) >= 8 + struct.unpack(">I", self.bytes[4:8])[0]:
                size = struct.unpack(">I", self.bytes[4:8])[0]
                payload, self.bytes = self.bytes[8:8 + size], self.bytes[8 + size:]
                message = BY_KEY[struct.unpack(">HH", payload[:4])].FromString(payload[4:])
                if message.DESCRIPTOR.name == name and wanted(message):
                    return message
                continue
            self.socket.settimeout(max(0.001, end - time.monotonic()))
            more = self.socket.recv(65536)
            if not more:
                raise EOFError
            self.bytes += more

    def hear_machine(self, machine, state):
        """The machine, once it is in that state."""
        info = self.hear("MachineInfo", lambda m: any((x.name, x.state) == (machine, state) for x in m.machines))
        return next(x for x in info.machines if x.name == machine)


class Controller(Game):
    """A program outside commands a game as controllers of the referee box do."""

    def connect(self):
        end = time.monotonic() + 20
        while True:
            try:
                stream = Stream(4444 + self.shift)
                break
            except ConnectionRefusedError:
                if time.monotonic() > end:
                    raise
                time.sleep(0.05)
        self.addCleanup(stream.socket.close)
        return stream

    def test_short_ends_set_up_and_the_game(self):
        self.start("setup_s: 100, exploration: true, ")
        controller = self.connect()
        other = self.connect()
        self.assertEqual(controller.hear("GameState").phase, 10)
        ended = time.monotonic()
        controller.say("SetGamePhase", phase=30)
        state = controller.hear("GameState", lambda m: m.phase == 30)
        self.assertLess(state.game_time.sec, 3, "production begins when the controller says so")
        self.assertLess(time.monotonic() - ended, 5)
        other.hear("GameState", lambda m: m.phase == 30)
        controller.hear("OrderInfo", lambda m: len(m.orders) == 2)
        self.assertEqual(len(controller.hear("RingInfo").rings), 4)
        self.assertEqual(controller.hear("MachineReportInfo").team_color, 0)

        machines = controller.hear("MachineInfo").machines
        self.assertEqual(len(machines), 14)
        for machine in machines:
            self.assertTrue(machine.HasField("zone") and machine.HasField("pose") and len(machine.lights) == 3, machine)
            self.assertFalse(machine.correctly_reported)
        robots = controller.hear("RobotInfo").robots
        self.assertEqual([robot.number for robot in robots], [1, 2, 3])
        self.assertTrue(all(robot.HasField("pose") and abs(robot.pose.x) > 1 for robot in robots))

        team = Peer(4446 + self.shift, 4441 + self.shift, CBC)
        self.addCleanup(team.socket.close)
        prepare = CLASSES["PrepareMachine"](team_color=0, machine="C-BS", sent_at=int(time.time()))
        prepare.instruction_bs.side, prepare.instruction_bs.color = 2, 1
        team.say(prepare)
        told = controller.hear("AttentionMessage")
        self.assertEqual((told.team_color, told.message), (0, "C-BS: C-BS is not reported right, and exploration goes on"))

        controller.say("SetGamePhase", phase=10)   # no phase comes again
        controller.say("SetGamePhase", phase=20)
        controller.say("SetGameState", state=2)    # it is RUNNING
        controller.say("RandomizeField")
        controller.say("SetTeamName", team_name="Snakes", team_color=1)  # who does not play
        controller.say("ConfirmDelivery", delivery_id=1, correct=True)
        controller.say("SetGamePhase", phase=40)
        self.assertEqual(self.game.wait(30), 0)
        result = json.loads((self.folder / "out/result.json").read_text())
        self.assertEqual(result["status"], "completed")
        self.assertLess(result["sim_time_s"], 60)
        said = (self.folder / "log").read_text()
        for text in ("SetGamePhase is refused: the game is in PRODUCTION, and no phase comes again",
                     "SetGamePhase is refused: found EXPLORATION, expected SETUP, PRODUCTION or POST_GAME",
                     "RandomizeField is refused: the field is laid before the game",
                     "SetTeamName is refused: MAGENTA does not play",
                     "ConfirmDelivery is refused: what lies under a gate is seen"):
            self.assertIn(text, said)
        self.assertNotIn("SetGameState", said)

    def test_short_pauses_the_game(self):
        self.start("")
        controller = self.connect()
        controller.hear("GameState", lambda m: m.state == 2)
        controller.say("SetGameState", state=3)
        paused = controller.hear("GameState", lambda m: m.state == 3)
        time.sleep(2)
        team = Peer(4446 + self.shift, 4441 + self.shift, CBC)
        self.addCleanup(team.socket.close)
        prepare = CLASSES["PrepareMachine"](team_color=0, machine="C-BS", sent_at=int(time.time()))
        prepare.instruction_bs.side, prepare.instruction_bs.color = 2, 1
        team.say(prepare)
        self.assertEqual(controller.hear("AttentionMessage").message, "C-BS: the game is paused")
        later = controller.hear("GameState")
        self.assertEqual((later.state, later.game_time), (3, paused.game_time))
        controller.say("SetGameState", state=0)
        controller.say("SetGameState", state=2)
        controller.hear("GameState", lambda m: m.state == 2 and m.game_time.sec > paused.game_time.sec)
        controller.say("SetGamePhase", phase=40)
        self.assertEqual(self.game.wait(30), 0)
        self.assertIn("SetGameState is refused: state: found 'INIT', expected RUNNING or PAUSED",
                      (self.folder / "log").read_text())

    def test_short_breaks_and_repairs_machines(self):
        self.start("")
        controller = self.connect()
        controller.hear_machine("C-BS", "IDLE")
        team = Peer(4446 + self.shift, 4441 + self.shift, CBC)
        self.addCleanup(team.socket.close)
        prepare = CLASSES["PrepareMachine"](team_color=0, machine="C-BS", sent_at=int(time.time()))
        prepare.instruction_bs.side, prepare.instruction_bs.color = 2, 3
        team.say(prepare)
        pieces = controller.hear("WorkpieceInfo", lambda m: len(m.workpieces) == 1).workpieces
        self.assertEqual((pieces[0].at_machine, pieces[0].base_color, pieces[0].team_color), ("C-BS", 3, 0))
        controller.say("SetMachineState", machine_name="C-BS", state=15)
        lights = {light.color: light.state for light in controller.hear_machine("C-BS", "BROKEN").lights}
        self.assertEqual(lights, {0: 2, 1: 2, 2: 0})
        broken = time.monotonic()
        controller.say("SetMachineState", machine_name="C-BS", state=1)
        controller.hear_machine("C-BS", "IDLE")
        self.assertLess(time.monotonic() - broken, 15, "it need not wait for 30 s")
        controller.hear("WorkpieceInfo", lambda m: not m.workpieces)
        controller.say("SetMachineState", machine_name="C-BS", state=1)
        controller.say("SetMachineState", machine_name="C-CS9", state=15)
        controller.say("SetMachineState", machine_name="C-CS1", state=3)

        # Robot 2 is there once, and is heard no more.
        beacon = CLASSES["BeaconSignal"](seq=1, number=2, team_name="CYAN", peer_name="R-2", team_color=0)
        beacon.time.sec, beacon.time.nsec = int(time.time()), 0
        team.say(beacon)
        controller.hear("RobotInfo", lambda m: any(robot.name == "R-2" for robot in m.robots))

        robot = Peer(2126 + self.shift, 2116 + self.shift)
        self.addCleanup(robot.socket.close)
        task = CLASSES["AgentTask"](team_color=0, task_id=5, robot_id=1)
        task.move.waypoint = "C_Z54"
        robot.say(task)
        where = lambda: robot.hear(lambda m: of_type("BeaconSignal")(m) and m.HasField("task")).pose
        first = where()
        task.pause_task = True
        robot.say(task)
        where(), where()
        rests = where()
        self.assertNotEqual((first.x, first.y), (rests.x, rests.y), "it was on its way")
        then = where()
        self.assertEqual((then.x, then.y), (rests.x, rests.y))
        task.pause_task = False
        robot.say(task)
        answer = robot.hear(of_type("AgentTask"))
        self.assertEqual((answer.task_id, answer.successful, answer.error_code), (5, True, 0))
        lost = controller.hear("AttentionMessage", lambda m: "lost" in m.message)
        self.assertEqual(lost.message, "robot 2 of CYAN is lost: no beacon for 5 s")
        moved = lambda pose: abs(pose.x - then.x) + abs(pose.y - then.y) > 0.1
        arrived = controller.hear("RobotInfo", lambda m: moved(m.robots[0].pose)).robots[0]
        self.assertEqual((arrived.number, arrived.HasField("pose")), (1, True))

        self.game.send_signal(signal.SIGINT)
        self.assertEqual(self.game.wait(30), 130)
        said = (self.folder / "log").read_text()
        for text in ("C-BS is IDLE, not BROKEN", "C-CS9", "found PROCESSED, expected RESET or IDLE"):
            self.assertIn(text, said)

    def test_short_there_may_be_none(self):
        self.start("")
        (self.folder / "game.yaml").write_text((self.folder / "game.yaml").read_text().replace("port_shift", "controllers: false, port_shift"))
        self.game.kill()
        self.game.wait()
        game = subprocess.Popen([CXLAB, "run", "game.yaml", "--sockets", "--until", "3", "--out", "none"], cwd=self.folder,
                                stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        self.addCleanup(game.stderr.close)
        public = Peer(4445 + self.shift, 4444 + self.shift)
        self.addCleanup(public.socket.close)
        public.hear(of_type("GameState"))
        with self.assertRaises(ConnectionRefusedError):
            Stream(4444 + self.shift)
        game.communicate(timeout=30)


CONFIRMING = """
(deffacts start (open))
(defrule open
  ?f <- (open)
  =>
  (retract ?f)
  (pb-connect "127.0.0.1" 4444))
(defrule confirm
  (protobuf-msg (type "llsf_msgs.OrderInfo") (client-id ?client) (ptr ?info))
  =>
  (foreach ?order (pb-field-list ?info "orders")
    (foreach ?delivery (pb-field-list ?order "unconfirmed_deliveries")
      (printout t "delivery " (pb-field-value ?delivery "id") " of " (pb-field-value ?delivery "team") crlf)
      (bind ?word (pb-create "llsf_msgs.ConfirmDelivery"))
      (pb-set-field ?word "delivery_id" (pb-field-value ?delivery "id"))
      (pb-set-field ?word "correct" CORRECT)
      (pb-send ?client ?word)
      (pb-destroy ?word)
      (pb-destroy ?delivery))
    (pb-destroy ?order)))
"""


class Inside(unittest.TestCase):
    def test_short_an_agent_confirms_deliveries(self):
        """Without its word a product counts nothing, whatever it is."""
        with tempfile.TemporaryDirectory(prefix="cxlab-league-") as folder:
            path = pathlib.Path(folder)
            (path / "confirm.yaml").write_text(
                "clips_manager:\n  ros__parameters:\n    environments: [referee]\n    referee: {plugins: [executive, protobuf, files]}\n"
                "    executive: {plugin: 'cx::ExecutivePlugin', refresh_rate: 10}\n"
                "    protobuf: {plugin: 'cx::ProtobufPlugin', pkg_share_dirs: [rcll_protobuf_msgs], proto_paths: [rcll-protobuf-msgs]}\n"
                "    files: {plugin: 'cx::FileLoadPlugin', pkg_share_dirs: [here], load: [confirm.clp]}\n")
            game = (EXAMPLE / "game.yaml").read_text().split("expect:")[0]
            game = game.replace("params/agent.yaml", f"{EXAMPLE}/params/agent.yaml").replace(
                "league_agent: .", f"league_agent: {EXAMPLE}")
            (path / "game.yaml").write_text(
                game.replace("tier: timed", "  refbox: {confirm_deliveries: true}\ntier: timed") +
                f"  - config: confirm.yaml\n    namespace: /referee\n    packages: {{here: {folder}}}\n")
            for word, points, reason in (("TRUE", 30, None), ("FALSE", 0, "not confirmed"), (None, 0, None)):
                (path / "confirm.clp").write_text(CONFIRMING.replace("CORRECT", word) if word else "")
                played = run("run", "game.yaml", "--until", "400", "--out", str(word), cwd=folder)
                self.assertEqual(played.returncode, 0, played.stdout)
                result = json.loads((path / str(word) / "result.json").read_text())
                by_kind = result["teams"]["CYAN"]["by_kind"]
                self.assertEqual(by_kind["delivery"] + by_kind["cap"], points, word)
                self.assertEqual([d["correct"] for d in result["deliveries"]], [] if word is None else [word == "TRUE"])
                if word:
                    self.assertIn("delivery 1 of CYAN", played.stdout)
                if reason:
                    self.assertIn(reason, (path / str(word) / "journal.jsonl").read_text())
            self.assertIn("the same", run("replay", "TRUE", cwd=folder).stdout)

    def test_short_the_example_makes_a_delivery(self):
        with tempfile.TemporaryDirectory(prefix="cxlab-league-") as folder:
            hashes = []
            for out in ("a", "b"):
                played = run("run", EXAMPLE / "game.yaml", "--until", "400", "--out", out, cwd=folder)
                self.assertEqual(played.returncode, 0, played.stdout)
                self.assertIn("is delivered", played.stdout)
                result = json.loads((pathlib.Path(folder) / out / "result.json").read_text())
                points = result["teams"]["CYAN"]["by_kind"]
                self.assertEqual((points["delivery"], points["cap"], points["exploration"]), (20, 10, 14))
                self.assertTrue(result["deterministic"])
                hashes.append(result["journal_hash"])
            self.assertEqual(hashes[0], hashes[1])
            for command in (("replay", "a"), ("rerun", "a", "--out", "none")):
                again = run(*command, cwd=folder)
                self.assertEqual(again.returncode, 0, again.stdout)
                self.assertIn("the same", again.stdout)

    def test_short_a_configuration_plays_unchanged(self):
        with tempfile.TemporaryDirectory(prefix="cxlab-league-") as folder:
            played = run("env", EXAMPLE / "params/agent.yaml", "--with", "rcll", "--param", "rcll.exploration=true", "--param",
                         "rcll.complexities=[C0]", "--until", "350", "--strict-cx", "--out", "out", cwd=folder)
            self.assertEqual(played.returncode, 0, played.stdout)
            result = json.loads((pathlib.Path(folder) / "out/result.json").read_text())
            self.assertEqual(result["teams"]["CYAN"]["by_kind"]["delivery"], 20, played.stdout)


class OurAgent(unittest.TestCase):
    """The agent that comes with cxlab, which knows topics and actions, against a referee box that it only reaches over the
    network."""

    NAMES = ["game_state", "order_info", "ring_info", "robot_info", "machine_info", "machine_report_info", "machine_report",
             "set_robot_maintenance", "factory/instruct_machine",
             *(f"robot{i}/{skill}" for i in (1, 2, 3)
               for skill in ("drive_to", "pick", "place", "transport", "explore", "discard", "sightings"))]
    AGENT = f"agents:\n- config: {SOURCE}/scenarios/rcll/agent/params/agent.yaml\n  packages: {{rcll_agent: {SOURCE}/scenarios/rcll/agent}}\n"

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="cxlab-league-"))
        self.addCleanup(shutil.rmtree, self.folder)

    def test_short_plays_a_whole_game(self):
        """In one process: what the agent hears and asks for goes twice through the protocol."""
        (self.folder / "game.yaml").write_text(
            "schema: 1\nworld: {kind: rcll, information: league, exploration: true}\ntier: timed\n"
            "servers: [{node: league_client, namespace: /outside, team_name: Ours}]\n" + self.AGENT + "  remap:\n" +
            "".join(f"    /{name}: /outside/{name}\n" for name in self.NAMES))
        played = run("run", "game.yaml", "--out", "out", cwd=self.folder)
        self.assertEqual(played.returncode, 0, played.stdout)
        self.assertNotIn("[warn]", played.stdout)
        result = json.loads((self.folder / "out/result.json").read_text())
        self.assertTrue(result["deterministic"])
        self.assertEqual(result["teams"]["CYAN"]["by_kind"]["exploration"], 14)
        self.assertGreater(result["teams"]["CYAN"]["points"], 400)
        self.assertEqual([robot["failures"] for robot in result["robots"]], [0, 0, 0])
        self.assertIn("the same", run("replay", "out", cwd=self.folder).stdout)

    def test_short_plays_over_sockets(self):
        shift = free_shift()
        (self.folder / "game.yaml").write_text(
            f"schema: 1\nworld: {{kind: rcll, information: league, refbox: {{port_shift: {shift}}}}}\ntier: timed\n")
        (self.folder / "agent.yaml").write_text(
            f"schema: 1\nservers: [{{node: league_client, port_shift: {shift}, team_name: Ours}}]\n" + self.AGENT)
        game, agent = (subprocess.Popen([CXLAB, "run", name + ".yaml", "--sockets", "--until", until, "--out", name], cwd=self.folder,
                                        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
                       for name, until in (("game", "200"), ("agent", "10")))
        for process in (game, agent):
            self.addCleanup(process.wait)
            self.addCleanup(process.stdout.close)
            self.addCleanup(process.kill)
        said = agent.communicate(timeout=100)[0]
        game.send_signal(signal.SIGINT)
        said += game.communicate(timeout=30)[0]
        self.assertEqual((game.returncode, agent.returncode), (130, 0), said)
        self.assertNotIn("[warn]", said)
        result = json.loads((self.folder / "game/result.json").read_text())
        self.assertGreaterEqual(sum(robot["skills"] for robot in result["robots"]), 3, said)


if __name__ == "__main__":
    unittest.main()
