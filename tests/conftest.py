from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pddecont.codegen import NumericModel
from pddecont.model import Model, load_model, parse_document, parse_model
from tests.runs import to_yaml

pytest_plugins = ["tests.reliability"]
ROOT = Path(__file__).parent.parent
SHIPPED = sorted((ROOT / "models").glob("*.yaml"))
# The generated chain of fifty oscillators has a hundred states: too large for checks of every function.
MODELS = [p for p in SHIPPED if not p.stem.startswith("oscillator_chain")]
CONFIGS = sorted((ROOT / "configs").glob("*.yaml"))
# Files whose tests take longest.
LONG = (
    "test_docs.py",
    "models/test_models.py",
    "batch/test_batch.py",
    "faults/test_interrupt.py",
    "random_models/test_kept_seeds.py",
    "test_paper.py",
)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with the files that take longest, so that in the end nobody waits for one of them."""
    first = {ROOT / "tests" / name for name in LONG}
    items.sort(key=lambda item: item.path not in first)


def model_from(model: str | dict, path: str = "m.yaml") -> Model:
    """Return a model written as text or as a mapping."""
    text = model if isinstance(model, str) else to_yaml(model)
    return parse_model(parse_document(text, path))[0]


def numeric_from(model: str | dict) -> NumericModel:
    return NumericModel(model_from(model))


def shipped(name: str) -> NumericModel:
    return NumericModel(load_model(str(ROOT / "models" / f"{name}.yaml"))[0])


def all_derivatives(function, arguments, free=()):
    """A function's derivatives with zeros in place: (as they come, dx, dxd, dp, dt)."""
    d, where = function.derivatives(*arguments, free), function.structure(free)
    n_points = d.value.shape[1]
    dense = [np.zeros((function.n_out, n, n_points)) for n in (len(function.states), len(function.delayed), len(free))]
    for array, places, values in zip(dense, (where.dx, where.dxd, where.dp), (d.dx, d.dxd, d.dp), strict=True):
        array[places] = values
    dt = np.zeros_like(d.value)
    dt[where.dt] = d.dt
    return d, *dense, dt


@pytest.fixture
def in_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path
