"""A model without some of its effects: the terms, delays, events, modes and states that nothing left needs are gone."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import replace

import sympy

from pddecont.errors import PddecontError, suggest
from pddecont.model.expression import substitute
from pddecont.model.lagged import make_symbol
from pddecont.model.left_out import LeftOut
from pddecont.model.reduction import KINDS, Reasons, Reduction, ReferencedNames, check_finite, reduce_model
from pddecont.model.syntax import ExpressionError
from pddecont.model.system import Model


def leave_out_effects(model: Model, off: Iterable[str], named: ReferencedNames | None = None) -> Model:
    """Return the model without the effects named in ``off``; ``left_out`` of it tells what went with them.

    Raises
    ------
    PddecontError
        If an effect is unknown, two effects set a parameter to different values, or a formula is not finite without
        them.
    """
    names, named = tuple(dict.fromkeys(off)), named or ReferencedNames()
    for name in names:
        if name not in model.effects:
            raise PddecontError(
                f"'{name}' is not an effect of model '{model.name}'{suggest(name, model.effects)} "
                f"(effects: {', '.join(model.effects) or 'none'})"
            )
    if not names:
        return model
    fixed = resolve_fixed_values(model, names)
    try:
        left = _cut(model, names, named)
        check_finite(left.model)
    except ExpressionError as exc:
        raise PddecontError(
            f"{_effects(names)} cannot be left out: a formula of model '{model.name}' then divides by zero"
        ) from exc
    put_back = {name: _cut(model, [n for n in names if n != name], named).reasons for name in names}
    alone = {name: _cut(model, [name], named).reasons for name in names}
    reasons: Reasons = {"parameters": {}}
    for parameter, value in fixed.items():
        setters = [name for name in names if parameter in model.effects[name].set]
        reasons["parameters"][parameter] = f"set to {value} by leaving out {_effects(setters)}"
    for kind, gone in left.reasons.items():
        for item, why in gone.items():
            needed = [name for name in names if item not in put_back[name][kind]]
            guilty = needed or [name for name in names if item in alone[name][kind]] or names
            reasons.setdefault(kind, {})[item] = f"{why} without {_effects(guilty)}"
    left_out = LeftOut(names, {kind: reasons[kind] for kind in ("parameters", *KINDS) if reasons.get(kind)})
    return replace(left.model, left_out=left_out, effects={k: e for k, e in model.effects.items() if k not in names})


def resolve_fixed_values(model: Model, off: Iterable[str]) -> dict[str, sympy.Expr]:
    """Return the parameters that the effects ``off`` set, as expressions in those that they do not."""
    values: dict[str, sympy.Expr] = {}
    by: dict[str, str] = {}
    for effect in off:
        for name, given in model.effects[effect].set.items():
            value = sympy.Integer(int(given)) if given.is_Float and float(given).is_integer() else given
            if name in values and values[name] != value:
                raise PddecontError(
                    f"effects '{by[name]}' and '{effect}' cannot both be left out: they set '{name}' to "
                    f"{values[name]} and "
                    f"to {value}"
                )
            values[name], by[name] = value, effect
    symbols = {make_symbol(name): value for name, value in values.items()}
    for _ in values:
        values = {name: substitute(value, symbols) for name, value in values.items()}
    for name, value in values.items():
        if value.free_symbols & set(symbols):
            raise PddecontError(
                f"effect '{by[name]}' cannot be left out: it sets '{name}' to {value}, which other effects set in a "
                f"circle"
            )
    return values


def _cut(model: Model, off: Collection[str], named: ReferencedNames) -> Reduction:
    dropped = {event for name in off for event in model.effects[name].drop}
    return reduce_model(model, resolve_fixed_values(model, off), dropped, named)


def _effects(names: Collection[str]) -> str:
    return f"effect{'s' if len(names) > 1 else ''} {', '.join(repr(n) for n in names)}"
