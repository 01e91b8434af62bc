#!/usr/bin/env python3
"""Counts the words of pages and the share of their sentences above 30 words, without code blocks and tables.

tests/docs/words.py [--long] [FILE.md|FOLDER ...]     without files: README, CONTRIBUTING, CHANGELOG and docs
  --long    also list the sentences above 30 words, with their lines
"""

import argparse
from pathlib import Path

from markdown_pages import LONGEST_SENTENCE, SOURCE, kind_of, markdown_files, prose_words, sentences, words_of


def measure(text):
    """Words, sentences, and the sentences above 30 words as (line, sentence)."""
    found = list(sentences(text))
    return prose_words(text), len(found), [(line, sentence) for line, sentence in found if len(words_of(sentence)) > LONGEST_SENTENCE]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--long", action="store_true")
    parser.add_argument("files", nargs="*", type=Path)
    arguments = parser.parse_args()
    if arguments.files:
        files = [found for file in arguments.files for found in (sorted(file.rglob("*.md")) if file.is_dir() else [file])]
    else:
        files = [SOURCE / name for name in markdown_files() if "/" not in name or kind_of(name) or name == "docs/index.md"]
        files = [file for file in files if "docs/examples" not in str(file) and "docs/templates" not in str(file)]
    pages = words = count = above = 0
    print(f"{'words':>7} {'sentences':>9} {'above 30':>8}  page")
    for file in files:
        text = file.read_text()
        page_words, page_sentences, long = measure(text)
        name = file.resolve().relative_to(SOURCE) if SOURCE in file.resolve().parents else file
        print(f"{page_words:7} {page_sentences:9} {100 * len(long) / max(page_sentences, 1):7.1f}%  {name}")
        if arguments.long:
            for line, sentence in long:
                print(f"    {name}:{line}: {len(words_of(sentence))} words: {sentence}")
        pages, words, count, above = pages + 1, words + page_words, count + page_sentences, above + len(long)
    print(f"{words:7} {count:9} {100 * above / max(count, 1):7.1f}%  {pages} pages together")


if __name__ == "__main__":
    main()
