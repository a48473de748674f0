"""Extrema come from the polynomials: none is missed between base points, at edges, or where a closed orbit begins."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.collocation import make_basis
from pddecont.native.assembly.extrema import find_slope_beside
from pddecont.orbit import Profile


def wave(frequencies, amplitudes, phases, degree, n, *, closed):
    """Return a trigonometric sum of period one as polynomials on ``n`` equal intervals, and the sum itself with its
    slope.
    """

    def value(t):
        return sum(a * np.sin(2 * np.pi * k * t + p) for k, a, p in zip(frequencies, amplitudes, phases, strict=True))

    def slope(t):
        return sum(
            2 * np.pi * k * a * np.cos(2 * np.pi * k * t + p)
            for k, a, p in zip(frequencies, amplitudes, phases, strict=True)
        )

    start = np.arange(n) / n
    base = make_basis(degree).base
    values = value(start[:, None] + base / n)
    return Profile(degree, values, np.zeros(n, dtype=int), start, np.full(n, 1 / n), closed), slope, value


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.integers(0, 10_000))
def test_none_is_missed_and_none_invented(seed):
    rng = np.random.default_rng(seed)
    profile, slope, value = wave([1, 2, 5], rng.uniform(0.2, 1, 3), rng.uniform(0, 6, 3), 9, 12, closed=True)
    t = np.linspace(0, 1, 20001)
    signs = np.sign(slope(t))
    expected = int(np.sum(signs[1:] != signs[:-1]))
    found = profile.extrema
    assert len(found) == expected
    for e in found:
        assert abs(slope(e.time)) < 1e-3
        assert e.value == pytest.approx(float(value(e.time)), abs=1e-6)
    # Maxima and minima alternate, all around.
    kinds = [e.is_max for e in found]
    assert all(a != b for a, b in zip(kinds, kinds[1:] + kinds[:1], strict=True))


@pytest.mark.parametrize("offset", [0.0, 1e-16, -1e-16, 1e-9, -1e-9, 1e-4])
@pytest.mark.parametrize("place", [0.0, 1 / 6, 0.5])
def test_an_extremum_on_an_edge_counts_once(offset, place):
    """A cosine with its maximum at an edge of the mesh, or at the start of a closed orbit, to rounding and beyond."""
    profile, _, _ = wave([1], [1.0], [np.pi / 2 - 2 * np.pi * (place + offset)], 8, 6, closed=True)
    found = profile.extrema
    assert [e.is_max for e in found].count(True) == 1
    assert len(found) == 2
    top = next(e for e in found if e.is_max)
    assert top.value == pytest.approx(1.0, abs=1e-8)
    assert abs((top.time - place - offset + 0.5) % 1 - 0.5) < 1e-6


@pytest.mark.parametrize("thin", [1e-3, 1e-5, 1e-7])
@pytest.mark.parametrize("away", [0.01, -0.01])
def test_a_slope_is_looked_at_across_short_intervals(thin, away):
    """Breaking points about to cross leave a short interval between; what lies beyond is read where it lies, not
    extrapolated.
    """
    side = 0.25 - np.sign(away) * np.array([0.0, thin])
    cuts = np.sort(np.array([0.0, *side + np.sign(away) * 0.005, 0.5, 0.75, 1.0]))
    h = np.diff(cuts)
    values = np.sin(2 * np.pi * (cuts[:-1, None] + make_basis(9).base * h[:, None]))
    profile = Profile(9, values, np.zeros(5, dtype=int), cuts[:-1], h, True)
    j = int(np.searchsorted(cuts, 0.25)) - 1
    found = find_slope_beside(profile.make_curve(), j, (0.25 - cuts[j]) / h[j], away)
    assert found == pytest.approx(2 * np.pi * np.cos(2 * np.pi * (0.25 + away)), abs=1e-5)


def test_an_open_segment_has_none_at_its_ends():
    profile, _, _ = wave([1], [1.0], [np.pi / 2], 8, 6, closed=False)
    assert [e.is_max for e in profile.extrema] == [False]
