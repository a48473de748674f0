"""What the backend for LLVM makes of loops; what it has no code for is named."""

import pytest

from pddecont.codegen.llvm_backend import compile_source
from pddecont.codegen.machine_code import HEADER
from tests.codegen.test_machine_code import called


@pytest.mark.parametrize(
    ("line", "named"),
    [
        ("out[0] = 2.0 * erf(x[0])", "erf(x[0])"),
        ("out[0] = 1j", "1j"),
        ("out[0] = float(t + 1)", "t + 1"),
        ("del t", "del t"),
        ("if which == 0:\n        pass\n    else:\n        del t", "del t"),
        ("if which == 0:\n        del x", "del x"),
        ("for k in x:\n        out[k] = t", "for k in x:\n    out[k] = t"),
        ("for k in range(0, 9, 1):\n        out[2 * k] = t", "2 * k"),
    ],
)
def test_what_no_printer_writes_is_named(line, named):
    with pytest.raises(AssertionError) as raised:
        compile_source(f"{HEADER}    {line}\n")
    assert str(raised.value) == f"no printer writes this, and no code is made of it: {named}"


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("for k in range(1, 9, 3):\n        out[k] = x[0]", [0, 5, 0, 0, 5, 0, 0, 5, 0]),
        ("for k in range(2, 5, 1):\n        out[k] = x[k - 2]", [0, 0, 5, 6, 7, 0, 0, 0, 0]),
        ("for k in range(0, 2, 1):\n        out[k] = -x[k + 1]", [-6, -7, 0, 0, 0, 0, 0, 0, 0]),
        ("c0 = 2.0 * x[1]\n    for k in range(8, 9, 1):\n        out[k] = c0\n    out[0] = c0", [12, *[0] * 7, 12]),
    ],
)
def test_loops_write_their_places(line, expected):
    code = compile_source(f"{HEADER}    {line}\n")
    assert list(called(code.address, 0, 0.0, [5, 6, 7], [0], [0], 9)) == expected
