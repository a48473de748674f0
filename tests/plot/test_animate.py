"""The moving picture, the list of views and style sheets."""

import numpy as np
import pytest
from PIL import Image

from pddecont.errors import ResultsError
from pddecont.plot import animate as animation
from pddecont.plot.animate import _Shown, frames
from pddecont.plot.choice import View, views_of
from pddecont.plot.figure import _figure, draw, image
from pddecont.plot.look import look
from tests.cli.test_cli import call


@pytest.fixture
def few(monkeypatch):
    monkeypatch.setattr(animation, "MAX_FRAMES", 6)


def test_a_gif_has_a_frame_for_each_point_that_is_shown(every, few, tmp_path):
    draw(every, View("animate", ("in_gain",)), tmp_path / "a.gif")
    with Image.open(tmp_path / "a.gif") as moving:
        assert moving.n_frames == 6
        first = np.asarray(moving.convert("L")).copy()
        moving.seek(5)
        assert np.any(np.asarray(moving.convert("L")) != first)


def test_frames_are_in_order_hold_the_special_points_and_are_few(every, monkeypatch):
    step = every.step("in_gain")
    assert np.array_equal(frames(step), step.order)
    monkeypatch.setattr(animation, "MAX_FRAMES", 6)
    shown = frames(step)
    assert len(shown) == 6
    assert {step.row("LP1"), step.row("GR1")} <= set(shown)
    assert list(shown) == sorted(shown, key=list(step.order).index)


def test_the_panel_stays_while_the_orbit_moves(every):
    with look():
        shown = _Shown(_figure(4, 4).subplots(), every.step("in_gain"), View())
        shown.draw(0)
        limits = shown.axes.get_xlim(), shown.axes.get_ylim()
        assert "unstable" not in shown.axes.get_title()
        shown.draw(12)
        assert (shown.axes.get_xlim(), shown.axes.get_ylim()) == limits
        assert "unstable" in shown.axes.get_title()
        assert limits[0] == pytest.approx((-1.1, 1.1), abs=0.02)


def test_suffixes_and_views_go_together(every, tmp_path):
    with pytest.raises(ResultsError, match=r"'\.gif' holds moving pictures; give '--view animate'"):
        draw(every, View(), tmp_path / "a.gif")
    with pytest.raises(ResultsError, match=r"moving pictures are \.gif, \.mp4; found '\.png'"):
        draw(every, View("animate"), tmp_path / "a.png")
    with pytest.raises(ResultsError, match="it can be drawn as orbit, profile"):
        draw(every, View("animate", ("orbit",)), tmp_path / "a.gif")


def test_without_ffmpeg_there_is_advice(every, tmp_path, monkeypatch):
    from matplotlib.animation import FFMpegWriter

    monkeypatch.setattr(FFMpegWriter, "isAvailable", classmethod(lambda cls: False))
    with pytest.raises(ResultsError, match="'ffmpeg', which was not found; install it"):
        draw(every, View("animate"), tmp_path / "a.mp4")


def test_the_list_holds_what_can_be_drawn_and_all_of_it_can(every):
    views = {name: views_of(step) for name, step in every.steps.items()}
    assert views["orbit"] == ("orbit", "profile", "multipliers")  # one point does not move
    assert views["grazing"][0] == "plane"
    assert "manifold" in views["grazing"] and "manifold" not in views["in_gain"]  # a branch alone spans no plane
    assert "multipliers" in views["in_gain"] and "multipliers" not in views["in_delay"]
    for name in ("in_gain", "grazing"):
        for kind in views[name]:
            if kind != "animate":
                assert image(every, View(kind, (name,)))[0] == "image/svg+xml"
    code, out, _ = call("plot", every.path, "--list")
    assert code == 0
    assert out.splitlines()[every.names.index("orbit")] == "orbit  orbit  orbit, profile, multipliers"
    assert len(out.splitlines()) == len(every.steps)
    assert call("plot", every.path, "--list", "--step", "nothing")[0] == 1


def test_a_large_picture_becomes_a_png(every, monkeypatch):
    monkeypatch.setattr("pddecont.plot.figure.LARGE", 100)
    media, contents = image(every, View())
    assert media == "image/png"
    assert contents.startswith(b"\x89PNG")


def test_a_style_sheet_goes_over_the_programs_look(every, tmp_path):
    import matplotlib

    sheet = tmp_path / "mine.mplstyle"
    sheet.write_text("savefig.dpi: 40  # small\n")
    before = matplotlib.rcParams["savefig.dpi"]
    draw(every, View("diagram", ("in_delay",)), tmp_path / "a.png")
    draw(every, View("diagram", ("in_delay",)), tmp_path / "b.png", str(sheet))
    with Image.open(tmp_path / "a.png") as a, Image.open(tmp_path / "b.png") as b:
        assert a.size[0] == 4 * b.size[0]
    assert matplotlib.rcParams["savefig.dpi"] == before
    with look("ggplot"):
        assert matplotlib.rcParams["axes.facecolor"] == matplotlib.style.library["ggplot"]["axes.facecolor"]
        assert matplotlib.rcParams["figure.constrained_layout.use"]


@pytest.mark.parametrize(("text", "message"), [
    ("font.siz: 8\n", "Bad key font.siz"), ("font.size: huge\n", "huge"), ("just words\n", "Missing colon"), (b"\xff\xfe", "UTF-8"),
])  # fmt: skip
def test_what_is_wrong_in_a_style_sheet_is_told(tmp_path, text, message):
    sheet = tmp_path / "bad.mplstyle"
    sheet.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(ResultsError, match=message), look(str(sheet)):
        pass


def test_an_unknown_style_is_told_with_the_nearest():
    with pytest.raises(ResultsError, match="did you mean 'ggplot'"), look("ggplott"):
        pass
    # A style is no address: nothing is fetched.
    with pytest.raises(ResultsError, match="no such file"), look("https://example.org/a.mplstyle"):
        pass
