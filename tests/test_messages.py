"""The index of messages holds every text that says that something is wrong, and no other."""

import importlib.util
import io
import sys

import pytest
import yaml

from pddecont.data import explain_message, read_entries, tells
from pddecont.data.message_index import FOLDER, HOLE
from tests.cli.test_cli import call
from tests.conftest import ROOT


@pytest.fixture(scope="module")
def said():
    """Return the texts that are found in the code."""
    spec = importlib.util.spec_from_file_location("messages", ROOT / "docs" / "messages.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules["messages"] = module
    spec.loader.exec_module(module)
    return module.find_messages()


def test_every_message_is_explained(said):
    assert len(said) > 500
    missing = [f"{one.file}:{one.line}: {one.text}" for one in said if not explain_message(one.text)]
    assert not missing, "add them to pddecont/data/messages"


def test_every_text_of_the_index_is_said(said):
    texts = [one.text for one in said]
    stale = [says for entry in read_entries() for says in entry.says if not any(tells(says, text) for text in texts)]
    assert not stale, "the program says this no more"


def test_no_text_stands_twice_and_none_tells_everything(said):
    says = [text for entry in read_entries() for text in entry.says]
    assert sorted(set(says)) == sorted(says)
    for text in says:
        assert sum(tells(text, one.text) for one in said) <= 20, text


def test_entries_are_sentences():
    for path in FOLDER.glob("*.yaml"):
        data = yaml.safe_load(path.read_text())
        assert set(data) == {"subject", "entries"}
        for entry in data["entries"]:
            assert set(entry) == {"says", "cause", "cure"}
            for text in (entry["cause"], entry["cure"]):
                assert text[0].isupper() or text[0] == "`", text
                assert text.endswith((".", ")")), text


MODEL = """
name: m
states: [x]
parameters: {k: 1, tau: 1}
equations: {x': -k*x(t - tau)}
"""


@pytest.mark.parametrize(
    ("change", "subject", "word"),
    [
        ({"stats": ["x"]}, "Model and run files as YAML", "misspelt"),
        ({"equations": {"x'": "-kk*x"}}, "Expressions", "most alike"),
        ({"equations": {"x'": "-k*x^2"}}, "Expressions", "never run as code"),
        ({"equations": {"x'": "-k*x(t - tau"}}, "Expressions", "never run as code"),
        ({"equations": {"x'": "-k/(tau - 1)*x/0"}}, "Expressions", "division by zero"),
        ({"equations": {"y'": "-k*x"}}, "Models", "derivatives"),
        ({"equations": {"x'": "sin(t)"}}, "Expressions", "forcing"),
        ({"parameters": {"k": 1, "tau": -1}}, "Delays and the past", "not there yet"),
        ({"states": "x y"}, "Model and run files as YAML", "another kind"),
    ],
)
def test_what_check_says_of_a_wrong_model_is_explained(in_folder, change, subject, word):
    (in_folder / "m.yaml").write_text(yaml.safe_dump(yaml.safe_load(MODEL) | change))
    code, out, err = call("check", "m.yaml")
    assert code == 1
    code, out, _ = call("explain", err.strip().splitlines()[0] if err.strip() else out.strip().splitlines()[0])
    assert code == 0
    assert out.splitlines()[0] == subject, (out, err)
    assert word in " ".join(out.split())


@pytest.mark.parametrize(
    ("words", "subject"),
    [
        (("run", "nothing_like_it"), "Files that are read and written"),
        (("run", "duffing", "--resume", "--overwrite"), "The command line"),
        (("run", "duffing", "--set", "F"), "The command line"),
        (("plot", "m.yaml"), "Results files"),
        (("plot", "none.h5"), "Files that are read and written"),
        (("explore", "duffing", "--over", "F"), "The command line"),
        (("run", "m.yaml"), "Run files"),
        (("run", "m.yaml", "-o", "m.yaml"), "Run files"),
    ],
)
def test_what_commands_say_is_explained(in_folder, words, subject):
    (in_folder / "m.yaml").write_text(MODEL)
    code, out, err = call(*words)
    assert code in (1, 2)
    code, out, _ = call("explain", err.strip().splitlines()[-1])
    assert code == 0, err
    assert out.splitlines()[0] == subject, (out, err)


def test_a_message_may_come_from_a_pipe_and_may_be_unknown(monkeypatch):
    monkeypatch.setattr("sys.stdin", io.StringIO("pddecont: k.yaml:3:1: unknown key 'stat'\n  (keys here: name)\n"))
    code, out, _ = call("explain")
    assert code == 0
    assert "  cause: This mapping has no such key" in out
    for part in ("model.yaml:3:1: unknown key 'stats'", "no shipped model or run", "unknown key 'stats'"):
        assert call("explain", part)[0] == 0
    code, _, err = call("explain", "a sentence that nobody says here")
    assert code == 2
    assert "no message of this program is like this one" in err


def test_holes_are_filled_by_anything():
    assert tells(f"step {HOLE} has {HOLE} points", "step 'a' has 7 points")
    assert not tells(f"step {HOLE} has {HOLE} points", "step 'a' has 7 rows")
    assert tells("the period", "the period")
    assert not tells("abc", "abcd")
