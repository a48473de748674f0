"""What a point of a branch costs, where the time of a Newton step goes, and how both grow: part of ``make bench``."""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import gc
import resource
import subprocess
import sys
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import yaml
from sympy.core.cache import clear_cache

from benchmarks.timing import growth, timed
from models.diffusive_logistic import diffusive_logistic
from models.oscillator_chain import chain
from pddecont.codegen import ArrayFunction, NumericModel
from pddecont.collocation import MeshRule
from pddecont.continuation import NewtonSettings, correct_component, equilibrate
from pddecont.delay import Direct
from pddecont.model import parse_document, parse_model
from pddecont.orbit import (
    OrbitEvaluation,
    PeriodicOrbitSystem,
    SegmentSpan,
    adapt_mesh,
    guess_from_cycle,
    measure_orbit,
    resegment,
    solve_orbit,
)
from pddecont.results import read_results
from pddecont.simulate import Simulator, detect_period, simulate
from pddecont.steps import load_run_plan
from pddecont.steps.execution import execute

ROOT = Path(__file__).parent.parent
BRANCH = """
model: ../models/impact_oscillator.yaml
set: {{tau_d: 3.8}}
mesh: {{degree: {degree}, tol: {tol}}}
steps:
  - {{name: transient, simulate: {{t_end: 200*2*pi/omega}}}}
  - {{name: orbit, orbit: {{from: transient}}}}
  - {{name: plain, continue: {{from: orbit, free: [tau_d], range: {{tau_d: [3.2, 4.6]}}, {step}}}}}
  - {{name: stable, continue: {{from: orbit, free: [tau_d], range: {{tau_d: [3.2, 4.6]}}, stability: true, {step}}}}}
"""


def ran(text, folder, name):
    """Return the results of a run file's text, and the CPU seconds of each step."""
    path, seconds = Path(folder) / f"{name}.h5", {}
    plan = load_run_plan(parse_document(text, str(ROOT / "configs" / "bench.yaml")))
    for i, step in enumerate(plan.steps):
        start = time.process_time()
        execute(plan, path, until=step.name, resume=i > 0, overwrite=i == 0)
        seconds[step.name] = time.process_time() - start
    return read_results(path), seconds


def points(folder):
    """Print what points cost with and without stability, and how good the grazing is."""
    step = "step: {max: 0.1}"
    fine = ran(BRANCH.format(degree=10, tol=1e-11, step=step), folder, "fine")[0].step("stable")
    best = {}
    for _ in range(3):
        results, seconds = ran(BRANCH.format(degree=8, tol=1e-9, step=step), folder, "branch")
        for name in ("plain", "stable"):
            best[name] = min(best.get(name, np.inf), seconds[name])
    print("A branch of the impact oscillator, delay equation, tau_d from 3.2 to 4.6, degree 8, tolerance 1e-9")
    for name in ("plain", "stable"):
        recorded = results.step(name)
        grazing, exact = (s.points["parameters"][s.row("GR1"), -1] for s in (recorded, fine))
        what = "with multipliers" if name == "stable" else "without"
        print(
            f"  {what:18} {len(recorded):4} points, {1e3 * best[name] / len(recorded):6.1f} ms of CPU time a point, "
            f"grazing off by {abs(grazing - exact):.1e}"
        )
    print(f"  ratio {best['stable'] / best['plain']:.2f}\n")


@contextmanager
def clock(owner, name, spent):
    """Add up the time that calls of a function take in ``spent[0]``."""
    original = getattr(owner, name)

    def wrapped(*args, **kwargs):
        start = time.perf_counter()
        try:
            return original(*args, **kwargs)
        finally:
            spent[0] += time.perf_counter() - start

    setattr(owner, name, wrapped)
    try:
        yield
    finally:
        setattr(owner, name, original)


def orbit_of(text, rule, periods=60):
    """Return the orbit that a model's motion settles to."""
    numeric = NumericModel(parse_model(parse_document(text, "m.yaml"))[0])
    p = numeric.parameter_values
    period = float(numeric.period.value(p)[0])
    cycle = detect_period(numeric, p, simulate(numeric, p, Direct(), periods * period))
    return solve_orbit(guess_from_cycle(numeric, p, Direct(), cycle, rule), rule).at.orbit


def impact(rule):
    """Return the impact oscillator's orbit."""
    return orbit_of((ROOT / "models" / "impact_oscillator.yaml").read_text(), rule)


def solver(orbit, free):
    """Return a function that takes one Newton step at the orbit."""
    orbit = orbit.with_free((free,))
    system, last = PeriodicOrbitSystem(orbit.problem, measure_orbit(orbit, (1.0,))), len(orbit.x) - 1
    settings = NewtonSettings(step_tol=np.inf, residual_tol=np.inf, max_iterations=1)
    return lambda: correct_component(system, orbit.x.copy(), last, orbit.x[last], settings)


def split(meshes=(20, 80, 320, 1280)):
    """Print where the time of a Newton step goes, on meshes of so many intervals."""
    print("Newton step of the impact oscillator, delay equation, parts of its time (%)")
    print(f"{'unknowns':>10} {'generated code':>15} {'assembly':>10} {'factorisation':>14} {'rest':>8} {'ms':>8}")
    orbit, matrix = impact(MeshRule(6, intervals=20)), type(equilibrate(np.eye(1)))
    for intervals in meshes:
        other = adapt_mesh(orbit, MeshRule(6, intervals=intervals))
        step = solver(other, "tau_d")
        spent = {name: [0.0] for name in ("value", "derivatives", "jacobian", "residual", "factor")}
        step()
        n = 20
        with (
            clock(ArrayFunction, "value", spent["value"]),
            clock(ArrayFunction, "derivatives", spent["derivatives"]),
            clock(OrbitEvaluation, "jacobian", spent["jacobian"]),
            clock(vars(OrbitEvaluation)["residual"], "func", spent["residual"]),
            clock(matrix, "factor", spent["factor"]),
        ):
            start = time.perf_counter()
            for _ in range(n):
                step()
            total = time.perf_counter() - start
        code = spent["value"][0] + spent["derivatives"][0]
        assembly = spent["jacobian"][0] + spent["residual"][0] - code
        factor = spent["factor"][0]
        parts = [100 * t / total for t in (code, assembly, factor, total - code - assembly - factor)]
        print(
            f"{len(other.x):10} {parts[0]:15.0f} {parts[1]:10.0f} {parts[2]:14.0f} {parts[3]:8.0f} "
            f"{1e3 * total / n:8.2f}"
        )
    print()


def table(title, steps, sizes):
    """Print the time of Newton steps and the exponent that they grow with."""
    times = timed(steps, 7)
    order = growth([sizes[k] for k in steps], [times[k] for k in steps])
    print(f"  {title:38} {', '.join(f'{k}: {1e3 * t:.2f}' for k, t in times.items())} ms; exponent {order:.2f}")


def take_often(orbit, k, rule):
    """Return an orbit taken ``k`` times as one orbit of k times as many segments."""
    ends = np.concatenate([[0.0], np.cumsum(np.tile(orbit.durations, k))])
    spans = [SegmentSpan(s, *ends[i : i + 2]) for i, s in enumerate(orbit.problem.segments * k)]
    return resegment(orbit, spans, rule, orbit.problem.n_periods * k)


def delays(k):
    """Return an impacting oscillator with ``k`` delays."""
    terms = " + ".join(f"{0.3 / k}*v(t - {0.4 + 0.37 * i})" for i in range(k))
    return f"""name: m
states: [x, v]
parameters: {{a: 1, K: 0.4}}
forcing: {{period: 2*pi/1.3}}
modes: {{m: {{x': v, v': cos(1.3*t)*a - x - 0.1*v - K*({terms})}}}}
events: {{hit: x - 0.9}}
resets: {{bounce: {{v: -0.7*v}}}}
segments: {{s: {{mode: m, event: hit, direction: rising, reset: bounce, to: m}}}}
"""


def sizes():
    """Print how a Newton step grows with everything that makes a problem large."""
    print("Newton steps (ms) and the exponent of their growth")
    orbit = impact(MeshRule(6, intervals=20))
    meshes = [adapt_mesh(orbit, MeshRule(6, intervals=n)) for n in (20, 80, 320, 1280)]
    steps = {len(other.x): solver(other, "tau_d") for other in meshes}
    table("unknowns", steps, {n: n for n in steps})
    often = [take_often(orbit, k, MeshRule(6, intervals=20 * k)) for k in (1, 2, 4, 8)]
    steps = {len(other.signature): solver(other, "tau_d") for other in often}
    table("segments (unknowns in proportion)", steps, {n: n for n in steps})
    chains = {2 * n: orbit_of(chain(n), MeshRule(6, intervals=40)) for n in (2, 5, 10, 25, 50)}
    table("states (chain of oscillators)", {n: solver(o, "K") for n, o in chains.items()}, {n: n for n in chains})
    many = {k: orbit_of(delays(k), MeshRule(6, intervals=160)) for k in (1, 2, 4, 8)}
    table("delays (160 intervals)", {k: solver(o, "K") for k, o in many.items()}, {k: k for k in many})
    print()


def long_branches(folder):
    """Print how the cost of a point and the memory change along a branch."""
    print("A branch of many points (impact oscillator, degree 6, 10 intervals)")
    for n in (250, 500, 1000, 2000):
        text = BRANCH.format(
            degree=6, tol=1e-6, step=f"step: {{initial: {0.5 / n}, max: {0.5 / n}}}, max_points: {n}, direction: up"
        )
        text = "\n".join(line for line in text.splitlines() if "name: stable" not in line)
        results, seconds = ran(text, folder, f"long{n}")
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        recorded = len(results.step("plain"))
        print(
            f"  {recorded:5} points: {1e3 * seconds['plain'] / recorded:6.2f} ms of CPU time a point, at most "
            f"{memory:.0f} MiB so far"
        )
    print()


def large_systems(folder):
    """Print what a point with multipliers costs where states are many."""
    print("Points of a chain of oscillators, with multipliers (degree 6, tolerance 1e-6)")
    costs = {}
    for n in (5, 10, 25, 50, 100):
        steps = [
            {"name": "t", "simulate": {"t_end": "60*2*pi/omega"}},
            {"name": "o", "orbit": {"from": "t"}},
            {"name": "b", "continue": {"from": "o", "free": ["K"], "range": {"K": [0.1, 0.12]}, "stability": True}},
        ]
        text = chain(n).split("\nrun:")[0] + "\n" + yaml.safe_dump({"run": {"mesh": {"tol": 1e-6}, "steps": steps}})
        results, seconds = ran(text, folder, f"chain{n}")
        recorded = results.step("b")
        costs[2 * n] = seconds["b"] / len(recorded)
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        unknowns = int(recorded.points["n_unknowns"][0])
        print(f"  {2 * n:4} states, {unknowns:6} unknowns: {costs[2 * n]:7.3f} s of CPU time, {memory:.0f} MiB so far")
    print(f"  exponent {growth(list(costs), list(costs.values())):.2f}\n")


def diffusion(folder):
    """Print what whole runs of a delayed reaction with diffusion cost, each in a process of its own."""
    print("Delayed logistic growth with diffusion: a transient, its orbit, three points with multipliers; whole runs")
    costs = {}
    steps = [
        {"name": "t", "simulate": {"t_end": 120}},
        {"name": "o", "orbit": {"from": "t", "stability": True}},
        {"name": "b", "continue": {"from": "o", "free": ["r"], "range": {"r": [1.7, 2.2]}, "stability": True}},
    ]
    steps[-1]["continue"] |= {"max_points": 3, "direction": "up"}
    for n in (50, 100, 200):
        path = Path(folder) / f"diffusion{n}.yaml"
        text = diffusive_logistic(n) + yaml.safe_dump({"run": {"mesh": {"tol": 1e-6}, "steps": steps}})
        path.write_text(text, encoding="utf-8")
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        command = [sys.executable, "-m", "pddecont", "run", str(path), "-o", str(path.with_suffix(".h5"))]
        subprocess.run(command, capture_output=True, check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        costs[n] = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        recorded = read_results(path.with_suffix(".h5")).step("b").points
        # The largest of all children so far, of which this one is the largest.
        print(
            f"  {n:4} states, {int(recorded['n_unknowns'][0]):6} unknowns: {costs[n]:7.2f} s of CPU time, "
            f"{after.ru_maxrss / 1024:.0f} MiB"
        )
    print(f"  exponent {growth(list(costs), list(costs.values())):.2f}\n")


def model_code(repeats=3):
    """Print what the code of large models costs, from their text to compiled functions."""
    print("Code of a chain of oscillators, seconds of CPU time, the least of several turns")
    print(f"{'states':>10} {'parsing':>9} {'derivatives':>12} {'NumPy code':>11} {'machine code':>13} {'all':>7}")
    for n in (10, 50, 100):
        costs = np.min([time_code(chain(n).split("\nrun:")[0] + "\n") for _ in range(repeats)], axis=0)
        parsing, slopes, arrays, machine = costs
        print(f"{2 * n:10} {parsing:9.2f} {slopes:12.2f} {arrays:11.2f} {machine:13.2f} {costs.sum():7.2f}")
    print()


def time_code(text):
    """Return the seconds of parsing, of derivatives, and of code over arrays and for machines that a model takes."""
    # What sympy remembers of the turn before, and its machine code.
    clear_cache()
    gc.collect()
    times = [time.process_time()]
    numeric = NumericModel(parse_model(parse_document(text, "m.yaml"))[0])
    times.append(time.process_time())
    function, free = numeric.mode("free"), (numeric.parameter_index("K"),)
    function.structure(free)
    times.append(time.process_time())
    x, xd = np.zeros((numeric.n_states, 1)), np.zeros((len(numeric.model.read_symbols), 1))
    function.value(np.zeros(1), x, xd, numeric.parameter_values)
    function.derivatives(np.zeros(1), x, xd, numeric.parameter_values, free)
    times.append(time.process_time())
    _ = Simulator(numeric, Direct()).system
    return np.diff([*times, time.process_time()])


TWO_BRANCHES = """
model: ../models/impact_oscillator.yaml
set: {tau_d: 3.8}
mesh: {degree: 8, tol: 1e-9}
steps:
  - {name: transient, simulate: {t_end: 200*2*pi/omega}}
  - {name: orbit, orbit: {from: transient}}
  - {name: delays, continue: {from: orbit, free: [tau_d], range: {tau_d: [3.2, 4.6]}, stability: true, step: STEP}}
  - {name: forcings, continue: {from: orbit, free: [omega], range: {omega: [0.8, 0.9]}, stability: true, step: STEP}}
"""


def workers(folder):
    """Print what a run of two branches, and of one branch in two directions, takes on one and two workers."""
    print(
        f"On one and two workers ({os.cpu_count()} cores, whatever else runs on them): s by the clock, and of CPU time"
    )
    text = TWO_BRANCHES.replace("STEP", "{initial: 0.01, max: 0.01}")
    plan = load_run_plan(parse_document(text, str(ROOT / "configs" / "bench.yaml")))
    for what, until in (("two branches from one orbit", "forcings"), ("one branch in two directions", "delays")):
        best = {}
        for number in (1, 2, 1, 2, 1, 2):
            start, cpu, others = time.perf_counter(), time.process_time(), resource.getrusage(resource.RUSAGE_CHILDREN)
            execute(plan, Path(folder) / f"workers{number}.h5", overwrite=True, until=until, workers=number)
            took = time.perf_counter() - start, time.process_time() - cpu
            ended = resource.getrusage(resource.RUSAGE_CHILDREN)
            took += (ended.ru_utime + ended.ru_stime - others.ru_utime - others.ru_stime,)
            best[number] = min(best.get(number, took), took)
        same = (Path(folder) / "workers1.h5").read_bytes() == (Path(folder) / "workers2.h5").read_bytes()
        print(
            f"  {what:30} {best[1][0]:5.2f}, {best[2][0]:5.2f}: ratio {best[1][0] / best[2][0]:.2f}; CPU "
            f"{best[1][1]:.2f}, {best[2][1]:.2f} here and {best[2][2]:.2f} elsewhere; "
            f"{'the same' if same else 'NOT the same'} file"
        )
    print()


def start_up():
    """Print how long commands take to start, against Python alone."""
    program = [sys.executable, "-m", "pddecont"]
    model = str(ROOT / "models" / "impact_oscillator.yaml")
    commands = {
        "python": [sys.executable, "-c", "pass"],
        "--help": [*program, "--help"],
        "check": [*program, "check", model],
        "info": [*program, "info", model],
    }
    times = timed(
        {
            name: lambda c=command: subprocess.run(c, capture_output=True, check=True)
            for name, command in commands.items()
        },
        5,
    )
    print(
        "Start-up: "
        + ", ".join(
            f"{name} {1e3 * t:.0f} ms ({t / times['python']:.0f} times Python's own)" for name, t in times.items()
        )
    )


def main():
    """Print all tables."""
    with tempfile.TemporaryDirectory() as folder:
        points(folder)
        split()
        sizes()
        long_branches(folder)
        diffusion(folder)
        large_systems(folder)
        workers(folder)
    model_code()
    start_up()


if __name__ == "__main__":
    main()
