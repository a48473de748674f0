"""Sizes of pictures as a person gives them: the width of a journal's column, or width and height."""

from __future__ import annotations

import re
from dataclasses import dataclass

from pddecont.errors import ResultsError

# Of an inch; without a unit millimetres are meant.
UNITS = {"mm": 1 / 25.4, "cm": 1 / 2.54, "in": 1.0, "pt": 1 / 72}
# In inches: there is nothing to see in smaller ones, and no room in memory for larger ones.
SMALLEST, LARGEST = 1.0, 60.0
# Pictures narrower than this have the letters of journals.
JOURNAL_WIDTH = 5.2
_SIZE = re.compile(r"\s*(\d+(?:\.\d+)?)\s*(mm|cm|in|pt)?\s*(?:[xX×]\s*(\d+(?:\.\d+)?)\s*(mm|cm|in|pt)?\s*)?")


@dataclass(frozen=True)
class PictureSize:
    """A picture's width and height in inches; of height 0 it has the proportions that the view gives it."""

    width: float
    height: float = 0.0


def read_size(text: str) -> PictureSize:
    """Return the size that a text such as ``85mm`` or ``17cm x 6cm`` gives.

    Raises
    ------
    ResultsError
        If it is none, or one of a picture that cannot be.
    """
    found = _SIZE.fullmatch(text)
    if found is None:
        raise ResultsError(f"--size {text}: expected a width such as 85mm, or width and height such as 170x60mm")
    width, unit, height, other = found.groups()
    # 170x60mm: the unit stands once, for both.
    factor = UNITS[unit or other or "mm"]
    size = PictureSize(float(width) * factor, float(height) * UNITS[other or unit or "mm"] if height else 0.0)
    for length in (size.width, size.height or size.width):
        if not SMALLEST <= length <= LARGEST:
            raise ResultsError(
                f"--size {text}: expected between {SMALLEST * 25.4:.0f} and {LARGEST * 25.4:.0f} mm each way"
            )
    return size
