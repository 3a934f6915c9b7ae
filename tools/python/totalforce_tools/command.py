# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Command lines as those of the commands in C: options, messages, exit statuses.

A table of options is parsed, shown by --help, and printed by --print-options for the programs that
write man pages and completion (service/command_line/command_line.h has the format).
"""
import functools
import getopt
import json
import math
import os
import re
import sys
import textwrap
import time
from types import SimpleNamespace
from typing import NamedTuple, Optional

import totalforce as tf
from totalforce import _totalforce

GOOD, UNMET, FAILED, USAGE = range(4)  # exit statuses, as tools/common/commands.h has them


class Usage(Exception):
    """A wrong command line: exit status 3."""


class Failed(Exception):
    """The work cannot be done: exit status 2."""


class Option(NamedTuple):
    """`read(text, before)` gives the value; `before` is that of the same option given earlier. Its
    ValueError becomes a usage error that begins with the option's name."""

    name: str
    letter: Optional[str]
    argument: Optional[str]
    what: str
    read: object = lambda text, before: text
    default: object = None


class Group(NamedTuple):
    """Heading of the options that follow; a remark if it has no colon at its end"""

    text: str


HELP = [
    Group("Help:"),
    Option("help", "?", None, "Give this help"),
    Option("usage", None, None, "Give a short usage"),
    Option("version", "V", None, "Print the program's version"),
]


class Command:
    """The command line of `totalforce NAME`."""

    def __init__(self, name, about, options, after="", arguments="", words=None):
        self.name = f"totalforce {name}"
        self.about, self.after, self.arguments = about, after, arguments
        self.rows = [*options, *HELP]
        self.options = [row for row in self.rows if isinstance(row, Option)]
        self.words = words or {}  # name of an argument: the words that stand for it

    def parse(self, argv, most=0):
        """Values by names of options, `arguments` (at most `most`), `command` (the line itself)."""
        if argv == ["--print-options"]:
            self.print_options()
            raise SystemExit(GOOD)
        letters = "h" + "".join(o.letter + ":" * bool(o.argument) for o in self.options if o.letter)
        names = [o.name + "=" * bool(o.argument) for o in self.options]
        try:
            given, arguments = getopt.gnu_getopt(argv, letters, names)
        except getopt.GetoptError as error:
            raise Usage(self._explain(error)) from None
        values = {o.name.replace("-", "_"): o.default for o in self.options}
        for word, text in given:
            self._take(values, word, text)
        if len(arguments) > most:
            raise Usage(f"one argument too many: '{arguments[most]}'")
        return SimpleNamespace(
            **values, arguments=arguments, command=" ".join([self.name, *argv]))

    def _explain(self, error):
        names = tuple(f"--{o.name}" for o in self.options)
        if "not recognized" in error.msg and len(error.opt) > 1:
            near = _totalforce._suggest(f"--{error.opt}", names).split(";")[0]
            return f"no option '--{error.opt}'; {near}"
        return error.msg

    def _take(self, values, word, text):
        word = {"-h": "--help"}.get(word, word)
        option = next(o for o in self.options if word in (f"--{o.name}", f"-{o.letter}"))
        if option in HELP:
            self._help(option.name)
        key = option.name.replace("-", "_")
        try:
            values[key] = option.read(text, values[key]) if option.argument else True
        except ValueError as error:
            raise Usage(f"--{option.name}: {error}") from None

    def _help(self, name):
        if name == "version":
            print(f"totalforce {tf.__version__} (kernels: {tf.isa()})")
        else:
            print(f"Usage: {self.name} [OPTION...] {self.arguments}".rstrip())
        if name == "help":
            print(textwrap.fill(self.about, 79))
            print(end="\n" * isinstance(self.rows[0], Option))
            for row in self.rows:
                print(f"\n {row.text}" if isinstance(row, Group) else help_of(row))
            if self.after:
                print("\n" + "\n".join(filled(line) for line in self.after.split("\n")))
        raise SystemExit(GOOD)

    def print_options(self):
        fact("about", self.about)
        fact("after", self.after)
        fact("arguments", self.arguments)
        for row in self.rows:
            if isinstance(row, Group):
                fact("group", row.text)
            else:
                fact("option", row.name, row.letter or "", row.argument or "", row.what)
        for name, words in self.words.items():
            fact("values", name, *words)


def fact(kind, *fields):
    """One line of --print-options; one without a text is left out."""
    if any(fields):
        escaped = (f.replace("\\", "\\\\").replace("\n", "\\n").replace("\t", " ") for f in fields)
        print(kind, *escaped, sep="\t")


def help_of(option):
    argument = option.argument or ""
    name = f"--{option.name}" + (f"={argument}" if argument else "")
    head = f"  -{option.letter}, {name}" if option.letter else f"      {name}"
    lines = textwrap.wrap(option.what, 50)
    gap = "\n" + " " * 29
    return (head.ljust(29) if len(head) < 28 else head + gap) + gap.join(lines)


def filled(line):
    indent = line[: len(line) - len(line.lstrip())]
    return textwrap.fill(line, 79, subsequent_indent=indent + "  " * bool(indent))


def explain(name, usage):
    """Says what is wrong with a command line."""
    print(f"totalforce {name}: {usage}\nTry `totalforce {name} --help' for more information.",
          file=sys.stderr, flush=True)


def run(name, main, argv=None):
    """Runs main(argv), the body of `totalforce NAME`, and ends the program by its status."""
    def tell(text):
        print(f"totalforce {name}: {text}", file=sys.stderr)

    try:
        status = main(sys.argv[1:] if argv is None else argv)
    except SystemExit as end:
        status = end.code
    except Usage as error:
        explain(name, error)
        status = USAGE
    except (Failed, tf.Error) as error:
        tell(error)
        status = FAILED
    except OSError as error:
        tell(f"{error.filename or 'output'}: {error.strerror}")
        status = FAILED
    except KeyboardInterrupt:
        status = 130
    try:
        sys.stdout.flush()
    except OSError as error:
        tell(f"output: {error.strerror}")
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # nothing is left for the end to flush
        status = FAILED
    sys.exit(status)


# Readers of option values

def word(words):
    def read(text, _):
        if text not in words:
            raise ValueError(f"no '{text}'; {_totalforce._suggest(text, tuple(words))}")
        return text

    return read


def whole(low, high):
    def read(text, _):
        decimal = re.fullmatch("0|[1-9][0-9]*", text)
        if not decimal or not low <= int(text) <= high:
            raise ValueError(f"'{text}' is not a whole number from {low} to {high}"
                             + ("" if decimal else ", in decimal digits"))
        return int(text)

    return read


def number(text, _=None):
    form = r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?"
    value = float(text) if re.fullmatch(form, text) else math.nan
    underflow = value == 0 and re.search("[1-9]", re.split("[eE]", text)[0])
    if underflow or not math.isfinite(value):
        raise ValueError(f"'{text}' is not a finite number, such as 2.5 or -1e-3")
    return value


def positive(most=math.inf):
    def read(text, _):
        value = number(text)
        if value <= 0:
            raise ValueError(f"{text}, must be above 0")
        if value > most:
            raise ValueError(f"{text}, must be at most {most:g}")
        return value

    return read


def each(read, most, twice=False):
    """A list "a,b,...", to which an option that is given again appends; `twice`: what is there
    already is passed over, otherwise an error."""
    def read_list(text, before):
        values = list(before or [])
        for entry in text.split(","):
            value = read(entry, None)
            if value in values and twice:
                continue
            if value in values:
                raise ValueError(f"{entry} twice")
            if len(values) == most:
                raise ValueError(f"more than {most}")
            values.append(value)
        return values

    return read_list


# Files of rows

@functools.cache
def machine():
    """Processor and kernels of this machine."""
    processor = "unknown"
    with open("/proc/cpuinfo", encoding="utf-8", errors="replace") as facts:
        for line in facts:
            if line.startswith("model name"):
                processor = line.split(":", 1)[1].strip()
                break
    return processor, tf.isa()


def today():
    return time.strftime("%Y-%m-%d", time.gmtime())


def print_head(out, command):
    """The lines of origin above rows of CSV"""
    processor, kernels = machine()
    known = [] if processor == "unknown" else [f"# processor: {processor}"]
    print(f"# command: {command}", f"# date: {today()}", *known,
          f"# client_kernels: {kernels}", f"# version: {tf.__version__}", sep="\n", file=out)


def open_rows(name, folder, as_json):
    """NAME.csv or NAME.jsonl in the folder, which is made; standard output without a folder."""
    if folder is None:
        return sys.stdout
    if not os.path.isdir(folder):
        os.mkdir(folder)
    path = os.path.join(folder, f"{name}.{'jsonl' if as_json else 'csv'}")
    return open(path, "w", encoding="utf-8")


def json_text(value):
    """As the commands in C print it: numbers with four digits, null where there is none"""
    if not isinstance(value, float):
        return json.dumps(value, ensure_ascii=False)
    if not math.isfinite(value):
        return "null"
    digits, exponent, power = f"{value:.4g}".partition("e")
    if exponent:
        return f"{digits}e{int(power)}"
    return digits if "." in digits else digits + ".0"


def json_line(values):
    return "{" + ",".join(f'"{key}":{json_text(value)}' for key, value in values.items()) + "}"


class Progress:
    """"what: done of count unit" in the last line of a terminal, at most twice a second"""

    def __init__(self, count, unit):
        self.count, self.unit, self.done, self.last = count, unit, 0, 0.0
        self.wanted = sys.stderr.isatty()

    def step(self, what):
        """Shows the step that begins, and counts it."""
        now = time.monotonic()
        if self.wanted and now - self.last > 0.5:
            self.last = now
            text = f"{what}: {self.done} of {self.count} {self.unit}"
            print(f"\r\033[K{text}", end="", file=sys.stderr, flush=True)
        self.done += 1

    def clear(self):
        if self.wanted and self.last:
            print("\r\033[K", end="", file=sys.stderr, flush=True)
