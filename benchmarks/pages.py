"""Measures how fast headless Chromium shows a page without a graphics card.

It prints the frames per second while the slider goes from begin to end, the CPU time of a frame, and the time until the first picture.

    pages.py PAGE... [--size 1400x900] [--swiftshader]

PAGE is index.html of a run, or an address that cxlab view printed. With --swiftshader, SwiftShader draws the whole page as a graphics card would, and
not only the field in 3D. Needs Debian's chromium-driver and python3-selenium."""

import argparse
import os
import sys
import time
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[1]
os.environ.setdefault("CXLAB", "cxlab")
os.environ.setdefault("CXLAB_SOURCE_DIR", str(SOURCE))
sys.path.insert(0, str(SOURCE / "tests/readers"))
from in_browser import SOFTWARE_GL, chromium

SECONDS = 5
# Seeks once in each frame, as somebody does who drags the slider.
SCRUB = """
const done = arguments[arguments.length - 1], seconds = arguments[0], clock = cxlab.clock, begin = performance.now();
let frames = 0;
dispatchEvent(new PointerEvent('pointerdown'));
const frame = (now) => {
  const share = (now - begin) / (1000 * seconds);
  if (share >= 1) {
    dispatchEvent(new PointerEvent('pointerup'));
    return done(frames);
  }
  ++frames;
  clock.seek(Math.max(0, share) * clock.end);
  requestAnimationFrame(frame);
};
requestAnimationFrame(frame);
"""


def cpu_of_threads(root):
    """Seconds of CPU of each thread of the processes below `root`."""
    parents = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        parents[int(stat.parent.name)] = int(fields[1])
    used = {}
    for pid in parents:
        above = pid
        while above and above != root:
            above = parents.get(above, 0)
        if above != root:
            continue
        for stat in Path(f"/proc/{pid}/task").glob("*/stat"):
            try:
                name, _, rest = stat.read_text().rpartition(")")
            except OSError:
                continue
            fields = rest.split()
            used[stat.parent.name, name.partition("(")[2]] = (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    return used


def measure(page, size, gl):
    browser = chromium(*gl, size=size)
    try:
        browser.set_script_timeout(120)
        browser.get(page if "://" in page else Path(page).resolve().as_uri())
        while not browser.execute_script("return document.documentElement.dataset.ready && !document.querySelector('canvas.solid')?.hidden && !document.querySelector('[aria-busy=true]')"):
            time.sleep(0.05)
        time.sleep(1)
        first = browser.execute_script("return performance.getEntriesByName('first-contentful-paint')[0].startTime")
        results = []
        for _ in range(3):
            before = cpu_of_threads(browser.service.process.pid)
            frames = browser.execute_async_script(SCRUB, SECONDS)
            after = cpu_of_threads(browser.service.process.pid)
            spent = {thread: seconds - before.get(thread, 0) for thread, seconds in after.items()}
            results.append((frames / SECONDS, 1000 * sum(spent.values()) / frames, 1000 * max(spent.values()) / frames))
        return first, max(results)
    finally:
        browser.quit()


parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("pages", nargs="+")
parser.add_argument("--size", default="1400x900")
parser.add_argument("--swiftshader", action="store_true")
options = parser.parse_args()
for page in options.pages:
    first, (rate, all_threads, busiest) = measure(page, tuple(map(int, options.size.split("x"))), SOFTWARE_GL if options.swiftshader else ())
    print(f"{page.partition('?')[0]}: first picture after {first:.0f} ms; {rate:.1f} frames/s; {all_threads:.1f} ms of CPU a frame, the busiest thread {busiest:.1f} ms", flush=True)
