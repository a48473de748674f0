"""Where a branch starts: an orbit, a special point, the other branch at a special point, the orbits after a grazing."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pddecont.bifurcation import grazing, torus
from pddecont.bifurcation.branch_start import BranchStart, StartError, start_branch
from pddecont.bifurcation.extended_system import DefiningFunction, ExtendedEvaluation, extend_system
from pddecont.bifurcation.grazing import DOUBLE_GRAZING, GRAZING_TWICE
from pddecont.bifurcation.kinds import CROSSINGS
from pddecont.bifurcation.registry import find_kind, list_kinds
from pddecont.bifurcation.settings import BranchSettings
from pddecont.bifurcation.signature_insertion import enter_signature
from pddecont.continuation import CurvePoint, NewtonSettings, correct, solve_adaptively, tangent_at
from pddecont.errors import SignatureError
from pddecont.orbit import Orbit, OrbitEvaluation, is_rotation, solve_orbit
from pddecont.reasons import NO_REASON, Reason

Array = NDArray[np.float64]
# A parameter that hardly moves along a curve, compared with the other, does not tell which way is forward.
STILL = 1e-6


def start_other_branch(orbit: Orbit, kind: str, tangent: Array, settings: BranchSettings) -> BranchStart:
    """Return the start of the other branch at a special point of ``kind``.

    Raises
    ------
    StartError
        If no other branch is switched to at such points.
    ConvergenceError
        If it is not found.
    """
    found = find_kind(kind)
    if found is None or found.switch is None:
        able = " or ".join(k.label for k in list_kinds() if k.switch is not None)
        raise StartError(f"'branch: switch' starts from a {able} point, not from {name_point(kind)}")
    return found.switch(orbit, tangent, settings)


def start_after_grazing(orbit: Orbit, kind: str, signature: Sequence[str], settings: BranchSettings) -> BranchStart:
    """Return the start of the branch with another signature at a grazing point.

    Raises
    ------
    SignatureError
        If the point is no grazing, or leads to another signature than the one asked for.
    ConvergenceError
        If the orbit is not found.
    """
    asked = f"asks for the signature [{', '.join(signature)}]"
    if kind != grazing.LABEL:
        raise SignatureError(
            f"{asked}, but its start runs through [{', '.join(orbit.signature.names)}]; another signature begins at a "
            "GR point"
        )
    system, orbit = settings.make_system(orbit)
    point = enter_signature(system.at(orbit.x), settings.rule)
    found = point.at.orbit.signature.names
    if not is_rotation(found, signature):
        raise SignatureError(f"{asked}, but the grazing leads to [{', '.join(found)}]")
    return BranchStart(point, one_way=True)


def start_curve(
    orbit: Orbit, label: str, reason: Reason, settings: BranchSettings, found_on: tuple[str, Reason] = ("", NO_REASON)
) -> BranchStart:
    """Return the start of the curve of special points in two parameters through one with a ``label``.

    From a point of a curve at which it meets another, that one goes on; ``found_on`` is the kind of the curve and what
    it follows. Where it begins there it goes one way.

    Raises
    ------
    StartError
        If no curve of such points is followed.
    ConvergenceError
        If the special point is not found.
    """
    other = find_other_kind(label, found_on[0])
    if other == found_on[0] != "" and reason.code != GRAZING_TWICE:
        raise StartError(f"the {label} point does not say what grazes there; follow the curve that it is on anew")
    kind = other or label
    inner, orbit = settings.make_system(orbit)
    known = reason if label in (kind, DOUBLE_GRAZING.label) else NO_REASON
    defining = define_special_point(inner.at(orbit.x), kind, known, settings)
    system, solution = solve_adaptively(
        extend_system(inner, defining),
        orbit.x,
        lambda on_mesh, x, _: correct(on_mesh, x, on_mesh.at(x).direction_along(), NewtonSettings()),
    )
    direction = tangent_at(solution, system.scaling, solution.at.direction_along())
    moves = direction[system.problem.unknowns.free] / np.array(settings.widths)
    forward = next((float(np.sign(m)) for m in moves if abs(m) > STILL * np.max(np.abs(moves))), 1.0)
    side = 0.0
    if other and is_boundary(found_on[0]):
        boundary = (found_on[0], grazing.exchange(reason)) if reason.code == GRAZING_TWICE else found_on
        side = _find_side_of_motions(solution.at, direction, boundary, settings)
    elif other and label != DOUBLE_GRAZING.label:
        side = torus.find_side_with_pair(system, solution.x, direction)
    return BranchStart(CurvePoint(system, solution.at, None, (side or forward) * direction), kind, one_way=bool(side))


def _find_side_of_motions(
    at: ExtendedEvaluation, direction: Array, boundary: tuple[str, Reason], settings: BranchSettings
) -> float:
    """Return on which side (1 or -1 times ``direction``) of a curve of grazings and the like orbits are motions.

    0 where they are on both.
    """
    kind, reason = boundary
    found = find_kind(kind)
    assert found is not None, "it was followed"
    own = define_special_point(at.inner, kind, reason, settings)
    sign = found.good_side(own)
    if sign is None:
        return 0.0
    (rate,) = extend_system(at.inner.system, own).at(at.x).rates_along(direction[None])
    return float(np.sign(sign * rate))


def find_other_kind(label: str, found_on: str) -> str:
    """Return the kind of the curve that meets one of the kind ``found_on`` in a point with a ``label``; "" if none."""
    kind = find_kind(label)
    meets = list(kind.meets) if kind is not None and found_on else []
    if found_on in meets:
        meets.remove(found_on)
    return meets[0] if meets else ""


def is_boundary(label: str) -> bool:
    """Return whether a curve of special points bounds where its orbits are motions: beyond it others take their place.

    There no multiplier is on the unit circle by the point's nature.
    """
    kind = find_kind(label)
    return kind is not None and kind.crossings == CROSSINGS


def define_special_point(at: OrbitEvaluation, kind: str, reason: Reason, settings: BranchSettings) -> DefiningFunction:
    """Return what defines the special point of ``kind`` at an orbit.

    Raises
    ------
    StartError
        If no curve of such points is followed.
    ConvergenceError
        If the orbit is no such point.
    """
    found = find_kind(kind)
    if found is None or found.define is None:
        able = [k.label for k in list_kinds() if k.define is not None]
        raise StartError(
            f"it has two free parameters: it follows a special point ({', '.join(able[:-1])} or {able[-1]}) and cannot "
            f"start from {name_point(kind)}"
        )
    return found.define(at, settings, reason)


def start_on_orbit(guess: Orbit, settings: BranchSettings) -> BranchStart:
    """Return the start of the branch through the orbit near ``guess``.

    Raises
    ------
    ConvergenceError
        If there is none.
    """
    return start_branch(solve_orbit(guess, settings.rule).at.orbit, settings)


def name_point(kind: str) -> str:
    """Return how a point of ``kind`` is called."""
    return f"a {kind} point" if kind else "an ordinary point"
