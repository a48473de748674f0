"""What tests of shipped models that are given by their equations share."""

import yaml

from pddecont.model import load_model
from pddecont.model.system import make_symbol
from tests.conftest import ROOT
from tests.runs import run

FINE = {"degree": 9, "tol": 1e-12}


def field(model, mode, values):
    """Return a mode's vector field where states and parameters have ``values``."""
    found = load_model(str(ROOT / "models" / f"{model}.yaml"))[0]
    values = {make_symbol(name): v for name, v in {**found.parameters, **values}.items()}
    return [float(f.xreplace(values)) for f in found.modes[mode]]


def shipped_run(model, path, n_steps=None, **more):
    """Return the results of a shipped model's own run, or of its first steps."""
    block = read_model(model)["run"]
    return run({"model": model, **block, "steps": block["steps"][:n_steps], **more}, path / "a.h5")


def read_model(name):
    """Return the mapping of a shipped model's file."""
    return yaml.safe_load((ROOT / "models" / f"{name}.yaml").read_text())
