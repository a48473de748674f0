"""Digits read from the names of events and segments of equations with switches."""

from __future__ import annotations

from collections.abc import Iterator

from pddecont.model.switches import ABOVE, BELOW, ON, OPEN, Digits, Equations

# What follows a switch's name in that of a segment, and the digit before it.
PASSED = {"up": BELOW, "down": ABOVE, "off_up": ON, "off_down": ON, "off": ON}
# What follows it in that of an event, and the digit beside or on its surface.
MET = {"": BELOW, "high": BELOW, "low": ABOVE, "off_up": ON, "off_down": ON, "off": ON, "speed": ON}


def list_written_digits(equations: Equations, name: str) -> Iterator[Digits]:
    """Yield the digits of the modes that a segment with this name, without what it leads to, may run in.

    It begins with the digits of the other switches and ends with what happens.
    """
    n = len(equations.switches)
    for jump in equations.jumps:
        rest = _strip_end(name, jump.name)
        if rest is not None:
            yield from (digits for digits in _read(equations, rest, -1) if OPEN not in digits)
    for k, switch in enumerate(equations.switches):
        for word, digit in PASSED.items():
            rest = _strip_end(name, f"{switch.name}_{word}")
            for digits in () if rest is None else _read(equations, rest, k):
                if all(digits[i] != OPEN for i in range(n) if i != k):
                    yield (*digits[:k], digit, *digits[k + 1 :])


def list_event_digits(equations: Equations, name: str) -> Iterator[Digits]:
    """Yield digits with which a mode may have an event of this name; those that it does not name are below.

    It begins with what happens and ends with the digits that its function reads.
    """
    for jump in equations.jumps:
        rest = _strip_begin(name, jump.name)
        for digits in () if rest is None else _read(equations, rest, -1):
            yield from (tuple(side if d == OPEN else d for d in digits) for side in (BELOW, ABOVE))
    for k, switch in enumerate(equations.switches):
        for word, own in MET.items():
            rest = _strip_begin(name, f"{switch.name}_{word}" if word else switch.name)
            for digits in () if rest is None else _read(equations, rest, -1):
                first = own if digits[k] == OPEN or switch.contact is not None else digits[k]
                yield tuple(first if i == k else BELOW if d == OPEN else d for i, d in enumerate(digits))


def _strip_end(name: str, end: str) -> str | None:
    """Return what stands before the words at the end of a name; None if it does not end so."""
    return "" if name == end else name.removesuffix(f"_{end}") if name.endswith(f"_{end}") else None


def _strip_begin(name: str, begin: str) -> str | None:
    return "" if name == begin else name.removeprefix(f"{begin}_") if name.startswith(f"{begin}_") else None


def _read(equations: Equations, text: str, but: int, first: int = 0) -> Iterator[Digits]:
    """Yield the digits that words may stand for, switch by switch in order; a switch without one is OPEN."""
    switches = equations.switches
    if first == len(switches):
        if not text:
            yield ()
        return
    own = switches[first]
    for digit in (ON, BELOW, ABOVE) if first != but else ():
        word = own.word(digit)
        rest = _strip_begin(text, word) if word else None
        for others in () if rest is None else _read(equations, rest, but, first + 1):
            yield (digit, *others)
    for others in _read(equations, text, but, first + 1):
        # A contact is named where it holds.
        yield (OPEN if own.contact is None else own.free, *others)
