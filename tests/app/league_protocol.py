"""The protocol of the league: the small agent that comes along plays with it, and a program outside speaks it over
sockets, with Python's protobuf and cryptography, and frames written here."""

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


class Outside(unittest.TestCase):
    """A program outside is the agent of a game that has none."""

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="cxlab-league-"))
        self.addCleanup(shutil.rmtree, self.folder)
        shift = free_shift()
        self.public = Peer(4445 + shift, 4444 + shift)
        self.cyan = Peer(4446 + shift, 4441 + shift, CBC)
        self.robot = Peer(2126 + shift, 2116 + shift)
        self.stream_port = 4444 + shift
        for peer in (self.public, self.cyan, self.robot):
            self.addCleanup(peer.socket.close)
        (self.folder / "game.yaml").write_text(
            "schema: 1\nworld: {kind: rcll, information: league, complexities: [C0], down: false,\n"
            f"  refbox: {{team_cyan: Pythons, port_shift: {shift}}}}}\ntier: timed\n")
        self.log = open(self.folder / "log", "w+")
        self.addCleanup(self.log.close)
        self.game = subprocess.Popen([CXLAB, "run", "game.yaml", "--sockets", "--until", "200", "--out", "out"],
                                     cwd=self.folder, stdout=subprocess.DEVNULL, stderr=self.log)
        self.addCleanup(self.game.wait)
        self.addCleanup(self.game.kill)

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


class Inside(unittest.TestCase):
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
