"""A browser without a window, and pages opened in it; ``make browser-tests`` has what is needed."""

import os
import shutil

import pytest

from pddecont.report import render_page
from pddecont.results import read_results
from tests.browser.explored import Explored
from tests.plot import equilibria, synthetic
from tests.report.test_page_data import SIMULATED
from tests.runs import run

CHROMIUM = ("chromium", "chromium-browser", "google-chrome")
# Set where a browser must be there, and a test without one fails instead of being left out.
NEEDED = "PDDECONT_BROWSER"


def find_browser():
    """Return what starts a page in Chromium, and where that is; leave the test out where one is missing."""
    path = next(filter(None, map(shutil.which, CHROMIUM)), None)
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        sync_playwright = None
    if not path or not sync_playwright:
        missing = "these tests need Chromium and the package playwright: 'make browser-tests'"
        if os.environ.get(NEEDED):
            pytest.fail(missing)
        pytest.skip(missing)
    return sync_playwright, path


@pytest.fixture(scope="session")
def browser():
    sync_playwright, path = find_browser()
    with sync_playwright() as playwright:
        # In containers tests run as root, for whom Chromium has no sandbox.
        arguments = ["--no-sandbox"] if os.geteuid() == 0 else []
        started = playwright.chromium.launch(executable_path=path, args=arguments)
        yield started
        started.close()


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
