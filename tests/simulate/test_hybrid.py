"""Events, jumps, delays and parameters that change, against closed forms: what users of hybrid delay systems meet."""

import math

import numpy as np
import pytest
import sympy
from scipy.special import lambertw

from pddecont.delay.chain import Chain
from pddecont.delay.direct import Direct
from pddecont.errors import ConvergenceError
from pddecont.model.expression import TIME
from pddecont.simulate.attractors import Clock, settled
from pddecont.simulate.integrate import follow, simulate
from pddecont.simulate.kernel.advance import run
from pddecont.simulate.kernel.tables import N_PENDING, Status, enlarged, new_log
from pddecont.simulate.lyapunov import lyapunov
from pddecont.simulate.simulator import Method, Section, Simulator
from tests.conftest import numeric_from, shipped
from tests.runs import run_model

TIGHT = Method(1e-12, 1e-13)
DIRECT = Direct()


def parameters(numeric, **given):
    names = list(numeric.model.parameters)
    return np.array([given.get(n, v) for n, v in zip(names, numeric.parameter_values, strict=True)])


def trajectory_of(text, t_end, method=TIGHT, **given):
    numeric = numeric_from(text)
    return simulate(numeric, numeric.parameter_values, DIRECT, t_end, method, **given)


# No pulse is lost.
LAGS = "x': -0.1*x(t - 0.2) - 0.2*x(t - 4)"
FORCED = (
    "name: p\nstates: [x, n]\nparameters: {p: PERIOD}\nforcing: {period: p}\nmodes: {m: {" + LAGS + ", n': 0}}\nevents: {e: H}\n"
    "resets: {add: {x: x + 1, n: n + 1}}\nsegments: {s: {mode: m, event: e, direction: DIR, reset: add, to: m}}\ninitial: {x: 1}\n"
)
CLOCK = ("name: p\nstates: [x, n, c]\nmodes: {m: {" + LAGS + ", n': 0, c': 1}}\nevents: {e: c - 1}\nresets: {add: {x: x + 1, "
         "n: n + 1, c: 0}}\n"
         "segments: {s: {mode: m, event: e, direction: rising, reset: add, to: m}}\ninitial: {x: 1}\n")  # fmt: skip


def forced(h, direction, period):
    return FORCED.replace("H}", h + "}").replace("DIR", direction).replace("PERIOD", str(period))


@pytest.mark.parametrize("text", [forced("sin(2*pi*t)", "rising", 1), forced("sin(pi*t)", "any", 2), CLOCK], ids=["once", "twice", "clock"])
def test_no_pulse_is_lost_between_short_and_long_lags(text):
    trajectory = trajectory_of(text, 1000.5)
    assert trajectory.events.t == pytest.approx(np.arange(1, 1001), abs=1e-11)
    assert trajectory(1000.5)[1] == 1000.0
    assert trajectory(999.9)[0] == pytest.approx(trajectory_of(CLOCK, 1000.5)(999.9)[0], abs=1e-10)


STILL = ("name: c\nstates: [c, n]\nmodes: {m: {c': 1, n': 0}}\nevents: {e: H}\nresets: {add: {n: n + 1}}\n"
         "segments: {s: {mode: m, event: e, direction: DIR, reset: add, to: m}}\n")  # fmt: skip


@pytest.mark.parametrize(
    ("direction", "expected"), [("any", np.arange(1, 1001)), ("falling", np.arange(1, 1001, 2)), ("rising", np.arange(2, 1001, 2))]
)
def test_no_zero_of_an_oscillating_event_is_lost_where_the_states_are_smooth(direction, expected):
    """The steps of c' = 1 grow without bound; sin(pi c) is then far from a polynomial along a step."""
    trajectory = trajectory_of(STILL.replace("H}", "sin(pi*c)}").replace("DIR", direction), 1000.5)
    assert len(trajectory.events) == len(expected)
    assert trajectory.events.t == pytest.approx(expected, abs=1e-10)


@pytest.mark.parametrize("per_period", [10, 100, 400])
def test_many_zeros_within_a_forcing_period(per_period):
    text = ("name: f\nstates: [n]\nparameters: {p: 2}\nforcing: {period: p}\nmodes: {m: {n': 0}}\nevents: {e: sin(W*pi*t)}\n"
            "resets: {add: {n: n + 1}}\nsegments: {s: {mode: m, event: e, direction: any, reset: add, to: m}}\n")  # fmt: skip
    trajectory = trajectory_of(text.replace("W", str(per_period)), 10 + 0.5 / per_period)
    assert trajectory.events.t == pytest.approx(np.arange(1, 10 * per_period + 1) / per_period, abs=1e-11)


@pytest.mark.parametrize("overlap", [1e-2, 1e-4, 1e-6])
def test_a_double_crossing_within_a_step_is_found(overlap):
    text = STILL.replace("H}", f"(c - 3.3)**2 - {overlap**2!r}}}").replace("DIR", "any")
    trajectory = trajectory_of(text, 10.0)
    assert trajectory.events.t == pytest.approx([3.3 - overlap, 3.3 + overlap], abs=1e-13 / overlap + 1e-12)
    none = trajectory_of(STILL.replace("H}", f"(c - 3.3)**2 + {overlap**2!r}}}").replace("DIR", "any"), 10.0)
    assert len(none.events) == 0


def test_double_crossings_at_each_turn_of_an_oscillation():
    """x = cos 10 t exceeds 1 - 1e-8 for 2.8e-5 time units at each maximum."""
    text = ("name: d\nstates: [x, v, n]\nparameters: {p: 6}\nforcing: {period: p}\nmodes: {m: {x': v, v': -100*x, n': 0}}\n"
            "events: {e: x - 0.99999999}\nresets: {add: {n: n + 1}}\n"
            "segments: {s: {mode: m, event: e, direction: any, reset: add, to: m}}\ninitial: {x: 1}\n")  # fmt: skip
    trajectory = trajectory_of(text, 20.0)
    half = math.acos(1 - 1e-8) / 10
    centres = np.arange(1, 32) * math.pi / 5
    # x passes the surface at the speed 10 sin(10 half) = 1.4e-3: an error of x becomes one of the time 700 times as large.
    assert trajectory.events.t == pytest.approx([half, *np.sort([*(centres - half), *(centres + half)])],
                                                abs=5e-11 / (10 * math.sin(10 * half)))  # fmt: skip


# What is kept, and what is under way.
def test_memory_stays_flat_over_a_million_time_units():
    numeric = numeric_from("name: p\nstates: [x, c]\nmodes: {m: {x': -x(t - 50)/50, c': 1}}\nevents: {e: c - 100}\n"
                           "resets: {r: {x: x + 1, c: 0}}\n"
                           "segments: {s: {mode: m, event: e, direction: rising, reset: r, to: m}}\n")  # fmt: skip
    simulator = Simulator(numeric, DIRECT, Method())
    values = simulator.values(numeric.parameter_values)
    memory, log = simulator.start(values), new_log(2, 0, 0)
    sizes = []
    for t in (1e4, 1e6):
        while (status := run(simulator.system, values, memory, log, simulator.work, t, 1 << 40)) == Status.ROOM:
            memory = enlarged(memory)
        assert status == Status.REACHED
        sizes.append(sum(a.nbytes for a in memory))
    assert sizes[1] == sizes[0] < 100_000
    assert memory.hits[0] in (9999, 10000)
    late = simulate(numeric, numeric.parameter_values, DIRECT, 1e5, keep_from=1e5 - 250)
    assert len(late.events) in (2, 3)
    assert late.t0 > 1e5 - 350


@pytest.mark.parametrize(("delay", "expected"), [(100.5, 199), (100, 200), (1000.5, 0)])
def test_many_delayed_events_under_way(delay, expected):
    numeric = numeric_from("name: k\nstates: [c, n]\nparameters: {tau: 1}\nmodes: {m: {c': 1, n': 0}}\n"
                           "events: {tick: c - 1, kick: {after: tick, delay: tau}}\nresets: {zero: {c: 0}, add: {n: n + 1}}\nsegments:\n"
                           "  tick: {mode: m, event: tick, direction: rising, reset: zero, to: m}\n"
                           "  kick: {mode: m, event: kick, reset: add, to: m}\n")  # fmt: skip
    p = np.array([float(delay)])
    assert simulate(numeric, p, DIRECT, 300.25, TIGHT)(300.25)[1] == expected
    simulator = Simulator(numeric, DIRECT, TIGHT)
    values = simulator.values(p)
    memory, _ = simulator.advance(values, simulator.start(values), 300.25)
    assert memory.count[N_PENDING] == 300 - expected


# Events at one moment.
@pytest.mark.parametrize(("first", "second"), [("a", "b"), ("b", "a")])
@pytest.mark.parametrize("other", ["2*c - 2", "c**2 - 1", "exp(c) - exp(1)"])
def test_events_at_one_moment_come_in_the_order_of_their_segments(first, second, other):
    text = ("name: o\nstates: [x, c]\nmodes: {m: {x': 0, c': 1}}\nevents: {a: c - 1, b: OTHER}\nresets: {p: {x: 2*x + 1}, q: {x: 3*x}}\n"
            f"segments:\n  A: {{mode: m, event: {first}, direction: rising, reset: p, to: m}}\n"
            f"  B: {{mode: m, event: {second}, direction: rising, reset: q, to: m}}\n").replace("OTHER", other)  # fmt: skip
    trajectory = trajectory_of(text, 2.0)
    assert trajectory.events.segment == ("A", "B")
    assert trajectory.events.t == pytest.approx([1, 1], abs=1e-13)
    assert trajectory(2.0)[0] == 3.0


def test_an_event_of_either_mode_does_not_come_twice():
    """An identity reset leaves the state on the surface, to rounding on either side of it, also late."""
    numeric = shipped("impact_oscillator")
    simulator = Simulator(numeric, DIRECT, Method())
    values = simulator.values(numeric.parameter_values)
    counts = []
    for turns in (0, 10_000, 1_000_000):
        t = turns * 2 * math.pi / 0.8
        trajectory = follow(simulator, numeric.parameter_values, simulator.start(values, t=t), t + 500.0)
        assert all(a != b for a, b in zip(trajectory.events.segment, trajectory.events.segment[1:], strict=False))
        counts.append(len(trajectory.events))
    assert counts[0] > 40
    assert len(set(counts)) == 1


# Jumps that are read later.
JUMPS = ("name: j\nstates: [x, y, n, c]\nparameters: {tau: 1}\nmodes: {m: {x': 0, y': x(t - tau), n': 0, c': 1}}\n"
         "events: {tick: c - 1, seen: x(t - tau) - 0.5}\nresets: {flip: {x: 1 - x, c: 0}, count: {n: n + 1}}\nsegments:\n"
         "  tick: {mode: m, event: tick, direction: rising, reset: flip, to: m}\n"
         "  seen: {mode: m, event: seen, direction: any, reset: count, to: m}\n")  # fmt: skip


@pytest.mark.parametrize("tau", [0.1, 0.7, 1.0, 2.0, 3.3])
def test_an_event_sees_a_delayed_value_jump(tau):
    """x flips between 0 and 1 at every whole number, so that its delayed value passes 1/2 at every whole number + tau."""
    numeric = numeric_from(JUMPS)
    trajectory = simulate(numeric, np.array([tau]), DIRECT, 10.45, TIGHT)
    seen = trajectory.events.t[np.array(trajectory.events.segment) == "seen"]
    expected = np.arange(1, 11) + tau
    assert len(seen) == np.sum(expected < 10.45)
    assert seen == pytest.approx(expected[expected < 10.45], abs=1e-12)
    ones = sum(min(max(10.45 - tau - k, 0.0), 1.0) for k in range(1, 11, 2))
    assert trajectory(10.45)[1] == pytest.approx(ones, abs=1e-12)


@pytest.mark.parametrize("tau", [1.0, 2.0, 0.5, 1 / 3, 7.0, 13.37])
def test_a_field_reads_jumps_a_delay_equal_to_or_unlike_their_spacing_later(tau):
    """x = floor(t), y' = x(t - tau)."""
    numeric = numeric_from("name: r\nstates: [x, y, c]\nparameters: {tau: 1}\nmodes: {m: {x': 0, y': x(t - tau), c': 1}}\n"
                           "events: {e: c - 1}\n"
                           "resets: {up: {x: x + 1, c: 0}}\nsegments: {s: {mode: m, event: e, direction: rising, reset: up, "
                           "to: m}}\n")  # fmt: skip
    whole, part = divmod(50.5 - tau, 1.0)
    trajectory = simulate(numeric, np.array([tau]), DIRECT, 50.5, TIGHT)
    assert trajectory(50.5)[1] == pytest.approx(whole * (whole - 1) / 2 + whole * part, abs=1e-10)
    assert trajectory.n_steps < 400


def test_a_reset_reads_the_value_before_a_jump_that_it_meets():
    """x' = 1, x -> 10 x(t - 1) at whole numbers: the event belongs to the arc that ends, and so does what it reads."""
    events = trajectory_of("name: r\nstates: [x, c]\nmodes: {m: {x': 1, c': 1}}\nevents: {e: c - 1}\nresets: {b: {x: 10*x(t - 1), c: 0}}\n"
                           "segments: {s: {mode: m, event: e, direction: rising, reset: b, to: m}}\n", 4.5).events  # fmt: skip
    assert events.before[:, 0] == pytest.approx([1, 1, 11, 11], abs=1e-12)
    assert events.after[:, 0] == pytest.approx([0, 10, 10, 110], abs=1e-11)


def test_a_history_that_differs_from_the_state_at_the_start():
    """x' = -x(t - 1), x = 1 before 0 and x(0) = 3: polynomials by the method of steps."""
    trajectory = trajectory_of("name: h\nstates: [x]\nmodes: {m: {x': -x(t - 1)}}\n", 2.0, initial=[3.0], history=(sympy.Integer(1),))
    t = np.array([0.0, 0.5, 1.0, 1.5, 2.0])
    assert trajectory(t)[:, 0] == pytest.approx(np.where(t <= 1, 3 - t, 2 - 3 * (t - 1) + (t - 1) ** 2 / 2), abs=1e-13)


def test_an_event_through_a_delayed_history():
    """x = t for t < 0: x(t - 1) = t - 1 passes -0.25 at 0.75, before the state itself has gone anywhere."""
    text = ("name: h\nstates: [x]\nmodes: {m: {x': 0}}\nevents: {e: x(t - 1) + 0.25}\nresets: {r: {x: 7}}\n"
            "segments: {s: {mode: m, event: e, direction: rising, reset: r, to: m}}\n")  # fmt: skip
    events = trajectory_of(text, 3.0, history=(TIME,)).events
    assert events.t == pytest.approx([0.75], abs=1e-13)


# Parameters that change.
def test_a_delay_that_changes_on_the_way():
    """c = t, x' = c(t - tau) with tau 1, then 3, then 1/2; c = 0 before 0."""
    numeric = numeric_from("name: h\nstates: [x, c]\nparameters: {tau: 1}\nmodes: {m: {x': c(t - tau), c': 1}}\n")
    trajectory = simulate(numeric, np.array([1.0]), DIRECT, 6.0, TIGHT, schedule=[(2.0, np.array([3.0])), (4.0, np.array([0.5]))])
    half_squares = [max(u, 0) ** 2 / 2 for u in (-1, 1, -1, 1, 3.5, 5.5)]
    assert trajectory(6.0)[0] == pytest.approx(half_squares[1] - half_squares[0] + half_squares[3] - half_squares[2] + half_squares[5]
                                               - half_squares[4], abs=1e-12)  # fmt: skip


def test_a_delay_that_changes_reads_the_jumps_of_the_past_again():
    numeric = numeric_from("name: r\nstates: [x, y, c]\nparameters: {tau: 1}\nmodes: {m: {x': 0, y': x(t - tau), c': 1}}\n"
                           "events: {e: c - 1}\n"
                           "resets: {up: {x: x + 1, c: 0}}\nsegments: {s: {mode: m, event: e, direction: rising, reset: up, "
                           "to: m}}\n")  # fmt: skip
    schedule = [(5.25, np.array([3.2])), (11.1, np.array([0.3]))]
    trajectory = simulate(numeric, np.array([1.0]), DIRECT, 20.5, TIGHT, schedule=schedule)

    def area(u):
        whole, part = divmod(max(u, 0.0), 1.0)
        return whole * (whole - 1) / 2 + whole * part

    expected = area(4.25) + area(11.1 - 3.2) - area(5.25 - 3.2) + area(20.2) - area(10.8)
    assert trajectory(20.5)[1] == pytest.approx(expected, abs=1e-11)


def test_a_long_chain_goes_to_the_delay_equation():
    numeric = numeric_from("name: m\nstates: [x]\nparameters: {tau: 1}\nmodes: {m: {x': -x(t - tau)}}\ninitial: {x: 1}\n")
    exact = simulate(numeric, numeric.parameter_values, DIRECT, 8.0, TIGHT)(8.0)[0]
    errors = [abs(simulate(numeric, numeric.parameter_values, Chain(2, n), 8.0, TIGHT)(8.0)[0] - exact) for n in (10, 20, 40)]
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx(2.0, abs=0.3)


# Accumulation and sliding.
BALL = ("name: b\nstates: [y, v]\nparameters: {r: 0.8, floor: 0}\nmodes: {m: {y': v, v': -9.81}, lie: {y': 0, v': 0}}\n"
        "events: {hit: y - floor}\n"
        "resets: {b: {v: -r*v}}\nsegments: {s: {mode: m, event: hit, direction: falling, reset: b, to: m}}\n")  # fmt: skip


# The ball of r = 0.95 bounces for ever at rounding's height on a floor that is not at 0: t_end stops just after its last impact.
@pytest.mark.parametrize("floor", [0.0, 0.001, 1.0, 100.0])
@pytest.mark.parametrize("r", [0.0, 0.3, 0.5, 0.8, 0.95])
def test_a_ball_comes_to_lie_on_a_floor_at_any_height(r, floor):
    numeric = numeric_from(BALL)
    rest = math.sqrt(2 / 9.81) * (1 + r) / (1 - r)
    trajectory = simulate(numeric, np.array([r, floor]), DIRECT, rest + 1e-4, Method(stick={"hit": "lie"}), initial=[floor + 1, 0.0])
    assert trajectory.mode[-1] == "lie"
    assert trajectory.time[trajectory.mode.index("lie")] == pytest.approx(rest, abs=1e-6)
    assert trajectory.sampled()[1][:, 0].min() > floor - 1e-9


@pytest.mark.parametrize("r", [0.3, 0.5])
def test_chatter_on_a_moving_table_never_passes_through_it(r):
    text = ("name: w\nstates: [x, v]\nparameters: {w: 1, A: 0.5, r: 0.5}\nforcing: {period: 2*pi/w}\nmodes: {m: {x': v, v': -1}}\n"
            "events: {hit: x - A*sin(w*t)}\nresets: {b: {v: -r*v + (1 + r)*A*w*cos(w*t)}}\n"
            "segments: {s: {mode: m, event: hit, direction: falling, reset: b, to: m}}\ninitial: {x: 2}\n")  # fmt: skip
    numeric = numeric_from(text)
    with pytest.raises(ConvergenceError, match="accumulate"):
        simulate(numeric, np.array([1.0, 0.5, r]), DIRECT, 30.0)


RELAY = (
    "name: f\nstates: [x]\nparameters: {tau: 1}\nmodes: {p: {x': -1}, q: {x': 2}, s: {x': 0}}\nevents: {e: H}\nsegments:\n"
    "  a: {mode: p, event: e, direction: falling, to: q}\n  b: {mode: q, event: e, direction: rising, to: p}\ninitial: {x: 1}\n"
)


def test_sliding_is_refused_with_advice_or_handed_over():
    text = RELAY.replace("H}", "x}").replace("parameters: {tau: 1}\n", "")
    with pytest.raises(ConvergenceError, match=r"event 'e' leads, at t = 1, .*slides.*'stick: \{e: MODE\}'"):
        trajectory_of(text, 5.0)
    trajectory = trajectory_of(text, 5.0, Method(1e-12, 1e-13, stick={"e": "s"}))
    assert trajectory.events.t == pytest.approx([1.0], abs=1e-13)
    assert (trajectory.mode[-1], trajectory.t_end) == ("s", 5.0)
    assert trajectory(5.0)[0] == pytest.approx(0.0, abs=1e-13)


@pytest.mark.parametrize(("h", "tau"), [("x + x(t - tau)/10", 1.0), ("x(t - tau)", 0.0)])
def test_sliding_is_seen_where_the_event_reads_a_delayed_value_too(h, tau):
    """Both vector fields point at the surface, whatever the delayed value does more slowly."""
    numeric = numeric_from(RELAY.replace("H}", h + "}"))
    with pytest.raises(ConvergenceError, match="slides"):
        simulate(numeric, np.array([tau]), DIRECT, 5.0)


@pytest.mark.parametrize(
    ("direction", "v", "expected"), [("rising", 1.0, [2 * math.pi]), ("falling", 1.0, [math.pi]), ("any", -1.0, [math.pi, 2 * math.pi])]
)
def test_a_start_on_a_surface_is_no_crossing(direction, v, expected):
    text = ("name: s\nstates: [x, v]\nmodes: {m: {x': v, v': -x}}\nevents: {e: x}\nresets: {n: {}}\n"
            f"segments: {{s: {{mode: m, event: e, direction: {direction}, reset: n, to: m}}}}\n")  # fmt: skip
    assert trajectory_of(text, 7.0, initial=[0.0, v]).events.t == pytest.approx(expected, abs=1e-11)


# Lyapunov exponents.
def exponent(numeric, clock, duration, section=None, delay=DIRECT, **given):
    p = parameters(numeric, **given)
    simulator = Simulator(numeric, delay, Method(), section or Section())
    values = simulator.values(p)
    attractor = settled(simulator, values, simulator.start(values), clock)
    assert not attractor.failed
    return (attractor, *lyapunov(simulator, values, attractor, duration))


def test_exponent_of_a_linear_delay_equation_is_its_largest_root():
    numeric = numeric_from("name: l\nstates: [x]\nparameters: {p: 1}\nforcing: {period: p}\nmodes: {m: {x': -x(t - 1) + sin(2*pi*t)}}\n")
    _, value, error = exponent(numeric, Clock(1.0, 0.0, 400.0, 4, 50), 400.0)
    assert error < 3e-3
    assert value == pytest.approx(lambertw(-1).real, abs=error)


@pytest.mark.parametrize(("name", "period", "given", "expected"), [
    ("pulsed_control", 1.0, {"b": 0.5, "q": 0.55}, math.log(0.9375213103)),
    ("wall_oscillator", math.pi, {}, math.log(abs(0.6829504 + 0.0321948j)) / math.pi),
    # The orbit takes two forcing periods.
    ("impact_oscillator", 2 * math.pi / 0.8, {"K": 0.12}, math.log(0.327612842) / (4 * math.pi / 0.8))])  # fmt: skip
def test_exponent_of_an_orbit_is_its_multiplier_s_logarithm(name, period, given, expected):
    _, value, error = exponent(shipped(name), Clock(period, 0.0, 400 * period, 8, 50), 300 * period, **given)
    assert error < 3e-3
    assert value == pytest.approx(expected, abs=error)


@pytest.mark.parametrize(("name", "event"), [("relay", "switch"), ("on_off_control", "switch"), ("spiking_neuron", "spike")])
def test_exponent_of_an_autonomous_orbit_is_zero(name, event):
    _, value, error = exponent(shipped(name), Clock(0.0, 0.0, 100.0, 4, 50), 200.0, Section(event=event))
    assert error < 0.01
    assert value == pytest.approx(0.0, abs=error)


def test_a_bouncing_ball_in_step_with_its_table():
    attractor, value, error = exponent(shipped("bouncing_ball"), Clock(2 * math.pi, 0.0, 3000.0, 8, 200), 2000.0, G=0.6)
    # The product of a bounce's multipliers is r^2, and they are complex: each has modulus r.
    assert (attractor.period, value) == (1, pytest.approx(math.log(0.8) / (2 * math.pi), abs=error))


@pytest.mark.parametrize(("direction", "reset", "expected"), [("falling", "v: -r*v", 1), ("any", "v: -r*v", 1), ("falling", "v: v", 0)])
def test_a_motion_that_starts_into_a_wall_is_turned_round(direction, reset, expected):
    text = ("name: ball\nstates: [y, v]\nparameters: {r: 0.8}\nmodes: {m: {y': v, v': -1}}\nevents: {hit: y}\n"
            f"resets: {{bounce: {{{reset}}}}}\nsegments: {{s: {{mode: m, event: hit, direction: {direction}, reset: bounce, to: m}}}}\n")
    trajectory = simulate(numeric_from(text), np.array([0.8]), DIRECT, 1.0, TIGHT, initial=[0.0, -1.0])
    assert len(trajectory.events) == expected
    assert trajectory(1.0)[0] == pytest.approx(0.8 - 0.5 if expected else -1.5, abs=1e-12)


def test_signals_read_the_history_that_the_step_gives(tmp_path):
    text = ("name: m\nstates: [x]\nparameters: {tau: 1}\nmodes: {m: {x': -x(t - tau)}}\ninitial: {x: 0.1}\nrun: {steps: [\n"
            "{name: c, simulate: {t_end: 0.5, initial: {x: 0.7, history: constant}, record: {signals: {d: x(t - tau)}}}},\n"
            "{name: h, simulate: {t_end: 0.5, initial: {history: {x: 2*t}}, record: {signals: {d: x(t - tau)}}}}]}\n")
    results = run_model(text, tmp_path / "s.h5")
    constant, given = (results.steps[name].orbit(0) for name in "ch")
    assert constant["signals"][:, 0] == pytest.approx(np.full(len(constant["time"]), 0.7))
    assert given["signals"][:, 0] == pytest.approx(2 * (given["time"] - 1), abs=1e-14)
