"""The site of the documentation in Chromium: it is built, asks for nothing else, finds words, and fits into 400 and 1400 pixels. ./dev readers"""

import subprocess
import unittest

from in_browser import SOURCE, Browser

SITE = SOURCE / "build/docs"


class Site(Browser):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        subprocess.run([SOURCE / "dev", "docs"], check=True, capture_output=True, timeout=300)
        cls.pages = sorted(page for page in SITE.rglob("*.html") if page.name != "404.html" and "sources" not in page.relative_to(SITE).parts)

    def set_width(self, width):
        self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 600})

    def test_no_page_is_wider_than_the_screen_or_asks_for_more(self):
        self.assertGreater(len(self.pages), 80)
        self.start_browser()
        for width in (400, 1400):
            self.set_width(width)
            for page in self.pages:
                with self.subTest(f"{page.relative_to(SITE)} at {width} pixels"):
                    self.browser.get(page.as_uri())
                    self.assertLessEqual(self.js("document.documentElement.scrollWidth"), width)
                    self.assertTrue(self.js("[...document.images].every(image => image.complete && image.naturalWidth > 0)"), "a picture is missing")
        self.clean()

    def test_search_works_from_the_file_system(self):
        self.start_browser()
        self.browser.get((SITE / "index.html").as_uri())
        field = self.browser.find_element("css selector", "input.md-search__input")
        field.click()
        field.send_keys("determinism")
        self.until(lambda: self.js("document.querySelectorAll('.md-search-result__item').length") > 3)
        self.clean()

    def test_dark_and_light(self):
        self.start_browser()
        self.browser.get((SITE / "index.html").as_uri())
        for wanted, scheme in (("dark", "slate"), ("light", "default")):
            self.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": wanted}]})
            self.browser.execute_script("localStorage.clear()")
            self.browser.refresh()
            self.until(lambda: self.js("document.body.getAttribute('data-md-color-scheme')") == scheme)


if __name__ == "__main__":
    unittest.main()
