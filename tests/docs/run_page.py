#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Runs every code block of a page of documentation, in order, as a reader would.

    with_domain run_page.py PAGE PREFIX SOURCE [--from-source] [--build BUILD] [--then PAGE]...

PREFIX is an installed totalforce. The blocks run in one bash session in a folder of its own with
copies of config/, idl/ and docs/examples/; with --from-source in a folder that looks like the
source tree with its build (the README starts there). Pages of --then go on in the same session,
with what the earlier ones copied and set.

    sh                     executed; a block fails where a command does
    c cpp cmake python xml yaml, whose first line is a comment with a file name: saved as that file
    python                 otherwise executed
    yaml                   otherwise a configuration or a fragment of one: totalforced --check
    json                   parsed; `...` is an ellipsis
    text                   not executed; a command in it is an error

`<!-- not run: REASON -->` on the line before a block leaves it out, and the reason is printed;
`<!-- run: COMMAND -->` is executed and not shown to a reader. Anything else is an error. A daemon
that a page starts (`... & daemon=$!`) is waited for until it serves; the page has to stop it.
"""
import argparse
import json
import os
import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "support"))
import guard
from wait import WAIT

FILE_NAME = re.compile(r"^(?:/\*|//|#|<!--)\s*([\w./-]+\.\w+)\b")
COMMANDS = re.compile(r"^\s*(\$ |sudo |apt|tools/|cmake |export |cc |gcc |totalforced? |python3? |"
                      r"ros2 |systemctl |docker |make |cd )")
TIMEOUT_S = 570  # ctest's is 600


class Block:
    """A fenced block, or a hidden command (language "run")."""

    def __init__(self, language, line, reason=None):
        self.language, self.line, self.reason = language, line, reason
        self.lines = []

    def text(self):
        return "\n".join(self.lines) + "\n"

    def file_name(self):
        found = FILE_NAME.match(self.lines[0]) if self.lines else None
        return found.group(1) if found else None


def parse(text):
    """Blocks of a page in order; the text's own mistakes."""
    blocks, mistakes = [], []
    block = reason = None
    indent = 0
    for number, line in enumerate(text.splitlines(), 1):
        fence = re.match(r"^( *)```(\w*)\s*$", line)
        if fence and block is None:
            indent = len(fence.group(1))
            block = Block(fence.group(2), number, reason)
            reason = None
        elif fence:
            blocks.append(block)
            block = None
        elif block is not None:
            block.lines.append(line[indent:] if not line[:indent].strip() else line)
        elif found := re.match(r"^ *<!-- not run: (.+) -->$", line):
            reason = found.group(1)
        elif found := re.match(r"^ *<!-- run: (.+) -->$", line):
            hidden = Block("run", number)
            hidden.lines.append(found.group(1))
            blocks.append(hidden)
        else:
            if reason and line.strip():
                mistakes.append((number, "'not run' without a block after it"))
                reason = None
            if re.match(r"^ *\$ ", line) or (re.match(r"^    ", line) and COMMANDS.match(line)):
                mistakes.append((number, "a command outside of a block"))
    if block is not None:
        mistakes.append((block.line, "a block without an end"))
    return blocks, mistakes


def parse_json(text):
    """Raises ValueError unless the text is a sequence of JSON values with ellipses."""
    text = re.sub(r"\.\.\.", "null", text.replace("\n", " "))
    decoder = json.JSONDecoder()
    while text := text.strip():
        _, end = decoder.raw_decode(text)
        text = text[end:]


def shell_of(block, folder, count):
    """Commands of a block; ValueError for one that cannot be run."""
    name = block.file_name()
    if block.language in ("sh", "run"):
        lines = []
        for line in block.lines:
            lines.append(line)
            if re.search(r"& daemon=\$!(; sleep 1)?$", line):
                lines.append("await")
        return "\n".join(lines)
    if block.language in ("c", "cpp", "cmake", "python", "xml", "yaml") and name:
        (folder / f"block_{count}").write_text(block.text())
        return (f"mkdir -p {shlex.quote(os.path.dirname(name) or '.')} && "
                f"cp {folder}/block_{count} {shlex.quote(name)}")
    if block.language == "python":
        (folder / f"block_{count}.py").write_text(block.text())
        return f"python3 -W error {folder}/block_{count}.py"
    if block.language == "yaml":
        text = block.text()
        if not re.search(r"^robots:", text, re.M):
            text += "robots:\n  - name: arm\n    urdf: robots/arm7.urdf\n"
        return (f"cat >config/block.yaml <<'END_OF_BLOCK'\n{text}END_OF_BLOCK\n"
                "totalforced --check config/block.yaml && rm config/block.yaml")
    if block.language == "json":
        parse_json(block.text())
        return ""
    if block.language == "text":
        for line in block.lines:
            if COMMANDS.match(line):
                raise ValueError(f"a command in a block of text: {line}")
        return ""
    raise ValueError(f"a block of language '{block.language}'"
                     + ("" if name else " without a file name in its first line"))


PROLOGUE = """set -eo pipefail
await() {
    echo $daemon >"$SCRATCH/daemon"
    turn=0
    until totalforce status >/dev/null 2>&1; do
        turn=$((turn + 1))
        [ $turn -le 600 ] && kill -0 $daemon || { echo "the daemon does not start" >&2; return 1; }
        sleep 0.1
    done
}
"""


def script_of(blocks, scratch):
    """The script of a page; mistakes; how many blocks run."""
    script, mistakes, ran = [PROLOGUE], [], 0
    for count, block in enumerate(blocks):
        if block.reason:
            print(f"  line {block.line}: not run: {block.reason}")
            continue
        try:
            commands = shell_of(block, scratch, count)
        except ValueError as mistake:
            mistakes.append((block.line, str(mistake)))
            continue
        script.append(f'line={block.line}; echo "-- line $line" >&2\n{commands}')
        ran += block.language != "run"
    script.append('echo "done" >"$SCRATCH/done"')
    return "\n".join(script), mistakes, ran


def make_folder(options, scratch):
    """The folder in which a page is read."""
    folder = scratch / "page"
    folder.mkdir()
    source = options.source
    for name in ("config", "idl"):
        shutil.copytree(source / name, folder / name)
    shutil.copytree(source / "docs", folder / "docs")
    if options.from_source:
        (folder / "build").mkdir()
        (folder / "build" / "release").symlink_to(options.build)
    # DDS keeps to ports of its own: other daemons of domain 0 on this machine are not met. Those of
    # each test domain are others, and below those of the test domains themselves.
    local = folder / "config/dds/local.xml"
    base = 8000 + (int(os.environ["TEST_DOMAIN"]) - 75) * 250
    local.write_text(local.read_text().replace(
        "<Discovery>", f"<Discovery><Ports><Base>{base}</Base></Ports>"))
    return folder


def make_environment(options, scratch, folder):
    """A newcomer's environment: nothing of the caller's but PATH."""
    for name in ("home", "run", "bin"):
        (scratch / name).mkdir()
    os.chmod(scratch / "run", 0o700)
    (scratch / "run/totalforce").mkdir(mode=0o700)
    compiler = scratch / "bin" / "cc"
    # code that idlc wrote is not ours to judge
    compiler.write_text('#!/bin/sh\ncase "$*" in *totalforce.c*) warn=-w ;; '
                        '*) warn="-Wall -Wextra -Werror" ;; esac\n'
                        f'exec "{options.compiler}" -std=gnu17 $warn "$@"\n')
    compiler.chmod(0o755)
    environment = {
        "HOME": str(scratch / "home"), "SCRATCH": str(scratch), "LANG": "C.UTF-8",
        "TMPDIR": str(scratch), "XDG_RUNTIME_DIR": str(scratch / "run"),
        "TOTALFORCE_RUNTIME_DIR": str(scratch / "run/totalforce"),
        "ROBOT_TAG": f"page-{os.getpid()}",
        "PATH": f"{scratch}/bin:/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin",
    }
    if not options.from_source:
        prefix = options.prefix
        environment |= {
            "PATH": f"{scratch}/bin:{prefix}/bin:{prefix}/sbin:" + environment["PATH"],
            "CMAKE_PREFIX_PATH": str(prefix), "PREFIX": str(prefix),
            "CYCLONEDDS_URI": f"file://{folder}/config/dds/local.xml",
        }
        for name, found in (("LD_LIBRARY_PATH", "libtotalforce.so"),
                            ("PKG_CONFIG_PATH", "totalforce.pc"), ("PYTHONPATH", "totalforce/__init__.py")):
            for path in prefix.rglob(found):
                environment[name] = str(path.parents[found.count("/")])
    return environment


def run(script, folder, environment, scratch):
    """Exit status of the script; ends what it left behind."""
    (scratch / "script").write_text(script)
    with open(scratch / "out", "wb") as out:
        session = guard.start(["bash", str(scratch / "script")], cwd=folder, env=environment,
                              stdin=subprocess.DEVNULL, stdout=out, stderr=subprocess.STDOUT)
        try:
            status = session.wait(timeout=TIMEOUT_S)
        except subprocess.TimeoutExpired:
            status = "no end"
    left = not ends(session.pid) if status == 0 else False
    guard.end(session, signal.SIGKILL)
    return "a process is left running" if left else status


def ends(group):
    """What the script has told to end may take its time."""
    end = time.monotonic() + WAIT
    while time.monotonic() < end:
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.02)
    return False


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("page", type=pathlib.Path)
    parser.add_argument("prefix", type=pathlib.Path)
    parser.add_argument("source", type=pathlib.Path)
    parser.add_argument("--from-source", action="store_true")
    parser.add_argument("--build", type=pathlib.Path)
    parser.add_argument("--then", type=pathlib.Path, action="append", default=[])
    parser.add_argument("--compiler", default="/usr/bin/cc")
    parser.add_argument("--say", action="append", default=[],
                        help="regular expression that a line of the output has to match")
    options = parser.parse_args()
    options.prefix, options.source = options.prefix.resolve(), options.source.resolve()
    name = options.page.name
    blocks, mistakes = parse(options.page.read_text())
    for page in options.then:
        for known, found in zip((blocks, mistakes), parse(page.read_text())):
            known.extend(found)
    scratch = pathlib.Path(tempfile.mkdtemp(prefix="tfa-page-"))
    try:
        script, more, ran = script_of(blocks, scratch)
        for line, mistake in mistakes + more:
            print(f"{name}:{line}: {mistake}")
        if mistakes or more:
            return 1
        if not ran:
            print(f"{name}: no block to run")
            return 0
        folder = make_folder(options, scratch)
        status = run(script, folder, make_environment(options, scratch, folder), scratch)
        output = (scratch / "out").read_text(errors="replace")
        missing = [x for x in options.say if not re.search(x, output, re.M)]
        if status != 0 or not (scratch / "done").exists() or missing:
            print(output)
            print(f"{name}: failed: {status}", *(f"no line '{x}'" for x in missing))
            return 1
        print(f"{name}: {ran} blocks ran")
        return 0
    finally:
        shutil.rmtree(scratch, ignore_errors=True)


if __name__ == "__main__":
    sys.exit(main())
