"""Numbers in engineering form."""

import numpy as np
import pytest

from pddecont.plot.engineering import count_decimals, find_exponent, use_engineering_form, write_number


@pytest.mark.parametrize(
    ("largest", "exponent"),
    [(0, 0), (0.02, 0), (0.005, -3), (9e-7, -9), (1e-6, -6), (5e4, 0), (1e5, 3), (1e6, 6), (-3e7, 6), (np.inf, 0)],
)
def test_the_power_is_a_multiple_of_three(largest, exponent):
    assert find_exponent([0.0, largest]) == exponent


@pytest.mark.parametrize(("values", "n"), [([0, 1, 2], 0), ([0, 0.5], 1), ([0.05, 0.1, 0.15], 2), ([0.1 + 0.2], 1)])
def test_no_more_decimals_than_tell_them_apart(values, n):
    assert count_decimals(values) == n


@pytest.mark.parametrize("scale", [1e-9, 1e-4, 1.0, 300.0, 1e6])
def test_what_ticks_say_is_where_they_stand(axes, scale):
    axes.plot([-1.3 * scale, 2.7 * scale], [0, 1])
    use_engineering_form(axes.figure)
    axes.figure.draw_without_rendering()
    offset = axes.xaxis.get_offset_text().get_text()
    power = int(offset.split("{")[-1].rstrip("}$")) if offset else 0
    assert power % 3 == 0
    said = [float(tick.get_text().replace("\N{MINUS SIGN}", "-")) * 10.0**power for tick in axes.get_xticklabels()]
    assert said == pytest.approx(list(axes.get_xticks()), abs=1e-6 * scale)
    assert all(len(tick.get_text()) <= 6 for tick in axes.get_xticklabels())


def test_what_differs_by_rounding_only_keeps_its_offset(axes):
    axes.plot([1.0, 1.0 + 1e-9], [0, 1])
    before = axes.xaxis.get_major_formatter()
    use_engineering_form(axes.figure)
    assert axes.xaxis.get_major_formatter() is before


def test_a_number_in_a_title():
    assert write_number(0.3) == "0.3"
    assert write_number(-1.070844e-7) == "\N{MINUS SIGN}107.084 $\\cdot$ 10$^{-9}$"
