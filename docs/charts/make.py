#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Measures everything that docs/accuracy.md shows and the answers of docs/which-method.md, counts
the operations of docs/methods.md, draws the pictures and writes the tables: the lines between
`<!-- made: NAME -->` and `<!-- end -->`.

    cmake --preset peers && cmake --build --preset peers     # release with MuJoCo and Orocos KDL
    docs/charts/make.py build/peers              # some 13 minutes; nothing else should run

    docs/charts/make.py BUILD --quick FOLDER     # a few small cells; pages and pictures in FOLDER

CSV files, and the tables that the pages do not show (blocks/), stay in BUILD/charts.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import time
from types import SimpleNamespace

SOURCE = pathlib.Path(__file__).resolve().parents[2]
PAGES = ("accuracy.md", "which-method.md", "methods.md")
FULL = SimpleNamespace(
    sizes="8,32,128,1024,4096", one=128, map_bodies=64, budget=10, chains="", maps="", points=13,
    robots=("arm7", "quadruped", "humanoid"), cores="8,32,128,512,1024,2048,4096", single="32,128",
    strategies="single,batch,specialised,specialised-batch", inertia=128, seconds=10, half=5,
    samples=100, published="8,64,256,1024", fronts="--bodies 64,1000 --threads 1,2 --methods "
    "aba,crba,scan,tfa,tfa-cr,cfa,cfa-cr,dca,hessenberg,hybrid")
QUICK = SimpleNamespace(
    sizes="4,48", one=48, map_bodies=48, budget=1, points=3, robots=("arm7",), cores="8,32",
    chains="--mechanisms random,heavy-tip,alternating,rank-deficient,side-branches,thin,taper "
           "--seeds 2", maps="--bodies 4,48 --states 1 --seeds 2", single="8",
    strategies="single,batch", inertia=8, seconds=0.4, half=0.2, samples=10, published="8",
    fronts="--bodies 4 --threads 1 --methods aba,tfa")
PLAN = """\
hero|{chart} {hero} --methods auto{peers} --rhs qdd --refine 0 --threads 1,2 \
--strategies {strategies} --precision f64,f32 --kernels {kernels}
lambda|{chart} {hero} --mechanisms random --bodies {inertia} --op operational_inertia --methods \
auto,crba,tfa,tfa-one-sided,propagation,tfa-cr,hessenberg,cfa,cfa-cr,dca,scan,efpa,pv-osimr\
{mujoco} --refine 0 --strategies {strategies} --kernels {kernels}
cores|{chart} --mechanisms random --bodies {cores} --methods auto --rhs qdd --refine 0 \
--threads 1,2 --strategies single,batch
single|{chart} {arm} {humanoid} --mechanisms random --bodies {single} --methods aba --rhs qdd \
--refine 0,1 --precision f64,f32,f32+f64 --strategies single,batch
front|{chart} {arm} {humanoid} --mechanisms random,thin {fronts} --rhs qdd --refine 0,1 \
--precision f64,f32,f32+f64 --strategies single
drift-arm|drift {arm} --precision f64,f32,f32+f64 --step 0.004,0.001 --seconds {seconds} \
--samples {samples}
drift-thin|drift --mechanism thin --methods aba,tfa,cfa,dca --precision f64,f32 --step 0.002 \
--seconds {half} --samples {samples}
mechanisms|{chart} --bodies {sizes} {chains}
published|{chart} --mechanisms coil,dill --bodies {published} --rhs qdd --turn 0.001 --methods \
aba,crba,scan,tfa,tfa-cr,cfa,dca --refine 0,1
robots|{chart} {arm} {quadruped} {humanoid} {snake64}
precision|{chart} --mechanisms random --bodies {one} --methods crba,aba,tfa,tfa-cr,cfa,dca,scan \
--refine 0,1,2 --precision f64,f32,f32+f64,f64+f128
atlas-qdd|atlas --rhs qdd --points {points} {maps}
atlas-tau|atlas --rhs tau --points {points} {maps}
atlas-gravity|atlas --rhs gravity --points {points} {maps}
"""


def plan(o, kernels, peers):
    """Names of the runs, and their command lines"""
    urdf = {name: f"--urdf config/robots/{name}.urdf" for name in (
        "arm7", "quadruped", "humanoid", "snake64")}
    text = PLAN.format(
        **vars(o), **urdf, chart=f"chart --budget-ms {o.budget}", arm=urdf["arm7"],
        hero=" ".join(urdf[name] for name in o.robots), kernels=kernels,
        peers="".join(f",{peer}" for peer in peers), mujoco=",mujoco" * ("mujoco" in peers))
    return [line.strip().split("|") for line in text.splitlines()]


def tool(build, line, out=subprocess.DEVNULL, allowed=(0,)):
    """Runs `totalforce LINE`, in SOURCE: the heads of files name those of robots from there."""
    status = subprocess.run([build / "bin/totalforce", *line.split()], stdout=out, cwd=SOURCE,
                            check=False).returncode
    if status not in allowed:
        sys.exit(f"make.py: status {status} of totalforce {line}")


def measure(build, work, o, peers):
    """Each run, into WORK/NAME, with its command line and time in the file `runs`"""
    kernels = work / "kernels"
    kernels.mkdir()
    for robot in o.robots if "specialised" in o.strategies else ():
        tool(build, f"specialise config/robots/{robot}.urdf -o {kernels}")
    with open(work / "runs", "w", encoding="utf-8") as runs:
        for name, line in plan(o, kernels, peers):
            print(f"{name}: totalforce {line}", file=sys.stderr, flush=True)
            begin = time.monotonic()
            (work / name).mkdir()
            with open(work / name / f"{line.split()[0]}.csv", "w", encoding="utf-8") as out:
                tool(build, line, out, (0, 1))  # 1: a promise about estimates is broken; it is told
            print(name, line, round(time.monotonic() - begin), sep="|", file=runs)


def count(build, work):
    """Operations, where the build counts them"""
    if (build / "bin/bench_count").exists():
        (work / "depth").mkdir()
        with open(work / "depth/depth.csv", "w", encoding="utf-8") as out:
            subprocess.run([build / "bin/bench_count", "--csv", "--largest", "4096"], stdout=out,
                           check=True)


def run_tests(build, work):
    for program in ("test_reference", "test_laws"):
        if (build / "bin" / program).exists():
            with open(work / f"{program}.txt", "w", encoding="utf-8") as out:
                subprocess.run([build / "bin" / program], stdout=out, stderr=out, check=False,
                               env=os.environ | {"TEST_LONG": "1"})


def fill(page, blocks):
    """Writes the blocks into the page; one without a file stays as it is."""
    def block(found):
        file = blocks / found[1]
        if file.exists():
            return f"<!-- made: {found[1]} -->\n{file.read_text()}<!-- end -->"
        print(f"not measured: {found[1]}", file=sys.stderr)
        return found[0]

    form = r"^<!-- made: (\S+) -->$.*?^<!-- end -->$"
    page.write_text(re.sub(form, block, page.read_text(), flags=re.M | re.S))


def main(arguments):
    quick = len(arguments) == 3 and arguments[1] == "--quick"
    if len(arguments) != 1 and not quick:
        print("usage: docs/charts/make.py BUILD [--quick FOLDER]", file=sys.stderr)
        return 3
    build, docs = pathlib.Path(arguments[0]).resolve(), SOURCE / "docs"
    work, options = build / "charts", FULL
    if not (build / "bin/totalforce-chart").exists():
        print(f"make.py: no {build}/bin/totalforce-chart: build it first", file=sys.stderr)
        return 2
    if quick:
        docs, options = pathlib.Path(arguments[2]).resolve(), QUICK
        work = docs / "work"
        docs.mkdir(parents=True, exist_ok=True)
        for page in PAGES:
            shutil.copy(SOURCE / "docs" / page, docs)
    shutil.rmtree(work, ignore_errors=True)
    for folder in (work / "blocks", docs / "pictures"):
        folder.mkdir(parents=True, exist_ok=True)
    sys.dont_write_bytecode = True  # beside the sources
    sys.path.append(str(build / "python"))
    import pictures
    import tables
    from totalforce_tools import chart_peers

    measure(build, work, options, [p for p in ("mujoco", "kdl") if p in chart_peers.TABLE])
    if not quick:
        count(build, work)
        run_tests(build, work)
    pictures.draw(work, docs / "pictures", options.map_bodies)
    tables.write(work, options.one)
    for page in PAGES:
        fill(docs / page, work / "blocks")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
