#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""HTML of all pages, with the pictures and files that they link to.

    pages.py SOURCE FOLDER VERSION

Begins at README.md and follows the links. A link to a file that does not exist, or to a heading that
a page does not have, is an error. FOLDER/api is what Doxygen makes of the public headers.
"""
import html
import pathlib
import re
import shutil
import sys

from markdown_it import MarkdownIt
from markdown_it.tree import SyntaxTreeNode

HERE = pathlib.Path(__file__).parent
ELSEWHERE = re.compile(r"[a-z]+:")


def anchor_of(heading):
    """The anchor that a heading has on a forge"""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


class Page:
    """A Markdown file: title, headings (text, anchor), links (label, file, anchor) and its HTML."""

    def __init__(self, path):
        self.parser = MarkdownIt("commonmark").enable("table")
        self.tokens = self.parser.parse(path.read_text())
        self.path, self.headings, self.anchors, self.links, self.title = path, [], set(), [], path.stem
        for node in SyntaxTreeNode(self.tokens).walk():
            if node.type == "heading":
                self.add_heading(node)
            elif node.type == "link":
                self.add_link(text_of(node), node.nester_tokens.opening, "href")
            elif node.type == "image":
                self.add_link(text_of(node), node.token, "src")

    def add_heading(self, node):
        text = text_of(node)
        anchor = anchor_of(text)
        node.nester_tokens.opening.attrSet("id", anchor)
        self.anchors.add(anchor)
        if node.tag == "h1":
            self.title = text
        elif node.tag == "h2":
            self.headings.append((text, anchor))

    def add_link(self, label, token, attribute):
        """Into the project: noted, and changed to what stands there in HTML"""
        target = str(token.attrGet(attribute))
        if ELSEWHERE.match(target):
            return
        path, _, anchor = target.partition("#")
        file = (self.path.parent / path).resolve() if path else self.path
        self.links.append((label, file, anchor))
        if file.suffix == ".md":
            token.attrSet(attribute, re.sub(r"\.md(#|$)", r".html\1", target))
        elif file.is_dir():
            token.attrSet(attribute, target.rstrip("/") + "/index.html")

    def body(self):
        return self.parser.renderer.render(self.tokens, self.parser.options, {})


def text_of(node):
    return "".join(n.content for n in node.walk() if n.type in ("text", "code_inline"))


def follow(source):
    """Pages and other files that the README leads to, and what is wrong with the links"""
    pages, files, faults = {}, set(), []
    waiting = [source / "README.md", source / "docs/README.md"]
    while waiting:
        path = waiting.pop()
        if path in pages:
            continue
        pages[path] = Page(path)
        for _, file, _ in pages[path].links:
            if file.suffix == ".md" and file.exists():
                waiting.append(file)
            else:
                files.add(file)
    for page in pages.values():
        for label, file, anchor in page.links:
            where = f"{page.path.relative_to(source)}: [{label}]"
            if not file.exists():
                faults.append(f"{where}: no {file}")
            elif anchor and file in pages and anchor not in pages[file].anchors:
                faults.append(f"{where}: no heading #{anchor} in {file.relative_to(source)}")
    return pages, files, faults


def copy(source, file, folder):
    """A file, or the files of a folder with a list of them"""
    place = folder / file.relative_to(source)
    if file.is_file():
        place.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(file, place)
        return
    inside = sorted(f.relative_to(file) for f in file.rglob("*") if f.is_file() and "__" not in str(f))
    for name in inside:
        copy(source, file / name, folder)
    rows = "".join(f'<li><a href="{html.escape(str(n))}">{html.escape(str(n))}</a>' for n in inside)
    (place / "index.html").write_text(f"<title>{place.name}</title><h1>{place.name}</h1><ul>{rows}</ul>")


def write(source, folder, version):
    pages, files, faults = follow(source)
    if faults:
        return faults
    template = (HERE / "page.html").read_text()
    for file in files:
        copy(source, file, folder)
    for path, page in pages.items():
        place = (folder / path.relative_to(source)).with_suffix(".html")
        place.parent.mkdir(parents=True, exist_ok=True)
        known = {
            "title": html.escape(page.title),
            "version": version,
            "root": "../" * (len(place.relative_to(folder).parts) - 1),
            "inside": "".join(f'<li><a href="#{a}">{html.escape(t)}</a>' for t, a in page.headings),
            "body": page.body(),
        }
        place.write_text(re.sub(r"\$\{?(\w+)\}?", lambda m: known[m[1]], template))
    return []


if __name__ == "__main__":
    wrong = write(pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]), sys.argv[3])
    print("\n".join(wrong), end="\n" if wrong else "")
    sys.exit(bool(wrong))
