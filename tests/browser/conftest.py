"""A browser without a window, and pages opened in it; ``make browser-tests`` has what is needed."""

import contextlib
import os

import pytest

from pddecont.report import render_page
from pddecont.results import read_results
from tests.browser.chromium import MissingBrowserError, open_browser
from tests.browser.explored import Explored
from tests.plot import equilibria, synthetic
from tests.report.test_page_data import SIMULATED
from tests.runs import run

# Set where a browser must be there, and a test without one fails instead of being left out.
NEEDED = "PDDECONT_BROWSER"


@pytest.fixture(scope="session")
def browser():
    with contextlib.ExitStack() as stack:
        try:
            started = stack.enter_context(open_browser())
        except MissingBrowserError as exc:
            (pytest.fail if os.environ.get(NEEDED) else pytest.skip)(str(exc))
        yield started


@pytest.fixture
def explore(browser, tmp_path):
    """Open the page on results files; in the end nothing may have been said on the console, or asked for outside."""
    opened = []

    def open_page(*files):
        path = tmp_path / f"page{len(opened)}.html"
        path.write_text(render_page(*files), encoding="utf-8")
        page = browser.new_page(viewport={"width": 1400, "height": 1500})
        explored = Explored(page)
        opened.append(explored)
        page.goto(path.as_uri())
        page.wait_for_selector("#explorer[data-ready]", timeout=30_000)
        return explored

    yield open_page
    for explored in opened:
        explored.page.close()
        assert explored.problems == []
        assert {address.split(":")[0] for address in explored.asked} <= {"file", "data", "blob"}


@pytest.fixture(scope="session")
def orbits(tmp_path_factory):
    return read_results(synthetic.write_all(tmp_path_factory.mktemp("orbits") / "orbits.h5"))


@pytest.fixture(scope="session")
def resting(tmp_path_factory):
    return read_results(equilibria.write_resting(tmp_path_factory.mktemp("resting") / "resting.h5"))


@pytest.fixture(scope="session")
def simulated(tmp_path_factory):
    return run(SIMULATED, tmp_path_factory.mktemp("simulated") / "simulated.h5")
