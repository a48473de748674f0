"""Names and units as they are written on axes."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.mathtext import MathTextParser

from pddecont.plot.axis_labels import find_unit, format_axis_label, format_name, format_unit
from pddecont.results import Step

NAMES = st.from_regex(r"\A[A-Za-z_][A-Za-z0-9_]{0,12}\Z")


def test_a_label_is_a_name_and_its_unit():
    step = Step("s", "orbit", {"units": {"tau_d": "s", "x": "m/s^2", "t": "s", "K": "N*s**-1"}}, {}, {}, (), True)
    assert format_axis_label(step, "tau_d") == r"$\tau_{d}$ (s)"
    assert format_axis_label([step], "x") == "$x$ (m/s$^{2}$)"
    assert format_axis_label(step, "K") == "$K$ (N*s$^{-1}$)"
    assert format_axis_label(step, "x(t - tau_d)") == r"$x(t - \tau_{d})$ (m/s$^{2}$)"
    assert format_axis_label(step, "period") == "period (s)"
    assert format_axis_label(step, "h_GR") == r"$h_{\mathrm{GR}}$"
    assert find_unit({}, "x") == ""
    assert format_unit("$") == r"\$"


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("contact_time", r"$\mathit{contact\ time}$"),
        ("x_1", "$x_{1}$"),
        ("x1", "$x_{1}$"),
        ("omega", r"$\omega$"),
        ("tau2", r"$\tau_{2}$"),
        ("top", r"$\mathit{top}$"),
        ("a_b_c", r"$\mathit{a\ b\ c}$"),
        ("error_estimate", "error estimate"),
        ("x(t - tau)", r"$x(t - \tau)$"),
        ("x(t - tau - T)", "x(t - tau - T)"),
    ],
)
def test_a_name_is_written_as_mathematics_or_in_words(name, text):
    assert format_name(name) == text


@settings(max_examples=50, deadline=None)
@given(NAMES)
def test_every_name_that_a_file_may_hold_can_be_set(name):
    MathTextParser("path").parse(format_name(name))
