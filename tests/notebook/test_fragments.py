"""What a notebook shows: every text escaped, pictures as images, tables cut."""

import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest

import pddecont
from pddecont.api import RunResults
from tests.api import sample_runs
from tests.api.sample_runs import WRIGHT

HOSTILE = "<script>alert(1)</script>\"'&"


class Tags(HTMLParser):
    """Collects names of elements, and what images show; sees that elements close."""

    def __init__(self):
        super().__init__(convert_charrefs=True)
        self.names, self.sources, self.open, self.text = [], [], [], ""

    def handle_starttag(self, tag, attrs):
        self.names.append(tag)
        assert not [name for name, _ in attrs if name.startswith("on")]
        if tag == "img":
            self.sources.append(dict(attrs)["src"])
        else:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += data


def read(shown):
    tags = Tags()
    tags.feed(shown._repr_html_())
    assert not tags.open
    assert set(tags.names) <= {"div", "p", "b", "table", "thead", "tbody", "tr", "th", "td", "img"}
    return tags


@pytest.fixture(scope="module")
def hostile():
    model = {**WRIGHT, "name": HOSTILE, "units": {"x": HOSTILE, "t": "s"}}
    return pddecont.run(model, steps=[{"name": "rest", "equilibrium": {"search": {"x": [-2, 2]}}}])


def test_texts_of_a_file_are_shown_and_nothing_of_them_runs(hostile):
    step = hostile["rest"]
    for shown in (hostile, step, step.point(), step.table(), step.table("roots")):
        tags = read(shown)
        assert HOSTILE in tags.text or shown is not hostile
    assert HOSTILE in read(step.table()).text  # the unit of x


@pytest.mark.parametrize("name", ["equilibria", "orbits", "attractors", "exploration", "precision"])
def test_results_and_steps_of_every_kind_show_tables_and_pictures(name):
    found = getattr(sample_runs, name)()
    tags = read(found)
    assert all(step in tags.text for step in found)
    for step in found:
        tags = read(found[step])
        assert bool(tags.sources) == bool(found[step].views)
        assert all(re.match(r"data:image/(svg\+xml|png);base64,", source) for source in tags.sources)
        assert tags.names.count("tr") <= 13


def test_points_and_orbits_show_their_own_pictures():
    branch = sample_runs.orbits()["branch"]
    a, b = read(branch.orbit("EP1")), read(branch.orbit("EP2"))
    assert len(a.sources) == len(b.sources) == 1
    assert a.sources != b.sources
    assert "branch: orbit EP1" in a.text
    assert read(branch.point("EP1")).sources != read(branch.point("EP2")).sources
    assert "Hopf" in read(sample_runs.equilibria()["line"].point("HB1")).text


def test_a_long_table_says_how_many_rows_are_left():
    table = sample_runs.orbits()["transient"].table()
    assert f"{len(table) - 12} more rows" in read(table).text
    assert "more rows" not in read(table[:12]).text


def test_units_stand_in_the_head_and_unknown_columns_are_left_out():
    text = read(sample_runs.precision()["orbit"].table()).text
    assert "period (s)" in text
    assert "stable" not in text


def test_a_step_shows_the_parameters_that_vary():
    head = read(sample_runs.orbits()["branch"]).text
    assert "a (1/s)" in head
    assert "tau" not in head
    assert "tau" in read(sample_runs.orbits()["branch"].table()).text


def test_what_is_shown_in_a_line_is_short():
    found = sample_runs.orbits()
    assert repr(found).splitlines()[0] == "<results of relay"
    assert repr(found["branch"]) == f"<continue step 'branch', {len(found['branch'])} points, EP1, EP2>"
    assert repr(found["branch"].orbit("EP1")).startswith("<orbit EP1 of step 'branch', period 4.87043")
    for shown in (found["branch"], found["branch"].orbit(), found["branch"].point(), found["branch"].table()):
        assert len(repr(shown)) < 200


def test_a_figure_draws_itself_as_a_png():
    figure = sample_runs.orbits().plot(steps=["branch"])
    assert figure._repr_png_().startswith(b"\x89PNG")


def test_what_would_move_a_terminals_cursor_is_written_out():
    results = sample_runs.orbits().results
    step = results.step("orbit")
    escape = replace(step, meta={**step.meta, "model": "\x1b[2J", "states": ["\x1b]0;"]})
    found = RunResults(replace(results, steps={"orbit": escape}, names=("orbit",)))
    for shown in (found, found["orbit"].table("orbit"), found["orbit"].orbit()):
        assert "\x1b" not in repr(shown)
    assert r"\x1b[2J" in repr(found)
    assert r"\x1b]0;" in repr(found["orbit"].table("orbit"))
