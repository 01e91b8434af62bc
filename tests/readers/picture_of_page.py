"""Takes a picture of a page: picture_of_page.py ADDRESS FILE.png [WIDTHxHEIGHT] [light|dark] [LINK]. Waits until the page is ready and nothing is asked any more.

For docs/pictures/view.png: play the first game of docs/tutorials/find-a-bug.md, and then, with the address that cxlab view /tmp/bugs/symbol prints:
picture_of_page.py ADDRESS docs/pictures/view.png 1400x1200 light '#t=200&order=2&ask=why-not&what=product-to-ring-station'"""

import sys
import time

from in_browser import SOFTWARE_GL, chromium

READY = "return document.documentElement.dataset.ready && !document.querySelector('[aria-busy=true]')"


def take(address, file, size="1400x900", theme="light", link=""):
    browser = chromium(*SOFTWARE_GL, size=tuple(map(int, size.split("x"))))
    try:
        browser.get(address)
        if link:
            browser.execute_script(f"location.hash = {link!r}")
        browser.execute_script("document.documentElement.dataset.theme = arguments[0]", theme)
        for _ in range(100):
            time.sleep(0.2)
            if browser.execute_script(READY):
                break
        time.sleep(1.5)
        browser.save_screenshot(file)
        for line in browser.get_log("browser"):
            print(line["level"], line["message"], file=sys.stderr)
    finally:
        browser.quit()


if __name__ == "__main__":
    take(*sys.argv[1:])
