"""The signature changes by itself at grazings and where segments vanish."""

import math
import re

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq

from pddecont.bifurcation.held import held
from tests.bifurcation.test_special_points import CHAIN_COLLAPSE, CHAIN_GRAZING, TWO_IMPACT_FOLD_CHAIN
from tests.conftest import numeric_from
from tests.problems import GRAZING_TAU
from tests.runs import labels, monitor, multipliers, parameter, run, run_model

FREE_GRAZING_CHAIN = 0.175337013230  # closed form of the linear orbit, N = 15, M = 2, tau_d = 3.8
CHAIN = "model: impact_oscillator\nset: {K: 0.12, tau_d: 3.8}\ndelay: {method: chain, order: 2, n: 15}\nmesh: {degree: 8, intervals: 40}\n"


def signatures(step):
    """Return the signatures along a branch, each once where it goes on."""
    names = [step.orbit(i)["signature"].tobytes().decode() for i in step.order if not step.points["kind"][i]]
    return [a for a, b in zip(names, [None, *names], strict=False) if a != b]


@pytest.fixture(scope="module")
def fig4_7(tmp_path_factory):
    text = CHAIN + """\
monitors: {contact_time: time_in(C), x_max: max(x)}
steps:
  - {name: t, simulate: {t_end: 60*2*pi/omega}}
  - {name: o, orbit: {from: t}}
  - {name: c, continue: {from: o, free: [K], range: {K: [0.1, 0.3]}, step: {max: 0.05}, stability: true, direction: up}}
  - {name: stop, continue: {from: o, free: [K], range: {K: [0.1, 0.3]}, step: {max: 0.05}, direction: up, signature_change: stop}}
  - {name: by_hand, continue: {from: {step: stop, point: GR1}, free: [K], range: {K: [0.1, 0.3]}, signature: [NC, C, NC, C]}}
"""
    return run(text, tmp_path_factory.mktemp("fig4_7") / "a.h5")


def test_from_impacts_to_none_without_user_action(fig4_7):
    step = fig4_7.step("c")
    assert labels(step) == ["GR1", "PD1", "VS1"]
    assert signatures(step) == ["NC C", "NC C NC C", "NC C", "(NC)"]
    assert step.termination[0] == ("up: reached the end of the range, K = 0.3; widen 'range' to go on, through the signatures [NC C], "
                                   "[NC C NC C], [NC C], [(NC)]")  # fmt: skip
    assert np.all(step.points["admissible"] == 1)
    assert parameter(step, "K", "GR1") == pytest.approx(CHAIN_GRAZING, abs=1e-10)
    assert parameter(step, "K", "PD1") == pytest.approx(CHAIN_COLLAPSE, abs=1e-10)
    assert parameter(step, "K", "VS1") == pytest.approx(FREE_GRAZING_CHAIN, abs=1e-10)
    assert parameter(step, "K")[-1] == 0.3
    assert step.points["note"][step.row("VS1")] == b"C vanishes"


def test_the_doubling_met_from_the_doubled_side(fig4_7):
    """Contact time and multipliers of the period-1 orbit at its doubling, from shooting with matrix exponentials."""
    step = fig4_7.step("c")
    assert monitor(step, "contact_time", "PD1") == pytest.approx(0.091210359937, abs=1e-9)
    assert multipliers(step, step.row("PD1"))[:3] == pytest.approx([-1.0, -0.24105926, 0.03017588], abs=1e-7)
    assert monitor(step, "x_max", "VS1") == pytest.approx(1.26, abs=1e-12)


def test_both_signatures_meet_in_the_grazing_orbit(fig4_7):
    """Just past the grazing K grows as the square of the small contact's duration, as shooting gives it: d = .01 and .05."""
    step = fig4_7.step("c")
    past = [i for i in step.order if step.orbit(i)["signature"].tobytes() == b"NC C NC C"]
    d = np.array([min(step.orbit(i)["unknowns"][[1, 3]]) for i in past])
    K = step.points["parameters"][past, step.meta["parameters"].index("K")]
    shooting_d = np.array([0.0, 0.01, 0.03, 0.05, 0.075, 0.085])
    shooting_K = np.array([CHAIN_GRAZING, 0.174752343075, 0.174785826696, 0.174832023855, 0.1748804862573, 0.1748902696928])
    expected = np.polynomial.Polynomial.fit(shooting_d, shooting_K, 5)(d)
    inside = d < 0.085
    assert np.sum(inside) > 0
    assert K[inside] == pytest.approx(expected[inside], abs=2e-8)


def test_stop_and_go_by_hand(fig4_7):
    stop, hand = fig4_7.step("stop"), fig4_7.step("by_hand")
    assert labels(stop) == ["GR1"]
    assert stop.termination[0].startswith("up: stopped at a special point where the signature of the orbit changes (GR)")
    assert signatures(hand)[0] == "NC C NC C"
    assert labels(hand) == ["PD1", "VS1"]
    assert parameter(hand, "K", "PD1") == pytest.approx(CHAIN_COLLAPSE, abs=1e-10)


def test_another_signature_than_the_grazings_is_refused(tmp_path, fig4_7):
    from pddecont.errors import SignatureError

    text = CHAIN + f"""\
steps:
  - {{name: c, continue: {{from: {{file: {fig4_7.path}, step: stop, point: GR1}}, free: [K], range: {{K: [0.1, 0.3]}}, signature: [SIG]}}}}
"""
    with pytest.raises(SignatureError, match=r"the grazing leads to \[NC, C, NC, C\]"):
        run(text.replace("SIG", "NC, C, NC, C, NC, C"), tmp_path / "a.h5")


def test_in_the_delay_through_both_grazings_to_the_free_orbit_and_back(tmp_path):
    text = """\
model: impact_oscillator
mesh: {degree: 9, tol: 1e-10}
monitors: {contact_time: time_in(C)}
steps:
  - {name: t, simulate: {t_end: 60*2*pi/omega}}
  - {name: o, orbit: {from: t}}
  - {name: c, continue: {from: o, free: [tau_d], range: {tau_d: [3, 6.5]}, step: {max: 0.05}}}
"""
    step = run(text, tmp_path / "a.h5").step("c")
    assert labels(step) == ["PD1", "GR1", "GR2", "PD2", "VS1", "GR3"]
    assert signatures(step) == ["NC C", "NC C NC C", "NC C", "NC C NC C", "NC C", "(NC)", "NC C"]
    assert [parameter(step, "tau_d", x) for x in ("GR1", "GR2")] == pytest.approx([3.2164416411, 4.6951888028], abs=2e-9)
    assert [parameter(step, "tau_d", x) for x in ("VS1", "GR3")] == pytest.approx(GRAZING_TAU, abs=1e-9)
    assert np.all(step.points["admissible"] == 1)


WALL = """\
model: wall_oscillator
mesh: {degree: 8, tol: 1e-10}
monitors: {x_max: max(x)}
steps:
  - {name: t, simulate: {t_end: 300}}
  - {name: o, orbit: {from: t}}
  - {name: c, continue: {from: o, free: [FREE], range: {FREE: RANGE}, step: {max: 0.05}, stability: true, direction: both}}
"""


def free_amplitude(omega):
    return 1 / math.hypot(1 - omega**2, 0.1 * omega)


@pytest.mark.parametrize(("free", "limits"), [("wall", [0.1, 1]), ("omega", [1.9, 3])])
def test_a_hard_impact_dies_at_speed_zero_where_the_free_orbit_grazes(tmp_path, free, limits):
    text = WALL.replace("FREE", free).replace("RANGE", str(limits))
    step = run(text, tmp_path / "a.h5").step("c")
    assert "VS1" in labels(step)
    at = parameter(step, free, "VS1")
    if free == "wall":
        assert at == pytest.approx(free_amplitude(2.0), abs=1e-10)
    else:
        assert free_amplitude(at) == pytest.approx(0.2, abs=1e-10)
    assert step.points["note"][step.row("VS1")] == b"event turns tangential"
    assert signatures(step) == ["flight", "(free)"]
    assert np.all(step.points["admissible"] == 1)
    # The multipliers of a hard impact are unbounded at speed zero, so the impacting orbit loses its stability before, in the same step.
    assert labels(step).index("PD1") < labels(step).index("VS1")


def test_the_free_orbit_grazes_a_hard_wall_and_the_new_family_turns_back(tmp_path):
    text = WALL.replace("model: wall_oscillator", "model: wall_oscillator\nset: {wall: 0.5}")
    text = text.replace("FREE", "wall").replace("RANGE", "[0.1, 0.6]").replace("direction: both", "direction: down")
    step = run(text, tmp_path / "a.h5").step("c")
    assert labels(step) == ["PD1", "GR1"]
    assert parameter(step, "wall", "GR1") == pytest.approx(free_amplitude(2.0), abs=1e-10)
    assert signatures(step) == ["flight", "(free)"]
    speeds = [step.orbit(i)["states"][-1, 1] for i in step.order if step.orbit(i)["signature"].tobytes() == b"flight"]
    assert min(speeds) > 0


def test_chattering_adds_impacts_one_by_one(tmp_path):
    """Down in the wall's place ever more low impacts are born at grazings; each orbit is admissible."""
    text = WALL.replace("FREE", "wall").replace("RANGE", "[-1, 0.3]").replace("direction: both", "direction: down, max_points: 100")
    step = run(text, tmp_path / "a.h5").step("c")
    counts = [len(name.split()) for name in signatures(step)]
    assert max(counts) >= 4
    assert np.all(np.abs(np.diff(counts)) == 1)
    assert np.mean(step.points["admissible"] == 1) == 1


@pytest.mark.parametrize(("kick", "level"), [(-0.1, 1.0), (0.1, 0.9)])
def test_two_events_that_meet_are_named(tmp_path, kick, level):
    """The neuron's kick comes tau after its spike. A braking kick is overtaken by the next spike when x = 1 without it; a driving one
    makes the spike itself when x = 1 with it, and the segment between the two vanishes. Here x = drive (1 - e^-tau)."""  # fmt: skip
    text = f"""\
model: spiking_neuron
set: {{kick: {kick}}}
mesh: {{degree: 9, tol: 1e-11}}
steps:
  - {{name: t, simulate: {{t_end: 60}}}}
  - {{name: o, orbit: {{from: t}}}}
  - {{name: c, continue: {{from: o, free: [tau], range: {{tau: [0.2, 2]}}, direction: up, step: {{max: 0.05}}}}}}
"""
    step = run(text, tmp_path / "a.h5").step("c")
    assert labels(step) == ["VS1"]
    assert b"meets" in step.points["note"][step.row("VS1")]
    assert parameter(step, "tau", "VS1") == pytest.approx(math.log(1.5 / (1.5 - level)), abs=1e-7)
    assert np.all(step.points["admissible"] == 1)


FAST = """\
name: ball_with_a_speed_limit
states: [y, v]
parameters: {G: 0.6, r: 0.8, w: 5}
forcing: {period: 2*pi}
modes: {flight: {y': v, v': G*sin(t) - 1}}
events: {landing: y, fast: v + w}
resets: {bounce: {v: -r*v}, brake: {v: -0.9*w}}
segments:
  hop: {mode: flight, event: landing, direction: falling, reset: bounce, to: flight}
  limit: {mode: flight, event: fast, direction: falling, reset: brake, to: flight}
initial: {y: 0.01, v: 2.5}
run:
  mesh: {degree: 8, tol: 1e-10}
  steps:
    - {name: t, simulate: {t_end: 200*2*pi}}
    - {name: o, orbit: {from: t}}
    - {name: c, continue: {from: o, free: [w], range: {w: [3, 6]}, direction: down}}
    - {name: vs, continue: {from: {step: c, point: VS1}, free: [w, r], range: {w: [3, 6], r: [0.5, 0.95]}}}
"""


def test_an_event_that_comes_in_at_a_segments_end_is_located(tmp_path):
    """The ball lands at relative speed 2 pi / (1 + r), its largest: the speed limit w is met there, and nowhere before."""

    results = run_model(FAST, tmp_path / "a.h5")
    step = results.step("c")
    assert labels(step) == ["VS1"]
    assert step.points["note"][step.row("VS1")] == b"landing meets fast"
    assert parameter(step, "w", "VS1") == pytest.approx(2 * math.pi / 1.8, abs=1e-10)
    assert np.all(step.points["admissible"] == 1)
    curve = results.step("vs")
    assert 2 * math.pi / (1 + parameter(curve, "r")) == pytest.approx(parameter(curve, "w"), abs=1e-9)
    assert len(curve) > 10


def test_the_orbit_with_two_impacts_in_the_gain(tmp_path):
    """Fig. 4.2: by brute force it is lost near K = 0.0027; followed, it ends in a fold."""
    text = CHAIN.replace("K: 0.12, ", "K: 0, ") + """\
steps:
  - {name: t, simulate: {initial: {x: -0.26, v: 1.74}, t_end: 150*2*pi/omega}}
  - {name: o, orbit: {from: t, signature: [NC, C, NC, C]}}
  - {name: c, continue: {from: o, free: [K], range: {K: [0, 0.3]}, step: {max: 0.02}, direction: up, stability: true}}
"""
    step = run(text, tmp_path / "a.h5").step("c")
    assert labels(step) == ["LP1"]
    assert parameter(step, "K", "LP1") == pytest.approx(TWO_IMPACT_FOLD_CHAIN, abs=1e-10)
    assert multipliers(step, step.row("LP1"))[:2] == pytest.approx([1.0, 0.697689695264], abs=1e-5)


SOFT_WALLS = """\
name: soft_walls
states: [x, v]
parameters: {omega: 2.0, a: 0.3, b: 0.3, c: 0.1, k: 4}
forcing: {period: 2*pi/omega}
modes:
  F: {x': v, v': cos(omega*t) - c*v - x}
  R: {x': v, v': cos(omega*t) - c*v - x - k*(x-a)}
  L: {x': v, v': cos(omega*t) - c*v - x - k*(x+b)}
events: {right: x - a, left: x + b}
resets: {same: {}}
segments:
  FR: {mode: F, event: right, direction: rising, reset: same, to: R}
  RF: {mode: R, event: right, direction: falling, reset: same, to: F}
  FL: {mode: F, event: left, direction: falling, reset: same, to: L}
  LF: {mode: L, event: left, direction: rising, reset: same, to: F}
initial: {mode: F}
run:
  mesh: {degree: 9, tol: 1e-11}
  steps:
    - {name: t, set: {omega: 2.6}, simulate: {t_end: 200}}
    - {name: o, set: {omega: 2.6}, orbit: {from: t}}
    - {name: c, continue: {from: o, free: [omega], range: {omega: [1.9, 2.7]}, direction: down, max_points: 40, step: STEP}}
"""
HARD_WALLS = re.sub(r"modes:.*?initial", """modes: {F: {x': v, v': cos(omega*t) - c*v - x - 0*k}}
events: {right: x - a, left: x + b}
resets: {hit: {v: -0.8*v}}
segments:
  right: {mode: F, event: right, direction: rising, reset: hit, to: F}
  left: {mode: F, event: left, direction: falling, reset: hit, to: F}
initial""", SOFT_WALLS, flags=re.S)


@pytest.mark.parametrize(("model", "b", "step", "last"), [
    (SOFT_WALLS, 0.3, "{}", "FL LF FR RF"), (HARD_WALLS, 0.3, "{}", "left right"), (HARD_WALLS, 0.33, "{}", "left right"),
    (HARD_WALLS, 0.33, "{initial: 0.3, max: 0.5}", "left right"),
])  # fmt: skip
def test_two_walls_touched_at_once_or_in_one_step(tmp_path, model, b, step, last):
    """The free orbit reaches both walls: at once if they are as far, else one after the other, in small steps and in large ones."""

    text = model.replace("b: 0.3,", f"b: {b},").replace("STEP", step)
    branch = run_model(text, tmp_path / "a.h5").step("c")
    grazings = [name for name in labels(branch) if name.startswith("GR")]
    assert len(grazings) == (1 if b == 0.3 else 2)
    touch = max(parameter(branch, "omega", name) for name in grazings)
    assert free_amplitude(touch) == pytest.approx(0.3, abs=1e-10)
    assert sorted(signatures(branch)[0].split()) == sorted(last.split())
    assert np.all(branch.points["admissible"] == 1)


def test_a_branch_does_not_go_on_with_orbits_that_are_none():
    """Whatever makes an orbit inadmissible without a located point ends the branch, and says what it is."""
    from pddecont.continuation.branch import State, StepSettings, follow
    from pddecont.continuation.ending import End
    from pddecont.continuation.special import Watch
    from tests.continuation.test_branch import Circle

    points = []
    watch = Watch(objection=lambda at: "beyond the wall" if at.x[0] > 0.5 else "")
    end = follow(State(Circle(), np.array([-1.0, 0.0]), np.array([0.0, 1.0]), 0.0, 0.02, 1), [(0, -2.0, 2.0)], watch, StepSettings(),
                 points.append, 1)  # fmt: skip
    assert end.end is End.INVALID
    assert "beyond the wall" in str(end)
    assert 0.5 < points[-1].state.x[0] < 0.65


def test_an_event_of_any_direction_turns_tangential_too(tmp_path):
    from tests.conftest import ROOT

    model = (ROOT / "models" / "wall_oscillator.yaml").read_text().replace("direction: rising", "direction: any")
    assert "direction: any" in model
    (tmp_path / "any.yaml").write_text(model)
    text = WALL.replace("FREE", "wall").replace("RANGE", "[0.1, 1]").replace("model: wall_oscillator", f"model: {tmp_path / 'any.yaml'}")
    step = run_model(text.replace("direction: both", "direction: up"), tmp_path / "a.h5").step("c")
    assert labels(step) == ["PD1", "VS1"]
    assert parameter(step, "wall", "VS1") == pytest.approx(free_amplitude(2.0), abs=1e-10)
    assert signatures(step) == ["flight", "(free)"]


TICKS = """\
name: ticks
states: [x, v]
parameters: {w: START, r: 0.8, tau: 0.6}
modes: {free: {x': v, v': 0.5*(1 - x**2)*v - x + 0.1*x(t - tau)}}
events: {hit: x - w, tick: x}
resets: {b: {v: -r*v}, same: {}}
segments:
  hop:  {mode: free, event: hit, direction: rising, reset: b, to: free}
  tick: {mode: free, event: tick, direction: falling, reset: same, to: free}
initial: {mode: free, x: 0.5, v: 0}
run:
  mesh: {degree: 9, tol: 1e-10}
  monitors: {top: max(x)}
  steps:
    - {name: t, simulate: {t_end: 200}}
    - {name: o, orbit: {from: t}}
    - {name: c, continue: {from: o, free: [w], range: {w: [1.7, 2.3]}}}
"""


def test_an_event_that_does_nothing_does_not_mislead(tmp_path):
    """An autonomous orbit leaves a wall and comes to it; it also ticks as x falls through zero. It goes the right way from both sides."""
    away = run_model(TICKS.replace("START", "1.83"), tmp_path / "a.h5").step("c")
    towards = run_model(TICKS.replace("START", "2.2"), tmp_path / "b.h5").step("c")
    assert sorted(labels(away)) == ["LP1", "VS1"]
    assert sorted(labels(towards)) == ["GR1", "LP1"]
    touch = parameter(away, "w", "VS1")
    assert parameter(towards, "w", "GR1") == pytest.approx(touch, abs=1e-10)
    assert monitor(towards, "top", "EP2") == pytest.approx(touch, abs=1e-9)
    assert parameter(away, "w", "LP1") == pytest.approx(parameter(towards, "w", "LP1"), abs=1e-9)
    for step in (away, towards):
        assert sorted(signatures(step)) == ["hop tick", "tick"]
        assert np.all(step.points["admissible"] == 1)
        assert {parameter(step, "w", "EP1"), parameter(step, "w", "EP2")} == {1.7, 2.3}


@pytest.mark.parametrize(("degree", "intervals"), [(7, 12), (7, 24), (8, 24), (6, 16)])
def test_an_extremum_on_an_edge_of_the_mesh_is_seen(tmp_path, degree, intervals):
    """The pulse's sin(2 pi t) has its minimum at an edge; missed, its rise at the end would look like a fall."""
    text = f"""\
model: pulsed_control
mesh: {{degree: {degree}, intervals: {intervals}}}
steps:
  - {{name: t, simulate: {{t_end: 150}}}}
  - {{name: o, orbit: {{from: t}}}}
  - {{name: c, continue: {{from: o, free: [b], range: {{b: [-2, -0.5]}}}}}}
"""
    step = run(text, tmp_path / "a.h5").step("c")
    assert np.all(step.points["admissible"] == 1)
    assert all("reached the end of the range" in t for t in step.termination)


STICK_SLIP = """\
name: s
states: [x, w]
parameters: {V: 0.5, c: 0.05, d: 0.4, q: 3}
modes:
  slip: {x': w - V, w': -x - c*w - 1 + d*(1 - exp(-q*w))}
  stick: {x': -V, w': 0}
events: {stop: w, release: -x - 1}
resets: {zero: {w: 0}}
segments:
  slip: {mode: slip, event: stop, direction: falling, reset: zero, to: stick}
  stick: {mode: stick, event: release, direction: rising, to: slip}
initial: {mode: stick, x: 0, w: 0}
run:
  mesh: {degree: 8, tol: 1.0e-10}
  monitors: {sticking: time_in(stick)}
  steps:
    - {name: t, simulate: {t_end: 200}}
    - {name: o, orbit: {from: t}}
    - {name: c, continue: {from: o, free: [V], range: {V: [0.1, 0.9]}, step: {max: 0.05}}}
"""


def test_slipping_that_begins_where_sticking_held_it_is_no_meeting(tmp_path):
    """Friction is continuous at the release, so that slip begins with speed and acceleration zero, to rounding."""

    def slip(V):
        """Return the time of slip and x at its end."""

        def field(_, y):
            return [y[1] - V, -y[0] - 0.05 * y[1] - 1 + 0.4 * (1 - np.exp(-3 * y[1]))]

        begun = solve_ivp(field, (0, 0.5), [-1.0, 0.0], method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
        stop = lambda _, y: y[1]  # noqa: E731
        stop.terminal, stop.direction = True, -1
        end = solve_ivp(field, (0.5, 20), begun, method="DOP853", rtol=1e-12, atol=1e-13, events=stop)
        return end.t[-1], end.y[0, -1]

    step = run_model(STICK_SLIP, tmp_path / "a.h5").step("c")
    assert labels(step) == []
    assert all("reached the end of the range" in text for text in step.termination)
    assert np.all(step.points["admissible"] == 1)
    for row in step.order[::5]:
        V = parameter(step, "V")[list(step.order).index(row)]
        time, x = slip(V)
        sticking = (x + 1) / V
        assert step.points["monitors"][row, 0] == pytest.approx(sticking, abs=1e-8)
        assert step.points["period"][row] == pytest.approx(time + sticking, abs=1e-8)


def test_an_event_function_that_a_mode_holds_at_zero_meets_nothing():
    model = numeric_from(STICK_SLIP.partition("run:")[0]).model
    signature = [model.segments["slip"], model.segments["stick"]]
    assert held(model, signature, 0, "stop", at_end=False)
    assert held(model, signature, 1, "stop", at_end=True)
    assert not held(model, signature, 0, "stop", at_end=True)
    moving = numeric_from(STICK_SLIP.partition("run:")[0].replace("w': 0}", "w': 0.1}")).model
    assert not held(moving, [moving.segments["slip"], moving.segments["stick"]], 0, "stop", at_end=False)


HYSTERESIS = """\
name: r
states: [x, v]
parameters: {h: 0.3, tau: 0.4}
modes:
  plus: {x': v, v': -0.2*v - x - 1}
  minus: {x': v, v': -0.2*v - x + 1}
events: {up: x(t - tau) - h, down: x(t - tau) + h}
segments:
  pos: {mode: plus, event: down, direction: falling, to: minus}
  neg: {mode: minus, event: up, direction: rising, to: plus}
initial: {mode: plus, x: 1, v: 0}
run:
  mesh: {degree: 6, tol: 1.0e-9}
  monitors: {top: max(x), late_top: max(x(t - tau)), square: mean(x**2), late_square: mean(x(t - tau)**2)}
  steps:
    - {name: t, simulate: {t_end: 200}}
    - {name: o, orbit: {from: t}}
    - {name: c, continue: {from: o, free: [h], range: {h: [-0.5, 1]}, stability: true}}
    - {name: tangent, continue: {from: {step: c, point: VS1}, free: [tau, h], range: {tau: [0.1, 1], h: [-1, 1]}, step: {max: 0.2}}}
"""


def test_a_delayed_event_turns_tangential_where_its_closed_form_says(tmp_path):
    """Only the events read the delayed state: it has kinks where the mesh needs no edges, a delay after each switching."""
    flow = np.array([[0.0, 1.0], [-1.0, -0.2]])

    def late(half, tau):
        """States a time tau before the end of a half period of a symmetric orbit in which x'' + 0.2 x' + x = -1."""

        def pushed(t):
            return np.linalg.solve(flow, (expm(flow * t) - np.eye(2)) @ np.array([0.0, -1.0]))

        start = np.linalg.solve(-np.eye(2) - expm(flow * half), pushed(half))
        return expm(flow * (half - tau)) @ start + pushed(half - tau)

    def touch(tau, near):
        """Half period and h of the orbit whose x(t - tau) meets -h with speed zero."""
        half = brentq(lambda T: late(T, tau)[1], 0.97 * near, 1.03 * near, xtol=1e-15)
        return half, -late(half, tau)[0]

    results = run_model(HYSTERESIS, tmp_path / "a.h5")
    branch, curve = results.step("c"), results.step("tangent")
    assert "VS1" in labels(branch)
    assert not any("WARNING" in text for text in branch.termination)
    for step in (branch, curve):
        assert np.all(step.points["admissible"] == 1)
        assert monitor(step, "late_top") == pytest.approx(monitor(step, "top"), abs=1e-8)
        assert monitor(step, "late_square") == pytest.approx(monitor(step, "square"), abs=1e-8)
    half, h = touch(0.4, branch.points["period"][branch.row("VS1")] / 2)
    assert parameter(branch, "h", "VS1") == pytest.approx(h, abs=1e-8)
    assert branch.points["period"][branch.row("VS1")] == pytest.approx(2 * half, abs=1e-7)
    for row in range(len(curve)):
        tau, period = curve.points["parameters"][row, 1], curve.points["period"][row]
        assert curve.points["parameters"][row, 0] == pytest.approx(touch(tau, period / 2)[1], abs=1e-7)
