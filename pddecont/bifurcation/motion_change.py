"""Motion change (MC): an orbit of its signature ceases to be a motion of the model.

Beyond such a point the equations of the signature still have a solution, but the model does something else: it slides
along a surface, an event happens that the signature does not list, or one that it lists does not. No test function
foresees it; the orbit's simulation from its own past says so, and the point is located by halving the step.
"""

from __future__ import annotations

from pddecont.bifurcation.kinds import SpecialPointKind

LABEL = "MC"
MOTION_CHANGE = SpecialPointKind(LABEL, "motion change", on_branches=True)
