# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Commands in Python: command lines and their faults as those of the commands in C, pages, pictures."""
import contextlib
import io
import re
import unittest
import xml.dom.minidom

from support import main
from totalforce_tools import command, page, style
from totalforce_tools.command import Failed, Group, Option, Usage, each, number, positive, whole, word

LINE = command.Command(
    "trial", "Tries.", [
        Option("methods", "M", "METHOD,...", "Methods", each(word(("aba", "crba")), 2)),
        Option("count", "n", "N", "How many (3)", whole(1, 9), 3),
        Option("turn", None, "X", "Angle", positive(1e3)),
        Option("json", None, None, "JSON"),
        Group("Files:"),
        Option("output", "o", "FOLDER", "Back\\slash"),
    ], "Words:\n  aba: one\n", "FILE", {"METHOD": ["aba", "crba"]})


def outcome(body, argv=()):
    """Exit status, standard output, standard error of a command with this body"""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            command.run("trial", body, list(argv))
        except SystemExit as end:
            return end.code, out.getvalue(), err.getvalue()
    raise AssertionError("command.run returned")


def parsed(*argv):
    return LINE.parse(list(argv), most=1)


class CommandLine(unittest.TestCase):
    def refused(self, message, *argv):
        code, _, err = outcome(lambda line: LINE.parse(line, most=1), argv)
        self.assertEqual(code, 3)
        self.assertIn(f"totalforce trial: {message}", err)
        self.assertIn("--help", err)

    def test_values(self):
        o = parsed("a.urdf", "-M", "aba", "--methods=crba", "--turn", "1e-3", "-n4", "--js")
        self.assertEqual((o.arguments, o.methods, o.turn, o.count, o.json, o.output),
                         (["a.urdf"], ["aba", "crba"], 1e-3, 4, True, None))
        self.assertEqual(o.command, "totalforce trial a.urdf -M aba --methods=crba --turn 1e-3 "
                         "-n4 --js")
        self.assertEqual(parsed().count, 3)

    def test_faults(self):
        self.refused("--methods: no 'abba'; there are aba, crba", "-M", "abba")
        self.refused("--methods: aba twice", "-M", "aba", "-M", "aba")
        self.refused("--count: '0' is not a whole number from 1 to 9\n", "-n", "0")
        self.refused("--count: '-1' is not a whole number from 1 to 9, in decimal", "-n", "-1")
        self.refused("--turn: -1, must be above 0", "--turn", "-1")
        self.refused("--turn: 2e3, must be at most 1000", "--turn", "2e3")
        self.refused("--turn: '0x1' is not a finite number", "--turn", "0x1")
        self.refused("one argument too many: 'b'", "a", "b")
        self.refused("no option '--cuont'; nearest: '--count'", "--cuont", "3")
        self.refused("option --count requires argument", "--count")
        for text in ("1e999", "1e-400", "", "--1", "1_000", " 5", "5kg", "nan", "one", "1e"):
            self.assertRaises(ValueError, number, text)
        for text in ("010", "+5", "1.0", "1e3", ""):
            self.assertRaises(ValueError, whole(0, 9000), text, None)
        self.assertEqual([number(t) for t in ("0e-400", "+.5", "-1.E2")], [0, 0.5, -100])

    def test_spellings(self):
        """As tests/tools/numbers.sh has them for the commands in C"""
        never = ["", "1e", "--1", "0x10", "1_000", " 5", "5 ", "5kg", "1;2", "nan", "inf", "1e400",
                 "one", "1.2.3", "2,5"]
        for text in never:
            self.assertRaises(ValueError, number, text)
        for text in [*never, "1e3", "1.5", "+5", "-1", "18446744073709551616"]:
            self.assertRaises(ValueError, whole(0, 2**64 - 1), text, None)

    def test_help(self):
        texts = [outcome(parsed_line, [name])[:2] for name in ("-h", "--help", "-?")]
        self.assertEqual(texts[0], texts[1])
        self.assertEqual(texts[0], texts[2])
        self.assertEqual(texts[0][0], 0)
        self.assertIn("Usage: totalforce trial [OPTION...] FILE\n", texts[0][1])
        self.assertIn("\n  -M, --methods=METHOD,...   Methods\n", texts[0][1])
        self.assertRegex(outcome(parsed_line, ["-V"])[1], r"^totalforce [0-9.]+ \(kernels: ")

    def test_tables(self):
        lines = outcome(parsed_line, ["--print-options"])[1].splitlines()
        self.assertEqual(lines[:3], ["about\tTries.", "after\tWords:\\n  aba: one\\n",
                                     "arguments\tFILE"])
        self.assertIn("option\tjson\t\t\tJSON", lines)
        self.assertIn("option\toutput\to\tFOLDER\tBack\\\\slash", lines)
        self.assertIn("option\thelp\t?\t\tGive this help", lines)
        self.assertEqual(lines[-1], "values\tMETHOD\taba\tcrba")


def parsed_line(argv):
    LINE.parse(argv)


class Endings(unittest.TestCase):
    def test_statuses(self):
        def raises(error):
            def body(_):
                raise error
            return body

        self.assertEqual(outcome(lambda _: 1)[0], 1)
        self.assertEqual(outcome(raises(Failed("no robot"))), (2, "", "totalforce trial: no robot\n"))
        self.assertEqual(outcome(raises(Usage("which")))[0], 3)
        code, _, err = outcome(raises(FileNotFoundError(2, "No such file or directory", "a.urdf")))
        self.assertEqual((code, err), (2, "totalforce trial: a.urdf: No such file or directory\n"))


def drawn():
    figure, axes = style.picture("Heavier tips cost digits, by $ and _", "a machine", "2026-01-01",
                                 "totalforce trial")
    axes[0, 0].plot([1, 2], [1, 2], gid="mark-0")
    return figure


class Drawings(unittest.TestCase):
    def test_picture(self):
        text = style.svg(drawn())
        for words in ("Heavier tips cost digits, by $ and _", "a machine", "2026-01-01",
                      "totalforce trial"):
            self.assertIn(words, text)
        self.assertEqual(text, style.svg(drawn()), "the same picture is the same text")

    def test_page(self):
        out = io.StringIO()
        parts = [page.heading("All"), page.figure(drawn(), {"mark-0": "aba <1 us>"}, "a line"),
                 page.figure(drawn()), page.folded("rows", page.table(["a", "b"], [["x&y", 0.5]]))]
        page.write(out, "Less & more", "a machine", "2026-01-01", "totalforce trial", parts)
        text = out.getvalue()
        self.assertIn("<title>aba &lt;1 us&gt;</title>", text)
        self.assertIn("<td>x&amp;y</td><td>0.5</td>", text)
        ids = re.findall(r'\bid="([^"]*)"', text)
        self.assertEqual(len(ids), len(set(ids)), "an id twice")
        self.assertNotRegex(text, "<script|<link|@import|src=")
        xml.dom.minidom.parseString(text[text.index("<svg"):text.index("</svg>") + 6])


main()
