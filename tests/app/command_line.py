"""What all commands share: help, options, colours, signals, completion, man page. python3 -m unittest command_line"""

import json
import os
import pathlib
import pty
import re
import resource
import shutil
import signal
import subprocess
import time

from lab import CXLAB, SOURCE, Lab

GAME = SOURCE / "scenarios/rcll/game.yaml"


def cxlab(*arguments, **options):
    return subprocess.run([CXLAB, *map(str, arguments)], capture_output=True, text=True, timeout=60, **options)


class Help(Lab):
    def test_help_is_a_command_too(self):
        self.assertEqual(cxlab("help").stdout, cxlab("--help").stdout)
        self.assertEqual(cxlab("help", "run").stdout, cxlab("run", "--help").stdout)
        self.assertEqual(cxlab("help", "new", "agent").stdout, cxlab("new", "agent", "--help").stdout)
        wrong = cxlab("help", "rnu")
        self.assertEqual(wrong.returncode, 2)
        self.assertIn("there is no command 'rnu', did you mean 'run'?", wrong.stderr)

    def test_a_misspelt_option_gets_a_suggestion(self):
        for arguments, message in [
                (["run", GAME, "--sed", "7"], "there is no option '--sed', did you mean '--seed'?"),
                (["run", GAME, "--untill=3"], "there is no option '--untill', did you mean '--until'?"),
                (["plan", "d", "p", "--any-time"], "there is no option '--any-time', did you mean '--anytime'?"),
                (["run", GAME, "--xyzzyx"], "there is no option '--xyzzyx'\n"),
                (["run", GAME, "another.yaml"], "one argument too many: 'another.yaml'")]:
            done = cxlab(*arguments)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn(message, done.stderr)

    def test_the_manual_page_has_every_command_and_option(self):
        page = cxlab("man").stdout
        names = [line.split()[0] for line in cxlab("--help").stdout.split("Subcommands:")[1].split("Exit codes")[0].splitlines() if line]
        self.assertGreater(len(names), 15)
        for name in names:
            self.assertIn(f".SS cxlab {name}".replace("-", "\\-"), page)
        for option in ["--seed", "--snapshot", "--anytime", "--with", "--coverage"]:
            self.assertIn("\\fB" + option.replace("-", "\\-"), page)
        self.assertNotRegex(page, r"(?m)^\.(?!TH|SH|SS|TP|PP|nf|fi)")
        if shutil.which("groff"):
            done = subprocess.run(["groff", "-man", "-Tutf8", "-ww"], input=page, capture_output=True, text=True)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            self.assertIn("\nEXIT STATUS\n", re.sub(".\b", "", done.stdout))


SCENARIOS = [line.split()[0] for line in cxlab("list", "scenarios").stdout.splitlines()]


class Completion(Lab):
    def complete(self, *words):
        """What bash offers for the last word."""
        script = """
source <("$CXLAB" completion bash)
COMP_WORDS=(cxlab "$@"); COMP_CWORD=$#
_cxlab
printf '%s\\n' "${COMPREPLY[@]}"
"""
        done = subprocess.run(["bash", "-c", script, "bash", *words], capture_output=True, text=True, cwd=self.folder)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return done.stdout.split()

    def test_bash_offers_commands_options_values_and_files(self):
        self.write("game.yaml", "")
        self.assertEqual(self.complete("re"), ["replay", "rerun", "render"])
        self.assertIn("--snapshot", self.complete("run", "--s"))
        self.assertNotIn("--anytime", self.complete("run", "--"))
        self.assertIn("--anytime", self.complete("plan", "--a"))
        self.assertEqual(self.complete("run", "--tier", ""), ["physics", "timed"])
        self.assertEqual(self.complete("list", "f"), ["functions", "faults"])
        self.assertEqual(self.complete("new", "p"), ["plugin"])
        self.assertEqual(self.complete("run", "ga"), ["game.yaml"])
        self.assertEqual(self.complete("run", "rcll/ga"), [name for name in SCENARIOS if name.startswith("rcll/ga")])
        self.assertEqual(self.complete("render", "turtlesim/b"), [name for name in SCENARIOS if name.startswith("turtlesim/b")])
        self.assertEqual(self.complete("env", "--with", "tu"), ["turtlesim"])
        self.assertEqual(self.complete("doc", "config-l"), ["config-load"])
        self.assertEqual(self.complete("doc", "std_srvs/srv/Set"), ["std_srvs/srv/SetBool"])
        self.assertEqual(self.complete("doc", "ConfigP"), ["ConfigPlugin"])

    def test_the_script_for_zsh_names_every_command(self):
        script = cxlab("completion", "zsh").stdout
        self.assertTrue(script.startswith("#compdef cxlab\n"))
        for text in ["'run:Play a scenario'", "'--tier[", ":value:(physics timed)'", "    why-not) _arguments", "'*:argument:_cxlab_run' ;;", f"_cxlab_run() {{ _alternative 'names:name:({' '.join(SCENARIOS)})' 'files:file:_files' }}",
                     "(agent plugin game story)", " config-load "]:
            self.assertIn(text, script)
        if shutil.which("zsh"):
            done = subprocess.run(["zsh", "-n"], input=script, capture_output=True, text=True)
            self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_another_shell_is_wrong_usage(self):
        self.assertEqual(cxlab("completion", "fish").returncode, 2)


class Output(Lab):
    def on_terminal(self, *arguments, **variables):
        """What the command writes to stderr where that is a terminal."""
        controller, terminal = pty.openpty()
        environment = {k: v for k, v in os.environ.items() if k != "NO_COLOR"} | {"TERM": "xterm"} | variables
        subprocess.run([CXLAB, *map(str, arguments)], stdout=subprocess.DEVNULL, stderr=terminal, env=environment, cwd=self.folder)
        os.close(terminal)
        text = b""
        try:
            while chunk := os.read(controller, 4096):
                text += chunk
        except OSError:  # all was read
            pass
        os.close(controller)
        return text.decode()

    def test_colours_are_for_terminals_that_want_them(self):
        wrong = ["run", "missing.yaml"]
        self.assertIn("\x1b[1;31merror:\x1b[0m missing.yaml", self.on_terminal(*wrong))
        self.assertTrue(self.on_terminal(*wrong, NO_COLOR="1").startswith("error: missing.yaml"))
        self.assertTrue(self.on_terminal(*wrong, TERM="dumb").startswith("error: missing.yaml"))
        self.assertIn("\x1b[", self.on_terminal(*wrong, NO_COLOR=""))
        self.assertTrue(cxlab(*wrong).stderr.startswith("error: missing.yaml"))

    def test_quiet_prints_nothing_on_stderr(self):
        self.agent('(defrule once (not (said)) => (assert (said)) (printout t "hello" crlf))')
        self.assertEqual(self.run_it().stderr, "")
        loud = cxlab("run", "scenario.yaml", "--out", "again", cwd=self.folder)
        self.assertIn("run: again\n", loud.stderr)
        self.assertIn("hello", loud.stderr)

    def test_a_run_that_ends_before_until_says_what_ends_it(self):
        (self.folder / "empty.yaml").write_text("schema: 1\nduration_s: 2\n")
        run = ["run", self.folder / "empty.yaml", "--out", self.folder / "run", "--force", "--until"]
        said = "ended after 2.000 s, the scenario's duration_s; for longer: --set duration_s=3"
        self.assertIn(said, cxlab(*run, "3").stderr)
        self.assertNotIn("duration_s", cxlab(*run, "2").stderr)
        self.assertNotIn("duration_s", cxlab(*run, "3", "--set", "duration_s=3").stderr)

    def test_an_error_of_a_file_is_shown_once(self):
        self.agent("(defrule broken (time ?) => (no-such-function))")
        loud = cxlab("env", "agent.yaml", "--package", "rules=rules", "--until", 1, "--out", "none", cwd=self.folder)
        self.assertEqual(loud.returncode, 3)
        self.assertEqual(loud.stderr.count("rules.clp:1: "), 1, loud.stderr)
        self.assertTrue(loud.stderr.endswith("errors: 1, reported in the log above\n"), loud.stderr)
        quiet = cxlab("env", "agent.yaml", "--package", "rules=rules", "--until", 1, "--out", "none", "--quiet", cwd=self.folder)
        self.assertEqual(quiet.returncode, 3)
        self.assertRegex(quiet.stderr, r"\Aerror: \S*rules.clp:1: .*\n\Z")

    def test_quiet_leaves_errors_of_rules(self):
        self.agent("(defrule broken (time ?) => (/ 1 0))\n(defrule other (time ?) => (nth$ 1 (create$)) (mod 1 0))")
        quiet = cxlab("env", "agent.yaml", "--package", "rules=rules", "--until", 1, "--out", "none", "--quiet", cwd=self.folder)
        self.assertEqual(quiet.returncode, 0)
        lines = {line.split("rules.clp:")[1] for line in quiet.stderr.splitlines()}
        self.assertEqual(lines, {"1: rule broken, RHS: [PRNTUTIL7] Attempt to divide by zero in '/' function.",
                                 "2: rule other, RHS: [PRNTUTIL7] Attempt to divide by zero in 'mod' function."})

    def test_quiet_leaves_what_rules_print_as_an_error(self):
        self.agent('(defrule once (not (said)) => (assert (said)) (printout warn "hm" crlf) (printout error "no" crlf))')
        self.assertEqual(self.run_it().stderr, "[    0.000] [error] [main] no\n")

    def test_rules_get_the_same_answers_without_a_folder(self):
        self.agent("""(defrule files => (printout t (open "a.txt" f "w") (close f) (open "a.txt" f "r") (readline f) (remove "b.txt")
  (rename "a.txt" "c.txt") (save-facts "d.txt") crlf))""")
        hashes = {json.loads(self.run_it("--json", "--out", out, out=False).stdout)["journal_hash"] for out in ("none", "out")}
        self.assertEqual(len(hashes), 1)

    def test_an_error_with_the_path_of_the_run_is_the_same_everywhere(self):
        self.agent('(defrule nameless => (save-facts ""))')
        hashes = set()
        for out in ("none", "out", "rules/inside"):
            done = cxlab("env", "agent.yaml", "--package", "rules=rules", "--until", 1, "--json", "--out", out, cwd=self.folder)
            self.assertIn("was unable to open file", done.stderr)
            hashes.add(json.loads(done.stdout)["journal_hash"])
            if out != "none":
                again = cxlab("replay", out, cwd=self.folder)
                self.assertEqual(again.returncode, 0, again.stdout)
        self.assertEqual(len(hashes), 1)

    def test_set_takes_one_value(self):
        self.agent("")
        done = cxlab("run", "--out", "none", "--set", "seed=3", "scenario.yaml", "--set", "duration_s=1", "--json", "--quiet",
                     cwd=self.folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        result = json.loads(done.stdout)
        self.assertEqual((result["seed"], result["sim_time_s"]), (3, 1))

    def test_whole_numbers_are_decimal(self):
        self.agent("")
        for text in ("010", "+10", "10"):
            done = cxlab("run", "--out", "none", "scenario.yaml", "--seed", text, "--json", "--quiet", cwd=self.folder)
            self.assertEqual(json.loads(done.stdout)["seed"], 10, text)

    def test_a_time_may_have_minutes(self):
        self.agent("")
        run = ["run", "--out", "none", "scenario.yaml", "--set", "duration_s=4000", "--json", "--quiet", "--until"]
        for text, seconds in (("312.4", 312.4), ("5:12.4", 312.4), ("5:12", 312), ("0:00.25", 0.25), ("65:07", 3907), ("0:00", 0)):
            done = cxlab(*run, text, cwd=self.folder)
            self.assertEqual(done.returncode, 0, done.stderr)
            # The last tick is the first that is not before it.
            self.assertAlmostEqual(json.loads(done.stdout)["sim_time_s"], seconds, delta=0.1, msg=text)
        for text in ("5:60", "5:1", "5:123", ":12", "5:", "-5:12", "5:-2", "5:12.", "5:12.x", "1:05:12", "5.5:12", "+5:12", "1e3:00", "99999999999:00", "1000000001"):
            done = cxlab(*run, text, cwd=self.folder)
            self.assertEqual(done.returncode, 2, text)
            self.assertIn(f"--until: found '{text}', expected a time: s from 0 to 1e9, as 312.4, or minutes and s, as 5:12.4", done.stderr)

    def test_a_failed_run_has_no_score_board(self):
        self.agent("(defrule wrong (time ?) => (+ 1 (nth$ 1 (create$ one))))", "schema: 1\nworld: {kind: rcll}\ntier: timed\n"
                   "packages: {rules: rules}\nagents:\n  - config: agent.yaml\n")
        done = self.run_it()
        self.assertEqual(done.returncode, 4)
        self.assertEqual(done.stdout.splitlines(), ["failed after 0.000 s of simulated time", f"file://{self.out}/index.html"])

    def test_the_address_of_the_page_is_one_for_any_name_of_a_folder(self):
        self.agent("")
        for name in ("plain", "a b#c?d%20é<1>"):
            done = cxlab("run", "scenario.yaml", "--quiet", "--out", self.folder / name, cwd=self.folder)
            self.assertEqual(done.stdout.splitlines()[-1], (self.folder / name / "index.html").as_uri())

    def test_a_picture_that_cannot_be_made_is_code_5(self):
        self.agent("")
        self.fails(5, "no pictures: the world is empty", arguments=["--snapshot", "1"])


class Interfaces(Lab):
    def test_an_interface_is_shown_with_its_nested_fields(self):
        text = cxlab("doc", "rcll_interfaces/msg/OrderInfo").stdout
        self.assertIn("Order[] orders", text)
        self.assertIn("\n\tuint32 id\n", text)
        self.assertEqual(cxlab("doc", "rcll_interfaces/msg/Order").stdout,
                         (SOURCE / "cx/interfaces/rcll_interfaces/msg/Order.msg").read_text())

    def test_interfaces_can_be_listed(self):
        names = cxlab("list", "interfaces").stdout.split()
        for name in ["rcll_interfaces/msg/Order", "std_srvs/srv/SetBool", "rcll_interfaces/action/InstructMachine"]:
            self.assertIn(name, names)

    def test_those_of_own_packages_are_there(self):
        self.write("own/msg/Mine.msg", "int32 value\n")
        self.assertEqual(cxlab("doc", "own/msg/Mine", "--package", f"own={self.folder}/own").stdout, "int32 value\n")
        done = cxlab("doc", "own/msg/Mine")
        self.assertEqual(done.returncode, 3)
        self.assertIn("there is no interface 'own/msg/Mine'", done.stderr)


class Signals(Lab):
    def interrupted(self, *arguments, after, number=signal.SIGINT):
        """The command, ended by a signal when stderr has said `after`, or after seconds; a second of CPU time is enough."""
        process = subprocess.Popen([CXLAB, *map(str, arguments)], cwd=self.folder, text=True, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE)
        said = ""
        if isinstance(after, str):
            for line in process.stderr:
                said += line
                if after in line:
                    break
        else:
            time.sleep(after)
        self.assertIsNone(process.poll(), said)
        cpu = lambda usage: usage.ru_utime + usage.ru_stime
        fields = pathlib.Path(f"/proc/{process.pid}/stat").read_text().rsplit(")", 1)[1].split()
        used = (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
        before = cpu(resource.getrusage(resource.RUSAGE_CHILDREN))
        process.send_signal(number)
        out, err = process.communicate(timeout=60)
        self.assertLess(cpu(resource.getrusage(resource.RUSAGE_CHILDREN)) - before - used, 1)
        self.assertEqual(process.returncode, 128 + number, said + err)
        return out, said + err

    def test_replay_ends(self):
        self.agent("(defrule count ?n <- (n ?i) (time ?) => (retract ?n) (assert (n (+ ?i 1))))\n(deffacts n (n 0))",
                   "schema: 1\nmax_firings_per_tick: 1000000\npackages: {rules: rules}\nagents:\n  - config: agent.yaml\n")
        self.run_it("--journal", "none")
        for half in ["--rules"]:
            out, _ = self.interrupted("replay", "out", half, after=0.3)
            self.assertEqual(out, "")

    def test_run_says_that_it_was_interrupted(self):
        for command, number, tick in [(("run", GAME, "--tier", "timed"), signal.SIGTERM, 0.3), (("env", SOURCE / "docs/examples/hello/hello.yaml"), signal.SIGINT, 1.1)]:
            out, err = self.interrupted(*command, "--realtime", "--quiet", "--out", "out", "--force", after=1.5, number=number)
            end = self.result()["sim_time_s"]
            self.assertRegex(out, rf"^interrupted after {end:.3f} s of simulated time")
            self.assertIn(f"interrupted: by {number.name}; the run ended after {end:.3f} s of simulated time, and out has it up to then\n", err)
            self.assertIn(">interrupted by a signal</b> after 0:0", (self.out / "index.html").read_text())
            self.assertAlmostEqual(self.result()["wall_time_s"], end, delta=tick)  # in real time
            self.assertAlmostEqual(self.result()["real_time_factor"], 1, delta=tick)

    def test_a_signal_that_comes_twice_is_one_and_a_later_one_ends_at_once(self):
        self.agent("(deffacts d (go))\n(defrule stranger (go) => (while TRUE do (format nil \"%9999d\" 1)))")
        for pause, said in [(0, "rule stranger: stopped by a signal"), (0.2, "interrupted: by a second signal, wherever it was")]:
            process = subprocess.Popen([CXLAB, "run", "scenario.yaml", "-v", "--out", "out", "--force", "--steps", "0"], cwd=self.folder, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
            for line in process.stderr:
                if "Created plugin: files" in line:
                    break
            time.sleep(0.3)
            process.send_signal(signal.SIGINT)
            time.sleep(pause or 0.02)
            process.send_signal(signal.SIGINT)
            _, err = process.communicate(timeout=20)
            self.assertEqual(process.returncode, 128 + signal.SIGINT, err)
            self.assertIn(said, err)

    def test_reading_files_ends_with_a_line_too(self):
        # A template that takes seconds: 20 million steps are allowed.
        self.write("d.pddl", "{% for i in range(9999) %}{% for j in range(9999) %}{% if i < 0 %}x{% endif %}{% endfor %}{% endfor %}")
        self.write("p.pddl", "(define (problem p) (:domain d))")
        self.write("x.plan", "0: (a)\n")
        for number in [signal.SIGINT, signal.SIGTERM]:
            for command in [["plan", "d.pddl", "p.pddl"], ["validate", "d.pddl", "p.pddl", "x.plan"]]:
                process = subprocess.Popen([CXLAB, *command], cwd=self.folder, text=True, stderr=subprocess.PIPE)
                time.sleep(0.3)
                process.send_signal(number)
                _, err = process.communicate(timeout=2)
                self.assertEqual(process.returncode, 128 + number, err)
                self.assertIn(f"interrupted: by {number.name}, in the middle of its work", err)

    def test_plan_prints_what_it_has_found(self):
        places = [f"p{i}" for i in range(60)]
        roads = " ".join(f"(road {a} {b})" for a in places for b in places if a != b)
        self.write("d.pddl", """(define (domain d) (:types place)
  (:predicates (at ?p - place) (road ?a ?b - place) (seen ?p - place))
  (:functions (length ?a ?b - place))
  (:durative-action go :parameters (?a ?b - place) :duration (= ?duration (length ?a ?b))
    :condition (and (at start (at ?a)) (over all (road ?a ?b)))
    :effect (and (at start (not (at ?a))) (at end (at ?b)) (at end (seen ?b)))))""")
        lengths = " ".join(f"(= (length {a} {b}) {1 + (7 * i + 13 * k) % 29})" for i, a in enumerate(places) for k, b in enumerate(places))
        self.write("p.pddl", f"(define (problem p) (:domain d) (:objects {' '.join(places)} - place) (:init (at p0) {roads} {lengths})"
                             f" (:goal (and {' '.join(f'(seen {p})' for p in places[1:])})))")
        for number in [signal.SIGINT, signal.SIGTERM]:
            out, err = self.interrupted("plan", "d.pddl", "p.pddl", "--anytime", "--budget", 10**12, after="plan: ", number=number)
            self.assertIn("plan: interrupted", err)
            self.assertIn(f"interrupted: by {number.name}; the answer is the best plan so far", err)
            self.write("found.plan", out)
            judged = cxlab("validate", "d.pddl", "p.pddl", "found.plan", cwd=self.folder)
            self.assertEqual(judged.returncode, 0, judged.stdout)

    def test_bench_takes_its_episodes_along(self):
        self.agent("(defrule count ?n <- (n ?i) (time ?) => (retract ?n) (assert (n (+ ?i 1))))\n(deffacts n (n 0))",
                   "schema: 1\nduration_s: 1000000\npackages: {rules: rules}\nagents:\n  - config: agent.yaml\n")
        self.write("suite.yaml", "scenarios: [scenario.yaml]\nseeds: [1, 2, 3]\nstrategies: {s: }\n")
        for number in [signal.SIGINT, signal.SIGKILL]:
            process = subprocess.Popen([CXLAB, "bench", "suite.yaml", "-j", "2", "--out", "o"], cwd=self.folder, text=True, stderr=subprocess.PIPE)
            children = []
            for _ in range(500):
                time.sleep(0.02)
                children = subprocess.run(["ps", "-o", "pid=", "--ppid", str(process.pid)], capture_output=True, text=True).stdout.split()
                if len(children) == 2:
                    break
            self.assertEqual(len(children), 2)
            process.send_signal(number)
            _, said = process.communicate(timeout=10)
            if number == signal.SIGINT:
                self.assertIn("interrupted: by SIGINT; 0 of 3 episodes are finished and kept; the same command plays the others", said)
            for child in children:
                for _ in range(200):
                    if not os.path.exists(f"/proc/{child}"):
                        break
                    time.sleep(0.02)
                self.assertFalse(os.path.exists(f"/proc/{child}"), "an episode goes on without its bench")
