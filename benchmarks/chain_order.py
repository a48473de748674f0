"""The grazing of figure 4.7 by chains of several orders and lengths, against the delay equation's: ``make
chain-order``.
"""

from __future__ import annotations

import math
import tempfile
from itertools import pairwise
from pathlib import Path

from pddecont.model import parse_document
from pddecont.results import read_results
from pddecont.steps import load_run_plan
from pddecont.steps.execution import execute

BASE = Path(__file__).parent.parent / "configs" / "chain_order.yaml"
START = """\
model: impact_oscillator
mesh: {degree: 10, tol: 1e-11}
steps:
  - {name: transient, simulate: {t_end: 60*2*pi/omega}}
  - {name: orbit, orbit: {from: transient}}
  - {name: in_gain, continue: {from: orbit, free: [K], range: {K: [0.1, 0.3]}, direction: up}}
"""
CHAIN = """\
model: impact_oscillator
delay: {method: chain, order: ORDER, n: LENGTH}
mesh: {degree: 8, intervals: INTERVALS}
steps:
  - {name: orbit, orbit: {from: {file: FILE, step: orbit}}}
  - {name: in_gain, continue: {from: orbit, free: [K], range: {K: [0.1, 0.3]}, direction: up}}
"""
LENGTHS = {1: (200, 400, 800), 2: (20, 40, 80), 3: (10, 20, 40), 4: (8, 12, 16)}
# Order 4 doubles, with every step, what the orbit holds at the frequency 2.45 n / tau: the kinks at impacts keep it
# from converging.
INTERVALS = dict.fromkeys(LENGTHS, 30)


def grazing(text: str, path: Path) -> float:
    """Return the gain at which the branch of a run grazes."""
    execute(load_run_plan(parse_document(text, str(BASE))), path, overwrite=True)
    step = read_results(path).step("in_gain")
    return float(step.points["parameters"][step.row("GR1"), step.meta["parameters"].index("K")])


def table(lengths: dict[int, tuple[int, ...]]) -> tuple[float, dict[int, list[tuple[int, float]]]]:
    """Return the delay equation's grazing and the chains' by order and length."""
    with tempfile.TemporaryDirectory() as folder:
        start = Path(folder) / "start.h5"
        exact = grazing(START, start)
        found = {}
        for order, ns in lengths.items():
            chain = (
                CHAIN.replace("ORDER", str(order))
                .replace("FILE", str(start))
                .replace("INTERVALS", str(INTERVALS[order]))
            )
            texts = {n: chain.replace("LENGTH", str(n)) for n in ns}
            found[order] = [(n, grazing(text, Path(folder) / "chain.h5")) for n, text in texts.items()]
    return exact, found


def orders(exact: float, values: list[tuple[int, float]]) -> list[float]:
    """Return the order between neighbouring lengths."""
    return [math.log(abs(a - exact) / abs(b - exact)) / math.log(m / n) for (n, a), (m, b) in pairwise(values)]


def main() -> None:
    """Print the table."""
    exact, found = table(LENGTHS)
    print(f"delay equation: GR at K = {exact:.12f}\n\n| order | n: K - K_exact | measured order |\n|---|---|---|")
    for order, values in found.items():
        cells = "; ".join(f"{n}: {value - exact:+.2e}" for n, value in values)
        print(f"| {order} | {cells} | {', '.join(f'{o:.2f}' for o in orders(exact, values))} |")


if __name__ == "__main__":
    main()
