"""``pddecont info``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pddecont.cli.completers import complete_effect, complete_file
from pddecont.cli.console import print_json
from pddecont.errors import printable

if TYPE_CHECKING:
    from collections.abc import Iterator

    from pddecont.model import DerivedModes, Ending, Model


# Lists that are written a line each.
LONG = ("switches", "equations", "event functions", "jumps", "segments", "termination", "cheapest")


@click.command("info")
@click.argument("file", shell_complete=complete_file)
@click.option(
    "--without",
    multiple=True,
    metavar="EFFECT",
    help="Look at the model without an effect; may be repeated.",
    shell_complete=complete_effect,
)
@click.option(
    "--expand", is_flag=True, help="Write a model given by its equations with modes, events and segments instead."
)
@click.option("--json", "as_json", is_flag=True, help="Write one JSON document.")
def command(file: str, without: tuple[str, ...], expand: bool, as_json: bool) -> None:
    """Say what is in FILE: a model, a run file or a results file."""
    if expand:
        click.echo(write_expanded(file, without), nl=False)
        return
    data = results_info(file) if _is_hdf5(file) else model_info(file, without)
    if as_json:
        print_json(data)
    else:
        click.echo(printable("\n".join(_lines(data))))


def _is_hdf5(file: str) -> bool:
    path = Path(file)
    if path.suffix in (".h5", ".hdf5"):
        return True
    if not path.is_file():
        return False
    with path.open("rb") as stream:
        return stream.read(8) == b"\x89HDF\r\n\x1a\n"


def results_info(file: str) -> dict[str, Any]:
    """Return what a results file holds."""
    from pddecont.results import read_results
    from pddecont.tables import summarise

    return {"file": file, **summarise(read_results(file))}


def write_expanded(file: str, without: tuple[str, ...]) -> str:
    """Return a model as a file with modes, events, resets and segments."""
    import yaml

    from pddecont.model import expand_model

    model, _ = _load_model(file, without)
    return str(yaml.safe_dump(expand_model(model), sort_keys=False, width=10_000, default_flow_style=None))


def _load_model(file: str, without: tuple[str, ...]) -> tuple[Model, list[str] | None]:
    """Return the model of a file and the steps of its run."""
    from pddecont.model import leave_out_effects as leave_out
    from pddecont.model import parse_model
    from pddecont.runfile import Overrides, is_run_file, load_document
    from pddecont.steps import load_run_plan

    document = load_document(file)
    if is_run_file(document):
        plan = load_run_plan(document, Overrides(without=without))
        return plan.model, [f"{step.name}: {step.kind}" for step in plan.steps]
    run = document.data.get("run") or {}
    model = leave_out(parse_model(document)[0], [*((run.get("effects") or {}).get("off") or []), *without])
    return model, [f"{s.get('name')}" for s in (run.get("steps") or []) if isinstance(s, dict)]


def model_info(file: str, without: tuple[str, ...]) -> dict[str, Any]:
    """Return what a model, or a run file and its model, holds."""
    from pddecont.model import list_reads

    model, steps = _load_model(file, without)
    read = list_reads(model)
    # Values by constant delays are named even where only rates of switches need them.
    read |= {s for r, s in zip(model.delayed, model.delayed_symbols, strict=True) if r.delay < len(model.delays)}
    return {
        "model": model.name,
        "reference": model.reference,
        "states": list(model.states),
        "parameters": dict(model.parameters),
        "forcing period": None if model.period is None else str(model.period),
        "delayed": [s.name for s in model.delayed_symbols if s in read],
        **({"integrals": [s.name for s in model.integral_symbols if s in read]} if model.integrals else {}),
        "switches": [] if model.derived is None else _describe_switches(model.derived),
        **(_list_parts(model) if model.derived is None or model.derived.builds_all else _describe_many(model)),
        "effects": list(model.effects),
        "steps": steps,
        "left out": model.left_out.as_data(),
    }


def _list_parts(model: Model) -> dict[str, Any]:
    """Return all modes, events, resets and segments of a model, with what they say."""
    from pddecont.model import write_condition, write_formula

    return {
        "modes": list(model.modes),
        "equations": [line for mode in model.modes for line in _write_equations(model, mode)],
        "events": list(model.events),
        "event functions": [
            f"{e.name}: {write_formula(e.delay)} after {e.after}"
            if e.function is None
            else f"{e.name}: {write_formula(e.function)}"
            for e in model.events.values()
        ],
        "resets": list(model.resets),
        "jumps": [
            f"{name}: {state} = {write_formula(after)}"
            for name, reset in model.resets.items()
            for state, before, after in zip(model.states, model.state_symbols, reset, strict=True)
            if after != before
        ],
        "segments": [
            f"{s.name}: {s.mode} -- {s.event} ({s.direction}) / {s.reset} -> {s.to}"
            + (" after impacts that accumulate" if s.rests else "")
            + (f" when {write_condition(s.guard)}" if s.written and not s.rests else "")
            for s in model.segments.values()
        ],
    }


def _write_equations(model: Model, mode: str) -> list[str]:
    """Return the equations of a mode, with its name where there are others."""
    from pddecont.model import write_formula

    place = f"{mode}: " if len(model.modes) > 1 else ""
    return [f"{place}{state}' = {write_formula(f)}" for state, f in zip(model.states, model.modes[mode], strict=True)]


def _describe_many(model: Model) -> dict[str, Any]:
    """Return what switches and jumps do where modes are too many to be listed, and what decides the digits after."""
    derived = model.derived
    assert derived is not None
    alike = derived.list_alike(model.initial_mode)
    endings = {derived.name_briefly(e): e for ends in alike for e in ends.endings}
    return {
        "modes": [f"{derived.n_modes} sets of digits; a mode is built when a motion or a signature comes to it"],
        "first mode": model.initial_mode,
        "equations": _write_equations(model, model.initial_mode),
        "events": list(dict.fromkeys(name for ends in alike for name in ends.events)),
        "segments": [
            f"{name}: {e.segment.event} ({e.segment.direction}) / {e.segment.reset} -> "
            + "; ".join(_describe_ending(derived, e))
            for name, e in endings.items()
        ],
    }


def _describe_ending(derived: DerivedModes, ending: Ending) -> Iterator[str]:
    """Yield what an ending changes: the digits that it sets, and those that conditions decide."""
    from pddecont.model import write_condition

    switches = derived.equations.switches
    before = derived.find_digits(ending.segment.mode)
    decided = {k for decision in ending.decisions for k in decision.numbers}
    for k, (old, new) in enumerate(zip(before, ending.after, strict=True)):
        if old != new and k not in decided:
            yield switches[k].word(new)
    for decision in ending.decisions:
        ways = []
        for number, option in enumerate(decision.options):
            digits = zip(decision.numbers, option, strict=True)
            words = "_".join(switches[k].word(digit) or "free" for k, digit in digits)
            last = number == len(decision.options) - 1 and not decision.is_open
            rules = decision.rules[number : number + (not last)]
            ways.append(" when ".join([words, *map(write_condition, rules)]))
        yield ", else ".join(ways)
    yield from (f"{resting.to} after impacts that accumulate" for resting, _ in ending.rests)


def _describe_switches(derived: DerivedModes) -> list[str]:
    """Return each switch of a model's equations: its name, its function, and whether motions slide along it."""
    from pddecont.model import write_formula

    found = []
    for switch, slides in zip(derived.equations.switches, derived.surfaces.slides, strict=True):
        if switch.contact is not None:
            found.append(f"{switch.name}: {write_formula(switch.contact)} (motions may rest)")
            continue
        memory = f", up at {switch.high}, down at {switch.low}" if switch.remembers else ""
        found.append(
            f"{switch.name}: {write_formula(switch.argument)}{memory}{' (motions may slide)' if slides else ''}"
        )
    return found


def _lines(data: dict[str, Any], indent: str = "") -> list[str]:
    lines = []
    for key, value in data.items():
        if value in (None, [], {}) or key == "curve name":
            continue
        if isinstance(value, dict):
            if any(value.values()):
                lines += [f"{indent}{key}:", *_lines(value, indent + "  ")]
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            lines.append(f"{indent}{key}:")
            for item in value:
                lines += [
                    f"{indent}  - {item.get('name')}",
                    *_lines({k: v for k, v in item.items() if k != "name"}, indent + "      "),
                ]
        elif key == "signatures":
            lines.append(f"{indent}{key}: {', '.join(map(_short, value))}")
        elif key == "warning":
            lines.append(f"{indent}WARNING: {value}")
        elif key == "curve":
            name = data.get("curve name")
            lines.append(f"{indent}{key}: {value}{f' ({name})' if name else ''}")
        elif isinstance(value, list):
            long = key in LONG
            lines += (
                [f"{indent}{key}:", *(f"{indent}  {v}" for v in value)]
                if long
                else [f"{indent}{key}: {', '.join(map(str, value))}"]
            )
        else:
            lines.append(f"{indent}{key}: {value:.6g}" if isinstance(value, float) else f"{indent}{key}: {value}")
    return lines


def _short(signature: str) -> str:
    from pddecont.tables import shorten_signature

    return shorten_signature(signature)
