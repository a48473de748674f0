"""The program's own kinds of special points, in the order in which they are listed and tested."""

from __future__ import annotations

from pddecont.bifurcation.branch_point import BRANCH_POINT
from pddecont.bifurcation.fold import CUSP, FOLD
from pddecont.bifurcation.grazing import DOUBLE_GRAZING, GRAZING
from pddecont.bifurcation.guard import GUARD
from pddecont.bifurcation.hopf import HOPF_BIFURCATION, HOPF_HOPF
from pddecont.bifurcation.kinds import SpecialPointKind
from pddecont.bifurcation.motion_change import MOTION_CHANGE
from pddecont.bifurcation.period_doubling import PERIOD_DOUBLING
from pddecont.bifurcation.sliding import SLIDING
from pddecont.bifurcation.torus import RESONANCES, TORUS
from pddecont.bifurcation.user_function import USER_FUNCTION
from pddecont.bifurcation.vanishing import VANISHING

# Points on curves that counts of multipliers tell: one more multiplier +1, -1 or a pair on the unit circle.
COUNTED = tuple(
    SpecialPointKind(label, name, on_curves=True, needs_multipliers=True, meets=tuple(kind.label for kind in meets))
    for label, name, *meets in (
        ("FF", "fold-flip", FOLD, PERIOD_DOUBLING),
        ("FT", "fold-torus", FOLD, TORUS),
        ("PT", "flip-torus", PERIOD_DOUBLING, TORUS),
        ("TT", "double torus"),
        ("GL", "grazing with multiplier 1", FOLD),
        ("GP", "grazing with multiplier -1", PERIOD_DOUBLING),
        ("GT", "grazing with multipliers on the unit circle", TORUS),
    )
)
BUILTIN = (
    FOLD,
    BRANCH_POINT,
    PERIOD_DOUBLING,
    TORUS,
    GRAZING,
    VANISHING,
    MOTION_CHANGE,
    GUARD,
    *SLIDING,
    USER_FUNCTION,
    HOPF_BIFURCATION,
    CUSP,
    *RESONANCES,
    HOPF_HOPF,
    *COUNTED,
    DOUBLE_GRAZING,
)
