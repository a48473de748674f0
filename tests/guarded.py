"""Models with guards whose motions are known in closed form."""

import math


def decide(names, event, reset, when, yes, no):
    """Return one segment for each name and its mode; whether ``when`` holds after the reset decides what follows."""
    rest = {"event": event, "direction": "rising", "reset": reset, "to": [{"when": when, "mode": yes}, {"mode": no}]}
    return {name: {"mode": mode, **rest} for name, mode in names.items()}


# At each tick what was fed in decides whether feeding goes on; exponentials between ticks.
RAMP = {
    "name": "ramp",
    "states": ["v", "c"],
    "parameters": {"ramp": 0.6, "T": 1, "up": 1, "leak": 0.1, "down": 0.5},
    "modes": {"feed": {"v'": "up - leak*v", "c'": 1}, "idle": {"v'": "-down*v", "c'": 1}},
    "events": {"tick": "c - T"},
    "resets": {"restart": {"c": 0}},
    "segments": decide({"tick": "feed", "tock": "idle"}, "tick", "restart", "v > ramp", "idle", "feed"),
    "initial": {"mode": "feed", "v": 0, "c": 0},
}
# A controller that samples a delayed state and cannot give more than cap: on both sides of cap the field is the same.
SATURATION = {
    "name": "saturation",
    "states": ["x", "s", "c"],
    "parameters": {"k": 0.8, "cap": 0.5, "F": 0.9, "T": 1, "tau": 0.3},
    "modes": {
        "linear": {"x'": "-0.5*x + F - k*s", "s'": 0, "c'": 1},
        "capped": {"x'": "-0.5*x + F - k*cap", "s'": 0, "c'": 1},
    },
    "events": {"sample": "c - T"},
    "resets": {"take": {"s": "x(t - tau)", "c": 0}},
    "segments": decide({"tick": "linear", "tock": "capped"}, "sample", "take", "s > cap", "capped", "linear"),
    "initial": {"mode": "linear", "x": 0, "s": 0, "c": 0},
}
# The lowest and the middle value of the orbit that feeds one tick in three, T = 1.
TOP = 10 * (1 - math.exp(-0.1)) / (1 - math.exp(-1.1))
LOW, MIDDLE = TOP * math.exp(-1.0), TOP * math.exp(-0.5)


def tick(mode, v, ramp=0.6):
    """Return the mode and the state after one tick of RAMP."""
    v = 10 + (v - 10) * math.exp(-0.1) if mode == "feed" else v * math.exp(-0.5)
    return ("idle" if v > ramp else "feed"), v
