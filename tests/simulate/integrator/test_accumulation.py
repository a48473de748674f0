"""Events that accumulate, motions that come to lie on a surface, and sliding."""

import math

import numpy as np
import pytest

from pddecont.delay import Chain, Direct
from pddecont.errors import ConvergenceError
from pddecont.native.integrator import ZENO_TIME, Status
from pddecont.simulate import Method, simulate
from tests.conftest import numeric_from
from tests.runs import to_yaml
from tests.simulate.motions import BALL, COUNTER, RELAY, TIGHT, trajectory_of

WAITING = {
    "name": "waiting",
    "states": ["x", "c", "d"],
    "modes": {"go": {"x'": 1, "c'": 0, "d'": 0}, "hold": {"x'": 0, "c'": 1, "d'": 0}},
    "events": {"reach": "x - 1", "free": "c - 1"},
    "resets": {"wait": {"c": 0}, "back": {"x": "-d", "d": "d/2"}},
    "segments": {
        "hit": {"mode": "go", "event": "reach", "direction": "rising", "reset": "wait", "to": "hold"},
        "leave": {"mode": "hold", "event": "free", "direction": "rising", "reset": "back", "to": "go"},
    },
    "initial": {"x": 0, "d": 0.5},
}


@pytest.mark.parametrize("ratio", [0.2, 0.5, 0.9])
def test_gaps_that_shrink_by_a_ratio_end_at_the_sum_of_their_series(interpreted, ratio):
    run = interpreted.start(COUNTER.replace("H}", "c - 1}").replace("DIR", "any"), [1.0, 0.0])
    detect, t, gap = interpreted.accumulation.detect_accumulation, 0.0, 1.0
    while detect(run.core, 0, 0, t) != Status.ZENO:
        t, gap = t + gap, gap * ratio
        assert gap > 1e-30
    assert run.core.clock[ZENO_TIME] == pytest.approx(1 / (1 - ratio), abs=1e-9)


@pytest.mark.parametrize("gaps", [[1.0] * 40, [1.0, 0.5] * 20, [1.0, 0.5, 0.25] * 13, list(np.arange(1, 40))])
def test_gaps_that_do_not_shrink_for_ever_are_no_accumulation(interpreted, gaps):
    run = interpreted.start(COUNTER.replace("H}", "c - 1}").replace("DIR", "any"), [1.0, 0.0])
    for t in np.cumsum(gaps):
        assert interpreted.accumulation.detect_accumulation(run.core, 0, 0, t) == Status.REACHED


def test_gaps_that_shrink_towards_a_rest_of_their_own_are_no_accumulation():
    """A motion waits at the surface, one time unit each time, and comes back to it after 1 + 2^-n.

    Ratios of gaps come near to 1, and while it waits the event function stands still.
    """
    trajectory = trajectory_of(to_yaml(WAITING), 59.0)
    hits = trajectory.events.t[[name == "hit" for name in trajectory.events.segment]]
    assert np.diff(hits) == pytest.approx(2.0 + 0.5 ** np.arange(1, len(hits)), abs=1e-9)
    assert len(hits) == 29


def test_events_without_end_at_one_moment_accumulate(interpreted):
    run = interpreted.start(COUNTER.replace("H}", "c - 1}").replace("DIR", "any"), [1.0, 0.0])
    found = [interpreted.accumulation.detect_accumulation(run.core, 0, 0, 3.0) for _ in range(1100)]
    assert found.index(Status.ZENO) > 900


@pytest.mark.parametrize(
    ("v", "a", "rests"), [(0.0, -1.0, True), (1e-9, -1.0, True), (1e-3, -1.0, False), (0.0, 1.0, False)]
)
def test_a_motion_rests_that_is_pressed_on_a_surface(interpreted, v, a, rests):
    text = BALL.replace("-g", "a").replace("g: 9.81", "a: 1").replace("y\nresets", "y + 1e-17\nresets")
    run = interpreted.start(text, [0.0, v], p=np.array([a, 0.8]))
    assert interpreted.accumulation.is_at_rest(run.core, 0, -1, 0, 0.0, 1e-16) == rests


@pytest.mark.parametrize(("before", "after", "slides"), [(0, 1, True), (0, 0, False), (0, 2, False)])
def test_a_motion_slides_between_two_fields_that_point_at_the_surface(interpreted, before, after, slides):
    run = interpreted.start(RELAY.replace("H}", "x}").replace("parameters: {tau: 1}\n", ""), [0.0])
    assert interpreted.accumulation.is_sliding(run.core, 0, -1, before, after, 0.0, 0.0) == slides


def test_a_falling_ball_bounces_at_the_closed_form_times():
    """h = 1, g = 9.81, r = 0.8: impact k at sqrt(2/g) (1 + 2 (r + ... + r^(k-1))); they accumulate at 4.0637127689."""
    numeric = numeric_from(
        "name: ball\nstates: [y, v]\nparameters: {g: 9.81, r: 0.8}\nmodes: {m: {x': v}}\n".replace(
            "x': v", "y': v, v': -g"
        )
        + "events: {hit: y}\nresets: {b: {v: -r*v}}\n"
        "segments: {s: {mode: m, event: hit, direction: falling, reset: b, to: m}}\ninitial: {y: 1}\n"
    )
    trajectory = simulate(numeric, numeric.parameter_values, Chain(2, 15), 4.0, TIGHT)
    first = math.sqrt(2 / 9.81)
    expected = [first * (1 + 2 * sum(0.8**j for j in range(1, k))) for k in range(1, 16)]
    assert trajectory.events.t[:15] == pytest.approx(expected, abs=1e-10)
    with pytest.raises(ConvergenceError, match=r"accumulate at t = 4\.0637127688"):
        simulate(numeric, numeric.parameter_values, Chain(2, 15), 5.0, TIGHT)


def test_impacts_of_a_ball_accumulate_and_it_comes_to_lie():
    """Impact k at sqrt(2/g) (1 + 2 (r + ... + r^(k-1))) with speed r^(k-1) sqrt(2 g); the limit is sqrt(2/g) (1 + r)/(1
    - r).
    """
    trajectory = trajectory_of(BALL, 10.0, Method(1e-12, 1e-13, stick={"hit": "lie"}))
    k = np.arange(len(trajectory.events))
    first = math.sqrt(2 / 9.81)
    assert len(k) > 50
    assert trajectory.events.t == pytest.approx(first * (1 + 2 * (0.8 - 0.8 ** (k + 1)) / 0.2), abs=1e-11)
    assert -trajectory.events.before[:40, 1] == pytest.approx(math.sqrt(2 * 9.81) * 0.8 ** k[:40], rel=1e-11)
    rest = trajectory.time[trajectory.mode.index("lie")]
    assert rest == trajectory.events.t[-1]
    assert rest + measure_left_out(trajectory, 0.8) == pytest.approx(first * 9, abs=1e-11)
    assert rest == pytest.approx(4.0637127689, abs=1e-9)
    assert (trajectory.events.segment[-1], trajectory.events.after[-1, 1]) == ("hop>lie", 0.0)
    assert (trajectory.t_end, trajectory.mode[-1]) == (10.0, "lie")
    assert trajectory(10.0) == pytest.approx([0, 0], abs=1e-8)


def measure_left_out(trajectory, r, g=9.81):
    """Return how long the impacts go on that are not followed: flights of 2 v/g, with v less by r each time."""
    return -2 * trajectory.events.before[-1, 1] * r / (1 - r) / g


FLOOR = (
    "name: b\nstates: [y, v]\nparameters: {r: 0.8, floor: 0}\nmodes: {m: {y': v, v': -9.81}, lie: {y': 0, v': 0}}\n"
    "events: {hit: y - floor}\n"
    "resets: {b: {v: -r*v}}\nsegments: {s: {mode: m, event: hit, direction: falling, reset: b, to: m}}\n"
)


# The ball of r = 0.95 bounces for ever at rounding's height on a floor that is not at 0: t_end stops just after its
# last impact.
@pytest.mark.parametrize("floor", [0.0, 0.001, 1.0, 100.0])
@pytest.mark.parametrize("r", [0.0, 0.3, 0.5, 0.8, 0.95])
def test_a_ball_comes_to_lie_on_a_floor_at_any_height(r, floor):
    numeric = numeric_from(FLOOR)
    rest = math.sqrt(2 / 9.81) * (1 + r) / (1 - r)
    trajectory = simulate(
        numeric, np.array([r, floor]), Direct(), rest + 1e-4, Method(stick={"hit": "lie"}), initial=[floor + 1, 0.0]
    )
    assert trajectory.mode[-1] == "lie"
    lies = trajectory.time[trajectory.mode.index("lie")]
    assert lies + measure_left_out(trajectory, r) == pytest.approx(rest, abs=1e-6)
    assert trajectory.sample()[1][:, 0].min() > floor - 1e-9


@pytest.mark.parametrize("r", [0.3, 0.5])
def test_chatter_on_a_moving_table_never_passes_through_it(r):
    text = (
        "name: w\nstates: [x, v]\nparameters: {w: 1, A: 0.5, r: 0.5}\nforcing: {period: 2*pi/w}\nmodes: {m: {x': v, "
        "v': -1}}\n"
        "events: {hit: x - A*sin(w*t)}\nresets: {b: {v: -r*v + (1 + r)*A*w*cos(w*t)}}\n"
        "segments: {s: {mode: m, event: hit, direction: falling, reset: b, to: m}}\ninitial: {x: 2}\n"
    )
    numeric = numeric_from(text)
    with pytest.raises(ConvergenceError, match="accumulate"):
        simulate(numeric, np.array([1.0, 0.5, r]), Direct(), 30.0)


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
        simulate(numeric, np.array([tau]), Direct(), 5.0)
