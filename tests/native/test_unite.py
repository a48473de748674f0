"""Modules of plain Python become one source for Cython."""

import sys
from pathlib import Path

import pytest

from pddecont.native import compiled_integrator, integrator, unite

FIRST = '''"""A module."""

from __future__ import annotations

from enum import IntEnum
from math import inf
from typing import NamedTuple

import numpy as np

LARGE, TABLE = 2.5, np.array([[1.0, 2.0], [3.0, 4.0]])
Floats = np.ndarray


class Way(IntEnum):
    """Where to."""

    UP = 1
    DOWN = 7


class Core(NamedTuple):
    """What is worked on."""

    n: int
    y: Floats


def _size(c: Core) -> float:
    """Return a size."""
    largest = 0.0
    for i in range(c.n):
        largest = max(largest, abs(c.y[i]) * TABLE[1][0])
    return largest if c.n > 0 else inf
'''
SECOND = '''"""Another."""

from __future__ import annotations

from parts.calls import entry, wide
from parts.first import LARGE, Core, Way, _size


@entry
def decide(c: Core, level: float) -> tuple[int, float]:
    """Return a way."""
    way: int = Way.UP
    if _size(c) > LARGE * level:
        way = Way.DOWN
    return way, c.y[0]


@wide
def shrink(c: Core, by: float) -> None:
    """Make numbers smaller."""
    for i in range(c.n):
        c.y[i] *= by


def left_to_python(text: str) -> str:
    """Return what it is given."""
    return text
'''
CALLS = "def entry(function):\n    return function\n\n\nwide = entry\n"


@pytest.fixture
def text(tmp_path, monkeypatch):
    folder = tmp_path / "parts"
    folder.mkdir()
    for name, source in (("first", FIRST), ("second", SECOND), ("calls", CALLS)):
        (folder / f"{name}.py").write_text(source)
    (folder / "calls.pxi").write_text("# by hand\n")
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    yield unite.unite(folder, "parts")
    for name in [name for name in sys.modules if name.split(".")[0] == "parts"]:
        del sys.modules[name]


def test_constants_are_numbers_of_c(text):
    assert "#define first_LARGE 2.5" in text
    assert "static const double first_TABLE[2][2] = {{1.0, 2.0}, {3.0, 4.0}};" in text
    assert "#define Way_DOWN 7" in text


def test_records_are_structs(text):
    assert "cdef struct Core:\n    long n\n    double* y\n" in text
    assert "    c.y = <double*> find_address(record.y)" in text


def test_functions_have_the_names_of_their_modules(text):
    assert "cdef double first__size(Core* c) noexcept nogil:" in text
    assert "largest = max(largest, abs(c.y[i]) * first_TABLE[1][0])" in text
    assert "return largest if c.n > 0 else infinity" in text
    assert "if first__size(c) > first_LARGE * level:" in text


def test_annotated_variables_have_types_and_members_of_enumerations_are_numbers(text):
    assert "    cdef long way\n" in text
    assert "    way = Way_UP\n" in text


def test_entries_are_called_by_python(text):
    assert "def decide(object c, double level):" in text
    assert "        result = second_decide(&c_, level)" in text


def test_functions_with_long_loops_are_compiled_for_wider_registers_too(text):
    assert "cdef wide_void second_shrink(Core* c, double by) noexcept nogil:" in text
    assert 'ctypedef void wide_void "for_each_width void"' in text


def test_what_has_no_type_of_c_is_left_out(text):
    assert "left_to_python" not in text


def test_what_is_compiled_is_what_the_sources_say():
    """If not, the package has to be built anew: ``make setup``."""
    assert unite.find_digest(Path(integrator.__file__).parent) == compiled_integrator.DIGEST
