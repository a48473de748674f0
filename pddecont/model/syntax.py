"""Text to a syntax tree by Python's own grammar, which is not evaluated; each node knows its column of the text."""

from __future__ import annotations

import ast
import keyword
import re
import warnings

from pddecont.model.mistakes import find_derivative

# Python keywords may be names in a model (`lambda` is a popular parameter): each is masked by a name of equal length
# whose last letter stands for nothing else.
_MASK = {word: word[:-1] + chr(0x250 + i) for i, word in enumerate(keyword.kwlist)}
_UNMASK = {mask: word for word, mask in _MASK.items()}
LOGICAL = ("and", "or", "not")
# The prime of a derivative x'(...) is masked by a letter of the same length.
PRIME, _PRIME_MASK = "'", chr(0x2B9)
_DERIVATIVE = re.compile(r"(?<=[A-Za-z0-9_'])'(?=['\s]*\()")
_KEYWORD = re.compile(r"\b(" + "|".join(keyword.kwlist) + r")\b")


class ExpressionError(Exception):
    """An expression is wrong at ``offset`` characters from its start."""

    def __init__(self, message: str, offset: int = 0):
        self.offset = offset
        super().__init__(message)


def parse_syntax(text: str, *, logical: bool = False) -> ast.expr:
    """Return the syntax tree of ``text``; raise :class:`ExpressionError` with an offset into it.

    ``logical``: and, or, not are operators there, else they may be names as other words are.
    """
    kept = LOGICAL if logical else ()
    masked = _KEYWORD.sub(
        lambda m: m.group() if m.group() in kept else _MASK[m.group()], text.replace("\n", " ").replace("\t", " ")
    )
    masked = _DERIVATIVE.sub(_PRIME_MASK, masked)
    stripped = masked.lstrip()
    shift = len(masked) - len(stripped)
    if not stripped:
        raise ExpressionError("the expression is empty; expected a number or a formula")
    try:
        # Parentheses let an expression span lines; they move columns by one. Python's advice on style is not for
        # models.
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            tree = ast.parse(f"({stripped}\n)", mode="eval").body
    except SyntaxError as exc:
        offset = max(0, min((exc.offset or 2) - 2, len(stripped) - 1)) if (exc.lineno or 1) == 1 else len(stripped)
        derivative = find_derivative(text)
        if derivative is not None:
            raise ExpressionError(*derivative) from exc
        reason = exc.msg if exc.msg.isascii() else "invalid syntax"
        raise ExpressionError(f"not an expression: {reason}", offset + shift) from exc
    except (RecursionError, MemoryError, ValueError) as exc:
        raise ExpressionError("the expression is nested too deeply; use definitions for its parts") from exc
    for node in ast.walk(tree):
        if hasattr(node, "col_offset"):
            # Python counts columns in bytes, and the mask is two bytes long.
            before = f"({stripped}".encode()[: node.col_offset].decode(errors="ignore")
            node.col_offset = max(0, len(before) - 1 + shift)
    return tree


def find_names(text: str | float) -> tuple[str, ...]:
    """Return the names in a text, each once; none where it is no expression."""
    if not isinstance(text, str):
        return ()
    try:
        tree = parse_syntax(text, logical=True)
    except ExpressionError:
        return ()
    return tuple(dict.fromkeys(unmask(node.id) for node in ast.walk(tree) if isinstance(node, ast.Name)))


def unmask(name: str) -> str:
    """Return a name as it was written."""
    bare = name.rstrip(_PRIME_MASK)
    return _UNMASK.get(bare, bare) + PRIME * (len(name) - len(bare))


def split_primes(name: str) -> tuple[str, int]:
    """Return a name without its primes, and how many it has."""
    bare = name.rstrip(PRIME)
    return bare, len(name) - len(bare)


def describe_node(node: ast.AST) -> str:
    """Return what a syntax node that may not stand in an expression is called."""
    names = {
        ast.Attribute: "an attribute (a dot)",
        ast.Subscript: "an index in brackets",
        ast.Compare: "a comparison",
        ast.BoolOp: "and/or",
        ast.IfExp: "if/else",
        ast.Lambda: "lambda",
        ast.List: "a list",
        ast.Tuple: "a tuple (a comma)",
        ast.Dict: "a mapping",
        ast.Set: "a set",
        ast.NamedExpr: "an assignment",
        ast.JoinedStr: "text",
        ast.UnaryOp: "this operator",
        ast.Starred: "'*' before a name",
        ast.Call: "the result of a call",
    }
    return names.get(type(node), f"'{type(node).__name__}'")
