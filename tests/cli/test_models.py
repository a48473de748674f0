"""The list of shipped models."""

import io
import json
import sys

from pddecont.data import describe_shipped, list_shipped
from tests.cli.test_cli import call


def test_every_shipped_file_has_a_line_that_says_what_it_is():
    code, out, _ = call("models")
    lines = dict(line.split(maxsplit=1) for line in out.splitlines())
    assert code == 0 and set(lines) == set(list_shipped())
    assert lines["duffing"] == "Duffing's equation: a hardening spring, driven"
    assert lines["fig4_7"].endswith("(a run file)")
    assert all(len(line) > 20 for line in lines.values())


def test_words_choose_among_them():
    rows = json.loads(call("models", "Belt", "slip", "--json")[1])
    assert {"belt_stick_slip", "friction_belt"} <= {row["name"] for row in rows} < set(list_shipped())
    assert all("belt" in text and "slip" in text for text in (f"{row['name']} {row['what']}".lower() for row in rows))
    assert call("models", "no such thing") == (0, "", "")


def test_a_sentence_may_hold_points_and_go_over_several_lines(tmp_path):
    file = tmp_path / "m.yaml"
    file.write_text("# A step of 0.5 mm, e.g. of a\n# staircase. More on that.\nname: m\n# not this\n")
    assert describe_shipped(file) == "A step of 0.5 mm, e.g. of a staircase"
    file.write_text("name: m\n")
    assert describe_shipped(file) == ""


def test_a_terminal_gets_one_line_each_cut_between_words(monkeypatch):
    from pddecont.cli import models

    class Terminal(io.StringIO):
        def isatty(self):
            return True

    monkeypatch.setenv("COLUMNS", "60")
    monkeypatch.setattr(sys, "stdout", Terminal())
    text = models._fit("An upright pendulum, pushed by a constant force, under feedback", 20)
    assert text == "An upright pendulum, pushed by a ..."
