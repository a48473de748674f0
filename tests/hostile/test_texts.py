"""Models, run files and expressions from strangers: a message or a model, in bounded time, and nothing else happens.

The inputs are the same at every run. Each one that ever broke something is kept in ``seeds/`` and tried first.
"""

import ast
import builtins
import contextlib
import itertools
import os
import random
import resource
import subprocess
import sys

import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

from pddecont.codegen import NumericModel
from pddecont.codegen import numpy_backend as codegen
from pddecont.codegen.machine_code import number_outputs, write_machine_source
from pddecont.codegen.printer import name_symbols
from pddecont.errors import InputError, PddecontError
from pddecont.model import parse_document, parse_model
from pddecont.model.expression import Scope, parse_expression
from pddecont.model.syntax import ExpressionError
from pddecont.model.system import make_delayed_symbol, make_symbol
from pddecont.runfile import is_run_file
from pddecont.steps import load_run_plan
from tests.cli.test_cli import call
from tests.conftest import ROOT
from tests.hostile import inputs
from tests.hostile.guard import watched
from tests.runs import to_yaml

SEEDS = sorted((ROOT / "tests" / "hostile" / "seeds").iterdir())
SECONDS = 10.0
SCOPE = Scope(
    {**{n: make_symbol(n) for n in ("x", "v", "a", "b", *inputs.NAMES) if n not in ("t", "pi", "sin")}},
    states=("x", "v"),
    delayed=make_delayed_symbol,
)
# All that generated code may name: arguments, functions, and common parts c0, c1, ...
ALLOWED = {
    "generated",
    "t",
    "x",
    "xd",
    "p",
    "which",
    "out",
    "value",
    "dx",
    "dxd",
    "dp",
    "dt",
    "atan2",
    "asin",
    "acos",
    "atan",
    "e",
    *codegen._NUMPY,
    *codegen._MATH,
}


def count(tally, what, tried, accepted):
    tally("inputs", what, "refused", tried - accepted)
    if accepted:
        tally("inputs", what, "accepted", accepted)


def short(message):
    return len(message) < 120_000 and all(len(line) < 2000 for line in message.splitlines())


def try_text(text):
    """Read a text as ``check`` does; return whether it was accepted."""
    try:
        with watched(SECONDS):
            document = parse_document(text, "m.yaml")
            if is_run_file(document) or document.data.get("run") is not None:
                load_run_plan(document)
            else:
                parse_model(document)
    except InputError as exc:
        assert exc.problems, text
        assert short(str(exc)), text
        return False
    except PddecontError as exc:
        assert short(str(exc)), text
        return False
    return True


@pytest.fixture(scope="module", autouse=True)
def everything_is_imported(tmp_path_factory):
    """Import now what is imported when it is first needed, and stand in an empty folder that stays empty."""
    before = os.getcwd()
    folder = tmp_path_factory.mktemp("empty")
    os.chdir(folder)
    for text in inputs.FILES:
        with_plan = parse_document(text.replace("model: ../models/", f"model: {ROOT}/models/"), "m.yaml")
        if is_run_file(with_plan) or with_plan.data.get("run") is not None:
            load_run_plan(with_plan)
    for text in ("x(t - 1)*atan2(v, a)**b + Abs(x)", "exp(x)/log(v)", "9**9**9", "x +"):
        try_text(inputs.SMALL % ((text,) * 5))
    yield
    assert not list(folder.iterdir())
    os.chdir(before)


@pytest.mark.parametrize("path", SEEDS, ids=lambda path: path.name)
def test_what_once_broke_something(path):
    try_text(path.read_text(encoding="utf-8", errors="surrogateescape"))


@pytest.mark.parametrize("seed", range(8))
def test_expressions(seed, tally):
    rng, accepted = random.Random(seed), 0
    for _ in range(1250):
        text = inputs.expression(rng)
        try:
            with watched(SECONDS):
                result = parse_expression(text, SCOPE)
        except ExpressionError as exc:
            assert str(exc), text
            assert 0 <= exc.offset <= len(text), text
            continue
        assert isinstance(result, sympy.Expr), text
        accepted += 1
    assert 100 < accepted < 1150
    count(tally, "expressions", 1250, accepted)


@pytest.mark.parametrize("seed", range(8))
def test_files_with_something_changed(seed, tally):
    rng = random.Random(seed)
    accepted = sum(try_text(inputs.document(rng)) for _ in range(750))
    assert 5 < accepted < 700
    count(tally, "shipped files with something changed", 750, accepted)


@pytest.mark.parametrize("seed", range(2))
def test_scraps_of_yaml(seed, tally):
    rng = random.Random(seed)
    for _ in range(1500):
        assert not try_text(inputs.scraps(rng))
    count(tally, "scraps of YAML", 1500, 0)


def test_any_text(tally):
    @settings(max_examples=1000, deadline=None, derandomize=True, database=None)
    @given(st.text(max_size=60))
    def none_is_a_model(text):
        assert not try_text(text)

    none_is_a_model()
    count(tally, "texts of any letters", 1000, 0)


def names_in(text):
    tree = ast.parse(text)
    assert not any(isinstance(n, ast.Attribute | ast.Lambda | ast.Import | ast.ImportFrom) for n in ast.walk(tree))
    return {n.id for n in ast.walk(tree) if isinstance(n, ast.Name)}


@pytest.mark.parametrize("seed", range(4))
def test_generated_code_names_nothing_but_its_arguments_and_functions(seed, monkeypatch, tally):
    rng, texts = random.Random(seed), []
    compiled = codegen.compile_source
    monkeypatch.setattr(codegen, "compile_source", lambda text, names: texts.append(text) or compiled(text, names))
    for _ in range(120):
        try:
            model = parse_model(parse_document(inputs.model(rng), "m.yaml"))[0]
        except InputError:
            continue
        numeric = NumericModel(model)
        with watched(SECONDS):
            for function in (
                *map(numeric.mode, model.modes),
                numeric.event("hit"),
                numeric.reset("back"),
                numeric.delays.function,
            ):
                function._function(None)
                with contextlib.suppress(PddecontError):  # a derivative that is no smooth function is refused
                    function._function((0,))
        texts += [
            write_machine_source(
                [number_outputs(f) for f in model.modes.values()],
                name_symbols(model.state_symbols, model.delayed_symbols, model.parameter_symbols),
            )
        ]
    assert len(texts) > 10
    for text in texts:
        stray = {
            n for n in names_in(text.split("\n\n\n")[-1]) if n not in ALLOWED and not (n[0] == "c" and n[1:].isdigit())
        }
        assert not stray, (stray, text)
    tally("inputs", "functions generated from models at random", "names nothing but its arguments", len(texts))


NEST = "".join(f"d{i}: sin(d{i - 1}) + d{i - 1}**2, " for i in range(1, 41))


def model(e="-x", extra=""):
    return f'name: m\nstates: [x]\nparameters: {{a: 9, b: 2}}\n{extra}\nmodes: {{g: {{x\': "{e}"}}}}\n'


def product(text, n, m):
    return "*".join("(" + "*".join(text.replace("#", str(i * m + j)) for j in range(m)) + ")" for i in range(n))


LETTERS = "abcdefghijklmnop"
BOMBS = {
    "100,000 brackets": "[" * 100_000,
    "100,000 dashes": "- " * 100_000,
    "1 MB of digits": "name: " + "1" * 990_000 + "x",
    "10 MB": "name: " + "x" * 10_000_000,
    "50,000 keys": "\n".join(f"k{i}: 1" for i in range(50_000)),
    "400,000 values": "a: [" + "1," * 400_000 + "]",
    "a key of 1 MB": "k" * 900_000 + ": 1",
    "aliases of aliases": "a: &a [1,1,1,1,1,1,1,1,1,1]\n"
    + "".join(f"{b}: &{b} [{','.join(['*' + a] * 10)}]\n" for a, b in itertools.pairwise(LETTERS)),
    "an alias of itself": "a: &a [*a]",
    "a name of 900,000 letters": f"name: m\nstates: [{'x' * 900_000}]\nmodes: {{g: {{}}}}",
    "3000 states, 3000 strangers": f"name: m\nstates: [{','.join(f's{i}' for i in range(3000))}]\n"
    f"modes: {{g: {{{','.join(f'r{i}: 1' for i in range(3000))}}}}}",
    "10 MB of an expression": model("x" + "+x" * 5_000_000),
    "a tower of powers": model("x*9**9**9**9"),
    "a tower of powers in definitions": model("d3*x", "definitions: {d0: 9, d1: d0**d0, d2: d1**d1, d3: d2**d2}"),
    "a tower of powers in a delay": model("x(t - a**(a**(a**a)))"),
    "a tower of exp": model("sqrt(exp(exp(exp(exp(9)))) - 1)*x"),
    "definitions that double": model("d40*x", "definitions: {d0: x + a, " + NEST + "}"),
    "900 factors": model(product("sin(#.5*x)", 20, 45)),
    "whole numbers of 16,000 digits": model(f"x*sqrt({product('9007199254740881', 25, 40)})"),
    "1e9 intervals": model() + "run: {mesh: {intervals: 1000000000}, steps: [{name: s, simulate: {t_end: 1}}]}\n",
    "a chain of 1e9": model()
    + "run: {delay: {method: chain, n: 1000000000}, steps: [{name: s, simulate: {t_end: 1}}]}\n",
    "1e10 parameter points": model()
    + "run: {steps: [{name: s, sweep: {over: {a: [0, 1, 100000], b: [0, 1, 100000]}, transient: 1, "
    "section: {zero: x}}}]}\n",
    "1e9 samples": model() + "run: {steps: [{name: s, simulate: {t_end: 1000, record: {every: 1.0e-6}}}]}\n",
}


@pytest.mark.parametrize("what", BOMBS)
def test_bombs_are_refused_in_bounded_time_and_memory(what, tmp_path, tally):
    (tmp_path / "m.yaml").write_text(BOMBS[what])
    done = subprocess.run(
        [sys.executable, "-m", "pddecont", "check", "m.yaml"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (2 << 30, 2 << 30)),
    )
    assert done.returncode == 1, done.stderr[-500:]
    assert "Traceback" not in done.stderr
    assert short(done.stderr)
    tally("inputs", what, "refused")


@pytest.mark.parametrize("command", ["check", "info", "run"])
def test_files_that_are_no_text_get_a_message(command, tmp_path, tally):
    contents = (
        b"\x89HDF\r\n\x1a\n",
        b"\xff\xfe",
        b"name: \xc3",
        b"\0",
        b"a: \0",
        b"\x1b[2J",
        b"\xef\xbb\xbf",
        b"\r\r",
        bytes(range(256)),
    )
    for content in contents:
        (tmp_path / "m.yaml").write_bytes(content)
        code, out, err = call(command, tmp_path / "m.yaml")
        assert (code, out) == (1, "")
        assert err
        assert "\x1b" not in err
    tally("inputs", f"{command} on a file that is no text", "refused", len(contents))


def test_what_is_not_a_model_is_not_shown(tmp_path):
    (tmp_path / "secret").write_text("password: hunter2\nother line of hunter2\n")
    (tmp_path / "r.yaml").write_text(to_yaml({"model": "secret", "steps": [{"name": "s", "simulate": {"t_end": 1}}]}))
    for path in ("r.yaml", "secret"):
        code, out, err = call("check", tmp_path / path)
        assert (code, out) == (1, "")
        assert "hunter2" not in err


def test_nothing_is_evaluated(monkeypatch, tmp_path):
    def forbidden(*_args, **_options):
        raise AssertionError("a text was run")

    rng = random.Random(99)
    for name in ("eval", "exec"):
        monkeypatch.setattr(builtins, name, forbidden)
    monkeypatch.setattr(os, "system", forbidden)
    for _ in range(200):
        try_text(inputs.SMALL % tuple(inputs.expression(rng).replace("\n", " ") for _ in range(5)))
