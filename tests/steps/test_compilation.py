"""A run that waits for the compiler says so once, whichever of its steps needs machine code first."""

import pytest

from pddecont.codegen import compilation
from pddecont.steps import Silent
from pddecont.steps.execution import execute, orbit_rows
from tests.runs import plan

RUN = {
    "model": "wall_oscillator",
    "mesh": {"degree": 4, "intervals": 10},
    "steps": [
        {"name": "transient", "simulate": {"t_end": "80*pi"}},
        {"name": "orbit", "orbit": {"from": "transient"}},
        {"name": "branch", "continue": {"from": "orbit", "free": ["r"], "range": {"r": [0.79, 0.8]}, "max_points": 2}},
    ],
}


class Listener(Silent):
    def __init__(self):
        self.heard = []

    def step(self, name, kind):
        self.heard.append(name)

    def note(self, text):
        self.heard.append(text.split(",")[0])


def half(x):
    return x / 2


@pytest.fixture
def transient(tmp_path):
    path = tmp_path / "a.h5"
    execute(plan(RUN), path, until="transient")
    return path


@pytest.fixture
def referee_is_compiled(tmp_path, monkeypatch):
    """What simulates the orbits of a step is compiled anew, into a folder of its own."""
    make_referee = orbit_rows.make_referee

    def compile_anew(*args):
        compilation.compile_when_called(half, tmp_path / "machine_code")(1.0)
        return make_referee(*args)

    for module in ("orbit", "branch_start", "continuation"):
        monkeypatch.setattr(f"pddecont.steps.execution.{module}.make_referee", compile_anew, raising=False)


def test_orbits_that_are_simulated_say_once_that_the_integrator_is_compiled(transient, referee_is_compiled):
    listener = Listener()
    execute(plan(RUN), transient, listener, resume=True)
    assert listener.heard == ["transient", "orbit", "the integrator is compiled", "branch"]
    assert list((transient.parent / "machine_code").rglob("*.nbi"))


def test_nothing_is_said_where_nothing_is_compiled(transient):
    listener = Listener()
    execute(plan(RUN), transient, listener, resume=True)
    assert listener.heard == ["transient", "orbit", "branch"]
