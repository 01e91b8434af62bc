"""Films, `cxlab run --video` and `cxlab render --video`. Most tests have a stand-in for ffmpeg that keeps the frames."""

import os
import shutil
import signal
import subprocess
import time
import unittest

from lab import CXLAB, SOURCE, Lab

GAME = SOURCE / "scenarios/rcll/game.yaml"
TURTLES = SOURCE / "scenarios/turtlesim/figures.yaml"


class Film(Lab):
    def setUp(self):
        super().setUp()
        self.stand_in('echo "$@" > arguments\nexec cat > frames\n')

    def stand_in(self, text):
        self.write("bin/ffmpeg", "#!/bin/sh\n" + text).chmod(0o755)
        self.environment = os.environ | {"PATH": f"{self.folder}/bin:{os.environ['PATH']}"}

    def cxlab(self, *arguments, expect=0, environment=None):
        done = subprocess.run([CXLAB, *map(str, arguments)], cwd=self.folder, capture_output=True, text=True,
                              timeout=100, env=environment or self.environment)
        self.assertEqual(done.returncode, expect, done.stderr)
        return done

    def film(self, *arguments):
        """The bytes of all frames."""
        self.cxlab(*arguments)
        frames = self.folder / "frames"
        data = frames.read_bytes()
        frames.unlink()
        return data

    def needs_opengl(self):
        if "OpenGL" in subprocess.run([CXLAB, "render", GAME, "--at", "0", "--out", self.folder / "probe.png"], capture_output=True, text=True).stderr:
            self.skipTest("no OpenGL here")

    def test_ffmpeg_gets_frames_of_that_size_and_the_name(self):
        self.film("run", TURTLES, "--video", "a film's.mp4", "--out", "none", "--quiet", "--until", 1,
                  "--set", "expect=[]", "--video-size", "500x300")
        arguments = (self.folder / "arguments").read_text()
        self.assertIn("-s 300x300 -r 25 ", arguments)
        self.assertRegex(arguments, r"file:\S+/a film's\.\d+\.part\.mp4\n$")  # it has its name when it is whole

    def test_frames_are_at_simulated_times_and_the_same_from_a_recorded_run(self):
        options = ["--until", 8, "--set", "expect=[]", "--quiet"]
        film = ["--video", "film.mp4", "--video-size", "100x100", "--video-speed", 4]  # every 0.16 s, ten ticks
        live = self.film("run", TURTLES, *options, *film, "--out", "run")
        self.assertEqual(len(live), 51 * 100 * 100 * 3)
        self.assertEqual(live, self.film("run", TURTLES, *options, *film, "--out", "none"))
        render = ["--video", "film.mp4", "--size", "100x100", "--speed", 4]
        self.assertEqual(live, self.film("render", "run", *render))
        self.assertEqual(live, self.film("render", TURTLES, *render, "--to", 8))
        part = self.film("render", "run", *render, "--from", 1.6, "--to", 4)
        self.assertEqual(part, live[10 * 30000:26 * 30000])

    def test_the_page_of_a_run_links_its_film_and_a_name_that_is_no_films_is_refused(self):
        options = ["run", TURTLES, "--until", 1, "--set", "expect=[]", "--quiet"]
        self.film(*options, "--video", "film.mp4", "--out", "run")
        self.assertIn('<a href="..&#x2f;film.mp4">', (self.folder / "run/index.html").read_text())
        self.assertIn("expected a name that ends in .mp4", self.cxlab(*options, "--video", "film.txt", "--out", "none", expect=2).stderr)
        self.assertFalse((self.folder / "film.txt").exists())
        self.assertIn("only a scenario takes it", self.cxlab("render", "run", "--seed", 3, "--out", "a.png", expect=2).stderr)

    def test_a_game_is_filmed_from_any_camera(self):
        self.needs_opengl()
        live = self.film("run", GAME, "--until", 8, "--quiet", "--out", "run", "--video", "film.mp4", "--video-camera",
                         "follow-robot1", "--video-size", "160x120", "--video-speed", 5)
        frame = 160 * 120 * 3
        self.assertEqual(len(live), 41 * frame)
        for camera in ("follow-robot1", "robot1", "C-CS1", "top"):
            film = self.film("render", "run", "--video", "film.mp4", "--camera", camera, "--size", "160x120", "--speed", 5,
                             "--from", 2, "--to", 6)
            self.assertEqual(len(film), 21 * frame)
            self.assertEqual(film == live[10 * frame:31 * frame], camera == "follow-robot1", camera)

    def interrupt(self, *arguments):
        """Sends SIGINT once frames have been written."""
        process = subprocess.Popen([CXLAB, *map(str, arguments)], cwd=self.folder, env=self.environment,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        frames = self.folder / "frames"
        while process.poll() is None and not (frames.exists() and frames.stat().st_size > 100000):
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        error = process.communicate(timeout=60)[1]
        self.assertEqual(process.returncode, 130, error)
        self.assertTrue((self.folder / "finished").exists(), "ffmpeg was not waited for")
        (self.folder / "finished").unlink()
        frames.unlink()

    def test_a_signal_ends_a_film_in_order_however_long_ffmpeg_takes(self):
        self.stand_in("cat > frames\nsleep 1.5\necho > finished\n")
        film = ["--video", "film.mp4"]
        endless = ["--set", "expect=[]", "--set", "duration_s=100000"]
        self.interrupt("run", TURTLES, *film, "--video-speed", 1, *endless, "--out", "run", "--quiet", "--journal", "none")
        self.interrupt("render", TURTLES, *film, "--speed", 1, *endless)

    def test_a_run_that_fails_has_a_film(self):
        self.stand_in("cat > frames\necho > finished\n")
        self.agent("(defrule wrong (time ?sec&:(> ?sec 1)) => (+ 1 (nth$ 1 (create$ one))))",
                   "schema: 1\nworld: {kind: turtlesim}\nduration_s: 3\npackages: {rules: rules}\nagents:\n  - config: agent.yaml\n")
        self.cxlab("run", "scenario.yaml", "--video", "film.mp4", "--out", "run", "--quiet", expect=4)
        self.assertTrue((self.folder / "finished").exists())

    def test_what_cannot_be_filmed_is_said_before_the_run_begins(self):
        run = ["run", TURTLES, "--out", "none", "--quiet", "--until", 1, "--set", "expect=[]"]
        self.write("empty/nothing", "")
        nowhere = os.environ | {"PATH": f"{self.folder}/empty"}
        for command in (run, ["render", TURTLES, "--to", 1]):
            done = self.cxlab(*command, "--video", "film.mp4", expect=5, environment=nowhere)
            self.assertEqual(done.stderr, "error: no pictures: --video needs ffmpeg: apt-get install ffmpeg\n")
            done = self.cxlab(*command, "--video", "/proc/none/film.mp4", expect=5)
            self.assertEqual(done.stderr, "error: /proc/none: the folder cannot be made: No such file or directory\n")
        self.stand_in("exit 1\n")
        self.assertIn("film.mp4: the film cannot be written", self.cxlab(*run, "--video", "film.mp4", expect=5).stderr)

    @unittest.skipUnless(shutil.which("ffmpeg") and shutil.which("ffprobe"), "there is no ffmpeg here")
    def test_ffmpeg_writes_a_film_that_can_be_played(self):
        self.cxlab("run", TURTLES, "--until", 8, "--set", "expect=[]", "--quiet", "--out", "none", "--video", "a:b.mp4",
                   "--video-size", "101x101", "--video-speed", 4, environment=os.environ)
        probe = subprocess.run(["ffprobe", "-v", "error", "-count_frames", "-show_entries",
                                "stream=width,height,nb_read_frames", "-of", "csv=p=0", "file:a:b.mp4"],
                               cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(probe.stdout.strip(), "102,102,51", probe.stderr)


if __name__ == "__main__":
    unittest.main()
