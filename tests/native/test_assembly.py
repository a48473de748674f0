"""What equations are put together with: compiled and as plain Python, against array code."""

import importlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp

from pddecont.codegen import NumericModel
from pddecont.collocation import make_basis
from pddecont.model import parse_document, parse_model
from pddecont.native import compiled_assembly, unite
from pddecont.native.assembly import Blocks, Equations
from pddecont.orbit import Profile

PARTS = (
    *("lagrange", "location", "reading", "residual", "entries", "sparse"),
    *("lagged", "turning", "extrema", "transfer", "cutting", "elimination"),
)
RNG = np.random.default_rng(7)
MODEL = """
name: impacts
parameters: {k: 0.3, tau: 1.0}
states: [x, v]
modes:
  m: {x': v, v': -x + k*x(t - tau) - v**3}
events:
  e: x - k
resets:
  r: {v: -k*v}
segments:
  s: {mode: m, event: e, direction: rising, reset: r, to: m}
initial: {x: 0, v: 0}
"""


class Plain:
    """The functions as plain Python, of arrays whose entries are numbered through."""

    def __getattr__(self, name):
        modules = (importlib.import_module(f"pddecont.native.assembly.{part}") for part in PARTS)
        function = next(getattr(m, name) for m in modules if hasattr(m, name))
        return lambda *args: function(*(a.reshape(-1) if isinstance(a, np.ndarray) else a for a in args))


def make_sine(waves, n, degree, *, closed):
    """Return a profile of so many waves of a sine that begins at a tenth of its period."""
    start = np.arange(n) / n
    values = np.sin(2 * np.pi * (waves * (start[:, None] + make_basis(degree).base / n) + 0.1))
    return Profile(degree, values, np.zeros(n, dtype=int), start, np.full(n, 1 / n), closed)


@pytest.fixture(params=[compiled_assembly, Plain()], ids=["compiled", "plain"])
def native(request):
    return request.param


def test_what_is_compiled_are_these_sources():
    assert unite.find_digest(Path(unite.__file__).parent / "assembly") == compiled_assembly.DIGEST


def test_lagrange_polynomials(native):
    """Products over base points, to rounding; at a base point one of them is one and the others zero."""
    base = 0.5 - 0.5 * np.cos(np.pi * np.arange(6) / 5)
    barycentric = np.array([0.5, -1.0, 1.0, -1.0, 1.0, -0.5])
    sigma = np.concatenate([RNG.uniform(-0.3, 1.3, 20), base, [np.nan]])
    weights = np.empty((len(sigma), 6))
    native.evaluate_lagrange(sigma, len(sigma), base, barycentric, 6, weights)
    for k in range(6):
        others = np.delete(base, k)
        exact = np.prod((sigma[:-1, None] - others) / (base[k] - others), axis=1)
        assert weights[:-1, k] == pytest.approx(exact, rel=1e-13, abs=1e-15)
    assert np.array_equal(weights[20:26], np.eye(6))
    assert np.all(np.isnan(weights[26]))


def test_times_are_found_on_a_mesh(native):
    """An interval holds its left edge; one without length holds nothing."""
    edges, lengths = np.array([0.0, 0.5, 0.5, 2.0]), np.array([0.5, 0.0, 1.5, 1.0])
    times = np.array([0.0, 0.25, 0.5, 2.0, 2.999, 3.25, -0.5, -3.0])
    n = len(times)
    interval, sigma, wraps = np.empty(n, dtype=np.intp), np.empty(n), np.empty(n, dtype=np.intp)
    every = np.arange(4)
    native.locate_times(times, times, n, edges, lengths, every, 4, 3.0, interval, sigma, wraps)
    assert interval.tolist() == [0, 0, 2, 3, 3, 0, 3, 0]
    assert wraps.tolist() == [0, 0, 0, 0, 0, 1, -1, -1]
    assert edges[interval] + sigma * lengths[interval] + 3.0 * wraps == pytest.approx(times, abs=1e-15)
    some = np.array([2, 3])
    native.locate_times(times, times, n, edges, lengths, some, 2, 0.0, interval, sigma, wraps)
    assert interval.tolist() == [2, 2, 2, 3, 3, 3, 2, 2]
    assert not wraps.any()
    assert edges[interval] + sigma * lengths[interval] == pytest.approx(times, abs=1e-15)
    inside = times + 1e-3
    native.locate_times(times, inside - 2e-3, n, edges, lengths, every, 4, 3.0, interval, sigma, wraps)
    assert (interval[0], wraps[0], sigma[0]) == (3, -1, 1.0)


def test_a_time_that_is_no_number_lies_somewhere(native):
    times, interval = np.array([np.nan, np.inf]), np.empty(2, dtype=np.intp)
    sigma, wraps, lengths = np.empty(2), np.empty(2, dtype=np.intp), np.array([1.0, 1.0])
    native.locate_times(times, times, 2, np.array([0.0, 1.0]), lengths, np.arange(2), 2, 2.0, interval, sigma, wraps)
    assert set(interval.tolist()) <= {0, 1}
    assert not np.any(np.isfinite(sigma))


def test_values_are_weighed(native):
    weights, columns = RNG.standard_normal((7, 3)), RNG.integers(0, 11, (7, 3))
    values, result = RNG.standard_normal((11, 4)), np.empty((7, 4))
    native.weigh_values(weights, columns, 7, 3, values, 4, result)
    assert result == pytest.approx(np.einsum("ib,ibn->in", weights, values[columns]), abs=1e-14)


def test_slopes_are_spread(native):
    slopes, factor = RNG.standard_normal((2, 5)), RNG.standard_normal(5)
    weights, out = RNG.standard_normal((5, 3)), np.empty((2, 5, 3))
    native.spread_slopes(slopes, 2, factor, weights, 5, 3, out)
    assert out == pytest.approx((slopes * factor)[:, :, None] * weights, abs=1e-15)
    points, which, tables = np.array([8, 0, 3, 3, 6]), np.array([2, 0]), RNG.standard_normal((3, 9, 3))
    native.spread_over_reads(slopes, which, 2, factor, points, 5, tables, 9, 3, out)
    assert out == pytest.approx((slopes * factor)[:, :, None] * tables[which][:, points], abs=1e-15)


def test_moves_add_up_and_are_stretched(native):
    rates, out, which = RNG.standard_normal((3, 4)), np.array([1, 0, 1]), np.array([0, 2, 1])
    points, tables = np.array([5, 1, 1, 0]), RNG.standard_normal((3, 6, 2))
    result = np.zeros((2, 4, 2))
    native.add_moves(rates, out, which, 3, points, 4, tables, 6, 2, result)
    exact = np.zeros((2, 4, 2))
    for k in range(3):
        exact[out[k]] += rates[k][:, None] * tables[which[k]][points]
    assert result == pytest.approx(exact, abs=1e-14)
    values, factor = RNG.standard_normal((2, 4)), RNG.standard_normal(4)
    interval, lengths = np.array([1, 0, 2, 2]), RNG.standard_normal((3, 2))
    native.stretch_moves(values, 2, factor, interval, 4, lengths, 2, result)
    exact = exact * factor[:, None] - values[:, :, None] * lengths[interval]
    assert result == pytest.approx(exact, abs=1e-14)


def test_reads_move_with_the_durations_of_every_period(native):
    """Point by point: its own time, the whole periods between, and the interval of as many periods ago."""
    n, n_lags, n_segments, n_moving = 5, 4, 2, 3
    times, (starts, lengths) = RNG.standard_normal((n, n_lags, n_moving)), RNG.standard_normal((2, 6, n_lags, n_moving))
    interval, wraps = np.array([5, 0, 2, 2, 1]), np.array([0, 1, 3, 2, 0])
    slopes, sigma, widths = RNG.standard_normal(n), RNG.uniform(0.0, 1.0, n), RNG.uniform(1.0, 2.0, 6)
    result = np.empty(times.shape)
    native.move_lagged_reads(
        slopes, times, n, n_lags, n_moving, n_segments, interval, sigma, wraps, starts, lengths, widths, result
    )
    rates, stretched = RNG.standard_normal(n), np.zeros(times.shape)
    native.stretch_lagged_rates(rates, n, n_lags, n_moving, interval, wraps, lengths, stretched)
    for i, (j, w) in enumerate(zip(interval, wraps, strict=True)):
        exact = times[i].copy()
        exact[1 : w + 1, :n_segments] += 1.0
        exact[w:] -= starts[j, : n_lags - w] + sigma[i] * lengths[j, : n_lags - w]
        assert result[i] == pytest.approx(slopes[i] * exact / widths[j], abs=1e-14)
        assert not np.any(stretched[i, :w])
        assert stretched[i, w:] == pytest.approx(-rates[i] * lengths[j, : n_lags - w], abs=1e-15)


def make_entries(n, shape):
    return RNG.integers(0, shape[0], n), RNG.integers(0, shape[1], n), RNG.standard_normal(n)


@pytest.mark.parametrize(("n", "shape"), [(60, (9, 7)), (5, (30, 40)), (0, (3, 2)), (8, (1, 1))])
def test_entries_are_sorted_and_added_up(native, n, shape):
    rows, columns, values = make_entries(n, shape)
    counts, by_column, places = (np.empty(k, dtype=np.intp) for k in (sum(shape) + 1, n, n))
    starts, indices = np.empty(shape[1] + 1, dtype=np.intc), np.empty(n, dtype=np.intc)
    found = native.sort_entries(rows, columns, n, *shape, counts, by_column, starts, indices, places)
    data = np.zeros(found)
    native.add_up(values, places, n, data)
    exact = sp.coo_matrix((values, (rows, columns)), shape=shape).tocsc()
    exact.sum_duplicates()
    assert starts.tolist() == exact.indptr.tolist()
    assert indices[:found].tolist() == exact.indices.tolist()
    assert data == pytest.approx(exact.data, abs=1e-14)


def test_rows_are_scaled_to_one(native):
    """A row of zeros stays one."""
    rows, columns, values = make_entries(40, (8, 6))
    matrix = sp.coo_matrix((values * (rows != 3), (rows, columns)), shape=(8, 6)).tocsc()
    sizes, scale, scaled = RNG.uniform(0.5, 2.0, 6), np.empty(8), np.empty(matrix.nnz)
    native.scale_to_one(matrix.indptr, matrix.indices, matrix.data, 8, 6, sizes, scale, scaled)
    largest = np.max(np.abs(matrix.toarray() * sizes), axis=1)
    assert scale == pytest.approx(1.0 / np.where(largest > 0.0, largest, 1.0), rel=1e-15)
    whole = sp.csc_matrix((scaled, matrix.indices, matrix.indptr), shape=(8, 6)).toarray()
    assert whole == pytest.approx(scale[:, None] * matrix.toarray() * sizes, abs=1e-15)
    assert scale[3] == 1.0


def test_a_row_is_appended_with_a_place_for_each_entry(native):
    rows, columns, values = make_entries(20, (5, 6))
    matrix, row = (
        sp.coo_matrix((values, (rows, columns)), shape=(5, 6)).tocsc(),
        np.array([1.0, 0.0, 2.0, 0.0, 0.0, 3.0]),
    )
    n = matrix.nnz + 6
    starts, indices, data = np.empty(7, dtype=np.intc), np.empty(n, dtype=np.intc), np.empty(n)
    native.append_row(matrix.indptr, matrix.indices, matrix.data, 5, 6, row, starts, indices, data)
    whole = sp.csc_matrix((data, indices, starts), shape=(6, 6))
    assert np.array_equal(whole.toarray(), np.vstack([matrix.toarray(), row]))
    assert whole.nnz == n


@pytest.mark.parametrize("closed", [True, False])
def test_a_curve_turns_where_its_slope_changes_sign(native, monkeypatch, closed):
    """Five waves on four intervals: five maxima and minima a quarter of a wave apart, some at ends and on edges."""
    monkeypatch.setattr("pddecont.orbit.extrema.compiled_assembly", native)
    found = make_sine(5, 4, 20, closed=closed).extrema
    times = (0.15 + 0.5 * np.arange(10)) / 5
    assert [e.time for e in found] == pytest.approx(times, abs=1e-9)
    assert [e.is_max for e in found] == [True, False] * 5
    assert [e.value for e in found] == pytest.approx([1.0, -1.0] * 5, abs=1e-9)


def test_what_does_not_change_or_is_no_number_has_no_turns(native, monkeypatch):
    monkeypatch.setattr("pddecont.orbit.extrema.compiled_assembly", native)
    profile = make_sine(1, 6, 7, closed=True)
    assert replace(profile, values=np.full((6, 8), 0.43008067)).extrema == []
    assert replace(profile, values=np.full((6, 8), np.nan)).extrema == []


def test_where_points_read(native):
    """Places are those of the times read; one without length, or a time that is none, is told."""
    starts, lengths = np.array([0.0, 0.5, 2.0]), np.array([0.5, 1.5, 1.0])
    interval, place = np.array([0, 1, 2, 2]), np.array([0.5, 0.2, 0.0, 1.0])
    wraps, read = np.array([1, 0, 0, 0]), np.array([2, 0, 1, 1])
    lags, basis = np.array([0.0, 0.1, 0.0, 0.3]), make_basis(4)
    sigma, weights = np.empty(4), np.empty((4, 5))

    def weigh(lengths, lags):
        return native.weigh_reads(
            *(starts, lengths, interval, place, 4, 0.7, lags, 3.0, wraps, read),
            *(basis.base, basis.barycentric, 5, sigma, weights),
        )

    times = starts[interval] + place * lengths[interval] - 0.7 - lags + 3.0 * wraps
    assert weigh(lengths, lags) == pytest.approx(np.max(np.abs((times - starts[read]) / lengths[read])))
    assert starts[read] + sigma * lengths[read] == pytest.approx(times, abs=1e-15)
    assert np.array_equal(weights, basis.lagrange(sigma))
    assert weigh(np.array([0.5, 0.0, 1.0]), lags) == -1.0
    assert weigh(lengths, np.array([0.0, np.nan, 0.0, 0.0])) == np.inf


def test_how_reads_move(native):
    """What is read moves as central differences say, to their error."""
    basis, n, m, n_theta = make_basis(5), 3, 6, 3
    start, stretch = RNG.uniform(size=(2, n_theta)), RNG.uniform(1.0, 2.0, size=(2, n_theta))
    times, theta, read = RNG.uniform(size=(n, n_theta)), np.array([1.0, 0.7, 0.4]), np.array([1, 0, 1])
    columns = np.array([[6, 7, 8, 9, 10, 11], [0, 1, 2, 3, 4, 5], [6, 7, 8, 9, 10, 11]])
    values, which, result = RNG.normal(size=(12, 2)), np.array([2, 0]), np.empty((n, 2, 2))

    def find_places(theta):
        return (times @ theta - start[read] @ theta) / (stretch[read] @ theta)

    def value(theta):
        return np.einsum("ik,ikq->iq", basis.lagrange(find_places(theta)), values[columns])

    sigma = find_places(theta)
    native.move_reads(
        *(basis.lagrange(sigma), columns, n, m, basis.differentiate, values, 2, times, start, stretch, n_theta),
        *(which, 2, read, sigma, stretch @ theta, np.empty(m), result),
    )
    for k, component in enumerate(which):
        step = 1e-6 * np.eye(n_theta)[component]
        assert result[:, :, k] == pytest.approx((value(theta + step) - value(theta - step)) / 2e-6, rel=1e-7, abs=1e-7)


def test_residuals_are_those_of_array_code(native):
    """Collocation, resets and events of a model, each by its machine code, against its functions over arrays."""
    model = NumericModel(parse_model(parse_document(MODEL, "model"))[0])
    degree, n_intervals, n_segments = 3, 4, 2
    basis, p = make_basis(degree), model.parameter_values
    base_index = degree * np.arange(n_intervals)[:, None] + np.array([0, 0, 1, 1])[:, None] + np.arange(degree + 1)
    n_points, next_base = n_intervals * degree + n_segments, np.array([7, 0])
    (field,), (reset,), (event,) = (
        model.locate_code(kind, (name,)) for kind, name in (("fields", "m"), ("resets", "r"), ("events", "e"))
    )
    codes = np.array([field] * (n_points - n_segments) + [reset] * 2 + [event, (0, 0)], dtype=np.int64)
    values, h = RNG.normal(size=(14, 2)), RNG.uniform(1.0, 2.0, n_intervals)
    t, x, xd = RNG.uniform(size=n_points), RNG.normal(size=(n_points, 2)), RNG.normal(size=(n_points, 1))
    address, which = codes.T.copy()
    result = np.full(n_points * 2 + n_segments, 7.0)
    equations = Equations(
        degree, n_intervals, n_segments, 2, 1, base_index.ravel(), basis.slopes.ravel(), next_base, address, which
    )
    native.fill_residual(equations, values, h, t, x, xd, p, np.empty(2), result)
    inner = slice(0, n_points - n_segments)
    slopes = np.einsum("ib,jbn->jin", basis.slopes, values[base_index]).reshape(-1, 2)
    f = model.mode("m").value(t[inner], x[inner].T, xd[inner].T, p).T
    assert result[: 2 * n_intervals * degree].reshape(-1, 2) == pytest.approx(
        slopes - np.repeat(h, degree)[:, None] * f, abs=1e-13
    )
    ends = slice(n_points - n_segments, None)
    g = model.reset("r").value(t[ends], x[ends].T, xd[ends].T, p).T
    assert result[2 * n_intervals * degree : 2 * n_points].reshape(-1, 2) == pytest.approx(
        values[next_base] - g, abs=1e-13
    )
    first = slice(n_points - n_segments, n_points - n_segments + 1)
    assert result[-2] == pytest.approx(model.event("e").value(t[first], x[first].T, xd[first].T, p)[0, 0], abs=1e-13)
    assert result[-1] == 7.0


SIZES = [2, 4, 3]


def make_blocks(matrix):
    """Return a matrix and its blocks, which stand in their order."""
    first, sparse = np.cumsum([0, *SIZES[:-1]]), sp.csc_matrix(matrix)
    of_row = np.repeat(np.arange(len(SIZES) + 1), [*SIZES, len(matrix) - sum(SIZES)])
    return Blocks(sparse.indptr, sparse.indices, sparse.data, first, first, np.array(SIZES), len(SIZES), of_row)


def draw_blocks(n):
    """Return a random matrix whose blocks hold nothing of later ones, with a zero where a first pivot would be."""
    full = RNG.normal(size=(n, n))
    for size, first in zip(SIZES, (0, 2, 6), strict=True):
        full[first : first + size, first + size : 9] = 0.0
    full[2, 2] = 0.0
    return full


def test_elimination_in_the_order_of_time(native):
    full = draw_blocks(11)
    right = np.concatenate([full[:, 9:], RNG.normal(size=(11, 3))], axis=1)
    blocks = make_blocks(full)
    factors, pivots, left, solved = np.empty(29), np.empty(9, dtype=np.intp), right.copy(), np.zeros(right.shape)
    assert native.factor_in_time(blocks, factors, pivots)
    native.solve_in_time(blocks, factors, pivots, 5, left, solved)
    above = np.linalg.solve(full[:9, :9], right[:9])
    assert solved[:9] == pytest.approx(above, rel=1e-11)
    assert left[9:] == pytest.approx(right[9:] - full[9:, :9] @ above, rel=1e-10)


def test_wide_registers_round_as_python_does():
    """What is compiled for several processors gives the same numbers on all of them, to the last bit."""
    full = draw_blocks(11)
    right = np.concatenate([full[:, 9:], RNG.normal(size=(11, 35))], axis=1)
    blocks, found = make_blocks(full), []
    for code in (compiled_assembly, Plain()):
        factors, pivots, left, solved = np.empty(29), np.empty(9, dtype=np.intp), right.copy(), np.zeros(right.shape)
        code.factor_in_time(blocks, factors, pivots)
        code.solve_in_time(blocks, factors, pivots, right.shape[1], left, solved)
        found.append(np.concatenate([factors, left.ravel(), solved.ravel()]))
    assert np.array_equal(*found)


def test_elimination_tells_of_a_singular_block(native):
    for value in (1.0, 0.0):
        full = np.eye(10)
        full[3, 3] = value
        blocks = make_blocks(full)
        assert native.factor_in_time(blocks, np.empty(29), np.empty(9, dtype=np.intp)) == bool(value)


def test_columns_that_come_round(native):
    """Columns of blocks that earlier blocks hold: which, and what of them and of the border stands at the right."""
    full = draw_blocks(11)
    full[0, 3], full[1, 8], full[4, 8] = 2.0, 3.0, 4.0
    blocks = make_blocks(full)
    found = np.empty(11, dtype=np.intp)
    assert native.find_wrapped(blocks, found) == 2
    assert found[:2].tolist() == [3, 8]
    right = np.zeros((11, 3))
    native.take_columns(blocks, np.array([3, 8, 10]), 3, blocks.block_of_row, right)
    expected = np.stack([full[:, 3], full[:, 8], full[:, 10]], axis=1)
    expected[2:, 0] = expected[6:, 1] = 0.0
    assert np.array_equal(right, expected)


def test_a_few_values_are_read_of_many(native):
    weights, columns = RNG.normal(size=(5, 3)), RNG.integers(0, 7, size=(5, 3))
    values, result = RNG.normal(size=(7, 4)), np.full((5, 3), 9.0)
    native.read_states(weights, columns, 5, 3, values, 4, np.array([3, 1]), np.array([2, 0]), 2, 3, result)
    every = np.einsum("pk,pkn->pn", weights, values[columns])
    assert result[:, [2, 0]] == pytest.approx(every[:, [3, 1]], abs=1e-14)
    assert np.all(result[:, 1] == 9.0)
