"""What ``info`` says of models."""

import json

from tests.cli.test_cli import call


def read_list(text, name):
    """Return the lines of a list that ``info`` prints."""
    lines = text.splitlines()
    first = lines.index(f"{name}:") + 1
    rest = [line for line in lines[first:] if not line.startswith("  ")]
    return [line.strip() for line in lines[first : lines.index(rest[0], first)]]


def test_the_equations_of_one_mode_are_shown_without_its_name():
    text = call("info", "bouncing_ball")[1]
    assert read_list(text, "equations") == ["y' = v", "v' = G*sin(t) - 1"]
    assert read_list(text, "event functions") == ["landing: y"]
    assert read_list(text, "jumps") == ["bounce: v = -r*v"]


def test_equations_of_several_modes_are_told_apart():
    text = call("info", "impact_oscillator", "--without", "feedback")[1]
    assert read_list(text, "equations")[:2] == ["NC: x' = v", "NC: v' = a*omega**2*sin(omega*t) - 2*v*zeta - x"]
    assert "jumps:" not in text


def test_an_event_that_follows_another_says_so():
    assert "pulse: tau after spike" in read_list(call("info", "spiking_neuron")[1], "event functions")


def test_of_too_many_modes_the_first_is_shown(tmp_path):
    states = [f"x{k}" for k in range(12)]
    body = "".join(f"  {s}': -{s} + max({s} - {k + 1}, 0)\n" for k, s in enumerate(states))
    path = tmp_path / "many.yaml"
    path.write_text(f"name: many\nstates: [{', '.join(states)}]\nparameters: {{a: 1}}\nequations:\n{body}")
    data = json.loads(call("info", path, "--json")[1])
    assert "sets of digits" in data["modes"][0]
    assert data["equations"][0] == "x0' = -x0"
