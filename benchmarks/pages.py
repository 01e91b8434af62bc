"""Frames per second while the slider of a page is drawn, and the time until its first picture, in headless Chromium with software rendering:
pages.py PAGE... [--size 1400x900]. PAGE: index.html of a run, or the address that cxlab view prints. Debian's chromium-driver and python3-selenium."""

import argparse
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests/readers"))
import os

os.environ.setdefault("CXLAB", "cxlab")
os.environ.setdefault("CXLAB_SOURCE_DIR", str(Path(__file__).resolve().parents[1]))
from in_browser import SOFTWARE_GL, chromium

SECONDS = 5
# Seeks once in each frame, from the begin of the run to its end.
SCRUB = """
const done = arguments[arguments.length - 1], seconds = arguments[0], clock = cxlab.clock, begin = performance.now();
let frames = 0;
const frame = (now) => {
  const share = (now - begin) / (1000 * seconds);
  if (share >= 1) return done(frames / seconds);
  ++frames;
  clock.seek(share * clock.end);
  requestAnimationFrame(frame);
};
requestAnimationFrame(frame);
"""


def measure(page, size):
    browser = chromium(*SOFTWARE_GL, size=size)
    try:
        browser.set_script_timeout(60)
        browser.get(page if "://" in page else Path(page).resolve().as_uri())
        while not browser.execute_script("return document.documentElement.dataset.ready && !document.querySelector('canvas.solid')?.hidden"):
            time.sleep(0.05)
        time.sleep(1)
        first = browser.execute_script("return performance.getEntriesByName('first-contentful-paint')[0].startTime")
        return first, max(browser.execute_async_script(SCRUB, SECONDS) for _ in range(3))
    finally:
        browser.quit()


parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("pages", nargs="+")
parser.add_argument("--size", default="1400x900")
options = parser.parse_args()
for page in options.pages:
    first, frames = measure(page, tuple(map(int, options.size.split("x"))))
    print(f"{page}: first picture after {first:.0f} ms, {frames:.1f} frames/s")
