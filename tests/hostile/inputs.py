"""Inputs as a stranger might write them: texts at random, and good files with something changed."""

from __future__ import annotations

import random

from tests.conftest import CONFIGS, MODELS

NAMES = [
    "x",
    "v",
    "a",
    "b",
    "t",
    "pi",
    "lambda",
    "class",
    "import",
    "__class__",
    "__import__",
    "I",
    "E",
    "S",
    "N",
    "O",
    "Q",
    "beta",
    "gamma",
    "zeta",
    "Symbol",
    "None",
    "True",
    "np",
    "self",
    "x0",
    "c0",
    "out",
    "p",
    "xd",
    "sympy",
    "eval",
    "exec",
    "sin",
    "re",
    "im",
    "oo",
    "nan",
    "zoo",
]
WORDS = [
    *NAMES,
    "sin",
    "cos",
    "tan",
    "asin",
    "acos",
    "atan",
    "atan2",
    "sinh",
    "cosh",
    "tanh",
    "exp",
    "log",
    "sqrt",
    "abs",
    "max",
    "min",
    "mean",
    "at",
    "time_in",
    "0",
    "1",
    "2",
    "9",
    "64",
    "0.5",
    "1e308",
    "1e-320",
    "1e999",
    "9007199254740993",
    "0x10",
    "1_000",
    "1j",
    "1e",
    "(",
    "(",
    ")",
    ")",
    "+",
    "-",
    "*",
    "/",
    "**",
    "**",
    ",",
    ".",
    "'",
    '"',
    "[",
    "]",
    "{",
    "}",
    ":",
    "=",
    ":=",
    "==",
    "<",
    ">",
    "and",
    "or",
    "not",
    "if",
    "else",
    "for",
    "in",
    "^",
    "%",
    "//",
    "@",
    "~",
    "&",
    "|",
    "#",
    "\\",
    "\n",
    "\t",
    "\x0c",
    "\0",
    "\x1b",
    "é",
    "ſ",
    "\u202e",
    "\U0001f600",
    "x(t - 1)",
    "x(t - a)",
    "x(t + a)",
    "lambda: 0",
    "__import__('os').system('touch pwned')",
    "().__class__",
    "f'{x}'",
    ";",
    "$",
]
SCALARS = [
    "",
    "~",
    "null",
    "true",
    "yes",
    "1",
    "-1",
    "0",
    "1e9",
    "1.0e+400",
    "-.inf",
    ".nan",
    "1e-3",
    "0o17",
    "1:30",
    "2020-01-01",
    "!!python/object:os.system x",
    "!!python/object/apply:os.system ['touch pwned']",
    "!!binary aGk=",
    "!!set {a}",
    "&a [*a]",
    "*a",
    "<<",
    "? a",
    "- -",
    "[",
    "{",
    "]",
    "}",
    "'",
    '"',
    '"\\0"',
    '"\\ud800"',
    '"\\x1b[31m"',
    '"\\U0010ffff"',
    "|",
    ">",
    "%YAML 1.2",
    "---",
    "...",
    "@",
    "`",
    "\t",
    "\r\n",
    "\ufeff",
    "\u2028",
    "../../../../etc/passwd",
    "/dev/zero",
    "/dev/stdin",
    "impact_oscillator",
    "x'",
    "x",
    "[0, 1, 100000]",
    "[0, 1, 1e9]",
    "1000000000",
    "{}",
    "[]",
    "9**9**9**9",
    "exp(exp(exp(exp(9))))",
    "x" * 300,
    "9" * 500,
]
FILES = [path.read_text() for path in (*MODELS, *CONFIGS)]
SMALL = """\
name: m
states: [x, v]
parameters: {a: 0.5, b: 2.0}
modes: {one: {x': %s, v': -x}, two: {x': v, v': %s}}
events: {hit: %s}
resets: {back: {v: %s}}
segments: {s: {mode: one, event: hit, reset: back, to: two}, u: {mode: two, event: hit, to: one}}
initial: {x: %s}
"""


def expression(rng: random.Random) -> str:
    """Return something like an expression: a formula that is well formed, with a few words changed, or words in any
    order.
    """
    if rng.random() < 0.3:
        return rng.choice(("", " ", "")).join(rng.choice(WORDS) for _ in range(rng.randrange(1, 25)))
    text = formula(rng, rng.randrange(1, 7))
    for _ in range(rng.choice((0, 0, 1, 2))):
        at = rng.randrange(len(text) + 1)
        text = text[:at] + rng.choice(WORDS) + text[at + rng.randrange(3) :]
    return text


def formula(rng: random.Random, depth: int) -> str:
    """Return a well-formed formula."""
    if depth == 0 or rng.random() < 0.15:
        return rng.choice(
            ("x", "v", "a", "b", "x(t - a)", "v(t - a*b)", "0", "1", "2", "3", "9", "64", "0.5", "1e300", "pi", "1/3")
        )
    way = rng.randrange(7)
    if way < 4:
        return f"({formula(rng, depth - 1)}){rng.choice(('+', '-', '*', '/', '**', '**'))}({formula(rng, depth - 1)})"
    if way == 4:
        return f"-({formula(rng, depth - 1)})"
    name = rng.choice(("sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "exp", "log", "sqrt"))
    return (
        f"{name}({formula(rng, depth - 1)})"
        if way == 5
        else f"atan2({formula(rng, depth - 1)}, {formula(rng, depth - 1)})"
    )


def model(rng: random.Random) -> str:
    """Return a small model with formulas at random in every place."""
    return SMALL % tuple(formula(rng, rng.randrange(1, 5)) for _ in range(5))


def document(rng: random.Random) -> str:
    """Return a shipped file with some things changed: pieces cut, doubled, moved, words replaced."""
    text = rng.choice(FILES)
    if len(text) > 1500 and rng.random() < 0.7:
        text = text[:1500]
    for _ in range(rng.choice((1, 1, 2, 3, 8))):
        at, n = rng.randrange(len(text) + 1), rng.choice((0, 1, 1, 2, 5, 20))
        way = rng.randrange(5)
        if way == 0:
            text = text[:at] + text[at + n :]
        elif way == 1:
            text = text[:at] + rng.choice(SCALARS) + text[at + n :]
        elif way == 2:
            other = rng.randrange(len(text) + 1)
            text = text[:at] + text[other : other + 40] + text[at:]
        elif way == 3:
            lines = text.split("\n")
            k = rng.randrange(len(lines))
            key, colon, _ = lines[k].partition(": ")
            lines[k] = key + colon + rng.choice(SCALARS) if colon else rng.choice(SCALARS)
            text = "\n".join(lines)
        else:
            text = text[:at] + rng.choice("{}[]:,#&*!|>'\"%@`-? \n\t") + text[at:]
    return text


def scraps(rng: random.Random) -> str:
    """Return pieces of YAML in any order."""
    return "".join(
        rng.choice(
            (*SCALARS, ": ", "\n", "\n  ", "- ", "{", "}", "[", "]", ", ", "a", "name", "states", "run", "steps")
        )
        for _ in range(rng.randrange(1, 30))
    )
