"""cxlab doc, and the pages that are made from the code. python3 -m unittest reference"""

import json
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

from lab import CXLAB, SOURCE


def doc(*arguments):
    return subprocess.run([CXLAB, "doc", *arguments], text=True, timeout=60, stdout=subprocess.PIPE, stderr=subprocess.PIPE)


# Functions of CX by prefix; the last three are those of bindings.
FUNCTIONS_OF_CX = {
    "": "cx-shutdown config-load now now-systime ros-param-get-value",
    "ament-index":
        "get-package-prefix get-package-share-directory get-packages-with-prefixes get-resource get-resources "
        "get-search-paths has-resource",
    "pb":
        "register-type create destroy field-names field-type has-field field-label field-value field-list "
        "field-is-list set-field add-list tostring send server-enable server-disable connect disconnect "
        "peer-create peer-create-local peer-create-crypto peer-create-local-crypto peer-destroy peer-setup-crypto "
        "broadcast",
    "ros-msgs":
        "create-publisher destroy-publisher create-subscription destroy-subscription create-message "
        "destroy-message publish get-field set-field create-client destroy-client create-request "
        "async-send-request create-service destroy-service create-action-client destroy-action-client "
        "create-goal-request async-send-goal async-cancel-goal destroy-client-goal-handle "
        "client-goal-handle-get-goal-id client-goal-handle-get-goal-stamp client-goal-handle-get-status "
        "client-goal-handle-is-feedback-aware client-goal-handle-is-result-aware goal-uuid-to-string",
    "tf2": "start-periodic-lookup stop-periodic-lookup",
    "std-msgs-string":
        "create-message destroy-message get-field set-field create-publisher destroy-publisher create-subscription "
        "destroy-subscription publish",
    "std-srvs-set-bool":
        "create-service destroy-service create-client destroy-client send-request request-create request-destroy "
        "request-get-field request-set-field response-create response-destroy response-get-field "
        "response-set-field",
    "example-interfaces-fibonacci":
        "create-server destroy-server create-client destroy-client send-goal goal-create goal-destroy "
        "goal-get-field goal-set-field feedback-create feedback-destroy feedback-get-field feedback-set-field "
        "result-create result-destroy result-get-field result-set-field client-cancel-goal client-cancel-all-goals "
        "client-cancel-goals-before server-goal-handle-abort server-goal-handle-succeed "
        "server-goal-handle-canceled server-goal-handle-get-goal server-goal-handle-get-goal-id "
        "server-goal-handle-is-canceling server-goal-handle-is-active server-goal-handle-is-executing "
        "server-goal-handle-execute server-goal-handle-publish-feedback server-goal-handle-destroy "
        "client-goal-handle-get-goal-id client-goal-handle-get-goal-stamp client-goal-handle-get-status "
        "client-goal-handle-is-feedback-aware client-goal-handle-is-result-aware client-goal-handle-destroy",
}


class Doc(unittest.TestCase):
    def test_reference_page_is_up_to_date(self):
        page = (SOURCE / "docs/reference/functions.md").read_text()
        self.assertEqual(doc("--markdown").stdout, page, "docs/reference/functions.md is old: cxlab doc --markdown > docs/reference/functions.md")

    def test_page_of_commands_is_up_to_date(self):
        printed = subprocess.run([CXLAB, "man", "--markdown"], text=True, timeout=60, stdout=subprocess.PIPE).stdout
        page = (SOURCE / "docs/reference/commands.md").read_text()
        self.assertEqual(printed, page, "docs/reference/commands.md is old: cxlab man --markdown > docs/reference/commands.md")
        for command in ("cxlab run", "cxlab bench", "cxlab bench show", "cxlab orders"):
            self.assertIn(f"\n## {command}\n", page)

    def test_page_of_errors_has_the_reasons_of_failure(self):
        """Codes of errors in the sources, without those of skills, and of failures that another code replaces."""
        inside = {"code", "stopped", "syntax", "unknown_construct", "place_taken", "no_spare_piece", "gripper_full", "gripper_empty", "no_piece"}
        codes = set()
        for folder in ("cx", "lab", "app", "scenarios", "sim"):
            for file in (*(SOURCE / folder).rglob("*.cpp"), *(SOURCE / folder).rglob("*.h")):
                text = file.read_text()
                codes |= set(re.findall(r'with_code\("(\w+)"\)|(?:\bline|\b0), "([a-z]+_[a-z]+)"\}|constexpr const char\* k\w*(?:Code|Untrusted|Refused) = "(\w+)"', text))
        codes = {word for found in codes for word in found if word}
        result = (SOURCE / "scenarios/result.cpp").read_text()
        codes |= set(re.findall(r'return "(\w+)";', result[result.index("default_code"):result.index("reason_json")]))
        page = (SOURCE / "docs/reference/errors.md").read_text()
        self.assertEqual(set(re.findall(r"^\| `(\w+)` \| [\d-]", page, re.M)), codes - inside)

    def test_scripts_that_pages_run_are_executable(self):
        pages = [SOURCE / "README.md", SOURCE / "CONTRIBUTING.md", SOURCE / "benchmarks/README.md", *(SOURCE / "docs").rglob("*.md")]
        scripts = {script for page in pages for script in re.findall(r"(?:^|^\$ |`)((?:tests|benchmarks)/[\w/]+\.py) ", page.read_text(), re.M)}
        self.assertGreater(len(scripts), 8)
        self.assertEqual([script for script in sorted(scripts) if not os.access(SOURCE / script, os.X_OK)], [])

    def test_one_function(self):
        done = doc("ros-param-get-value")
        self.assertEqual(done.returncode, 0)
        self.assertIn("(ros-param-get-value STRING|SYMBOL anything) -> anything, pure", done.stdout)
        self.assertNotIn("config-load", done.stdout)

    def test_one_template(self):
        done = doc("confval")
        self.assertIn("cx::ConfigPlugin", done.stdout)
        self.assertIn("(multislot list-value)", done.stdout)

    def test_one_plugin(self):
        for name in ("cx::ExecutivePlugin", "ExecutivePlugin"):
            done = doc(name)
            self.assertIn("parameter refresh_rate", done.stdout)
            self.assertIn("(now) -> FLOAT, pure", done.stdout)
            self.assertIn("(defrule time-retract", done.stdout)

    def test_a_class_that_is_made_from_its_name(self):
        done = doc("cx::CXStdMsgsStringPlugin")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("(std-msgs-string-create-message) -> EXTERNAL-ADDRESS", done.stdout)
        self.assertIn("(deftemplate std-msgs-string-message", done.stdout)
        self.assertIn("did you mean 'cx::CXStdMsgsStringPlugin'?", doc("cx::CXStdMsgsStrngPlugin").stderr)

    def test_a_function_of_bindings(self):
        done = doc("std-msgs-string-publish")
        self.assertIn("cx::CXStdMsgsStringPlugin\n  (std-msgs-string-publish EXTERNAL-ADDRESS STRING|SYMBOL) -> nothing, acting", done.stdout)
        self.assertNotIn("create-message", done.stdout)
        self.assertIn("(slot result-ptr", doc("example-interfaces-fibonacci-wrapped-result").stdout)
        self.assertIn("did you mean 'std-msgs-string-publish'?", doc("std-msgs-string-publsh").stderr)

    def test_functions_are_those_of_cx(self):
        """Those that CX does not have must be found by --strict-cx (look_for_own_functions)."""
        def functions(plugin):
            return {function["name"] for function in plugin["functions"]}
        plugins = json.loads(doc("--json").stdout)
        for name in ("StdMsgsString", "StdSrvsSetBool", "ExampleInterfacesFibonacci"):
            plugins += json.loads(doc(f"cx::CX{name}Plugin", "--json").stdout)
        known = {prefix + "-" * bool(prefix) + name for prefix, names in FUNCTIONS_OF_CX.items() for name in names.split()}
        self.assertEqual(set().union(*map(functions, plugins)), known)

    def test_unknown_name(self):
        done = doc("confvl")
        self.assertEqual((done.returncode, done.stdout), (3, ""))
        self.assertIn("did you mean 'confval'?", done.stderr)

    def test_json(self):
        plugins = {p["plugin"]: p for p in json.loads(doc("--json").stdout)}
        load = plugins["cx::ConfigPlugin"]["functions"][0]
        self.assertEqual((load["name"], load["kind"], load["min_args"], load["max_args"], load["gives"]), ("config-load", "acting", 2, 2, "nothing"))
        self.assertTrue(all(f["help"].endswith(".") for p in plugins.values() for f in p["functions"]), "each function has a sentence of help")

    def test_json_of_an_interface(self):
        shown = json.loads(doc("std_msgs/msg/String", "--json").stdout)
        self.assertEqual(shown, {"interface": "std_msgs/msg/String", "text": doc("std_msgs/msg/String").stdout})
        self.assertEqual(doc("std_msgs/msg/String", "--markdown").returncode, 2)

    def test_list_says_the_same(self):
        listed = subprocess.run([CXLAB, "list", "functions"], text=True, timeout=60, stdout=subprocess.PIPE).stdout
        names = [f["name"] for p in json.loads(doc("--json").stdout) for f in p["functions"]]
        self.assertEqual([re.match(r"\(([^ )]+)", line)[1] for line in listed.splitlines()], names)

    def test_each_plugin_has_a_page_and_an_example(self):
        for plugin in json.loads(doc("--json").stdout):
            if not plugin["plugin"].startswith("cx::"):
                continue
            name = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", plugin["plugin"][4:].removesuffix("Plugin")).lower()
            page = (SOURCE / f"docs/reference/plugins/{name}.md").read_text()
            self.assertIn(plugin["plugin"], page.splitlines()[0])
            self.assertIn(f"docs/examples/{name}/example.yaml", page)
            self.assertTrue((SOURCE / f"docs/examples/{name}/example.yaml").is_file(), name)


class Examples(unittest.TestCase):
    def test_each_ends_without_a_complaint_and_replays(self):
        examples = sorted((SOURCE / "docs/examples").glob("*/example.yaml"))
        self.assertTrue(examples)
        for example in examples:
            with self.subTest(example.parent.name), tempfile.TemporaryDirectory() as folder:
                run = pathlib.Path(folder) / "run"
                call = lambda *arguments: subprocess.run([CXLAB, *arguments], text=True, timeout=60, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
                done = call("env", example, "--package", f"example={example.parent}", "--strict-cx", "--until", "5", "--out", run)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertEqual([line for line in done.stderr.splitlines() if "[warn]" in line or "[error]" in line], [])
                replay = call("replay", run, "--rules")
                self.assertEqual(replay.returncode, 0, replay.stdout + replay.stderr)


if __name__ == "__main__":
    unittest.main()
