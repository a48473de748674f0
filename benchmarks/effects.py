"""What each effect of a full model costs, and that without them all it costs what the hand-written linear oscillator
does.

Run as ``python -m benchmarks.effects``. All models take turns in one process; the times are medians, the ratios are
medians of the ratios within a turn.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import statistics
import sys
import tempfile
import time
from pathlib import Path

from pddecont.model import parse_document
from pddecont.results import create_results, read_results
from pddecont.runfile import Overrides, PlannedStep
from pddecont.simulate import Simulator, Workers
from pddecont.steps import Context, Silent, list_step_kinds, load_run_plan

ROOT = Path(__file__).parent.parent
# In the order in which they are left out, one after another.
EFFECTS = ("damping", "friction", "impact", "cutting", "feedback")
HAND = "linear_oscillator"
PERIODS = 200
TURNS = 5


def context_of(model: str, off: tuple[str, ...], path: Path) -> Context:
    """Return a model's own run without some effects, its transient done."""
    source = ROOT / "models" / f"{model}.yaml"
    plan = load_run_plan(parse_document(source.read_text(), str(source)), Overrides(without=off))
    context = Context(plan, path, Silent(), Workers())
    begin(context)
    do_step(context, plan.steps[0])
    return context


def begin(context: Context) -> None:
    """Begin a new file."""
    plan = context.plan
    create_results(context.path, plan.model_text, plan.run_text, plan.source, "{}", overwrite=True)
    context.file = read_results(context.path)


def do_step(context: Context, step: PlannedStep) -> None:
    """Do a step; trajectories stay in memory for the steps that start from them."""
    list_step_kinds()[step.kind].load()(context, step, None)


def followed(context: Context) -> None:
    """Find the orbit and follow its branch, into a new file."""
    begin(context)
    for step in context.plan.steps[1:]:
        do_step(context, step)


def simulated(context: Context):
    """Return a function that integrates ``PERIODS`` periods."""
    plan = context.plan
    simulator = Simulator(plan.numeric, plan.steps[0].delay)
    values = simulator.values(plan.parameters)
    t_end = PERIODS * float(plan.numeric.period.value(plan.parameters)[0])
    return lambda: simulator.advance(values, simulator.start(values), t_end)


def turns(functions, n: int) -> dict[str, list[float]]:
    """Return the times of ``n`` calls of each function; they take turns, one way and back, so that what disturbs one
    disturbs all.
    """
    for f in functions.values():
        f()
    times: dict[str, list[float]] = {name: [] for name in functions}
    for k in range(n):
        for name in list(functions)[:: 1 if k % 2 else -1]:
            start = time.perf_counter()
            functions[name]()
            times[name].append(time.perf_counter() - start)
    return times


def ratio(times: dict[str, list[float]], name: str, to: str) -> float:
    """Return the median over the turns of the ratio of two times."""
    return statistics.median(a / b for a, b in zip(times[name], times[to], strict=True))


def main() -> int:
    """Print the table; return 1 if the lean model's times are not those of the hand-written one to within 5 %."""
    with tempfile.TemporaryDirectory() as folder:
        contexts = {
            f"without {', '.join(EFFECTS[:k])}" if k else "full": ("full_oscillator", EFFECTS[:k])
            for k in range(len(EFFECTS) + 1)
        }
        contexts["by hand"] = (HAND, ())
        made = {
            name: context_of(model, off, Path(folder) / f"{i}.h5")
            for i, (name, (model, off)) in enumerate(contexts.items())
        }
        follow = turns({name: lambda c=c: followed(c) for name, c in made.items()}, TURNS)
        integration = turns({name: simulated(c) for name, c in made.items()}, 10 * TURNS)
        print(
            f"full_oscillator without one effect after another; {PERIODS} periods simulated, orbit and branch with "
            f"multipliers"
        )
        counts = f"{'states':>6} {'delayed':>7} {'modes':>5} {'unknowns':>8} {'points':>6}"
        heads = f"{counts} {'orbit+branch':>13} {'simulation':>11}"
        print(f"{'time / by hand':52} {heads}")
        for name, context in made.items():
            model, branch = context.plan.model, read_results(context.path).step("branch")
            unknowns = int(branch.points["n_unknowns"][0])
            sizes = f"{len(model.states):6} {len(model.delayed):7} {len(model.modes):5} {unknowns:8} {len(branch):6}"
            print(
                f"{name:52} {sizes} {ratio(follow, name, 'by hand'):13.3f} {ratio(integration, name, 'by hand'):11.3f}"
            )
        for what, times in (("orbit + branch", follow), ("simulation", integration)):
            print(f"by hand, {what}: {1e3 * statistics.median(times['by hand']):.3g} ms")
        # The lean model and the hand-written one alone, many more times.
        lean = list(made)[-2]
        pair = {name: simulated(made[name]) for name in (lean, "by hand")}
        closer = {
            "orbit + branch": turns({name: lambda c=made[name]: followed(c) for name in pair}, 3 * TURNS),
            "simulation": turns(pair, 50 * TURNS),
        }
        off_by = {what: abs(ratio(times, lean, "by hand") - 1.0) for what, times in closer.items()}
        print("lean against by hand: " + ", ".join(f"{what} {100 * x:.2f} % apart" for what, x in off_by.items()))
        return int(max(off_by.values()) > 0.05)


if __name__ == "__main__":
    sys.exit(main())
