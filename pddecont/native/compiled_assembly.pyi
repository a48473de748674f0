"""The entries of the assembly as they are compiled: see the functions of the same names in its sources."""

from pddecont.native.arrays import Floats, Indices, Integers
from pddecont.native.assembly.curve import Curve
from pddecont.native.assembly.residual import Equations

DIGEST: str

def evaluate_lagrange(sigma: Floats, n: int, base: Floats, barycentric: Floats, m: int, weights: Floats) -> None: ...
def locate_times(
    times: Floats,
    chooser: Floats,
    n: int,
    edges: Floats,
    lengths: Floats,
    candidates: Integers,
    n_candidates: int,
    period: float,
    interval: Integers,
    sigma: Floats,
    wraps: Integers,
) -> None: ...
def weigh_values(
    weights: Floats, columns: Integers, n: int, m: int, values: Floats, n_values: int, result: Floats
) -> None: ...
def spread_slopes(
    slopes: Floats, n_slopes: int, factor: Floats, weights: Floats, n: int, m: int, out: Floats
) -> None: ...
def spread_over_reads(
    slopes: Floats,
    which: Integers,
    n_slopes: int,
    factor: Floats,
    points: Integers,
    n: int,
    weights: Floats,
    n_points: int,
    m: int,
    out: Floats,
) -> None: ...
def add_moves(
    rates: Floats,
    out: Integers,
    which: Integers,
    n_rates: int,
    points: Integers,
    n: int,
    tables: Floats,
    n_points: int,
    n_moving: int,
    result: Floats,
) -> None: ...
def stretch_moves(
    values: Floats,
    n_out: int,
    factor: Floats,
    interval: Integers,
    n: int,
    lengths: Floats,
    n_moving: int,
    result: Floats,
) -> None: ...
def sort_entries(
    rows: Integers,
    columns: Integers,
    n: int,
    n_rows: int,
    n_columns: int,
    counts: Integers,
    by_row: Integers,
    starts: Indices,
    indices: Indices,
    places: Integers,
) -> int: ...
def add_up(values: Floats, places: Integers, n: int, data: Floats) -> None: ...
def scale_to_one(
    starts: Indices,
    indices: Indices,
    data: Floats,
    n_rows: int,
    n_columns: int,
    columns: Floats,
    rows: Floats,
    scaled: Floats,
) -> None: ...
def append_row(
    starts: Indices,
    indices: Indices,
    data: Floats,
    n_rows: int,
    n_columns: int,
    row: Floats,
    new_starts: Indices,
    new_indices: Indices,
    new_data: Floats,
) -> None: ...
def move_lagged_reads(
    slopes: Floats,
    times: Floats,
    n: int,
    n_lags: int,
    n_moving: int,
    n_segments: int,
    interval: Integers,
    sigma: Floats,
    wraps: Integers,
    starts: Floats,
    lengths: Floats,
    widths: Floats,
    result: Floats,
) -> None: ...
def stretch_lagged_rates(
    rates: Floats,
    n: int,
    n_lags: int,
    n_moving: int,
    interval: Integers,
    wraps: Integers,
    lengths: Floats,
    result: Floats,
) -> None: ...
def fill_residual(
    c: Equations, values: Floats, h: Floats, t: Floats, x: Floats, xd: Floats, p: Floats, work: Floats, result: Floats
) -> None: ...
def interpolate(
    weights: Floats,
    interval: Integers,
    base_index: Integers,
    n: int,
    m: int,
    values: Floats,
    n_values: int,
    out: Floats,
) -> None: ...
def weigh_reads(
    starts: Floats,
    lengths: Floats,
    interval: Integers,
    place: Floats,
    n: int,
    lag: float,
    lags: Floats,
    period: float,
    wraps: Integers,
    read: Integers,
    base: Floats,
    barycentric: Floats,
    m: int,
    sigma: Floats,
    weights: Floats,
) -> float: ...
def move_reads(
    weights: Floats,
    columns: Integers,
    n: int,
    m: int,
    differentiate: Floats,
    values: Floats,
    n_values: int,
    times: Floats,
    starts: Floats,
    stretches: Floats,
    n_theta: int,
    which: Integers,
    n_which: int,
    read: Integers,
    sigma: Floats,
    lengths: Floats,
    slopes: Floats,
    out: Floats,
) -> None: ...
def find_turns(
    curve: Curve,
    halves: Floats,
    parts: Floats,
    rates: Floats,
    room: int,
    interval: Integers,
    sigma: Floats,
    is_max: Integers,
) -> int: ...
def choose_extrema(
    curve: Curve, n: int, interval: Integers, sigma: Floats, is_max: Integers, value: Floats, chosen: Integers
) -> int: ...
def transfer_values(
    starts: Floats,
    lengths: Floats,
    segment: Integers,
    n: int,
    base: Floats,
    m: int,
    durations: Floats,
    old_starts: Floats,
    old_lengths: Floats,
    old_last: Integers,
    old_base: Floats,
    old_barycentric: Floats,
    old_m: int,
    old_durations: Floats,
    values: Floats,
    n_values: int,
    times: Floats,
    owner: Integers,
    sigma: Floats,
    weights: Floats,
    result: Floats,
) -> None: ...
def cut_piece(
    edges: Floats,
    heights: Floats,
    n: int,
    start: float,
    end: float,
    most: int,
    grid: Floats,
    totals: Floats,
    cuts: Floats,
) -> int: ...
