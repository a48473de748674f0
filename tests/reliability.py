"""What the suite reaches, as a table: tests hand in rows, and ``make reliability`` prints them as docs/reliability.md.

Run as a module it turns the rows of a run of the suite into the page: ``python -m tests.reliability ROWS.json PAGE.md
[TRIALS.jsonl ...]``, with the random models that ``python -m tests.random_models`` wrote down besides.
"""

from __future__ import annotations

import json
import sys
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path

import pytest

from tests.random_models.tables import summarise_trials

KEY = "reliability"
TALLIES = "tallies"
CASES = "Hard cases"
ESTIMATES = "Error estimates"
RANDOM = "Random models"
MENDED = "Cases that went wrong"
INTRODUCTION = {
    CASES: """\
Each case with what it is compared with, the error reached and the limit that its test asserts; what is hard and why
stands in [hard_cases.md](hard_cases.md). An error of 0 is a refusal, with the message that is due, or an exact
equality.""",
    ESTIMATES: """\
True error over `error_estimate`, for every model that has an orbit: on meshes of several fineness and degrees, the
delay read directly (tracked or not) or through delay lines, and along branches. The true error is measured against a
solution of far higher order, itself confirmed on a second mesh.""",
    MENDED: """\
Runs that went wrong without a word (`tests/cases`): what was said before they were mended, as written down then; what
this run of the tests found; and what is known, from closed forms or an integrator written apart.""",
    RANDOM: """\
Models drawn at random (`tests/random_models`): simulated, solved, followed in a parameter, swept over its range; then
compared with motions by an integrator written apart (SciPy's DOP853, the method of steps, events by root finding).
*Periods*: recorded orbits simulated for one period from their own past, same events in the same order; the worst
deviation is in parts of what the error estimate allows. *Multipliers*: the leading one against the growth of a small
perturbation, relative deviation. *Given up*: too long for one
model. *At a limit*: a labelled point at which the signature ends, or a change as small as the orbit's error changes
its events. *Too
sensitive*: a period magnifies the error to more than 1e-3. *Said to be none*: the program says itself that the orbit
is no motion of the model; *refused, a motion*: it says so of one that is. *Wrong, unsaid*: none of that, and yet no
motion, or another multiplier.""",
}
# Sections that count, by the name that tests give: heading, introduction.
TITLES = {
    "faults": (
        "Faults tried and survived",
        """\
What happened to a run, what it did, and how often that was tried. "The same file" is the file that a run gives which
nobody disturbed.""",
    ),
    "inputs": (
        "Inputs tried and refused",
        """\
Texts and files as strangers might send them, and how often each was refused with a message or read. None ended the
process, ran code or touched another file; [security.md](security.md) says what is promised.""",
    ),
    "accuracy": (
        "Accuracy asked for",
        "`--accuracy` on random hybrid orbits; the error is that against a solution a thousand times finer.",
    ),
    "batch": ("Batch use", "Many runs at once, and what scripts rely on."),
}


def pytest_addoption(parser):
    parser.addoption("--reliability", metavar="FILE", help="write what the tests record to FILE, as JSON")


def pytest_configure(config):
    if config.getoption("--reliability") and not hasattr(config, "workerinput"):
        config.pluginmanager.register(Collector(Path(config.getoption("--reliability"))))


class Collector:
    """Gathers the rows of all tests in the process that reports come to, and writes them at the end."""

    def __init__(self, path):
        self.path, self.rows = path, []

    def pytest_runtest_logreport(self, report):
        if report.when == "teardown":
            self.rows += [json.loads(row) for key, row in report.user_properties if key == KEY]

    def pytest_sessionfinish(self):
        self.path.parent.mkdir(parents=True, exist_ok=True)
        self.path.write_text(json.dumps(self.rows, indent=1))


def keep(request, **row):
    """Let a row travel with the test's report."""
    request.node.user_properties.append((KEY, json.dumps(row)))


@pytest.fixture
def record(request):
    """Assert that an error is within its limit and keep the row: ``record(case, reference, error, limit)``."""
    section = request.module.__doc__.splitlines()[0].rstrip(".")

    def row(case, reference, error, limit):
        keep(
            request,
            section=CASES,
            family=section,
            case=case,
            reference=reference,
            error=float(error),
            limit=float(limit),
        )
        assert error <= limit, f"{case}: error {error:.3g} against {reference}, limit {limit:.3g}"

    return row


@pytest.fixture
def compare(request):
    """Keep true errors and estimates of a model's orbits: ``compare(model, errors, estimates)``."""

    def row(model, errors, estimates):
        keep(request, section=ESTIMATES, model=model, errors=[*map(float, errors)], estimates=[*map(float, estimates)])

    return row


@pytest.fixture
def mended(request):
    """Keep a row of a case that went wrong: ``mended(case, before, now, reference)``."""

    def row(case, before, now, reference):
        keep(request, section=MENDED, case=case, before=before, now=now, reference=reference)

    return row


@pytest.fixture
def keep_trial(request):
    """Keep what a random model showed: ``keep_trial(trial)``."""
    return lambda trial: keep(request, section=RANDOM, trial=asdict(trial))


@pytest.fixture
def tally(request):
    """Count outcomes in a section of the page: ``tally(section, what, outcome, number)``."""

    def row(section, what, outcome, number=1):
        keep(request, section=TALLIES, title=section, what=what, outcome=outcome, number=number)

    return row


def page(rows):
    """Return the page that the rows make."""
    parts = [
        "# Reliability",
        "Made from what a run of the tests records (`make reliability`); random models besides (`make random-models`).",
    ]
    parts += [
        *_cases([r for r in rows if r["section"] == CASES]),
        *_estimates([r for r in rows if r["section"] == ESTIMATES]),
    ]
    parts += _mended([r for r in rows if r["section"] == MENDED])
    parts += _random([r["trial"] for r in rows if r["section"] == RANDOM])
    parts += _tallies([r for r in rows if r["section"] == TALLIES])
    return "\n\n".join(parts) + "\n"


def _table(head: Iterable[str], lines: Iterable[Iterable[str]]) -> str:
    head = list(head)
    rows = [head, ["---"] * len(head), *([cell.replace("|", "\\|") for cell in cells] for cells in lines)]
    return "\n".join("| " + " | ".join(cells) + " |" for cells in rows)


def _cases(rows):
    if not rows:
        return
    yield f"## {CASES}"
    yield INTRODUCTION[CASES]
    families = defaultdict(list)
    for row in rows:
        families[row["family"]].append(row)
    for family, members in sorted(families.items()):
        yield f"### {family}"
        yield _table(
            ["case", "reference", "error", "limit"],
            ([r["case"], r["reference"], f"{r['error']:.1e}", f"{r['limit']:.0e}"] for r in members),
        )


def _estimates(rows):
    if not rows:
        return
    ratios = defaultdict(list)
    for row in rows:
        ratios[row["model"]] += [e / s for e, s in zip(row["errors"], row["estimates"], strict=True)]
    ratios["all"] = [r for members in list(ratios.values()) for r in members]
    yield f"## {ESTIMATES}"
    yield INTRODUCTION[ESTIMATES]
    yield _table(
        ["model", "orbits", "within a factor of 10", "within a factor of 2", "smallest", "largest"],
        (
            [
                name,
                str(len(r)),
                *(f"{100 * sum(1 / f <= q <= f for q in r) / len(r):.1f} %" for f in (10, 2)),
                f"{min(r):.2g}",
                f"{max(r):.2g}",
            ]
            for name, r in ratios.items()
        ),
    )


def _mended(rows):
    if not rows:
        return
    yield f"## {MENDED}"
    yield INTRODUCTION[MENDED]
    head = ["case", "before", "now", "reference"]
    yield _table(head, ([r[name] for name in head] for r in rows))


def _random(trials):
    if not trials:
        return
    yield f"## {RANDOM}"
    yield INTRODUCTION[RANDOM]
    for head, lines in summarise_trials(trials):
        yield _table(head, lines)


def _tallies(rows):
    sections: dict[str, dict[tuple[str, str], int]] = defaultdict(lambda: defaultdict(int))
    for row in rows:
        sections[row["title"]][row["what"], row["outcome"]] += row["number"]
    for title in (t for t in TITLES if t in sections):
        heading, introduction = TITLES[title]
        counts = [[what, outcome, f"{number:,}"] for (what, outcome), number in sections[title].items()]
        yield f"## {heading}"
        yield introduction
        yield _table(["what", "outcome", "number"], [*counts, ["all", "", f"{sum(sections[title].values()):,}"]])


def read_trials(paths):
    """Return the rows of random models that were tried outside the suite, each seed once."""
    lines = [json.loads(line) for path in paths for line in Path(path).read_text().splitlines()]
    return [{"section": RANDOM, "trial": trial} for trial in {trial["seed"]: trial for trial in lines}.values()]


def main(rows, target, *trials):
    """Write the page of a run of the suite, and of random models tried besides."""
    Path(target).write_text(page([*json.loads(Path(rows).read_text()), *read_trials(trials)]))


if __name__ == "__main__":
    main(*sys.argv[1:])
