"""Plain Python, one idea a file, to one source for Cython: what is compiled when the package is built.

The functions of a folder of modules are written one after the other, their names with their module's before them, and
their annotations as C's types, so that the C compiler sees all of them at once. What stands at the top of the modules
is evaluated now and becomes constants:

======================== =========================
float, int, bool, None   double, long, bint, void
Floats, Integers         double*, long*
Indices                  int*
tuple[float, int], ..    a struct of these
a NamedTuple             a pointer to such a struct
an IntEnum               the number
======================== =========================

A function that is marked as an ``entry`` can be called by Python too: arrays become pointers, NamedTuples structs, and
other threads run meanwhile. One that is marked as ``wide`` is compiled once more for processors with wider registers,
which do the same with more numbers at a time; the C library chooses. ``calls.pxi`` has what Python writes otherwise.
"""

from __future__ import annotations

import ast
import enum
import hashlib
import importlib
import io
import sys
import tokenize
import types
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

TYPES = {"float": "double", "int": "long", "bool": "bint", "None": "void"}
TYPES |= {"Floats": "double*", "Integers": "long*", "Indices": "int*"}
MATH = {"inf": "infinity", "nan": "not_a_number"}
HEADER = '''# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, cpow=True, infer_types=True
# Written by unite.py from the modules of the folder beside it.
from cpython.buffer cimport PyBUF_C_CONTIGUOUS, PyBuffer_Release, PyObject_GetBuffer
from libc.math cimport floor, isfinite, isnan, log, nextafter, sqrt

cdef extern from *:
    """
    #define infinity ((double) INFINITY)
    #define not_a_number ((double) NAN)
    #if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__)
    #define for_each_width __attribute__((target_clones("avx2", "default")))
    #else
    #define for_each_width
    #endif
    """
    const double infinity
    const double not_a_number
    ctypedef void wide_void "for_each_width void"
    ctypedef bint wide_bint "for_each_width int"

# The array outlives the call.
cdef void* find_address(object array) except? NULL:
    cdef Py_buffer view
    PyObject_GetBuffer(array, &view, PyBUF_C_CONTIGUOUS)
    PyBuffer_Release(&view)
    return view.buf

'''


@dataclass(frozen=True)
class Source:
    """A module: its name, text, syntax tree, and what it holds once it is imported."""

    name: str
    lines: list[str]
    tree: ast.Module
    module: types.ModuleType


def unite(folder: Path, package: str) -> str:
    """Return the source for Cython of a folder of modules, which import one another as parts of ``package``."""
    sources = list(_read(folder, package))
    structs = {
        node.name: node for s in sources for node in s.tree.body if isinstance(node, ast.ClassDef) and _is_struct(node)
    }
    parts = [HEADER, f'DIGEST = "{find_digest(folder)}"', _write_constants(sources)]
    parts += [_write_struct(node) for node in structs.values()]
    parts += [(home / "calls.pxi").read_text() for home in (folder.parent, folder) if (home / "calls.pxi").exists()]
    parts += [_write_filling(node) for node in structs.values()]
    for source in sources:
        names = _find_names(source, package)
        for node in source.tree.body:
            if isinstance(node, ast.FunctionDef) and source.name != "calls":
                parts += _write_function(source, node, names, structs)
    return "\n".join(parts)


def find_digest(folder: Path) -> str:
    """Return what tells one state of the sources of a folder from another; compiled, they hold theirs as ``DIGEST``."""
    digest = hashlib.sha256()
    shared = [folder.parent / "calls.pxi"] if (folder.parent / "calls.pxi").exists() else []
    for path in [*sorted(folder.glob("*.py")), *sorted(folder.glob("*.pxi")), *shared, Path(__file__)]:
        digest.update(path.read_bytes())
    return digest.hexdigest()


def _read(folder: Path, package: str) -> Iterator[Source]:
    """Yield the modules of a folder, imported without the packages that they are in."""
    for name, home in ((package.rpartition(".")[0], folder.parent), (package, folder)):
        if name not in sys.modules:
            parent = types.ModuleType(name)
            parent.__path__ = [str(home)]
            sys.modules[name] = parent
    for path in sorted(folder.glob("*.py")):
        if path.stem == "__init__":
            continue
        text = path.read_text(encoding="utf-8")
        module = importlib.import_module(f"{package}.{path.stem}")
        yield Source(path.stem, text.split("\n"), ast.parse(text), module)


def _is_struct(node: ast.ClassDef) -> bool:
    return any(isinstance(base, ast.Name) and base.id == "NamedTuple" for base in node.bases)


def _fields(node: ast.ClassDef) -> Iterator[tuple[str, str]]:
    for part in node.body:
        if isinstance(part, ast.AnnAssign) and isinstance(part.target, ast.Name):
            yield part.target.id, TYPES[ast.unparse(part.annotation)]


def _write_struct(node: ast.ClassDef) -> str:
    return "\n".join([f"cdef struct {node.name}:", *(f"    {kind} {name}" for name, kind in _fields(node)), ""])


def _write_filling(node: ast.ClassDef) -> str:
    lines = [f"cdef int fill_{node.name}({node.name}* c, object record) except -1:"]
    for name, kind in _fields(node):
        value = f"<{kind}> find_address(record.{name})" if kind.endswith("*") else f"record.{name}"
        lines.append(f"    c.{name} = {value}")
    return "\n".join([*lines, "    return 0", ""])


def _is_constant(value: Any) -> bool:
    return isinstance(value, bool | int | float | np.ndarray) and not isinstance(value, enum.Enum)


def _own_constants(source: Source) -> dict[str, Any]:
    """Return what a module itself assigns at its top that is a number or an array."""
    found = {}
    for node in source.tree.body:
        for target in node.targets if isinstance(node, ast.Assign) else ():
            for name in (n.id for n in ast.walk(target) if isinstance(n, ast.Name)):
                if _is_constant(getattr(source.module, name)):
                    found[name] = getattr(source.module, name)
    return found


def _write_constants(sources: list[Source]) -> str:
    """Return the constants of all modules, as C has them and as Cython knows them."""
    there, known = [], []
    for source in sources:
        for name, value in _own_constants(source).items():
            full = f"{source.name}_{name}"
            if isinstance(value, np.ndarray):
                shape = "".join(f"[{n}]" for n in value.shape)
                there.append(f"static const double {full}{shape} = {_write_array(value)};")
                known.append(f"const double {full}{shape}")
            else:
                there.append(f"#define {full} {value!r}")
                known.append(f"const {'double' if isinstance(value, float) else 'long'} {full}")
        for name, value in vars(source.module).items():
            if (
                isinstance(value, type)
                and issubclass(value, enum.IntEnum)
                and value.__module__ == source.module.__name__
            ):
                there += [f"#define {name}_{member.name} {int(member)}" for member in value]
                known += [f"const long {name}_{member.name}" for member in value]
    return "\n".join(
        [
            "cdef extern from *:",
            '    """',
            *(f"    {line}" for line in there),
            '    """',
            *(f"    {line}" for line in known),
            "",
        ]
    )


def _write_array(value: Any) -> str:
    if np.ndim(value) == 0:
        return repr(float(value))
    return "{" + ", ".join(_write_array(part) for part in value) + "}"


def _find_names(source: Source, package: str) -> dict[str, str]:
    """Return what the names that a module defines or imports are called in the united source."""
    names = {name: f"{source.name}_{name}" for name in _own_constants(source)}
    for node in source.tree.body:
        if isinstance(node, ast.FunctionDef):
            names[node.name] = f"{source.name}_{node.name}"
        elif isinstance(node, ast.ClassDef):
            names[node.name] = node.name
        elif isinstance(node, ast.ImportFrom) and node.module == "math":
            names |= {alias.name: MATH.get(alias.name, alias.name) for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and node.module.rpartition(".")[2] == "calls":
            names |= {alias.name: alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and node.module.startswith(f"{package}."):
            home = node.module.rpartition(".")[2]
            names |= {alias.name: f"{home}_{alias.name}" for alias in node.names}
    return names


def _find_type(annotation: ast.expr | None, structs: dict[str, ast.ClassDef]) -> str | None:
    """Return C's type for an annotation; None if there is none."""
    if annotation is None:
        return None
    text = ast.unparse(annotation)
    if text in structs:
        return f"{text}*"
    if text.startswith("tuple["):
        return "(" + ", ".join(TYPES[part.strip()] for part in text[6:-1].split(",")) + ")"
    return TYPES.get(text)


def _write_function(
    source: Source, node: ast.FunctionDef, names: dict[str, str], structs: dict[str, ast.ClassDef]
) -> list[str]:
    """Return a function, and what Python calls of it; nothing if it has types that C does not have."""
    kinds = [(a.arg, _find_type(a.annotation, structs)) for a in node.args.args]
    result = _find_type(node.returns, structs)
    if result is None or any(kind is None for _, kind in kinds):
        return []
    marks = {d.id for d in node.decorator_list if isinstance(d, ast.Name)}
    made = f"wide_{result}" if "wide" in marks else result
    head = f"cdef {made} {names[node.name]}({', '.join(f'{kind} {name}' for name, kind in kinds)}) noexcept nogil:"
    text = "\n".join(_drop_annotations(source, node)[node.body[0].lineno - 1 : node.end_lineno])
    given = {name for name, _ in kinds}
    local = [f"    cdef {kind} {name}" for name, kind in _infer_locals(node).items() if name not in given]
    parts = ["\n".join([head, *local, _rename(text, names), ""])]
    if "entry" in marks:
        parts.append(_write_entry(node.name, names[node.name], result, kinds, structs))
    return parts


def _drop_annotations(source: Source, node: ast.FunctionDef) -> list[str]:
    """Return the lines of a module without the annotations of variables in a function."""
    lines = list(source.lines)
    for part in ast.walk(node):
        if isinstance(part, ast.AnnAssign):
            line, begin, end = part.lineno - 1, part.target.end_col_offset, part.annotation.end_col_offset
            lines[line] = lines[line][:begin] + lines[line][end:]
    return lines


def _infer_locals(node: ast.FunctionDef) -> dict[str, str]:
    """Return C's types of variables that are annotated, or whose values show what Cython does not see.

    These are truths and fractions.
    """
    found = {}
    for part in ast.walk(node):
        if isinstance(part, ast.AnnAssign) and isinstance(part.target, ast.Name):
            found[part.target.id] = TYPES[ast.unparse(part.annotation)]
        if not isinstance(part, ast.Assign):
            continue
        for target in part.targets:
            pairs = [(target, part.value)]
            if isinstance(target, ast.Tuple) and isinstance(part.value, ast.Tuple):
                pairs = list(zip(target.elts, part.value.elts, strict=True))
            for name, value in pairs:
                kind = _infer_type(value)
                if isinstance(name, ast.Name) and kind is not None:
                    found[name.id] = kind
    return found


def _infer_type(value: ast.expr) -> str | None:
    if isinstance(value, ast.UnaryOp) and isinstance(value.op, ast.USub):
        return _infer_type(value.operand)
    if isinstance(value, ast.Compare | ast.BoolOp) or (
        isinstance(value, ast.Constant) and isinstance(value.value, bool)
    ):
        return "bint"
    if isinstance(value, ast.Constant) and isinstance(value.value, float):
        return "double"
    if isinstance(value, ast.Name) and value.id in MATH:
        return "double"
    if isinstance(value, ast.Call) and isinstance(value.func, ast.Name) and value.func.id == "abs":
        return "double"
    if isinstance(value, ast.BinOp) and "double" in (_infer_type(value.left), _infer_type(value.right)):
        return "double"
    return None


def _rename(text: str, names: dict[str, str]) -> str:
    """Return a function's body with the names of the united source; members of enumerations are numbers."""
    lines = text.split("\n")
    tokens = list(tokenize.generate_tokens(io.StringIO("if 1:\n" + text + "\n").readline))
    changes = []
    for i, token in enumerate(tokens):
        before = tokens[i - 1].string if i else ""
        if token.type != tokenize.NAME or before == "." or token.string not in names:
            continue
        row, end = token.start[0] - 2, token.end[1]
        new = names[token.string]
        if tokens[i + 1].string == "." and token.string[0].isupper():
            new, end = f"{token.string}_{tokens[i + 2].string}", tokens[i + 2].end[1]
        changes.append((row, token.start[1], end, new))
    for row, start, end, new in reversed(changes):
        lines[row] = lines[row][:start] + new + lines[row][end:]
    return "\n".join(lines)


def _write_entry(
    name: str, full: str, result: str, kinds: list[tuple[str, str | None]], structs: dict[str, ast.ClassDef]
) -> str:
    """Return the function that Python calls."""
    records = [(arg, kind[:-1]) for arg, kind in kinds if kind and kind[:-1] in structs]
    arrays = [(arg, kind) for arg, kind in kinds if kind in ("double*", "long*", "int*")]
    plain = dict(kinds) | {arg: "object" for arg, _ in [*records, *arrays]}
    lines = [f"def {name}({', '.join(f'{plain[arg]} {arg}' for arg, _ in kinds)}):"]
    for arg, kind in records:
        lines += [f"    cdef {kind} {arg}_", f"    fill_{kind}(&{arg}_, {arg})"]
    lines += [f"    cdef {kind} {arg}_ = <{kind}> find_address({arg})" for arg, kind in arrays]
    passed = {arg: f"&{arg}_" for arg, _ in records} | {arg: f"{arg}_" for arg, _ in arrays}
    call = f"{full}({', '.join(passed.get(arg, arg) for arg, _ in kinds)})"
    if result == "void":
        lines += ["    with nogil:", f"        {call}", ""]
    else:
        lines += [f"    cdef {result} result", "    with nogil:", f"        result = {call}", "    return result", ""]
    return "\n".join(lines)


if __name__ == "__main__":
    Path(sys.argv[3]).write_text(unite(Path(sys.argv[1]), sys.argv[2]), encoding="utf-8")
