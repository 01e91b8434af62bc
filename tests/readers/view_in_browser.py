"""The pages of cxlab view in Chromium, with the real server: questions, graphs, steps, runs, two runs, a run in progress."""

import json
import os
import re
import select
import shutil
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

from in_browser import CXLAB, SOURCE, Browser
from picture_of_page import take

sys.path += [str(SOURCE / "tests/support"), str(SOURCE / "tests/app")]
import pictures  # noqa: E402

RULE_THAT_ASKS_FOR_NOTHING = ("(machine (name ?next) (kind RS))", "(machine (name ?next) (kind RNIG))")
HOSTILE = "<img src=x onerror=window.hit=1>"


def ask(*arguments, code=0):
    done = subprocess.run([CXLAB, *map(str, arguments), "--json"], capture_output=True, text=True, timeout=120)
    assert done.returncode == code, done.stderr
    return json.loads(done.stdout)


class View(Browser):
    def serve(self, *arguments):
        """Starts the server; returns the address that it prints, with its token."""
        server = subprocess.Popen([CXLAB, "view", *map(str, arguments), "--port", "0"], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                  stderr=subprocess.PIPE, text=True)
        self.addCleanup(server.stderr.close)
        self.addCleanup(server.stdout.close)
        self.addCleanup(server.wait)
        self.addCleanup(server.terminate)
        ready, _, _ = select.select([server.stdout], [], [], 30)
        line = server.stdout.readline() if ready else ""
        address = re.search(r"http://\S+", line)
        self.assertTrue(address, line or "it has printed no address")
        self.server = re.match(r"http://127\.0\.0\.1:\d+", address[0])[0]
        return address[0]

    def view(self, *arguments, link="", size=(1400, 900)):
        address = self.serve(*arguments)
        self.start_browser(size=size)
        self.show_address(address)
        if link:
            self.js(f"location.hash = {link!r}")
        if self.js("!!cxlab.ask"):
            self.settled()

    def settled(self):
        """The page shows the answer."""
        time.sleep(0.3)
        self.until(lambda: self.js("document.querySelector('section.ask').getAttribute('aria-busy') === 'false'"))
        self.assertEqual(self.js("document.querySelector('.ask > [role=alert]').hidden || document.querySelector('.ask > [role=alert]').textContent"), True)

    def all_is_well(self):
        self.clean("^(data|blob|about|chrome):|^" + re.escape(self.server) + "/")

    def at(self, t):
        self.js("cxlab.clock.seek(arguments[0])", t)
        self.settled()

    def tab(self, name):
        self.js("document.getElementById(arguments[0]).click()", "ask-" + name)
        self.settled()

    def search(self, css, text):
        field = self.browser.find_element(By.CSS_SELECTOR, css)
        field.clear()
        field.send_keys(text, Keys.ENTER)
        self.settled()

    def nodes(self, name):
        return self.js("[...cxlab.ask.tabs.find((tab) => tab.name === arguments[0]).graph.nodes.values()].map((node) => ({...node, rows: node.rows.map((row) => ({text: row.text, below: row.below || '', to: row.to || []}))}))", name)

    def game(self):
        return self.play("game", "rcll/game", "--tier", "timed", "--seed", 5)

    def faulty(self):
        """A game whose agent has a rule that waits for a machine that nobody has."""
        run, source = self.folder / "faulty", self.folder / "source"
        if not source.exists():
            source.mkdir()
            shutil.copytree(SOURCE / "scenarios/rcll/agent", source / "agent")
            shutil.copy(SOURCE / "scenarios/rcll/game.yaml", source)
            rules = source / "agent/clips/products.clp"
            text = rules.read_text()
            self.assertIn(RULE_THAT_ASKS_FOR_NOTHING[0], text)
            rules.write_text(text.replace(*RULE_THAT_ASKS_FOR_NOTHING))
        return self.play("faulty", source / "game.yaml", "--tier", "timed", "--until", 200) if not run.exists() else run

    def test_it_plays_and_a_click_on_an_order_chooses_it(self):
        self.view(self.game())
        self.press(" ")
        self.until(lambda: self.js("cxlab.clock.t") > 2)
        self.press(" ")
        self.browser.find_elements(By.CSS_SELECTOR, ".tasks .name")[4].click()
        self.until(lambda: "order=5" in self.js("location.hash"))
        self.all_is_well()

    def test_facts_are_those_of_the_question(self):
        run = self.game()
        self.view(run)
        for t in (312, 60.4):
            self.at(t)
            there = ask("facts", run, "--at", t)["environments"][0]["facts"]
            shown = self.js("cxlab.ask.tabs[0].facts.map((fact) => fact.fact)")
            self.assertEqual(shown, [fact["fact"] for fact in there])
        self.search(".pane input[type=search]", "(order (id 1))")
        rows = self.js("[...document.querySelectorAll('table.facts tr')].map((row) => row.textContent)")
        self.assertEqual(len(rows), 1)
        found = ask("facts", run, "(order (id 1))", "--at", 60.4)["environments"][0]["facts"][0]
        self.assertIn(found["fact"], rows[0])
        self.assertIn(found["changes"][-1]["text"], rows[0])
        self.assertIn(found["changes"][0]["by"]["name"], rows[0])
        # Its history.
        self.js("document.querySelector('table.facts .plain').click()")
        self.assertEqual(self.js("document.querySelectorAll('.changes tr').length"), len(found["changes"]))
        self.all_is_well()

    def test_why_is_a_graph_whose_boxes_lead_to_their_times(self):
        run = self.game()
        self.view(run)
        self.at(self.js("cxlab.run.end"))
        self.search(".pane input[type=search]", "(order (state DONE))")
        self.js("document.querySelector('table.facts .link').click()")
        self.settled()
        what = self.js("cxlab.ask.what")
        steps = {str(step["n"]): step for step in ask("why", run, what)["environments"][0]["steps"]}
        nodes = {node["key"]: node for node in self.nodes("why")}
        self.assertGreater(len(nodes), 4)
        for key, node in nodes.items():
            self.assertEqual(node["title"], steps[key]["text"])
            for row in node["rows"]:
                for to in row["to"]:
                    self.assertLessEqual(steps[to]["t_s"], steps[key]["t_s"])
        # A row that is not open yet.
        button = self.browser.find_element(By.CSS_SELECTOR, ".graph button.open")
        self.js("arguments[0].click()", button)
        self.until(lambda: len(self.nodes("why")) > len(nodes) or any(row["to"] for row in self.nodes("why")[0]["rows"]))
        # A click on a firing: its time, and the source of its rule.
        fired = next(node for node in nodes.values() if node["kind"] == "rule")
        self.js("cxlab.ask.tabs.find((tab) => tab.name === 'why').graph.find(arguments[0]).click()", fired["key"])
        self.settled()
        self.assertAlmostEqual(self.js("cxlab.clock.t"), steps[fired["key"]]["t_s"], places=6)
        self.assertIn("(defrule " + fired["title"].split("::")[-1], self.js("document.querySelector('.detail .source').textContent"))
        # The link leads to the same graph.
        self.until(lambda: "ask=why" in self.js("location.hash"))
        link = self.js("location.href")
        self.browser.get("about:blank")
        self.show_address(link)
        self.settled()
        self.assertEqual(self.nodes("why")[0]["title"], steps[self.nodes("why")[0]["key"]]["text"])
        self.all_is_well()

    def test_it_steps_from_firing_to_firing_and_back(self):
        self.view(self.game(), link="#t=100")
        place = lambda: self.js("document.querySelector('.ask .place').textContent")
        seen = []
        for _ in range(4):
            self.press(".")
            self.settled()
            seen.append(place())
        self.assertEqual(len(set(seen)), 4)
        for before in reversed(seen[:-1]):
            self.press(",")
            self.settled()
            self.assertEqual(place(), before)
        self.search(".moves input", "order-begin")
        self.assertIn("before rule order-begin fires", place())
        t = self.js("cxlab.clock.t")
        firings = ask("firings", self.game(), "order-begin")["environments"][0]["firings"]
        self.assertEqual(t, min(firing["t_s"] for firing in firings if firing["t_s"] > 100))
        self.all_is_well()

    def test_why_not_marks_the_condition_that_does_not_hold(self):
        run, rule = self.faulty(), "product-to-ring-station"
        self.view(run, link=f"#t=200&ask=why-not&what={rule}")
        unmet = ask("why-not", run, rule)["explanations"][0]["first_unmet"]
        marked = self.js("[...document.querySelectorAll('.code.fails')].map((line) => ({condition: Number(line.dataset.condition), text: line.textContent}))")
        self.assertEqual({line["condition"] for line in marked}, {unmet["condition"]})
        self.assertIn("RNIG", "".join(line["text"] for line in marked))
        self.assertIn(unmet["because"], self.js("document.querySelector('.because').textContent"))
        held = self.js("[...document.querySelectorAll('.code.holds')].map((line) => Number(line.dataset.condition))")
        self.assertEqual(set(held), set(range(1, unmet["condition"])))
        # From the product that waits to the rule that should fetch it.
        self.search(".asked input", "(product (order 2))")
        rows = self.nodes("why-not")[0]["rows"]
        self.assertTrue(any(row["text"] == rule and "RNIG" in row["below"] for row in rows), rows)
        self.all_is_well()

    def test_the_tutorial_finds_the_bug_with_clicks_alone(self):
        """docs/tutorials/find-a-bug.md"""
        run = self.faulty()
        self.view(run)
        click = lambda css, text="": self.js("[...document.querySelectorAll(arguments[0])].find((one) => one.textContent.includes(arguments[1])).click()", css, text)
        self.press(Keys.END)
        click(".tasks .name", "order 2")
        self.assertIn("no product is known", self.js("document.querySelector('.details').textContent"))
        click(".ask .about", "facts about order 2")
        self.settled()
        click("table.facts .plain", "(product")
        self.settled()
        self.assertIn("order-begin", self.js("document.querySelector('.changes').textContent"))
        click(".detail button.ask", "who waits for it")
        self.settled()
        click(".graph button.text", "product-to-ring-station")
        self.settled()
        self.assertIn("RNIG", self.js("document.querySelector('.code.fails').textContent"))
        self.assertEqual(self.js("document.querySelectorAll('.code.holds').length > 0"), True)
        self.js("[...document.querySelectorAll('.graph .of')].find((row) => row.textContent.includes('product-to-ring-station')).querySelector('.open').click()")
        self.until(lambda: any("in the nearest fact kind is RS" in text for text in self.js("[...document.querySelectorAll('.graph .below')].map((one) => one.textContent)")))
        self.all_is_well()

    def test_the_picture_of_the_guides_is_not_old(self):
        picture = self.folder / "view.png"
        take(self.serve(self.faulty()), str(picture), "1400x1200", "light", "#t=200&order=2&ask=why-not&what=product-to-ring-station")
        shown = SOURCE / "docs/pictures/view.png"
        self.assertLess(pictures.share(pictures.frames(picture)[0], pictures.frames(shown)[0]), pictures.MOST, "picture_of_page.py says how it is taken")

    def test_what_the_server_refuses_is_said_where_it_was_asked(self):
        self.view(self.game(), link="#t=100")
        field = self.browser.find_element(By.CSS_SELECTOR, ".moves input")
        field.send_keys("order-begn", Keys.ENTER)
        self.until(lambda: "order-begin" in self.js("document.querySelector('.ask > [role=alert]').textContent"))

    def test_runs_of_a_folder_and_two_side_by_side(self):
        folder = self.folder / "both"
        if not folder.exists():
            folder.mkdir()
            for seed in (1, 2, 3):
                subprocess.run([CXLAB, "run", "rcll/game", "--tier", "timed", "--seed", str(seed), "--until", "120", "--quiet", "--out", folder / f"g{seed}"], check=True, capture_output=True, timeout=60)
        self.view(folder)
        names = lambda: self.js("[...document.querySelectorAll('.runs tbody a')].map((link) => link.textContent)")
        self.assertEqual(sorted(names()), ["g1", "g2", "g3"])
        heads = self.js("[...document.querySelectorAll('.runs th')].map((head) => head.textContent)")
        self.js("document.querySelectorAll('.runs th button')[arguments[0]].click()", [head for head in heads if head].index("seed"))
        self.assertEqual(names(), ["g3", "g2", "g1"])
        self.browser.find_element(By.CSS_SELECTOR, ".runs input[type=search]").send_keys("seed 2")
        self.assertEqual(names(), ["g2"])
        self.browser.find_element(By.CSS_SELECTOR, ".runs input[type=search]").send_keys(*[Keys.BACKSPACE] * 6)
        self.assertEqual(len(names()), 3)
        for run in ("g1", "g2"):
            self.js("[...document.querySelectorAll('.runs tbody tr')].find((row) => row.querySelector('a').textContent === arguments[0]).querySelector('input').click()", run)
        self.browser.find_element(By.CSS_SELECTOR, ".compare").click()
        self.until(lambda: self.js("document.documentElement.dataset.ready && location.pathname === '/two'"))
        first = ask("diff", folder / "g1", folder / "g2", code=1)["first"]
        self.until(lambda: not self.js("cxlab.jump.disabled"))
        self.browser.find_element(By.CSS_SELECTOR, ".jump").click()
        self.assertEqual(self.js("cxlab.sides.map((side) => side.page.clock.t)"), [first["t_s"]] * 2)
        said = self.js("[...document.querySelectorAll('.said')].map((one) => one.textContent)")
        self.assertEqual(said, [first[side]["what"] or "nothing more" for side in "ab"])
        # The link of a time.
        self.browser.get("about:blank")
        self.show_address(self.server + "/two?a=g1&b=g2#t=45.5")
        self.assertEqual(self.js("cxlab.sides.map((side) => side.page.clock.t)"), [45.5, 45.5])
        # A click in one goes for both.
        self.js("cxlab.sides[1].page.clock.seek(30)")
        self.assertEqual(self.js("[cxlab.clock.t, ...cxlab.sides.map((side) => side.page.clock.t)]"), [30, 30, 30])
        self.all_is_well()

    def test_a_run_in_progress_is_stepped_and_grows(self):
        run = Path(tempfile.mkdtemp(prefix="cxlab-live-", dir=self.folder)) / "run"
        player = subprocess.Popen([CXLAB, "run", "rcll/game", "--tier", "timed", "--break", "--out", run], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(player.wait)
        self.addCleanup(player.terminate)
        self.until(lambda: (run / "control.sock").exists())
        self.view(run, "--live")
        state = lambda: self.js("document.querySelector('.live .state').textContent")
        self.until(lambda: "stands" in state())
        place = lambda: self.js("document.querySelector('.ask .place').textContent")
        before = place()
        self.press(".")
        self.settled()
        self.assertNotEqual(place(), before)
        self.search(".moves input", "1:00")
        self.until(lambda: "stands" in state() and self.js("cxlab.clock.end") >= 60)
        self.until(lambda: not self.js("cxlab.scene.empty"))
        facts = self.js("cxlab.ask.tabs[0].facts.length")
        self.assertGreater(facts, 50)
        self.js("document.activeElement.blur()")
        self.press("p")
        self.until(lambda: "runs" in state() or "has ended" in state())
        self.press("p")
        self.until(lambda: "stands" in state() or "has ended" in state())
        self.assertGreater(self.js("cxlab.clock.end"), 60)
        # When it has ended, the page has what that of any run has, and time goes both ways.
        if "stands" in state():
            self.press("p")
        self.until(lambda: "has ended" in state())
        self.until(lambda: "completed after 20:00" in self.js("document.querySelector('header').textContent"))
        self.assertEqual(self.js("[...document.querySelectorAll('body > section > h2')].map((head) => head.textContent)"), ["Points", "Work of the robots", "Files of this run"])
        self.until(lambda: "1200.000 s" in place())
        self.until(lambda: self.js("document.querySelector('.moves button').checkVisibility()"))
        self.all_is_well()

    def test_hostile_names_do_nothing(self):
        agent = self.folder / "hostile"
        if not agent.exists():
            subprocess.run([CXLAB, "new", "agent", agent], check=True, capture_output=True, timeout=60)
        rules = next(path for path in agent.rglob("*.clp"))
        rules.write_text(rules.read_text() + f'\n(deftemplate evil (slot text))\n(deffacts evil (evil (text "{HOSTILE}")))\n'
                         f'(defrule takes-evil (evil (text ?text)) => (assert (taken ?text "{HOSTILE}")))\n(defrule never (evil (text "other {HOSTILE}")) =>)\n')
        scenario = next(path for path in agent.rglob("*.yaml") if "duration" in path.read_text() or "world" in path.read_text())
        self.view(self.play("evil run", scenario), link="#t=1")
        for question in ("facts", "agenda", "rules", "firings", "globals"):
            self.tab(question)
        for name, what in (("why", "(taken $?)"), ("why-not", "never")):
            self.tab(name)
            self.search(".asked input", what)
            self.assertIn(HOSTILE, self.js("document.querySelector('.ask').textContent"))
        self.assertIsNone(self.js("window.hit"))
        self.assertEqual(self.js("document.querySelectorAll('.ask img').length"), 0)
        self.all_is_well()

    def test_narrow_screens_scroll_down_only(self):
        self.view(self.game(), link="#t=300&ask=why&what=order-begin")
        self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {"width": 400, "height": 800, "deviceScaleFactor": 1, "mobile": False})
        self.assertEqual(self.js("innerWidth"), 400)
        for tab in ("facts", "rules", "firings", "why"):
            self.tab(tab)
            self.assertLessEqual(self.js("document.documentElement.scrollWidth"), 400, tab)
        self.all_is_well()


if __name__ == "__main__":
    unittest.main()
