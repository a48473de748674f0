"""Orbits as lines through points of their own polynomials, and the multipliers or roots of each."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.plot import interpolate_segments
from pddecont.report.packed_arrays import ArrayPacker
from pddecont.results import Step
from pddecont.tables import find_signature, holds_equilibria, read_multipliers, read_roots

Array = NDArray[np.float64]
# A step's orbits have so many numbers in a page if they can; fewer points each then, but not fewer than the least.
NUMBERS = 2_000_000
LEAST_SAMPLES, MOST_SAMPLES = 48, 400
# Beyond these numbers only some orbits are in the page: those of special points, and every so many others.
MOST_NUMBERS = 4 * NUMBERS


def describe_orbits(packer: ArrayPacker, step: Step) -> dict[str, Any] | None:
    """Return the orbits of a step in order along the branch; None where it holds none.

    Segment by segment ``time`` and each signal have the same samples; ``samples`` are their numbers. ``held`` says for
    each point which orbit is its own, -1 where the page has none. ``extents`` are highest and lowest values of each
    state of every point. Events are ``surfaces`` normal . z = level: (n_points, n_surfaces, n_states + 1).
    """
    if "segment" not in step.orbits:
        return None
    states = [str(name) for name in step.meta["states"]]
    signals = [*states, *(str(name) for name in step.meta.get("delayed", []))]
    n_samples, stride = choose_samples(len(step), len(signals) + 1)
    highest, lowest, held, texts = [], [], [], []
    counts: list[list[int]] = []
    times: list[Array] = []
    values: list[Array] = []
    for place, row in enumerate(step.order):
        arcs = interpolate_segments(step, int(row))
        highest.append(np.max([arc.max(axis=0) for _, arc in arcs], axis=0))
        lowest.append(np.min([arc.min(axis=0) for _, arc in arcs], axis=0))
        if place % stride and not step.labels[row]:
            held.append(-1)
            continue
        held.append(len(counts))
        texts.append(find_signature(step, int(row)))
        # Of a model without delays nothing can be interpolated.
        delayed = interpolate_segments(step, int(row), "delayed") if len(signals) > len(states) else arcs
        chosen = [choose_places(len(t), n_samples // len(arcs)) for t, _ in arcs]
        counts.append([len(places) for places in chosen])
        for places, (t, arc), (_, past) in zip(chosen, arcs, delayed, strict=True):
            times.append(t[places] - arcs[0][0][0])
            values.append(np.hstack([arc, past])[places, : len(signals)])
    signatures = list(dict.fromkeys(texts))
    return {
        "signals": signals,
        "events": [str(name) for name in step.meta.get("events", [])],
        "held": packer.add(held, "<i4"),
        "segments": packer.add([len(own) for own in counts], "<u4"),
        "samples": packer.add([n for own in counts for n in own], "<u4"),
        "signatures": signatures,
        "signature": packer.add([signatures.index(text) for text in texts], "<u4"),
        "time": packer.add(np.concatenate(times), "<f4"),
        "values": packer.add(np.vstack(values).T, "<f4"),
        "extents": [packer.add(np.array(side).T, "<f8") for side in (highest, lowest)],
        "surfaces": packer.add(step.points["surfaces"][step.order], "<f8"),
        "n_surfaces": int(step.points["surfaces"].shape[1]),
    }


def choose_samples(n_orbits: int, n_signals: int) -> tuple[int, int]:
    """Return how many samples an orbit has in the page, and that every so many orbits are in it."""
    n_samples = int(np.clip(NUMBERS // (n_orbits * n_signals), LEAST_SAMPLES, MOST_SAMPLES))
    return n_samples, max(1, -(-n_orbits * n_signals * n_samples // MOST_NUMBERS))


def choose_places(n: int, n_samples: int) -> NDArray[np.intp]:
    """Return which of ``n`` points of a line are shown: both ends, and others between at equal numbers."""
    return np.unique(np.round(np.linspace(0, n - 1, max(2, n_samples))).astype(np.intp))


def describe_spectra(packer: ArrayPacker, step: Step) -> dict[str, Any] | None:
    """Return Floquet multipliers, or characteristic roots, of each point along the branch; None where there are none.

    ``n`` says how many each point has.
    """
    at_rest = holds_equilibria(step)
    found = [(read_roots if at_rest else read_multipliers)(step, int(row)) for row in step.order]
    together = np.concatenate([np.empty(0, dtype=complex), *found])
    if not len(together):
        return None
    return {
        "what": "roots" if at_rest else "multipliers",
        "n": packer.add([len(values) for values in found], "<u4"),
        "real": packer.add(together.real, "<f8"),
        "imaginary": packer.add(together.imag, "<f8"),
    }
