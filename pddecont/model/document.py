"""YAML text to plain data that remembers where each value stood.

Only the YAML that the formats need: mappings with text keys, lists, text, numbers, booleans and null. Scalars are
resolved here, so that ``1e-3`` is a number and nothing but ``true`` and ``false`` is a boolean.
"""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from pddecont.errors import InputError, Problem

MAX_BYTES = 1_000_000
MAX_DEPTH = 40
MAX_NODES = 50_000
TOO_MUCH = (
    f"more than {MAX_NODES} values or {MAX_DEPTH} levels, counting each use of an anchor; write the values out or "
    f"make the file "
    "smaller"
)
AMBIGUOUS_KEYS = {"yes", "no", "on", "off", "true", "false"}

# Longer ones are text: what is tried in vain on a million digits takes hours.
MAX_DIGITS = 400
MAX_KEY = 200
# Letters of a text that a message repeats.
MAX_SHOWN = 40

_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?\Z", re.ASCII)

KeyPath = tuple[str | int, ...]


@dataclass(frozen=True)
class Mark:
    """A place in a file; line and column count from 1."""

    line: int
    column: int


@dataclass(frozen=True)
class Document:
    """A YAML file as plain data; ``values`` and ``keys`` give the place of each value and key by its path.

    ``is_written``: nobody has seen the text, as it was made of a mapping of Python's; places in it are named by keys.
    """

    path: str
    text: str
    data: Any
    values: dict[KeyPath, Mark] = field(repr=False)
    keys: dict[KeyPath, Mark] = field(repr=False)
    is_written: bool = False

    def mark(self, path: KeyPath) -> Mark:
        """Return the place of the value at ``path``, or of the nearest thing around it that the file holds."""
        while path not in self.values and path:
            path = path[:-1]
        return self.values.get(path, Mark(1, 1))

    def problem(self, path: KeyPath, message: str, *, offset: int = 0, key: bool = False) -> Problem:
        """Return a problem placed at the value (or the key) at ``path``, ``offset`` characters into it."""
        if self.is_written:
            return Problem(self.path, 0, 0, f"{name_place(path)}: {message}" if path else message)
        mark = self.keys.get(path, self.mark(path)) if key else self.mark(path)
        return Problem(self.path, mark.line, mark.column + offset, message)


def name_place(path: KeyPath) -> str:
    """Return a place in words, such as ``steps[1].continue.free``: lists are counted from 0, as Python does."""
    return "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in path).removeprefix(".")


def read_text(path: str | Path, error: type[InputError] = InputError) -> str:
    """Return the file's text, or raise ``error`` that says why it cannot be read."""
    try:
        with Path(path).open("rb") as stream:
            raw = stream.read(4 * MAX_BYTES)
    except OSError as exc:
        raise error.at(str(path), 0, 0, f"cannot be read: {exc.strerror}; check the path") from exc
    return decode(raw, path, error)


def decode(raw: bytes, path: str | Path, error: type[InputError] = InputError) -> str:
    """Return UTF-8 text, or raise ``error`` that says where it is none."""
    try:
        return raw.decode("utf-8")
    except UnicodeDecodeError as exc:
        raise error.at(str(path), 0, 0, f"is not UTF-8 text (byte {exc.start}); save it as UTF-8") from exc


def parse_document(text: str, path: str, error: type[InputError] = InputError) -> Document:
    """Return ``text`` as a :class:`Document`; raise ``error`` with every problem of YAML found."""
    if len(text) > MAX_BYTES:
        raise error.at(path, 0, 0, f"holds {len(text)} characters; at most {MAX_BYTES} are read")
    try:
        root = yaml.compose(text, Loader=_Loader)
    except yaml.MarkedYAMLError as exc:
        mark = exc.problem_mark or exc.context_mark
        line, column = (mark.line + 1, mark.column + 1) if mark else (1, 1)
        what = " ".join(str(part) for part in (exc.context, exc.problem) if part)[:300]
        if text.splitlines()[line - 1 : line] and text.splitlines()[line - 1][column - 1 : column] == "\t":
            what = "a tab stands here; YAML is indented and spaced with spaces, write some instead"
        raise error.at(path, line, column, what if what == TOO_MUCH else f"not valid YAML: {what}") from exc
    except yaml.YAMLError as exc:
        raise error.at(path, 1, 1, f"not valid YAML: {' '.join(str(exc).split())[:300]}") from exc
    except ValueError as exc:
        # An escape such as "\\Uffffffff" that names no character.
        raise error.at(path, 1, 1, f"not valid YAML: {str(exc)[:100]}") from exc
    if root is None:
        raise error.at(path, 1, 1, "the file is empty; expected a mapping such as 'name: my_model'")
    builder = _Builder(path, text)
    data = builder.build(root, ())
    if builder.problems:
        raise error(builder.problems)
    if not isinstance(data, dict):
        raise error.at(path, 1, 1, f"expected a mapping at the top of the file, found {describe_kind(data)}")
    return Document(path, text, data, builder.values, builder.keys)


def describe_kind(value: Any) -> str:
    """Return what ``value`` is, in words for a message."""
    names = {dict: "a mapping", list: "a list", str: "text", bool: "true/false", type(None): "nothing"}
    return names.get(type(value), "a number")


def _explain_comma(after: str, before: Sequence[Any]) -> str:
    """Return what is wrong with text ``after`` a comma between braces, where a key with a value must stand.

    ``before`` are the values before it.
    """
    shown = f"'{after[:MAX_SHOWN]}' after a comma is no 'key: value'"
    if before and isinstance(before[-1], int | float) and after.isdigit():
        return f"{shown}; write a decimal point instead of the comma, {before[-1]}.{after[:MAX_SHOWN]}"
    return (
        f"{shown}: between braces a comma ends a value; put a formula that holds one between quotation marks, or write "
        "the mapping without braces, each key on a line of its own"
    )


def _readable(text: str) -> bool:
    """Whether a text has nothing in it that would do something to a terminal, or that cannot be written."""
    return text.isprintable() or not any(unicodedata.category(c) in ("Cc", "Cs") and c not in "\n\t" for c in text)


class _Loader(yaml.SafeLoader):
    """Stops at once where a file has too many values or levels, before it has built them."""

    nodes = 0
    levels = 0

    def compose_node(self, parent: Any, index: Any) -> Any:
        """Return the next node, and count it."""
        self.nodes += 1
        self.levels += 1
        if self.nodes > 2 * MAX_NODES or self.levels > MAX_DEPTH:
            raise yaml.MarkedYAMLError(problem=TOO_MUCH, problem_mark=self.peek_event().start_mark)  # type: ignore[no-untyped-call]
        node = super().compose_node(parent, index)
        self.levels -= 1
        return node


class _Builder:
    """Walks the node tree once; counts what it visits, so that aliases cannot multiply without bound."""

    def __init__(self, path: str, text: str):
        self.path, self.text = path, text
        self.problems: list[Problem] = []
        self.values: dict[KeyPath, Mark] = {}
        self.keys: dict[KeyPath, Mark] = {}
        self.visited = 0

    def complain(self, node: yaml.Node, message: str) -> None:
        """Note a problem at a node."""
        self.problems.append(Problem(self.path, node.start_mark.line + 1, node.start_mark.column + 1, message))

    def build(self, node: yaml.Node, path: KeyPath) -> Any:
        """Return the data of a node and note where it stands."""
        self.visited += 1
        if self.visited > MAX_NODES or len(path) > MAX_DEPTH:
            if self.visited < 2 * MAX_NODES:
                self.complain(node, TOO_MUCH)
                self.visited = 2 * MAX_NODES
            return None
        quoted = isinstance(node, yaml.ScalarNode) and node.style in ("'", '"')
        self.values[path] = Mark(node.start_mark.line + 1, node.start_mark.column + 1 + quoted)
        if isinstance(node, yaml.MappingNode):
            return self.mapping(node, path)
        if isinstance(node, yaml.SequenceNode):
            return [self.build(item, (*path, i)) for i, item in enumerate(node.value)]
        assert isinstance(node, yaml.ScalarNode)
        return self.scalar(node)

    def mapping(self, node: yaml.MappingNode, path: KeyPath) -> dict[str, Any]:
        """Return a mapping, its keys checked."""
        data: dict[str, Any] = {}
        for key_node, value_node in node.value:
            if self.visited > MAX_NODES:
                break
            if not isinstance(key_node, yaml.ScalarNode):
                self.complain(key_node, "a key must be a plain name")
                continue
            key = key_node.value
            if node.flow_style and ":" not in self.text[key_node.end_mark.index : value_node.start_mark.index]:
                self.complain(key_node, _explain_comma(key, list(data.values())))
                break
            if len(key) > MAX_KEY or not _readable(key):
                self.complain(key_node, f"a key is a name of at most {MAX_KEY} characters, without control characters")
                continue
            here = (*path, key)
            mark = Mark(key_node.start_mark.line + 1, key_node.start_mark.column + 1)
            if key in data:
                first = self.keys[here]
                self.complain(
                    key_node, f"key '{key}' stands twice in this mapping (first on line {first.line}); remove one"
                )
                continue
            if key_node.style is None and key.lower() in AMBIGUOUS_KEYS and here[-2:] != ("effects", "off"):
                self.complain(key_node, f"key '{key}' means true or false to many YAML readers; use another name")
                continue
            if key == "<<":
                self.complain(key_node, "merge keys '<<' are not supported; write the keys out")
                continue
            self.keys[here] = mark
            data[key] = self.build(value_node, here)
        return data

    def scalar(self, node: yaml.ScalarNode) -> Any:
        """Return a number, a truth value, nothing or text."""
        text = node.value
        if not _readable(text):
            self.complain(node, "text with control characters, or with half a character, is not supported; remove them")
            return None
        if node.style is not None or node.tag == "!":
            return text
        if not node.tag.startswith("tag:yaml.org,2002:"):
            self.complain(node, f"tags such as '{node.tag}' are not supported; remove it")
            return None
        if text in ("true", "false"):
            return text == "true"
        if text in ("", "~", "null"):
            return None
        if len(text) <= MAX_DIGITS and _NUMBER.match(text):
            if text.lstrip("+-").isdigit() and len(text) < 16:
                return int(text)
            number = float(text)
            if math.isinf(number):
                self.complain(node, f"{text} is too large for a number of double precision")
            return number
        return text
