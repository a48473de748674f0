"""Where motions go on after an event: the digits that have to be read anew, and what decides each of them.

Digits that do not depend on each other are decided one after another, each by a rule of its own; only those of which
one hangs on the other, such as two surfaces along which a motion may slide at once, are decided together.
"""

from __future__ import annotations

from collections.abc import Collection, Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product

import sympy
from sympy.logic.boolalg import Boolean
from sympy.utilities.iterables import strongly_connected_components

from pddecont.model.conditions import holds
from pddecont.model.evaluation import evaluate
from pddecont.model.sliding import FIXED, Surfaces, put_in
from pddecont.model.switches import ABOVE, BELOW, ON, OPEN, Digits

# Digits that hang together have at most so many combinations with a condition each; of more only the signs of their
# functions are looked at, and what signs leave open is asked of the numbers at that moment.
MAX_TOGETHER = 16
# So many combinations are listed at most: more than modes that a file by hand may have.
MOST_LISTED = 512


@dataclass(frozen=True)
class Undecided:
    """A switch whose digit has to be read anew: the digits it may have, and whether its function is zero."""

    options: tuple[int, ...]
    on_surface: bool = False


@dataclass(frozen=True)
class Decision:
    """Digits that are chosen together: the first of the ``options`` whose rule holds in the states after an event.

    Rules are conditions in the digits of the other switches: many modes share one. Where ``is_open`` none of them may
    hold, and the numbers decide all digits at once (:func:`choose_digits`).
    """

    numbers: tuple[int, ...]
    options: tuple[Digits, ...]
    rules: tuple[Boolean, ...]
    is_open: bool = False


@dataclass
class WayFinder:
    """Finds where motions go on; what it has worked out once it knows."""

    surfaces: Surfaces
    _rules: dict[Hashable, tuple[Boolean, ...]] = field(default_factory=dict)
    _guards: dict[Hashable, Boolean] = field(default_factory=dict)

    def list_decisions(self, after: Digits, undecided: Mapping[int, Undecided]) -> tuple[Decision, ...]:
        """Return what decides the ``undecided`` digits, in order: each needs only those before it."""
        found: list[Decision] = []
        for group in _group(self.surfaces, after, undecided):
            own = {k: undecided[k] for k in group}
            options = self._list_options(after, undecided, own)
            if len(options) <= MAX_TOGETHER:
                found.append(self._decide(after, undecided, own, options))
                continue
            contacts = {k for k in group if self.surfaces.equations.switches[k].contact is not None}
            signs = [k for k in group if not undecided[k].on_surface and k not in contacts]
            found += (self._read_sign(after, undecided, k) for k in signs)
            rest = {k: undecided[k] for k in group if k not in signs}
            if rest:
                found.append(Decision(tuple(rest), self._list_options(after, undecided, rest), (), is_open=True))
        return tuple(found)

    def find_guard(self, decisions: Sequence[Decision], digits: Digits) -> Boolean:
        """Return the condition under which decisions lead to some digits."""
        return sympy.And(*(self._find_own_guard(decision, digits) for decision in decisions))

    def _decide(
        self,
        after: Digits,
        undecided: Mapping[int, Undecided],
        own: Mapping[int, Undecided],
        options: tuple[Digits, ...],
    ) -> Decision:
        """Return the decision on digits that hang together; options that the other digits rule out are left out."""
        beside = _replace(after, dict.fromkeys(undecided, BELOW))
        options = tuple(o for o in options if self.surfaces.may_slide(_replace(beside, dict(zip(own, o, strict=True)))))
        kept = _open_all(after, undecided)
        key = kept, tuple(own.items()), tuple(after[k] for k in own), options
        if key not in self._rules:
            changed = [_replace(kept, dict(zip(own, chosen, strict=True))) for chosen in options]
            self._rules[key] = _list_rules(self.surfaces, changed, after, own)
        rules, known = self._rules[key], _replace(after, dict.fromkeys(undecided, OPEN))
        guards = [self._put_in(rule, known) for rule in rules]
        # What comes after a condition that always holds never happens.
        end = next((i + 1 for i, guard in enumerate(guards) if guard == sympy.true), len(guards))
        left = [i for i in range(end) if guards[i] != sympy.false]
        return Decision(tuple(own), tuple(options[i] for i in left), tuple(rules[i] for i in left))

    def _read_sign(self, after: Digits, undecided: Mapping[int, Undecided], number: int) -> Decision:
        """Return the decision by the sign of a switch's function; it is open where the function is zero."""
        kept = _open_all(after, undecided)
        u = put_in(self.surfaces.equations.switches[number].argument, self.surfaces.find_values(kept))
        options = tuple((d,) for d in undecided[number].options if d != ON)
        return Decision((number,), options, tuple(u > 0 if d == (ABOVE,) else u < 0 for d in options), is_open=True)

    def _list_options(
        self, after: Digits, undecided: Mapping[int, Undecided], own: Mapping[int, Undecided]
    ) -> tuple[Digits, ...]:
        """Return the digits that do not exclude each other; of very many some."""
        known = _replace(after, dict.fromkeys(undecided, OPEN))
        found: list[Digits] = [()]
        for n, k in enumerate(own):
            longer = [(*option, digit) for option in found[:MOST_LISTED] for digit in own[k].options]
            numbers = tuple(own)[: n + 1]
            found = [o for o in longer if self.surfaces.agree(_replace(known, dict(zip(numbers, o, strict=True))))]
        return tuple(found)

    def _find_own_guard(self, decision: Decision, digits: Digits) -> Boolean:
        chosen = tuple(digits[k] for k in decision.numbers)
        rule = dict(zip(decision.options, decision.rules, strict=False)).get(chosen, sympy.true)
        return self._put_in(rule, digits)

    def _put_in(self, rule: Boolean, digits: Digits) -> Boolean:
        """Return a rule with the digits of a mode, but for those that are open."""
        pairs = zip(self.surfaces.equations.switches, digits, strict=True)
        values = {s.digit: FIXED[d] for s, d in pairs if d in FIXED and s.digit in rule.free_symbols}
        key = rule, tuple(values.items())
        if key not in self._guards:
            self._guards[key] = rule.xreplace(values) if values else rule
        return self._guards[key]


def _group(surfaces: Surfaces, after: Digits, undecided: Mapping[int, Undecided]) -> list[tuple[int, ...]]:
    """Return the undecided switches in groups that hang together, each after those that it reads.

    What holds a motion on a surface depends on all that its rate reads: a digit that may be on a surface hangs together
    with all that read it, and with the surfaces that share states with its own.
    """
    if len(undecided) == 1:
        return [tuple(undecided)]
    loose = {k for k, d in enumerate(after) if k not in undecided and d == ON}
    loose |= {k for k, u in undecided.items() if ON in u.options}
    nodes = sorted({*undecided, *loose})
    edges = {(k, j) for k in nodes for j in _list_read(surfaces, k) if j in nodes}
    edges |= {(j, k) for k, j in edges if j in loose}
    states = set(surfaces.equations.states)
    reads = {k: surfaces.equations.switches[k].argument.free_symbols & states for k in loose}
    edges |= {(k, j) for k in loose for j in loose if k != j and reads[k] & reads[j]}
    for i, j in surfaces.compatible:
        # Of parallel surfaces the digits exclude each other.
        edges |= {(i, j), (j, i)} if i in undecided and j in undecided else set()
    for k in loose:
        # Whether a law acts at all on a surface may depend on digits too.
        acting = [j for j in _list_acting(surfaces, k, loose) if j in undecided]
        edges |= {(k, j) for j in acting} | {(j, k) for j in acting}
    components = strongly_connected_components((nodes, sorted(edges)))
    groups = (tuple(sorted(k for k in component if k in undecided)) for component in components)
    return [group for group in groups if group]


def _list_read(surfaces: Surfaces, number: int) -> list[int]:
    """Return the other switches whose digits the function or the rate of one reads."""
    switches, rate = surfaces.equations.switches, surfaces.rates[number]
    symbols = set(switches[number].argument.free_symbols)
    if rate is not None and not switches[number].remembers:
        symbols |= rate.free_symbols
    return [k for k, s in enumerate(switches) if k != number and s.digit in symbols]


def _list_acting(surfaces: Surfaces, number: int, loose: Collection[int]) -> list[int]:
    """Return the switches on whose digits it depends how the laws of those ``loose`` move one switch's function."""
    switches, rate = surfaces.equations.switches, surfaces.rates[number]
    if rate is None:
        return []
    symbols = set().union(*(rate.diff(switches[k].digit).free_symbols for k in loose))
    return [k for k, s in enumerate(switches) if k != number and s.digit in symbols]


def _open_all(after: Digits, undecided: Mapping[int, Undecided]) -> Digits:
    """Return digits with all open but those of the surfaces that a motion keeps sliding along."""
    return tuple(d if d == ON and k not in undecided else OPEN for k, d in enumerate(after))


def _list_rules(
    surfaces: Surfaces, changed: list[Digits], before: Digits, undecided: Mapping[int, Undecided]
) -> tuple[Boolean, ...]:
    """Return the condition of each of the sets of digits that may follow; the last one holds where no other does."""
    conditions = [
        sympy.And(*(_find_condition(surfaces, after, k, undecided[k], before[k]) for k in undecided))
        for after in changed[:-1]
    ]
    return (*conditions, sympy.And(*map(sympy.Not, conditions)))


def _replace(digits: Digits, changes: Mapping[int, int]) -> Digits:
    return tuple(changes.get(k, digit) for k, digit in enumerate(digits))


def _find_condition(surfaces: Surfaces, digits: Digits, number: int, undecided: Undecided, before: int) -> Boolean:
    """Return the condition under which a switch has its digit, where the others have theirs."""
    switch, digit = surfaces.equations.switches[number], digits[number]
    u = put_in(switch.argument, surfaces.find_values(digits))
    if switch.remembers:
        above = u > switch.high if before == BELOW else u >= switch.low
        return above if digit == ABOVE else sympy.Not(above)
    if surfaces.rates[number] is None:
        return u > 0 if digit == ABOVE else u <= 0
    leaves = _find_direction(surfaces, digits, number)
    if undecided.on_surface:
        return leaves
    if digit == ON:
        return sympy.And(u <= 0, u >= 0, leaves)
    return sympy.Or(u > 0, sympy.And(u >= 0, leaves)) if digit == ABOVE else sympy.Or(u < 0, sympy.And(u <= 0, leaves))


def _find_direction(surfaces: Surfaces, digits: Digits, number: int) -> Boolean:
    """Return the condition under which a motion on the surface of a switch goes where its digit says."""
    # On the other side there may be no rate: what holds the motion on other surfaces may not act there.
    lower, upper = surfaces.find_bounds(number, digits)
    if digits[number] == ON:
        return sympy.And(upper <= 0, lower >= 0)
    return upper > 0 if digits[number] == ABOVE else lower < 0


def choose_digits(
    surfaces: Surfaces, after: Digits, undecided: Mapping[int, Undecided], numbers: Mapping[sympy.Symbol, float]
) -> Digits:
    """Return the digits that follow where symbols have these ``numbers``: the first whose conditions hold."""
    options: dict[int, tuple[int, ...]] = {}
    symbols = {s.digit for s in surfaces.equations.switches}
    for k, own in undecided.items():
        u = surfaces.equations.switches[k].argument
        switch = surfaces.equations.switches[k]
        signed = not switch.remembers and switch.contact is None
        clear = signed and not own.on_surface and not u.free_symbols & symbols
        value = evaluate(u, numbers) if clear else 0.0
        options[k] = own.options if value == 0.0 else (ABOVE,) if value > 0.0 else (BELOW,)
    digits = after
    for chosen in product(*options.values()):
        later = _replace(after, dict(zip(options, chosen, strict=True)))
        if not surfaces.may_be(later):
            continue
        digits = later
        if all(holds(_find_condition(surfaces, later, k, u, after[k]), numbers) for k, u in undecided.items()):
            break
    return digits


def list_options(surfaces: Surfaces, number: int, *, on_surface: bool) -> Undecided:
    """Return that a switch may have any digit."""
    return Undecided(surfaces.list_digits(number), on_surface)
