"""The integrator as plain Python, for tests of functions that only machine code can call.

Pointers are views of arrays there, and a model's functions are called by Python.
"""

from __future__ import annotations

import importlib
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from pddecont.codegen import ModelFunctions, machine_code
from pddecont.delay import Direct
from pddecont.native.integrator import places
from pddecont.simulate import integrator
from pddecont.simulate.integrator import make_core
from pddecont.simulate.method import Method
from pddecont.simulate.model_numbers import make_values
from pddecont.simulate.reached_system import ReachedSystem
from pddecont.simulate.returns import ReturnSection
from tests.conftest import numeric_from

NAME = "pddecont.native.integrator"

# What is called by its address; no address is 0.
FUNCTIONS = [None]


class Interpreted:
    """The modules of the integrator, as they are before they are compiled, with what makes their records."""

    def __init__(self):
        for path in Path(places.__file__).parent.glob("*.py"):
            module = importlib.import_module(f"{NAME}.{path.stem}")
            setattr(self, path.stem, module)
            if path.stem != "calls" and hasattr(module, "call"):
                module.call = lambda address, *arguments: FUNCTIONS[address](*arguments)

    def prepare(
        self, text, p=None, *, delay=None, method=None, section=None, tangent=False, steps=0, events=0, longest=0.0
    ):
        """Return an integration of a model's text that has not begun, in its records and as a core."""
        numeric, method, section = numeric_from(text), method or Method(), section or ReturnSection()
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(machine_code, "load_machine_code", lambda source: SimpleNamespace(address=number_of(source)))
            reached = ReachedSystem(
                numeric, ModelFunctions(numeric.model), delay or Direct(), method, section, tangent=tangent
            )
            system = reached.system
        p = numeric.parameter_values if p is None else p
        values = make_values(numeric, reached.tables, delay or Direct(), method, p, longest)
        state, work = integrator.make_state(system, values), integrator.make_workspace(system)
        log = integrator.make_log(system.n, steps, events)
        core = make_plain_core(system, values, state, log, work)
        return SimpleNamespace(
            numeric=numeric, system=system, values=values, state=state, work=work, log=log, core=core
        )

    def start(self, text, states, p=None, t=0.0, mode=0, **given):
        """Return an integration of a model's text that begins at given states."""
        run = self.prepare(text, p, **given)
        run.state.y[: run.system.n] = states
        self.advance.initialise(run.core, t, mode)
        return run


def make_plain_core(*records):
    """Return an integration for plain Python, with arrays whose entries are numbered through."""
    core = make_core(*records)
    return core._make(part.reshape(-1) if isinstance(part, np.ndarray) else part for part in core)


def number_of(source):
    """Return the address of a generated source: its place among the functions made so far."""
    namespace = {}
    exec(source, namespace)
    FUNCTIONS.append(namespace["generated"])
    return len(FUNCTIONS) - 1


@pytest.fixture(scope="session")
def interpreted():
    return Interpreted()
