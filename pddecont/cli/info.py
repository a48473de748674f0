"""``pddecont info``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from pddecont.cli.completion import complete_file
from pddecont.cli.console import print_json, printable


@click.command("info")
@click.argument("file", shell_complete=complete_file)
@click.option(
    "--without", multiple=True, metavar="EFFECT", help="Look at the model without an effect; may be repeated."
)
@click.option("--json", "as_json", is_flag=True, help="Write one JSON document.")
def command(file: str, without: tuple[str, ...], as_json: bool) -> None:
    """Say what is in FILE: a model, a run file or a results file."""
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


def model_info(file: str, without: tuple[str, ...]) -> dict[str, Any]:
    """Return what a model, or a run file and its model, holds."""
    from pddecont.model import leave_out_effects as leave_out
    from pddecont.model import parse_model
    from pddecont.runfile import Overrides, is_run_file, load_document
    from pddecont.steps import load_run_plan

    document = load_document(file)
    steps = None
    if is_run_file(document):
        plan = load_run_plan(document, Overrides(without=without))
        model = plan.model
        steps = [f"{step.name}: {step.kind}" for step in plan.steps]
    else:
        run = document.data.get("run") or {}
        model = leave_out(parse_model(document)[0], [*((run.get("effects") or {}).get("off") or []), *without])
        steps = [f"{s.get('name')}" for s in (run.get("steps") or []) if isinstance(s, dict)]
    delays = [s.name for s in model.delayed_symbols]
    return {
        "model": model.name,
        "reference": model.reference,
        "states": list(model.states),
        "parameters": dict(model.parameters),
        "forcing period": None if model.period is None else str(model.period),
        "delayed": delays,
        "modes": list(model.modes),
        "events": list(model.events),
        "resets": list(model.resets),
        "segments": [
            f"{s.name}: {s.mode} -- {s.event} ({s.direction}) / {s.reset} -> {s.to}"
            + (f" when {s.guard}" if s.written else "")
            for s in model.segments.values()
        ],
        "effects": list(model.effects),
        "steps": steps,
        "left out": model.left_out.as_data(),
    }


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
            long = key in ("segments", "termination", "cheapest")
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
