"""Recorded error estimates against true errors, of all orbits of all branches of runs: part of ``make bench``.

Takes run files, by default those of the models and the paper's figures. The true error of a recorded orbit is its
distance to the nearest exact one, which Newton's method finds from it with polynomials of four degrees more and a
tolerance of a thousandth of the estimate; the free parameters may move. Estimates below 3e-13 are rounding, and left
out. Where branches cross exact orbits are not isolated, and Newton's method may lead out of where the equations hold:
such orbits are counted by themselves.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np

from benchmarks.continuation import ROOT
from pddecont.collocation import MeshRule
from pddecont.errors import ConvergenceError
from pddecont.model import parse_document
from pddecont.orbit import adapt_mesh, measure_orbit, orbit_from_rows
from pddecont.orbit.estimate import solve_nearest
from pddecont.orbit.system import PeriodicOrbitSystem
from pddecont.results import read_results
from pddecont.steps import load_run_plan
from pddecont.steps.execution import execute

# What is left out takes minutes a run.
LEFT_OUT = ("oscillator_chain_50",)
FIGURES = ("fig4_2", "fig4_5", "fig4_6", "fig4_7")
MORE_DEGREES, MOST, FINER, LEAST = 4, 14, 1e-3, 3e-14
ROUNDING, WITHIN = 3e-13, 10.0
STEPS = 6


def list_files():
    """Return the run files that are tried where none is named."""
    models = [path for path in sorted((ROOT / "models").glob("*.yaml")) if path.stem not in LEFT_OUT]
    return models + [path for path in sorted((ROOT / "configs").glob("*.yaml")) if path.stem.startswith(FIGURES)]


def measure(path, folder):
    """Return the estimates over the true errors of the orbits of a run's branches."""
    plan = load_run_plan(parse_document(path.read_text(encoding="utf-8"), str(path)))
    execute(plan, folder / "a.h5", overwrite=True)
    results, ratios = read_results(folder / "a.h5"), []
    for step in plan.steps:
        recorded = results.step(step.name)
        if recorded.kind != "continue":
            continue
        points, widths = recorded.points, tuple(high - low for low, high in step.settings.ranges)
        for row in range(len(recorded)):
            estimate = float(points["error_estimate"][row])
            if not ROUNDING <= estimate < np.inf:
                continue
            orbit = orbit_from_rows(
                plan.numeric,
                step.delay,
                points["parameters"][row],
                step.settings.free,
                recorded.orbit(row),
                int(points["n_periods"][row]),
                float(points["phase"][row]),
            )
            ratios.append(estimate / find_true_error(orbit, widths, estimate))
    return np.array(ratios)


def find_true_error(orbit, widths, estimate):
    """Return the distance of an orbit to the nearest exact one, relative to its sizes; NaN where none is found."""
    rule = MeshRule(min(orbit.mesh.degree + MORE_DEGREES, MOST), None, max(FINER * estimate, LEAST))
    fine = adapt_mesh(orbit, rule)
    system, x = PeriodicOrbitSystem(fine.problem, measure_orbit(fine, widths)), fine.x
    for _ in range(STEPS):
        at = system.at(x)
        try:
            step = solve_nearest(at.jacobian(), -at.residual, system.scaling)
        except ConvergenceError:
            return np.nan
        x = x + step
        if np.max(np.abs(step) / system.scaling.scale) < FINER * estimate:
            break
    return max(float(np.max(np.abs(x - fine.x) / system.scaling.scale)), np.finfo(float).tiny)


def main(names):
    """Print how many estimates of each run are within a factor of ten of the true error."""
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for path in [Path(name) for name in names] or list_files():
            ratios = measure(path, Path(folder))
            if len(ratios):
                print(f"  {path.stem:30} {describe(ratios)}", flush=True)
                found.append(ratios)
    print(f"  {'all':30} {describe(np.concatenate(found))}")


def describe(ratios):
    """Return in words how estimates compare with true errors."""
    lost, ratios = int(np.sum(np.isnan(ratios))), ratios[~np.isnan(ratios)]
    if not len(ratios):
        return f"{lost:5} orbits, not found"
    low, high = int(np.sum(ratios <= 1.0 / WITHIN)), int(np.sum(ratios >= WITHIN))
    within = 1.0 - (low + high) / len(ratios)
    off = f"too small {low}, too large {high}; median {np.median(ratios):.3f}{f'; {lost} not found' if lost else ''}"
    return f"{len(ratios):5} orbits, {within:.2%} within; {off}"


if __name__ == "__main__":
    main(sys.argv[1:])
