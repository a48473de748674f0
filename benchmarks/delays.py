"""What a constant delay costs that is written as one that varies; whether numbers stay: part of ``make bench``."""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import tempfile

import numpy as np

from benchmarks.continuation import ROOT, ran

RUN = """
  steps:
    - {name: transient, simulate: {t_end: 200*2*pi/omega}}
    - {name: orbit, orbit: {from: transient, stability: true}}
    - {name: in_delay, continue: {from: orbit, free: [tau_d], range: {tau_d: [3, 4.75]}, stability: true}}
"""
REPEATS = 3


def write_models():
    """Return the model of the impact oscillator with its delay, and with a delay that reads a state, times nothing."""
    text = (ROOT / "models" / "impact_oscillator.yaml").read_text()
    constant = text[: text.index("\nrun:")] + "\nrun:\n  mesh: {degree: 8, tol: 1.0e-9}" + RUN
    varying = constant.replace("tau_d: 3.8}", "tau_d: 3.8, nothing: 0}").replace(
        "(t - tau_d)", "(t - tau_d - nothing*x)"
    )
    assert varying.count("nothing") == 2
    return {"constant": constant, "varying": varying}


def main():
    """Print CPU times of both, and how far they are apart."""
    best, found = {}, {}
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(REPEATS):
            for name, text in write_models().items():
                found[name], seconds = ran(text, folder, name)
                for step, spent in seconds.items():
                    best[name, step] = min(best.get((name, step), np.inf), spent)
        print("The impact oscillator with its delay, and with one that varies but for a factor 0; CPU seconds")
        for step in ("transient", "orbit", "in_delay"):
            a, b = best["constant", step], best["varying", step]
            print(f"  {step:12} {a:7.3f} {b:7.3f}  ratio {b / a:.2f}")
        one, other = (found[name].step("in_delay") for name in ("constant", "varying"))
        for label in sorted(set(one.labels) & set(other.labels) - {""}):
            place = [s.points["parameters"][s.row(label), 6] for s in (one, other)]
            print(f"  {label:4} at {place[0]:.12f}, apart by {abs(place[0] - place[1]):.1e}")


if __name__ == "__main__":
    main()
