"""Dist(N) of chains."""

import numpy as np
import pytest

from pddecont.plot.chain_distances import draw_distances


def test_distances_are_drawn_with_their_order(compared, axes):
    draw_distances(axes, compared.step("fine"), "title")
    [line] = axes.lines
    assert line.get_xydata() == pytest.approx(np.array([[4, 1 / 4], [8, 1 / 8], [16, 1 / 16], [32, 1 / 32]]))
    assert line.get_label() == "chain of order 1: p = 1.00"
    assert (axes.get_xscale(), axes.get_yscale(), axes.get_title()) == ("log", "log", "title")
