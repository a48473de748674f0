"""What a results file looks like inside (design section 5.5).

    format_version                                 root attribute
    /versions, /source                             what made the file (JSON), and from which file
    /model, /run                                   the texts as they were read
    /steps/<name>/kind, /steps/<name>/meta         kind of step; names and settings (JSON)
    /steps/<name>/finished                         number of finished rows
    /steps/<name>/termination                      one text a direction
    /steps/<name>/points/<column>                  one row a point
    /steps/<name>/orbits/<column>                  rows of all points one after another ...
    /steps/<name>/orbits/<column>_end              ... and where each point's rows end
    /steps/<name>/special_points/{label, index}    written when the step is done

Rows beyond ``finished`` are room for points to come and hold nothing; a step that is closed has none.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

FORMAT_VERSION = 2
TEXT_BYTES = 1000
N_TERMINATIONS = 4
# The kind of step that has special points.
BRANCH = "continue"


@dataclass(frozen=True)
class Column:
    """One array of a step: element type and the shape of one row."""

    dtype: str
    shape: tuple[int, ...] = ()


@dataclass(frozen=True)
class StepSpec:
    """The arrays of one step.

    ``points`` has one row a point; each of ``orbits`` any number of rows a point. ``meta`` is anything JSON can hold:
    names of parameters, monitors and states, settings.
    """

    name: str
    kind: str
    points: Mapping[str, Column]
    orbits: Mapping[str, Column] = field(default_factory=dict)
    meta: Mapping[str, Any] = field(default_factory=dict)

    def meta_text(self) -> str:
        """Return ``meta`` as JSON with keys in a fixed order."""
        return json.dumps(self.meta, sort_keys=True)
