"""A results file as one HTML page that needs nothing from outside.

All text comes from the file, which may come from anybody: it is escaped, pictures are images (in which nothing runs), and the page
forbids scripts and loading.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Iterable
from html import escape
from importlib.resources import files
from pathlib import Path

from pddecont.errors import ResultsError
from pddecont.plot.choice import View, views_of
from pddecont.plot.figure import image
from pddecont.report.cells import html_table, listed, special_tables
from pddecont.results.reader import Results, Step
from pddecont.results.summary import left_out_of, step_summary

POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'"
# Their pictures show several steps at once, or move.
APART = ("manifold", "animate")


def page(results: Results) -> str:
    """Return the page on a results file."""
    model = next((str(s.meta.get("model", "")) for s in results.steps.values()), "") or results.path.stem
    style = files("pddecont.report").joinpath("page.css").read_text()
    parts = [
        "<!DOCTYPE html>", '<html lang="en">', "<head>", '<meta charset="utf-8">',
        f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>{escape(model)}: {escape(results.path.name)}</title>", f"<style>{style}</style>", "</head>", "<body>",
        f"<h1>{escape(model)}</h1>", f'<p class="from">{escape(results.path.name)}, from {escape(Path(results.source).name)}</p>',
        *_contents(results), *_overview(results),
        *(line for step in results.steps.values() for line in _step(results, step)),
        '<h2 id="texts">Texts and versions</h2>',
        *_text("Model", results.model_text),
        *(_text("Run", results.run_text) if results.run_text != results.model_text else ()),
        "<h3>Versions</h3>", html_table([{"package": k, "version": str(v)} for k, v in results.versions.items()]),
        "</body>", "</html>",
    ]  # fmt: skip
    return "\n".join(parts) + "\n"


def _contents(results: Results) -> Iterable[str]:
    rows = []
    for step in results.steps.values():
        said = step_summary(step)
        rows.append({"step": step.name, "kind": step.kind, "points": len(step), "special points": ", ".join(said["special"]),
                     "ended": "\n".join(step.termination) or "not finished"})  # fmt: skip
    yield "<h2>Steps</h2>"
    yield html_table(rows, links={step.name: f"#step-{k}" for k, step in enumerate(results.steps.values())})


def _overview(results: Results) -> Iterable[str]:
    """Return the pictures that show several steps at once, where there are any."""
    drawn = [s for s in results.steps.values() if views_of(s)]
    if sum(s.kind in ("continue", "sweep") for s in drawn) < 2:
        return
    yield "<h2>Overview</h2>"
    yield _picture(results, View(), "overview")
    if any("manifold" in views_of(s) for s in drawn):
        yield _picture(results, View("manifold"), "manifold")


def _step(results: Results, step: Step) -> Iterable[str]:
    number = list(results.steps).index(step.name)
    yield f'<h2 id="step-{number}">{escape(step.name)} <small>{escape(step.kind)}</small></h2>'
    for text in step.termination:
        yield f"<p>{escape(text)}</p>"
    if not step.done:
        yield "<p>This step is not finished.</p>"
    said = step_summary(step)
    yield listed({k: v for k, v in said.items() if k not in ("name", "kind", "termination", "done", "special")})
    for title, rows in special_tables(step):
        yield f"<h3>{escape(title)}</h3>"
        yield html_table(rows)
    for kind in views_of(step):
        if kind not in APART:
            yield _picture(results, View(kind, (step.name,)), f"{step.name}: {kind}")
    yield from _settings(step)


def _picture(results: Results, view: View, caption: str) -> str:
    """Return a picture with its caption; a view that this file cannot give says why."""
    try:
        media, contents = image(results, view)
    except ResultsError as exc:
        return f'<p class="none">{escape(caption)}: {escape(str(exc))}</p>'
    data = base64.b64encode(contents).decode()
    return f'<figure><img alt="{escape(caption)}" src="data:{media};base64,{data}"><figcaption>{escape(caption)}</figcaption></figure>'


def _settings(step: Step) -> Iterable[str]:
    settings = json.loads(step.meta.get("settings") or "{}")
    if settings:
        yield "<details><summary>Settings</summary>"
        yield f"<pre>{escape(json.dumps(settings, indent=2, ensure_ascii=False))}</pre></details>"
    gone = left_out_of(step)
    if gone.get("effects"):
        yield f"<p>Computed without: {escape(', '.join(map(str, gone['effects'])))}</p>"


def _text(title: str, text: str) -> Iterable[str]:
    yield f"<details><summary>{escape(title)}</summary><pre>{escape(text)}</pre></details>"
