"""Each shipped model's own run, once, against the values in the file of its name."""

import re

import numpy as np
import pytest

from pddecont.model import leave_out_effects, load_model, parse_document
from pddecont.results import read_results
from pddecont.steps import load_run_plan
from pddecont.steps.execution import execute
from pddecont.tables import describe_endings
from tests.conftest import ROOT
from tests.conftest import SHIPPED as MODELS
from tests.models import (
    test_machines,
    test_oscillators,
    test_populations,
    test_smooth_orbits,
    test_sticking,
    test_switching,
    test_varying_delays,
)
from tests.models.expected import FOLDER, both, entries, points

# Where expected values are calculated again.
INDEPENDENT = (
    test_machines,
    test_oscillators,
    test_populations,
    test_smooth_orbits,
    test_sticking,
    test_switching,
    test_varying_delays,
)
# Their branches take half a minute and more: tests/test_full_model.py and the benchmarks follow them.
LARGE = {"full_oscillator", "oscillator_chain_50"}


@pytest.mark.parametrize("path", MODELS, ids=lambda p: p.stem)
def test_a_models_run_gives_what_is_expected_of_it(path, tmp_path):
    execute(
        load_run_plan(parse_document(path.read_text(), str(path))),
        tmp_path / "a.h5",
        until="orbit" if path.stem in LARGE else None,
    )
    results = read_results(tmp_path / "a.h5")
    for item in entries(path.stem):
        for names in points(results, item["at"]):
            found, value = both(item, names)
            assert found == pytest.approx(value, abs=item["tol"], rel=0), (item["what"], names)
    for step in results.steps.values():
        if step.kind in ("orbit", "continue"):
            ordinary = np.isin(step.points["kind"], [b"VS", b"GR"], invert=True)
            assert np.all(step.points["admissible"][ordinary] == 1), step.name
            assert not any("not located" in text for text in describe_endings(step)), step.name


@pytest.mark.parametrize("path", MODELS, ids=lambda p: p.stem)
def test_what_is_expected_says_where_it_is_from(path):
    for item in entries(path.stem):
        assert item["source"] and item["because"], item["what"]
        # A number is either from elsewhere or calculated again here; an expression is its own derivation.
        if "independent" in item:
            name = item["independent"]
            assert any(hasattr(room, name) for room in INDEPENDENT), name


def test_every_file_of_expected_values_belongs_to_a_model():
    assert {p.stem for p in FOLDER.glob("*.yaml")} == {p.stem for p in MODELS}


@pytest.mark.parametrize("path", MODELS, ids=lambda p: p.stem)
def test_every_effect_can_be_left_out(path):
    model, _ = load_model(str(path))
    assert model.reference
    assert model.effects or path.stem == "linear_oscillator", "that one is what a model without its effects is"
    for name in model.effects:
        left = leave_out_effects(model, [name])
        changed = (left.modes, left.resets, left.events, left.delays) != (
            model.modes,
            model.resets,
            model.events,
            model.delays,
        )
        assert changed, f"leaving out '{name}' changes nothing"
        assert all(np.isfinite(left.evaluate(delay)) for delay in left.delays)


def test_the_page_of_models_lists_them_all():
    rows = re.findall(r"^\| `(\w+)` \|", (ROOT / "docs" / "models.md").read_text(), re.M)
    assert sorted(rows) == sorted(p.stem for p in MODELS)
