"""The page that the suite's own rows make."""

import json

from tests.conftest import ROOT
from tests.reliability import CASES, ESTIMATES, MENDED, RANDOM, TALLIES, main, page


def test_rows_become_tables():
    rows = [
        {
            "section": CASES,
            "family": "Walls",
            "case": "stiff",
            "reference": "closed form",
            "error": 2e-11,
            "limit": 1e-10,
        },
        {"section": ESTIMATES, "model": "relay", "errors": [1e-6, 3e-5], "estimates": [1e-6, 1e-6]},
        {"section": ESTIMATES, "model": "wright", "errors": [1e-6, 2e-6], "estimates": [1e-6, 1e-6]},
        {"section": TALLIES, "title": "faults", "what": "killed", "outcome": "resumed", "number": 25},
        {"section": TALLIES, "title": "inputs", "what": "bombs", "outcome": "refused", "number": 1020},
        {"section": TALLIES, "title": "inputs", "what": "bombs", "outcome": "refused", "number": 22},
        {"section": TALLIES, "title": "inputs", "what": "bombs", "outcome": "accepted", "number": 3},
    ]
    rows += [{"section": MENDED, "case": "slides", "before": "stable", "now": "MC at 1", "reference": "1"}]
    trial = {"family": "relay", "outcome": "compared", "n_points": 40, "n_multipliers": 3, "worst_orbit": 0.02}
    trial |= {"worst_multiplier": 3e-6, "at_limit": 1, "too_sensitive": 0, "warned": 2, "faults": [["a", "b", "c"]]}
    trial["refused"] = []
    trial["attractors"] = {"no period": 1, "on a stable part of the branch": 6}
    rows += [{"section": RANDOM, "trial": trial}, {"section": RANDOM, "trial": {**trial, "outcome": "no orbit"}}]
    text = page(rows)
    for line in (
        "## Hard cases",
        "### Walls",
        "| stiff | closed form | 2.0e-11 | 1e-10 |",
        "| relay | 2 | 50.0 % | 50.0 % | 1 | 30 |",
        "| all | 4 | 75.0 % | 75.0 % | 1 | 30 |",
        "## Cases that went wrong",
        "| slides | stable | MC at 1 | 1 |",
        "## Random models",
        "| relay | 2 | 1 | 0 | 80 | 0.02 | 6 | 3.0e-06 | 2 | 0 | 4 | 0 | 2 |",
        "| on a stable part of the branch | 12 |",
        "## Inputs tried and refused",
        "| killed | resumed | 25 |",
        "| bombs | refused | 1,042 |",
        "| all |  | 1,045 |",
    ):
        assert line in text.splitlines()


def test_every_family_is_documented():
    page = (ROOT / "docs" / "hard_cases.md").read_text()
    for path in (ROOT / "tests" / "hard").glob("test_*.py"):
        assert f"`tests/hard/{path.name}`" in page, path.name


def test_random_models_tried_besides_are_counted_once_each(tmp_path):
    trial = {"family": "relay", "outcome": "no orbit", "n_points": 0, "n_multipliers": 0, "worst_orbit": 0.0}
    trial |= {"worst_multiplier": 0.0, "at_limit": 0, "too_sensitive": 0, "warned": 0, "faults": [], "refused": []}
    lines = [json.dumps({**trial, "attractors": {}, "seed": seed}) for seed in (1, 2, 2, 3)]
    (tmp_path / "trials.jsonl").write_text("\n".join(lines) + "\n")
    (tmp_path / "rows.json").write_text("[]")
    main(tmp_path / "rows.json", tmp_path / "page.md", tmp_path / "trials.jsonl")
    assert "| relay | 3 | 0 |" in (tmp_path / "page.md").read_text()
