"""A program of another make talks to an agent over sockets: Python's protobuf and cryptography, and frames written here
from the description of the league's protocol."""

import hashlib
import json
import pathlib
import shutil
import socket
import struct
import subprocess
import tempfile
import time
import unittest

from cryptography.hazmat.primitives import padding
from cryptography.hazmat.primitives.ciphers import Cipher, algorithms, modes
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory

from lab import CXLAB, SOURCE

PROTO = """syntax = "proto2";
package talk;
message Say {
  enum CompType { COMP_ID = 2000; MSG_TYPE = 1; }
  required string text = 1;
  optional double number = 2;
  repeated string words = 3;
  enum Mood { CALM = 0; GLAD = 3; }
  optional Mood mood = 4;
}
"""
# Every peer, server and client answers what it hears with the same in capitals.
RULES = """(deffacts start (open))
(defglobal ?*plain* = 0)
(defrule open
  (open)
  =>
  (bind ?*plain* (pb-peer-create-local "127.0.0.1" PLAIN_TO PLAIN_AT))
  (pb-peer-create-local-crypto "127.0.0.1" C1_TO C1_AT "randomkey" "aes-128-ecb")
  (pb-peer-create-local-crypto "127.0.0.1" C2_TO C2_AT "randomkey" "aes-128-cbc")
  (pb-peer-create-local-crypto "127.0.0.1" C3_TO C3_AT "randomkey" "aes-256-ecb")
  (pb-peer-create-local-crypto "127.0.0.1" C4_TO C4_AT "randomkey" "aes-256-cbc")
  (pb-server-enable SERVER)
  (pb-connect "127.0.0.1" CLIENT))
(defrule ready (open) (time ?) => (printout t "ready" crlf))
(defrule hear
  (protobuf-msg (type "talk.Say") (ptr ?said) (client-id ?id) (client-type ?type) (rcvd-via ?via))
  =>
  (bind ?answer (pb-create "talk.Say"))
  (pb-set-field ?answer text (upcase (pb-field-value ?said text)))
  (if (pb-has-field ?said number) then
    (pb-set-field ?answer number (* 2 (pb-field-value ?said number))))
  (pb-add-list ?answer words ?type)
  (pb-add-list ?answer words ?via)
  (foreach ?word (pb-field-list ?said words) (pb-add-list ?answer words ?word))
  (if (pb-has-field ?said mood) then (pb-set-field ?answer mood (pb-field-value ?said mood)))
  (pb-send ?id ?answer)
  (pb-destroy ?answer))
(defrule connected (protobuf-client-connected ?id) => (printout t "client connected" crlf))
(defrule accepted (protobuf-server-client-connected ?id ?host ?port) => (printout t "accepted " ?host crlf))
(defrule lost (protobuf-client-disconnected ?id) => (printout t "client disconnected" crlf))
(defrule left (protobuf-server-client-disconnected ?id) => (printout t "server: one has left" crlf))
(defrule stop
  (declare (salience -100))
  (protobuf-msg (type "talk.Say") (ptr ?said))
  (test (eq (pb-field-value ?said text) "stop"))
  =>
  (cx-shutdown))
"""
CONFIG = """/**:
  ros__parameters:
    environments: ["main"]
    main: {plugins: ["executive", "protobuf", "files"]}
    executive: {plugin: "cx::ExecutivePlugin", refresh_rate: 50}
    protobuf: {plugin: "cx::TalkProtobufPlugin"}
    files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["talk"], load: ["rules.clp"]}
"""
NAMES = ["none", "aes-128-ecb", "aes-128-cbc", "aes-256-ecb", "aes-256-cbc"]


def say_class():
    file = descriptor_pb2.FileDescriptorProto(name="talk.proto", package="talk")
    say = file.message_type.add(name="Say")
    kinds = descriptor_pb2.FieldDescriptorProto
    for name, number, kind, label in [("text", 1, kinds.TYPE_STRING, kinds.LABEL_REQUIRED),
                                      ("number", 2, kinds.TYPE_DOUBLE, kinds.LABEL_OPTIONAL),
                                      ("words", 3, kinds.TYPE_STRING, kinds.LABEL_REPEATED)]:
        say.field.add(name=name, number=number, type=kind, label=label)
    say.field.add(name="mood", number=4, type=kinds.TYPE_ENUM, label=kinds.LABEL_OPTIONAL, type_name=".talk.Say.Mood")
    mood = say.enum_type.add(name="Mood")
    mood.value.add(name="CALM", number=0)
    mood.value.add(name="GLAD", number=3)
    pool = descriptor_pool.DescriptorPool()
    pool.Add(file)
    descriptor = pool.FindMessageTypeByName("talk.Say")
    if hasattr(message_factory, "GetMessageClass"):
        return message_factory.GetMessageClass(descriptor)
    return message_factory.MessageFactory(pool).GetPrototype(descriptor)


Say = say_class()
GLAD = 3


def key_of(phrase, size):
    """EVP_BytesToKey with sha256, no salt, 8 rounds."""
    key, last = b"", b""
    while len(key) < size:
        last = hashlib.sha256(last + phrase).digest()
        for _ in range(7):
            last = hashlib.sha256(last).digest()
        key += last
    return key[:size]


def engine(cipher, phrase, iv):
    return Cipher(algorithms.AES(key_of(phrase, 16 if cipher < 3 else 32)), modes.CBC(iv) if iv else modes.ECB())


def frame(message, cipher=0, phrase=b"randomkey", key=(2000, 1)):
    payload = struct.pack(">HH", *key) + (message if isinstance(message, bytes) else message.SerializeToString())
    if cipher:
        iv = b"0123456789abcdef" if cipher in (2, 4) else b""
        pad = padding.PKCS7(128).padder()
        encryptor = engine(cipher, phrase, iv).encryptor()
        payload = iv + encryptor.update(pad.update(payload) + pad.finalize()) + encryptor.finalize()
    return struct.pack(">BBBBI", 2, cipher, 0, 0, len(payload)) + payload


def read_frame(bytes_, cipher=0, phrase=b"randomkey"):
    version, found, zero, zero_too, size = struct.unpack(">BBBBI", bytes_[:8])
    payload = bytes_[8:]
    assert (version, found, zero, zero_too, size) == (2, cipher, 0, 0, len(payload)), bytes_
    if cipher:
        iv = b""
        if cipher in (2, 4):
            iv, payload = payload[:16], payload[16:]
        decryptor, pad = engine(cipher, phrase, iv).decryptor(), padding.PKCS7(128).unpadder()
        payload = pad.update(decryptor.update(payload) + decryptor.finalize()) + pad.finalize()
    assert struct.unpack(">HH", payload[:4]) == (2000, 1)
    return Say.FromString(payload[4:])


def datagrams():
    made = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    made.bind(("127.0.0.1", 0))
    made.settimeout(20)
    return made


def read_stream(stream):
    def exactly(size):
        data = b""
        while len(data) < size:
            more = stream.recv(size - len(data))
            if not more:
                raise EOFError
            data += more
        return data

    head = exactly(8)
    return read_frame(head + exactly(struct.unpack(">I", head[4:])[0]))


def free_port(kind):
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Peers(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="cxlab-protobuf-"))
        self.addCleanup(shutil.rmtree, self.folder)
        self.peers = [datagrams() for _ in NAMES]  # by cipher
        self.ports = [free_port(socket.SOCK_DGRAM) for _ in NAMES]  # of the agent
        self.server = socket.create_server(("127.0.0.1", 0))
        self.server.settimeout(20)
        self.server_port = free_port(socket.SOCK_STREAM)
        for made in [*self.peers, self.server]:
            self.addCleanup(made.close)
        rules = RULES.replace("SERVER", str(self.server_port)).replace("CLIENT", str(self.server.getsockname()[1]), 1)
        for i, (peer, port) in enumerate(zip(self.peers, self.ports)):
            name = f"C{i}" if i else "PLAIN"
            rules = rules.replace(f"{name}_TO", str(peer.getsockname()[1])).replace(f"{name}_AT", str(port))
        (self.folder / "talk/proto").mkdir(parents=True)
        (self.folder / "talk/rules.clp").write_text(rules)
        (self.folder / "talk/proto/talk.proto").write_text(PROTO)
        (self.folder / "talk.yaml").write_text(CONFIG)
        self.log = open(self.folder / "log", "w+")
        self.addCleanup(self.log.close)
        self.agent = subprocess.Popen([CXLAB, "env", "talk.yaml", "--package", "talk=talk", "--sockets", "--until", "60",
                                       "--out", "out"], cwd=self.folder, stdout=subprocess.DEVNULL, stderr=self.log)
        self.addCleanup(self.agent.wait)
        self.addCleanup(self.agent.kill)
        self.wait_for("ready")

    def said(self):
        return (self.folder / "log").read_text()

    def wait_for(self, text, count=1):
        end = time.monotonic() + 20
        while self.said().count(text) < count:
            self.assertLess(time.monotonic(), end, f"{count} x '{text}' in:\n{self.said()}")
            self.assertIsNone(self.agent.poll(), self.said())
            time.sleep(0.01)

    def send(self, cipher, data):
        self.peers[cipher].sendto(data, ("127.0.0.1", self.ports[cipher]))

    def stop(self):
        """Ends the agent; its rules then replay without anybody."""
        self.send(0, frame(Say(text="stop")))
        self.assertEqual(self.agent.wait(20), 0, self.said())
        self.assertIs(json.loads((self.folder / "out/result.json").read_text())["deterministic"], False)
        replayed = subprocess.run([CXLAB, "replay", "out", "--rules"], cwd=self.folder, text=True, timeout=60,
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.assertEqual(replayed.returncode, 0, replayed.stdout)
        self.assertIn("the same", replayed.stdout)
        again = subprocess.run([CXLAB, "rerun", "out"], cwd=self.folder, text=True, timeout=60, stdout=subprocess.PIPE,
                               stderr=subprocess.STDOUT)
        self.assertEqual(again.returncode, 2, again.stdout)
        self.assertIn("programs outside (--sockets) took part in this run", again.stdout)

    def test_short_datagrams_of_all_ciphers(self):
        for cipher, name in enumerate(NAMES):
            for text in ("hello", "x" * 5000):
                with self.subTest(name, size=len(text)):
                    self.send(cipher, frame(Say(text=text, number=1.5, words=["a", "b c"], mood=GLAD), cipher))
                    answer = read_frame(self.peers[cipher].recv(65536), cipher)
                    self.assertEqual(answer, Say(text=text.upper(), number=3, words=["PEER", "BROADCAST", "a", "b c"], mood=GLAD))
        self.stop()

    def test_short_streams(self):
        program, _ = self.server.accept()
        with program:
            program.settimeout(20)
            self.wait_for("client connected")
            whole = frame(Say(text="one")) + frame(Say(text="two"))
            for i in range(0, len(whole), 5):
                program.sendall(whole[i:i + 5])
                time.sleep(0.005)
            answers = [read_stream(program), read_stream(program)]  # of two facts of one run the later one fires first
            for text in ("ONE", "TWO"):
                self.assertIn(Say(text=text, words=["CLIENT", "STREAM"]), answers)
        self.wait_for("client disconnected")
        with socket.create_connection(("127.0.0.1", self.server_port), 20) as first, \
                socket.create_connection(("127.0.0.1", self.server_port), 20) as second:
            for stream, text in ((second, "b"), (first, "a")):
                stream.sendall(frame(Say(text=text)))
                self.assertEqual(read_stream(stream), Say(text=text.upper(), words=["SERVER", "STREAM"]))
            first.sendall(frame(Say(text="gone"), key=(1, 1)))
            self.wait_for("Message type 1:1 not registered")
            first.sendall(frame(Say(text="still here")))
            self.assertEqual(read_stream(first).text, "STILL HERE")
            first.sendall(b"GET / HTTP/1.1\r\n")
            with self.assertRaises((EOFError, ConnectionError)):
                read_stream(first)
            self.wait_for("found frame header version 71")
            second.sendall(frame(Say(text="and I")))
            self.assertEqual(read_stream(second).text, "AND I")
        self.wait_for("server: one has left", 2)
        self.stop()

    def test_short_broken_datagrams(self):
        good = Say(text="never")
        for count, (what, cipher, data) in enumerate([
            ("found 0, expected 8", 0, b""),
            ("found 7, expected 8", 0, frame(good)[:7]),
            ("Invalid number of bytes", 0, frame(good)[:-1]),
            ("Invalid number of bytes", 0, frame(good) + b"x"),
            ("found frame header version 1", 0, b"\1" + frame(good)[1:]),
            ("found cipher 9", 0, b"\2\x09" + frame(good)[2:]),
            ("found a payload of 2 bytes", 0, b"\2\0\0\0\0\0\0\2\0\1"),
            ("Message type 5:6 not registered", 0, frame(good, key=(5, 6))),
            ("the bytes are no talk.Say", 0, frame(b"\x0a\x50short")),
            ("talk.Say lacks required fields: text", 0, frame(b"")),
            ("encryption is disabled", 0, frame(good, 2)),
            ("encryption is enabled", 2, frame(good)),
            ("cipher aes-128-ecb, expected aes-128-cbc", 2, frame(good, 1)),
            ("cipher aes-256-cbc, expected aes-128-cbc", 2, frame(good, 4)),
            ("Decryption failed", 2, frame(good, 2, b"another")),
            ("Decryption failed", 2, struct.pack(">BBBBI", 2, 2, 0, 0, 20) + b"x" * 20),
            ("Decryption failed", 1, struct.pack(">BBBBI", 2, 1, 0, 0, 0)),
        ], 1):
            with self.subTest(what):
                before = self.said().count(what)
                self.send(cipher, data)
                self.wait_for(what, before + 1)
                self.wait_for("Receiving from 127.0.0.1:", count)
        for cipher in range(5):
            self.send(cipher, frame(Say(text="fine"), cipher))
            self.assertEqual(read_frame(self.peers[cipher].recv(65536), cipher).text, "FINE")
        self.assertEqual(self.said().count("failed (id"), 17, self.said())
        self.stop()

    def test_short_a_flood_does_not_starve_it(self):
        flood = frame(Say(text="flood"))
        for _ in range(3000):
            self.peers[0].sendto(flood, ("127.0.0.1", self.ports[0]))
        self.send(3, frame(Say(text="and me"), 3))
        self.assertEqual(read_frame(self.peers[3].recv(65536), 3).text, "AND ME")
        self.stop()


class Inside(unittest.TestCase):
    def test_short_the_same_run_gives_the_same_bytes(self):
        with tempfile.TemporaryDirectory(prefix="cxlab-protobuf-") as folder:
            hashes = []
            for out in ("a", "b"):
                done = subprocess.run([CXLAB, "env", SOURCE / "docs/examples/protobuf/example.yaml", "--package",
                                       f"example={SOURCE / 'docs/examples/protobuf'}", "--until", "10", "--out", out, "--json"],
                                      cwd=folder, text=True, timeout=60, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
                result = json.loads(done.stdout)
                self.assertTrue(result["deterministic"])
                hashes.append(result["journal_hash"])
                subprocess.run([CXLAB, "replay", out, "--rules"], cwd=folder, timeout=60, check=True, stdout=subprocess.DEVNULL,
                               stderr=subprocess.DEVNULL)
            self.assertEqual(hashes[0], hashes[1])


if __name__ == "__main__":
    unittest.main()
