"""mcap, mcap-ros2-support and rosbags read the bags of cxlab export; pandas, pyarrow and DuckDB its tables. ./dev readers"""

import collections
import csv
import dataclasses
import json
import math
import pathlib
import random
import struct
import subprocess
import unittest

import duckdb
import pandas
import pyarrow
import pyarrow.parquet
from lab import CXLAB, SOURCE, Lab
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from rosbags.interfaces import Nodetype
from rosbags.typesys import get_types_from_msg

SECOND = 10**9
RANGES = {f"{sign}int{bits}": (-(2 ** (bits - 1)) if not sign else 0, 2 ** (bits - (not sign)) - 1) for sign in ("", "u") for bits in (8, 16, 32, 64)}
RANGES |= {"byte": (0, 127), "octet": (0, 127), "char": (0, 127)}  # mcap-ros2-support takes both for an int8


def in_rosbags(connection):
    """How rosbags calls the type of a service's event."""
    return connection.msgtype.replace("/srv/", "/srv/msg/")


def plain(value):
    """A message, or a part of it, as dictionaries, lists and numbers. Names of fields are lower case, those of constants are
    not; rosbags calls a field `from` `from_`."""
    if dataclasses.is_dataclass(value):
        return {field.name.rstrip("_"): plain(getattr(value, field.name)) for field in dataclasses.fields(value) if field.name.islower() and field.name != "__msgtype__"}
    if hasattr(value, "__slots__") and not hasattr(value, "tolist") and not isinstance(value, (str, bytes)):
        return {name: plain(getattr(value, name)) for name in value.__slots__ if name.islower()}
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, bytes):
        return list(value)
    return value


def same(a, b):
    """Whether two plain values are the same; journals write numbers that JSON lacks as texts."""
    if isinstance(a, dict) and isinstance(b, dict):
        a, b = ({k: v for k, v in x.items() if k != "structure_needs_at_least_one_member"} for x in (a, b))
        return a.keys() == b.keys() and all(same(a[key], b[key]) for key in a)
    if isinstance(a, list) and isinstance(b, list):
        return len(a) == len(b) and all(map(same, a, b))
    if isinstance(a, float) or isinstance(b, float):
        a, b = float(a), float(b)
        return a == b or (math.isnan(a) and math.isnan(b))
    return a == b


class Exports(Lab):
    def cxlab(self, *arguments, code=0):
        done = subprocess.run([CXLAB, *map(str, arguments)], cwd=self.folder, text=True, capture_output=True, timeout=300)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done.stdout

    def bag(self, *arguments):
        written = json.loads(self.cxlab("export", "out", "--mcap", "--json", *arguments))
        return self.folder / written["files"][0]["path"], written

    def messages(self, path):
        """By topic (time, plain value), as rosbags reads them: each is written again as the same bytes."""
        out = {}
        with AnyReader([path]) as bag:
            for connection, t, raw in bag.messages():
                message = bag.deserialize(raw, in_rosbags(connection))
                self.assertEqual(bytes(bag.typestore.serialize_cdr(message, in_rosbags(connection))), bytes(raw), connection.topic)
                out.setdefault(connection.topic, []).append((t, plain(message)))
        return out

    def messages_of_mcap(self, path):
        """The same, as mcap and mcap-ros2-support read them; the latter takes no types with underscores, as those of events have."""
        out = {}
        with path.open("rb") as file:
            reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
            self.assertEqual(reader.get_header().profile, "ros2")
            summary = reader.get_summary()
            topics = [c.topic for c in summary.channels.values() if "_" not in summary.schemas[c.schema_id].name.split("/")[-1]]
            for _, channel, message, value in reader.iter_decoded_messages(topics):
                out.setdefault(channel.topic, []).append((message.log_time, plain(value)))
        return out

    def random_value(self, chance, types, node, args):
        if node == Nodetype.BASE:
            name, limit = args if isinstance(args, tuple) else (args, 0)
            if name in RANGES:
                low, high = RANGES[name]
                return chance.choice([low, high, 0, chance.randint(low, high)])
            if name == "bool":
                return chance.random() < 0.5
            if name == "float64":
                return chance.choice([0.0, -1.5, 1e300, chance.uniform(-1e3, 1e3)])
            if name == "float32":
                return struct.unpack("f", struct.pack("f", chance.uniform(-1e3, 1e3)))[0]
            self.assertEqual(name, "string")
            return "".join(chance.choice("aZ 9_\"'\\é€\n:#") for _ in range(chance.randint(0, min(limit or 9, 9))))
        if node == Nodetype.NAME:
            return self.random_message(chance, types, args)
        size = args[1] if node == Nodetype.ARRAY else chance.randint(0, min(args[1] or 3, 3))
        return [self.random_value(chance, types, *args[0]) for _ in range(size)]

    def random_message(self, chance, types, name):
        return {field: self.random_value(chance, types, *kind) for field, kind in types[name][1] if field != "structure_needs_at_least_one_member"}

    def test_random_messages_of_all_definitions(self):
        types, chance = {}, random.Random(1)
        for path in sorted((SOURCE / "cx/interfaces").glob("*/msg/*.msg")):
            if path.stem != "WString":  # neither reader has wide strings
                types |= get_types_from_msg(path.read_text(), f"{path.parent.parent.name}/msg/{path.stem}")
        sent = {}
        for name in sorted(types):
            for _ in range(3):
                sent.setdefault("/t/" + name.replace("/msg/", "/"), (name, []))[1].append(self.random_message(chance, types, name))
        stimuli = [{"at": 0.1 * (n + 1), "publish": topic, "type": name, "data": data} for topic, (name, all_of) in sent.items() for n, data in enumerate(all_of)]
        self.assertGreater(len(sent), 130)
        self.write("scenario.yaml", json.dumps({"schema": 1, "duration_s": 2, "stimuli": stimuli}))
        self.cxlab("run", "scenario.yaml", "--quiet", "--journal", "full", "--out", "out")
        path, _ = self.bag()
        for read in (self.messages(path), self.messages_of_mcap(path)):
            for topic, (_, expected) in sent.items():
                found = [value for _, value in read[topic]]
                self.assertTrue(same(expected, found), f"{topic}:\n{expected}\n{found}")

    def game(self):
        self.cxlab("run", SOURCE / "scenarios/rcll/planning.yaml", "--tier", "timed", "--until", 120, "--seed", 1, "--journal", "full", "--quiet", "--out", "out")

    def test_a_game(self):
        self.game()
        path, written = self.bag()
        read, read_of_mcap, journal = self.messages(path), self.messages_of_mcap(path), self.records()
        self.assertEqual(sum(map(len, read.values())), written["files"][0]["entries"])
        for topic, messages in read_of_mcap.items():
            self.assertTrue(same([list(m) for m in messages], [list(m) for m in read[topic]]), topic)
        for messages in read.values():
            self.assertEqual([t for t, _ in messages], sorted(t for t, _ in messages))

        # The bus: each message that the journal has, under its topic, at its time.
        def of(op, key):
            out = {}
            for record in journal:
                if record["kind"] == "bus" and record["data"]["op"] == op:
                    out.setdefault(record["data"]["name"], []).append((record["t"], record["data"][key]))
            return out

        published = of("publish", "msg")
        self.assertGreater(len(published), 10)
        for topic, messages in published.items():
            self.assertTrue(same([list(m) for m in messages], [list(m) for m in read[topic]]), topic)
        for op, key in (("call", "request"), ("respond", "response")):
            for service, messages in of(op, key).items():
                events = [(t, e[key][0]) for t, e in read[service + "/_service_event"] if e[key]]
                self.assertTrue(same([list(m) for m in messages], [list(e) for e in events]), service)
                kinds = {e["info"]["event_type"] for t, e in read[service + "/_service_event"] if e[key]}
                self.assertEqual(kinds, {0 if op == "call" else 2})
        for action, messages in of("feedback", "feedback").items():
            self.assertTrue(same([m for _, m in messages], [m["feedback"] for _, m in read[action + "/_action/feedback"]]), action)
        for action, messages in of("goal", "goal").items():
            events = [e["request"][0]["goal"] for _, e in read[action + "/_action/send_goal/_service_event"] if e["request"]]
            self.assertTrue(same([m for _, m in messages], events), f"{action}:\n{messages}\n{events}")
            ids = {bytes(s["goal_info"]["goal_id"]["uuid"]).hex() for _, m in read[action + "/_action/status"] for s in m["status_list"]}
            self.assertEqual(ids, {r["data"]["goal_id"] for r in journal if r["kind"] == "bus" and r["data"]["name"] == action and r["data"]["op"] == "goal"})
        for action, messages in of("result", "result").items():
            events = [e["response"][0]["result"] for _, e in read[action + "/_action/get_result/_service_event"] if e["response"]]
            self.assertTrue(same([m for _, m in messages], events), f"{action}:\n{messages}\n{events}")

        # What the journal tells.
        skills = [r["data"] for r in journal if r["kind"] == "skill"]
        found = [m for topic, messages in read.items() if topic.startswith("/cxlab/skills/") for _, m in messages]
        self.assertEqual(sorted((s["robot"], s["skill"], s["target"], s["event"], s.get("phase", ""), s.get("for", "")) for s in skills),
                         sorted((m["robot"], m["skill"], m["target"], m["event"], m["phase"], m["waits_for"]) for m in found))
        self.assertTrue(any(" wait for robot" in m["state"] for m in found))
        events = [(r["t"], r["stream"], r["n"], r["kind"], r["data"]) for r in journal if r["kind"] in ("referee", "decision", "control", "error")]
        self.assertEqual(events, [(t, m["stream"], m["n"], m["kind"], json.loads(m["data"])) for t, m in read["/cxlab/events"]])
        result = json.loads((self.out / "result.json").read_text())
        for team, points in result["teams"].items():
            if points["points"]:
                self.assertEqual(read[f"/cxlab/points/{team}"][-1][1]["total"], points["points"])

        # The scene, at some times.
        for at in (0.0, 33.3, 60.0, 119.9):
            scene = json.loads(self.cxlab("scene", "out", "--at", at, "--json"))["entities"]
            poses = {}
            for topic in ("/tf_static", "/tf"):
                last = [m for t, m in read[topic] if t <= round(at * SECOND)][-1]
                poses |= {one["child_frame_id"]: one for one in last["transforms"]}
            names = [e["name"] for e in scene]
            frames = [name if names.index(name) == n else f"{name}_{scene[n]['id']}" for n, name in enumerate(names)]
            self.assertEqual(set(frames), set(poses))
            frame_of = {entity["id"]: frame for entity, frame in zip(scene, frames)} | {None: "map"}
            for entity, frame in zip(scene, frames):
                pose = poses[frame]
                self.assertEqual(pose["header"]["frame_id"], frame_of[entity["carried_by"]])
                place = [pose["transform"]["translation"][axis] for axis in "xyz"]
                self.assertTrue(all(abs(a - b) < 1e-3 for a, b in zip(place, entity["seen_from_carrier"]["position"])), (entity, pose))
                turn = pose["transform"]["rotation"]
                self.assertAlmostEqual(sum(part * part for part in turn.values()), 1, places=9)
                yaw = math.atan2(2 * (turn["w"] * turn["z"] + turn["x"] * turn["y"]), 1 - 2 * (turn["y"] ** 2 + turn["z"] ** 2))
                self.assertAlmostEqual(math.sin(yaw), math.sin(entity["seen_from_carrier"]["rotation"][2]), places=2)
            for kind in {e["kind"] for e in scene}:
                markers = [m for t, m in read[f"/cxlab/scene/{kind}"] if t <= round(at * SECOND)][-1]["markers"]
                self.assertEqual(markers[0]["action"], 3)
                solids = sum(len(e["look"]) for e in scene if e["kind"] == kind)
                self.assertEqual(sum(m["type"] in (1, 3) for m in markers[1:]), solids)
                texts = {m["text"] for m in markers[1:] if m["type"] == 9}
                self.assertEqual(texts, {f"{e['name']}\n{e['state']}" for e in scene if e["kind"] == kind and e["state"]})

    def test_a_stretch(self):
        self.game()
        path, _ = self.bag("--from", 30, "--to", 40, "-o", "part.mcap")
        whole, part = self.messages(self.bag()[0]), self.messages(path)
        for topic, messages in part.items():
            self.assertTrue(all(30 * SECOND <= t <= 40 * SECOND for t, _ in messages), topic)
            if not topic.startswith(("/cxlab/scene", "/tf")):
                self.assertEqual(messages, [m for m in whole[topic] if 30 * SECOND <= m[0] <= 40 * SECOND], topic)
        self.assertIn("/tf_static", part)

    def test_tables(self):
        self.game()
        self.cxlab("export", "out", "--csv")
        journal = self.records()
        records = pandas.read_csv(self.out / "export/csv/records.csv", keep_default_na=False)
        self.assertEqual(list(zip(records.stream, records.n, records.t_ns, records.kind)), [(r["stream"], r["n"], r["t"], r["kind"]) for r in journal])
        self.assertEqual([json.loads(data) for data in records.data], [r["data"] for r in journal])
        self.assertEqual(list(records.cause), [" ".join(r["cause"]) for r in journal])
        skills = pandas.read_csv(self.out / "export/csv/skills.csv")
        report = json.loads((self.out / "report.json").read_text())["skills"]
        self.assertEqual(sorted(zip(skills.robot, skills.skill, skills.target, skills.begin_s)), sorted((s["robot"], s["skill"], s["target"], s["begin"]) for s in report))
        points = pandas.read_csv(self.out / "export/csv/points.csv")
        result = json.loads((self.out / "result.json").read_text())
        self.assertEqual(points.points.sum(), sum(team["points"] for team in result["teams"].values()))
        orders = pandas.read_csv(self.out / "export/csv/orders.csv")
        asked = json.loads(self.cxlab("orders", "out", "--json"))["orders"]
        self.assertEqual(list(orders.order), [o["order"] for o in asked])
        for name in ("waits", "machines", "pieces"):
            self.assertTrue(list((self.out / "export/csv").glob(f"{name}*.csv")), name)

    def test_parquet_is_what_csv_is(self):
        self.game()
        self.cxlab("export", "out", "--csv", "--parquet")
        files = sorted((self.out / "export/parquet").glob("*.parquet"))
        self.assertEqual([f.stem for f in files], sorted(f.stem for f in (self.out / "export/csv").glob("*.csv")))
        for path in files:
            rows = pyarrow.parquet.read_table(path)
            for field in rows.schema:
                self.assertIn(field.type, (pyarrow.int64(), pyarrow.float64(), pyarrow.string()))
            with (self.out / "export/csv" / f"{path.stem}.csv").open(newline="") as file:
                text = list(csv.reader(file))
            self.assertEqual(rows.column_names, text[0])
            kinds = [{pyarrow.int64(): int, pyarrow.float64(): float}.get(field.type, str) for field in rows.schema]
            expected = [[kind(cell) if cell else None for kind, cell in zip(kinds, row)] for row in text[1:]]
            found = [[value or None if kind is str else value for kind, value in zip(kinds, row.values())] for row in rows.to_pylist()]
            self.assertEqual(found, expected, path.name)
            frame = pandas.read_parquet(path)
            self.assertEqual((len(frame), list(frame.columns)), (len(expected), text[0]))
            asked = duckdb.sql(f"SELECT * FROM '{path}'")
            self.assertEqual([[value or None if kind is str else value for kind, value in zip(kinds, row)] for row in asked.fetchall()], expected)
        records = self.out / "export/parquet/records.parquet"
        self.assertEqual(duckdb.sql(f"SELECT kind, count(*) FROM '{records}' GROUP BY kind ORDER BY kind").fetchall(),
                         sorted(collections.Counter(r["kind"] for r in self.records()).items()))

    def test_pictures(self):
        self.write("game.yaml", "schema: 1\nworld: {kind: rcll}\ntier: physics\nduration_s: 5\n")
        self.cxlab("run", "game.yaml", "--quiet", "--out", "out")
        path, _ = self.bag("--pictures", 2, "--size", "160x120")
        pictures = self.messages(path)["/cxlab/camera/field"]
        self.assertEqual([t for t, _ in pictures], [0, 2 * SECOND, 4 * SECOND])
        self.cxlab("render", "out", "--at", 4, "--size", "160x120", "--out", "p.png")
        self.assertEqual(bytes(pictures[-1][1]["data"]), (self.folder / "p.png").read_bytes())
        self.assertEqual(pictures[-1][1]["format"], "png")


if __name__ == "__main__":
    unittest.main()
