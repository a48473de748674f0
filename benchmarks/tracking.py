"""Error against unknowns with and without tracked breaking points, for soft and hard impact: ``make tracking``."""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from pddecont.delay.direct import Direct
from pddecont.model.builder import load_model, parse_model
from pddecont.model.codegen import NumericModel
from pddecont.model.document import parse_document
from pddecont.orbit.curve import settle
from pddecont.orbit.guess import orbit_from_cycle
from pddecont.orbit.mesh import Mesh, Places
from pddecont.orbit.meshing import MeshRule, on_mesh, remeshed, transfer
from pddecont.orbit.problem import OrbitProblem, read
from pddecont.simulate.integrate import simulate
from pddecont.simulate.recognise import recognise

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


def fine_orbit(numeric: NumericModel, t_end: float) -> tuple[OrbitProblem, np.ndarray]:
    """Return the orbit that a model settles to, on a mesh of degree 10 to a tolerance of 1e-12."""
    p = numeric.parameter_values
    rule = MeshRule(10, tol=1e-12)
    cycle = recognise(numeric, p, simulate(numeric, p, Direct(), t_end))
    problem, solution = settle(*orbit_from_cycle(numeric, p, Direct(), cycle, rule), rule)
    return problem, solution.x


def soft() -> tuple[OrbitProblem, np.ndarray]:
    """Return the impact oscillator's orbit."""
    return fine_orbit(NumericModel(load_model(str(ROOT / "models" / "impact_oscillator.yaml"))[0]), 50 * 2 * math.pi / 0.8)


def hard() -> tuple[OrbitProblem, np.ndarray]:
    """Return the orbit of an oscillator that bounces off a wall, with delayed feedback."""
    return fine_orbit(NumericModel(parse_model(parse_document(HARD, "hard"))[0]), 60 * math.pi)


def errors_on_refinement(fine: tuple[OrbitProblem, np.ndarray], degree: int, track: bool, counts: tuple[int, ...]):
    """Return (unknowns, largest error at any time) on meshes whose pieces are cut into each of ``counts`` equal intervals."""
    problem, x = fine
    theta, found = problem.theta(x), []
    values = problem.layout.split(x)[0]
    for count in counts:
        other = replace(problem, delay=Direct(track))
        pieces = remeshed(other, x, MeshRule(degree, intervals=1))[0].mesh.pieces
        cut = tuple(replace(p, cuts=np.linspace(0, 1, count + 1)) for p in pieces)
        coarse, guess = on_mesh(other, x, Mesh(degree, problem.mesh.n_segments, cut, theta))
        coarse, solution = settle(coarse, guess, MeshRule(degree, intervals=count))
        mesh = coarse.mesh
        places = Places(np.repeat(np.arange(mesh.n_intervals), 7), np.tile(np.linspace(0.07, 0.93, 7), mesh.n_intervals))
        reads = read(coarse, solution.x, places, delays=False)
        # The fine orbit at the same fractions of its segments.
        dense = Mesh(12, mesh.n_segments, mesh.pieces, mesh.anchor)
        exact = dense.at(transfer(problem.mesh, theta, values, dense, reads.theta), places)
        found.append((len(solution.x), float(np.max(np.abs(reads.x.T - exact)))))
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
                axes.loglog(unknowns, errors, "o-" if track else "s:", color=f"C{degree // 2 - 2}", ms=4,
                            label=f"degree {degree}{'' if track else ', not tracked'}")  # fmt: skip
        axes.set_title(f"{name} impact", fontsize=10)
        axes.set_xlabel("unknowns")
        axes.grid(alpha=0.3)
    panels[0].set_ylabel("largest error at any time")
    panels[1].legend(fontsize=7.5, frameon=False)
    folder.mkdir(exist_ok=True)
    figure.savefig(folder / "tracking.png", dpi=130)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "out"))
