"""The chain's stages as states: the paper's equations, and the generated chain of oscillators."""

import subprocess
import sys

import sympy

from pddecont.model.chain_states import add_chain_states, name_stage
from pddecont.model.system import make_symbol
from tests.conftest import ROOT, model_from


def test_two_stages_of_order_two_are_eq_2_7():
    model = add_chain_states(
        model_from("name: m\nstates: [x]\nparameters: {tau: 3}\nmodes: {m: {x': -x(t - tau)}}\n"), 2, 2
    )
    (u1, w1), (u2, w2) = ([make_symbol(name_stage("x", 0, stage, k)) for k in range(2)] for stage in (1, 2))
    x, delta = make_symbol("x"), make_symbol("tau") / 2
    assert [s.name for s in model.state_symbols[1:]] == [u1.name, w1.name, u2.name, w2.name]
    equations = model.modes["m"]
    assert equations[0] == -u2
    # u + delta u' + delta^2/2 u'' = input, with w = delta u'
    for u, w, before, du, dw in ((u1, w1, x, *equations[1:3]), (u2, w2, u1, *equations[3:5])):
        assert sympy.simplify(du - w / delta) == 0
        assert sympy.simplify(u + delta * du + delta * dw / 2 - before) == 0
    assert not model.delays and not model.delayed


def test_the_chain_of_oscillators_is_what_its_script_writes():
    written = subprocess.run(
        [sys.executable, "models/oscillator_chain.py", "50"], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert (ROOT / "models" / "oscillator_chain_50.yaml").read_text() == written.stdout
