# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""`totalforce chart`: every row is an answer with a finite error or a refusal by name; its front, seeds,
same answers; pictures and a page of fixed rows."""
import contextlib
import csv
import io
import json
import math
import pathlib
import re
import subprocess
import tempfile
import unittest
import xml.dom.minidom

from support import ROBOTS, SOURCE, TOOL, main
from totalforce_tools import cases, chart, chart_page, chart_peers, chart_pictures, chart_rows, command
from totalforce_tools.chart_rows import Row

ARM = str(SOURCE / "tests" / "tools" / "data" / "arm.urdf")
FIXED = SOURCE / "tests" / "pages" / "data" / "chart.csv"
OWN = ("crba", "aba", "tfa", "tfa-cr", "hessenberg", "cfa", "cfa-cr", "dca", "scan", "scan-two-pass",
       "hybrid")
ANSWERS = ("ok", "fallback")


def run(line):
    """Status, standard output and standard error of `totalforce chart LINE`, in this process"""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            command.run("chart", chart.main, line.split())
        except SystemExit as end:
            return end.code, out.getvalue(), err.getvalue()
    raise AssertionError("no end")


def rows_of(text):
    return list(csv.DictReader(line for line in text.splitlines() if not line.startswith("#")))


def charted(line, status=0):
    code, out, err = run(line)
    if code != status:
        raise AssertionError(f"{line}: {code}, {err}")
    return rows_of(out)


class Rows(unittest.TestCase):
    def check_answer(self, row):
        self.assertRegex(row["error"], r"^[0-9.]+e[-+][0-9]+$")
        for name in ("time_us", "aba_us", "time_ratio"):
            self.assertGreater(float(row[name]), 0, row)
        for name, unit in (("error", ""), ("time", "_us")):
            low, middle, high = (float(row[f"{name}{end}{unit}"]) for end in ("_low", "", "_high"))
            self.assertTrue(low <= middle <= high, row)
        self.assertFalse(row["same_as"] and int(row["front"]), "one answer is twice on the front")

    def test_every_mechanism(self):
        rows = charted(f"--bodies 2,7 --budget-ms 1 --states 2 --seeds 2 --methods {','.join(OWN)}")
        self.assertEqual(list(rows[0]), list(chart_rows.COLUMNS))
        self.assertEqual(len(rows), 15 * 2 * 3 * len(OWN) * 2)
        for row in rows:
            if row["status"] in ANSWERS:
                self.check_answer(row)
                self.assertFalse(row["method"] == "aba" and float(row["error"]) > 1e-6, row)
            else:
                self.assertTrue(row["status"].startswith("E_") and not row["error"], row)
                wanted = "body link" if row["status"] == "E_SINGULAR" else ""
                self.assertTrue(row["about"] and row["about"].startswith(wanted), row)
        fronts = {(r["mechanism"], r["bodies"], r["rhs"]) for r in rows if r["front"] == "1"}
        self.assertEqual(len(fronts), 90)
        self.assertGreater(sum(r["error_low"] < r["error_high"] for r in rows), len(rows) / 2)
        self.assertIn("E_SINGULAR", {r["status"] for r in rows if r["mechanism"] == "rank-deficient"
                                     and r["method"] == "tfa"})

    def test_same_answers(self):
        rows = charted("--mechanisms random --bodies 8,64 --methods aba,tfa-cr,cfa-cr --rhs tau "
                       "--budget-ms 1 --seeds 1")
        for row in rows:
            self.assertEqual((row["error_low"], row["time_low_us"]),
                             (row["error_high"], row["time_high_us"]), "one seed has a spread")
            long = row["bodies"] == "64" and row["method"] == "cfa-cr"
            self.assertEqual(row["same_as"], "tfa-cr" if long else "", row)

    def test_json(self):
        code, out, _ = run(f"--urdf {ARM} --base floating --rhs tau --refine 0 --json --budget-ms 1")
        self.assertEqual(code, 0)
        rows = [json.loads(line) for line in out.splitlines()]
        self.assertEqual(tuple(rows[0]), chart_rows.KEYS)
        self.assertEqual({row["mechanism"] for row in rows}, {"arm"})
        self.assertIn('"rhs":"tau","method":"aba","refine":0,"precision":"f64","threads":1,'
                      '"strategy":"single","status":"ok"', out)

    def test_thin_rods(self):
        aba, tfa = charted("--mechanisms thin --bodies 24 --methods aba,tfa --rhs qdd --refine 0 "
                           "--budget-ms 1")
        self.assertGreater(float(tfa["error"]), 1e3 * float(aba["error"]))

    def test_a_mechanism_is_its_file(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "chain.urdf"
            file.write_bytes(subprocess.run([TOOL, "chain", "random", "--bodies", "6"], check=True,
                                            capture_output=True).stdout)
            both = [charted(f"{source} --turn 1 --seeds 1 --methods aba,tfa,crba --rhs tau "
                            "--refine 0 --budget-ms 1")
                    for source in ("--mechanisms random --bodies 6", f"--urdf {file}")]
        for a, b in zip(*both):
            self.assertEqual([a[c] for c in chart_rows.COLUMNS[2:14]],
                             [b[c] for c in chart_rows.COLUMNS[2:14]])

    def test_precisions(self):
        rows = charted("--mechanisms random --bodies 5 --methods aba,tfa --rhs tau "
                       "--precision f64,f64+f128,f128,f32 --budget-ms 1")
        aba = [row for row in rows if row["method"] == "aba"]
        self.assertEqual([r["precision"] for r in aba], ["f64", "f64", "f64+f128", "f128", "f128",
                                                         "f32", "f32"])
        self.assertLess(float(aba[3]["error"]), 1e-20, "the reference differs from itself")
        for row in rows:
            self.assertIn(row["status"], (*ANSWERS, "E_UNSUPPORTED"))

    def test_strategies(self):
        code, out, err = run(f"--urdf {ARM} --methods auto,aba --rhs qdd --threads 1,2 --refine 0 "
                             "--strategies single,batch,specialised --kernels /nonexistent "
                             "--precision f64,f32 --budget-ms 1")
        self.assertEqual(code, 0)
        self.assertIn("no specialised kernel: ", err)
        rows, errors = rows_of(out), {}
        for row in rows:
            if row["strategy"] == "specialised":
                self.assertEqual((row["status"], row["about"], row["method"]),
                                 ("E_UNSUPPORTED", "kernel", "auto"))
            else:
                key = row["method"], row["precision"]
                self.assertEqual(row["error"], errors.setdefault(key, row["error"]), "other bits")
        self.assertEqual(len(rows), 20)
        self.assertGreater(float(errors["aba", "f32"]), 1e3 * float(errors["aba", "f64"]))

    def test_operational_inertia(self):
        rows = charted(f"--urdf {ARM} --op operational_inertia,forward_dynamics --rhs tau,qdd "
                       "--strategies single,batch --refine 0 --precision f64,f32 --budget-ms 1")
        inertia = [row for row in rows if row["op"] == "operational_inertia"]
        errors = {}
        for row in inertia:
            self.assertEqual((row["rhs"], row["precision"], row["status"]), ("", "f64", "ok"))
            self.assertLess(float(row["error"]), 1e-12)
            self.assertEqual(row["error"], errors.setdefault(row["method"], row["error"]))
        self.assertTrue({"pv-osimr", "crba", "efpa"} <= set(errors) and "aba" not in errors)
        self.assertGreaterEqual(sum(int(row["front"]) for row in inertia), 2)
        self.assertFalse(any(r["rhs"] == "" for r in rows if r not in inertia))

    def test_over_budget(self):
        """Processor time, far from the bound of 200 ms on either side: crba needs a second or so."""
        rows = charted("--mechanisms straight --bodies 8,2048,2049 --methods aba,crba,hessenberg "
                       "--rhs tau --refine 0 --budget-ms 10 --states 2 --seeds 1")
        by = {m: [r["status"] for r in rows if r["method"] == m] for m in ("aba", "crba", "hessenberg")}
        self.assertEqual(by["crba"], ["ok", "over_budget", "over_budget"])
        self.assertEqual(by["hessenberg"], ["ok", "E_UNSUPPORTED", "E_UNSUPPORTED"])
        self.assertEqual(by["aba"], ["ok"] * 3)

    def test_peers(self):
        if not chart_peers.TABLE:
            self.assertIn("--methods: no 'mujoco'", run("--methods mujoco")[2])
            self.skipTest("no peers in this build")
        names = list(chart_peers.TABLE)
        rows = charted(f"--methods {','.join(names)} --mechanisms random --bodies 5,301 --rhs tau "
                       "--budget-ms 1")
        for row in rows:
            if row["bodies"] == "301":
                self.assertEqual(row["status"], "too_large")
            else:
                self.assertEqual((row["status"], row["answered_by"]), ("ok", row["method"]))
                self.assertLess(float(row["error"]), 1e-6)


class Options(unittest.TestCase):
    REFUSED = {
        "--mechanisms knot": "--mechanisms: no 'knot'",
        "--mechanisms taper:0": "--mechanisms: taper:0: the number must be positive",
        "--methods magic": "--methods: no 'magic'",
        "--methods aba,aba": "--methods: aba twice",
        "--op operational_inertia --methods rnea": "--methods: rnea answers none of --op",
        "--op sideways": "--op: no 'sideways'",
        "--rhs sideways": "--rhs: no 'sideways'; there are qdd, tau, gravity",
        "--refine 3": "--refine: no '3'",
        "--precision f16": "--precision: no 'f16'; there are f64, f32, f32+f64, f64+f128, f128",
        "--precision f32+f64 --refine 0": "--precision f32+f64 needs --refine 1 or 2",
        "--strategies batch,sideways":
            "--strategies: no 'sideways'; there are single, batch, specialised, specialised-batch",
        "--strategies batch,batch": "--strategies: batch twice",
        "--strategies specialised": "--strategies specialised needs --kernels FOLDER",
        "--threads 1,2,3,4,5,6,7,8,9": "--threads: more than 8",
        "--threads 0": "--threads: '0' is not a whole number from 1 to 256",
        "--seeds 17": "--seeds: '17' is not",
        "--turn 0": "--turn: 0, must be above 0",
        "one": "one argument too many: 'one'",
    }

    def test_refused(self):
        for line, message in self.REFUSED.items():
            code, _, err = run(line)
            self.assertEqual(code, 3, line)
            self.assertIn(f"totalforce chart: {message}", err)

    def test_failures(self):
        for line, message in (("--urdf /absent.urdf", "[unreadable]"),
                              ("-m random -n 2 --output /absent/folder", "/absent/folder"),
                              ("-m random -n 2 --html /absent/page.html", "/absent/page.html")):
            code, _, err = run(line)
            self.assertEqual(code, 2, line)
            self.assertIn(message, err)


def made(method, error, time, bits, **fields):
    row = Row("arm", 3, "tau", method, 0, "f64", 1, "single", "forward_dynamics", answered_by=method,
              error=error, error_low=error, error_high=error, floor=1e-16, estimate=math.nan,
              worst_component=error, time_us=time, time_low_us=time, time_high_us=time, aba_us=time,
              time_ratio=1.0, samples=3, bits=(bits,))
    return chart_rows.replace(row, **fields)


class Sums(unittest.TestCase):
    def test_seeds(self):
        rows = [made("aba", error, time, 1)
                for error, time in ((1e-10, 2.0), (1e-9, 1.0), (1e-12, 4.0))]
        row = chart_rows.combine(rows)
        self.assertEqual((row.error, row.error_low, row.error_high), (1e-10, 1e-12, 1e-9))
        self.assertEqual((row.time_us, row.time_low_us, row.time_high_us, row.samples),
                         (2.0, 1.0, 4.0, 9))
        rows[2].fail("E_SINGULAR")
        self.assertFalse(chart_rows.combine(rows).good)

    def test_same_and_front(self):
        rows = [made("aba", 1e-15, 2.0, 1), made("tfa-cr", 1e-12, 3.0, 2),
                made("cfa-cr", 1e-12, 1.0, 2), made("scan", 1e-15, 1.0, 1, threads=2)]
        chart_rows.find_same(rows)
        self.assertEqual([row.same_as for row in rows], ["", "", "tfa-cr", ""])
        chart_rows.mark_front(rows[:3])
        self.assertEqual([row.front for row in rows[:3]], [1, 0, 0])

    def test_axes(self):
        """Two to twelve numbers on every axis of time"""
        figure, axes = chart_pictures.style.picture("x", "", "", "")
        for low in (0.1, 0.13, 0.31, 0.77):
            for ratio in (1.0, 1.07, 1.5, 3.9, 4.1, 11.0, 13.0, 300.0, 1100.0, 1e6):
                chart_pictures.set_axes(axes[0, 0], [low, low * ratio])
                left, right = axes[0, 0].get_xlim()
                shown = [t for t in axes[0, 0].get_xticks() if left <= t <= right]
                self.assertTrue(2 <= len(shown) <= 12, (low, ratio, shown))
        self.assertIsNotNone(figure)


def fixed_rows():
    numbers = {"bodies", "refine", "threads", "samples", "front"}
    for row in rows_of(FIXED.read_text()):
        known = {name: int(text) if name in numbers else text for name, text in row.items()
                 if text and name != "status"}
        for name, kind in Row.__annotations__.items():
            if kind is float and name in known:
                known[name] = float(known[name])
        yield Row(**{"rhs": "", **known}, status="" if row["status"] in ANSWERS else row["status"])


class Drawings(unittest.TestCase):
    def setUp(self):
        self.rows = list(fixed_rows())
        line = re.search("# command: totalforce chart (.*)", FIXED.read_text())[1]
        self.options = chart.options_of(line.split())

    def test_page(self):
        scatters = [chart_pictures.scatter(self.options, some)
                    for some in chart_pictures.cases_of(self.rows)]
        out = io.StringIO()
        chart_page.write(out, self.options, self.rows, scatters)
        text = out.getvalue()
        titles = re.findall(r'<g id="f\d+-mark-\d+"><title>([^<]*)</title>', text)
        drawn = [row for row in self.rows if row.drawn]
        self.assertEqual(len(titles), len(drawn), "a mark for each row")
        self.assertTrue(any(f"time_us {drawn[0].time_us:.4g}" in title for title in titles))
        self.assertNotRegex(text, "<script|<link|@import")
        for picture in re.findall("<svg.*?</svg>", text, re.S):
            xml.dom.minidom.parseString(picture)
        self.assertEqual(text.count("<tr><td>"), len(self.rows) + len(
            chart_pictures.panels_of(self.rows)), "a line for each row and panel")

    def test_conclusion(self):
        text = chart_pictures.conclusion(self.rows, self.options)
        self.assertRegex(text, "exact to rounding")
        worse = [chart_rows.replace(row, error=1.0) for row in self.rows]
        self.assertEqual(chart_pictures.conclusion(worse, self.options),
                         "No answer is exact to rounding here")

    def test_overview(self):
        first = [row for row in self.rows if row.op == "forward_dynamics" and row.threads == 1
                 and row.strategy == "single"]
        figure, name = chart_pictures.overview(self.options, first)
        self.assertEqual(name, "overview")
        text = chart_pictures.style.svg(figure)
        for words in ("Counted over all", "CPU time of a call", "On the front somewhere"):
            self.assertIn(words, text)


class References(unittest.TestCase):
    def test_at_the_border(self):
        self.assertEqual(cases.exact_method("operational_inertia", 128), "crba")
        self.assertEqual(cases.exact_method("operational_inertia", 129), "propagation")
        case = cases.Case.mechanism("random", 128, 1)
        states = cases.States(case, "operational_inertia", "qdd", 2)
        for s in range(2):
            reply = case.exact.compute(states.op, **states.request(s), method="propagation")
            self.assertLess(cases.error_of(states.answer(reply), states.exact[s])[0], 1e-20)
        self.assertTrue(2**-53 <= states.floor < 1e-13)

    def test_rounded_cosines_are_in_the_floor(self):
        """On a straight chain near q = 0 they are more than the last bits of all other numbers."""
        case = cases.Case.mechanism("straight", 1024, 1)
        states = cases.States(case, "forward_dynamics", "tau", 5)
        rounded = cases.tf.Workspace(case.model, precision="f128", round_sincos=True)
        change = cases.median([cases.error_of(states.answer(rounded.compute(
            states.op, **states.request(s), method="aba")), states.exact[s])[0] for s in range(5)])
        self.assertGreater(change, 4e-16)
        self.assertGreater(states.floor, 0.7 * change)

    def test_random_numbers(self):
        """Of splitmix64 with seed 1: the first number, and the same whether one by one or together"""
        self.assertEqual(int(cases.Random(1).bits(1)[0]), 0x910A2DEC89025CC1)
        one = cases.Random(5)
        self.assertEqual([float(one.normal(1)[0]) for _ in range(4)], list(cases.Random(5).normal(4)))


main()
