"""The pages as a whole: links, anchors, navigation, length. python3 -m unittest links"""

import posixpath
import re
import unittest
from pathlib import Path

from ceilings import Ceilings
from markdown_pages import SOURCE, anchors, blank_code, headings, kind_of, markdown_files, prose_words, slug_of, tracked
from words import measure

LINK = re.compile(r"!?\[(?:[^\[\]]|\[[^\]]*\])*\]\(<?([^)\s>]+)>?(?:\s+\"[^\"]*\")?\)")
MOST_WORDS = 1500
# Pages that a program or a template writes for its reader, and that are no part of the site.
NOT_ON_SITE = ("docs/examples/", "docs/templates/", "lab/pages/", "tests/", "python/")


def links(text):
    """(line, target) of each link outside of code."""
    text = re.sub(r"(`+)(?!`).*?(?<!`)\1(?!`)", lambda found: " " * len(found.group(0)), blank_code(text))
    for number, line in enumerate(text.splitlines(), 1):
        for found in LINK.finditer(line):
            yield number, found.group(1)


def problem_of(page, target, exists, text_of):
    """The fault of a link of a page, or ""."""
    if re.match(r"[a-z+]+:", target):
        return ""
    path, _, anchor = target.partition("#")
    file = posixpath.normpath(posixpath.join(posixpath.dirname(page), path)) if path else page
    if file.startswith("..") or path.startswith("/"):
        return "it leaves the repository"
    if not exists(file):
        return "there is no such file"
    if not anchor or not file.endswith(".md"):
        return ""
    text = text_of(file)
    for site, name in ((False, "on GitHub"), (True, "on the site")):
        if anchor not in anchors(text, site):
            return f"{file} has no such anchor {name}; it has {', '.join(sorted(anchors(text, site)))}"
    return ""


def navigation():
    """The pages in mkdocs.yml, as paths of the repository."""
    listed = re.findall(r"^ +- .*?([\w./-]+\.md)$", (SOURCE / "mkdocs.yml").read_text().partition("\nnav:")[2], re.MULTILINE)
    outside = re.search(r"^OUTSIDE = \((.*)\)$", (SOURCE / "docs/site/hook.py").read_text(), re.MULTILINE)[1]
    return [page if f'"{page}"' in outside else f"docs/{page}" for page in listed]


def pages():
    return [name for name in markdown_files() if not name.startswith(NOT_ON_SITE)]


class Links(unittest.TestCase):
    def test_each_leads_somewhere(self):
        files = set(tracked())
        folders = {str(folder) for file in files for folder in Path(file).parents}
        count = 0
        for page in markdown_files():
            if page.startswith("lab/pages/"):  # templates of pages: what they give is read
                continue
            for line, target in links((SOURCE / page).read_text()):
                count += 1
                with self.subTest(f"{page}:{line}: {target}"):
                    self.assertEqual(problem_of(page, target, lambda file: file in files | folders, lambda file: (SOURCE / file).read_text()), "")
        self.assertGreater(count, 300, "the pages are read")

    def test_wrong_ones_are_found(self):
        text = "# A page\n\n## What `x` is\n\n## Twice\n\n## Twice\n"
        problem = lambda target: problem_of("docs/how-to/a.md", target, {"docs/b.md", "docs/how-to/a.md"}.__contains__, lambda file: text)
        for right in ("../b.md", "#what-x-is", "../b.md#a-page", "https://example.org/nothing"):
            self.assertEqual(problem(right), "", right)
        for wrong in ("b.md", "../b.md#what-x-was", "#", "../../../b.md", "#twice-1", "#twice_1"):
            self.assertTrue(problem(wrong) or wrong == "#", wrong)

    def test_links_in_code_are_none(self):
        self.assertEqual(list(links("a `[b](c)`\n\n```\n[d](e)\n```\n\n[f](g.md) ![h](i.png)\n")), [(7, "g.md"), (7, "i.png")])

    def test_anchors_are_those_of_github_and_of_the_site(self):
        for heading, github, site in [("Two words", "two-words", "two-words"), ("`a_b`, c: d!", "a_b-c-d", "a_b-c-d"),
                                      ("A - b", "a---b", "a-b"), ("[Link](x.md) é", "link-é", "link-e"), ("**Bold** *x*", "bold-x", "bold-x")]:
            self.assertEqual((slug_of(heading), slug_of(heading, "-")), (github, site))


class Site(unittest.TestCase):
    def test_each_page_is_in_the_navigation_once(self):
        shown = navigation()
        self.assertEqual(sorted(set(shown)), sorted(shown), "a page is listed twice")
        self.assertEqual(sorted(set(shown) | {"README.md"}), sorted({*pages(), "README.md"}), "mkdocs.yml and the files differ")

    def test_each_page_begins_with_its_title_and_a_sentence(self):
        for page in pages():
            with self.subTest(page):
                text = (SOURCE / page).read_text()
                titles = re.findall(r"^# (.*)", blank_code(text), re.MULTILINE)
                self.assertEqual(len(titles), 1, "one title")
                after = text.partition(f"# {titles[0]}\n")[2].lstrip()
                self.assertFalse(re.match(r"[#|!]|```|[-*] |1\. ", after), f"a sentence that says what the reader gets comes first, not {after[:20]!r}")

    def test_each_page_has_one_kind(self):
        for page in pages():
            if page.startswith("docs/") and page != "docs/index.md":
                self.assertIn(kind_of(page), ("tutorials", "how-to", "reference", "explanation", "internals"), page)


class Length(unittest.TestCase):
    def test_no_page_is_too_long(self):
        ceilings = Ceilings("words")
        for page in pages():
            if kind_of(page) == "reference":
                continue
            words = prose_words((SOURCE / page).read_text())
            with self.subTest(page):
                self.assertLessEqual(words, max(MOST_WORDS, ceilings.of(page)), f"{page} has {words} words: shorten or divide it")

    def test_sentences_are_not_too_long(self):
        ceilings = Ceilings("sentences")
        for page in pages():
            _, _, long = measure((SOURCE / page).read_text())
            with self.subTest(page):
                self.assertLessEqual(len(long), ceilings.of(page), f"see tests/docs/words.py --long {page}")

    def test_exceptions_are_none_that_have_gone(self):
        for kind in ("words", "sentences"):
            self.assertEqual([page for page in Ceilings(kind).all() if page not in pages()], [])


class Headings(unittest.TestCase):
    def test_are_read(self):
        self.assertEqual(headings("# a\n```\n# no\n```\n## b ##\n"), ["a", "b"])


if __name__ == "__main__":
    unittest.main()
