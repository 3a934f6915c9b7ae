# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Numbers on the command lines in Python are read whole or refused: every option that takes one, so
that a new option is tested from its first day. tests/tools/numbers.sh does the same for those in C."""
import unittest

from support import main
from totalforce_tools import sweep_options
from totalforce_tools.command import Option, Usage

LINES = [sweep_options.LINE]
NEVER = ["", "1e", "--1", "0x10", "1_000", " 5", "5 ", "5kg", "1;2", "nan", "inf", "1e400", "1e-400",
         "one", "\u0665"]
WHOLE = NEVER + ["1e3", "1.5", "2.0", "+5", "-1", "010", "2,,5", "18446744073709551616", "9" * 23]
REAL = NEVER + ["2,5", "1.2.3"]
SEVERAL = NEVER + ["1,2,", ",1,2", "1,,2", "1,2;3", "1,2,3,4,5,6,7,8,9,10,11"]
KINDS = {"N": WHOLE, "0|1|2|3": WHOLE, "X": REAL, "ANGLE": REAL, "X,Y,Z": SEVERAL,
         "JOINT=VALUE": ["elbow=" + text for text in SEVERAL], "I/N": [f"{t}/9" for t in WHOLE]}


class Numbers(unittest.TestCase):
    def spellings(self, option):
        if option.argument and option.argument.startswith("LINK:MASS"):
            return ["tool:" + text for text in SEVERAL]
        return KINDS.get(option.argument, [])

    def test_refused(self):
        options = 0
        for line in LINES:
            for option in (row for row in line.rows if isinstance(row, Option)):
                options += bool(self.spellings(option))
                for text in self.spellings(option):
                    with self.assertRaises(Usage, msg=f"--{option.name}={text}") as caught:
                        line.parse([f"--{option.name}={text}"], most=1)
                    self.assertIn(f"--{option.name}", str(caught.exception))
        self.assertGreaterEqual(options, 15)


if __name__ == "__main__":
    main()
