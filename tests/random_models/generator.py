"""Random models by seed: ``draw_model(seed)``. Each family is a function of a source of random numbers."""

from __future__ import annotations

from tests.random_models.draw import Draw, driven, feedback
from tests.random_models.formula import States, call, name
from tests.random_models.random_model import RandomModel, Segment


def draw_model(seed):
    """Return the model of a seed; the families take turns."""
    families = list(FAMILIES)
    family = families[seed % len(families)]
    draw = Draw(seed)
    fields = FAMILIES[family](draw)
    parameters = fields["parameters"]
    times = [p for p in parameters if p in (*fields["delays"], "lag", "lag2", "rest", "level", "wall")]
    named = times if draw.chance(0.5) else [p for p, value in parameters.items() if value]
    free = fields.pop("free", None) or draw.one_of(named)
    span = fields.pop("span", None) or draw.span(parameters[free])
    return RandomModel(seed=seed, family=family, free=free, span=span, **fields)


def hard_walls(draw, kicks=0.3):
    """Impacts on one wall or two, with resets that may read delayed states."""
    states, parameters, delays, force, period = driven(draw)
    x, v = states["x"], states["v"]
    parameters |= {"wall": draw.between(-0.1, 0.7), "r": draw.between(0.3, 0.85)}
    rebound = -1 * name("r") * v
    if draw.chance(0.35):
        parameters["q"] = draw.between(-0.12, 0.12)
        rebound = rebound + name("q") * states[draw.one_of(["x", "v"]), draw.one_of(list(delays))]
    events = {"hit": x - name("wall")}
    segments = {"flight": Segment("free", "hit", "rising", "bounce", "free")}
    if draw.chance(0.4):
        parameters["floor"] = draw.between(-0.9, -0.2) - max(0.0, -parameters["wall"])
        events["land"] = x - name("floor")
        segments["fall"] = Segment("free", "land", "falling", "bounce", "free")
    if draw.chance(kicks):
        _add_kick(draw, states, parameters, events, segments, "hit")
    resets = {"bounce": {"v": rebound}}
    if "kick" in events:
        resets["kicked"] = {"v": v + name("J")}
    return {
        "states": states.names,
        "parameters": parameters,
        "delays": tuple(delays),
        "period": period,
        "modes": {"free": {"x": v, "v": force}},
        "initial": {"mode": "free", "x": min(parameters["wall"], 0.0) - 0.05, "v": 0.0},
        "events": events,
        "resets": resets,
        "segments": segments,
    }


def _add_kick(draw, states, parameters, events, segments, source):
    """Let a delayed event follow another event: the kick that it brings is the reset 'kicked'."""
    parameters |= {"lag": draw.between(0.2, 1.5), "J": draw.signed(0.05, 0.3)}
    events["kick"] = (source, "lag")
    segments["struck"] = Segment("free", "kick", "any", "kicked", "free")


def soft_walls(draw):
    """Elastic walls that begin with a force or without one; contact may be felt a delay later."""
    states, parameters, delays, force, period = driven(draw)
    x, v = states["x"], states["v"]
    parameters |= {"wall": draw.between(-0.1, 0.6), "k": draw.between(2, 20)}
    push = name("k") * (x - name("wall"))
    if draw.chance(0.35):
        parameters["F"] = draw.between(0.02, 0.3)
        push = push + name("F")
    if draw.chance(0.35):
        parameters["b"] = draw.between(0.05, 0.4)
        push = push + name("b") * v
    late = draw.chance(0.25)
    felt = states["x", draw.one_of(list(delays))] if late else x
    if late:
        parameters["k"] = draw.between(0.2, 0.8)
    modes = {"free": {"x": v, "v": force}, "high": {"x": v, "v": force - push}}
    events = {"touch": felt - name("wall")}
    segments = {
        "rise": Segment("free", "touch", "rising", None, "high"),
        "leave": Segment("high", "touch", "falling", None, "free"),
    }
    if draw.chance(0.4):
        parameters |= {"floor": draw.between(-1.0, -0.3), "kf": draw.between(2, 12)}
        modes["low"] = {"x": v, "v": force - name("kf") * (x - name("floor"))}
        events["below"] = x - name("floor")
        segments["sink"] = Segment("free", "below", "falling", None, "low")
        segments["lift"] = Segment("low", "below", "rising", None, "free")
    return {
        "states": states.names,
        "parameters": parameters,
        "delays": tuple(delays),
        "period": period,
        "modes": modes,
        "initial": {"mode": "free", "x": min(parameters["wall"], 0.0) - 0.05, "v": 0.0},
        "events": events,
        "segments": segments,
    }


def relay(draw):
    """A relay on a combination of states, now or delayed, with hysteresis or not; driven or not."""
    states, delays = States(("x", "v") if draw.chance(0.6) else ("x",)), draw.lags(0.2, 2.5)
    parameters = {**delays, "u": draw.between(0.6, 1.4), "down": draw.between(0.5, 1.3), "th": draw.between(-0.2, 0.2)}
    first = next(iter(delays))
    late = dict(list(delays.items())[1:])
    oscillator = len(states.names) == 2
    if oscillator:
        parameters["zeta"] = draw.between(0.1, 0.5)
        base = -1 * states["x"] - 2 * name("zeta") * states["v"]
    else:
        parameters["a"] = draw.between(-0.8, 0.5)
        base = name("a") * states["x"]
    if late:
        base = base + feedback(draw, states, late, parameters)
    period = None
    if draw.chance(0.12):
        parameters |= {"omega": draw.between(0.8, 2), "A": draw.between(0.3, 0.8)}
        base, period = base + name("A") * call("cos", name("omega") * name("t")), 2 * name("pi") / name("omega")
    seen = states["x", first] + (0.3 * states["v", first] if oscillator and draw.chance(0.4) else 0)
    gap = draw.chance(0.4)
    if gap:
        parameters["gap"] = draw.between(0.05, 0.3)
    events = {"s": seen - name("th")}
    if gap:
        events["low"] = seen - name("th") + name("gap")
    last = "v" if oscillator else "x"
    head = {"x": states["v"]} if oscillator else {}
    return {
        "states": states.names,
        "parameters": parameters,
        "delays": tuple(delays),
        "period": period,
        "modes": {"push": head | {last: base + name("u")}, "pull": head | {last: base - name("down")}},
        "initial": {"mode": "push", **dict.fromkeys(states.names, 0.0), "x": parameters["th"] - 0.3},
        "events": events,
        "segments": {
            "on": Segment("push", "s", "rising", None, "pull"),
            "off": Segment("pull", "low" if gap else "s", "falling", None, "push"),
        },
        "section": None if period else {"event": "s"},
    }


def neuron(draw, busy=0.4):
    """Integrate and fire with a slow state: refractory, kicked a lag after each spike, or seeing its echo."""
    states, delays = States(("x", "y")), draw.lags(0.1, 1.6)
    parameters = {**delays, "I": draw.between(1.25, 2.2), "d": draw.between(-0.2, 0.6), "T": draw.between(0.6, 3)}
    x, y = states["x"], states["y"]
    slow = (0 - y + feedback(draw, States(("x", "y")), delays, parameters, 0.1, 0.6)) / name("T")
    drive = name("I") - x
    if draw.chance(0.6):
        parameters["g"] = draw.signed(0.05, 0.3)
        drive = drive + name("g") * y
    period = None
    if draw.chance(0.2):
        parameters |= {"omega": draw.between(2, 6), "A": draw.between(0.05, 0.2)}
        drive, period = drive + name("A") * call("cos", name("omega") * name("t")), 2 * name("pi") / name("omega")
    start = name("d")
    if draw.chance(0.35):
        parameters["q"] = draw.signed(0.05, 0.25)
        start = start + name("q") * states[draw.one_of(["x", "y"]), draw.one_of(list(delays))]
    modes = {"go": {"x": drive, "y": slow}}
    events = {"spike": x - 1}
    resets = {"fire": {"x": start, "y": y + draw.between(0, 0.3)}}
    after = "go"
    segments = {}
    if draw.chance(busy):
        parameters["rest"] = draw.between(0.1, 0.6)
        events["recovers"] = ("spike", "rest")
        modes["tired"] = {"x": 0 - x, "y": slow}
        segments["pause"] = Segment("tired", "recovers", "any", None, "go")
        after = "tired"
    if draw.chance(busy):
        parameters |= {"lag": draw.between(0.1, 1.4), "J": draw.signed(0.05, 0.25)}
        events["kick"] = ("spike", "lag")
        resets["kicked"] = {"x": 0.8 * x + name("J")}
        segments["struck"] = Segment("go", "kick", "any", "kicked", "go")
        if after == "tired" and draw.chance(0.5):
            segments["struck_tired"] = Segment("tired", "kick", "any", "kicked", "tired")
    if draw.chance(busy):
        parameters["level"] = draw.between(0.3, 0.9)
        events["echo"] = states["x", draw.one_of(list(delays))] - name("level")
        resets["pushed"] = {"y": y + draw.between(0.1, 0.6)}
        for mode in modes:
            segments[f"echo_{mode}"] = Segment(mode, "echo", draw.one_of(["falling", "rising"]), "pushed", mode)
    return {
        "states": states.names,
        "parameters": parameters,
        "delays": tuple(delays),
        "period": period,
        "modes": modes,
        "initial": {"mode": "go", "x": 0.0, "y": 0.1},
        "events": events,
        "resets": resets,
        "segments": {"fires": Segment("go", "spike", "rising", "fire", after), **segments},
        "section": None if period else {"event": "spike"},
    }


def kicked_walls(draw):
    """Impacts each of which is followed by a kick, in a parameter that makes and loses impacts."""
    return hard_walls(draw, kicks=1.0) | {"free": draw.one_of(["A", "wall", "lag", "omega"])}


def busy_neuron(draw):
    """Neurons with refractory times, kicks and echoes, in a parameter that changes which of them happen."""
    fields = neuron(draw, busy=0.85)
    here = [p for p in ("level", "lag", "rest", "d") if fields["parameters"].get(p)]
    return fields | {"free": draw.one_of([*here, *fields["delays"]])}


def hysteresis(draw):
    """A driven mass that is pulled back beyond one threshold until it is below another."""
    states, parameters, delays, force, period = driven(draw)
    x, v = states["x"], states["v"]
    parameters |= {"th": draw.between(0.2, 0.8), "gap": draw.between(0.05, 0.4), "F": draw.between(0.2, 1.0)}
    return {
        "states": states.names,
        "parameters": parameters,
        "delays": tuple(delays),
        "period": period,
        "modes": {"off": {"x": v, "v": force}, "on": {"x": v, "v": force - name("F")}},
        "initial": {"mode": "off", "x": 0.0, "v": 0.0},
        "events": {"up": x - name("th"), "down": x - name("th") + name("gap")},
        "segments": {
            "pulls": Segment("off", "up", "rising", None, "on"),
            "lets_go": Segment("on", "down", "falling", None, "off"),
        },
        "free": draw.one_of(["A", "th", "F", "gap", "omega"]),
    }


def late_switch(draw):
    """A thermostat whose actuator answers a lag after the threshold is crossed: delayed events change the mode."""
    states, delays = States(("x", "y")), draw.lags(0.2, 2)
    parameters = {**delays, "up": draw.between(0.2, 0.6), "low": draw.between(-0.6, 0.0), "lag": draw.between(0.1, 1.2)}
    parameters |= {"heat": draw.between(0.8, 2), "cool": draw.between(0.5, 1.5), "a": draw.between(0.2, 1)}
    x, y = states["x"], states["y"]
    base = 0 - name("a") * x + feedback(draw, states, delays, parameters, 0.05, 0.3)
    other = (x - y) * draw.between(0.3, 2)
    seen = y if draw.chance(0.3) else x
    lags = {"warm": "lag", "cold": "lag"}
    if draw.chance(0.5):
        parameters["lag2"], lags["cold"] = draw.between(0.1, 1.2), "lag2"
    return {
        "states": states.names,
        "parameters": parameters,
        "delays": tuple(delays),
        "modes": {"heat": {"x": base + name("heat"), "y": other}, "cool": {"x": base - name("cool"), "y": other}},
        "initial": {"mode": "heat", "x": parameters["low"], "y": parameters["low"]},
        "events": {
            "warm": seen - name("up"),
            "cold": seen - name("low"),
            "stop": ("warm", lags["warm"]),
            "start": ("cold", lags["cold"]),
        },
        "segments": {
            "gets_warm": Segment("heat", "warm", "rising", None, "heat"),
            "stops": Segment("heat", "stop", "any", None, "cool"),
            "gets_cold": Segment("cool", "cold", "falling", None, "cool"),
            "starts": Segment("cool", "start", "any", None, "heat"),
        },
        "section": {"event": "warm"},
    }


def friction(draw):
    """A driven mass on a rough floor: force by the sign of the velocity; where both fields point at rest it sticks."""
    states, parameters, delays, force, period = driven(draw)
    parameters |= {"A": draw.between(1.3, 2.2), "mu": draw.between(0.2, 1.0)}
    v = states["v"]
    flows = {"right": force - name("mu"), "left": force + name("mu")}
    return {
        "states": states.names,
        "parameters": parameters,
        "delays": tuple(delays),
        "period": period,
        "modes": {m: {"x": v, "v": f} for m, f in flows.items()},
        "initial": {"mode": "right", "x": 0.0, "v": 4.0},
        "events": {"turn": v},
        "segments": {
            "right": Segment("right", "turn", "falling", None, "left"),
            "left": Segment("left", "turn", "rising", None, "right"),
        },
        "free": draw.one_of(["omega", "omega", "A", "mu", *delays]),
    }


def network(draw):
    """Two or three smooth cells with delayed coupling, driven or not: no events."""
    states, delays = States(("x", "y", "z")[: draw.one_of([2, 2, 3])]), draw.lags(0.5, 2.5)
    parameters = {**delays, "k": draw.between(0.6, 1.2)}
    period, names = None, list(states.names)
    flow = {}
    for i, s in enumerate(names):
        weight, back = f"w{i + 1}", f"b{i + 1}"
        parameters |= {weight: draw.between(1.5, 2.6) * (-1 if i == 0 else 1), back: draw.between(-0.9, -0.1)}
        source = names[(i + 1) % len(names)]
        flow[s] = (
            0
            - name("k") * states[s]
            + name(weight) * call("tanh", states[source, draw.one_of(list(delays))])
            + name(back) * call("tanh", states[s, draw.one_of(list(delays))])
        )
    if draw.chance(0.25):
        parameters |= {"omega": draw.between(0.8, 2), "A": draw.between(0.6, 1.5)}
        flow["x"] = flow["x"] + name("A") * call("cos", name("omega") * name("t"))
        period = 2 * name("pi") / name("omega")
    return {
        "states": states.names,
        "parameters": parameters,
        "delays": tuple(delays),
        "period": period,
        "modes": {"m": flow},
        "initial": {s: draw.between(0.1, 0.6) for s in names},
        "section": None if period else {"zero": "x", "direction": "rising"},
    }


def piecewise(draw):
    """Linear flows on both sides of a surface on states or delayed states, with jumps of the state at it."""
    states, delays = States(("x", "v", "w")), draw.lags(0.2, 2.5)
    x, v, w = (states[s] for s in states.names)
    parameters = {"omega": draw.between(0.8, 2), "A": draw.between(0.5, 1.2), **delays, "th": draw.between(-0.3, 0.3)}
    drive = name("A") * call("cos", name("omega") * name("t"))
    modes = {}
    for mode in ("one", "two"):
        parameters |= {f"s_{mode}": draw.between(0.5, 2), f"c_{mode}": draw.between(0.2, 0.6)}
        parameters[f"e_{mode}"] = draw.signed(0.05, 0.4)
        late = draw.between(-0.2, 0.2) * states[draw.one_of(["x", "v", "w"]), draw.one_of(list(delays))]
        force = drive - name(f"s_{mode}") * x - name(f"c_{mode}") * v + late + name(f"e_{mode}") * w
        modes[mode] = {"x": v, "v": force, "w": draw.between(0.5, 1.5) * (x - w)}
    delay = draw.one_of(list(delays))
    seen = draw.one_of([x, states["x", delay], x + 0.3 * states["w", delay], 0.7 * x - 0.4 * w])
    resets, names = {}, [None, None]
    if draw.chance(0.6):
        resets["jump"] = {"w": draw.between(0.3, 0.8) * w + draw.between(-0.2, 0.2) * states["x", delay]}
        names[0] = "jump"
    if draw.chance(0.3):
        resets["brake"] = {"v": draw.between(0.5, 0.9) * v}
        names[1] = "brake"
    return {
        "states": states.names,
        "parameters": parameters,
        "delays": tuple(delays),
        "period": 2 * name("pi") / name("omega"),
        "modes": modes,
        "initial": {"mode": "one", "x": parameters["th"] - 0.4, "v": 0.0, "w": parameters["th"] - 0.4},
        "events": {"cross": seen - name("th")},
        "resets": resets,
        "segments": {
            "up": Segment("one", "cross", "rising", names[0], "two"),
            "down": Segment("two", "cross", "falling", names[1], "one"),
        },
    }


def sampled(draw):
    """A controller that samples delayed states once a period and holds; the plant may meet a wall."""
    states, delays = States(("x", "v", "u")), draw.lags(0.1, 1.0)
    x, v, u = (states[s] for s in states.names)
    period = 2 * name("pi") / name("omega")
    parameters = {"omega": draw.between(2.5, 6), "A": draw.between(0.5, 1.5), "c": draw.between(0.2, 0.8), **delays}
    parameters |= {"P": draw.between(-0.5, 0.7), "D": draw.between(-0.3, 0.4)}
    delay = draw.one_of(list(delays))
    hold = 0 - name("P") * states["x", delay] - name("D") * states["v", draw.one_of(list(delays))]
    force = u - x - name("c") * v + name("A") * call("cos", name("omega") * name("t"))
    events = {"tick": call("sin", name("omega") * name("t") + draw.between(0.2, 1.2))}
    segments = {"held": Segment("run", "tick", "rising", "sample", "run")}
    resets = {"sample": {"u": hold}}
    if draw.chance(0.6):
        parameters |= {"wall": draw.between(0.0, 0.12), "r": draw.between(0.3, 0.8)}
        events["hit"] = x - name("wall")
        segments["bounce"] = Segment("run", "hit", "rising", "rebound", "run")
        resets["rebound"] = {"v": -1 * name("r") * v}
    return {
        "states": states.names,
        "parameters": parameters,
        "delays": tuple(delays),
        "period": period,
        "modes": {"run": {"x": v, "v": force, "u": 0 * u}},
        "initial": {"mode": "run", "x": -0.05, "v": 0.0, "u": 0.0},
        "events": events,
        "resets": resets,
        "segments": segments,
    }


FAMILIES = {
    f.__name__: f
    for f in (
        *(hard_walls, soft_walls, relay, neuron, late_switch, friction, network, piecewise, sampled),
        *(kicked_walls, busy_neuron, hysteresis),
    )
}
