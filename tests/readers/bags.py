"""cxlab plays bags that rosbags writes: MCAP and SQLite, compressed and not, with topics, services and actions. ./dev readers"""

import itertools
import json
import struct
import subprocess
import unittest

from lab import CXLAB, SOURCE, Lab
from mcap.writer import Writer as McapWriter
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

SECOND = 10**9
BEGIN = 1_700_000_000 * SECOND
EXAMPLE = SOURCE / "docs/examples/bag"
GREETER = EXAMPLE / "greeter.yaml"


class Bags(Lab):
    def setUp(self):
        super().setUp()
        self.types = get_typestore(Stores.ROS2_JAZZY)
        fields = {"RotateAbsolute_Feedback": "float32 remaining\n", "RotateAbsolute_Goal": "float32 theta\n", "RotateAbsolute_Result": "float32 delta\n"}
        types = {}
        for name, text in fields.items():
            types |= get_types_from_msg(text, f"turtlesim/msg/{name}")
        self.types.register(types)

    def cxlab(self, *arguments, code=0):
        done = subprocess.run([CXLAB, *map(str, arguments)], cwd=self.folder, text=True, capture_output=True, timeout=100)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done

    def published(self):
        return [(r["t"], r["data"]["name"], r["data"]["msg"]) for r in self.records() if r["stream"] == "node/bag" and r["kind"] == "bus" and r["data"]["op"] == "publish"]

    def visitors(self, name, storage, mode=None):
        writer = Writer(self.folder / name, version=9, storage_plugin=storage)
        if mode:
            writer.set_compression(mode, CompressionFormat.ZSTD)
        with writer as bag:
            topic = bag.add_connection("/visitor", "std_msgs/msg/Float32", typestore=self.types)
            other = bag.add_connection("/pose", "geometry_msgs/msg/PoseStamped", typestore=self.types)
            Float32 = self.types.types["std_msgs/msg/Float32"]
            pose = self.types.types
            stamp = pose["builtin_interfaces/msg/Time"](sec=0, nanosec=0)
            header = pose["std_msgs/msg/Header"](stamp=stamp, frame_id="map")
            where = pose["geometry_msgs/msg/Pose"](position=pose["geometry_msgs/msg/Point"](x=1.0, y=2.0, z=3.0),
                                                   orientation=pose["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0))
            for n in range(30):
                t = BEGIN + n * SECOND // 5
                bag.write(topic, t, self.types.serialize_cdr(Float32(data=-0.5 * n), "std_msgs/msg/Float32"))
                bag.write(other, t, self.types.serialize_cdr(pose["geometry_msgs/msg/PoseStamped"](header=header, pose=where), "geometry_msgs/msg/PoseStamped"))
        return self.folder / name

    def test_topics_of_each_kind_of_file(self):
        expected = [(n * SECOND // 5, "/visitor", {"data": -0.5 * n}) for n in range(30)]
        for storage, mode in ((StoragePlugin.MCAP, None), (StoragePlugin.MCAP, CompressionMode.STORAGE), (StoragePlugin.SQLITE3, None),
                              *itertools.product(StoragePlugin, (CompressionMode.FILE, CompressionMode.MESSAGE))):
            with self.subTest(storage=storage, mode=mode):
                name = f"bag_{storage.name}_{mode}"
                self.visitors(name, storage, mode)
                said = self.cxlab("env", GREETER, "--bag", name, "--journal", "full", "--out", "out", "--force").stderr
                self.assertEqual(self.published(), expected)
                self.assertNotIn("differ", said)

    def test_big_endian_messages_and_definitions_in_idl(self):
        """As other machines write them, and as ROS 2 does for packages whose definitions are .idl files."""
        idl = "=" * 80 + "\nIDL: std_msgs/msg/Float32\nmodule std_msgs { module msg { struct Float32 { float data; }; }; };\n"
        Float32 = self.types.types["std_msgs/msg/Float32"]
        with (self.folder / "other.mcap").open("wb") as file:
            bag = McapWriter(file)
            bag.start(profile="ros2", library="test")
            schema = bag.register_schema("std_msgs/msg/Float32", "ros2idl", idl.encode())
            topic = bag.register_channel("/visitor", "cdr", schema)
            for n in range(10):
                value = self.types.serialize_cdr(Float32(data=-0.5 * n), "std_msgs/msg/Float32", little_endian=n % 2 == 0)
                bag.add_message(topic, BEGIN + n * SECOND // 5, bytes(value), BEGIN)
            bag.finish()
        self.cxlab("env", GREETER, "--bag", "other.mcap", "--journal", "full", "--out", "out")
        self.assertEqual(self.published(), [(n * SECOND // 5, "/visitor", {"data": -0.5 * n}) for n in range(10)])

    def test_services_and_actions(self):
        uuid = bytes(range(16))
        header = b"\0\1\0\0"

        def event(kind, number, request=b"", response=b""):
            """As service introspection publishes it; the parts are aligned by hand."""
            return header + struct.pack("<Bxxxii16sxxxxqI", kind, 0, 0, b"client", number, bool(request)) + request + struct.pack("<I", bool(response)) + response

        raw = []
        with Writer(self.folder / "floor", version=9, storage_plugin=StoragePlugin.MCAP) as bag:
            add = lambda topic, kind, text="": bag.add_connection(topic, kind, msgdef=text, rihs01="RIHS01_" + 64 * "0")
            visitor = bag.add_connection("/visitor", "std_msgs/msg/Float32", typestore=self.types)
            action = "/turtle1/rotate_absolute/_action/"
            send = add(action + "send_goal/_service_event", "turtlesim/action/RotateAbsolute_SendGoal_Event")
            result = add(action + "get_result/_service_event", "turtlesim/action/RotateAbsolute_GetResult_Event")
            feedback = add(action + "feedback", "turtlesim/action/RotateAbsolute_FeedbackMessage")
            pen = add("/turtle1/set_pen/_service_event", "turtlesim/srv/SetPen_Event", 80 * "=" + "\nSRV: turtlesim/srv/SetPen\nuint8 r\nuint8 g\nuint8 b\nuint8 width\nuint8 off\n---\n")
            raw = [
                (0, visitor, header + struct.pack("<f", 1.5)),
                (0.5, send, event(1, 1, request=uuid + struct.pack("<f", 1.5))),
                (0.6, send, event(2, 1, response=struct.pack("<Bxxxii", 1, 0, 0))),
                (0.7, result, event(1, 7, request=uuid)),
                (1.0, feedback, header + uuid + struct.pack("<f", 0.5)),
                (2.0, result, event(2, 7, response=struct.pack("<bxxxf", 4, 1.5))),
                (2.5, pen, event(1, 3, request=struct.pack("<5Bxxx", 0, 0, 0, 5, 0))),
                (3.0, pen, event(2, 3, response=b"\0")),
            ]
            for t, connection, data in raw:
                bag.write(connection, BEGIN + round(t * SECOND), data)
        said = self.cxlab("env", GREETER, "--bag", "floor", "--journal", "full", "--out", "out").stderr
        self.assertIn("a visitor is greeted", said)
        fired = {r["data"]["rule"]: r["t"] / SECOND for r in self.records() if r["kind"] == "fire"}
        self.assertEqual({rule: fired[rule] for rule in ("turn-to-visitor", "drop-feedback", "greet", "visitor-is-greeted")},
                         {"turn-to-visitor": 0.0, "drop-feedback": 1.0, "greet": 2.0, "visitor-is-greeted": 3.0})
        self.assertEqual(json.loads((self.out / "result.json").read_text())["warnings"], [])

    def test_another_definition_is_named(self):
        with Writer(self.folder / "floor", version=9, storage_plugin=StoragePlugin.MCAP) as bag:
            topic = bag.add_connection("/visitor", "std_msgs/msg/Float32", msgdef="float64 data\n", rihs01="RIHS01_" + 64 * "0")
            bag.write(topic, BEGIN, b"\0\1\0\0" + struct.pack("<d", 1.5))
        said = self.cxlab("env", GREETER, "--bag", "floor", code=3).stderr
        self.assertIn("field 1 of std_msgs/Float32 is 'float64 data' in the bag and 'float32 data' in the workspace", said)


if __name__ == "__main__":
    unittest.main()
