# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""What an atlas counts, on rows that are made up: broken promises, failures, who answered. And the page
and the pictures of fixed rows."""
import csv
import html.parser
import io
import math
import pathlib
import re
import tempfile
import unittest
from dataclasses import fields

from support import SOURCE, main
from totalforce import Model, _totalforce
from totalforce_tools import atlas, atlas_page, atlas_pictures
from totalforce_tools.atlas_rows import Row
from totalforce_tools.atlas_words import Summary, broken_promises, short

ORIGIN = ("a machine", "2026-01-01", "totalforce atlas <script>")


def made_up(mode="service", **values):
    return Row("ratio", 0, 1.0, 2, "qdd", "tfa", mode, **{"answered_by": "tfa", **values})


# kept, failed, fell back, refused
JUDGED = {
    "good": (made_up(own=3, error=1e-9, worst=1e-9, floor=1e-12, over=29.0), 1, 0, 0, 0),
    "estimate too small": (made_up(own=3, error=1e-9, floor=1e-12, over=31.0), 0, 0, 0, 0),
    "silent": (made_up(own=3, error=1e-5, floor=1e-12, silent=1), 0, 0, 0, 0),
    "wrong": (made_up(own=3, error=1e-3, floor=1e-6), 1, 1, 0, 0),
    "data allow no better": (made_up(own=3, error=1e-3, floor=1e-4), 1, 0, 0, 0),
    "fallback": (made_up(own=1, fallback=2, error=1e-9, floor=1e-12), 1, 0, 1, 0),
    "refused": (made_up(refused=3, status="E_SINGULAR"), 1, 0, 0, 1),
    "not finite": (made_up(refused=3, status="E_NOT_COMPUTED"), 1, 1, 0, 1),
}


class Judgements(unittest.TestCase):
    def test_rows(self):
        for what, (row, *wanted) in JUDGED.items():
            found = [Summary([row]).kept, row.failed, row.fell_back, row.is_refused]
            self.assertEqual(found, [bool(w) for w in wanted], what)
            self.assertEqual(bool(list(broken_promises([row]))), not wanted[0], what)

    def test_the_worst_are_found(self):
        rows = [made_up(own=2, worst=1e-6, floor=1e-6, unsaid=2),
                made_up(own=1, fallback=1, worst=1e-9, floor=1e-15, over=2.0),
                made_up("plain", own=2, worst=1e3, floor=1e-15, unsaid=2)]
        s = Summary(rows)
        self.assertIs(s.worst, rows[0])
        self.assertIs(s.far, rows[1])
        self.assertIs(s.over, rows[1])
        self.assertEqual(s.answers, [3, 1, 0])
        self.assertEqual(s.unsaid, 2)  # what a method alone does is no word of the service

    def test_axes_end_where_they_should(self):
        for name, facts in atlas.MAPS.items():
            first, last = facts.value(0, 13), facts.value(12, 13)
            self.assertEqual(first, 0.0 if name == "curl" else 1.0)
            robots = [Model(_totalforce._mechanism(facts.mechanism, 5, **{facts.option: value}))
                      for value in (first, last)]
            self.assertNotEqual(robots[0].hash, robots[1].hash)  # the value goes somewhere
        self.assertAlmostEqual(atlas.MAPS["ratio"].value(6, 13) / 1e6, 1.0, delta=1e-12)

    def test_numbers_are_short(self):
        for value, text in ((0.0, "0"), (1.0, "1"), (10.0, "10"), (100.0, "1e2"), (1e12, "1e12"),
                            (0.01, "0.01"), (1e-3, "1e-3"), (3.1623e-6, "3.2e-6"),
                            (0.0278, "0.028")):
            self.assertEqual(short(value), text)


NAMES = {"error_over_estimate": "over"}
KINDS = {NAMES.get(f.name, f.name): f.type for f in fields(Row)}


def read_rows():
    """Rows of tests/pages/data/atlas.csv"""
    path = SOURCE / "tests" / "pages" / "data" / "atlas.csv"
    with open(path, newline="", encoding="utf-8") as file:
        for line in csv.DictReader(line for line in file if not line.startswith("#")):
            row = Row(*[None] * 7)
            for name, text in line.items():
                name = NAMES.get(name, name)
                if text or KINDS[name] == str:
                    setattr(row, name, KINDS[name](text))
            yield row


def fixed_maps():
    rows = list(read_rows())
    for _, some in atlas.by_map(rows):
        points = {value: k for k, value in enumerate(dict.fromkeys(r.value for r in some))}
        for row in some:
            row.point = points[row.value]
    return [(name, atlas.MAPS[name], some) for name, some in atlas.by_map(rows)]


class Cells(html.parser.HTMLParser):
    """Titles and colours of all cells of a page; texts by their element"""

    def __init__(self, text):
        super().__init__()
        self.cells, self.tags, self.texts, self.last = [], set(), {}, ""
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.add(tag)
        self.last = tag
        attrs = dict(attrs)
        if "title" in attrs:
            self.cells.append((attrs["title"], re.search("background: (#[0-9a-f]+)",
                                                         attrs["style"])[1]))

    def handle_data(self, data):
        self.texts.setdefault(self.last, []).append(data)


class Drawings(unittest.TestCase):
    maps = fixed_maps()

    def test_page(self):
        out = io.StringIO()
        atlas_page.write(out, self.maps, *ORIGIN)
        page = Cells(out.getvalue())
        rows = [row for _, _, some in self.maps for row in some]
        floors = sum(row.method == rows[0].method and row.mode == "plain" for row in rows)
        self.assertEqual(len(page.cells), len(rows) + floors)
        self.assertRegex(page.texts["h1"][0], r"^\d+ of \d+ default requests are wrong")
        self.assertIn("a machine, 2026-01-01: totalforce atlas <script>", page.texts["p"])
        self.assertFalse(page.tags & {"script", "link", "img", "iframe"})
        row = next(r for r in rows if r.map == "thin" and r.method == "tfa" and r.mode == "plain"
                   and r.bodies == 16 and r.value < 1e-5)
        title, shade = next((t, c) for t, c in page.cells
                            if t.startswith(f"tfa at {short(row.value)}, 16 bodies: error {row.error:.2e}"))
        self.assertIn("; default request: error ", title)
        self.assertEqual(shade, atlas_page.colour(row.error)[0])
        self.assertGreater(len({shade for _, shade in page.cells}), 4)

    def test_picture(self):
        with tempfile.TemporaryDirectory() as folder:
            name, facts, rows = self.maps[0]
            atlas_pictures.draw(folder, name, facts, rows, *ORIGIN)
            text = (pathlib.Path(folder) / f"{name}.svg").read_text(encoding="utf-8")
            self.assertTrue((pathlib.Path(folder) / f"{name}.png").exists())
        for words in (facts.what.capitalize(), "a machine, 2026-01-01: totalforce atlas &lt;script>",
                      "floor of the data", facts.axis, *(r.method for r in rows)):
            self.assertIn(words, text.replace("&gt;", ">"))

    def test_shades_follow_digits(self):
        shades = [atlas_page.colour(10.0 ** power)[0] for power in range(-17, 3)]
        self.assertEqual(len(set(shades)), 8)
        self.assertEqual(atlas_page.colour(math.inf), atlas_page.colour(1.0))


main()
