"""Arrays of a file that lie side by side, in memory: which do, and that rows written together are those meant."""

import os

import numpy as np

from pddecont.results.parts import GAP, Part, Place, find_parts

FLOAT, TEXT = np.dtype("f8"), np.dtype("S4")


def test_arrays_side_by_side_make_one_part():
    """Not across an array that is written by itself, nor far apart; those without columns lie nowhere."""
    places = {
        "a": Place(FLOAT, (), 8, 100),
        "b": Place(TEXT, (), 4, 200),
        "none": Place(FLOAT, (0,), 0, 0),
        "long": Place(FLOAT, (3,), 24, 300),
        "c": Place(FLOAT, (2,), 16, 400),
        "d": Place(FLOAT, (), 8, 400 + 5 * 16 + GAP + 1),
    }
    found = find_parts(places, 5, {"a", "b", "c", "d", "none"})
    assert [set(part) for part in found] == [{"a", "b"}, {"c"}, {"d"}]


def test_rows_of_a_part_stand_where_the_file_has_them(tmp_path):
    path = tmp_path / "a"
    path.write_bytes(bytes(range(250)))
    places = {"a": Place(FLOAT, (2,), 16, 40), "b": Place(TEXT, (), 4, 100)}
    descriptor = os.open(path, os.O_RDWR)
    part = Part(descriptor, places, 3)
    part.rows["a"][1] = [1.5, -2.0]
    part.rows["b"][2] = b"GR"
    os.pwrite(descriptor, part.image, part.offset)
    os.close(descriptor)
    data = path.read_bytes()
    assert np.frombuffer(data[56:72], FLOAT).tolist() == [1.5, -2.0]
    assert data[108:112] == b"GR\0\0"
    kept = [k for k in range(250) if not (56 <= k < 72 or 108 <= k < 112)]
    assert [data[k] for k in kept] == kept
