"""The reference itself, against closed forms; and what its laws say, against plain functions."""

import math
import random

import numpy as np
import pytest

from tests.random_equations.generator import draw_equations
from tests.random_equations.laws import Law
from tests.random_equations.reference import Impact, Reference
from tests.random_equations.sides import UnsureError


def run(texts, start, t_end, **more):
    return Reference(states=tuple(texts), texts=tuple(texts.values()), start=np.array(start), **more).run(t_end)


def test_dry_friction():
    """From 3.3 with friction 0.4: half turns of length pi, each 0.8 less; it sticks at 0.1."""
    r = run({"x": "v", "v": "-x - 0.4*sign('v', v)"}, [3.3, 0.0], 14.0)
    assert [t for t, _ in r.events] == pytest.approx([math.pi * k for k in range(1, 5)], abs=1e-9)
    assert r.z == pytest.approx([0.1, 0.0], abs=1e-10)
    assert r.slid == pytest.approx(14.0 - 4 * math.pi, abs=1e-8)


def test_static_friction():
    belt = {"x": "v", "v": "-x - 0.3*sign('u', v - 0.5)"}
    r = run(belt, [0.0, 0.5], 5.0, grips={"u": 1.5})
    assert r.events[0] == (pytest.approx(0.9, abs=1e-10), "u")


def test_a_relay_and_a_delay():
    """x' = -sign(x(t - 1)) from 0.5: down to -1 at 1.5, up to 1 at 3.5."""
    r = run({"x": "-sign('late', x_tau)"}, [0.5], 6.0, tau=1.0, fixed=frozenset({"late"}))
    assert [t for t, _ in r.events] == pytest.approx([1.5, 3.5, 5.5], abs=1e-10)
    assert r.z == pytest.approx([-0.5], abs=1e-10)
    r = run({"x": "-relay('r', x, -0.3, 0.7)"}, [0.0], 3.0, relays=frozenset({"r"}))
    assert [t for t, _ in r.events] == pytest.approx([0.7, 1.7, 2.7], abs=1e-11)


def test_an_impact_and_its_kick():
    stop = Impact("stop", "x - 0.5", 1, ("x", "-0.8*v"))
    kick = Impact("kick", None, 0, ("x", "v + 1.5"), "stop", 0.2)
    r = run({"x": "v", "v": "0.0*x"}, [0.0, 1.0], 0.9, impacts=(stop, kick))
    assert [t for t, _ in r.events] == pytest.approx([0.5, 0.7], abs=1e-11)
    assert r.z == pytest.approx([0.34 + 0.14, 0.7], abs=1e-11)


def test_it_says_where_it_is_unsure():
    with pytest.raises(UnsureError):
        run({"x": "sign('x', x)"}, [0.0], 1.0)
    with pytest.raises(UnsureError, match="grazes"):
        run({"x": "v", "v": "-x - 3.0*ramp('w', x - 1.0)"}, [0.0, 1.0], 3.0)


def test_its_laws_are_plain_functions_where_flags_are_signs():
    law = Law(["clip('a', 'b', x, -0.3, 0.5) + 10.0*absolute('x', x) + 100.0*deadzone('c', 'd', x, -0.2, 0.2)"], ["x"])
    draw = random.Random(2)
    for _ in range(30):
        x = draw.uniform(-1, 1)
        law.flags = {"a": x > -0.3, "b": x > 0.5, "x": x > 0, "c": x > -0.2, "d": x > 0.2}
        dead = x - 0.2 if x > 0.2 else x + 0.2 if x < -0.2 else 0.0
        assert law.evaluate(x) == pytest.approx([min(max(x, -0.3), 0.5) + 10 * abs(x) + 100 * dead])
    law = Law(["mod('m', t - 0.4, 1.7)", "square('m', t - 0.4, 1.7)"], ["t"])
    for _ in range(30):
        t = draw.uniform(0, 9)
        turns = (t - 0.4) / 1.7 % 1
        law.flags = {"m": turns < 0.5}
        assert law.evaluate(t) == pytest.approx([1.7 * turns, 1.0 if turns < 0.5 else -1.0])


def test_a_seed_gives_the_same_model_again_and_another_another():
    texts = [str(draw_equations(seed).mapping) for seed in (3, 3, 4)]
    assert texts[0] == texts[1] != texts[2]
