"""The report: one page that is well formed, holds everything, loads nothing and trusts no text."""

import base64
import json
import re
from functools import cache
from html.parser import HTMLParser
from xml.etree import ElementTree

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from jinja2 import UndefinedError

from pddecont.reasons import make_reason
from pddecont.report import render_page
from pddecont.report.page import MAX_ROWS, Picture, make_environment
from pddecont.results import create_results, read_results
from tests.cli.test_cli import call
from tests.plot import equilibria, synthetic

VOID = {"meta", "img", "br", "link", "input"}
HOSTILE = "<script>alert('x')</script><img src=\"https://example.org/a.png\" onerror='alert(1)'>$\\frac"

# What HTML cannot hold as it is (a carriage return, control characters) is no text of a page.
TEXTS = st.text(
    st.characters(blacklist_categories=("Cc", "Cs"), whitelist_characters="\n"), max_size=30
) | st.sampled_from(["<b>", "&lt;", "</pre>", "{{ 7*7 }}", "{% raw %}", "\"' onerror=", "<!--", "]]>"])


class Page(HTMLParser):
    """Reads a page, with its tags, their attributes and its text; fails where tags do not close."""

    def __init__(self, text):
        super().__init__()
        self.open, self.tags, self.text = [], [], []
        self.feed(text)
        self.close()
        assert not self.open

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)

    def of(self, tag):
        return [attributes for name, attributes in self.tags if name == tag]


@pytest.fixture(scope="module")
def text(tmp_path_factory):
    path = tmp_path_factory.mktemp("report") / "some.h5"
    create_results(path, "model", "run", "/home/somebody/run.yaml", '{"numpy": "2.0"}')
    synthetic.add(path, "orbit", synthetic.gain()[:1], kind="orbit")
    synthetic.add(path, "in_delay", [synthetic.point(float(k), 0.3, 3.0 + k, 1.0) for k in range(2)], free=("tau_d",))
    synthetic.add(path, "in_gain", synthetic.gain())
    synthetic.add(path, "grazing", synthetic.grazing_curve(), free=("tau_d", "K"), curve="GR", side=True)
    return render_page(read_results(path))


def test_the_page_holds_every_step_its_points_and_its_pictures(text):
    read = Page(text)
    said = " ".join(read.text)
    for word in (
        "in_gain",
        "in_delay",
        "grazing",
        "run.yaml",
        "numpy",
        "LP1",
        "GR1",
        "GG1",
        "reached the end",
        "fold",
        "grazing",
    ):
        assert word in said
    captions = [a["alt"] for a in read.of("img")]
    assert captions[:2] == ["overview", "manifold"]
    assert {"in_gain: diagram", "in_gain: multipliers", "orbit: profile", "grazing: plane", "grazing: orbit"} <= set(
        captions
    )
    assert "in_delay: multipliers" not in captions
    assert not [a for a in read.of("p") if a.get("class") == "none"]  # every picture that is listed could be drawn
    assert "somebody" not in text  # folders are nobody's business
    anchors = {a["id"] for _, a in read.tags if "id" in a}
    assert {a["href"][1:] for a in read.of("a")} <= anchors
    assert len(read.of("a")) == 4


def test_every_picture_is_a_whole_image_within_the_page(text):
    for attributes in Page(text).of("img"):
        media, _, data = attributes["src"].partition(";base64,")
        assert media == "data:image/svg+xml"
        svg = base64.b64decode(data, validate=True)
        assert ElementTree.fromstring(svg).tag.endswith("svg")
        assert b"<script" not in svg


def test_nothing_comes_from_outside_and_nothing_runs(text):
    read = Page(text)
    assert not re.search(r"(?:https?:)?//", re.sub(r"base64,[A-Za-z0-9+/=]+", "", text))
    assert not read.of("script") and not read.of("link")
    assert not any(name.startswith("on") for _, attributes in read.tags for name in attributes)
    [policy] = [a["content"] for a in read.of("meta") if a.get("http-equiv") == "Content-Security-Policy"]
    assert policy.startswith("default-src 'none'")


def test_text_of_a_stranger_is_only_text(tmp_path):
    path = tmp_path / "h.h5"
    create_results(path, HOSTILE, HOSTILE + "run", HOSTILE, json.dumps({"numpy": HOSTILE}))
    row = synthetic.point(0.0, 0.2, 3.8, 1.0, reason=make_reason("text", text=HOSTILE), signature="<b>NC</b> C")
    rows = [row, row | {"arclength": 1.0, "kind": b"LP", "parameters": [0.8, 0.3, 3.8]}]
    synthetic.add(path, "step", rows)
    text = render_page(read_results(path))
    read = Page(text)
    assert not {"script", "b", "i"} & {tag for tag, _ in read.tags}
    assert all(a["src"].startswith("data:image/") for a in read.of("img"))
    assert not any(name.startswith("on") for _, attributes in read.tags for name in attributes)
    assert HOSTILE in "".join(read.text)
    assert "<b>NC</b> C" in "".join(read.text)
    assert read.of("img")


def test_an_unfinished_file_has_a_page_too(tmp_path):
    path = tmp_path / "empty.h5"
    create_results(path, "model", "run", "run.yaml", "{}")
    assert "Steps" in Page(render_page(read_results(path))).text
    synthetic.add(path, "nothing_yet", [])
    assert "nothing_yet" in Page(render_page(read_results(path))).text


@cache
def macros():
    return make_environment().get_template("tables.html").module


@settings(max_examples=40, deadline=None)
@given(TEXTS, TEXTS, TEXTS)
def test_any_text_in_a_table_is_only_text(name, first, second):
    read = Page(str(macros().table([{name: first, name + "2": [second]}], ["step-0"])))
    assert "".join(read.text).replace("\n", "") == "".join((name, name, "2", first, second)).replace("\n", "")
    lines = second.count("\n")
    assert [tag for tag, _ in read.tags] == ["table", "tr", "th", "th", "tr", "td", "a", "td", *["br"] * lines]


@settings(max_examples=40, deadline=None)
@given(TEXTS, TEXTS)
def test_any_text_elsewhere_is_only_text(title, text):
    for read, tags, words in (
        (Page(str(macros().folded(title, text))), ["details", "summary", "pre"], title + text),
        (Page(str(macros().facts({title: text}))), ["dl", "dt", "dd", *["br"] * text.count("\n")], title + text),
        (Page(str(macros().picture(Picture(title, problem=f"{text}!")))), ["p"], f"{title}: {text}!"),
        (Page(str(macros().picture(Picture(title, text)))), ["figure", "img", "figcaption"], title),
    ):
        assert [tag for tag, _ in read.tags] == tags
        assert "".join(read.text).replace("\n", "") == words.replace("\n", "")
    [image] = read.of("img")
    assert image == {"alt": title, "src": text}


def test_long_tables_end_with_where_the_rest_is():
    assert str(macros().table([])).strip() == ""
    shown = str(macros().table([{"n": i} for i in range(MAX_ROWS + 3)]))
    assert shown.rstrip().endswith("<p>3 more rows: see 'pddecont export'.</p>")
    assert len(Page(shown).of("tr")) == MAX_ROWS + 1


def test_what_a_page_is_made_of_is_there_or_is_an_error():
    environment = make_environment()
    assert environment.autoescape is True
    with pytest.raises(UndefinedError):
        environment.from_string("{{ nothing }}").render()


def test_the_command_writes_the_page(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    create_results(tmp_path / "old.h5", "model", "run", "run.yaml", "{}")
    synthetic.add(tmp_path / "old.h5", "orbit", synthetic.gain()[:1], kind="orbit", new=False)
    assert call("report", "old.h5")[0] == 0
    assert Page((tmp_path / "old.html").read_text()).of("img")
    code, _, err = call("report", "old.h5", "-o", "old.pdf")
    assert code == 1 and "a report is .html; found '.pdf'" in err
    assert call("report", "none.h5")[0] == 1
    code, _, err = call("report", "old.h5", "-o", "no/folder.html")
    assert code == 1 and "cannot be written" in err


def test_numbers_too_large_to_draw_leave_a_word_in_place_of_the_picture(tmp_path):
    path = tmp_path / "large.h5"
    create_results(path, "model", "run", "run.yaml", "{}")
    rows = [row | {"monitors": [(-1) ** k * 1e308]} for k, row in enumerate(synthetic.gain())]
    synthetic.add(path, "in_gain", rows)
    text = render_page(read_results(path))
    assert "cannot be drawn so" in text
    assert "1e+308" in text


def test_equilibria_are_on_the_page_with_their_pictures(tmp_path):
    read = Page(render_page(read_results(equilibria.write_resting(tmp_path / "a.h5"))))
    said = " ".join(read.text)
    for words in ("all 2 equilibria in the box; also 1 virtual one", "through the modes [low], [high]", "Hopf"):
        assert words in said
    captions = [a["alt"] for a in read.of("img")]
    assert captions[:2] == ["overview", "manifold"]
    assert {"all: diagram", "all: roots", "resting: diagram", "hopf: plane", "boundaries: roots"} <= set(captions)
    assert not [a for a in read.of("p") if a.get("class") == "none"]
