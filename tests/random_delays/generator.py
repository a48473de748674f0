"""Random models with delays of every kind by seed: ``draw_model(seed)``; smooth ones and ones with events."""

from __future__ import annotations

from tests.random_delays.terms import Parts, draw_lag, draw_terms, read_late
from tests.random_models.draw import Draw
from tests.random_models.formula import States, call, name
from tests.random_models.random_model import RandomModel, Segment


def draw_model(seed):
    """Return the model of a seed; the families take turns."""
    family = list(FAMILIES)[seed % len(FAMILIES)]
    draw = Draw(seed)
    parts, fields = FAMILIES[family](draw)
    free = draw.one_of([p for p in parts.parameters if p[0] in "Kqtw" and p != "wall"])
    value = parts.parameters[free]
    return RandomModel(
        seed=seed,
        family=family,
        states=parts.states.names,
        parameters=parts.parameters,
        delays=(),
        free=free,
        span=tuple(sorted((round(0.9 * value, 6), round(1.1 * value, 6)))),
        period=2 * name("pi") / name("omega") if parts.forced else None,
        # Damping of 0.25 and more leaves 1e-11 of a start.
        settle=200.0,
        kinds=tuple(parts.kinds),
        **fields,
    )


def driven(draw, remembers=False):
    """Return the parts of a driven oscillator, and its force."""
    states = States(("x", "v"))
    parameters = {"omega": draw.between(0.8, 2.0), "A": draw.between(0.6, 1.2), "c": draw.between(0.25, 0.6)}
    parts = Parts(draw, states, parameters, forced=True, remembers=remembers)
    force = name("A") * call("cos", name("omega") * name("t")) - name("c") * states["v"] - states["x"]
    if draw.chance(0.4):
        force = force - parts.add("a", draw.between(0.1, 0.5)) * states["x"] ** 3
    return parts, force + draw_terms(parts)


def smooth_driven(draw):
    """A driven oscillator with late forces."""
    parts, force = driven(draw, remembers=True)
    flow = {"x": parts.states["v"], "v": force}
    return parts, {"modes": {"m": flow}, "initial": {"x": 0.1, "v": 0.0}}


def late_feedback(draw):
    """Negative feedback by a lag that varies, with other late terms: it oscillates by itself."""
    states = States(("x",))
    parts = Parts(draw, states, {"k": draw.between(0.2, 0.8)}, forced=False, remembers=False)
    lag = draw_lag(parts, 1.5, 2.5)
    gain = parts.add("g", draw.between(2.0, 3.0))
    flow = 0 - name("k") * states["x"] - gain * call("tanh", read_late(parts, "x", lag)) + draw_terms(parts, 0.05, 0.2)
    return parts, {"modes": {"m": {"x": flow}}, "initial": {"x": 0.5}}


def hard_wall(draw):
    """A driven oscillator with late forces that strikes a wall."""
    parts, force = driven(draw)
    x, v = parts.states["x"], parts.states["v"]
    parts.parameters |= {"wall": draw.between(0.0, 0.6), "r": draw.between(0.3, 0.8)}
    return parts, {
        "modes": {"free": {"x": v, "v": force}},
        "initial": {"mode": "free", "x": -0.1, "v": 0.0},
        "events": {"hit": x - name("wall")},
        "resets": {"bounce": {"v": -1 * name("r") * v}},
        "segments": {"flight": Segment("free", "hit", "rising", "bounce", "free")},
    }


def soft_wall(draw):
    """A driven oscillator with late forces and an elastic wall."""
    parts, force = driven(draw)
    x, v = parts.states["x"], parts.states["v"]
    parts.parameters |= {"wall": draw.between(0.0, 0.5), "stiff": draw.between(2.0, 10.0)}
    push = name("stiff") * (x - name("wall"))
    return parts, {
        "modes": {"free": {"x": v, "v": force}, "touch": {"x": v, "v": force - push}},
        "initial": {"mode": "free", "x": -0.1, "v": 0.0},
        "events": {"contact": x - name("wall")},
        "segments": {
            "rise": Segment("free", "contact", "rising", None, "touch"),
            "leave": Segment("touch", "contact", "falling", None, "free"),
        },
    }


def late_relay(draw):
    """A relay that sees its output by a lag that varies, with other late terms."""
    states = States(("x",))
    parameters = {"k": draw.between(-0.2, 0.5), "up": draw.between(0.6, 1.4), "down": draw.between(0.6, 1.4)}
    parts = Parts(draw, states, parameters, forced=False, remembers=False)
    seen = read_late(parts, "x", draw_lag(parts, 0.8, 2.0))
    flow = draw_terms(parts, 0.05, 0.15) - name("k") * states["x"]
    return parts, {
        "modes": {"rises": {"x": flow + name("up")}, "falls": {"x": flow - name("down")}},
        "initial": {"mode": "rises", "x": -0.5},
        "events": {"seen": seen},
        "segments": {
            "above": Segment("rises", "seen", "rising", None, "falls"),
            "below": Segment("falls", "seen", "falling", None, "rises"),
        },
    }


FAMILIES = {f.__name__: f for f in (smooth_driven, hard_wall, late_feedback, soft_wall, late_relay)}
SMOOTH = ("smooth_driven", "late_feedback")
