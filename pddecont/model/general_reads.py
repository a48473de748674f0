"""Whether a model reads its past in other ways than states a constant time ago, and what that rules out."""

from __future__ import annotations

from pddecont.model.system import Model


def reads_generally(model: Model) -> bool:
    """Return whether a model reads more than states a constant time ago."""
    return bool(model.varying or model.integrals or any(read.derivative for read in model.delayed))


def explain_direct_only(model: Model) -> str:
    """Return why delayed values of a model come from its past alone, by no chain or line; empty if they need not."""
    if model.varying:
        return f"the delay {model.varying[0]} varies along a motion"
    if any(read.derivative for read in model.delayed):
        return "the model reads rates of the past"
    return "the model has integrals over the past" if model.integrals else ""


def list_rates(model: Model) -> list[str]:
    """Return the rates x'(t - tau) that the modes of a model read, as they are written (a neutral equation)."""
    rates = {s for s, read in zip(model.delayed_symbols, model.delayed, strict=True) if read.derivative}
    exprs = [*model.varying, *(e for body in model.modes.values() for e in body)]
    return sorted(str(symbol) for symbol in rates & set().union(*(e.free_symbols for e in exprs)))
