"""Hook of MkDocs: links of a page that leave docs/, or that name a source file, lead to a page of the site that shows the file.

The same Markdown then works on GitHub, in an editor and on the site, and the site needs no other place to show a file.
"""

import os
import posixpath
import re
import subprocess
from pathlib import Path

from mkdocs.structure.files import File, InclusionLevel

ROOT = Path(__file__).resolve().parents[2]
# Pages that stand outside of docs/ by convention; they are in the navigation.
OUTSIDE = ("CONTRIBUTING.md", "CHANGELOG.md", "benchmarks/README.md", "third_party/README.md")
LANGUAGES = {".yaml": "yaml", ".cpp": "cpp", ".h": "cpp", ".py": "python", ".clp": "lisp", ".pddl": "lisp", ".txt": "text", ".json": "json"}
LINK = re.compile(r"(!?\[(?:[^\[\]]|\[[^\]]*\])*\]\()([^)\s#]+)(#[^)\s]*)?(\))")
FENCE = re.compile(r"^( *)(```+).*?^\1\2[ \t]*$", re.MULTILINE | re.DOTALL)


def tracked(folder):
    listed = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard", folder], cwd=ROOT, text=True, check=True,
                            stdout=subprocess.PIPE).stdout
    return sorted(set(listed.splitlines()))


def is_picture(file):
    return file.endswith((".png", ".gif", ".svg"))


def place_of(file):
    """Where a file of the sources is on the site."""
    if file in OUTSIDE:
        return file
    inside = file.removeprefix("docs/")
    if inside != file and (inside.endswith(".md") or is_picture(inside)) and not inside.startswith(("examples/", "templates/")):
        return inside
    return f"sources/{file}" if is_picture(file) else f"sources/{file}.md"


def text_of_source(file):
    """The page that shows a file or lists a folder."""
    path = ROOT / file
    if path.is_dir():
        lines = [f"- [{name}]({posixpath.relpath(place_of(name), posixpath.dirname(place_of(file)))})" for name in tracked(file)]
        return f"# {file}\n\nThe files of this folder of the sources.\n\n" + "\n".join(lines) + "\n"
    text = path.read_text(errors="replace")
    return f"# {file}\n\n````{LANGUAGES.get(path.suffix, 'text')}\n{text}````\n"


def rewrite(text, page):
    """The text of a file of the sources with links for the site, and the files that they name."""
    named, here = set(), posixpath.dirname(place_of(page))

    def link(found):
        target = found.group(2)
        if re.match(r"\w+:", target):
            return found.group(0)
        file = posixpath.normpath(posixpath.join(posixpath.dirname(page), target))
        if not (ROOT / file).exists():
            return found.group(0)
        named.add(file)
        return f"{found.group(1)}{posixpath.relpath(place_of(file), here)}{found.group(3) or ''}{found.group(4)}"

    parts, end = [], 0
    for fence in FENCE.finditer(text):
        parts += [LINK.sub(link, text[end:fence.start()]), fence.group(0)]
        end = fence.end()
    return "".join([*parts, LINK.sub(link, text[end:])]), named


def on_files(files, config):
    texts = {}
    pages = [f"docs/{file.src_uri}" for file in files.documentation_pages()] + list(OUTSIDE)
    waiting, seen = [], set(pages)
    for page in pages:
        texts[page], named = rewrite((ROOT / page).read_text(), page)
        waiting += sorted(named - seen)
    while waiting:
        file = waiting.pop()
        if file in seen or not place_of(file).startswith("sources/"):
            continue
        seen.add(file)
        if is_picture(file):
            files.append(File.generated(config, place_of(file), abs_src_path=str(ROOT / file)))
            continue
        texts[file] = text_of_source(file)
        if (ROOT / file).is_dir():
            waiting += tracked(file)
    for file, text in texts.items():
        place = place_of(file)
        if place.startswith("sources/"):
            files.append(File.generated(config, place, content=text, inclusion=InclusionLevel.NOT_IN_NAV))
        elif file in OUTSIDE:
            files.append(File.generated(config, place, content=text))
        else:
            files.get_file_from_path(place).content_string = text
    return files
