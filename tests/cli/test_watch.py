"""A page that follows a run."""

import re
from itertools import pairwise

import pytest

from pddecont.cli import watch
from pddecont.cli.watch import Watch
from pddecont.errors import ResultsError
from pddecont.steps import Silent
from tests.cli.test_cli import call

LIVE = re.compile(r'id="explorer-live" data-written="(\d+)" data-every="(\d+)"')


@pytest.fixture
def pages(monkeypatch):
    """The pages of a run that is watched at every point, as they were written."""
    found, write_report = [], watch.write_report

    def write(results, path, every=0.0):
        write_report(results, path, every)
        found.append(path.read_text())

    monkeypatch.setattr(watch, "write_report", write)
    monkeypatch.setattr(watch, "EVERY", 1e-3)
    monkeypatch.setattr(watch, "SHARE", 0.0)
    return found


def test_the_page_grows_with_the_run_and_ends_with_it(pages, tmp_path):
    path = tmp_path / "a.h5"
    code, _, err = call("run", "wall_oscillator", "-o", path, "--watch")
    assert code == 0
    page = path.with_suffix(".html")
    assert f"page: {page.as_uri()} follows the run in a browser" in err
    assert len(pages) > 5
    # Before the first step has a point there is nothing to explore: the browser itself reads such a page anew.
    assert all(LIVE.search(text) or 'http-equiv="refresh"' in text for text in pages[:-1])
    assert any(LIVE.search(text) for text in pages[:-1])
    assert "not finished" in pages[len(pages) // 2]
    assert page.read_text() == pages[-1]
    assert not LIVE.search(pages[-1]) and 'http-equiv="refresh"' not in pages[-1]
    call("report", path, "-o", tmp_path / "b.html")
    assert (tmp_path / "b.html").read_text() == pages[-1]


def test_watching_changes_no_number(pages, tmp_path):
    for name, options in (("a", ["--watch"]), ("b", [])):
        assert call("run", "wall_oscillator", "-o", tmp_path / f"{name}.h5", *options)[0] == 0
    assert pages
    assert (tmp_path / "a.h5").read_bytes() == (tmp_path / "b.h5").read_bytes()


def test_what_is_not_a_page_stays_and_nothing_is_computed(tmp_path):
    other = tmp_path / "a.html"
    other.write_text("mine")
    code, _, err = call("run", "wall_oscillator", "-o", tmp_path / "a.h5", "--watch")
    assert code == 1
    assert f"{other} exists and is not a report of pddecont" in err
    assert other.read_text() == "mine"
    assert not (tmp_path / "a.h5").exists()


def test_a_run_that_does_not_begin_leaves_the_page(pages, tmp_path):
    path = tmp_path / "a.h5"
    call("run", "wall_oscillator", "-o", path)
    code, _, err = call("run", "wall_oscillator", "-o", path, "--watch")
    assert code == 1 and "--overwrite" in err
    assert not path.with_suffix(".html").exists()


def test_a_page_that_cannot_be_written_is_said_once_and_the_run_goes_on(monkeypatch, tmp_path):
    def refuse(results, path, every=0.0):
        raise ResultsError("the disk is full")

    monkeypatch.setattr(watch, "write_report", refuse)
    code, _, err = call("run", "wall_oscillator", "-o", tmp_path / "a.h5", "--watch")
    assert code == 0
    assert err.count("the page is not written any more: the disk is full") == 1


def test_pages_take_a_tenth_of_the_time(monkeypatch, tmp_path):
    clock, written = [0.0], []

    def write(results, path, every=0.0):
        written.append(clock[0])
        clock[0] += 2.0

    monkeypatch.setattr(watch, "read_results", lambda path: None)
    monkeypatch.setattr(watch.time, "monotonic", lambda: clock[0])
    monkeypatch.setattr(watch, "write_report", write)
    watching = Watch(Silent(), tmp_path / "a.h5", tmp_path / "a.html")
    watching.step("a", "continue")
    for _ in range(1000):
        clock[0] += 0.1
        watching.progress("K = 1")
    assert written[0] == 0.0
    assert all(b - a >= 22.0 for a, b in pairwise(written))
    assert len(written) == pytest.approx(clock[0] / 22.0, abs=1.5)


def test_an_exploration_is_watched_too(pages, tmp_path):
    path = tmp_path / "a.h5"
    code, _, err = call(
        *("explore", "bouncing_ball", "--over", "G=0.5:0.6", "--starts", 4, "--check", 2, "--depth", 0),
        *("-o", path, "--watch"),
    )
    assert code == 0, err
    assert any(LIVE.search(text) for text in pages) and not LIVE.search(pages[-1])
