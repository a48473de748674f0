"""A page that follows a run, and what it keeps when it is read anew."""

import time

import pytest

from pddecont.report import Live, render_page
from pddecont.results import create_results, read_results
from tests.browser.explored import Explored
from tests.plot import synthetic


@pytest.fixture
def follow(browser, tmp_path):
    """Return a function that writes the page on the first rows of a branch, and the page in a browser."""
    path, rows = tmp_path / "page.html", synthetic.gain()

    def write(n, every, written=None):
        results = tmp_path / f"run{n}" / "run.h5"
        results.parent.mkdir()
        create_results(results, "model", "run", "run.yaml", "{}")
        synthetic.add(results, "in_gain", rows[:n])
        live = Live(round(1000 * (written or time.time())), every) if every else None
        path.write_text(render_page(read_results(results), live=live), encoding="utf-8")

    page = browser.new_page(viewport={"width": 1400, "height": 1000})
    yield write, Explored(page), path.as_uri()
    page.close()


def wait_for_points(explored, n):
    explored.page.wait_for_function(
        f"() => document.getElementById('explorer')?.dataset.ready && "
        f"document.getElementById('explorer-status').textContent.includes('of {n}')",
        timeout=20_000,
    )


def test_new_points_come_in_and_what_is_shown_stays(follow):
    write, explored, address = follow
    write(6, every=500)
    explored.page.goto(address)
    wait_for_points(explored, 6)
    assert "The run goes on; this is what it had found at" in explored.text("#explorer-live")
    explored.choose("y", "period")
    explored.press("Home", "ArrowRight", "ArrowRight", "+")
    row, ranges = explored.row(), explored.ranges()
    write(9, every=500)
    wait_for_points(explored, 9)
    assert explored.row() == row
    assert explored.page.input_value("#explorer-y") == "period"
    assert explored.ranges() == ranges
    # Shown whole, it stays whole.
    explored.press("0")
    before = explored.ranges()
    write(12, every=0)
    wait_for_points(explored, 12)
    assert explored.ranges() != before
    assert explored.text("#explorer-live") == ""
    whole = explored.ranges()
    explored.press("0")
    assert explored.ranges() == whole
    assert explored.problems == []


def test_a_page_in_use_is_not_taken_away(follow):
    write, explored, address = follow
    write(6, every=200)
    explored.page.goto(address)
    wait_for_points(explored, 6)
    explored.page.evaluate("() => { window.isSame = true; }")
    write(9, every=200)
    explored.page.mouse.move(600, 300)
    explored.page.mouse.down()
    explored.page.wait_for_timeout(3500)
    assert explored.page.evaluate("() => window.isSame")
    explored.page.mouse.up()
    wait_for_points(explored, 9)
    assert explored.page.evaluate("() => window.isSame") is None


def test_a_run_that_was_stopped_is_said_to_be_old(follow):
    write, explored, address = follow
    write(6, every=60_000, written=time.time() - 300)
    explored.page.goto(address)
    wait_for_points(explored, 6)
    assert "there is nothing new since then. It may have been stopped." in explored.text("#explorer-live")


@pytest.mark.parametrize("address", ["%7B", "null", "%5B1%5D", "%7B%22view%22%3A%22none%22%7D", "<img src=x>"])
def test_an_address_that_says_nonsense_is_passed_over(follow, address):
    write, explored, page = follow
    write(6, every=0)
    explored.page.goto(f"{page}#{address}")
    wait_for_points(explored, 6)
    assert explored.problems == []


def test_an_address_can_be_passed_on(follow):
    write, explored, address = follow
    write(9, every=0)
    explored.page.goto(address)
    wait_for_points(explored, 9)
    explored.choose("x", "period")
    explored.press("End", "ArrowLeft", "+", "+")
    explored.page.wait_for_timeout(600)
    passed_on, shown = explored.page.url, (explored.row(), explored.ranges())
    explored.page.goto("about:blank")
    explored.page.goto(passed_on)
    wait_for_points(explored, 9)
    assert (explored.row(), explored.ranges()) == shown
    assert explored.page.input_value("#explorer-x") == "period"
