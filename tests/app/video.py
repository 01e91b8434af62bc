"""Films, `cxlab run --video` and `cxlab render --video`. Many tests have a stand-in for ffmpeg that keeps the frames."""

import functools
import os
import re
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

from gif import read_gif
from lab import CXLAB, FEW_PICTURES, SOURCE, Lab

GAME = SOURCE / "scenarios/rcll/game.yaml"
TURTLES = SOURCE / "scenarios/turtlesim/figures.yaml"


@functools.cache
def without_opengl():
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run([CXLAB, "render", GAME, "--at", "0", "--size", "32x32", "--out", f"{folder}/probe.png"], capture_output=True, text=True, env=os.environ | FEW_PICTURES)
    return "OpenGL" in done.stderr


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
        if without_opengl():
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
        self.environment |= FEW_PICTURES
        live = self.film("run", GAME, "--until", 4, "--quiet", "--out", "run", "--video", "film.mp4", "--video-camera",
                         "follow-robot1", "--video-size", "160x120", "--video-speed", 10)
        frame = 160 * 120 * 3
        self.assertEqual(len(live), 11 * frame)
        for camera, last in (("follow-robot1", 3.2), ("robot1", 2), ("C-CS1", 2), ("top", 2)):
            film = self.film("render", "run", "--video", "film.mp4", "--camera", camera, "--size", "160x120", "--speed", 10,
                             "--from", 2, "--to", last)
            frames = round((last - 2) / 0.4) + 1
            self.assertEqual(len(film), frames * frame)
            self.assertEqual(film == live[5 * frame:(5 + frames) * frame], camera == "follow-robot1", camera)

    def run_game(self, out, *options, until=60, scenario="two_teams", tier="timed"):
        self.cxlab("run", SOURCE / f"scenarios/rcll/{scenario}.yaml", "--tier", tier, "--seed", 1, "--until", until, "--out", out,
                   "--quiet", *options)

    @staticmethod
    def rows(frame, width, first, last):
        return frame[3 * width * first:3 * width * last]

    def test_the_timed_tier_is_filmed_as_it_is_played_and_as_it_was_recorded(self):
        self.needs_opengl()
        size, frame = "320x240", 320 * 240 * 3
        live = ["--video", "film.mp4", "--video-size", size, "--video-camera", "field,follow-robot1"]
        self.run_game("run", *live, until=8)
        played = (self.folder / "frames").read_bytes()
        self.assertEqual(len(played), 11 * frame)  # at 0, 0.8 ... 8 s
        again = ["render", "run", "--video", "film.mp4", "--size", size, "--camera", "field,follow-robot1"]
        recorded = self.film(*again)
        self.assertEqual(recorded[8 * frame:], self.film(*again, "--from", 6.4), "the same run has the same frames")
        # Ways of robots are kept in whole milliseconds and millimetres: an edge may lie a pixel further.
        for k in range(0, 11, 2):
            here, there = played[k * frame:(k + 1) * frame], recorded[k * frame:(k + 1) * frame]
            self.assertLess(sum(a != b for a, b in zip(here, there)), frame // 50, k)
        self.assertGreater(sum(a != b for a, b in zip(played[:frame], played[10 * frame:])), frame // 50, "robots move")

    def test_a_caption_has_lines_of_its_own(self):
        self.needs_opengl()
        self.environment |= FEW_PICTURES
        self.run_game("run", "--set", "faults=[{kind: skill_fails, probability: 0.7}]", until=30)
        film = ["render", "run", "--video", "film.mp4", "--size", "480x300", "--from", 27, "--to", 27]
        with_it, without = self.film(*film), self.film(*film, "--no-caption")
        self.assertEqual((len(with_it), len(without)), (480 * 300 * 3,) * 2)
        below = self.rows(with_it, 480, 262, 300)
        self.assertNotEqual(below, self.rows(without, 480, 262, 300))
        colours = {below[i:i + 3] for i in range(0, len(below), 3)}
        self.assertIn(bytes((255, 153, 115)), colours, "a fault stands out")
        self.assertIn(bytes((51, 242, 255)), colours, "the points of cyan")
        self.assertIn(bytes((255, 128, 217)), colours, "the points of magenta")
        # Without a journal nothing is told.
        (self.folder / "run/journal.jsonl").unlink()
        self.assertNotIn(bytes((255, 153, 115)), self.film(*film))

    def test_snapshots_of_the_timed_tier_are_at_the_times_that_were_asked_for(self):
        self.needs_opengl()
        self.environment |= FEW_PICTURES
        self.run_game("run", "--snapshot", "7.3,20", until=30)
        self.assertEqual(sorted(p.name for p in (self.folder / "run/snapshots").iterdir()),
                         ["0007.30-field.png", "0007.30-top.png", "0020.00-field.png", "0020.00-top.png"])

    # --- Animated images

    def gif(self, name="film.gif"):
        data = (self.folder / name).read_bytes()
        return (len(data), *read_gif(data))

    def test_an_animated_image_has_the_frames_of_the_film_without_ffmpeg(self):
        self.environment["PATH"] = f"{self.folder}/nothing"
        options = ["render", TURTLES, "--to", 8, "--size", "120x120", "--speed", 4]
        self.cxlab(*options, "--video", "film.gif")
        _, width, height, frames = self.gif()
        self.assertEqual((width, height), (120, 120))
        self.environment["PATH"] = f"{self.folder}/bin:{os.environ['PATH']}"
        raw = self.film(*options, "--video", "film.mp4", "--frame-rate", 10)
        size = 120 * 120 * 3
        shown, at = [], 0
        for delay, pixels in frames:  # a frame that repeats the one before makes it longer
            shown += [(at + k, pixels) for k in range(0, delay, 10)]
            at += delay
        self.assertEqual(at, 210)
        self.assertEqual([t for t, _ in shown], list(range(0, 210, 10)))
        for k, (_, pixels) in enumerate(shown):
            wanted = raw[k * size:(k + 1) * size]
            self.assertLess(max(abs(a - b) for a, b in zip(pixels, wanted)), 40, k)  # 255 colours in a frame
            self.assertLess(sum(a != b for a, b in zip(pixels, wanted)), size // 4, k)

    def test_an_animated_image_of_a_whole_game_is_below_five_megabytes(self):
        """With `--speed 150` it has 81 frames; these are a quarter of them."""
        self.needs_opengl()
        self.run_game("run", until=1200)
        done = self.cxlab("render", "run", "--video", "game.gif", "--speed", 600)
        size, width, height, frames = self.gif("game.gif")
        self.assertEqual((width, height, done.stdout), (640, 400, "game.gif\n"))
        self.assertLess(size, 5_000_000 / 4)
        self.assertGreater(len(frames), 15)
        self.assertAlmostEqual(sum(delay for delay, _ in frames), 210, delta=10)

    def test_an_animated_image_is_made_to_fit_and_says_how(self):
        options = ["render", TURTLES, "--to", 30, "--size", "200x200", "--speed", 5]
        self.cxlab(*options, "--video", "whole.gif")
        whole = self.gif("whole.gif")
        done = self.cxlab(*options, "--video", "small.gif", "--max-size", f"{whole[0] * 4 // 5}")
        small = self.gif("small.gif")
        self.assertLessEqual(small[0], whole[0] * 4 // 5)
        self.assertRegex(done.stderr, r"small\.gif: 0\.\d\d MB with 5 frames a second instead of 10.*, to stay below 0\.\d\d MB")
        self.assertEqual(sum(delay for delay, _ in whole[3]), sum(delay for delay, _ in small[3]), "it lasts as long")
        self.assertEqual(f"{small[1]}x{small[2]}" in done.stderr, small[1] < 200)
        tiny = self.cxlab(*options, "--video", "tiny.gif", "--max-size", "10kB")
        self.assertLessEqual(self.gif("tiny.gif")[0], 10_000)
        self.assertIn("instead of 200x200", tiny.stderr)
        self.assertEqual((self.folder / "whole.gif").stat().st_size, whole[0])

    def test_an_animated_image_that_is_interrupted_is_whole(self):
        process = subprocess.Popen([CXLAB, "render", TURTLES, "--video", "film.gif", "--speed", "1", "--set", "expect=[]", "--set",
                                    "duration_s=100000"], cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        time.sleep(2)
        self.assertFalse((self.folder / "film.gif").exists())
        process.send_signal(signal.SIGINT)
        error = process.communicate(timeout=60)[1]
        self.assertEqual(process.returncode, 130, error)
        self.assertIn("film.gif ends there", error)
        self.assertGreater(len(self.gif()[3]), 1)
        self.assertEqual([p.name for p in self.folder.iterdir() if "part" in p.name], [])

    def test_a_killed_film_leaves_no_half_file(self):
        process = subprocess.Popen([CXLAB, "render", TURTLES, "--video", "film.gif", "--speed", "1", "--set", "expect=[]", "--set",
                                    "duration_s=100000"], cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        while not any("part" in p.name for p in self.folder.iterdir()) and process.poll() is None:
            time.sleep(0.01)
        process.kill()
        process.wait()
        for _ in range(100):
            if not [p for p in self.folder.iterdir() if p.suffix == ".gif"]:
                return
            time.sleep(0.05)
        self.fail("a part of a film is left")

    def test_a_faulty_film_is_an_error(self):
        turtles = ["render", TURTLES, "--to", 1]
        self.run_game("run", until=2)
        for code, text, arguments in (
                (2, "expected a name that ends in .mp4, .mkv, .mov, .avi, .webm or .gif", [*turtles, "--video", "film.bmp"]),
                (2, "which only an animated image (.gif) can have", [*turtles, "--video", "film.mp4", "--max-size", "2MB"]),
                (2, "expected a size of at least 10kB", [*turtles, "--video", "film.gif", "--max-size", "2"]),
                (2, "expected a size of at least 10kB", [*turtles, "--video", "film.gif", "--max-size", "2 apples"]),
                (2, "expected at most 50 for an animated image", [*turtles, "--video", "film.gif", "--frame-rate", 60]),
                (2, "expected a number from 1 to 120", [*turtles, "--video", "film.gif", "--frame-rate", 0]),
                (2, "--from: found 5 s, which is after the end of the film at 1 s", [*turtles, "--from", 5, "--video", "film.gif"]),
                (3, "expected: canvas", [*turtles, "--video", "film.gif", "--camera", "canvas,field"]),
                (5, "film.gif: the film cannot be written", [*turtles, "--video", "/proc/film.gif"]),
                (2, "--to: there is no picture at 5 s: the run ends at 2 s", ["render", "run", "--video", "film.gif", "--to", 5])):
            done = self.cxlab(*arguments, expect=code)
            self.assertIn(text, done.stderr)
        self.needs_opengl()
        done = self.cxlab("render", "run", "--video", "film.gif", "--camera", "field,folow-robot1", expect=3, environment=self.environment | FEW_PICTURES)
        self.assertRegex(done.stderr, r"no camera 'folow-robot1', expected one of: field, top, follow-robot1, .*C-CS1.*did you mean 'follow-robot1'")
        self.assertEqual([p.name for p in self.folder.iterdir() if p.suffix == ".gif"], [])

    def test_odd_sizes_are_drawn(self):
        self.needs_opengl()
        self.environment |= FEW_PICTURES
        self.run_game("run", until=1)
        for size in ("65x49", "321x199", "100x400"):
            self.cxlab("render", "run", "--video", "film.gif", "--size", size, "--camera", "field,follow-robot1,top", "--from", 1)
            self.assertEqual("%dx%d" % self.gif()[1:3], size)

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

    def test_an_impossible_film_is_an_error_before_the_run_begins(self):
        run = ["run", TURTLES, "--out", "none", "--quiet", "--until", 1, "--set", "expect=[]"]
        self.write("empty/nothing", "")
        nowhere = os.environ | {"PATH": f"{self.folder}/empty"}
        for command in (run, ["render", TURTLES, "--to", 1]):
            done = self.cxlab(*command, "--video", "film.mp4", expect=5, environment=nowhere)
            self.assertEqual(done.stderr, "error: no pictures: --video needs ffmpeg: apt-get install ffmpeg, or a name that ends in .gif, "
                             "which needs nothing\n")
            done = self.cxlab(*command, "--video", "/proc/none/film.mp4", expect=5)
            self.assertEqual(done.stderr, "error: /proc/none: the folder cannot be made: No such file or directory\n")
        for ends in ("exit 1\n", "cat > /dev/null\nexit 1\n"):  # before it has read, or after
            self.stand_in(ends)
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
