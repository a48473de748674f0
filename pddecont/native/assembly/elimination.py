"""Elimination in the order of time: what each part of a period makes of the parts before it.

Blocks of equations and unknowns stand one after the other; what an equation holds of later blocks, and of unknowns
beside all of them, is left to the right-hand sides.
"""

from __future__ import annotations

from typing import NamedTuple

from pddecont.native.arrays import Floats, Indices, Integers, entry, wide


class Blocks(NamedTuple):
    """A sparse matrix by columns, and its blocks in the order of time; the arrays have to outlive it.

    Block b has ``sizes[b]`` rows and columns from ``rows[b]`` and ``columns[b]`` on. ``block_of_row`` (n_rows,) says
    which block each row belongs to; ``n_blocks`` stands for those below all blocks.
    """

    starts: Indices
    indices: Indices
    data: Floats
    rows: Integers
    columns: Integers
    sizes: Integers
    n_blocks: int
    block_of_row: Integers


class Border(NamedTuple):
    """What stands above and beside the blocks of a matrix of ``n`` columns; the arrays have to outlive it.

    The columns ``wrapped``, which earlier blocks hold, and those ``beside`` all blocks are the unknowns of a small full
    system; the rows ``below`` are as many as the latter. ``small`` are its factors by LAPACK, column by column, with
    ``exchanged`` rows; ``above`` (n_wrapped + n_beside, n) are the blocks' solutions for its columns.
    """

    n: int
    wrapped: Integers
    n_wrapped: int
    beside: Integers
    below: Integers
    n_beside: int
    above: Floats
    small: Floats
    exchanged: Indices


@wide
def factor_block(factors: Floats, first: int, n: int, pivots: Integers, top: int) -> bool:
    """Put the factors of a full matrix (n, n) from ``first`` on in its place; False where a pivot is zero.

    By Gaussian elimination with partial pivoting: row p was exchanged with row ``pivots[top + p]``.
    """
    for p in range(n):
        best = p
        for r in range(p + 1, n):
            if abs(factors[first + r * n + p]) > abs(factors[first + best * n + p]):
                best = r
        pivots[top + p] = best
        if factors[first + best * n + p] == 0.0:
            return False
        if best != p:
            for c in range(n):
                kept = factors[first + p * n + c]
                factors[first + p * n + c] = factors[first + best * n + c]
                factors[first + best * n + c] = kept
        for r in range(p + 1, n):
            factors[first + r * n + p] /= factors[first + p * n + p]
            factor = factors[first + r * n + p]
            if factor != 0.0:
                for c in range(p + 1, n):
                    factors[first + r * n + c] -= factor * factors[first + p * n + c]
    return True


@wide
def solve_block(
    factors: Floats, first: int, n: int, pivots: Integers, top: int, right: Floats, at: int, width: int
) -> None:
    """Put the solution of a factored block in place of ``right`` (n, width) from ``at`` on."""
    for p in range(n):
        here = at + p * width
        best = pivots[top + p]
        if best != p:
            other = at + best * width
            for t in range(width):
                kept = right[here + t]
                right[here + t] = right[other + t]
                right[other + t] = kept
    for p in range(n):
        here = at + p * width
        for r in range(p + 1, n):
            factor = factors[first + r * n + p]
            if factor != 0.0:
                there = at + r * width
                for t in range(width):
                    right[there + t] -= factor * right[here + t]
    for i in range(n):
        p = n - 1 - i
        here = at + p * width
        for c in range(p + 1, n):
            factor = factors[first + p * n + c]
            if factor != 0.0:
                there = at + c * width
                for t in range(width):
                    right[here + t] -= factor * right[there + t]
        inverse = 1.0 / factors[first + p * n + p]
        for t in range(width):
            right[here + t] *= inverse


@entry
def find_wrapped(m: Blocks, wrapped: Integers) -> int:
    """Write which columns of blocks equations of earlier blocks hold, in order; return how many there are.

    ``wrapped`` has room for all columns.
    """
    n = 0
    for b in range(m.n_blocks):
        for c in range(m.columns[b], m.columns[b] + m.sizes[b]):
            for e in range(m.starts[c], m.starts[c + 1]):
                if m.block_of_row[m.indices[e]] < b:
                    wrapped[n] = c
                    n += 1
                    break
    return n


@entry
def factor_in_time(m: Blocks, factors: Floats, pivots: Integers) -> bool:
    """Write the factors of the blocks of a matrix, one after the other; False where one of them is singular.

    ``factors`` has room for all blocks' entries, ``pivots`` for a number a row of theirs.
    """
    first = 0
    top = 0
    for b in range(m.n_blocks):
        size = m.sizes[b]
        for i in range(size * size):
            factors[first + i] = 0.0
        for c in range(size):
            for e in range(m.starts[m.columns[b] + c], m.starts[m.columns[b] + c + 1]):
                if m.block_of_row[m.indices[e]] == b:
                    factors[first + (m.indices[e] - m.rows[b]) * size + c] += m.data[e]
        if not factor_block(factors, first, size, pivots, top):
            return False
        first += size * size
        top += size
    return True


@entry
@wide
def solve_in_time(m: Blocks, factors: Floats, pivots: Integers, width: int, right: Floats, solved: Floats) -> None:
    """Solve a matrix whose blocks are factored, what stands above and beside them left out.

    ``right`` (n_rows, width) holds right-hand sides; in the rows below all blocks it ends as what the solutions
    ``solved`` (n_columns, width) leave there, which are written in the blocks' columns.
    """
    first = 0
    top = 0
    for b in range(m.n_blocks):
        size = m.sizes[b]
        left = m.columns[b]
        for i in range(size * width):
            solved[left * width + i] = right[m.rows[b] * width + i]
        solve_block(factors, first, size, pivots, top, solved, left * width, width)
        first += size * size
        top += size
        for c in range(size):
            here = (left + c) * width
            for e in range(m.starts[left + c], m.starts[left + c + 1]):
                if m.block_of_row[m.indices[e]] > b:
                    value = m.data[e]
                    there = m.indices[e] * width
                    for t in range(width):
                        right[there + t] -= value * solved[here + t]


@entry
def take_columns(m: Blocks, chosen: Integers, n: int, block_of_column: Integers, right: Floats) -> None:
    """Write ``n`` columns to ``right`` (n_rows, n), zero before: of those of a block what earlier blocks' rows hold."""
    for k in range(n):
        block = block_of_column[chosen[k]]
        for e in range(m.starts[chosen[k]], m.starts[chosen[k] + 1]):
            if block == m.n_blocks or m.block_of_row[m.indices[e]] < block:
                right[m.indices[e] * n + k] = m.data[e]


def solve_blocks(m: Blocks, factors: Floats, pivots: Integers, right: Floats, x: Floats) -> None:
    """Do what :func:`solve_in_time` does with a single right-hand side ``right`` (n_rows,), into ``x`` (n_columns,)."""
    first = 0
    top = 0
    for b in range(m.n_blocks):
        size = m.sizes[b]
        left = m.columns[b]
        for i in range(size):
            x[left + i] = right[m.rows[b] + i]
        for i in range(size):
            kept = x[left + pivots[top + i]]
            x[left + pivots[top + i]] = x[left + i]
            for p in range(i):
                kept -= factors[first + i * size + p] * x[left + p]
            x[left + i] = kept
        for k in range(size):
            i = size - 1 - k
            total = x[left + i]
            for p in range(i + 1, size):
                total -= factors[first + i * size + p] * x[left + p]
            x[left + i] = total / factors[first + i * size + i]
        first += size * size
        top += size
        for c in range(left, left + size):
            for e in range(m.starts[c], m.starts[c + 1]):
                if m.block_of_row[m.indices[e]] > b:
                    right[m.indices[e]] -= m.data[e] * x[c]


def solve_small(border: Border, unknown: Floats) -> None:
    """Put the solution of the small system in place of its right-hand side ``unknown`` (n_wrapped + n_beside,)."""
    width = border.n_wrapped + border.n_beside
    for k in range(width):
        kept = unknown[border.exchanged[k]]
        unknown[border.exchanged[k]] = unknown[k]
        unknown[k] = kept
    for k in range(width):
        for i in range(k + 1, width):
            unknown[i] -= border.small[k * width + i] * unknown[k]
    for j in range(width):
        k = width - 1 - j
        unknown[k] /= border.small[k * width + k]
        for i in range(k):
            unknown[i] -= border.small[k * width + i] * unknown[k]


@entry
@wide
def solve_bordered(
    m: Blocks, factors: Floats, pivots: Integers, border: Border, right: Floats, unknown: Floats, x: Floats
) -> None:
    """Write the solution ``x`` (n,) for the right-hand side ``right`` (n,), which is lost.

    ``unknown`` (n_wrapped + n_beside,) has room for the small system's solution.
    """
    solve_blocks(m, factors, pivots, right, x)
    n_wrapped = border.n_wrapped
    for k in range(n_wrapped):
        unknown[k] = x[border.wrapped[k]]
    for k in range(border.n_beside):
        unknown[n_wrapped + k] = right[border.below[k]]
        x[border.beside[k]] = 0.0
    solve_small(border, unknown)
    for k in range(n_wrapped + border.n_beside):
        value = unknown[k]
        for i in range(border.n):
            x[i] -= border.above[k * border.n + i] * value
    for k in range(border.n_beside):
        x[border.beside[k]] = unknown[n_wrapped + k]
