from __future__ import annotations

import pytest

from pddecont.plot.choice import View
from pddecont.plot.figure import picture
from pddecont.results.reader import read_results
from tests.plot import synthetic


@pytest.fixture(scope="session")
def every(tmp_path_factory):
    """Return the results file that holds every kind of step."""
    return read_results(synthetic.write_all(tmp_path_factory.mktemp("every") / "every.h5"))


@pytest.fixture(scope="session")
def old(tmp_path_factory):
    """Return a results file of the first version."""
    return read_results(synthetic.write_old(tmp_path_factory.mktemp("old") / "old.h5"))


@pytest.fixture
def show():
    """Return a function that draws a view and gives the figure."""
    return lambda results, *arguments, **options: picture(results, View(*arguments, **options))
