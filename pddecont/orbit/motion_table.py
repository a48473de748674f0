"""One period of a motion as a table of times and states, read from CSV text."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.errors import RunError
from pddecont.model import Model

Array = NDArray[np.float64]
# Names that the column of times may have, and the name of the column of segments.
TIMES, SEGMENT = ("t", "time"), "segment"
# Fewer rows do not tell a motion.
MIN_ROWS = 4
# Times that differ by this part of the largest are one: those of the two sides of an event do by rounding.
ROUNDING = 1e-12
# Letters of a value that a message repeats.
MAX_SHOWN = 40


@dataclass(frozen=True, eq=False)
class MotionTable:
    """The rows of a table, in order of time.

    Attributes
    ----------
    t, x
        Times that never fall (n_rows,) and states (n_rows, n_states).
    segment
        What the rows say of the segment that they lie in: its name, or its number in the signature (None: nothing).
    line
        Where the rows stand in the file.
    """

    t: Array
    x: Array
    segment: tuple[str | int, ...] | None
    line: tuple[int, ...]


@dataclass(frozen=True)
class _Columns:
    """Which columns a table has."""

    n: int
    time: int
    states: tuple[int, ...]
    segment: int | None
    names: tuple[str, ...]


def read_motion_table(text: str, path: str, model: Model) -> MotionTable:
    """Return the table that CSV text writes: a header, then one row a time; lines that begin with ``#`` are left out.

    Raises
    ------
    RunError
        With what is wrong at which line and column of the file at ``path``. Nothing is repeated of a file without the
        columns that the model asks for.
    """
    lines = [(k, line) for k, line in enumerate(text.removeprefix("\ufeff").splitlines(), 1) if _is_row(line)]
    if not lines:
        raise RunError.at(path, 0, 0, "is empty; expected a line with the names of columns, then one line a time")
    columns = _read_header(path, lines[0], model)
    rows = [(k, line, _split(path, k, line, columns)) for k, line in lines[1:]]
    if len(rows) < MIN_ROWS:
        raise RunError.at(
            path, 0, 0, f"has too few rows, {len(rows)}; one period of a motion takes at least {MIN_ROWS}"
        )
    numbers = np.array([list(_read_numbers(path, row, columns)) for row in rows])
    labels = None
    if columns.segment is not None:
        labels = _read_labels([fields[columns.segment] for _, _, fields in rows])
    places = tuple(k for k, _, _ in rows)
    return MotionTable(_order_times(path, places, numbers[:, 0]), numbers[:, 1:], labels, places)


def _is_row(line: str) -> bool:
    return bool(line.strip()) and not line.lstrip().startswith("#")


def _split(path: str, k: int, line: str, columns: _Columns | None = None) -> list[str]:
    """Return the fields of a line."""
    try:
        fields = [field.strip() for field in next(csv.reader([line], skipinitialspace=True))]
    except csv.Error as exc:
        raise RunError.at(path, k, 1, f"is not a line of a CSV file: {exc}") from exc
    if columns is not None and len(fields) != columns.n:
        raise RunError.at(
            path,
            k,
            1,
            f"{len(fields)} values, expected {columns.n}: {', '.join(columns.names)} (numbers have a decimal point, a "
            "comma stands between them)",
        )
    return fields


def _read_header(path: str, first: tuple[int, str], model: Model) -> _Columns:
    """Return which columns there are; raise RunError if they are not a time, the model's states and a segment."""
    line, names = first[0], _split(path, *first)
    times = [name for name in TIMES if name in names and name not in model.states]
    if not times:
        raise RunError.at(
            path,
            line,
            1,
            f"no column '{TIMES[0]}' or '{TIMES[1]}'; expected a line with the names of columns: "
            f"{', '.join([TIMES[0], *model.states])}",
        )
    missing = [name for name in model.states if name not in names]
    if missing:
        listed = ", ".join(f"'{name}'" for name in missing)
        raise RunError.at(path, line, 1, f"no column for state {listed}; every state of the model has one")
    known = {times[0], *model.states, SEGMENT}
    for name in names:
        if names.count(name) > 1:
            raise RunError.at(path, line, 1, f"column '{name[:MAX_SHOWN]}' is there twice")
        if name not in known:
            raise RunError.at(
                path,
                line,
                1,
                f"column '{name[:MAX_SHOWN]}' is neither the time nor a state nor '{SEGMENT}'"
                f"{model.hint('states', name, model.states)} (states: {', '.join(model.states)}); remove or rename it",
            )
    segment = names.index(SEGMENT) if SEGMENT in names and SEGMENT not in model.states else None
    states = tuple(names.index(name) for name in model.states)
    return _Columns(len(names), names.index(times[0]), states, segment, tuple(names))


def _read_numbers(path: str, row: tuple[int, str, list[str]], columns: _Columns) -> Iterator[float]:
    """Yield the time and the states of a row."""
    k, line, fields = row
    for i in (columns.time, *columns.states):
        value = _to_number(fields[i])
        if not math.isfinite(value):
            column = 1 if '"' in line else 1 + sum(len(part) + 1 for part in line.split(",")[:i])
            raise RunError.at(
                path,
                k,
                column,
                f"expected a finite number in column '{columns.names[i]}', found '{fields[i][:MAX_SHOWN]}'",
            )
        yield value


def _to_number(text: str) -> float:
    try:
        return math.nan if "_" in text else float(text)
    except ValueError:
        return math.nan


def _read_labels(labels: Sequence[str]) -> tuple[str | int, ...]:
    """Return the segments of all rows: numbers if all of them are, else names."""
    numbers = [_to_number(label) for label in labels]
    if all(number.is_integer() for number in numbers):
        return tuple(int(number) for number in numbers)
    return tuple(labels)


def _order_times(path: str, lines: Sequence[int], t: Array) -> Array:
    """Return times that never fall, with rounding taken away; raise RunError where they do, or all of them are one."""
    rounding = ROUNDING * float(np.max(np.abs(t)))
    for i in np.flatnonzero(np.diff(t) < -rounding)[:1]:
        raise RunError.at(
            path,
            lines[i + 1],
            1,
            f"the time {t[i + 1]:.10g} does not come after {t[i]:.10g} above it; rows go forward in time",
        )
    if not t[-1] - t[0] > rounding:
        raise RunError.at(path, 0, 0, f"all rows are at the time {t[0]:.10g}; expected one period of a motion")
    ordered = t.copy()
    for i in np.flatnonzero(np.diff(t) <= rounding):
        ordered[i + 1] = ordered[i]
    return ordered
