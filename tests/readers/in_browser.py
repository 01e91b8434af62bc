"""Pages in headless Chromium, for tests."""

import json
import os
import shutil
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

from selenium import webdriver
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.chrome.service import Service

CXLAB = os.environ["CXLAB"]
SOURCE = Path(os.environ["CXLAB_SOURCE_DIR"])
SOFTWARE_GL = ("--use-angle=swiftshader", "--enable-unsafe-swiftshader")
NO_GL = ("--disable-gpu", "--disable-software-rasterizer")


def chromium(*arguments, size=(1400, 900)):
    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium")
    for argument in ("--headless=new", "--no-sandbox", "--disable-background-networking", f"--window-size={size[0]},{size[1]}", *arguments):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    return webdriver.Chrome(service=Service(shutil.which("chromedriver")), options=options)


class Browser(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = Path(tempfile.mkdtemp(prefix="cxlab-page-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)

    @classmethod
    def play(cls, name, *arguments):
        run = cls.folder / name
        if not run.exists():
            subprocess.run([CXLAB, "run", *map(str, arguments), "--quiet", "--out", run], check=True, capture_output=True, timeout=120)
        return run

    def start_browser(self, gl=SOFTWARE_GL, size=(1400, 900)):
        self.browser = chromium(*gl, size=size)
        self.addCleanup(self.browser.quit)

    def show_address(self, address):
        self.browser.get(address)
        self.until(lambda: self.js("document.documentElement.dataset.ready"))

    def js(self, expression, *arguments):
        return self.browser.execute_script(f"return {expression}", *arguments)

    def until(self, what):
        for _ in range(400):
            if what():
                return
            time.sleep(0.05)
        self.fail(f"has not come in 20 s; console: {self.browser.get_log('browser')}")

    def press(self, *keys):
        ActionChains(self.browser).send_keys(*keys).perform()

    def shown(self):
        return self.js("document.getElementById('time').value"), self.js("cxlab.clock.t")

    def clean(self, allowed="^(file|data|chrome|about):"):
        """No error in the console, and nothing was asked for but what is allowed: the page itself."""
        self.assertEqual([line for line in self.browser.get_log("browser") if line["level"] in ("SEVERE", "WARNING") and "GPU stall" not in line["message"]
                          and "GroupMarkerNotSet" not in line["message"]], [])
        for line in self.browser.get_log("performance"):
            message = json.loads(line["message"])["message"]
            if message["method"] == "Network.requestWillBeSent":
                self.assertRegex(message["params"]["request"]["url"], allowed)
