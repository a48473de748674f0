"""What the program says where something is wrong: texts in its syntax tree. ``python docs/messages.py`` lists them.

They are what the index of messages, ``pddecont/data/messages``, has to explain; tests compare the two.
"""

from __future__ import annotations

import ast
import itertools
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import pddecont

PACKAGE = Path(pddecont.__file__).parent
# What stands in a text for what is known when the program runs.
HOLE = "{}"
# Which argument of a call is a message, by the name of what is called. Errors have it first.
SINKS = {
    "at": 3,
    "Problem": 3,
    "problem": 1,
    "add_error": 1,
    "add_warning": 1,
    "complain": 1,
    "PydanticCustomError": 1,
    "UsageError": 0,
    "say": 0,
}
# Errors that are not the package's own, and those for who writes code.
OTHER_ERRORS = {"KeyError", "AssertionError", "AttributeError", "KeyboardInterrupt", "NotImplementedError"}
# Modules that make errors of texts from elsewhere.
PASS_ON = ("errors.py",)
# Functions and constants that hold the sentences of what is recorded as data.
SENTENCES = {
    "simulate/failure.py": ("describe_failure",),
    "tables/words.py": ("_WORDS", "describe_neutral"),
    "tables/branch_endings.py": ("BRANCH_ENDS",),
    "tables/endings.py": ("UNRELIABLE", "UNCOUNTED", "UNSTATED", "list_warnings"),
    "tables/equilibrium_branch_endings.py": ("UNSTATED_ROOTS", "EQUILIBRIUM_ENDS"),
    "tables/equilibrium_endings.py": ("UNCOUNTED", "describe_switchings", "_describe_places"),
}
# A text of fewer words says nothing by itself: it is part of another.
FEWEST_WORDS = 2
# Ways to put one text together from its parts, and calls from function to function.
MOST_WAYS, DEEPEST = 64, 6
_WORD = re.compile(r"[A-Za-z][A-Za-z']+")
_HINT = re.compile(r"^\s*[;:,(.]")
Function = ast.FunctionDef | ast.AsyncFunctionDef
Scope = tuple["Module", Function | None]


@dataclass(frozen=True, order=True)
class Said:
    """A text that the program can say, with holes for what varies, and the line of its code that says it."""

    file: str
    line: int
    text: str


@dataclass
class Module:
    """One file of the package: its constants and its functions, methods among them, by name."""

    file: str
    tree: ast.Module
    constants: dict[str, ast.expr] = field(default_factory=dict)
    functions: dict[str, Function] = field(default_factory=dict)


@dataclass
class Code:
    """The package, with the functions that hand one of their arguments on as a message."""

    modules: list[Module]
    sinks: dict[tuple[str, str], tuple[int, str]] = field(default_factory=dict)

    def find(self, kind: str, name: str, near: Module) -> list[tuple[Module, ast.AST]]:
        """Return the functions or constants of a name: the module's own, else all of the package."""
        if name in getattr(near, kind):
            return [(near, getattr(near, kind)[name])]
        if name.startswith("_"):
            return []
        return [(module, getattr(module, kind)[name]) for module in self.modules if name in getattr(module, kind)]


def read_code() -> Code:
    """Return the package as syntax trees."""
    modules = []
    for path in sorted(PACKAGE.rglob("*.py")):
        module = Module(str(path.relative_to(PACKAGE)), ast.parse(path.read_text(encoding="utf-8")))
        for node in module.tree.body:
            targets = node.targets if isinstance(node, ast.Assign) else [node.target] if is_given(node) else []
            module.constants |= {t.id: node.value for t in targets if isinstance(t, ast.Name)}
        module.functions = {node.name: node for node in ast.walk(module.tree) if isinstance(node, Function)}
        modules.append(module)
    return Code(modules)


def is_given(node: ast.AST) -> bool:
    """Return whether a statement gives an annotated name its value."""
    return isinstance(node, ast.AnnAssign) and node.value is not None


def find_messages() -> list[Said]:
    """Return every text that the program can say where something is wrong, in the order of its files."""
    code, found, before = read_code(), set(), -1
    while len(code.sinks) > before:
        before = len(code.sinks)
        found = {said for module in code.modules for said in find_in_module(code, module)}
    return sorted(found)


def find_in_module(code: Code, module: Module) -> Iterator[Said]:
    """Yield what a module says."""
    if module.file in PASS_ON:
        return
    for function, node in walk_functions(module.tree):
        for part in list_messages(code, module, node):
            for line, text in find_texts(code, (module, function), part):
                if len(_WORD.findall(text.replace(HOLE, ""))) >= FEWEST_WORDS:
                    yield Said(module.file, line, " ".join(text.split()))
    for name in SENTENCES.get(module.file, ()):
        node = module.constants.get(name) or module.functions[name]
        for part in list_sentences(node):
            for line, text in find_texts(code, (module, None), part):
                if len(_WORD.findall(text.replace(HOLE, ""))) >= FEWEST_WORDS:
                    yield Said(module.file, line, " ".join(text.split()))


def walk_functions(tree: ast.AST, inside: Function | None = None) -> Iterator[tuple[Function | None, ast.AST]]:
    """Yield every node with the function that it is in."""
    for child in ast.iter_child_nodes(tree):
        yield inside, child
        yield from walk_functions(child, child if isinstance(child, Function) else inside)


def list_messages(code: Code, module: Module, node: ast.AST) -> list[ast.expr]:
    """Return the expressions that are a message at a node of the tree."""
    if not isinstance(node, ast.Call):
        return []
    name = called(node)
    if name.endswith("Error") and name not in OTHER_ERRORS and name not in SINKS:
        return node.args[:1] if is_text(node.args[:1]) else []
    place, keyword = code.sinks.get((module.file, name), (SINKS.get(name, -1), "message"))
    given = [k.value for k in node.keywords if k.arg == keyword]
    if place < 0:
        return given if (module.file, name) in code.sinks else []
    return node.args[place : place + 1] or given


def is_text(arguments: list[ast.expr]) -> bool:
    """Return whether the first argument of an error may be its text."""
    return bool(arguments) and not isinstance(arguments[0], ast.List | ast.ListComp)


def called(node: ast.Call) -> str:
    """Return the last name of what is called."""
    function = node.func
    return function.id if isinstance(function, ast.Name) else getattr(function, "attr", "")


def list_sentences(node: ast.AST) -> list[ast.expr]:
    """Return the outermost texts inside a function or a table."""
    if isinstance(node, ast.Constant | ast.JoinedStr | ast.BinOp | ast.IfExp):
        return [node]
    if isinstance(node, ast.Dict):
        return [text for value in node.values for text in list_sentences(value)]
    body = node.body[1:] if isinstance(node, Function) else list(ast.iter_child_nodes(node))
    return [text for child in body for text in list_sentences(child)]


def find_texts(code: Code, scope: Scope, node: ast.AST, depth: int = 0) -> list[tuple[int, str]]:
    """Return the texts, with their lines, that an expression can be; sentences in its holes stand alone."""
    if depth > DEEPEST:
        return []
    again = [(code, scope, part, depth + 1) for part in alternatives(node)]
    if again:
        return [text for part in again for text in find_texts(*part)]
    if isinstance(node, ast.Constant):
        return [(node.lineno, node.value)] if isinstance(node.value, str) else []
    if isinstance(node, ast.JoinedStr | ast.BinOp):
        return join_texts(code, scope, node, depth)
    if isinstance(node, ast.Name):
        return find_named(code, scope, node, depth)
    if isinstance(node, ast.Call):
        found = code.find("functions", called(node), scope[0])
        return [text for module, function in found for text in find_returned(code, module, function, depth)]
    return []


def alternatives(node: ast.AST) -> list[ast.expr]:
    """Return the expressions that one of which this one is."""
    if isinstance(node, ast.IfExp):
        return [node.body, node.orelse]
    if isinstance(node, ast.BoolOp):
        return list(node.values)
    if isinstance(node, ast.NamedExpr):
        return [node.value]
    if isinstance(node, ast.Tuple | ast.List):
        return list(node.elts)
    if isinstance(node, ast.ListComp | ast.GeneratorExp):
        return [node.elt]
    if isinstance(node, ast.Subscript):
        return [node.value]
    if isinstance(node, ast.Dict):
        return list(node.values)
    if isinstance(node, ast.Call) and called(node) in ("get", "join", "strip", "next", "list", "sorted"):
        inner = node.func.value if isinstance(node.func, ast.Attribute) else None
        return node.args[:1] if called(node) in ("join", "next", "list", "sorted") else [inner] if inner else []
    return []


def join_texts(code: Code, scope: Scope, node: ast.expr, depth: int) -> list[tuple[int, str]]:
    """Return the ways in which parts make one text, and the sentences that stand in its holes."""
    ways, held = [], []
    for part in parts_of(node):
        if isinstance(part, str):
            ways.append([part])
            continue
        found = find_texts(code, scope, part, depth + 1)
        if isinstance(node, ast.BinOp) and found:
            ways.append([text for _, text in found])
        else:
            ways.append([HOLE])
            held += [one for one in found if is_sentence(one[1])]
    texts = ["".join(way) for way in itertools.islice(itertools.product(*ways), MOST_WAYS)]
    return [(node.lineno, text) for text in texts] + held


def parts_of(node: ast.expr) -> list[str | ast.expr]:
    """Return the parts that an f-string or a sum of texts is made of."""
    if isinstance(node, ast.BinOp):
        return [node.left, node.right]
    assert isinstance(node, ast.JoinedStr)
    return [str(v.value) if isinstance(v, ast.Constant) else v.value for v in node.values]  # type: ignore[attr-defined]


def is_sentence(text: str) -> bool:
    """Return whether a text in a hole of another says something by itself, and is no hint such as a list of names."""
    return not _HINT.match(text) and len(_WORD.findall(text.replace(HOLE, ""))) > 2 * FEWEST_WORDS


def find_named(code: Code, scope: Scope, node: ast.Name, depth: int) -> list[tuple[int, str]]:
    """Return the texts that a name stands for: of the function, else of the module, else of another."""
    module, function = scope
    if function is not None:
        given = list(list_given(function, node.id))
        if given:
            return [text for value in given for text in find_texts(code, scope, value, depth + 1)]
        names = [a.arg for a in (*function.args.posonlyargs, *function.args.args)]
        if node.id in names:
            if function.name not in SINKS and not function.name.startswith("__"):
                own = names[0] in ("self", "cls")
                code.sinks[module.file, function.name] = (names.index(node.id) - own, node.id)
            return []
    found = code.find("constants", node.id, module)
    return [text for other, value in found for text in find_texts(code, (other, None), value, depth + 1)]


def list_given(function: Function, name: str) -> Iterator[ast.expr]:
    """Yield what a name of a function is given."""
    for node in ast.walk(function):
        if isinstance(node, ast.Assign):
            for target in node.targets:
                yield from list_matched(target, node.value, name)
        elif isinstance(node, ast.AugAssign | ast.AnnAssign | ast.NamedExpr) and node.value is not None:
            yield from list_matched(node.target, node.value, name)
        elif isinstance(node, ast.For | ast.comprehension) and has_name(node.target, name):
            yield node.iter


def has_name(node: ast.AST, name: str) -> bool:
    """Return whether a name stands anywhere in an expression."""
    return any(isinstance(n, ast.Name) and n.id == name for n in ast.walk(node))


def list_matched(target: ast.expr, value: ast.expr, name: str) -> Iterator[ast.expr]:
    """Yield the part of a value that a name in a target is given."""
    if isinstance(target, ast.Name) and target.id == name:
        yield value
    elif isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple) and len(target.elts) == len(value.elts):
        for one, part in zip(target.elts, value.elts, strict=True):
            yield from list_matched(one, part, name)
    elif isinstance(target, ast.Tuple) and any(isinstance(t, ast.Name) and t.id == name for t in target.elts):
        yield value


def find_returned(code: Code, module: Module, function: ast.AST, depth: int) -> list[tuple[int, str]]:
    """Return the texts that a function returns or yields."""
    values = [
        node.value
        for inside, node in walk_functions(function, function)  # type: ignore[arg-type]
        if inside is function and isinstance(node, ast.Return | ast.Yield) and node.value is not None
    ]
    return [text for value in values for text in find_texts(code, (module, function), value, depth + 1)]  # type: ignore[arg-type]


if __name__ == "__main__":
    for said in find_messages():
        print(f"{said.file}:{said.line}: {said.text}")
