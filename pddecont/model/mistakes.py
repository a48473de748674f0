"""What people write where a number or an expression must stand, and what they mean by it."""

from __future__ import annotations

import ast
import re

_DECIMAL_COMMA = re.compile(r"\s*[-+]?\d{1,40},\d{1,40}\s*", re.ASCII)
# A name with a prime.
_DERIVATIVE = re.compile(r"([A-Za-z_][A-Za-z0-9_]*)'")


def is_infinite(text: str) -> bool:
    """Whether a text is one of the words for infinity, or for what is not a number."""
    return text.strip().lower().lstrip("+-") in {"nan", ".nan", "inf", ".inf", "infinity"}


def suggest_point(text: str) -> str:
    """Return "; write a decimal point, 0.8" for a text such as "0,8", or an empty text."""
    return f"; write a decimal point, {text.strip().replace(',', '.')}" if _DECIMAL_COMMA.fullmatch(text) else ""


def find_derivative(text: str) -> tuple[str, int] | None:
    """Return why a derivative ``x'`` of the present cannot stand in an expression, and where it does; or None."""
    found = _DERIVATIVE.search(text)
    if found is None:
        return None
    name = found.group(1)
    return (
        f"{name}' is a derivative, which cannot be used in an expression but delayed, {name}'(t - tau); write what it "
        "is equal to",
        found.start(),
    )


def is_moment(node: ast.expr) -> bool:
    """Whether an argument is a time, ``t`` or ``t - tau``, as a state's is."""
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add | ast.Sub):
        return is_moment(node.left) or is_moment(node.right)
    return isinstance(node, ast.Name) and node.id == "t"
