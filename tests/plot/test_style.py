"""Colours and markers."""

import numpy as np
import pytest
from matplotlib.colors import to_hex, to_rgb

from pddecont.bifurcation import list_kinds
from pddecont.equilibrium import CURVE_NAMES, NAMES
from pddecont.plot.style import (
    COLOURS,
    CURVE_COLOURS,
    EQUILIBRIUM_COLOURS,
    OTHER_CURVE_COLOUR,
    OTHER_MARKER,
    find_curve_colour,
    find_marker,
    make_palette,
)


def test_colours_are_distinct():
    assert len({to_hex(c) for c in COLOURS}) == len(COLOURS)
    of_curves = [*CURVE_COLOURS.values(), *EQUILIBRIUM_COLOURS.values(), OTHER_CURVE_COLOUR]
    assert len({to_hex(c) for c in of_curves}) == len(of_curves)


@pytest.mark.parametrize("n", [0, 3, 9, 13, 20, 30])
def test_colours_beyond_the_palette_are_like_none_of_it(n):
    palette = make_palette(n)
    assert tuple(palette[: len(COLOURS)]) == COLOURS[:n]
    colours = np.array([to_rgb(c) for c in palette]).reshape(n, 3)
    gaps = np.linalg.norm(colours[:, None] - colours, axis=-1) + 9 * np.eye(n)
    assert np.all(gaps > 0.05)


def test_every_kind_has_its_own_marker():
    kinds = list({*(kind.label for kind in list_kinds()), *NAMES, *CURVE_NAMES})
    assert len({find_marker(kind) for kind in kinds}) == len(kinds)
    assert find_marker("nothing") == OTHER_MARKER
    assert find_curve_colour("nothing") == find_curve_colour("") == OTHER_CURVE_COLOUR
