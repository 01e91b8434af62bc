"""cxlab export: the same bytes each time, a trace that follows the rules of its format, tables, and errors."""

import collections
import csv
import json
import shutil
import subprocess
import unittest

from lab import CXLAB, SOURCE, Lab

RULES = """(deftemplate decision (slot what) (slot number))
(defrule decide (time ?) (not (done)) => (assert (done) (decision (what "a, \\"b\\"") (number 3))))
"""


class Exports(Lab):
    def cxlab(self, *arguments, code=0):
        done = subprocess.run([CXLAB, *map(str, arguments)], cwd=self.folder, text=True, capture_output=True, timeout=200)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done

    def game(self, *arguments):
        self.cxlab("run", SOURCE / "scenarios/rcll/game.yaml", "--tier", "timed", "--until", 150, "--seed", 1, "--quiet", "--out", "out", *arguments)

    def files(self, folder):
        return {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}

    def test_the_same_run_gives_the_same_bytes(self):
        self.game("--journal", "full")
        before = self.files(self.out)
        said = self.cxlab("export", "out", "--mcap", "--trace", "--csv")
        self.assertNotIn("note:", said.stderr)
        first = self.files(self.out / "export")
        self.assertEqual({name for name in self.files(self.out) if name.parts[0] != "export"}, set(before))
        self.assertLessEqual({"out.mcap", "out.foxglove.json", "out.trace.json", "csv/records.csv", "csv/orders.csv"}, {str(name) for name in first})
        self.assertEqual(said.stdout.split(), [f"out/export/{name}" for name in said.stdout.replace("out/export/", "").split()])
        shutil.copytree(self.out, self.folder / "elsewhere/out", ignore=shutil.ignore_patterns("export"))
        self.cxlab("export", "elsewhere/out", "--mcap", "--trace", "--csv", "-o", "new")
        self.assertEqual(self.files(self.folder / "new"), first)
        self.cxlab("export", "out", "--mcap", "-o", "one.mcap")
        self.assertEqual((self.folder / "one.mcap").read_bytes(), first[min(n for n in first if n.suffix == ".mcap")])
        self.assertFalse(list(self.folder.rglob("*.part")))

    def test_trace_of_a_killed_run_has_the_running_skills(self):
        self.game("--journal", "full")
        lines = [line for line in (self.out / "journal.jsonl").read_text().splitlines() if json.loads(line)["t"] <= 100e9]
        (self.out / "journal.jsonl").write_text("".join(line + "\n" for line in lines))
        result = json.loads((self.out / "result.json").read_text())
        result |= {"status": "failed", "sim_time_s": 0, "stream_hashes": {}, "reason": {"code": "unfinished", "message": "unfinished"}}
        (self.out / "result.json").write_text(json.dumps(result))
        under_way, last = {}, 0
        for record in map(json.loads, lines):
            last = max(last, record["t"])
            if record["kind"] == "skill" and record["data"]["event"] in ("start", "end"):
                under_way[record["stream"]] = record if record["data"]["event"] == "start" else None
        starts = [r for r in under_way.values() if r]
        self.assertTrue(starts)
        self.cxlab("export", "out", "--trace", "-o", "t.json", "--to", 99.9)
        spans = {(e["name"], e["ts"]): e["dur"] for e in json.loads((self.folder / "t.json").read_text())["traceEvents"] if e["ph"] == "X" and e["cat"] == "skill"}
        for record in starts:
            name = f"{record['data']['skill']} {record['data']['target']}"
            if record["t"] < 99.9e9:
                self.assertGreater(spans[name, record["t"] / 1e3], 0, name)

    def test_trace(self):
        self.game("--journal", "full")
        self.cxlab("export", "out", "--trace", "-o", "t.json")
        trace = json.loads((self.folder / "t.json").read_text())
        names, end = {}, json.loads((self.out / "result.json").read_text())["sim_time_s"] * 1e6
        for event in trace["traceEvents"]:
            if event["ph"] == "M":
                key = (event["pid"], event["tid"] if event["name"] == "thread_name" else 0)
                self.assertNotIn(key, names, "each process and thread is named once, before it is used")
                names[key] = event["args"]["name"]
                continue
            self.assertIn((event["pid"], event["tid"]), names)
            self.assertTrue(0 <= event["ts"] <= end, event)
            self.assertIn(event["ph"], "XiC")
            if event["ph"] == "X":
                self.assertGreaterEqual(event["dur"], 0)
        of = lambda process, category: [e for e in trace["traceEvents"] if e["ph"] != "M" and names[e["pid"], 0] == process and e["cat"] == category]
        records = self.records()
        agent = "env/agent"
        self.assertEqual([(e["name"].split("::")[-1], e["args"]["n"]) for e in of(agent, "firing")],
                         [(r["data"]["rule"], r["n"]) for r in records if r["kind"] == "fire" and r["stream"] == agent])
        starts = sorted((r["data"]["robot"], f'{r["data"]["skill"]} {r["data"]["target"]}', r["t"] / 1e3) for r in records if r["kind"] == "skill" and r["data"]["event"] == "start")
        skills = sorted((names[e["pid"], e["tid"]], e["name"], e["ts"]) for e in of("skills", "skill"))
        self.assertGreater(len(starts), 5)
        self.assertEqual(skills, starts)
        for skill in of("skills", "skill"):  # phases lie in their skills, and ends of slices are not after the run
            self.assertLessEqual(skill["ts"] + skill["dur"], end + 1)
        for phase in of("skills", "phase"):
            self.assertTrue(any(s["tid"] == phase["tid"] and s["ts"] <= phase["ts"] and phase["ts"] + phase["dur"] <= s["ts"] + s["dur"] + 1 for s in of("skills", "skill")))
        waits = lambda phases: collections.Counter(name for name in phases if name.startswith("wait"))
        recorded = [r["data"] for r in records if r["kind"] == "skill" and r["data"].get("phase") == "wait"]
        names_of_waits = waits(d["phase"] + (f" for {d['for']}" if "for" in d else "") for d in recorded)
        self.assertTrue(any(name.startswith("wait for robot") for name in names_of_waits), names_of_waits)
        self.assertEqual(waits(e["name"] for e in of("skills", "phase")), names_of_waits)
        for machine in of("machine", "state"):
            self.assertRegex(names[machine["pid"], machine["tid"]], r"^[CM]-")

    def test_tables(self):
        self.agent(RULES)
        self.run_it()
        done = self.cxlab("export", "out", "--csv", "--json")
        files = {file["path"].split("/")[-1]: file for file in json.loads(done.stdout)["files"]}
        with (self.out / "export/csv/records.csv").open(newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(files["records.csv"]["entries"], len(rows))
        self.assertEqual([(r["stream"], int(r["n"]), int(r["t_ns"]), r["kind"], json.loads(r["data"]), r["cause"].split()) for r in rows],
                         [(r["stream"], r["n"], r["t"], r["kind"], r["data"], r["cause"]) for r in self.records()])

    def test_pictures_of_the_timed_tier_come_from_its_scene(self):
        self.game("--set", "world.exploration=false")
        self.cxlab("export", "out", "--mcap", "--pictures", 50, "-o", "bag")
        self.assertIn(b"/cxlab/camera/field", (self.folder / "bag").read_bytes())
        self.cxlab("export", "out", "--trace", "--pictures", 5, code=2)

    def test_parquet_begins_and_ends_as_it_must(self):
        self.agent(RULES)
        self.run_it()
        self.cxlab("export", "out", "--parquet", "-o", "p")
        for path in (self.folder / "p").iterdir():
            text = path.read_bytes()
            self.assertEqual((text[:4], text[-4:]), (b"PAR1", b"PAR1"))
            self.assertLessEqual(int.from_bytes(text[-8:-4], "little"), len(text) - 12)
        self.assertEqual({path.name for path in (self.folder / "p").iterdir()}, {"records.parquet", "skills.parquet", "points.parquet"})

    def test_a_stretch_has_what_lies_in_it(self):
        self.game()
        self.cxlab("export", "out", "--csv", "--from", 30, "--to", "1:00", "-o", "part")
        with (self.folder / "part/records.csv").open(newline="") as file:
            rows = [(r["stream"], int(r["n"])) for r in csv.DictReader(file)]
        self.assertEqual(rows, [(r["stream"], r["n"]) for r in self.records() if 30e9 <= r["t"] <= 60e9])

    def test_missing_parts_are_reported(self):
        self.game()
        said = self.cxlab("export", "out", "--mcap", "--trace").stderr
        self.assertIn("note: the run has no messages of the bus, because its journal has only decisions: cxlab run --journal full records them", said)
        self.assertIn("note: the trace has no firings", said)

    def test_errors(self):
        self.agent(RULES)
        self.run_it("--journal", "full")
        self.assertIn("--mcap, --trace, --csv or --parquet", self.cxlab("export", "out", code=2).stderr)
        self.cxlab("export", "nowhere", "--mcap", code=3)
        self.assertIn("--from: ", self.cxlab("export", "out", "--csv", "--from", 99, code=2).stderr)
        self.assertIn("--from is after --to", self.cxlab("export", "out", "--csv", "--from", 2, "--to", 1, code=2).stderr)
        self.assertIn("is a folder", self.cxlab("export", "out", "--mcap", "-o", "out", code=2).stderr)
        self.write("file", "")
        self.cxlab("export", "out", "--csv", "-o", "file", code=5)
        self.cxlab("export", "out", "--mcap", "-o", "file/a.mcap", code=5)
        # A scenario that cannot be read: no folder is left behind, but one that was there stays.
        (scenario,) = (path for path in (self.out / "files").iterdir() if path.read_bytes().startswith(b"schema: 1"))
        known = scenario.read_text()
        scenario.write_text(known + "world: {kind: grid}\n")
        self.write("kept/note", "")
        for out in ([], ["-o", "new/deep"], ["-o", "kept"], ["--parquet", "-o", "kept/new"]):
            self.assertIn("was changed", self.cxlab("export", "out", "--csv", *out, code=3).stderr)
        self.assertFalse((self.out / "export").exists() or (self.folder / "new").exists())
        self.assertEqual([path.name for path in (self.folder / "kept").iterdir()], ["note"])
        scenario.write_text(known)
        # A record that its definition does not fit: nothing is left behind.
        journal = (self.out / "journal.jsonl").read_text()
        self.assertIn('"op":"publish"', journal)
        (self.out / "journal.jsonl").write_text(journal.replace('"op":"publish","name":', '"op":"publish","nome":'))
        said = self.cxlab("export", "out", "--mcap", "-o", "a.mcap", code=3).stderr
        self.assertRegex(said, r"record node/\S+:\d+ \(publish ")
        self.assertFalse(list(self.folder.rglob("*.mcap*")))
        (self.out / "scene.bin").unlink(missing_ok=True)
        (self.out / "journal.jsonl").unlink()
        self.assertIn("no journal.jsonl", self.cxlab("export", "out", "--trace", "-o", "t.json", code=3).stderr)
        self.run_it("--journal", "none", "--force")
        self.assertIn("without a journal (--journal none)", self.cxlab("export", "out", "--csv", code=3).stderr)


if __name__ == "__main__":
    unittest.main()
