"""Several results files in one picture: their steps together, each named with its file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from pddecont.errors import ResultsError
from pddecont.plot.view import View, ViewRequest, distinguish_kind
from pddecont.plot.view_selection import select_view
from pddecont.results import Results, Step

# Between a file and a step; neither stands in a step's own name.
SEPARATOR = ": "


def select_steps(files: Sequence[Results], request: ViewRequest) -> tuple[View, list[Step]]:
    """Return the view of one or several files, and the steps that it draws of them, the main one last.

    Of several files each gives the steps that it would give by itself in the view that the last one gives.

    Raises
    ------
    ResultsError
        If there is nothing to draw so, or the view does not show several steps.
    """
    if len(files) == 1:
        return select_view(files[0], request)
    view, _ = select_view(files[-1], request)
    names = name_files([results.path for results in files])
    steps: list[Step] = []
    for results, name in zip(files, names, strict=True):
        _, own = select_view(results, replace(request, view=view.name))
        steps += [replace(step, name=f"{name}{SEPARATOR}{step.name}") for step in own]
    if not all(distinguish_kind(step) in view.together for step in steps):
        raise ResultsError(f"the view '{view.name}' shows one step, and so one file; name one of {', '.join(names)}")
    view.drawing.check_steps(steps)
    return view, steps


def name_files(paths: Sequence[Path]) -> list[str]:
    """Return a name for each file: without its folder and suffix where these are not needed to tell it from others."""
    for shorten in (lambda path: path.stem, lambda path: str(path.with_suffix("")), str):
        names = [shorten(path) for path in paths]
        if len(set(names)) == len(names):
            return names
    raise ResultsError(f"the same file is named twice: {', '.join(map(str, paths))}")


def split_name(step: Step) -> tuple[str, str]:
    """Return the file that a step belongs to, empty where there is only one, and its name there."""
    file, _, name = step.name.rpartition(SEPARATOR)
    return file, name


def list_file_names(steps: Sequence[Step]) -> list[str]:
    """Return the files that steps belong to, in order; one empty name where there is only one."""
    return list(dict.fromkeys(split_name(step)[0] for step in steps))
