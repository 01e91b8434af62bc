"""The page of a run, taken apart: what its scripts read."""

import base64
import gzip
import json
import pathlib
import re


def island(page, name):
    """The bytes that the page has inside under that id; None if it has none."""
    found = re.search(rf'<script type="text/plain" id="{name}">([^<]*)</script>', page)
    return gzip.decompress(base64.b64decode(found[1], validate=True)) if found else None


class RunPage:
    def __init__(self, run):
        self.text = (pathlib.Path(run) / "index.html").read_text()
        self.run = json.loads(island(self.text, "run-data"))
        self.scene = island(self.text, "run-scene")

    def part(self, title):
        return next((part for part in self.run["parts"] if part["title"] == title), None)

    def lanes(self):
        return [lane for part in self.run["parts"] if part["type"] == "lanes" for lane in part["lanes"]]

    def events(self, kind):
        return [event for event in self.run["events"] if event["kind"] == kind]

    @property
    def static(self):
        """The page without what is packed and without scripts: what it shows where there are none."""
        return re.sub(r"<script.*?</script>", "", self.text, flags=re.DOTALL)
