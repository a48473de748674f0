from __future__ import annotations

import pytest

from pddecont.plot import ViewRequest, draw_picture
from pddecont.results import create_results, read_results
from tests.plot import equilibria, synthetic
from tests.runs import run


@pytest.fixture(scope="session")
def every(tmp_path_factory):
    """Return the results file that holds every kind of step in which orbits are followed."""
    return read_results(synthetic.write_all(tmp_path_factory.mktemp("every") / "every.h5"))


@pytest.fixture(scope="session")
def resting(tmp_path_factory):
    """Return a results file with equilibria, the orbits born of them, and curves of both."""
    return read_results(equilibria.write_resting(tmp_path_factory.mktemp("resting") / "resting.h5"))


@pytest.fixture(scope="session")
def old(tmp_path_factory):
    """Return a results file of the first version."""
    return read_results(synthetic.write_old(tmp_path_factory.mktemp("old") / "old.h5"))


@pytest.fixture(scope="session")
def compared(tmp_path_factory):
    """Return a results file with two steps that compare methods."""
    return read_results(synthetic.write_precision(tmp_path_factory.mktemp("compared") / "compared.h5"))


@pytest.fixture(scope="session")
def simulated(tmp_path_factory):
    """Return the results of a run with every kind of simulation, and a branch in the sweep's parameter."""
    return run(synthetic.SIMULATIONS, tmp_path_factory.mktemp("simulated") / "s.h5")


@pytest.fixture
def made(tmp_path):
    """Return a function that makes a results file of steps: names with rows and options of ``synthetic.add``."""

    def make(**steps):
        path = tmp_path / "a.h5"
        path.unlink(missing_ok=True)
        create_results(path, "m", "r", "r", "{}")
        for name, (rows, options) in steps.items():
            synthetic.add(path, name, rows, **options)
        return read_results(path)

    return make


@pytest.fixture
def show():
    """Return a function that draws a view and gives the figure."""
    return lambda results, *arguments, **options: draw_picture(results, ViewRequest(*arguments, **options))


@pytest.fixture
def axes():
    from matplotlib.figure import Figure

    return Figure().subplots()
