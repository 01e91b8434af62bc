"""The page of a run in Chromium: it opens, plays, jumps and links, in 3D and where there is no WebGL. ./dev readers"""

import json
import random
import subprocess
import time
import unittest

from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

from in_browser import CXLAB, NO_GL, SOFTWARE_GL, SOURCE, Browser


class Pages(Browser):
    def open(self, run, link="", gl=SOFTWARE_GL, size=(1400, 900)):
        self.start_browser(gl, size)
        self.show(run, link)

    def show(self, run, link=""):
        self.show_address(f"{(run / 'index.html').as_uri()}{link}")

    def pointer(self):
        self.actions = ActionChains(self.browser)
        return self.actions.w3c_actions.pointer_action

    def act(self):
        self.actions.perform()

    def game(self):
        return self.play("game", "rcll/game", "--seed", 5)

    def test_keys_and_clicks(self):
        self.open(self.game())
        self.press(Keys.ARROW_RIGHT)
        self.assertEqual(self.shown(), ("0:01.0", 1))
        self.press(Keys.END)
        self.assertEqual(self.shown()[1], self.js("cxlab.run.end"))
        self.press(Keys.HOME, "]")
        self.assertGreater(self.shown()[1], 0)
        self.press("+", "+")
        self.assertAlmostEqual(self.js("cxlab.span.length"), self.js("cxlab.run.end") / 4, places=3)
        self.press("0")
        self.assertEqual(self.js("cxlab.span.length"), self.js("cxlab.run.end"))
        # The longest bar in the lane of the first robot.
        bars = self.js("cxlab.run.parts.find((part) => part.title === 'Robots').lanes[0].bars")
        longest = max(range(len(bars)), key=lambda i: (bars[i]["shape"] == "bar", bars[i]["end"] - bars[i]["begin"]))
        bar = self.js("[...document.querySelectorAll('.row.lane .name')].find((name) => name.textContent === 'robot1').closest('.row').querySelectorAll('.bar')[arguments[0]]", longest)
        self.js("arguments[0].scrollIntoView({block: 'center'})", bar)
        ActionChains(self.browser).move_to_element(bar).perform()
        self.assertIn(bars[longest]["text"], self.js("document.getElementById('tip').textContent"))
        bar.click()
        at = self.shown()[1]
        self.assertEqual(at, bars[longest]["begin"])
        self.until(lambda: f"t={round(at, 2):g}" in self.js("location.hash"))
        # An order: its details, and the link.
        name = self.browser.find_elements(By.CSS_SELECTOR, ".tasks .name")[4]
        name.click()
        self.until(lambda: "order=5" in self.js("location.hash"))
        self.assertIn(self.js("cxlab.choice.task.reason"), self.js("document.querySelector('.details').textContent"))
        self.press(Keys.ESCAPE)
        self.until(lambda: "order" not in self.js("location.hash"))
        self.clean()

    def test_a_link_shows_what_it_names(self):
        self.open(self.game(), "#t=312.4&order=5")
        self.assertEqual(self.shown(), ("5:12.4", 312.4))
        self.assertEqual(self.js("cxlab.choice.task.id"), "5")
        self.js("location.hash = 't=1:00&of=robot1'")
        self.until(lambda: self.shown() == ("1:00.0", 60))
        self.assertEqual(self.js("cxlab.choice.name"), "robot1")
        self.clean()

    def test_it_plays(self):
        self.open(self.game())
        self.press(" ")
        self.until(lambda: self.js("cxlab.clock.t") > 2)
        self.press(" ")
        at = self.js("cxlab.clock.t")
        time.sleep(0.3)
        self.assertEqual(self.js("cxlab.clock.t"), at)
        self.clean()

    def test_filters_of_the_table(self):
        self.open(self.game())
        rows = lambda: self.js("[...document.querySelectorAll('.event-table tbody tr')].map((row) => row.cells[1].textContent)")
        self.assertEqual(set(rows()) & {"decision", "points"}, {"decision", "points"})
        self.js("[...document.querySelectorAll('.filters input[type=checkbox]')].find((box) => box.parentNode.textContent.trim() === 'decision').click()")
        self.assertNotIn("decision", rows())
        self.browser.find_element(By.CSS_SELECTOR, ".filters input[type=search]").send_keys("order 3")
        texts = self.js("[...document.querySelectorAll('.event-table tbody tr')].map((row) => row.textContent)")
        self.assertTrue(texts)
        for text in texts:
            self.assertIn("order 3", text)
        self.clean()

    def test_without_webgl_the_field_is_shown_from_above(self):
        self.open(self.game(), "#t=300", gl=NO_GL)
        self.until(lambda: "no WebGL" in self.js("document.querySelector('.field .note').textContent"))
        self.assertFalse(self.js("document.querySelector('canvas.flat').hidden"))
        colours = self.js("new Set(new Uint32Array(document.querySelector('canvas.flat').getContext('2d').getImageData(0, 0, 800, 400).data.buffer)).size")
        self.assertGreater(colours, 20, "there is a picture")
        self.clean()

    def test_in_3d(self):
        self.open(self.game(), "#t=300")
        self.until(lambda: not self.js("document.querySelector('canvas.solid').hidden"))
        # Where things are in the picture they can be pointed at and chosen; the ground and a drag choose nothing.
        where = '''(() => {
          const { view3d, seen } = cxlab.field, { position } = seen.find((one) => one.track.name === arguments[0]).at;
          const at = new THREE.Vector3(position[0], position[1], 0.3).project(view3d.camera), box = view3d.canvas.getBoundingClientRect();
          return [box.left + ((at.x + 1) / 2) * box.width, box.top + ((1 - at.y) / 2) * box.height].map(Math.round);
        })()'''
        for name in ("robot2", "C-RS1"):
            x, y = self.js(where, name)
            self.pointer().move_to_location(x, y)
            self.act()
            self.assertIn(name, self.js("document.getElementById('tip').textContent"))
            self.pointer().move_to_location(x, y).pointer_down().pointer_up()
            self.act()
            self.assertEqual(self.js("cxlab.choice.name"), name)
        self.pointer().move_to_location(*self.js(where, "robot1")).pointer_down().move_by(30, 0).pointer_up()
        self.act()
        self.assertEqual(self.js("cxlab.choice.name"), "C-RS1", "a drag turns the view only")
        self.press("v")
        self.until(lambda: self.js("document.querySelector('canvas.solid').hidden"))
        self.clean()

    def test_the_chart_tells_what_stood_at_a_time(self):
        self.open(self.game())
        plot = self.browser.find_element(By.CSS_SELECTOR, ".row.chart .plot")
        self.js("arguments[0].scrollIntoView({block: 'center'})", plot)
        ActionChains(self.browser).move_to_element(plot).perform()
        tip = self.js("[...document.getElementById('tip').children].map((line) => line.textContent)")
        self.assertRegex(tip[0], r"^(9:59|10:0)")
        shown = self.js("cxlab.run.parts.find((part) => part.type === 'chart').lines.map((line) => [line.text, (line.steps.filter((step) => step[0] <= 600).pop() || [0, 0])[1]])")
        self.assertEqual(tip[1:], [f"{text} {value}" for text, value in shown if value])
        self.assertGreater(len(tip), 3)
        self.clean()

    def test_positions_are_those_of_the_scene(self):
        chance = random.Random(1)
        for run in (self.game(), self.play("timed", "rcll/planning", "--tier", "timed", "--seed", 5)):
            self.open(run)
            for _ in range(15):
                t = round(chance.uniform(0, 1150), 1)
                said = json.loads(subprocess.run([CXLAB, "scene", run, "--at", str(t), "--json"], check=True, capture_output=True, text=True, timeout=60).stdout)
                entities = said if isinstance(said, list) else said["entities"]
                seen = {one["id"]: one for one in self.js("cxlab.scene.at(arguments[0]).map((s) => ({id: s.track.id, name: s.track.name, state: s.state, look: s.look, carrier: s.carrier, at: s.at.position}))", t)}
                self.assertEqual(set(seen), {one["id"] for one in entities})
                for one in entities:
                    page = seen[one["id"]]
                    self.assertEqual((page["name"], page["carrier"]), (one["name"], one["carried_by"] or 0))
                    self.assertEqual(page["state"], one["state"], f"{one['name']} at {t}")
                    for value, key in zip(page["at"], "xyz"):
                        self.assertAlmostEqual(value, one[key], delta=0.002, msg=f"{one['name']} at {t}")
            self.clean()

    def test_it_opens_within_a_second(self):
        self.open(self.game())
        opened = []
        for _ in range(5):
            self.show(self.game())
            self.until(lambda: self.js("performance.getEntriesByName('first-contentful-paint').length"))
            opened.append(self.js("performance.getEntriesByName('first-contentful-paint')[0].startTime"))
        self.assertLess(min(opened), 1000, opened)

    def test_a_narrow_screen_scrolls_down_only(self):
        self.open(self.game(), "#t=300", size=(500, 800))
        self.assertLessEqual(self.js("document.documentElement.scrollWidth"), self.js("innerWidth"))
        self.clean()

    def test_worlds_that_declare_little(self):
        self.open(self.play("turtles", SOURCE / "scenarios/turtlesim/figures.yaml"), "#t=20&of=star")
        self.assertIn("pen", self.js("document.querySelector('.now').textContent"))
        self.clean()

    def test_scripts_have_their_types(self):
        done = subprocess.run(["tsc", "--noEmit", "--allowJs", "--checkJs", "--strict", "--target", "es2022", "--lib", "es2022,dom,dom.iterable", "--module", "es2022",
                               "--moduleResolution", "node", *(SOURCE / "lab/pages").glob("*/*.js")], capture_output=True, text=True, timeout=120)
        self.assertEqual((done.returncode, done.stdout), (0, ""))


if __name__ == "__main__":
    unittest.main()
