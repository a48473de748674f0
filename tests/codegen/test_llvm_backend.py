"""What the backend for LLVM has no code for is named."""

import pytest

from pddecont.codegen.llvm_backend import compile_source
from pddecont.codegen.machine_code import HEADER


@pytest.mark.parametrize(
    ("line", "named"),
    [
        ("out[0] = 2.0 * erf(x[0])", "erf(x[0])"),
        ("out[0] = 1j", "1j"),
        ("out[0] = float(t + 1)", "t + 1"),
        ("del t", "del t"),
        ("if which == 0:\n        pass\n    else:\n        del t", "del t"),
        ("if which == 0:\n        del x", "del x"),
    ],
)
def test_what_no_printer_writes_is_named(line, named):
    with pytest.raises(AssertionError) as raised:
        compile_source(f"{HEADER}    {line}\n")
    assert str(raised.value) == f"no printer writes this, and no code is made of it: {named}"
