"""What the explorer in a page shows, as one text: all files with their steps, points, orbits and multipliers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from pddecont.plot import make_palette, name_files
from pddecont.report.explanations import EXPLANATIONS
from pddecont.report.packed_arrays import ArrayPacker
from pddecont.report.page_data_attractors import choose_colours, describe_attractors
from pddecont.report.page_data_branch import describe_branch
from pddecont.report.page_data_orbits import describe_orbits, describe_spectra
from pddecont.report.page_data_points import describe_points
from pddecont.report.starts import write_start
from pddecont.results import Results, Step

# Kinds of steps whose views the explorer draws; the page has pictures of the others.
BRANCHES, ATTRACTORS = ("orbit", "continue", "equilibrium", "equilibria"), ("sweep", "basin")
# Of so many colours each step has one; a file may have more steps than that.
N_COLOURS = 8


def make_page_data(files: Sequence[Results]) -> str:
    """Return what the script of a page reads of some results files; empty if it can show nothing of them."""
    packer = ArrayPacker()
    names = name_files([results.path for results in files])
    steps = [step for results in files for step in results.steps.values() if is_explored(step)]
    if not steps:
        return ""
    colours = choose_colours([step for step in steps if step.kind == "sweep"])
    described = [
        {
            "name": name,
            "file": results.path.name,
            "steps": [
                _describe_step(packer, results, step, colours) for step in results.steps.values() if is_explored(step)
            ],
        }
        for name, results in zip(names, files, strict=True)
    ]
    return packer.pack({"files": described, "colours": make_palette(N_COLOURS), "explanations": EXPLANATIONS})


def is_explored(step: Step) -> bool:
    """Return whether the explorer shows a step."""
    return bool(len(step)) and step.kind in BRANCHES + ATTRACTORS


def _describe_step(packer: ArrayPacker, results: Results, step: Step, colours: Mapping[str, str]) -> dict[str, Any]:
    start = write_start(results, step)
    shown: dict[str, Any] = {
        "name": step.name,
        "kind": step.kind,
        "states": list(step.meta["states"]),
        "parameters": list(step.meta["parameters"]),
        "monitors": list(step.meta.get("monitors", [])),
        "free": list(step.meta.get("free") or []),
        "units": {str(k): str(v) for k, v in step.meta.get("units", {}).items()},
        "kinds": {str(k): str(v) for k, v in step.meta.get("kinds", {}).items()},
        "start": list(start) if start else None,
        "points": describe_points(packer, step),
    }
    if step.kind in ATTRACTORS:
        return shown | {"attractors": describe_attractors(packer, step, colours)}
    return shown | {
        "branch": describe_branch(packer, step),
        "orbits": describe_orbits(packer, step),
        "spectra": describe_spectra(packer, step),
    }
