# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Every block of docs/python.md runs as it stands, in order, in a folder with config/ only."""
import os
import pathlib
import re
import shutil
import subprocess
import tempfile

import support


class Documentation(support.Case):
    def test_blocks(self):
        text = (support.SOURCE / "docs" / "python.md").read_text()
        blocks = re.findall(r"^```(\w+)\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
        self.assertGreater(len(blocks), 5)
        self.assertLessEqual(len(text.split()), 500)
        with tempfile.TemporaryDirectory(prefix="tfdoc") as folder:
            shutil.copytree(support.SOURCE / "config", pathlib.Path(folder) / "config")
            script = [
                "set -e",
                "trap '[ -z \"$daemon\" ] || kill $daemon 2>/dev/null || true' EXIT",
            ]
            for k, (language, block) in enumerate(blocks):
                self.assertIn(language, ("sh", "python"))
                name = re.match(r"# (\w+\.py)\n", block)
                if language == "python":
                    file = name[1] if name else f"block{k}.py"
                    (pathlib.Path(folder) / file).write_text(block)
                    script += [] if name else [f"python3 -W error {file}"]
                else:
                    script.append(block)
            path = f"/usr/bin:/bin:{support.BIN}"
            done = subprocess.run(
                ["sh", "-c", "\n".join(script)],
                cwd=folder,
                capture_output=True,
                text=True,
                timeout=100,
                env={**os.environ, "PATH": path},
            )
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        for wanted in ("joint_2 +", "(512, 7, 7)", "E_SIZE q q: shape (3,), must be (7,)"):
            self.assertIn(wanted, done.stdout)


if __name__ == "__main__":
    support.main()
