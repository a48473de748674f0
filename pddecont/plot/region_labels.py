"""Texts inside regions of a plane: where a region is widest, with a rim that keeps them readable on every colour."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pddecont.plot.style import LABEL_SHARE, scale_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]
# Cells of a plane along each axis in which regions are looked for.
CELLS = 80
# Places of one class that a region holds at least, if it has a label.
FEWEST_PLACES = 4


def find_inside(image: NDArray[np.bool_]) -> tuple[int, int]:
    """Return the row and column of a cell of an ``image`` that is furthest inside its cells, ties by the first."""
    from scipy.ndimage import distance_transform_edt

    distances = distance_transform_edt(np.pad(image, 1))[1:-1, 1:-1]
    row, column = np.unravel_index(int(np.argmax(distances)), image.shape)
    return int(row), int(column)


def write_in_region(axes: Axes, text: str, x: float, y: float) -> None:
    """Write a text at a place of a picture, centred."""
    from matplotlib.patheffects import withStroke

    rim = [withStroke(linewidth=2.5, foreground="white")]
    axes.text(
        x, y, text, ha="center", va="center", fontsize=scale_text(LABEL_SHARE), path_effects=rim, clip_on=True, zorder=4
    )


def label_regions(axes: Axes, places: Mapping[str, Array]) -> list[tuple[str, float, float]]:
    """Write the name of each class into the regions in which its places lie, and return what is written where.

    A region is where the nearest place, distances as they are in the picture, is of that class.

    Parameters
    ----------
    places
        Of each class the places that are known, shape (n, 2), in the axes' units.
    """
    found = find_regions(places, (*axes.get_xlim(), *axes.get_ylim()))
    for name, x, y in found:
        write_in_region(axes, name, x, y)
    return found


def find_regions(
    places: Mapping[str, Array], limits: tuple[float, float, float, float]
) -> list[tuple[str, float, float]]:
    """Return the name of each region that holds enough places, with the place furthest inside it.

    ``limits`` are those of the plane: left, right, lower, upper.
    """
    from scipy.ndimage import label
    from scipy.spatial import cKDTree

    corner, size = np.array([limits[0], limits[2]]), np.array([limits[1] - limits[0], limits[3] - limits[2]])
    names = [name for name, own in places.items() for _ in own]
    if not names:
        return []
    known = (np.vstack([own for own in places.values() if len(own)]) - corner) / size
    middles = (np.arange(CELLS) + 0.5) / CELLS
    grid = np.stack(np.meshgrid(middles, middles), axis=-1)
    nearest = cKDTree(known).query(grid.reshape(-1, 2))[1].reshape(CELLS, CELLS)
    cells = np.clip((known * CELLS).astype(int), 0, CELLS - 1)
    regions = []
    for name in places:
        own = np.array([other == name for other in names])
        numbered, n = label(own[nearest])
        held = numbered[cells[own, 1], cells[own, 0]]
        for k in range(1, n + 1):
            if np.count_nonzero(held == k) >= FEWEST_PLACES:
                row, column = find_inside(numbered == k)
                regions.append((name, *(corner + size * [middles[column], middles[row]]).tolist()))
    return regions


def number_long_names(names: Sequence[str], longest: int) -> dict[str, str]:
    """Return what is written for each name: itself, or its number where one has more letters than ``longest``."""
    if max(map(len, names), default=0) <= longest:
        return {name: name for name in names}
    return {name: str(k) for k, name in enumerate(names, 1)}
