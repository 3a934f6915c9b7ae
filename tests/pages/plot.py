# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""`totalforce plot` of a fixed session (two scripted responders in virtual time): page, pictures,
comparison.

    plot.py BIN
"""
import copy
import html.parser
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

BIN = pathlib.Path(sys.argv.pop(1))
DATA = pathlib.Path(__file__).parent / "data" / "latency.json"
SESSION = json.loads(DATA.read_text(encoding="utf-8"))
HEADLINE = ("arm over shm: half of 3000 round trips within 11 µs, 99 % within 21 µs, all within "
            "40 ms")
COMMAND = "totalforce latency arm --table <script>window.hit=1<"


def plot(*arguments, status=0):
    done = subprocess.run([BIN / "totalforce", "plot", *arguments], capture_output=True, text=True)
    assert done.returncode == status, (arguments, done)
    return done.stderr if status else done.stdout


class Page(html.parser.HTMLParser):
    """Texts of a page by their element, all tags, all attributes"""

    def __init__(self, path):
        super().__init__()
        self.texts, self.tags, self.attributes, self.open = {}, set(), [], []
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attrs):
        self.tags.add(tag)
        self.attributes += attrs
        self.open.append(tag)

    def handle_endtag(self, tag):
        while self.open and self.open.pop() != tag:
            pass

    def handle_data(self, data):
        if self.open:
            self.texts.setdefault(self.open[-1], []).append(data)


class Plot(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.path = pathlib.Path(folder.name)
        plot("--html", cls.path / "page.html", "-o", cls.path / "new" / "folder", DATA)
        cls.page = Page(cls.path / "page.html")

    def saved(self, session, name="other.json"):
        (self.path / name).write_text(json.dumps(session), encoding="utf-8")
        return self.path / name

    def test_page_says_where_it_comes_from(self):
        self.assertEqual(self.page.texts["h1"], [HEADLINE])
        self.assertIn(f"Fixed Processor, 2026-01-01: {COMMAND}", self.page.texts["p"])
        self.assertIn("not told", self.page.texts["td"])

    def test_page_works_offline(self):
        self.assertFalse(self.page.tags & {"script", "link", "img", "iframe", "object", "image"})
        for name, value in self.page.attributes:
            self.assertFalse(name in ("src", "href", "xlink:href") and not value.startswith("#"),
                             (name, value))
            self.assertNotIn("url(http", value or "")

    def test_marks_have_the_numbers_of_the_report(self):
        titles = self.page.texts["title"]
        slower = [int(word) for word in re.findall(r"(\d+) slower ones",
                                                   " ".join(self.page.texts["text"]))]
        bars = [int(word) for word in re.findall(r"µs: (\d+) round trips", " ".join(titles))]
        self.assertEqual(sum(bars) + sum(slower), 2 * 3000)
        for run in SESSION["runs"]:
            percentiles = run["ns"]["round_trip"]["percentiles"]
            for name in ("90", "99"):
                self.assertIn(f"{run['via']}: {name} % within {percentiles[name] / 1e3:.4g} µs",
                              titles)
            for name, parts in run["breakdown_ns"].items():
                name = "slowest" if name == "max" else f"p{name}"
                self.assertIn(f"{name}: compute {parts['compute'] / 1e3:.4g} of "
                              f"{parts['round_trip'] / 1e3:.4g} µs, of {parts['count']}", titles)
        self.assertIn("ping-pong: 99 % within 0.406 µs", titles)

    def test_pictures_say_where_they_come_from(self):
        for name in ("latency", "latency-shm", "latency-socket"):
            picture = self.path / "new" / "folder" / name
            words = " ".join(Page(picture.with_suffix(".svg")).texts["text"])
            for text in (COMMAND, "Fixed Processor, 2026-01-01", "round trip"):
                self.assertIn(text, words)
            self.assertEqual(picture.with_suffix(".png").read_bytes()[1:4], b"PNG")

    def test_one_session_is_told_in_a_line(self):
        self.assertEqual(plot(DATA), HEADLINE + "\n")

    def test_sessions_are_compared(self):
        slower = copy.deepcopy(SESSION)
        for run in slower["runs"]:
            run["load"] = "closed loop, 100 a second"
            for histogram in (run["round_trip"], *run["slices"]):
                histogram["highest"] *= 4
                # two powers of two further: four times as long
                histogram["buckets"] = [[bucket + 2 * 128, count]
                                        for bucket, count in histogram["buckets"]]
        text = plot(DATA, self.saved(slower))
        self.assertIn('not the same load: "closed loop", "closed loop, 100 a second"', text)
        self.assertIn("  p50             10.751     43.007   4.000  ", text)
        self.assertEqual(text.count(" slower"), 6)
        same = plot(DATA, DATA)
        self.assertIn("  p50             10.751     10.751   1.000  ", same)
        self.assertEqual(same.count(" within noise"), 6)
        noisy = copy.deepcopy(SESSION)
        for run in noisy["runs"]:
            for histogram in run["slices"][::2]:  # every other tenth twice as long
                histogram["highest"] *= 2
                histogram["buckets"] = [[bucket + 128, count] for bucket, count in
                                        histogram["buckets"]]
        text = plot(DATA, self.saved(noisy))
        self.assertIn("  p50             10.751     10.751   1.000  0.853 to 2.345 too noisy to tell",
                      text)
        del slower["runs"][1]
        self.assertIn("not as many runs: 2, 1", plot(DATA, self.saved(slower)))

    def test_what_cannot_be_drawn(self):
        self.assertIn("which session?", plot(status=3))
        self.assertIn("one argument too many", plot(DATA, DATA, DATA, status=3))
        self.assertIn("/nonexistent: No such file", plot("/nonexistent", status=2))
        self.assertIn("Is a directory", plot("--html", self.path, DATA, status=2))
        damaged = copy.deepcopy(SESSION)
        damaged["runs"][0]["round_trip"]["count"] += 1
        self.assertIn("does not add up", plot(self.saved(damaged), status=2))
        for change in ({"format": "totalforce latency 0"}, {"runs": None}, {"runs": []}, {"pingpong": {}}):
            self.assertIn("no session: ", plot(self.saved({**SESSION, **change}), status=2))
        self.assertIn("no session: ", plot(self.saved([1]), status=2))


unittest.main()
