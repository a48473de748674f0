"""The modes, events, resets and segments that motions have reached, by number, as the compiled integrator has them.

Numbers stay as they are while more is added. A model whose modes are all built has all of them in its own order from
the start.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise

import numpy as np
import sympy
from numpy.typing import NDArray

from pddecont.codegen import ModelFunctions, write_rule
from pddecont.model import (
    TIME,
    Digits,
    Ending,
    Form,
    Model,
    Segment,
    find_bits,
    find_event_form,
    find_field_form,
    find_reset_form,
    find_rest,
    find_way,
    list_clocks,
    list_endings,
    list_held,
    list_way_digits,
    write_repulsion,
)
from pddecont.simulate.growing_tables import Decisions, Lists, Shared
from pddecont.simulate.past_plan import make_past_plan

Integers = NDArray[np.int64]
DIRECTIONS = {"rising": 1, "falling": -1, "any": 0}
# What stands for a mode that is not in the tables, and for no further way.
MISSING = -1


class PartTables:
    """A model's parts by number, and their tables for the integrator, named as in :class:`System`.

    ``section`` is one more event function, numbered after the model's own; ``stick`` names modes in which motions rest,
    by the events that accumulate.
    """

    def __init__(
        self,
        model: Model,
        functions: ModelFunctions,
        section: sympy.Expr | None = None,
        stick: Mapping[str, str] | None = None,
    ) -> None:
        self.model, self.functions, self.section, self.stick = model, functions, section, stick or {}
        self.plan = make_past_plan(model, set() if section is None else section.free_symbols)
        self.n_keys = max(1, len(functions.digits))
        self.modes: dict[str, int] = {}
        self.events: dict[str, int] = {}
        self.resets: dict[str, int] = {}
        self.segments: dict[str, int] = {}
        self.endings: dict[int, Ending] = {}
        self._leaders: dict[tuple[str, str], int] = {}
        self._forms: dict[str, list[Form]] = {"fields": [], "events": [], "resets": []}
        self._segment: dict[str, list[int]] = {
            name: []
            for name in (
                "mode",
                "event",
                "direction",
                "reset",
                "to",
                "decision_first",
                "decision_end",
                "next_way",
                "opposite",
            )
        }
        self._leader_digits: list[int] = []
        self._way_digits: list[int] = []
        self._resting: list[int] = []
        self._repulsions: list[tuple[tuple[sympy.Expr, ...], int] | None] = []
        self._waiting: dict[str, list[int]] = {}
        self._crossing, self._ending, self._held, self._clock = Lists(), Lists(), Lists(), Lists()
        self._decisions = Decisions()
        self._last_way: dict[int, int] = {}
        self._n_shared = 0
        # What was added, in order: a mode (-1, its digits), or a way of a segment (its number, the digits after it).
        self.steps: list[tuple[int, Digits]] = []
        for event in model.events.values():
            if self.builds_all or event.after is not None:
                self.add_event(event.name)
        if self.builds_all:
            self.modes = {mode: number for number, mode in enumerate(model.modes)}
            for segment in model.segments.values():
                self._number_segment(segment)
        for mode in list(model.modes) if self.builds_all else [model.initial_mode]:
            self._fill_mode(mode)

    @property
    def builds_all(self) -> bool:
        """Whether all parts of the model are in the tables."""
        return self.model.derived is None or self.model.derived.builds_all

    @property
    def size(self) -> tuple[int, int, int]:
        """How many modes, events and segments there are: tables that have not grown are as they were."""
        return len(self.modes), len(self.events), len(self.segments)

    def add_mode(self, mode: str) -> int:
        """Add a mode, unless it is there, and what ends it; return its number."""
        if mode not in self.modes:
            derived = self.model.derived
            self.steps.append((MISSING, () if derived is None else derived.find_digits(mode)))
            self._fill_mode(mode)
        return self.modes[mode]

    def repeat(self, leader: int, digits: Digits) -> None:
        """Add what a member of :attr:`steps` says.

        Raises
        ------
        KeyError
            If there is no such mode or segment.
        """
        derived = self.model.derived
        assert derived is not None, "models by hand have all their modes in the tables"
        if len(digits) != len(derived.equations.switches) or not set(digits) <= {0, 1, 2}:
            raise KeyError(digits)
        mode = derived.equations.name_mode(digits)
        if derived.look_up(mode) is None or (leader != MISSING and leader not in self.endings):
            raise KeyError(mode)
        if leader == MISSING:
            self.add_mode(mode)
        elif self.endings[leader].may_lead_to(digits):
            self.add_way(leader, digits)
        else:
            raise KeyError(mode)

    def add_from(self, other: PartTables) -> None:
        """Add all that is in other tables of the model."""
        for mode in other.modes:
            self.add_mode(mode)
        for leader, digits in other.steps:
            if leader != MISSING:
                ending = other.endings[leader].segment
                self.add_way(self._leaders[ending.mode, ending.name], digits)

    def _fill_mode(self, mode: str) -> None:
        number = self.modes.setdefault(mode, len(self.modes))
        self._forms["fields"].append(find_field_form(self.model, mode))
        self._held.append([self.add_event(event) for event in list_held(self.model, mode)])
        leaders = [self._add_ending(ending) for ending in list_endings(self.model, mode)]
        self._ending.append(leaders)
        self._note_opposite(leaders)
        events = [self.model.events[self.endings[leader].segment.event] for leader in leaders]
        self._crossing.append(k for k, event in zip(leaders, events, strict=True) if event.function is not None)
        for segment in self._waiting.pop(mode, ()):
            self._segment["to"][segment] = number

    def add_way(self, leader: int, digits: Digits) -> int:
        """Add the segment of an ending after which some digits hold, and the mode that it leads to."""
        segment = find_way(self.model, self.endings[leader], digits)
        number = self.segments.get(segment.name)
        self.steps.append((leader, digits))
        if number is None:
            number = self._add_segment(segment, digits)
            self._segment["next_way"][self._last_way[leader]] = number
            self._last_way[leader] = number
        self.add_mode(segment.to)
        return number

    def add_rest(self, leader: int) -> int:
        """Add the mode in which motions rest after a segment; return the number of what the segment is then."""
        ending = self.endings[leader].segment
        resting = find_rest(self.model, ending, self.stick.get(ending.event))
        assert resting is not None, "only a segment with a rest is asked for it"
        self.add_mode(resting.to)
        return self.segments[resting.name]

    def add_event(self, event: str) -> int:
        """Add an event, unless it is there; return its number."""
        if event not in self.events:
            self.events[event] = len(self.events)
            self._forms["events"].append(find_event_form(self.model, event))
        return self.events[event]

    def _add_reset(self, reset: str) -> int:
        if reset not in self.resets:
            self.resets[reset] = len(self.resets)
            self._forms["resets"].append(find_reset_form(self.model, reset))
        return self.resets[reset]

    def _add_ending(self, ending: Ending) -> int:
        """Add an ending with its first way, or with all where all are built; return its number."""
        ways = list_way_digits(self.model, ending)
        every = list(ways) if self.builds_all else [next(ways)]
        numbers = [self._add_segment(find_way(self.model, ending, digits), digits) for digits in every]
        leader = numbers[0]
        for this, following in pairwise(numbers):
            self._segment["next_way"][this] = following
        self._last_way[leader], self.endings[leader] = numbers[-1], ending
        self._leaders[ending.segment.mode, ending.segment.name] = leader
        first, end = self._decisions.add(ending)
        self._segment["decision_first"][leader], self._segment["decision_end"][leader] = first, end
        self._leader_digits[leader * self.n_keys : (leader + 1) * self.n_keys] = self._pad(ending.after)
        return leader

    def _add_segment(self, segment: Segment, digits: Digits) -> int:
        """Add a segment, unless it is there, after which some digits hold; return its number."""
        number = self.segments.get(segment.name)
        number = self._number_segment(segment) if number is None else number
        self._way_digits[number * self.n_keys : (number + 1) * self.n_keys] = self._pad(digits)
        self._note_rest(number, segment)
        return number

    def _number_segment(self, segment: Segment) -> int:
        number = self.segments[segment.name] = len(self.segments)
        row = {
            "mode": self.modes[segment.mode],
            "event": self.add_event(segment.event),
            "direction": DIRECTIONS[segment.direction],
            "reset": self._add_reset(segment.reset),
            "to": self.modes.get(segment.to, MISSING),
            "decision_first": 0,
            "decision_end": 0,
            "next_way": MISSING,
            "opposite": MISSING,
        }
        self._resting.append(MISSING)
        self._repulsions.append(self._find_repulsion(segment))
        for name, value in row.items():
            self._segment[name].append(value)
        if segment.to not in self.modes:
            self._waiting.setdefault(segment.to, []).append(number)
        self._way_digits += self._pad(())
        self._leader_digits += self._pad(())
        return number

    def _note_opposite(self, leaders: Sequence[int]) -> None:
        """Note of segments that leave a surface which one leaves it to the other side."""
        crossings = {leader: self.endings[leader].crossing for leader in leaders}
        leaving = {(c.switch, c.up): leader for leader, c in crossings.items() if c is not None and c.leaves}
        for (switch, up), leader in leaving.items():
            self._segment["opposite"][leader] = leaving.get((switch, not up), MISSING)

    def _note_rest(self, number: int, segment: Segment) -> None:
        """Note what a segment is where its event accumulates and the motion rests."""
        resting = find_rest(self.model, segment, self.stick.get(segment.event))
        if resting is not None and self._resting[number] == MISSING:
            known = self.segments.get(resting.name)
            self._resting[number] = self._number_segment(resting) if known is None else known

    def _find_repulsion(self, segment: Segment) -> tuple[tuple[sympy.Expr, ...], int] | None:
        """Return the condition that a surface repels the motion after a segment, and the digits there as bits."""
        rule = write_repulsion(self.model, segment)
        derived = self.model.derived
        if rule == sympy.false or derived is None:
            return None
        return write_rule(rule), find_bits(derived.find_digits(segment.to))

    def _pad(self, digits: Digits) -> Digits:
        return digits or (0,) * self.n_keys

    def make_tables(self, *, with_jacobians: bool, tangent: bool) -> dict[str, Integers]:
        """Return the tables; machine code is made of what has none."""
        with self.functions.lock:
            self._add_functions()
        kinds = {"field": with_jacobians, "event": True, "reset": tangent}
        tables: dict[str, Integers] = {}
        for kind, needed in kinds.items():
            tables |= self._find_addresses(kind, jacobian=needed)
        decisions = self._decisions
        rules = self._find_rules([None if rule is None else (rule, 0) for rule in decisions.rules])
        repulsions = self._find_rules(self._repulsions)
        clocks = self._list_clocks()
        delayed = set(self.model.read_symbols)
        names = list(self.events)
        after = [0 if self.model.events[name].after else -1 for name in names]
        reads = [any(delayed & e.free_symbols for e in form.exprs) for form in self._list_event_forms()]
        return tables | {
            **{f"segment_{name}": integers(values) for name, values in self._segment.items()},
            **{
                f"{name}_{part}": integers(numbers)
                for name, lists, members in (
                    ("crossing", self._crossing, "segment"),
                    ("ending", self._ending, "segment"),
                    ("held", self._held, "event"),
                    ("clock", clocks, "event"),
                )
                for part, numbers in (("first", lists.first), (members, lists.members))
            },
            "leader_digits": integers(self._leader_digits),
            "way_digits": integers(self._way_digits),
            "option_first": integers(decisions.option_first),
            "option_end": integers(decisions.option_end),
            "is_open": integers(decisions.is_open),
            "number_first": integers(decisions.number_first),
            "decision_size": integers(decisions.size),
            "decided": integers(decisions.numbers),
            "digit_first": integers(decisions.digit_first),
            "decided_digit": integers(decisions.digits),
            "rule": rules[0],
            "rule_case": rules[1],
            "segment_repulsion": repulsions[0],
            "segment_repulsion_case": repulsions[1],
            "resting": integers(self._resting),
            "after": integers([*after, *([] if self.section is None else [-1])]),
            "reads": integers(reads),
        }

    def _list_event_forms(self) -> list[Form]:
        """Return the event functions: the model's, the section's, and of each lag that varies t - lag and the lag."""
        lags = [Form((expr,)) for lag in self.plan.varying for expr in (TIME - lag, lag)]
        return [*self._forms["events"], *([] if self.section is None else [Form((self.section,))]), *lags]

    def find_rates(self) -> list[bool]:
        """Return of each value that is read whether it is a rate on which a field depends."""
        exprs = [*self.plan.varying, *(e for form in self._forms["fields"] for e in form.exprs)]
        used = set().union(*(e.free_symbols for e in exprs))
        rates = {s for s, d in zip(self.model.delayed_symbols, self.model.delayed, strict=True) if d.derivative}
        return [symbol in rates & used for symbol in self.model.read_symbols]

    def _add_functions(self) -> None:
        """Add what has no machine code yet, with what other modes that slide along the same surfaces will need too."""
        functions, shared = self.functions, Shared()
        for mode in () if self.builds_all else list(self.modes)[self._n_shared :]:
            shared.add(self.model, mode)
        self._n_shared = len(self.modes)
        functions.fields.add(form.exprs for form in self._forms["fields"])
        functions.events.add(form.exprs for form in [*self._list_event_forms(), *shared.events])
        functions.resets.add(form.exprs for form in [*self._forms["resets"], *shared.resets])
        repulsions = [rule[0] for rule in self._repulsions if rule is not None]
        rules = [rule for rule in self._decisions.rules if rule is not None]
        functions.rules.add([*rules, *repulsions, *shared.rules])

    def _find_addresses(self, kind: str, *, jacobian: bool) -> dict[str, Integers]:
        pages = getattr(self.functions, f"{kind}s")
        forms = self._list_event_forms() if kind == "event" else self._forms[f"{kind}s"]
        places = [pages.find_place(form.exprs) for form in forms]
        values = pages.list_addresses("value")
        slopes = pages.list_addresses("jacobian") if jacobian else [0] * len(values)
        shift = len(self.functions.digits)
        return {
            kind: integers(values[page] for page, _ in places),
            f"{kind}_jacobian": integers(slopes[page] for page, _ in places),
            f"{kind}_case": integers(
                which << shift | form.bits for (_, which), form in zip(places, forms, strict=True)
            ),
        }

    def _find_rules(self, rules: Sequence[tuple[tuple[sympy.Expr, ...], int] | None]) -> tuple[Integers, Integers]:
        """Return the address of each condition, 0 for none, and what it is known by there with its digits as bits."""
        pages, shift = self.functions.rules, len(self.functions.digits)
        addresses = pages.list_addresses("value")
        places = [(MISSING, 0, 0) if rule is None else (*pages.find_place(rule[0]), rule[1]) for rule in rules]
        return integers(0 if page == MISSING else addresses[page] for page, _, _ in places), integers(
            which << shift | bits for _, which, bits in places
        )

    def _list_clocks(self) -> Lists:
        found = Lists()
        for event in self.events:
            found.append(self.events[other] for other in list_clocks(self.model, event))
        return found


def integers(numbers: Iterable[int]) -> Integers:
    """Return whole numbers as an array."""
    return np.array(list(numbers), dtype=np.int64)
