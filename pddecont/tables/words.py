"""Words for what files hold as data: kinds of special points, and reasons by their codes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeAlias

from pddecont.errors import ResultsError
from pddecont.reasons import NEUTRAL, WITHIN, Reason, Scalar
from pddecont.results import Step
from pddecont.simulate import FailureReason, describe_failure, failure_from_reason

Values: TypeAlias = Mapping[str, Scalar]
# Names of kinds in files of format 2, which do not say them.
OLD_KIND_NAMES = {
    "GR": "grazing",
    "LP": "fold",
    "PD": "period doubling",
    "TR": "torus",
    "BP": "branch point",
    "VS": "vanishing segment",
    "UF": "user function",
    "CP": "cusp",
    "R1": "resonance 1:1",
    "R2": "resonance 1:2",
    "R3": "resonance 1:3",
    "R4": "resonance 1:4",
    "FF": "fold-flip",
    "FT": "fold-torus",
    "PT": "flip-torus",
    "TT": "double torus",
    "GG": "double grazing",
    "GL": "grazing with multiplier 1",
    "GP": "grazing with multiplier -1",
    "GT": "grazing with multipliers on the unit circle",
}
END_POINT = {"EP": "end point"}
MOTION_FAILURES = {failure.value for failure in FailureReason}
# Why an attractor has no Lyapunov exponent; its cause is a failure of the motion.
NO_EXPONENT = "no exponent"
_WORDS: dict[str, Callable[[Values], str]] = {
    "user_function": lambda v: str(v["name"]),
    "tangential": lambda v: "event turns tangential",
    "meeting": lambda v: f"{v['event']} meets {v['other']}",
    "released": lambda v: f"the impacts at {v['event']} accumulate just as {v['segment']} releases the motion",
    "vanishing": lambda v: f"{v['segment']} vanishes",
    "hopf_normal_form": lambda v: (
        f"{v['nature']}, frequency {v['frequency']:.8g}, l1 = {v['coefficient']:.5g}; orbits at {v['side']} "
        f"{v['parameter']}"
    ),
    "linear_hopf": lambda v: f"frequency {v['frequency']:.8g}, l1 = 0: the equations are linear to the third order",
    "homoclinic": lambda v: "curves of folds, Hopf points and homoclinic orbits meet here",
    "fold_normal_form": lambda v: f"quadratic coefficient {v['coefficient']:.5g}",
    "boundary_equilibrium": lambda v: (
        (f"{v['nature']}: " if v.get("nature") else "") + f"on the surface of event '{v['event']}'"
    ),
    "halves_equal": lambda v: "halves become equal",
    "grazing": lambda v: "grazing",
    "grazing_twice": lambda v: f"{v['event']} and {v['own_event']}",
    "hopf_point": lambda v: f"Hopf point{_name_where(v)}",
    "hopf_beyond_range": lambda v: f"their Hopf point lies just beyond the range{_name_where(v)}",
    "hopf_not_located": lambda v: f"no Hopf point was located there: {v['why']}",
    "grows": lambda v: f"{_name_growing(v)} grows without bound, {v['value']:.8g} here, while {_name_limits(v)}",
    "kind": lambda v: str(v["kind"]),
    "range": lambda v: f"{v['parameter']} = {v['value']:.8g}",
    "segment_vanishes": lambda v: f"segment {v['number']} ({v['segment']}) vanishes",
    "reads_future": lambda v: (
        f"delay '{v['delay']}' is {v['lag']:.6g} here: the equations would read the future, and have no roots"
    ),
    "negative_delay": lambda v: f"delay '{v['delay']}' becomes negative beyond {_name_places(v)}",
    "no_duration": lambda v: f"segment {v['number']} ({v['segment']}) has duration {v['duration']:.3g}",
    "crossed_backwards": lambda v: f"{_name_crossing(v)} is crossed {v['crossed']} at its end, not {v['listed']}",
    "drifts": lambda v: f"{_name_segment(v)}: the simulation from the orbit's own past ends elsewhere",
    "missing": lambda v: f"{_name_segment(v)}: its event '{v['event']}' does not happen",
    "happens": lambda v: (
        f"{_name_segment(v)}: event '{v['event']}' happens there, at {v['time']:.8g} after the orbit's start "
        f"('{v['instead']}')"
    ),
    "guard": lambda v: f"{_name_segment(v)}: its condition {v['condition']} does not hold",
    "slides": lambda v: (
        f"{_name_segment(v)}: beyond event '{v['event']}' the flow leads straight back: both fields point at its "
        "surface, and the motion slides along it"
    ),
    "repels": lambda v: (
        f"{_name_segment(v)}: after its event, {v['time']:.8g} after the orbit's start, the orbit is on the surface "
        f"{v['surface']} = 0 of switch '{v['switch']}', and both fields point away from it (its rate is "
        f"{v['below']:.6g} below and {v['above']:.6g} above): nothing decides on which side it goes on"
    ),
    "halts": lambda v: (
        f"{_name_segment(v)}: the motion comes to a halt ({v['why']}{_name_part(' at event', v['event'])}"
        f"{_name_part(' in mode', v['mode'])})"
    ),
    "no_time": lambda v: "one of its segments takes no time, or its period is not positive",
    "too_many_steps": lambda v: "its simulation takes too many steps",
    "also_crossed": lambda v: f"{_name_crossing(v)} is also crossed {v['crossed']} inside",
}


def describe_reason(reason: Reason) -> str:
    """Return a reason in words; empty for none, and the bare data for a code that has no words.

    Raises
    ------
    ResultsError
        If what belongs to the reason is not there.
    """
    if not reason:
        return ""
    try:
        within = f" (located only within {reason.values[WITHIN]:.2%} of a step)" if WITHIN in reason.values else ""
        words = [] if reason.code == NEUTRAL else [_describe(reason) + within]
        return "; ".join(words + ([describe_neutral(reason.values[NEUTRAL])] if NEUTRAL in reason.values else []))
    except (KeyError, TypeError, ValueError, OverflowError) as exc:
        raise ResultsError(
            f"what belongs to the reason '{reason.code[:40]}' is not there; the file is damaged"
        ) from exc


def describe_neutral(radius: Scalar) -> str:
    """Return what it means for roots that past rates have coefficients near one, or larger ones."""
    if float(radius) >= 1.0:
        return (
            f"the coefficients of delayed rates come to {float(radius):.6g} together, not below 1: infinitely many "
            "characteristic roots may lie to the right of the imaginary axis, and no count of them is made"
        )
    return (
        f"the coefficients of delayed rates come to {float(radius):.6g} together, near 1: infinitely many "
        "characteristic roots lie next to the imaginary axis, and small changes of parameters may put them to its right"
    )


def _describe(reason: Reason) -> str:
    if "text" in reason.values:
        return str(reason.values["text"])
    if reason.code in _WORDS:
        return _WORDS[reason.code](reason.values)
    if reason.code in MOTION_FAILURES:
        return describe_failure(failure_from_reason(reason))
    if reason.code == NO_EXPONENT:
        cause = str(reason.values["cause"])
        if cause == NO_EXPONENT:
            raise ValueError("it is its own cause")
        return f"no Lyapunov exponent: {_describe(Reason(cause, reason.values))}"
    values = ", ".join(f"{name} = {value}" for name, value in reason.values.items())
    return f"{reason.code.replace('_', ' ')}{f' ({values})' if values else ''}"


def register_words(code: str, describe: Callable[[Values], str]) -> None:
    """Give words to reasons of a code."""
    _WORDS[code] = describe


def name_kind(step: Step, kind: str) -> str:
    """Return what people call a kind of special point, as the step's file says it; the label where it does not."""
    return str({**END_POINT, **OLD_KIND_NAMES, **step.meta.get("kinds", {})}.get(kind, kind))


def _name_places(values: Values) -> str:
    places = {name.removeprefix("at "): value for name, value in values.items() if name.startswith("at ")}
    return ", ".join(f"{name} = {value:.8g}" for name, value in places.items())


def _name_growing(values: Values) -> str:
    return f"the {values['what']}{_name_part('', values['name'])}"


def _name_limits(values: Values) -> str:
    """Return the limits of the parameters with their errors."""
    limits = {name.removeprefix("limit "): value for name, value in values.items() if name.startswith("limit ")}
    return " and ".join(f"{name} tends to {v:.12g} (+-{values[f'error {name}']:.0e})" for name, v in limits.items())


def _name_segment(values: Values) -> str:
    return f"segment {values['number']} ({values['segment']})"


def _name_part(what: str, name: Scalar) -> str:
    return f"{what} '{name}'" if name else ""


def _name_where(values: Values) -> str:
    places = _name_places(values)
    return f", {places}" if places else ""


def _name_crossing(values: Values) -> str:
    return f"segment {values['number']} ({values['segment']}): event '{values['event']}'"


def forget_words(code: str) -> None:
    """Forget words that :func:`register_words` gave."""
    _WORDS.pop(code, None)
