"""Elimination in the order of time: what each part of a period makes of the parts before it."""

from __future__ import annotations

from pddecont.native.arrays import Floats, Indices, Integers, entry


def solve_block(matrix: Floats, n: int, right: Floats, first: int, width: int) -> bool:
    """Put the solution of a full ``matrix`` (n, n), which is lost, in place of ``right`` (n, width) from ``first`` on.

    By Gaussian elimination with partial pivoting; False where a pivot is zero.
    """
    for p in range(n):
        best = p
        for r in range(p + 1, n):
            if abs(matrix[r * n + p]) > abs(matrix[best * n + p]):
                best = r
        if matrix[best * n + p] == 0.0:
            return False
        here = first + p * width
        if best != p:
            other = first + best * width
            for c in range(p, n):
                kept = matrix[p * n + c]
                matrix[p * n + c] = matrix[best * n + c]
                matrix[best * n + c] = kept
            for t in range(width):
                kept = right[here + t]
                right[here + t] = right[other + t]
                right[other + t] = kept
        for r in range(p + 1, n):
            factor = matrix[r * n + p] / matrix[p * n + p]
            if factor != 0.0:
                for c in range(p + 1, n):
                    matrix[r * n + c] -= factor * matrix[p * n + c]
                there = first + r * width
                for t in range(width):
                    right[there + t] -= factor * right[here + t]
    for i in range(n):
        p = n - 1 - i
        here = first + p * width
        for c in range(p + 1, n):
            factor = matrix[p * n + c]
            if factor != 0.0:
                there = first + c * width
                for t in range(width):
                    right[here + t] -= factor * right[there + t]
        inverse = 1.0 / matrix[p * n + p]
        for t in range(width):
            right[here + t] *= inverse
    return True


@entry
def eliminate_in_time(
    starts: Indices,
    indices: Indices,
    data: Floats,
    rows: Integers,
    columns: Integers,
    sizes: Integers,
    n_blocks: int,
    block_of_row: Integers,
    width: int,
    right: Floats,
    solved: Floats,
    matrix: Floats,
) -> bool:
    """Solve a matrix that is block lower triangular in time but for a border; False where it is not, or is singular.

    Block b has ``sizes[b]`` rows and columns from ``rows[b]`` and ``columns[b]`` on; the rows below all of them are
    those with the number ``n_blocks`` in ``block_of_row`` (n_rows,). ``right`` (n_rows, width) holds right-hand sides;
    in the rows below it ends as what the solutions ``solved`` (n_columns, width), written in the blocks' columns, leave
    there. ``matrix`` has room for the largest block.
    """
    for b in range(n_blocks):
        size = sizes[b]
        top = rows[b]
        left = columns[b]
        for i in range(size * size):
            matrix[i] = 0.0
        for c in range(size):
            for e in range(starts[left + c], starts[left + c + 1]):
                row = indices[e]
                if block_of_row[row] == b:
                    matrix[(row - top) * size + c] += data[e]
                elif block_of_row[row] < b:
                    return False
        for i in range(size * width):
            solved[left * width + i] = right[top * width + i]
        if not solve_block(matrix, size, solved, left * width, width):
            return False
        for c in range(size):
            here = (left + c) * width
            for e in range(starts[left + c], starts[left + c + 1]):
                if block_of_row[indices[e]] != b:
                    value = data[e]
                    there = indices[e] * width
                    for t in range(width):
                        right[there + t] -= value * solved[here + t]
    return True
