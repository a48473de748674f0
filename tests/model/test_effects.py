"""What leaving effects out takes along, and the reasons that are given."""

import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.errors import PddecontError
from pddecont.model import leave_out_effects, load_model
from pddecont.model.reduction import ReferencedNames
from pddecont.model.system import make_symbol
from tests.conftest import ROOT, model_from

MODEL = load_model(str(ROOT / "models" / "impact_oscillator.yaml"))[0]
FULL = load_model(str(ROOT / "models" / "full_oscillator.yaml"))[0]


def test_feedback_off_takes_the_delay_along():
    left = leave_out_effects(MODEL, ["feedback"])
    assert left.delays == ()
    assert left.delayed == ()
    assert not any("K" in str(e) for e in left.modes["NC"])
    assert left.parameters["K"] == 0.0
    assert left.left_out.reasons == {
        "parameters": {"K": "set to 0 by leaving out effect 'feedback'"},
        "delayed": {"v(t - tau_d)": "nothing left reads it without effect 'feedback'"},
        "delays": {"tau_d": "nothing left is delayed by it without effect 'feedback'"},
    }


def test_impact_off_takes_the_contact_mode_along():
    left = leave_out_effects(MODEL, ["impact"])
    assert list(left.modes) == ["NC"]
    assert left.smooth
    reasons = left.left_out.reasons
    assert reasons["events"] == {"impact": "it never happens without effect 'impact'"}
    assert reasons["modes"] == {"C": "no segment left leads to it without effect 'impact'"}
    assert set(reasons["segments"]) == {"NC", "C"}


def test_nothing_left_out_leaves_the_model_as_it_is():
    assert leave_out_effects(MODEL, []) is MODEL
    assert MODEL.left_out.as_data() == {}


def test_the_effects_that_are_still_in_are_told_from_those_that_are_not():
    left = leave_out_effects(MODEL, ["impact", "impact"])
    assert list(left.effects) == ["feedback", "damping"]
    assert left.left_out.effects == ("impact",)


def test_an_unknown_effect():
    with pytest.raises(PddecontError, match="did you mean 'damping'"):
        leave_out_effects(MODEL, ["dampin"])


def test_a_follower_goes_with_its_reader_and_the_blame_is_on_the_effect_that_did_it():
    left = leave_out_effects(FULL, ["damping", "feedback"])
    assert left.states == ("x", "v")
    assert left.left_out.reasons["states"] == {"w": "nothing left reads it without effect 'feedback'"}
    assert all(len(body) == 2 for body in (*left.modes.values(), *left.resets.values(), left.history))
    assert [left.states[d.state] for d in left.delayed] == ["x"]


def test_what_two_effects_need_together_is_blamed_on_both():
    left = leave_out_effects(FULL, ["friction", "impact"])
    assert list(left.modes) == ["free_up"]
    assert left.left_out.reasons["modes"]["free_down"].endswith("without effect 'friction'")
    assert left.left_out.reasons["modes"]["hit_down"].endswith("without effects 'friction', 'impact'")


def chain(f_x, f_y, f_z="0", effects="effects: {link: {set: {k: 0}}}", more=""):
    return model_from(
        f"name: m\nstates: [x, y, z]\nparameters: {{k: 1, T: 2}}\nmodes: {{m: {{x': {f_x}, y': {f_y}, z': {f_z}}}}}\n"
        f"{effects}\n{more}"
    )


@pytest.mark.parametrize(
    ("f_x", "f_y", "f_z", "left"),
    [
        ("-x + k*y", "1", "-z + x", "xz"),  # a clock that fed x; z, which nothing ever read, is an output
        ("-x + k*z", "(x - y)/T", "(y - z)/T", "x"),  # a filter behind a filter
        ("-x + k*(y - x)", "-y + k*(x - y)", "0", "xyz"),  # two motions that were coupled both ways; z stands alone
        ("-x + k*y", "z - y", "y - z", "x"),  # a generator of two states goes as a whole
        ("-x", "-y + x", "-z + k*x", "xyz"),  # outputs that nothing ever read
        ("-x + y", "-y + k*z", "-z", "xy"),  # only the far end of a chain
        ("-x + y*k + y*T", "-y", "0", "xyz"),  # still read by another term
    ],
)
def test_states_that_nothing_left_reads(f_x, f_y, f_z, left):
    assert "".join(leave_out_effects(chain(f_x, f_y, f_z), ["link"]).states) == left


def test_a_delayed_reader_is_a_reader_too():
    model = chain("-x + k*y(t - 1) + y(t - T)", "x - y")
    assert leave_out_effects(model, ["link"]).states == ("x", "y", "z")
    assert [str(d) for d in leave_out_effects(model, ["link"]).delays] == ["T"]
    assert leave_out_effects(chain("-x + k*y(t - 1)", "x - y"), ["link"]).states == ("x", "z")


def test_a_reset_is_a_reader_too():
    more = "events: {hit: x - 1}\nresets: {jump: {x: z}}\nsegments: {s: {mode: m, event: hit, reset: jump, to: m}}\n"
    assert leave_out_effects(chain("-x + k*z", "x - y", "x - z", more=more), ["link"]).states == ("x", "y", "z")
    text = "effects: {link: {set: {k: 0}}, hits: {drop: [hit]}}"
    assert leave_out_effects(chain("-x + k*z", "x - y", "x - z", text, more), ["link", "hits"]).states == ("x", "y")


def test_a_clock_stays_as_long_as_its_event_can_happen():
    bolus = load_model(str(ROOT / "models" / "bolus.yaml"))[0]
    assert "clock" in bolus.states
    left = leave_out_effects(bolus, ["dose"])
    assert left.states == ("u1", "u2")
    assert left.left_out.reasons["states"] == {"clock": "nothing left reads it without effect 'dose'"}


def test_states_that_a_run_names_stay_by_name_or_through_a_definition():
    assert leave_out_effects(FULL, ["feedback"], ReferencedNames(frozenset({"w"}))).states == ("x", "v", "w")
    assert leave_out_effects(FULL, ["feedback"], ReferencedNames(frozenset({"filter"}))).states == ("x", "v", "w")
    assert "filter" not in leave_out_effects(FULL, ["feedback"]).definitions


def test_a_delay_that_becomes_zero_is_none():
    left = leave_out_effects(
        chain("-x(t - T)", "y(t - k)*x(t - T - k)", effects="effects: {late: {set: {k: 0}}, fast: {set: {T: 0}}}"),
        ["late"],
    )
    assert [s.name for s in left.delayed_symbols] == ["x(t - T)"]
    assert left.modes["m"][1] == make_symbol("y") * sympy.Symbol("x(t - T)", real=True)
    assert left.left_out.reasons["delayed"] == {"y(t - k)": "its delay is 0 without effect 'late'"}
    assert (
        leave_out_effects(
            chain("-x(t - T)", "y(t - k)*x(t - T - k)", effects="effects: {all: {set: {k: 0, T: 0}}}"), ["all"]
        ).delays
        == ()
    )


def test_an_event_whose_function_changes_no_more_is_none():
    more = "events: {hit: k*x - 1}\nsegments: {s: {mode: m, event: hit, to: m}}\n"
    left = leave_out_effects(chain("-x", "-y", more=more), ["link"])
    assert left.smooth
    assert left.left_out.reasons["events"] == {"hit": "its function changes no more without effect 'link'"}


def test_events_after_an_event_that_never_happens_go_too():
    more = (
        "events: {hit: x - 1, kick: {after: hit, delay: T}, echo: {after: kick, delay: T}}\nresets: {jump: {y: 0}}\n"
        "segments: {s: {mode: m, event: hit, to: m}, k: {mode: m, event: kick, reset: jump, to: m},\n"
        "  e: {mode: m, event: echo, to: m}}\n"
    )
    left = leave_out_effects(chain("-x", "-y", effects="effects: {hits: {drop: [hit]}}", more=more), ["hits"])
    assert left.events == {}
    assert left.segments == {}
    assert set(left.resets) == {"identity"}
    assert (
        left.left_out.reasons["events"]["echo"] == "'kick', which it comes after, never happens without effect 'hits'"
    )


def test_modes_that_only_a_run_leads_to_stay():
    more = (
        "events: {hit: x - 1}\nsegments: {s: {mode: m, event: hit, to: n}, back: {mode: n, event: hit, direction: "
        "falling, to: m}, "
        "r: {mode: rest, event: hit, to: m}}\n"
    )
    model = model_from(
        "name: m\nstates: [x]\nparameters: {k: 1}\nmodes: {m: {x': 1 + k}, n: {x': -1}, rest: {x': 0}}\n"
        f"effects: {{hits: {{drop: [hit]}}, link: {{set: {{k: 0}}}}}}\n{more}"
    )
    assert list(leave_out_effects(model, ["link"]).modes) == ["m", "n", "rest"]
    assert list(leave_out_effects(model, ["hits"]).modes) == ["m", "rest"]
    assert list(leave_out_effects(model, ["hits"], ReferencedNames(modes=frozenset({"n"}))).modes) == ["m", "n", "rest"]


def test_forcing_goes_with_the_last_t():
    left = leave_out_effects(FULL, ["forcing"])
    assert not left.forced
    assert left.left_out.reasons["forcing"] == {"period": "'t' appears nowhere any more without effect 'forcing'"}
    assert leave_out_effects(FULL, ["damping"]).forced


def test_whole_numbers_written_as_decimals_leave_no_trace():
    exact, decimal = (
        chain("-x + k*y", "-y + k", effects=f"effects: {{link: {{set: {{k: {k}}}}}}}") for k in ("1", "1.0")
    )
    assert leave_out_effects(exact, ["link"]).modes == leave_out_effects(decimal, ["link"]).modes


def test_effects_that_contradict_each_other_or_divide_by_zero_are_refused():
    two = "effects: {one: {set: {k: 0}}, same: {set: {k: 0}}, other: {set: {k: 2}}, stop: {set: {T: 0}}}"
    model = chain("-x + k*y", "(x - y)/T + x*T", effects=two)
    assert leave_out_effects(model, ["one", "same"]).parameters["k"] == 0.0
    with pytest.raises(
        PddecontError, match="effects 'one' and 'other' cannot both be left out: they set 'k' to 0 and to 2"
    ):
        leave_out_effects(model, ["one", "other"])
    with pytest.raises(
        PddecontError, match="effect 'stop' cannot be left out: a formula of model 'm' then divides by zero"
    ):
        leave_out_effects(model, ["stop"])


def test_values_in_terms_of_other_parameters_follow_them_and_circles_are_refused():
    text = "effects: {equal: {set: {k: 2*T}}, one: {set: {T: 1}}, turn: {set: {T: k}}}"
    model = chain("-k*x", "-T*y", effects=text)
    assert leave_out_effects(model, ["equal"]).modes["m"][0] == -2 * make_symbol("T") * make_symbol("x")
    assert leave_out_effects(model, ["equal"]).parameters["k"] == 4.0
    assert leave_out_effects(model, ["equal", "one"]).parameters["k"] == 2.0
    with pytest.raises(PddecontError, match="in a circle"):
        leave_out_effects(model, ["equal", "turn"])


@st.composite
def networks(draw):
    """Linear systems in which states read one another, now or delayed, through couplings that effects can cut."""
    n = draw(st.integers(2, 5))
    couplings = draw(
        st.lists(st.tuples(st.integers(0, n - 1), st.integers(0, n - 1), st.booleans(), st.integers(0, 2)), max_size=8)
    )
    off = draw(st.sets(st.integers(0, 2)))
    return n, [c for c in couplings if c[0] != c[1]], off


@given(networks())
@settings(max_examples=60, deadline=None)
def test_equations_of_kept_states_are_those_of_the_full_model_with_the_values_put_in(network):
    n, couplings, off = network
    bodies = [
        f"-s{i}" + "".join(f" + k{k}*s{j}{'(t - 1)' if late else ''}" for i_, j, late, k in couplings if i_ == i)
        for i in range(n)
    ]
    states = [f"s{i}" for i in range(n)]
    model = model_from(
        f"name: m\nstates: [{', '.join(states)}]\nparameters: {{k0: 1, k1: 2, k2: 3}}\n"
        f"modes: {{m: {{{', '.join(f'''{s}': {b}''' for s, b in zip(states, bodies, strict=True))}}}}}\n"
        "effects: {e0: {set: {k0: 0}}, e1: {set: {k1: 0}}, e2: {set: {k2: 0}}}\n"
    )
    left = leave_out_effects(model, [f"e{k}" for k in sorted(off)])
    assert left.states[0] == "s0"
    values = {make_symbol(f"k{k}"): 0 for k in off}
    there = {*left.state_symbols, *left.delayed_symbols, *left.parameter_symbols}
    full = dict(zip(model.states, model.modes["m"], strict=True))
    for state, body in zip(left.states, left.modes["m"], strict=True):
        # Nothing that is left reads what is gone, so the kept states move as they did.
        assert body == full[state].subs(values)
        assert body.free_symbols <= there
    # Only what lost a reader goes.
    for state in set(model.states) - set(left.states):
        assert any(j == int(state[1:]) and k in off for _, j, _, k in couplings) or any(
            j == int(state[1:]) and f"s{i}" not in left.states for i, j, _, _ in couplings
        )
