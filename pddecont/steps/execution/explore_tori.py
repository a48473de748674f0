"""Tori followed by simulation: from the points at which they are born, over the parameter, as far as it goes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pddecont.errors import ConvergenceError
from pddecont.exploration import RecordedBranch, RotationNumber, Survey, find_rotation_number
from pddecont.results import Step
from pddecont.runfile import Plan
from pddecont.simulate import find_attractor, unpack_motion
from pddecont.steps.execution.attractor_restart import read_task
from pddecont.steps.execution.attractor_rows import attractor_from_row
from pddecont.steps.execution.explore_looks import Look, LookCode, name_irregular

Array = NDArray[np.float64]
# The kind of special point at which a torus is born.
TORUS = "TR"
# Parameter values over which a torus is followed from one point, and from a motion each way.
N_VALUES = 16
# The part of the way at which the first of them is: at a torus's birth it is as small as a point.
FIRST = 0.02
# What a torus may be, or become, beside a locked one.
WITHOUT_PERIOD = (LookCode.TORUS, LookCode.CHAOS, LookCode.IRREGULAR)
# How far from the orbit a motion begins, in parts of how far motions go: on it, it would stay there.
ASIDE = 0.02
# Returns from which a rotation number is taken; as many again are its way there.
N_RETURNS = 512


@dataclass(frozen=True, eq=False)
class TorusLead:
    """A torus to be followed: where it begins, from and to which value, and states at some time near to it."""

    step: str
    point: str
    begin: float
    end: float
    states: Mapping[str, float]

    @property
    def origin(self) -> str:
        """Where it begins in words of names: step and label."""
        return f"{self.step} {self.point}"


@dataclass(frozen=True, eq=False)
class TorusPoint:
    """What a torus has become at a value of the parameter, with its rotation number (None: it has none)."""

    origin: str
    look: Look
    rotation: RotationNumber | None


def list_torus_leads(branch: RecordedBranch, names: Sequence[str], scale: Array) -> Iterator[TorusLead]:
    """Yield the torus bifurcations of a branch of orbits with the stretch beyond on which it is not stable.

    ``scale`` is how far motions of the model go (n_states,).
    """
    step = branch.step
    if "roots" in step.format.orbits:
        return
    stable = step.points["stable"][branch.rows]
    for k, row in enumerate(branch.rows):
        if step.kind_of(int(row)) != TORUS or not 0 < k < len(stable) - 1 or {stable[k - 1], stable[k + 1]} != {0, 1}:
            continue
        way = 1 if stable[k + 1] == 0 else -1
        end = k + way
        while 0 < end < len(stable) - 1 and stable[end] == 0:
            end += way
        orbit = step.orbit(int(row))
        # A motion of a forced model begins at the time 0.
        period = float(step.points["period"][row])
        at = (-float(step.points["phase"][row])) % period
        on_orbit = [np.interp(at, orbit["time"], column) for column in orbit["states"].T]
        states = {name: float(x + ASIDE * d) for name, x, d in zip(names, on_orbit, scale, strict=True)}
        begin, last = float(branch.parameter[k]), float(branch.parameter[end])
        if begin != last:
            yield TorusLead(step.name, step.labels[row], begin, last, states)


def list_leads_of_motions(
    looks: Sequence[Look], plan: Plan, number: int, limits: tuple[float, float], read: Any
) -> Iterator[TorusLead]:
    """Yield motions on tori, to be followed to both ends of the range; ``read`` returns the step of a name."""
    for look in looks:
        if look.code != LookCode.TORUS:
            continue
        attractor = attractor_from_row(read(look.sweep), look.row)
        states = dict(zip(plan.model.states, attractor.states[-1].tolist(), strict=True))
        value = float(look.parameters[number])
        for end in limits:
            if end != value:
                yield TorusLead(look.sweep, look.point, value, end, states)


def plan_torus(
    sweep: Mapping[str, Any], lead: TorusLead, parameter: str, name: str, own: Sequence[str]
) -> dict[str, Any]:
    """Return a sweep like another whose one motion begins near a torus and is carried along to the end of its way."""
    body = {key: value for key, value in sweep["sweep"].items() if key != "random"}
    first = lead.begin + FIRST * (lead.end - lead.begin)
    low, high = sorted((first, lead.end))
    initial = {"history": "constant", **{state: lead.states[state] for state in own}}
    body |= {
        "over": {parameter: [low, high, N_VALUES]},
        "initial": [initial],
        "carry": "up" if first == low else "down",
    }
    return {**sweep, "name": name, "sweep": body}


def covers(points: Sequence[TorusPoint], lead: TorusLead, number: int, limits: tuple[float, float]) -> bool:
    """Return whether a torus was followed just beyond where another is to be followed from, on its way."""
    way, near = np.sign(lead.end - lead.begin), (limits[1] - limits[0]) / N_VALUES
    on_torus = [point for point in points if point.rotation is not None or point.look.code in WITHOUT_PERIOD]
    away = [way * (point.look.parameters[number] - lead.begin) for point in on_torus]
    return any(0.0 < one < near for one in away)


def look_at_torus(plan: Plan, recorded: Step, look: Look, origin: str, survey: Survey) -> TorusPoint:
    """Return what a torus has become at a value of a sweep; ``survey`` tells how far motions go."""
    named = name_irregular(plan, recorded, look, survey) if look.code == LookCode.IRREGULAR else look
    return TorusPoint(origin, named, measure_rotation(plan, recorded, named, survey.high - survey.low))


def measure_rotation(plan: Plan, recorded: Step, look: Look, scale: Array) -> RotationNumber | None:
    """Return the rotation number of a motion of a sweep on a torus, or locked to a period; None of any other."""
    attractor = attractor_from_row(recorded, look.row)
    if look.code == LookCode.PERIODIC and attractor.period > 0:
        return find_rotation_number(attractor.states, scale, is_periodic=True)
    if look.code != LookCode.TORUS or len(attractor.times) < 2:
        return None
    simulator = read_task(plan, recorded).make_simulator()
    settings = plan.find_step(recorded.name).settings.settling.make_return_settings(plan.numeric, attractor.p)
    between = float(np.mean(np.diff(attractor.times)))
    longer = replace(settings, transient=2.2 * N_RETURNS * between, n_kept=N_RETURNS, max_period=1)
    values = simulator.values(attractor.p)
    try:
        state = unpack_motion(simulator.reached, values, attractor.packed_state)
        found = find_attractor(simulator, values, state, longer)
    except (ConvergenceError, ValueError):
        return None
    return None if found.period else find_rotation_number(found.states, scale)
