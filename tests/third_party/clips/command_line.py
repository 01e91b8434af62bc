"""The command line of CLIPS in a pipe: CLIPS=program python3 -m unittest command_line"""

import os
import subprocess
import unittest

def run(text, *arguments):
    return subprocess.run([os.environ["CLIPS"], *arguments], input=text, text=True, timeout=20,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE)


class CommandLine(unittest.TestCase):
    def test_ends_at_the_end_of_an_empty_input(self):
        done = run("")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn("CLIPS (", done.stdout)

    def test_carries_out_a_last_line_without_newline(self):
        done = run("(bind ?x 20)\n(+ ?x 22)")
        self.assertEqual(done.returncode, 0)
        self.assertIn("CLIPS> 42\n", done.stdout)

    def test_ends_with_the_status_that_exit_names(self):
        self.assertEqual(run("(exit 3)\n(printout t never crlf)\n").returncode, 3)

    def test_says_that_the_last_command_is_incomplete(self):
        done = run("(assert (a)\n")
        self.assertEqual((done.returncode, done.stderr), (1, "The input ends inside a command.\n"))

    def test_takes_space_and_a_comment_at_the_end_for_no_command(self):
        self.assertEqual(run("(+ 1 2)\n\n  ; done (\n").returncode, 0)

    def test_goes_on_after_a_rule_has_read_the_end_of_the_input(self):
        done = run("(bind ?line (readline))")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn("EOF", done.stdout)


if __name__ == "__main__":
    unittest.main()
