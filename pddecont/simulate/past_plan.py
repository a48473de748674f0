"""How a simulation evaluates what a model reads of the past: lags, values, rates and integrals, one after another."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
import sympy
from numpy.typing import NDArray

from pddecont.codegen import NumericModel
from pddecont.memo import cached_property
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


@dataclass(frozen=True)
class _Readers:
    """Symbols by what holds them: vector fields, events and resets, lags and limits, and what is read besides."""

    fields: set[sympy.Symbol]
    events: set[sympy.Symbol]
    lags: set[sympy.Symbol]
    others: set[sympy.Symbol]

    @cached_property
    def every(self) -> set[sympy.Symbol]:
        """The symbols that anything holds; derivatives alone may read more."""
        return self.fields | self.events | self.lags | self.others


def make_past_plan(model: Model, more_reads: Collection[sympy.Symbol] = ()) -> PastPlan:
    """Return how to evaluate what a model, and ``more_reads`` besides, read of the past."""
    limits = tuple(dict.fromkeys(limit for i in model.integrals for limit in (i.low, i.high) if limit != 0))
    constant, varying = _list_lags(model, limits)
    slot = {lag: k for k, lag in enumerate((*constant, *varying))}

    def find_slot(limit: sympy.Expr) -> int:
        return PRESENT if limit == 0 else slot[limit]

    readers = _list_readers(model, (*varying, *limits), more_reads)
    turns = _put_in_order(model, varying)
    late = [turn for turn in turns if _is_late(model, turn, readers)]
    return PastPlan(
        constant,
        varying,
        tuple(slot[model.find_delay(read)] for read in model.delayed),
        tuple(find_slot(i.low) for i in model.integrals),
        tuple(find_slot(i.high) for i in model.integrals),
        (*(turn for turn in turns if turn not in late), *late),
        tuple(_find_gain(model, lag, lag in varying and lag not in limits, readers) for lag in slot),
        len(turns) - len(late),
    )


def _list_lags(model: Model, limits: tuple[sympy.Expr, ...]) -> tuple[tuple[sympy.Expr, ...], tuple[sympy.Expr, ...]]:
    """Return the lags that depend on parameters alone, and those that change: those of the model, then other limits."""
    known = set(model.parameter_symbols)
    more = [limit for limit in limits if limit not in (*model.delays, *model.varying)]
    constant = (*model.delays, *(e for e in more if e.free_symbols <= known))
    return constant, (*model.varying, *(e for e in more if not e.free_symbols <= known))


def _list_readers(model: Model, lags: Collection[sympy.Expr], others: Collection[sympy.Symbol]) -> _Readers:
    functions = [event.function for event in model.events.values() if event.function is not None]
    resets = [e for body in model.resets.values() for e in body]
    fields = [e for body in model.modes.values() for e in body]
    return _Readers(_list_symbols(fields), _list_symbols([*functions, *resets]), _list_symbols(lags), set(others))


def _list_symbols(exprs: Collection[sympy.Expr]) -> set[sympy.Symbol]:
    return set().union(*(e.free_symbols for e in exprs))


def _find_gain(model: Model, lag: sympy.Expr, shifts_alone: bool, readers: _Readers) -> int:
    """Return by how many orders what is read by a lag is smoother where it comes back.

    ``shifts_alone`` says of a lag that it varies and is no limit of an integral. What modes given by equations read is
    not known before they are reached.
    """
    if model.derived is not None:
        return 1
    pairs = zip(model.delayed, model.delayed_symbols, strict=True)
    values = {symbol for read, symbol in pairs if model.find_delay(read) == lag}
    if not values & readers.every:
        return 2
    in_events_alone = shifts_alone and not values & (readers.fields | readers.lags)
    return LEVELS + 1 if in_events_alone else 1


def _is_late(model: Model, turn: tuple[Turn, int], readers: _Readers) -> bool:
    """Return whether a turn is that of a rate or an integral that nothing but derivatives reads.

    What modes given by equations read is not known before they are reached.
    """
    kind, i = turn
    if model.derived is not None or kind == Turn.LAG or (kind == Turn.VALUE and not model.delayed[i].derivative):
        return False
    return model.read_symbols[i if kind == Turn.VALUE else len(model.delayed) + i] not in readers.every


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
