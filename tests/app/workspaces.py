"""Workspaces of the CX as they lie: checkouts, install trees and prefixes, with any release of the CX's packages beside the agent."""

import json
import os
import pathlib
import subprocess

from lab import CXLAB, Lab

PLUGINS = """/**:
  ros__parameters:
    environments: ["main"]
    main: {plugins: [PLUGINS]}
    executive: {plugin: "cx::ExecutivePlugin", refresh_rate: 10}
    index: {plugin: "cx::AmentIndexPlugin"}
    ros_msgs: {plugin: "cx::RosMsgsPlugin"}
    protobuf: {plugin: "cx::ProtobufPlugin", pkg_share_dirs: ["rcll_protobuf_msgs"], proto_paths: ["rcll-protobuf-msgs"]}
    files: {plugin: "cx::FileLoadPlugin", pkg_share_dirs: ["greeter", "cx_pddl_clips"], load: [FILES]}
"""
GREET = """(defrule greet => (printout t "good morning" crlf))
(defrule ask
  (not (asked))
  =>
  (assert (asked))
  (ros-msgs-create-client "/clips_manager/list_envs" "cx_msgs/srv/ListClipsEnvs")
  (bind ?q (ros-msgs-create-request "cx_msgs/srv/ListClipsEnvs"))
  (ros-msgs-async-send-request ?q "/clips_manager/list_envs")
  (ros-msgs-destroy-message ?q))
(defrule told
  ?r <- (ros-msgs-response (msg-ptr ?m))
  =>
  (printout t "environments: " (ros-msgs-get-field ?m "envs") crlf)
  (ros-msgs-destroy-message ?m)
  (retract ?r))
(defrule close (executive-finalize) => (ros-msgs-destroy-client "/clips_manager/list_envs"))
"""
# What releases 0.1.1 to 0.1.3 have: no SetTopicLogging, ClipsCommand and Log.
RELEASED = {
    "cx_msgs/srv/CreateClipsEnv.srv": "string env_name\n---\nbool success\nstring error\n",
    "cx_msgs/srv/DestroyClipsEnv.srv": "string env_name\n---\nbool success\nstring error\n",
    "cx_msgs/srv/ListClipsEnvs.srv": "---\nbool success\nstring[] envs\nstring error\n",
    "cx_msgs/srv/ListClipsenvs.srv": "---\nbool success\nstring[] plugins\nstring error\n",
    "cx_msgs/srv/ListClipsPlugins.srv": "string env_name\n---\nbool success\nstring[] plugins\nstring error\n",
    "cx_msgs/srv/LoadClipsPlugin.srv": "string env_name\nstring plugin_name\n---\nbool success\nstring error\n",
    "cx_msgs/srv/UnloadClipsPlugin.srv": "string env_name\nstring plugin_name\n---\nbool success\nstring error\n",
}


def package_xml(name):
    return f'<?xml version="1.0"?>\n<package format="3">\n  <name>{name}</name>\n</package>\n'


class Workspace(Lab):
    def config(self, plugins, files=("clips/greet.clp",)):
        return PLUGINS.replace("PLUGINS", ", ".join(plugins)).replace("FILES", ", ".join(f'"{f}"' for f in files))

    def agent_files(self, rules=GREET, plugins=("executive", "index", "ros_msgs", "files")):
        return {"greeter/params/greeter.yaml": self.config(plugins), "greeter/clips/greet.clp": rules}

    def lay(self, layout, files):
        """Files "PACKAGE/..." in a workspace of that layout; the folder of each package, by name."""
        files = {**files, **{f"{name}/package.xml": package_xml(name) for name in {f.split("/")[0] for f in files}}}
        folders = {}
        for file, text in files.items():
            package, inside = file.split("/", 1)
            source = pathlib.Path("ws/src") / file
            folder = {"checkout": f"ws/src/{package}", "nested checkout": f"ws/src/upstream/{package}", "merged": f"ws/install/share/{package}",
                      "isolated": f"ws/install/{package}/share/{package}", "symlinks": f"ws/install/{package}/share/{package}"}[layout]
            folders[package] = self.folder / folder
            if layout != "symlinks":
                self.write(f"{folder}/{inside}", text)
                continue
            self.write(source, text)
            link = self.folder / folder / inside
            link.parent.mkdir(parents=True, exist_ok=True)
            link.symlink_to(self.folder / source)
        return folders

    def env(self, config, *arguments, code=0, out="none", **environment):
        done = subprocess.run([CXLAB, "env", config, "--until", "1", "--out", out, *map(str, arguments)], cwd=self.folder, text=True, timeout=60,
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, env={**os.environ, **environment})
        self.assertEqual(done.returncode, code, done.stdout)
        return done.stdout

    def assert_greets(self, said):
        self.assertIn("good morning", said)
        self.assertIn("environments: (\"main\")", said)
        self.assertNotIn("[error]", said)
        self.assertNotIn("not offered", said)


class Layouts(Workspace):
    """A released cx_msgs beside the agent."""

    def test_beside_the_agent(self):
        for layout in ("checkout", "nested checkout", "merged", "isolated", "symlinks"):
            with self.subTest(layout):
                self.setUp()
                folders = self.lay(layout, {**self.agent_files(), **RELEASED})
                self.assert_greets(self.env(folders["greeter"] / "params/greeter.yaml"))

    def test_below_prefixes(self):
        for layout in ("merged", "isolated", "symlinks"):
            folders = None
            for how in ("option", "variable", "one prefix for each package"):
                with self.subTest(f"{layout}, {how}"):
                    self.setUp()
                    folders = self.lay(layout, {**self.agent_files(), **RELEASED})
                    config = self.write("elsewhere/greeter.yaml", self.config(["executive", "index", "ros_msgs", "files"]))
                    prefix = self.folder / "ws/install"
                    prefixes = [f.parent.parent for f in folders.values()] if how.startswith("one") else [prefix]
                    options = [word for p in prefixes for word in ("--prefix", p)] if how == "option" else []
                    variable = {} if how == "option" else {"CXLAB_PREFIX_PATH": ":".join(map(str, prefixes))}
                    self.assert_greets(self.env(config, *options, **variable))
        self.assertTrue(folders)

    def test_named(self):
        folders = self.lay("nested checkout", {**self.agent_files(), **RELEASED})
        config = self.write("elsewhere/greeter.yaml", self.config(["executive", "index", "ros_msgs", "files"]))
        self.assert_greets(self.env(config, *[word for name, folder in folders.items() for word in ("--package", f"{name}={folder}")]))

    def test_a_prefix_that_is_none(self):
        (self.folder / "empty").mkdir()
        said = self.env(self.write("greeter.yaml", self.config([])), "--prefix", "empty", code=3)
        self.assertIn("empty: cannot read its folder share", said)

    def test_rules_read_linked_files_of_their_package_and_no_others(self):
        files = {**self.agent_files("""(defrule load
  =>
  (load* (str-cat (ament-index-get-package-share-directory "greeter") "/clips/more.clp"))
  (load* (str-cat (ament-index-get-package-share-directory "greeter") "/clips/secret.clp")))
"""), "greeter/clips/more.clp": '(defrule more => (printout t "more is there" crlf))\n'}
        folders = self.lay("symlinks", files)
        secret = self.write("home/clips/secret.clp", '(defrule secret => (printout t "secret is out" crlf))\n')
        (folders["greeter"] / "clips/secret.clp").symlink_to(secret)
        said = self.env(folders["greeter"] / "params/greeter.yaml")
        self.assertIn("more is there", said)
        self.assertNotIn("secret is out", said)
        self.assertIn("secret.clp' is refused", said)


class Definitions(Workspace):
    """Each type is the workspace's, where it has one."""

    def play(self, files, *arguments, code=0, out="none", rules=GREET, layout="checkout"):
        folders = self.lay(layout, {**self.agent_files(rules), **files})
        return self.env(folders["greeter"] / "params/greeter.yaml", *arguments, code=code, out=out)

    def test_a_type_of_the_workspace_wins(self):
        said = self.play({"cx_msgs/srv/ListClipsEnvs.srv": "---\nbool success\nstring[] envs\nstring error\nint32 count 7\n",
                          "std_msgs/msg/String.msg": "string data\nstring more \"and more\"\n"}, rules=GREET + """
(defrule look
  =>
  (bind ?m (ros-msgs-create-message "std_msgs/msg/String"))
  (printout t "own: " (ros-msgs-get-field ?m "more") crlf)
  (ros-msgs-destroy-message ?m)
  (bind ?m (ros-msgs-create-message "std_msgs/msg/Int64"))
  (printout t "built in: " (ros-msgs-get-field ?m "data") crlf)
  (ros-msgs-destroy-message ?m))
(defrule count (declare (salience 1)) (ros-msgs-response (msg-ptr ?m)) => (printout t "count: " (ros-msgs-get-field ?m "count") crlf))
""")
        self.assert_greets(said)
        for line in ("own: and more", "built in: 0", "count: 7"):
            self.assertIn(line, said)

    def test_nested_types_are_resolved_each(self):
        said = self.play({"geometry_msgs/msg/Point.msg": "float64 x\nfloat64 y\nfloat64 z\nstring who \"workspace\"\n"}, rules="""
(defrule look
  =>
  (bind ?m (ros-msgs-create-message "geometry_msgs/msg/Pose"))
  (bind ?p (ros-msgs-get-field ?m "position"))
  (printout t "point of " (ros-msgs-get-field ?p "who") crlf)
  (ros-msgs-destroy-message ?m))
""")
        self.assertIn("point of workspace", said)

    def test_a_service_that_lacks_a_field_is_not_offered(self):
        for text, what in (("string env_name\n---\nbool success\nstring error\n", "'cx_msgs/srv/LoadClipsPlugin_Request' has no field 'plugin_name' (string)"),
                           ("string env_name\nint32 plugin_name\n---\nbool success\nstring error\n", "has the field 'plugin_name' as int32 instead of string"),
                           ("string env_name\nstring[] plugin_name\n---\nbool success\nstring error\n", "has the field 'plugin_name' as string[] instead of string"),
                           ("string env_name\nstring plugin_name\n---\nbool ok\nstring error\n", "'cx_msgs/srv/LoadClipsPlugin_Response' has no field 'success' (bool)")):
            with self.subTest(what):
                self.setUp()
                said = self.play({**RELEASED, "cx_msgs/srv/LoadClipsPlugin.srv": text}, out="out")
                self.assertIn("environments: (\"main\")", said)
                self.assertEqual(said.count("service /clips_manager/load_plugin is not offered: "), 2, said)  # in the log, and at the end
                self.assertIn("src/cx_msgs/srv/LoadClipsPlugin.srv: ", said)
                self.assertIn(what, said)
                self.assertNotIn("unload_plugin is not", said)
                self.assertIn(what, json.loads((self.out / "result.json").read_text())["warnings"][0])
                replayed = subprocess.run([CXLAB, "replay", self.out], text=True, timeout=60, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
                self.assertEqual(replayed.returncode, 0, replayed.stdout)

    def test_topics_and_actions_that_lack_a_field(self):
        said = self.play({"cx_msgs/msg/Log.msg": "string env_name\nstring text\n", "lifecycle_msgs/msg/TransitionEvent.msg": "uint64 timestamp\n",
                          "rcl_interfaces/msg/ParameterEvent.msg": "string node\n"}, "--param", "clips_manager.main.log_clips_to_topic=true")
        self.assertIn("good morning", said)
        self.assertIn("topic /clips_manager/clips_log is not offered: ", said)
        self.assertIn("'cx_msgs/msg/Log' has no field 'logical_name' (string)", said)
        self.assertIn("topic /clips_manager/transition_event is not offered: ", said)
        self.assertIn("topic /parameter_events is not offered: ", said)
        self.setUp()
        said = self.play({"cx_pddl_interfaces/action/PlanTemporal.action": "string pddl_instance\n---\nbool success\n---\n",
                          "cx_pddl_interfaces/srv/AddFluents.srv": "---\nbool success\nstring error\n"}, "--with", "pddl_manager")
        self.assertIn("action /pddl_manager/temp_plan is not offered: ", said)
        self.assertIn("service /pddl_manager/add_fluents is not offered: ", said)
        self.assertEqual(said.count("is not offered"), 4)

    def test_a_missing_need_of_a_node_is_an_error(self):
        said = self.play({"cxlab_skills/action/Pick.action": "string target\n---\nbool success\n---\n"}, "--with", "rcll", code=3)
        self.assertIn("src/cxlab_skills/action/Pick.action", said)
        self.assertIn("has no field 'error_code' (uint16), which cxlab needs", said)

    def test_a_field_with_a_default_may_be_lacking(self):
        self.play({"cxlab_skills/action/Pick.action": "string target\n---\nbool success\nuint16 error_code\nstring error\nstring target\n---\nstring phase\nfloat64 remaining_m\n"}, "--with", "rcll")

    def test_a_definition_that_is_wrong_is_an_error(self):
        said = self.play({"cx_msgs/srv/ListClipsEnvs.srv": "---\nbool success\nstrin[] envs\n"}, code=3)
        self.assertIn("src/cx_msgs/srv/ListClipsEnvs.srv:3: found type 'strin[]'", said)

    def test_doc_shows_what_a_run_takes(self):
        folders = self.lay("checkout", {"cx_msgs/srv/ListClipsEnvs.srv": "---\nbool success\nstring[] envs\nstring error\nint32 count\n"})
        show = lambda name: subprocess.run([CXLAB, "doc", name, "--package", f"cx_msgs={folders['cx_msgs']}"], text=True, stdout=subprocess.PIPE, check=True).stdout
        self.assertIn("int32 count", show("cx_msgs/srv/ListClipsEnvs"))
        self.assertIn("string command", show("cx_msgs/srv/ClipsCommand"))


class OtherFiles(Workspace):
    """Files of packages that come with cxlab, which the workspace's package of that name lacks."""

    def test_messages_of_the_league_without_their_submodule(self):
        rules = '(defrule make => (bind ?m (pb-create "llsf_msgs.GameState")) (printout t "made " (pb-field-names ?m) crlf) (pb-destroy ?m))\n'
        for empty in (True, False):
            with self.subTest(empty):
                self.setUp()
                folders = self.lay("checkout", {**self.agent_files(rules, ("executive", "protobuf", "files")), "rcll_protobuf_msgs/CMakeLists.txt": ""})
                if empty:
                    (folders["rcll_protobuf_msgs"] / "rcll-protobuf-msgs").mkdir()
                said = self.env(folders["greeter"] / "params/greeter.yaml", out="out")
                self.assertIn("made (game_time", said)
                replayed = subprocess.run([CXLAB, "replay", self.out], text=True, timeout=60, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
                self.assertEqual(replayed.returncode, 0, replayed.stdout)
                self.assertEqual(self.env(folders["greeter"] / "params/greeter.yaml", "--force", out="out").count("made (game_time"), 1)

    def test_own_messages_of_the_league_win(self):
        rules = '(defrule make => (bind ?m (pb-create "llsf_msgs.GameState")) (printout t "made " (pb-field-names ?m) crlf) (pb-destroy ?m))\n'
        folders = self.lay("checkout", {**self.agent_files(rules, ("executive", "protobuf", "files")),
                                        "rcll_protobuf_msgs/rcll-protobuf-msgs/Mine.proto": 'syntax = "proto2";\npackage llsf_msgs;\nmessage GameState { optional string mine = 1; }\n'})
        self.assertIn("made (mine)", self.env(folders["greeter"] / "params/greeter.yaml"))

    def test_rules_that_the_package_lacks(self):
        rules = """(defrule load
  =>
  (bind ?share (ament-index-get-package-share-directory "cx_pddl_clips"))
  (load* (str-cat ?share "/clips/cx_pddl_clips/saliences.clp"))
  (printout t "own " (any-defglobals) crlf))
(deffunction any-defglobals () (length$ (get-defglobal-list)))
"""
        rules = "\n".join(reversed(rules.split("(deffunction"))).replace(" any-defglobals () ", "(deffunction any-defglobals () ", 1)
        folders = self.lay("checkout", {**self.agent_files(rules), "cx_pddl_clips/clips/cx_pddl_clips/own.clp": "(defglobal ?*OWN* = 1)\n",
                                        "greeter/params/greeter.yaml": self.config(["executive", "index", "files"], ["clips/cx_pddl_clips/own.clp", "clips/greet.clp"])})
        said = self.env(folders["greeter"] / "params/greeter.yaml", out="out")
        self.assertRegex(said, r"own [1-9][0-9]+")
        self.assertTrue(list((self.out / "files").iterdir()))
        replayed = subprocess.run([CXLAB, "replay", self.out], text=True, timeout=60, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.assertEqual(replayed.returncode, 0, replayed.stdout)
