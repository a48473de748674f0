"""How a simulation evaluates what a model reads of the past: lags, values, rates and integrals, one after another."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
import sympy
from numpy.typing import NDArray

from pddecont.codegen import NumericModel
from pddecont.model import TIME, Integral, Model
from pddecont.native.integrator import LEVELS

Array = NDArray[np.float64]
# The slot of a limit that is zero: such a lag is the present.
PRESENT = -1


class Turn(IntEnum):
    """What is evaluated next, as a number that machine code reads."""

    LAG = 0
    VALUE = 1
    INTEGRAL = 2


@dataclass(frozen=True)
class PastPlan:
    """The lags of a model, numbered as slots, and the order in which they and what is read are evaluated.

    Attributes
    ----------
    constant, varying
        Lags that depend on parameters alone, the model's constant delays first, and those that change along a motion;
        slots are numbered through both.
    slots
        The slot of each delayed value (n_delayed,).
    low, high
        The slots of each integral's limits (n_integrals,); PRESENT for zero.
    turns
        What to evaluate, in order: (kind, number), a lag by its number among ``varying``.
    gains
        By how many orders what a slot reads is smoother where it comes back (n_slots,): one through a value, two
        through a limit of integrals alone; more than are followed where a lag that varies is read by events alone.
    n_first
        So many turns come first; nothing but derivatives by lags that vary reads the values of the others.
    """

    constant: tuple[sympy.Expr, ...]
    varying: tuple[sympy.Expr, ...]
    slots: tuple[int, ...]
    low: tuple[int, ...]
    high: tuple[int, ...]
    turns: tuple[tuple[Turn, int], ...]
    gains: tuple[int, ...]
    n_first: int


def make_past_plan(model: Model, more_reads: Collection[sympy.Symbol] = ()) -> PastPlan:
    """Return how to evaluate what a model, and ``more_reads`` besides, read of the past."""
    limits = dict.fromkeys(limit for i in model.integrals for limit in (i.low, i.high) if limit != 0)
    known = set(model.parameter_symbols)
    more = [limit for limit in limits if limit not in (*model.delays, *model.varying)]
    constant = (*model.delays, *(e for e in more if e.free_symbols <= known))
    varying = (*model.varying, *(e for e in more if not e.free_symbols <= known))
    slot = {expr: k for k, expr in enumerate((*constant, *varying))}
    turns = _put_in_order(model, varying)
    inner = {s for e in (*varying, *limits) for s in e.free_symbols}
    late = [turn for turn in turns if _is_late(model, turn, more_reads, inner)]
    expressions = list(slot)
    slots = tuple(slot[model.find_delay(read)] for read in model.delayed)
    read = _list_read(model) | inner | set(more_reads)
    rough = {k for k, symbol in zip(slots, model.read_symbols, strict=False) if symbol in read}
    felt = set().union(inner, *(e.free_symbols for body in model.modes.values() for e in body))
    silent = rough - {k for k, symbol in zip(slots, model.read_symbols, strict=False) if symbol in felt}

    def find_slot(limit: sympy.Expr) -> int:
        return PRESENT if limit == 0 else slot[limit]

    def find_gain(k: int) -> int:
        # What modes given by equations read is not known before they are reached.
        if model.derived is not None:
            return 1
        if k >= len(constant) and k in silent and expressions[k] not in limits:
            return LEVELS + 1
        return 1 if k in rough else 2

    return PastPlan(
        constant,
        varying,
        slots,
        tuple(find_slot(i.low) for i in model.integrals),
        tuple(find_slot(i.high) for i in model.integrals),
        (*(turn for turn in turns if turn not in late), *late),
        tuple(find_gain(k) for k in range(len(slot))),
        len(turns) - len(late),
    )


def _is_late(model: Model, turn: tuple[Turn, int], read: Collection[sympy.Symbol], inner: set[sympy.Symbol]) -> bool:
    """Return whether a turn is that of a rate or an integral that nothing but derivatives reads.

    What modes given by equations read is not known before they are reached.
    """
    kind, i = turn
    if model.derived is not None or kind == Turn.LAG or (kind == Turn.VALUE and not model.delayed[i].derivative):
        return False
    symbol = model.read_symbols[i if kind == Turn.VALUE else len(model.delayed) + i]
    return symbol not in inner and symbol not in read and symbol not in _list_read(model)


def _list_read(model: Model) -> set[sympy.Symbol]:
    """Return the symbols that the modes, events and resets of a model hold."""
    exprs = [*(e for body in (*model.modes.values(), *model.resets.values()) for e in body)]
    exprs += [event.function for event in model.events.values() if event.function is not None]
    return set().union(*(e.free_symbols for e in exprs))


def _put_in_order(model: Model, varying: tuple[sympy.Expr, ...]) -> tuple[tuple[Turn, int], ...]:
    """Return the turns, each after those that it depends on."""
    number = {symbol: i for i, symbol in enumerate(model.read_symbols)}
    lag = {expr: k for k, expr in enumerate(varying)}
    turns: dict[tuple[Turn, int], None] = {}

    def take_lag(expr: sympy.Expr) -> None:
        for symbol in sorted(expr.free_symbols & number.keys(), key=number.__getitem__):
            take_read(number[symbol])
        if expr in lag:
            turns.setdefault((Turn.LAG, lag[expr]))

    def take_read(i: int) -> None:
        if i < len(model.delayed):
            take_lag(model.find_delay(model.delayed[i]))
            turns.setdefault((Turn.VALUE, i))
            return
        integral = model.integrals[i - len(model.delayed)]
        take_lag(integral.low)
        take_lag(integral.high)
        turns.setdefault((Turn.INTEGRAL, i - len(model.delayed)))

    for i in range(len(number)):
        take_read(i)
    return tuple(turns)


def evaluate_limits(numeric: NumericModel, plan: PastPlan, p: Array) -> Array:
    """Return the constant lags that are limits of integrals alone, shape (n_limits,)."""
    limits = plan.constant[len(numeric.model.delays) :]
    return numeric.parameter_function(limits).value(p) if limits else np.zeros(0)


def find_longest_lag(numeric: NumericModel, p: Array) -> float:
    """Return the longest of the constant delays and limits of integrals, 0 where there is none."""
    constant = make_past_plan(numeric.model).constant
    return float(np.max(numeric.parameter_function(constant).value(p), initial=0.0)) if constant else 0.0


def find_integrated(model: Model, integral: Integral) -> list[sympy.Symbol]:
    """Return the symbols of the states that an integrand reads."""
    return [symbol for symbol in model.state_symbols if symbol in integral.integrand.free_symbols]


def list_integrand_cases(model: Model) -> list[list[sympy.Expr]]:
    """Return what machine code evaluates of each integrand g: g itself, then dg/ds and dg/dx."""
    cases = []
    for integral in model.integrals:
        cases += [[integral.integrand], _list_slopes(model, integral)]
    return cases


def _list_slopes(model: Model, integral: Integral) -> list[sympy.Expr]:
    return [integral.integrand.diff(symbol) for symbol in (TIME, *model.state_symbols)]
