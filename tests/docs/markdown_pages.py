"""The pages of the documentation, as the tests and the linter read them. Needs only Python's standard library."""

import html
import os
import re
import subprocess
import unicodedata
from pathlib import Path

SOURCE = Path(os.environ.get("CXLAB_SOURCE_DIR", Path(__file__).resolve().parents[2]))
LONGEST_SENTENCE = 30

FENCE = re.compile(r"^( *)(`{3,}|~{3,})([^\n`]*)\n(.*?)^\1\2[ \t]*$", re.MULTILINE | re.DOTALL)
FRONT_MATTER = re.compile(r"\A---\n.*?\n---\n", re.DOTALL)


def tracked(*patterns):
    """Files of the repository that match, new ones included, without those that are ignored."""
    listed = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard", *patterns], cwd=SOURCE, text=True, check=True,
                            stdout=subprocess.PIPE).stdout
    return sorted({name for name in listed.splitlines() if (SOURCE / name).is_file()})


def markdown_files():
    return tracked("*.md")


def kind_of(name):
    """The kind of a page: tutorials, how-to, reference, explanation, internals, or "" for one outside of these folders."""
    folders = Path(name).parts
    return folders[1] if len(folders) > 2 and folders[0] == "docs" else ""


def blank_code(text):
    """The text with the lines of code blocks, comments and the front matter emptied, so that lines keep their numbers."""
    def emptied(found):
        return re.sub(r"[^\n]+", "", found.group(0))
    text = FRONT_MATTER.sub(emptied, text)
    text = FENCE.sub(emptied, text)
    return re.sub(r"<!--.*?-->", emptied, text, flags=re.DOTALL)


def paragraphs(text):
    """(line, text) of each paragraph, item of a list and heading, without code blocks, tables and pictures."""
    collected, begin = [], 0
    for number, line in enumerate([*blank_code(text).splitlines(), ""], 1):
        bare = line.strip()
        starts = re.match(r"(?:[-*+]|\d+\.)\s+|#{1,6}\s|!!!\s|\?\?\?\+?\s|>\s?", bare)
        if collected and (not bare or starts or bare.startswith("|")):
            yield begin, " ".join(collected)
            collected = []
        if not bare or bare.startswith("|") or re.fullmatch(r"[-=*_]{3,}|</?\w+[^>]*>|\[[^\]]+\]: .*", bare):
            continue
        if not collected:
            begin = number
        collected.append(bare[starts.end():] if starts else bare)
        if re.match(r"#{1,6}\s", bare):
            yield begin, collected.pop()


def plain(text):
    """What a reader sees of a paragraph: the text of links, pictures left out, one word for a piece of code."""
    text = re.sub(r"!\[[^\]]*\]\([^)]*\)", "", text)
    text = re.sub(r"\[((?:[^\[\]]|\[[^\]]*\])*)\]\([^)]*\)", r"\1", text)
    text = re.sub(r"(`+)(.+?)\1", lambda found: "`" + re.sub(r"\s+", "_", found.group(2).strip().rstrip(".?!:")) + "`", text)
    return html.unescape(re.sub(r"\*\*|__|(?<!\w)[*_](?=\w)|(?<=\w)[*_](?!\w)|<[^>]+>", "", text)).strip()


def words_of(text):
    return [word for word in text.split() if re.search(r"\w", word)]


ENDS = re.compile(r"(?<!\be\.g)(?<!\bi\.e)(?<!\betc)(?<!\bvs)(?<!\bNo)(?<!\bFig)[.!?][\"')\]]*\s+(?=[\"'(\[`]*(?:[A-Z0-9`./]|cxlab\b))|(?<=:)\s*$|;\s+(?=$)")


def sentences(text):
    """(line, sentence) of the prose of a page."""
    for line, paragraph in paragraphs(text):
        for sentence in ENDS.split(plain(paragraph)):
            if sentence and words_of(sentence):
                yield line, sentence.strip()


def prose_words(text):
    return sum(len(words_of(plain(paragraph))) for _, paragraph in paragraphs(text))


def slug_of(heading, separator=""):
    """The anchor that GitHub gives to a heading (separator ""), or MkDocs ("-", which joins several blanks and hyphens to one)."""
    text = re.sub(r"`+", "", re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", heading)).strip()
    if not separator:
        text = re.sub(r"(?<!\w)[*_]+|[*_]+(?!\w)", "", text)
        return re.sub(r"[^\w\- ]", "", text.lower()).replace(" ", "-")
    text = re.sub(r"(?<!\w)[*_]+|[*_]+(?!\w)", "", html.unescape(text))
    text = unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode()
    return re.sub(r"[-\s]+", "-", re.sub(r"[^\w\s-]", "", text).strip().lower())


def headings(text):
    return [found.group(1).strip() for found in re.finditer(r"^#{1,6}\s+(.*?)\s*#*$", blank_code(text), re.MULTILINE)]


def anchors(text, mkdocs):
    """All anchors of a page. The second heading of one name gets -1 on GitHub and _1 in MkDocs."""
    found, seen = set(re.findall(r'(?:id|name)="([^"]+)"', blank_code(text))), {}
    for heading in headings(text):
        slug = slug_of(heading, "-" if mkdocs else "")
        seen[slug] = seen.get(slug, -1) + 1
        found.add(slug if not seen[slug] else f"{slug}{'_' if mkdocs else '-'}{seen[slug]}")
    return found
