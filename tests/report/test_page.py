"""The report: one page that is well formed, holds everything, loads nothing and trusts no text."""

import base64
import json
import re
import zlib
from functools import cache
from html.parser import HTMLParser
from xml.etree import ElementTree

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from jinja2 import UndefinedError

from pddecont.plot import ViewRequest
from pddecont.reasons import make_reason
from pddecont.report import render_page
from pddecont.report.explorer import hash_script, pack_library, read_library, read_script, write_policy
from pddecont.report.page import MAX_ROWS, Picture, draw_picture, make_environment
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
    # What the explorer shows has no pictures.
    assert [a["alt"] for a in read.of("img")] == ["manifold"]
    assert not [a for a in read.of("p") if a.get("class") == "none"]  # every picture that is listed could be drawn
    assert "somebody" not in text  # folders are nobody's business
    anchors = {a["id"] for _, a in read.tags if "id" in a}
    assert {a["href"][1:] for a in read.of("a")} <= anchors
    assert len(read.of("a")) == 4


def test_every_part_that_the_script_looks_for_is_in_the_page(text):
    known = {a["id"] for _, a in Page(text).tags if "id" in a}
    for name in re.findall(r'getElementById\("([\w-]+)"\)', read_script()):
        assert name in known
    for name in re.findall(r"#([\w-]+)", read_script()):
        assert name in known or re.fullmatch("[0-9a-f]{3}|[0-9a-f]{6}", name), name


def test_every_picture_is_a_whole_image_within_the_page(text):
    for attributes in Page(text).of("img"):
        media, _, data = attributes["src"].partition(";base64,")
        assert media == "data:image/svg+xml"
        svg = base64.b64decode(data, validate=True)
        assert ElementTree.fromstring(svg).tag.endswith("svg")
        assert b"<script" not in svg


def test_nothing_comes_from_outside_and_nothing_runs_but_the_explorer(text):
    read = Page(text)
    assert not re.search(r"https?:", text.replace(read_script(), ""))
    assert not read.of("link")
    assert not any(name in attributes for _, attributes in read.tags for name in ("srcset", "action", "data"))
    assert all(a["src"].startswith("data:") for _, a in read.tags if "src" in a)
    assert not any(name.startswith("on") for _, attributes in read.tags for name in attributes)
    assert [a.get("type") for a in read.of("script")] == ["application/octet-stream"] * 2 + [None]
    [policy] = [a["content"] for a in read.of("meta") if a.get("http-equiv") == "Content-Security-Policy"]
    assert policy.startswith("default-src 'none'; script-src 'sha256-")
    assert "unsafe-eval" not in policy and policy.count("unsafe-inline") == 1
    assert set(re.findall(r"'sha256-[^']+'", policy)) == {hash_script(read_script()), hash_script(read_library())}
    own = text[text.rindex("<script>") + len("<script>") : text.rindex("</script>")]
    assert hash_script(own) in policy
    assert zlib.decompress(base64.b64decode(pack_library())).decode() == read_library()
    assert pack_library() in text


def test_text_of_a_stranger_is_only_text(tmp_path):
    path = tmp_path / "h.h5"
    create_results(path, HOSTILE, HOSTILE + "run", HOSTILE, json.dumps({"numpy": HOSTILE}))
    row = synthetic.point(0.0, 0.2, 3.8, 1.0, reason=make_reason("text", text=HOSTILE), signature="<b>NC</b> C")
    rows = [row, row | {"arclength": 1.0, "kind": b"LP", "parameters": [0.8, 0.3, 3.8]}]
    synthetic.add(path, "step", rows)
    text = render_page(read_results(path))
    read = Page(text)
    [policy] = [a["content"] for a in read.of("meta") if a.get("http-equiv") == "Content-Security-Policy"]
    assert policy == write_policy(with_scripts=True)
    assert not {"b", "i"} & {tag for tag, _ in read.tags}
    assert [a.get("type") for a in read.of("script")] == ["application/octet-stream"] * 2 + [None]
    assert all(hash_script(text) in policy for text in (read_script(), read_library()))
    assert all(a["src"].startswith("data:image/") for a in read.of("img"))
    assert not any(name.startswith("on") for _, attributes in read.tags for name in attributes)
    assert HOSTILE in "".join(read.text)
    assert "<b>NC</b> C" in "".join(read.text)


def test_an_unfinished_file_has_a_page_too(tmp_path):
    path = tmp_path / "empty.h5"
    create_results(path, "model", "run", "run.yaml", "{}")
    text = render_page(read_results(path))
    assert "Steps" in Page(text).text
    assert not Page(text).of("script")
    assert write_policy(with_scripts=False) in [a.get("content") for a in Page(text).of("meta")]
    assert "script-src" not in text
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
    assert "old.h5, from run.yaml" in Page((tmp_path / "old.html").read_text()).text
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
    results = read_results(path)
    picture = draw_picture(results, ViewRequest("diagram", ("in_gain",)), "diagram")
    assert "cannot be drawn so" in picture.problem and not picture.address
    assert "1e+308" in render_page(results)


def test_equilibria_are_on_the_page_with_their_pictures(tmp_path):
    read = Page(render_page(read_results(equilibria.write_resting(tmp_path / "a.h5"))))
    said = " ".join(read.text)
    for words in ("all 2 equilibria in the box; also 1 virtual one", "through the modes [low], [high]", "Hopf"):
        assert words in said
    assert [a["alt"] for a in read.of("img")] == ["manifold"]
    assert not [a for a in read.of("p") if a.get("class") == "none"]


def test_several_files_have_one_page(tmp_path):
    paths = [equilibria.write_resting(tmp_path / name) for name in ("a.h5", "b.h5")]
    read = Page(render_page(*map(read_results, paths)))
    anchors = [a["id"] for _, a in read.tags if "id" in a]
    assert len(anchors) == len(set(anchors))
    assert len(read.of("a")) == 2 * len(read_results(paths[0]).steps)
    assert {"a.h5, from run.yaml", "b.h5, from run.yaml"} <= set(read.text)
