"""This version's branches against those of an earlier one, in turns: part of ``make bench``.

Takes the Python of the earlier version (``make bench`` installs one), how often each takes its turn, and with
``--large`` adds chains of 100 and 200 states. Prints the least CPU milliseconds a point, and how far special points
that both find are apart. A turn of the earlier version that takes longer than ``--limit`` seconds is ended: this
version's whole turn is set against the limit then.
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from benchmarks.continuation import BRANCH, ROOT, delays
from models.oscillator_chain import chain

# For scale: figures of others as they were taken with Octave on two cores.
OTHERS = "PWSDDE-cont, DDE-BIFTOOL and COCO took 400 to 6500 ms a point with multipliers (Octave, two cores)"
TIMES = Path(__file__).with_name("branch_times.py")
DELAYS = """run:
  mesh: {degree: 6, intervals: 160}
  steps:
    - {name: transient, simulate: {t_end: 60*2*pi/1.3}}
    - {name: orbit, orbit: {from: transient}}
    - name: branch
      continue: {from: orbit, free: [K], range: {K: [0.3, 0.5]}, max_points: 8, stability: true, direction: up}
"""
# Where the bilinear oscillator's run stands.
PAGE, BILINEAR = ROOT / "docs" / "howto" / "from_pwsdde_cont.md", r'```yaml title="bilinear.yaml"\n(.*?)```'
CHAIN = """run:
  mesh: {degree: 6, tol: 1.0e-6}
  steps:
    - {name: transient, simulate: {t_end: 60*2*pi/omega}}
    - {name: orbit, orbit: {from: transient}}
    - name: branch
      continue:
        {from: orbit, free: [K], range: {K: [0.0, 2.0]}, stability: MULTIPLIERS, max_points: POINTS, direction: up}
"""
# Numbers of oscillators, the case's name, whether multipliers are asked for, and the most points.
LARGE = (
    (50, "", "false", "500"),
    (50, ", 3 points", "false", "3"),
    (50, ", 3 points, multipliers", "true", "3"),
    (100, ", 3 points", "false", "3"),
    (100, ", 3 points, multipliers", "true", "3"),
)
SHIPPED = {
    "mackey_glass": "in_delay",
    "wall_oscillator": "in_wall",
    "gear_backlash": "in_frequency",
    "dry_friction": "in_frequency",
    "den_hartog": "in_friction",
}


def list_cases(*, large):
    """Return the cases: branches of models that are shipped, the impact oscillator's with its delay, and large ones."""
    run = BRANCH.format(degree=8, tol=1e-9, step="step: {max: 0.1}")
    cases = {
        "impact oscillator": make_case(run, "plain", ROOT / "configs" / "bench.yaml"),
        "impact oscillator, multipliers": make_case(run, "stable", ROOT / "configs" / "bench.yaml"),
    }
    cases["bilinear oscillator"] = make_case(find_run(PAGE, BILINEAR), "in_delay", "bilinear.yaml")
    for name, step in SHIPPED.items():
        path = ROOT / "models" / f"{name}.yaml"
        cases[name] = make_case(path.read_text(encoding="utf-8"), step, path)
    cases["eight delays"] = make_case(delays(8) + DELAYS, "branch", "delays.yaml")
    for n, name, multipliers, points in LARGE if large else ():
        text = chain(n).split("\nrun:")[0] + "\n" + CHAIN.replace("MULTIPLIERS", multipliers).replace("POINTS", points)
        cases[f"chain of {2 * n} states{name}"] = make_case(text, "branch", "chain.yaml")
    return cases


def find_run(page, pattern):
    """Return the run file that stands in a page."""
    return re.search(pattern, page.read_text(encoding="utf-8"), re.DOTALL)[1]


def make_case(text, step, source):
    """Return a case as ``branch_times`` takes it."""
    return {"text": text, "step": step, "source": str(source)}


def run(python, case, folder, limit=None):
    """Return what one version takes for a case, in a process of its own; None if it takes more than ``limit`` s."""
    path = Path(folder) / "case.json"
    path.write_text(json.dumps(case), encoding="utf-8")
    command, start = [python, str(TIMES), str(path)], time.perf_counter()
    try:
        done = subprocess.run(command, capture_output=True, text=True, cwd=folder, check=True, timeout=limit)
    except subprocess.TimeoutExpired:
        return None
    return {**json.loads(done.stdout), "whole": time.perf_counter() - start}


def compare(case, before, folder, turns, limit):
    """Return a line that says what both versions take for a case."""
    best, found = {}, {}
    for _ in range(turns):
        for version, python in (("now", sys.executable), ("before", before)):
            found[version] = run(python, case, folder, limit if version == "before" else None)
            if found[version] is None:
                whole = found["now"]["whole"]
                least = f"ratio over {limit / whole:.0f}: no end in {limit:.0f} s, now {whole:.0f} s"
                return f"{'-':>8} {best['now']:8.1f}  {least}"
            spent = 1e3 * found[version]["seconds"] / found[version]["points"]
            best[version] = min(best.get(version, spent), spent)
    one, other = (found[version]["special"] for version in ("before", "now"))
    apart = max((abs(one[label] - other[label]) for label in one.keys() & other.keys()), default=0.0)
    labels = "" if one.keys() == other.keys() else f"; labels {sorted(one)} and {sorted(other)}"
    ratio = best["before"] / best["now"]
    return f"{best['before']:8.1f} {best['now']:8.1f}  ratio {ratio:.2f}  {apart:.1e}{labels}"


def main():
    """Print the least time a point of each version, and their ratio."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("before")
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument("--large", action="store_true")
    parser.add_argument("--limit", type=float, default=600.0)
    options = parser.parse_args()
    print("CPU milliseconds a point, before and now, the least of the turns; how far special points are apart at most")
    print(f"  {OTHERS}")
    with tempfile.TemporaryDirectory() as folder:
        for name, case in list_cases(large=options.large).items():
            line = compare(case, str(Path(options.before).absolute()), folder, options.turns, options.limit)
            print(f"  {name:32} {line}", flush=True)


if __name__ == "__main__":
    main()
