"""Results files as one HTML page that needs nothing from outside.

All text comes from files, which may come from anybody: the template escapes it, pictures are images (in which nothing
runs), and the page forbids loading and all scripts but the explorer's own.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined

from pddecont.errors import ResultsError
from pddecont.plot import VIEWS, ViewRequest, list_views, render_image
from pddecont.report.explanations import EXPLANATIONS
from pddecont.report.explorer import make_explorer, write_policy
from pddecont.report.page_data import is_explored
from pddecont.report.step_tables import Row, build_tables, format_value, is_number
from pddecont.results import Results, Step
from pddecont.tables import describe_endings, find_left_out, summarise_step

# Steps that a picture of the whole file shows together, and how many it takes for one.
OVERVIEW_KINDS, OVERVIEW_STEPS = ("continue", "equilibria", "sweep"), 2
# What the explorer shows of a step; of other views, and of steps that it does not show, the page has pictures. It draws
# no branch among the returns of a sweep, so sweeps have theirs too.
EXPLORED_VIEWS = ("diagram", "plane", "multipliers", "roots", "orbit", "profile", "basin")
# Rows beyond these are left to 'pddecont export'.
MAX_ROWS = 200
# What tells a page of this program from others; before it was named they were known by what they forbid.
MARKS = (b'content="pddecont"', b"content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'\"")
# What the page shows of a summary elsewhere.
ELSEWHERE = ("name", "kind", "termination", "done", "special")


@dataclass(frozen=True)
class Picture:
    """An image as an address that holds it (``data:``) with its caption, or why there is none."""

    caption: str
    address: str = ""
    problem: str = ""


@dataclass(frozen=True)
class Section:
    """What the page says of one step; ``facts`` are names with texts."""

    anchor: str
    step: Step
    endings: list[str]
    facts: Mapping[str, str]
    tables: list[tuple[str, list[Row]]]
    pictures: list[Picture]
    settings: str
    effects_off: list[str]


@dataclass(frozen=True)
class FilePart:
    """What the page says of one file."""

    model: str
    results: Results
    source: str
    contents: list[Row]
    overview: list[Picture]
    sections: list[Section]
    versions: list[Row]


@dataclass(frozen=True)
class Live:
    """Of a page on a run that goes on: when it was written (ms since 1970), and how often it is read anew (ms)."""

    written: int
    every: int


def render_page(*files: Results, live: Live | None = None) -> str:
    """Return the page on one or several results files, which must differ in name.

    A ``live`` page reads itself anew in the browser, as the run that writes the file goes on.
    """
    explorer = make_explorer(files)
    counted = [sum(len(results.steps) for results in files[:k]) for k in range(len(files))]
    parts = [_make_part(results, number) for results, number in zip(files, counted, strict=True)]
    found = {step.kind_of(int(row)) for r in files for step in r.steps.values() for row in range(len(step))}
    return (
        make_environment()
        .get_template("page.html")
        .render(
            title=parts[0].model if len(parts) == 1 else " and ".join(dict.fromkeys(part.model for part in parts)),
            policy=write_policy(explorer is not None),
            explorer=explorer,
            files=parts,
            live=live,
            kinds={kind: text for kind, text in EXPLANATIONS.items() if kind in found},
        )
    )


def _make_part(results: Results, number: int) -> FilePart:
    """Return what the page says of a file; ``number`` counts the steps of the files before it."""
    return FilePart(
        model=next((str(s.meta.get("model", "")) for s in results.steps.values()), "") or results.path.stem,
        results=results,
        source=Path(results.source).name,
        contents=[_list_contents(step) for step in results.steps.values()],
        overview=list(_draw_overview(results)),
        sections=[_make_section(results, step, number + k) for k, step in enumerate(results.steps.values())],
        versions=[{"package": name, "version": version} for name, version in results.versions.items()],
    )


def is_page(head: bytes) -> bool:
    """Whether a file that begins so is such a page, of this version or one before."""
    return head.startswith(b"<!DOCTYPE html>") and any(mark in head for mark in MARKS)


def make_environment(package: str = "pddecont.report") -> Environment:
    """Return what renders the templates that lie in a package's folder: every text is escaped."""
    environment = Environment(
        loader=PackageLoader(package, "."),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters["format_value"] = format_value
    environment.tests["number_value"] = is_number
    environment.globals["max_rows"] = MAX_ROWS
    return environment


def _list_contents(step: Step) -> Row:
    return {
        "step": step.name,
        "kind": step.kind,
        "points": len(step),
        "special points": ", ".join(summarise_step(step)["special"]),
        "ended": "\n".join(describe_endings(step)) or "not finished",
    }


def _draw_overview(results: Results) -> Iterator[Picture]:
    """Yield the pictures that show several steps at once, where there are any."""
    views = {step.name: list_views(step) for step in results.steps.values()}
    if sum(step.kind in OVERVIEW_KINDS and bool(views[step.name]) for step in results.steps.values()) < OVERVIEW_STEPS:
        return
    for view in VIEWS.values():
        if view.in_overview and any(view in found for found in views.values()):
            yield draw_picture(results, ViewRequest(view.name), view.name)


def _list_facts(step: Step) -> dict[str, str]:
    texts = {name: format_value(value) for name, value in summarise_step(step).items() if name not in ELSEWHERE}
    return {name.replace("_", " "): text for name, text in texts.items() if text}


def _make_section(results: Results, step: Step, number: int) -> Section:
    settings = json.loads(step.meta.get("settings") or "{}")
    views = [view.name for view in list_views(step) if not (view.in_overview or view.is_moving)]
    views = [name for name in views if not (is_explored(step) and name in EXPLORED_VIEWS)]
    return Section(
        anchor=f"step-{number}",
        step=step,
        endings=describe_endings(step),
        facts=_list_facts(step),
        tables=list(build_tables(step)),
        pictures=[draw_picture(results, ViewRequest(name, (step.name,)), f"{step.name}: {name}") for name in views],
        settings=json.dumps(settings, indent=2, ensure_ascii=False) if settings else "",
        effects_off=[str(name) for name in find_left_out(step).get("effects") or []],
    )


def draw_picture(results: Results, request: ViewRequest, caption: str) -> Picture:
    """Return a picture; a view that this file cannot give says why."""
    try:
        media, contents = render_image(results, request)
    except ResultsError as exc:
        return Picture(caption, problem=str(exc))
    return Picture(caption, address=f"data:{media};base64,{base64.b64encode(contents).decode()}")
