"""The simulator against a loop over scipy's solve_ivp and against JiTCDDE, at equal error, and what its steps cost.

Run as ``python -m benchmarks.simulator``. All ratios are measured in one process.
"""

from __future__ import annotations

import os
import tempfile

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import contextlib
import heapq
import math
import shutil
import time
import warnings
from bisect import bisect_right
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.timing import timed
from pddecont.codegen import NumericModel
from pddecont.delay import Direct
from pddecont.model import leave_out_effects, load_model
from pddecont.native.integrator import N_REJECTED, N_STEPS
from pddecont.simulate import (
    BasinRow,
    InitialState,
    Method,
    MotionTask,
    ReturnSection,
    ReturnSettings,
    Simulator,
    classify_row,
    record_trajectory,
    simulate,
    survey_attractors,
)

ROOT = Path(__file__).parent.parent
# Where JiTCDDE compiles.
SCRATCH = tempfile.mkdtemp(prefix="pddecont-bench-")
REFERENCE, SECOND = 1e-13, 3e-13
# Absolute tolerances of all integrators beside their relative ones.
ATOL = 1e-2
PERIODS = 30
HEADER = f"  {'':32} {'rtol':>9} {'error':>9} {'ms':>10} {'ratio':>10}"
# Jumps that the loop over solve_ivp steps on: an event's, and its echoes up to so many delays later. Of 0 to 7 this is
# fastest at equal error, if not by much.
ECHOES = 3


def numeric_model(name: str, **parameters: float):
    """Return a model of models/ and its parameter values, some of them replaced."""
    numeric = NumericModel(load_model(str(ROOT / "models" / f"{name}.yaml"))[0])
    p = numeric.parameter_values.copy()
    for symbol, value in parameters.items():
        p[[s.name for s in numeric.model.parameter_symbols].index(symbol)] = value
    return numeric, p


def method(rtol: float, stiff: bool = False) -> Method:
    """Return the simulator's method at a relative tolerance."""
    return Method(rtol, ATOL * rtol, stiff)


def plain_run(simulator: Simulator, p, t_end: float) -> Callable[[], int]:
    """Return a function that integrates from 0 to ``t_end``, keeps nothing, and returns how many steps it tried."""
    values = simulator.values(p)

    def run():
        state, _ = simulator.advance(values, simulator.start(values), t_end)
        return int(state.count[N_STEPS] + state.count[N_REJECTED])

    run()
    return run


def kept_run(simulator: Simulator, p, t_end: float):
    """Return a function that integrates from 0 to ``t_end`` and returns the trajectory."""
    values = simulator.values(p)
    return lambda: record_trajectory(simulator, p, simulator.start(values), t_end)


def solve_ivp_run(values: dict[str, float], t_end: float, rtol: float, echoes: int = ECHOES):
    """Return a function that integrates the impact oscillator by steps of solve_ivp, from each stop to the next.

    Stops are events, their echoes, and a delay after the last stop, so that all that is read has been stored.
    """
    omega, zeta, e, beta, K, tau = (values[name] for name in ("omega", "zeta", "e", "beta", "K", "tau_d"))
    amplitude = values["a"] * omega**2
    sin = math.sin

    def run():
        starts: list[float] = []
        stored: list[Callable[[float], np.ndarray]] = []

        def free(t, y):
            x, v = y
            delayed = stored[bisect_right(starts, t - tau) - 1](t - tau)[1] if t > tau else 0.0
            return v, amplitude * sin(omega * t) + K * (delayed - v) - 2 * zeta * v - x

        def contact(t, y):
            x, v = y
            delayed = stored[bisect_right(starts, t - tau) - 1](t - tau)[1] if t > tau else 0.0
            return v, amplitude * sin(omega * t) + K * (delayed - v) - 2 * zeta * v - x - beta * (x - e)

        def impact(t, y):
            return y[0] - e

        impact.terminal = True
        t, y, field, impact.direction, step = 0.0, (0.0, 0.0), free, 1, None
        stops = [(tau, 1)]
        while t < t_end:
            while stops and stops[0][0] <= t + 1e-12:
                at, level = heapq.heappop(stops)
                if level < echoes:
                    heapq.heappush(stops, (at + tau, level + 1))
            stop = min(t_end, t + tau, stops[0][0] if stops else math.inf)
            solution = solve_ivp(
                field,
                (t, stop),
                y,
                method="DOP853",
                events=impact,
                dense_output=True,
                rtol=rtol,
                atol=ATOL * rtol,
                first_step=None if step is None else min(step, stop - t),
            )
            starts.extend(solution.sol.ts[:-1])
            stored.extend(solution.sol.interpolants)
            t, y = solution.t[-1], solution.y[:, -1]
            if len(solution.t) > 2:
                step = float(np.max(np.diff(solution.t)))
            if solution.status == 1:
                field, impact.direction = (contact, -1) if field is free else (free, 1)
                heapq.heappush(stops, (t + tau, 1))
        return lambda times: np.array([stored[max(bisect_right(starts, s) - 1, 0)](s) for s in times])

    return run


def jitcdde_runs(n: float, delay: float, t_end: float):
    """Return JiTCDDE's compilation time of Mackey-Glass and a function from a tolerance to a run of it; None if it is
    missing.
    """
    try:
        from jitcdde import jitcdde, t, y
    except ImportError:
        print("jitcdde is not installed: pip install jitcdde")
        return None
    field = [2 * y(0, t - delay) / (1 + y(0, t - delay) ** n) - y(0)]
    # The compilation reads the settings of a package that it finds in the working directory.
    with contextlib.chdir(SCRATCH):
        start = time.perf_counter()
        first = jitcdde(field, verbose=False)
        first.compile_C(modulename="jitcdde_mackey_glass")
        seconds = time.perf_counter() - start
        library = os.path.abspath(first.save_compiled(overwrite=True))

    def run(rtol: float, times: Sequence[float] = (t_end,)):
        dde = jitcdde(field, module_location=library, verbose=False)
        dde.constant_past([0.9])
        dde.set_integration_parameters(rtol=rtol, atol=ATOL * rtol)
        dde.step_on_discontinuities()
        with warnings.catch_warnings():
            # It says that samples lie closer than its steps; that is meant.
            warnings.simplefilter("ignore", UserWarning)
            return np.array([dde.integrate(s) for s in times])

    return seconds, run


def tolerance_for(error: float, errors: dict[float, float]) -> float:
    """Return the loosest tolerance from which on all tighter ones have at most this error."""
    chosen = min(errors)
    for rtol in sorted(errors):
        if errors[rtol] > error:
            break
        chosen = rtol
    return chosen


def distance(a, b) -> float:
    """Return the largest distance of two sets of states."""
    return float(np.max(np.abs(a - b)))


def decades(tightest: float, loosest: float) -> list[float]:
    """Return tolerances, four in each decade, between two given by their exponents."""
    return [float(x) for x in 10.0 ** np.arange(tightest, loosest + 0.1, 0.25)]


def compare(rows: dict[str, dict[str, object]], repeats: int) -> dict[str, float]:
    """Print tolerances, errors, median times and their ratios to the first; return the times."""
    names = list(rows)
    times = timed({name: rows[name]["run"] for name in names}, repeats)
    for name in names:
        row = rows[name]
        print(
            f"  {name:32} {row['rtol']:9.1e} {row['error']:9.1e} {1e3 * times[name]:10.2f} "
            f"{times[name] / times[names[0]]:10.1f}"
        )
    return times


def against_solve_ivp(targets=(1e-5, 1e-7, 1e-9), repeats=9) -> None:
    """Print times of the impact oscillator against a loop over solve_ivp."""
    numeric, p = numeric_model("impact_oscillator")
    values = {s.name: float(x) for s, x in zip(numeric.model.parameter_symbols, p, strict=True)}
    period = 2 * math.pi / values["omega"]
    t_end = PERIODS * period
    times = np.linspace(t_end - 10 * period, t_end, 101)
    exact = simulate(numeric, p, Direct(), t_end, method(REFERENCE))(times)
    second = distance(exact, simulate(numeric, p, Direct(), t_end, method(SECOND))(times))
    other = distance(exact, solve_ivp_run(values, t_end, REFERENCE, 7)()(times))
    print(f"Impact oscillator, direct delay, {PERIODS} periods; errors are the largest over the last ten.")
    print(
        f"  reference: rtol {REFERENCE:.0e}, {second:.0e} from rtol {SECOND:.0e}, {other:.0e} from solve_ivp at rtol "
        f"{REFERENCE:.0e}"
    )
    ours = {
        rtol: distance(exact, simulate(numeric, p, Direct(), t_end, method(rtol))(times)) for rtol in decades(-12, -3)
    }
    theirs = {rtol: distance(exact, solve_ivp_run(values, t_end, rtol)()(times)) for rtol in decades(-11.5, -3)}
    print(HEADER)
    for target in targets:
        a, b = tolerance_for(target, ours), tolerance_for(target, theirs)
        simulator = Simulator(numeric, Direct(), method(a))
        compare(
            {
                "trajectory kept": {"run": kept_run(simulator, p, t_end), "rtol": a, "error": ours[a]},
                "solve_ivp, DOP853": {"run": solve_ivp_run(values, t_end, b), "rtol": b, "error": theirs[b]},
            },
            repeats,
        )
    print()


def against_jitcdde(n=5.5, delay=2.0, t_end=1000.0, targets=(1e-3, 1e-5, 1e-7), repeats=15) -> None:
    """Print times of Mackey-Glass on its cycle against JiTCDDE."""
    numeric, p = numeric_model("mackey_glass", n=n, tau=delay)
    start = time.perf_counter()
    simulate(numeric, p, Direct(), 0.1)
    seconds = time.perf_counter() - start
    found = jitcdde_runs(n, delay, t_end)
    if found is None:
        return
    compiling, run = found
    times = np.linspace(t_end - 10, t_end, 21)
    exact = simulate(numeric, p, Direct(), t_end, method(REFERENCE))(times)
    second = distance(exact, simulate(numeric, p, Direct(), t_end, method(SECOND))(times))
    print(
        f"Mackey-Glass, n = {n}, tau = {delay}, to t = {t_end}, on a cycle; errors are the largest over the last ten "
        f"units of time."
    )
    ours = {
        rtol: distance(exact, simulate(numeric, p, Direct(), t_end, method(rtol))(times)) for rtol in decades(-12, -2)
    }
    theirs = {rtol: distance(exact, run(rtol, times)) for rtol in decades(-10, -3)}
    tightest = min(theirs)
    print(
        f"  reference: rtol {REFERENCE:.0e}, {second:.0e} from rtol {SECOND:.0e}, "
        f"{theirs[tightest]:.0e} from JiTCDDE at rtol {tightest:.0e}"
    )
    print(f"  compilation: {seconds:.2f} s for the model's functions, {compiling:.2f} s for JiTCDDE's module")
    print(HEADER)
    for target in targets:
        a, b = tolerance_for(target, ours), tolerance_for(target, theirs)
        rows = {
            "nothing kept": {
                "run": plain_run(Simulator(numeric, Direct(), method(a)), p, t_end),
                "rtol": a,
                "error": ours[a],
            },
            "JiTCDDE": {"run": partial(run, b), "rtol": b, "error": theirs[b]},
        }
        medians = compare(rows, repeats)
        print(
            f"  {'':54} with compilation {(compiling + medians['JiTCDDE']) / (seconds + medians['nothing kept']):10.1f}"
        )
    print()


def steps(repeats=25) -> None:
    """Print what steps cost."""
    print("Steps at the default tolerances; rejected ones count.")
    print(f"  {'':47} {'steps':>8} {'ns / step':>10} {'steps / s':>10} {'ratio':>8}")
    for name, t_end, parameters in (
        ("impact_oscillator", 50 * 2 * math.pi / 0.8, {}),
        ("mackey_glass", 500.0, {"n": 5.5, "tau": 2.0}),
    ):
        numeric, p = numeric_model(name, **parameters)
        explicit, stiff = (Simulator(numeric, Direct(), Method(stiff=s)) for s in (False, True))
        plain, implicit = plain_run(explicit, p, t_end), plain_run(stiff, p, t_end)
        runs = {
            "explicit": plain,
            "explicit, trajectory kept": kept_run(explicit, p, t_end),
            "explicit, a call of simulate": partial(simulate, numeric, p, Direct(), t_end),
            "stiff": implicit,
        }
        counts = {kind: implicit() if kind == "stiff" else plain() for kind in runs}
        times = timed(runs, repeats)
        for kind, n_steps in counts.items():
            each = times[kind] / n_steps
            ratio = each / (times["explicit"] / counts["explicit"])
            print(f"  {name + ', ' + kind:47} {n_steps:8d} {1e9 * each:10.0f} {1 / each:10.0f} {ratio:8.2f}")
    print()


def basin(size=500, lines=20) -> None:
    """Print what the basins of figure 4.1 at beta = 29 cost on a grid, from some of its lines."""
    numeric, p = numeric_model("impact_oscillator")
    model = leave_out_effects(numeric.model, ["feedback"])
    period = 2 * math.pi / 0.8
    task = MotionTask(NumericModel(model), Direct(), Method(1e-6, 1e-8), ReturnSection())
    settings = ReturnSettings(period, 0.0, 400 * period, 16, 64)
    start = InitialState(np.zeros(2), "NC", True)
    xs, vs = np.linspace(-2, 1.26, size), np.linspace(-2, 2, size)
    coarse = np.stack(np.meshgrid(xs[:: size // 6], vs[:: size // 6]), axis=-1).reshape(-1, 2)
    known = tuple(survey_attractors(task, p, settings, coarse, start))
    chosen = [
        BasinRow(p, settings, np.stack([xs, np.full(size, v)], axis=-1), start, known) for v in vs[:: size // lines]
    ]
    classify_row(task, chosen[0])
    begin = time.perf_counter()
    for line in chosen:
        classify_row(task, line)
    seconds = (time.perf_counter() - begin) / len(chosen) * size
    print(
        f"Basins of figure 4.1 at beta = 29, {len(known)} attractors: {seconds:.0f} s on one core for {size} x {size} "
        f"initial states,"
    )
    print(f"from {len(chosen)} of its lines; {1e3 * seconds / size**2:.2f} ms each.")
    print()


def compilation() -> None:
    """Print what the first simulation of a model costs beside its steps."""
    numeric, p = numeric_model("impact_oscillator")
    start = time.perf_counter()
    simulate(numeric, p, Direct(), 0.1)
    compiling = time.perf_counter() - start
    print(f"The first simulation of a model compiles its functions for {compiling:.2f} s, left out of all times below.")
    print()


def main() -> None:
    """Print the tables."""
    try:
        compilation()
        against_solve_ivp()
        against_jitcdde()
        steps()
        basin()
    finally:
        shutil.rmtree(SCRATCH)


if __name__ == "__main__":
    main()
