"""Every view there is: what ``pddecont plot`` and reports offer stands here and nowhere else.

A new view is a module in ``pddecont/plot/views`` with a ``DRAWING``, and an entry here.
"""

from __future__ import annotations

from pddecont.plot.view import View

VIEWS: dict[str, View] = {}
# Of the kinds of steps that a file holds one of the last of these is drawn when neither a step nor a view is named.
KINDS_BY_INTEREST = (
    ("simulate",),
    ("equilibrium",),
    ("orbit",),
    ("basin",),
    ("continue", "equilibria"),
    ("sweep",),
    ("precision",),
    ("explore",),
)


def register_view(view: View) -> None:
    """Add a view, in place of one of the same name."""
    VIEWS[view.name] = view


def forget_view(name: str) -> None:
    """Forget a view that :func:`register_view` added."""
    VIEWS.pop(name, None)


register_view(
    View(
        "diagram",
        "branches of orbits and equilibria over their parameter, with phase plots of special points",
        "pddecont.plot.views.diagram:DRAWING",
        places={"continue": 0, "curve": 1, "equilibrium": 0, "equilibria": 0, "equilibrium_curve": 1},
        together=("continue", "curve", "equilibrium", "equilibria", "equilibrium_curve"),
    )
)
register_view(
    View(
        "plane",
        "curves of special points in two parameters, and the branches that they start from",
        "pddecont.plot.views.plane:DRAWING",
        places={"curve": 0, "equilibrium_curve": 0},
        together=("curve", "equilibrium_curve"),
    )
)
register_view(
    View(
        "manifold",
        "branches and such curves in three dimensions",
        "pddecont.plot.views.manifold:DRAWING",
        places={"continue": 4, "curve": 2, "equilibria": 2, "equilibrium_curve": 3},
        together=("continue", "curve", "equilibria", "equilibrium_curve"),
        in_overview=True,
    )
)
register_view(
    View(
        "multipliers",
        "Floquet multipliers in the complex plane",
        "pddecont.plot.views.multipliers:DRAWING",
        places={"orbit": 2, "continue": 3, "curve": 5},
    )
)
register_view(
    View(
        "roots",
        "characteristic roots of equilibria in the complex plane",
        "pddecont.plot.views.roots:DRAWING",
        places={"equilibrium": 1, "equilibria": 1, "equilibrium_curve": 2},
    )
)
register_view(
    View(
        "orbit",
        "orbits in the plane of two states",
        "pddecont.plot.views.orbit:DRAWING",
        places={"orbit": 0, "continue": 1, "curve": 3},
        together=("orbit",),
    )
)
register_view(
    View(
        "profile",
        "states over one period",
        "pddecont.plot.views.profile:DRAWING",
        places={"orbit": 1, "continue": 2, "curve": 4},
    )
)
register_view(View("trajectory", "a simulation", "pddecont.plot.views.trajectory:DRAWING", places={"simulate": 0}))
register_view(
    View(
        "sweep",
        "a brute-force diagram: returns over a parameter, with branches in it and Lyapunov exponents below it",
        "pddecont.plot.views.sweep:DRAWING",
        places={"sweep": 0},
        together=("sweep",),
    )
)
register_view(
    View(
        "explore",
        "a whole diagram: all branches that were found, and in grey where motions settled",
        "pddecont.plot.views.explore:DRAWING",
        places={"explore": 0},
    )
)
register_view(
    View(
        "basin",
        "the map of basins of attraction",
        "pddecont.plot.views.basin:DRAWING",
        places={"basin": 0},
        together=("basin",),
    )
)
register_view(
    View(
        "precision",
        "error against CPU time and unknowns, with slopes",
        "pddecont.plot.views.precision:DRAWING",
        places={"precision": 0},
    )
)
register_view(
    View(
        "distance",
        "how far chains are from the delay equation, over N",
        "pddecont.plot.views.distance:DRAWING",
        places={"precision": 1},
        together=("precision",),
    )
)
register_view(
    View(
        "points",
        "points of steps that have no view of their own",
        "pddecont.plot.views.points:DRAWING",
        is_default=True,
    )
)
register_view(
    View(
        "animate",
        "the orbit moving along a branch, beside a mark on the diagram",
        "pddecont.plot.views.animate:DRAWING",
        places={"continue": 5, "curve": 6},
        is_moving=True,
    )
)
