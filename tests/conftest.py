from __future__ import annotations

from pathlib import Path

import pytest

from pddecont.model.builder import load_model, parse_model
from pddecont.model.codegen import NumericModel
from pddecont.model.document import parse_document
from pddecont.model.system import Model

pytest_plugins = ["tests.reliability"]
ROOT = Path(__file__).parent.parent
MODELS = sorted((ROOT / "models").glob("*.yaml"))
CONFIGS = sorted((ROOT / "configs").glob("*.yaml"))


def model_from(text: str, path: str = "m.yaml") -> Model:
    return parse_model(parse_document(text, path))[0]


def numeric_from(text: str) -> NumericModel:
    return NumericModel(model_from(text))


def shipped(name: str) -> NumericModel:
    return NumericModel(load_model(str(ROOT / "models" / f"{name}.yaml"))[0])


@pytest.fixture
def in_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path
