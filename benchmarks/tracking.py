"""Error against unknowns with and without tracked breaking points, for soft and hard impact: ``make tracking``."""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from pddecont.codegen import NumericModel
from pddecont.collocation import Mesh, MeshPoints, MeshRule, transfer
from pddecont.delay import Direct
from pddecont.model import load_model, parse_document, parse_model
from pddecont.orbit import Orbit, adapt_mesh, guess_from_cycle, solve_orbit, transfer_orbit
from pddecont.simulate import detect_period, simulate

ROOT = Path(__file__).parent.parent
HARD = """\
name: hard_wall_with_delay
states: [x, v]
parameters: {omega: 2, c: 0.1, wall: 0.2, r: 0.8, K: 0.2, tau: 0.7}
forcing: {period: 2*pi/omega}
modes: {free: {x': v, v': cos(omega*t) - c*v - x + K*(v(t - tau) - v)}}
events: {hit: x - wall}
resets: {bounce: {v: -r*v}}
segments: {flight: {mode: free, event: hit, direction: rising, reset: bounce, to: free}}
"""


def fine_orbit(numeric: NumericModel, t_end: float) -> Orbit:
    """Return the orbit that a model settles to, on a mesh of degree 10 to a tolerance of 1e-12."""
    p = numeric.parameter_values
    rule = MeshRule(10, tol=1e-12)
    cycle = detect_period(numeric, p, simulate(numeric, p, Direct(), t_end))
    return solve_orbit(guess_from_cycle(numeric, p, Direct(), cycle, rule), rule).at.orbit


def soft() -> Orbit:
    """Return the impact oscillator's orbit."""
    return fine_orbit(
        NumericModel(load_model(str(ROOT / "models" / "impact_oscillator.yaml"))[0]), 50 * 2 * math.pi / 0.8
    )


def hard() -> Orbit:
    """Return the orbit of an oscillator that bounces off a wall, with delayed feedback."""
    return fine_orbit(NumericModel(parse_model(parse_document(HARD, "hard"))[0]), 60 * math.pi)


def errors_on_refinement(fine: Orbit, degree: int, track: bool, counts: tuple[int, ...]) -> list[tuple[int, float]]:
    """Return (unknowns, largest error at any time) on meshes whose pieces are cut into each of ``counts`` equal
    intervals.
    """
    found, other = [], Orbit(replace(fine.problem, delay=Direct(track)), fine.x)
    for count in counts:
        pieces = adapt_mesh(other, MeshRule(degree, intervals=1)).mesh.pieces
        cut = tuple(replace(p, cuts=np.linspace(0, 1, count + 1)) for p in pieces)
        guess = transfer_orbit(other, Mesh(degree, fine.mesh.n_segments, cut, fine.theta))
        coarse = solve_orbit(guess, MeshRule(degree, intervals=count)).at.orbit
        mesh, inside = coarse.mesh, np.linspace(0.07, 0.93, 7)
        points = MeshPoints(np.repeat(np.arange(mesh.n_intervals), 7), np.tile(inside, mesh.n_intervals))
        reads = coarse.read(points, delays=False)
        # The fine orbit at the same fractions of its segments.
        dense = Mesh(12, mesh.n_segments, mesh.pieces, mesh.reference_theta)
        values = transfer(fine.mesh, fine.theta, fine.values, dense, coarse.theta)
        found.append((len(coarse.x), float(np.max(np.abs(reads.x.T - dense.interpolate(values, points))))))
    return found


def main(folder: Path) -> None:
    """Print the table and draw it."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, panels = plt.subplots(1, 2, figsize=(10, 4.2), constrained_layout=True, sharey=True)
    print("| impact | degree | tracked | unknowns: error | order |\n|---|---|---|---|---|")
    for axes, (name, fine) in zip(panels, (("soft", soft()), ("hard", hard())), strict=True):
        for degree in (4, 6, 8, 10):
            for track in (True, False):
                found = errors_on_refinement(fine, degree, track, (1, 2, 4) if track else (8, 16, 32, 64))
                # The order over the refinements whose error is above rounding.
                clear = [e for _, e in found if e > 2e-13]
                order = math.log2(clear[0] / clear[-1]) / (len(clear) - 1) if len(clear) > 1 else math.nan
                cells = "; ".join(f"{n}: {e:.1e}" for n, e in found)
                print(f"| {name} | {degree} | {'yes' if track else 'no'} | {cells} | {order:.1f} |", flush=True)
                unknowns, errors = zip(*found, strict=True)
                axes.loglog(
                    unknowns,
                    errors,
                    "o-" if track else "s:",
                    color=f"C{degree // 2 - 2}",
                    ms=4,
                    label=f"degree {degree}{'' if track else ', not tracked'}",
                )
        axes.set_title(f"{name} impact", fontsize=10)
        axes.set_xlabel("unknowns")
        axes.grid(alpha=0.3)
    panels[0].set_ylabel("largest error at any time")
    panels[1].legend(fontsize=7.5, frameon=False)
    folder.mkdir(exist_ok=True)
    figure.savefig(folder / "tracking.png", dpi=130)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "out"))
