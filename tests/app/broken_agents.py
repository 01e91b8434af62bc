"""Ten agents with a fault each, of ten kinds, and the questions that lead from what one sees to the cause.

An agent is the shipped one with a small change. The questions are those of somebody who knows the agent's templates, but guesses
no name of a rule: each name in a question stands in the game's result or in the answer before. docs/testing.md has the table.
"""

import os
import re
import shlex
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

CXLAB = os.environ["CXLAB"]
SOURCE = Path(os.environ["CXLAB_SOURCE_DIR"])


class Agent:
    """Kind of fault; file, changes of its text; the questions; what the last answer says of the cause."""

    def __init__(self, kind, until, file, changes, questions, cause):
        self.kind, self.until, self.file, self.changes, self.questions, self.cause = kind, until, file, changes, questions, cause


AGENTS = [
    # Products with rings stay at the base station.
    Agent("a misspelt symbol", 200, "products.clp", [("(machine (name ?next) (kind RS))", "(machine (name ?next) (kind RNIG))")],
          ["orders", "why-not '(product (order 2))'"],
          r"product-to-ring-station \(.*products.clp:\d+\) has not fired for it\n +lacks condition 2: \(machine \(name \?next\) \(kind RNIG\)\).*kind is RS, not RNIG"),
    # Robots look for bases where there are none any more.
    Agent("a fact that is not retracted", 200, "payments.clp", [("  ?clear <- (clear-base ?name)\n  ?slide <-", "  (clear-base ?name)\n  ?slide <-"),
                                                         ("  (retract ?clear)\n  (bind ?missing", "  (bind ?missing")],
          ["facts '(job (purpose CLEAR))' --at 1:30", "why '(job (purpose CLEAR))' --at 1:30", "firings payment-of-bare-base"],
          r"(?s)56.400 s  payment-of-bare-base .*\?name = \"C-CS1\".*\n +56.400 s  payment-of-bare-base .*\?name = \"C-CS1\""),
    # No order is begun.
    Agent("a salience that is too low", 200, "orders.clp", [('have the best order made."\n', 'have the best order made."\n  (declare (salience -10000))\n')],
          ["orders", "rules", "why-not order-choose"],
          r"(?s)order-choose.*was on the agenda up to 200.000 s, until rule time-retract took it off"),
    # Machines stand while another one works.
    Agent("a condition that is too strict", 320, "skills.clp", [("(not (instruction (state SENT)))\n  (not (game", "(not (instruction (state SENT|RUNNING)))\n  (not (game")],
          ["waits", "facts '(instruction (state NEW))' --at 1:02", "why-not '(instruction (state NEW))' --at 1:02"],
          r"instruct-send \(.*\) has not fired for it\n +lacks condition 4: \(not \(instruction \(state SENT\|RUNNING\)\)\)"),
    # Nothing is fetched from a machine.
    Agent("a wrong value in a slot", 240, "products.clp", [("(retract ?instruction)\n  (modify ?product (state READY)))", "(retract ?instruction)\n  (modify ?product (state WAITING)))")],
          ["orders", "why-not '(product (order 1))'", "why '(product (order 1))'"],
          r"(?s)\(product \(order 1\).*\(state WAITING\)\).*rule product-ready "),
    # Orders are delivered and stay begun, until no new one is.
    Agent("a fact that another rule takes away", 400, "shared-machines.clp", [('"Nobody ordered it."\n  ?delivered <- (delivered 0 ?)', '"Nobody ordered it."\n  (declare (salience 5))\n  ?delivered <- (delivered ? ?)')],
          ["orders", "why-not '(product (order 1))'", "why-not product-delivered"],
          r"\(delivered \d SUCCEEDED\), was asserted at .* by rule delivery-done, and retracted at .* by rule delivery-discarded"),
    # No order is begun.
    Agent("two rules that race for a fact", 200, "orders.clp", [("?chosen <- (chosen 0)", "?chosen <- (chosen ?)")],
          ["orders", "why-not '(order (id 1) (state STARTED))'", "why-not '(chosen ?)'"],
          r"asserted at .* by rule order-choose, and retracted at .* by rule order-choose-none"),
    # Finished products are not fetched.
    Agent("a wrong parameter", 280, "products.clp", [("?*DELIVERY-LEAD* = 45.0", "?*DELIVERY-LEAD* = -300.0")],
          ["orders", "why-not '(product (order 1))' --at 4:00", "globals"],
          r"DELIVERY-LEAD\* = -300"),
    # No order is begun after the first second.
    Agent("a wrong unit", 200, "orders.clp", [("(assert (next-choice (+ ?now 1.0)))", "(assert (next-choice (+ ?now 1000.0)))")],
          ["orders", "why-not '(order (id 1) (state STARTED))'", "why-not '(chosen ?)'"],
          r"order-choose \(.*\) asserts it through .*\n +lacks now condition 4: .*1000"),
    # The second product stays in the robot's gripper.
    Agent("a resource that is not released", 400, "shared-machines.clp", [("  ?reserved <- (reserved (job ?id))\n  =>\n  (retract ?instruction ?reserved)", "  (reserved (job ?id))\n  =>\n  (retract ?instruction)")],
          ["orders", "why-not '(job (order 2))'", "why-not '(held-up (step GO-PUT))'"],
          r"delivery-reserve \(.*\) has not fired for it\n +lacks condition 4: \(not \(reserved \(machine \?delivery\)\)\).*\(reserved \(machine \"C-DS\"\)"),
]


class Broken(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = Path(tempfile.mkdtemp(prefix="cxlab-broken-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)

    def cxlab(self, *arguments):
        done = subprocess.run([CXLAB, *arguments], capture_output=True, text=True, cwd=self.folder, timeout=300)
        return done

    def test_each_cause_is_found_with_four_questions_at_most(self):
        for number, agent in enumerate(AGENTS):
            with self.subTest(agent.kind):
                self.assertLessEqual(len(agent.questions), 4)
                package = self.folder / f"{number}/agent"
                shutil.copytree(SOURCE / "scenarios/rcll/agent", package)
                shutil.copy(SOURCE / "scenarios/rcll/game.yaml", package.parent)
                file = package / "clips" / agent.file
                text = file.read_text()
                for old, new in agent.changes:
                    self.assertEqual(text.count(old), 1, old)
                    text = text.replace(old, new)
                file.write_text(text)
                run = f"{number}/run"
                played = self.cxlab("run", f"{number}/game.yaml", "--tier", "timed", "--until", str(agent.until), "--quiet", "--out", run)
                self.assertEqual(played.returncode, 0, played.stderr)
                seen = ""
                for question in agent.questions:
                    name, *arguments = shlex.split(question)
                    answer = self.cxlab(name, run, *arguments)
                    self.assertEqual(answer.returncode, 0, answer.stderr)
                    for rule in re.findall(r"^(?:why-not|why|firings) ([a-z][a-z-]+)$", question):
                        self.assertIn(rule, seen, "nobody knows this rule yet")
                    seen += answer.stdout
                if os.environ.get("CXLAB_SHOW"):
                    print(f"=== {agent.kind}: {question}\n{answer.stdout}")
                self.assertRegex(answer.stdout, agent.cause)


if __name__ == "__main__":
    unittest.main()
