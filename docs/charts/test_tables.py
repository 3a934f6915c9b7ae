# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Tables of docs/accuracy.md from what the programs test_reference and test_laws print."""
import re

from rows import table


def reference(text):
    """The worst error of each answer, and the robot that has it"""
    worst, robot = {}, ""
    for line in text.splitlines():
        if re.search("joints.*worst of", line):
            robot = line.split(".json:")[0]
        if re.match("  [a-z]", line):
            *words, error = line.split()
            worst.setdefault(" ".join(words), []).append((error, robot))
    return table("answer|worst error|robot", (
        (name, *max(found, key=lambda entry: float(entry[0]))) for name, found in worst.items()))


def laws(text):
    """Worst errors of each method, with a line of the rest"""
    methods, rest, column = {}, {"f128": "0"}, 0
    for line in text.splitlines():
        if line.startswith("[ RUN"):
            column = 0 if "acceleration" in line else 2 if "lambda" in line else -1
        found = re.match(r" *(.*?):? +worst (.*), bound ", line)
        if not found or re.search("f32|twice", found[1]):
            continue
        name, error = found.groups()
        if "f128" in name:
            rest["f128"] = max(rest["f128"], error, key=float)
        elif column < 0:
            rest["M" if name == "crba" else name] = error
        else:
            plain = name.replace(", refined", "")
            methods.setdefault(plain, ["-"] * 4)[column + (plain != name)] = error
    same = {}
    for name, cells in methods.items():
        same.setdefault(tuple(cells), []).append(f"`{name}`")
    full = table("method|qdd|refined once|Λ⁻¹|refined once",
                 ((", ".join(names), *cells) for cells, names in same.items()))
    full += ("\n`rnea`: {rnea}; mass matrix: {M}; the worst of all in quadruple precision: {f128}."
             "\n".format(**rest))
    return full


def make(work):
    """Blocks of the programs that have run"""
    blocks, texts = {}, {name: work / f"test_{name}.txt" for name in ("reference", "laws")}
    if texts["reference"].exists():
        blocks["reference"] = reference(texts["reference"].read_text())
    if texts["laws"].exists():
        blocks["laws"] = laws(texts["laws"].read_text())
    return blocks
