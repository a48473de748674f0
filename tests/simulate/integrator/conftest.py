"""The integrator as plain Python, for tests of functions that only machine code can call.

Pointers are views of arrays there, and a model's functions are called by Python.
"""

from __future__ import annotations

import importlib
import sys
import types
from types import SimpleNamespace

import pytest

import pddecont.simulate.integrator
from pddecont.codegen import ModelFunctions, machine_code
from pddecont.delay import Direct
from pddecont.simulate.method import Method
from pddecont.simulate.model_numbers import make_values
from pddecont.simulate.reached_system import ReachedSystem
from pddecont.simulate.returns import ReturnSection
from tests.conftest import numeric_from

NAME = "pddecont.simulate.integrator"


def plain(function):
    return function


# What machine code is called by its address; no address is 0.
FUNCTIONS = [None]


def fake_calls():
    calls = types.ModuleType(f"{NAME}.calls")
    calls.entry = calls.internal = calls.inlined = calls.either = plain
    calls.pointer = lambda array: array.reshape(-1)
    calls.offset = lambda pointer, count: pointer[count:]
    calls.call = lambda address, *arguments: FUNCTIONS[address](*arguments)
    return calls


class Interpreted:
    """The modules of the integrator, imported anew without a compiler."""

    def __init__(self):
        whole = {name: module for name, module in sys.modules.items() if name.split(".")[:3] == NAME.split(".")}
        for name in whole:
            del sys.modules[name]
        package = types.ModuleType(NAME)
        package.__path__ = pddecont.simulate.integrator.__path__
        sys.modules[NAME], sys.modules[f"{NAME}.calls"] = package, fake_calls()
        try:
            for name in ("classification", "tangent_growth", "advance", "poincare"):
                importlib.import_module(f"{NAME}.{name}")
            modules = {
                name.rpartition(".")[2]: module for name, module in sys.modules.items() if name.startswith(f"{NAME}.")
            }
        finally:
            for name in [name for name in sys.modules if name.split(".")[:3] == NAME.split(".")]:
                del sys.modules[name]
            sys.modules.update(whole)
        self.__dict__.update(modules)

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
        state, work = self.state.make_state(system, values), self.buffers.make_workspace(system)
        log = self.buffers.make_log(system.n, steps, events)
        core = self.core.make_core(system, values, state, log, work)
        return SimpleNamespace(
            numeric=numeric, system=system, values=values, state=state, work=work, log=log, core=core
        )

    def start(self, text, states, p=None, t=0.0, mode=0, **given):
        """Return an integration of a model's text that begins at given states."""
        run = self.prepare(text, p, **given)
        run.state.y[: run.system.n] = states
        self.advance.initialise(run.system, run.values, run.state, run.work, t, mode)
        return run


def number_of(source):
    """Return the address of a generated source: its place among the functions made so far."""
    namespace = {}
    exec(source, namespace)
    FUNCTIONS.append(namespace["generated"])
    return len(FUNCTIONS) - 1


@pytest.fixture(scope="session")
def interpreted():
    return Interpreted()
