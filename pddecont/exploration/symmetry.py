"""Symmetries of a model, seen at random arguments: signs of states, alike cells, half a forcing period.

A symmetry S changes the signs of some states and interchanges some, S x = (s_i x_k(i)), and may come with half a
forcing period. The model has it if f(t', S x, S x_d) = S f(t, x, x_d) in corresponding modes, if event functions agree
but for their sign, and if resets commute with S. What holds at random arguments holds at all, but for a chance of
measure zero.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pddecont.codegen import ArrayFunction, NumericModel
from pddecont.memo import cached_property
from pddecont.model import IDENTITY, Segment
from pddecont.simulate import read_start_modes

Array = NDArray[np.float64]
# Arguments that are tried, and the least share of those at which functions have values.
N_PLACES, LEAST = 16, 0.5
# Values that differ by less than this, relative to the largest, are one.
EQUAL = 1e-9
# States up to which all permutations, and all changes of signs, are tried.
MOST_PERMUTED, MOST_SIGNED = 5, 8
# Modes up to which it is looked for the one that corresponds to another.
MOST_MODES = 6
# Symmetries that are kept.
MOST_KEPT = 64
# Directions of an event, and what they are of an event function with the other sign.
OTHER_DIRECTION = {"rising": "falling", "falling": "rising"}


@dataclass(frozen=True)
class Symmetry:
    """State ``i`` becomes ``signs[i]`` times state ``sources[i]``; ``shifted``: half a forcing period later."""

    sources: tuple[int, ...]
    signs: tuple[int, ...]
    shifted: bool = False

    @property
    def is_identity(self) -> bool:
        """Whether it changes no state."""
        return self.sources == tuple(range(len(self.sources))) and all(sign > 0 for sign in self.signs)

    def apply(self, states: Array) -> Array:
        """Return the image of states (n_states, ...)."""
        signs = np.array(self.signs, dtype=float).reshape(-1, *[1] * (states.ndim - 1))
        return np.asarray(signs * states[list(self.sources)])

    def describe(self, names: Sequence[str]) -> str:
        """Return it in words of names: the states, then what takes their place."""
        if self.is_identity:
            return ""
        changed = [i for i, (k, sign) in enumerate(zip(self.sources, self.signs, strict=True)) if k != i or sign < 0]
        images = [f"{'-' if self.signs[i] < 0 else ''}{names[self.sources[i]]}" for i in changed]
        text = f"{', '.join(names[i] for i in changed)} -> {', '.join(images)}"
        return f"{text}, half a forcing period later" if self.shifted else text


def find_symmetries(numeric: NumericModel, points: Array, low: Array, high: Array) -> tuple[Symmetry, ...]:
    """Return the symmetries of a model, the identity first.

    Of models whose delays vary or that read integrals of the past, or whose segments have guards, it is the identity
    alone.

    Parameters
    ----------
    points
        Parameters at which the model has them (n_points, n_parameters).
    low, high
        Where states are (n_states,).
    """
    model, n = numeric.model, numeric.n_states
    identity = Symmetry(tuple(range(n)), (1,) * n)
    # The modes of a model given by its equations may be too many to look at the guards of their segments.
    has_guards = model.derived is None and any(segment.guard != True for segment in model.segments.values())  # noqa: E712
    if model.varying or model.integrals or has_guards:
        return (identity,)
    tested = _Tested(numeric, points, low, high)
    found = [identity]
    for sources in _list_permutations(model.states):
        if not tested.allows(sources):
            continue
        for signs in _list_signs(n):
            for shifted in (False, True) if model.forced else (False,):
                symmetry = Symmetry(sources, signs, shifted)
                if not symmetry.is_identity and tested.has(symmetry):
                    found.append(symmetry)
                    break
            if len(found) == MOST_KEPT:
                return tuple(found)
    return tuple(found)


def _list_permutations(states: Sequence[str]) -> Iterator[tuple[int, ...]]:
    """Yield the orders of states that are tried: all of a few, of more those that interchange cells numbered alike."""
    n = len(states)
    if n <= MOST_PERMUTED:
        yield from itertools.permutations(range(n))
        return
    yield tuple(range(n))
    cells = _find_cells(states)
    m = len(cells)
    turns = {tuple((k + by) % m for k in range(m)) for by in range(1, m)}
    turns |= {tuple((by - k) % m for k in range(m)) for by in range(m)}
    turns |= {tuple(k + 1 if i == k else k if i == k + 1 else i for i in range(m)) for k in range(m - 1)}
    for order in sorted(turns - {tuple(range(m))}):
        sources = list(range(n))
        for here, there in enumerate(order):
            for i, k in zip(cells[here], cells[there], strict=True):
                sources[i] = k
        yield tuple(sources)


def _find_cells(states: Sequence[str]) -> list[list[int]]:
    """Return the numbers of the states of each cell: states whose names end in one number, of all stems alike."""
    named = [re.fullmatch(r"(.*?\D)(\d+)(\D*)", name) for name in states]
    cells: dict[int, dict[tuple[str, str], int]] = {}
    for i, match in enumerate(named):
        if match is not None:
            cells.setdefault(int(match[2]), {})[match[1], match[3]] = i
    kept = [cells[number] for number in sorted(cells)]
    if len({frozenset(cell) for cell in kept}) != 1:
        return []
    return [[cell[stem] for stem in sorted(cell)] for cell in kept]


def _list_signs(n: int) -> Iterator[tuple[int, ...]]:
    if n <= MOST_SIGNED:
        yield from itertools.product((1, -1), repeat=n)
    else:
        yield from ((1,) * n, (-1,) * n)


class _Tested:
    """A model at random arguments: ``t`` (n_places,), ``x`` (n_states, n_places), ``xd`` (n_reads, n_places)."""

    def __init__(self, numeric: NumericModel, points: Array, low: Array, high: Array):
        rng = np.random.default_rng(1)
        self.numeric, self.model, self.points = numeric, numeric.model, points
        middle, half = 0.5 * (low + high), 0.5 * (high - low) + 0.5 * np.abs(low + high)
        half = np.where(half > 0.0, half, 1.0)
        self.x = middle[:, None] + half[:, None] * rng.uniform(-1.0, 1.0, (numeric.n_states, N_PLACES))
        read = [value.state for value in self.model.delayed]
        self.xd = middle[read, None] + half[read, None] * rng.uniform(-1.0, 1.0, (len(read), N_PLACES))
        self.turns = rng.uniform(0.0, 1.0, N_PLACES)

    @cached_property
    def _pattern(self) -> Array:
        """How many of what each state's slope depends on belong to each state (n_states, n_states)."""
        model, n = self.model, len(self.model.states)
        counts = np.zeros((n, n))
        fields = [model.modes[name] for name in ([model.initial_mode] if model.derived else model.modes)]
        for i, j in itertools.product(range(n), range(n)):
            symbols = {model.state_symbols[j]}
            symbols |= {s for s, read in zip(model.delayed_symbols, model.delayed, strict=True) if read.state == j}
            counts[i, j] = sum(len(field[i].free_symbols & symbols) for field in fields)
        return counts

    def allows(self, sources: tuple[int, ...]) -> bool:
        """Return whether states that take each other's place depend on as much."""
        order = list(sources)
        return bool(np.array_equal(self._pattern[np.ix_(order, order)], self._pattern))

    def has(self, symmetry: Symmetry) -> bool:
        """Return whether the model has a symmetry at all points."""
        return all(self._has_at(symmetry, p) for p in self.points)

    def _has_at(self, symmetry: Symmetry, p: Array) -> bool:
        reads = self._map_reads(symmetry, p)
        if reads is None:
            return False
        signs = np.array([symmetry.signs[read.state] for read in self.model.delayed], dtype=float)
        period = float(self.numeric.period.value(p)[0]) if self.model.forced else 1.0
        t = self.turns * period
        here = (t, self.x, self.xd, p)
        there = (t + 0.5 * symmetry.shifted * period, symmetry.apply(self.x), signs[:, None] * self.xd[reads], p)
        pair = _Pair(self.numeric, symmetry, here, there)
        if self.model.derived is not None:
            return pair.has_same_flow()
        modes = list(self.model.modes)
        if len(modes) > MOST_MODES:
            return all(pair.modes_match(mode, mode) for mode in modes) and pair.keeps({m: m for m in modes})
        can = {mode: [other for other in modes if pair.modes_match(mode, other)] for mode in modes}
        return any(
            len(set(images)) == len(modes) and pair.keeps(dict(zip(modes, images, strict=True)))
            for images in itertools.product(*can.values())
        )

    def _map_reads(self, symmetry: Symmetry, p: Array) -> list[int] | None:
        """Return for each delayed value which one takes its place; None if the model does not read that."""
        delays, found = self.numeric.delays.value(p), []
        for read in self.model.delayed:
            source = symmetry.sources[read.state]
            same = (
                k
                for k, other in enumerate(self.model.delayed)
                if (other.state, other.derivative) == (source, read.derivative)
                and abs(delays[other.delay] - delays[read.delay]) <= EQUAL * delays[read.delay]
            )
            place = next(same, None)
            if place is None:
                return None
            found.append(place)
        return found


Arguments = tuple[Array, Array, Array, Array]


@dataclass(frozen=True, eq=False)
class _Pair:
    """A model at arguments ``here`` and at their images ``there``: each time, states, delayed values and parameters."""

    numeric: NumericModel
    symmetry: Symmetry
    here: Arguments
    there: Arguments

    def has_same_flow(self) -> bool:
        """Return whether the field of a model given by its equations is its own image, in whichever modes it is.

        Events are zeros of what the field is switched by: they need no look of their own, but for jumps.
        """
        modes, images = self._read_modes(self.here), self._read_modes(self.there)
        n, slopes, of_images = self.here[1].shape[1], [], []
        for k in range(n):
            mode, image = modes[k], images[k]
            if mode is None or image is None:
                continue
            slopes.append(_take(self.numeric.mode(mode), self.here, k))
            of_images.append(_take(self.numeric.mode(image), self.there, k))
            if not _are_equal(self.symmetry.apply(slopes[-1]), of_images[-1], 0.0):
                return False
            if not self._jumps_match(mode, image):
                return False
        return bool(slopes) and bool(np.mean(np.isfinite(np.array(slopes)).all(axis=(1, 2))) >= LEAST)

    def _jumps_match(self, mode: str, image: str) -> bool:
        """Return whether each segment of a mode that ends with a jump is another's image."""
        model = self.numeric.model
        jumps = [
            [segment for segment in model.list_segments(name) if model.resets[segment.reset] != model.state_symbols]
            for name in (mode, image)
        ]
        return len(jumps[0]) == len(jumps[1]) and all(
            any(self._segments_match(segment, other) for other in jumps[1]) for segment in jumps[0]
        )

    def _read_modes(self, at: Arguments) -> list[str | None]:
        t, x, xd, p = at
        return [read_start_modes(self.numeric, p, float(t[k]), x[:, k][None], xd[:, k][None])[0] for k in range(len(t))]

    def modes_match(self, mode: str, image: str) -> bool:
        """Return whether the field of a mode becomes that of another, and each of its segments one of the other's."""
        field, other = self.numeric.mode(mode), self.numeric.mode(image)
        if not _are_equal(self.symmetry.apply(field.value(*self.here)), other.value(*self.there)):
            return False
        segments, images = (self.numeric.model.list_segments(name) for name in (mode, image))
        return len(segments) == len(images) and all(
            any(self._segments_match(segment, other) for other in images) for segment in segments
        )

    def keeps(self, images: dict[str, str]) -> bool:
        """Return whether segments lead to the images of the modes to which others lead."""
        model = self.numeric.model
        return all(
            any(
                other.to == images[segment.to] and self._segments_match(segment, other)
                for other in model.list_segments(images[mode])
            )
            for mode in images
            for segment in model.list_segments(mode)
        )

    def _segments_match(self, segment: Segment, other: Segment) -> bool:
        event, image = (self.numeric.model.events[name] for name in (segment.event, other.event))
        if (event.function is None) != (image.function is None):
            return False
        if event.function is None:
            delay, of_image = (self.numeric.event_delay(one.name).value(self.here[3]) for one in (event, image))
            if not _are_equal(delay, of_image):
                return False
        else:
            h = self.numeric.event(event.name).value(*self.here)
            k = self.numeric.event(image.name).value(*self.there)
            turned = OTHER_DIRECTION.get(segment.direction, segment.direction)
            same = _are_equal(h, k) and segment.direction == other.direction
            if not same and not (_are_equal(-h, k) and turned == other.direction):
                return False
        if segment.reset == IDENTITY and other.reset == IDENTITY:
            return True
        after, of_other = (self.numeric.reset(one.reset) for one in (segment, other))
        return _are_equal(self.symmetry.apply(after.value(*self.here)), of_other.value(*self.there))


def _take(function: ArrayFunction, at: Arguments, k: int) -> Array:
    t, x, xd, p = at
    return function.value(t[k : k + 1], x[:, k : k + 1], xd[:, k : k + 1], p)


def _are_equal(a: Array, b: Array, least: float = LEAST) -> bool:
    """Return whether values are equal where they exist, which they do at as many arguments."""
    there = np.isfinite(a)
    if not np.array_equal(there, np.isfinite(b)) or np.mean(there) < least:
        return False
    size = np.max(np.abs(a[there]), initial=0.0)
    return bool(np.all(np.abs(a[there] - b[there]) <= EQUAL * size))
