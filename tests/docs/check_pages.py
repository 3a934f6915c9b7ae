#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Sizes and links of the documentation.

    check_pages.py SOURCE

README.md has at most 120 lines, docs/ and some pages a number of words; every link and picture
leads to a file, every anchor to a heading; every page of docs/ is in docs/README.md; every layer of
lib/README.md is drawn in architecture.svg.
"""
import pathlib
import re
import sys

README_LINES = 120
DOCS_WORDS = 20700
PAGE_WORDS = {"python.md": 500}
PAGE_LINES = {"which-method.md": 60}


def words_of(text):
    """Bars of tables, dashes and operators are none."""
    return sum(any(c.isalnum() for c in word) for word in text.split())


def check_layers(source):
    """Every folder in the table of lib/README.md, those of dynamics/ too, in the picture"""
    drawn = re.findall(r">([\w/]+)[:<]", (source / "docs/architecture.svg").read_text())
    for first, rest in re.findall(r"^\| (`.*?) \| (.*) \|", (source / "lib/README.md").read_text(), re.M):
        for folder in re.findall(r"`([\w/]+)/`", first + (rest if "dynamics" in first else "")):
            if folder not in drawn:
                yield f"docs/architecture.svg: {folder} of lib/README.md is not drawn"


def check(source):
    readme, docs = source / "README.md", sorted((source / "docs").glob("*.md"))
    lines = len(readme.read_text().splitlines())
    if lines > README_LINES:
        yield f"README.md: {lines} lines, at most {README_LINES}"
    words = {page.name: words_of(page.read_text()) for page in docs}
    if sum(words.values()) > DOCS_WORDS:
        yield f"docs: {sum(words.values())} words, at most {DOCS_WORDS}: {words}"
    yield from check_layers(source)
    for page, limit in PAGE_WORDS.items():
        if words[page] > limit:
            yield f"docs/{page}: {words[page]} words, at most {limit}"
    for page, limit in PAGE_LINES.items():
        if len((source / "docs" / page).read_text().splitlines()) > limit:
            yield f"docs/{page}: more than {limit} lines"
    index = (source / "docs/README.md").read_text()
    for page in docs:
        if page.name != "README.md" and f"]({page.name}" not in index:
            yield f"docs/README.md: {page.name} is missing"
    sys.path.append(str(source / "docs/html"))
    from pages import follow

    yield from follow(source)[2]


if __name__ == "__main__":
    faults = list(check(pathlib.Path(sys.argv[1]).resolve()))
    print("\n".join(faults) or "pages: sizes and links are right")
    sys.exit(bool(faults))
