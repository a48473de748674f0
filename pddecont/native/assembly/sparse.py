"""Sparse matrices by columns."""

from __future__ import annotations

from pddecont.native.arrays import Floats, Indices, Integers, entry


def count_before(numbers: Integers, n: int, n_numbers: int, counts: Integers) -> None:
    """Write how many of ``n`` numbers are smaller than each up to ``n_numbers``, ``counts`` (n_numbers + 1,)."""
    for i in range(n_numbers + 1):
        counts[i] = 0
    for e in range(n):
        counts[numbers[e] + 1] += 1
    for i in range(n_numbers):
        counts[i + 1] += counts[i]


@entry
def sort_entries(
    rows: Integers,
    columns: Integers,
    n: int,
    n_rows: int,
    n_columns: int,
    counts: Integers,
    by_column: Integers,
    starts: Indices,
    indices: Indices,
    places: Integers,
) -> int:
    """Write the structure of a matrix with ``n`` entries; return at how many places it has any.

    ``starts`` (n_columns + 1,) and ``indices`` (n,) are those of its columns, rows in order; ``places`` (n,) says where
    among them each entry stands. ``counts`` (n_rows + n_columns + 1,) and ``by_column`` (n,) are worked in.
    """
    # Entries in the order of their rows, and those of a row as they come.
    count_before(rows, n, n_rows, counts)
    for e in range(n):
        places[counts[rows[e]]] = e
        counts[rows[e]] += 1
    # So they come to their columns; entries at one place follow each other.
    count_before(columns, n, n_columns, counts)
    for k in range(n):
        e = places[k]
        by_column[counts[columns[e]]] = e
        counts[columns[e]] += 1
    n_places = 0
    column = -1
    for k in range(n):
        e = by_column[k]
        while column < columns[e]:
            column += 1
            starts[column] = n_places
        if n_places == starts[column] or indices[n_places - 1] != rows[e]:
            indices[n_places] = rows[e]
            n_places += 1
        places[e] = n_places - 1
    while column < n_columns:
        column += 1
        starts[column] = n_places
    return n_places


@entry
def add_up(values: Floats, places: Integers, n: int, data: Floats) -> None:
    """Add ``values`` (n,) to ``data`` at their ``places`` (n,)."""
    for e in range(n):
        data[places[e]] += values[e]


@entry
def scale_to_one(
    starts: Indices,
    indices: Indices,
    data: Floats,
    n_rows: int,
    n_columns: int,
    columns: Floats,
    rows: Floats,
    scaled: Floats,
) -> None:
    """Write a matrix times ``columns`` (n_columns,), then times the ``rows`` (n_rows,) that make its rows' maxima one.

    A row of zeros stays one.
    """
    for i in range(n_rows):
        rows[i] = 0.0
    for j in range(n_columns):
        for e in range(starts[j], starts[j + 1]):
            scaled[e] = data[e] * columns[j]
            if abs(scaled[e]) > rows[indices[e]]:
                rows[indices[e]] = abs(scaled[e])
    for i in range(n_rows):
        rows[i] = 1.0 / rows[i] if rows[i] > 0.0 else 1.0
    for j in range(n_columns):
        for e in range(starts[j], starts[j + 1]):
            scaled[e] *= rows[indices[e]]


@entry
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
) -> None:
    """Write a matrix with a ``row`` (n_columns,) more below, each of its entries at a place of its own."""
    to = 0
    for j in range(n_columns):
        new_starts[j] = to
        for e in range(starts[j], starts[j + 1]):
            new_indices[to] = indices[e]
            new_data[to] = data[e]
            to += 1
        new_indices[to] = n_rows
        new_data[to] = row[j]
        to += 1
    new_starts[n_columns] = to
