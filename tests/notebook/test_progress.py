"""The bar below a notebook's cell: in a display of its own, and in the kernel of a real notebook."""

import sys
import types

import pytest

import pddecont
from pddecont.errors import PddecontError
from pddecont.notebook import NotebookProgress
from pddecont.steps import Silent
from tests.api.sample_runs import RELAY, WRIGHT

STEPS = [{"name": "rest", "equilibrium": {"search": {"x": [-2, 2]}}}]
CELL = f"""
import pddecont
found = pddecont.run({WRIGHT!r}, steps={STEPS!r})
found
"""


@pytest.fixture
def shown(monkeypatch):
    """All that a notebook's display is given in turn, in one that stands in for IPython's."""
    bundles = []

    class Handle:
        def update(self, bundle, raw):
            assert raw
            bundles.append(bundle)

    def display(bundle, raw, display_id):
        assert raw and display_id
        bundles.append(bundle)
        return Handle()

    stand_in = types.ModuleType("IPython")
    stand_in.get_ipython = lambda: types.SimpleNamespace(kernel=object())
    stand_in.display = types.ModuleType("IPython.display")
    stand_in.display.display = display
    monkeypatch.setitem(sys.modules, "IPython", stand_in)
    monkeypatch.setitem(sys.modules, "IPython.display", stand_in.display)
    return bundles


def test_a_run_in_a_notebook_shows_a_bar_and_leaves_a_list(shown):
    pddecont.run(WRIGHT, steps=STEPS)
    assert shown[0]["text/html"] == '<progress max="1"></progress> rest: equilibrium'
    assert shown[-1]["text/html"].startswith("<details><summary>1 step done</summary><ul><li>rest: ")
    assert shown[-1]["text/plain"] == "1 step done"


def test_a_reporter_of_ones_own_hears_instead(shown):
    pddecont.run(WRIGHT, steps=STEPS, reporter=Silent())
    assert shown == []


def test_a_run_that_fails_says_where(shown):
    # The growth outruns the relay: the motion leaves for good and no orbit is found.
    steps = [{"name": "transient", "simulate": {"t_end": 60}}, {"name": "orbit", "orbit": {"from": "transient"}}]
    with pytest.raises(PddecontError):
        pddecont.run(RELAY, set={"a": 1.5}, steps=steps)
    assert "then broken off in" in shown[-1]["text/plain"]


def test_texts_are_escaped_and_the_share_is_kept_within_its_bounds(shown):
    progress = NotebookProgress(every=0)
    progress.step("<b>", "continue")
    progress.progress("<script>", 1.5)
    assert shown[-1]["text/html"] == '<progress max="1" value="1.0000"></progress> &lt;b&gt;: &lt;script&gt;'
    progress.advance(1, 4, "motions")
    assert shown[-1]["text/html"] == '<progress max="1" value="0.2500"></progress> &lt;b&gt;: 1 of 4 motions'
    progress.note("<i>note")
    progress.done("<u>done")
    progress.close(True)
    assert "<li>&lt;i&gt;note</li><li>&lt;b&gt;: &lt;u&gt;done</li>" in shown[-1]["text/html"]


def test_a_long_list_names_its_last_lines(shown):
    progress = NotebookProgress()
    for k in range(60):
        progress.step(f"s{k}", "continue")
        progress.done("ended")
    progress.close(True)
    assert "<li>10 lines before</li><li>s10: ended</li>" in shown[-1]["text/html"]
    assert "60 steps done" in shown[-1]["text/html"]


def test_the_display_is_not_shown_anew_more_often_than_it_is_looked_at(shown):
    progress = NotebookProgress(every=3600)
    for k in range(100):
        progress.progress(f"{k}")
    assert len(shown) == 1


def test_outside_of_a_notebook_nothing_is_shown(capfd):
    pddecont.run(WRIGHT, steps=STEPS)
    assert capfd.readouterr() == ("", "")


def test_a_real_notebook_holds_the_list_and_the_results():
    nbformat = pytest.importorskip("nbformat")
    nbclient = pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    book = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(CELL)])
    nbclient.NotebookClient(book, timeout=120).execute()
    progress, result = book.cells[0].outputs
    assert progress["output_type"] == "display_data"
    assert progress["data"]["text/html"].startswith("<details><summary>1 step done")
    assert result["output_type"] == "execute_result"
    assert "data:image/svg+xml;base64," in result["data"]["text/html"]
    assert "results of wright" in result["data"]["text/plain"]
