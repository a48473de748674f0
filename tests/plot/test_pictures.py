"""Views as figures, as images and as files."""

import numpy as np
import pytest
from PIL import Image

from pddecont.errors import ResultsError
from pddecont.plot import VIEWS, ViewRequest, draw_picture, render_image, save_picture
from pddecont.plot.views import animate
from tests.cli.test_cli import call


@pytest.fixture
def few(monkeypatch):
    monkeypatch.setattr(animate, "MAX_FRAMES", 6)


def test_a_gif_has_a_frame_for_each_point_that_is_shown(every, few, tmp_path):
    save_picture(every, ViewRequest("animate", ("in_gain",)), tmp_path / "a.gif")
    with Image.open(tmp_path / "a.gif") as moving:
        assert moving.n_frames == 6
        first = np.asarray(moving.convert("L")).copy()
        moving.seek(5)
        assert np.any(np.asarray(moving.convert("L")) != first)


def test_suffixes_and_views_go_together(every, tmp_path):
    with pytest.raises(ResultsError, match=r"'\.gif' holds moving pictures; give '--view animate'"):
        save_picture(every, ViewRequest(), tmp_path / "a.gif")
    with pytest.raises(ResultsError, match=r"pictures are \.png, \.svg, \.pdf; found 'no suffix'"):
        save_picture(every, ViewRequest(), tmp_path / "a")
    with pytest.raises(ResultsError, match=r"moving pictures are \.gif, \.mp4; found '\.png'"):
        save_picture(every, ViewRequest("animate"), tmp_path / "a.png")
    with pytest.raises(ResultsError, match="it can be drawn as orbit, profile"):
        save_picture(every, ViewRequest("animate", ("orbit",)), tmp_path / "a.gif")


def test_without_ffmpeg_there_is_advice(every, tmp_path, monkeypatch):
    from matplotlib.animation import FFMpegWriter

    monkeypatch.setattr(FFMpegWriter, "isAvailable", classmethod(lambda cls: False))
    with pytest.raises(ResultsError, match="'ffmpeg', which was not found; install it"):
        save_picture(every, ViewRequest("animate"), tmp_path / "a.mp4")


def test_a_moving_view_is_no_figure(every):
    with pytest.raises(ResultsError, match=r"'animate' moves; it goes into a file \(\.gif, \.mp4\)"):
        draw_picture(every, ViewRequest("animate", ("in_gain",)))


def test_a_file_that_cannot_be_written_is_named(every, tmp_path):
    with pytest.raises(ResultsError, match=r"a\.png cannot be written: No such file"):
        save_picture(every, ViewRequest(), tmp_path / "none" / "a.png")


def test_numbers_that_cannot_be_drawn_are_said_so(every, tmp_path, monkeypatch):
    from pddecont.plot.views import plane

    def fail(*_):
        raise ValueError("strange\nnumbers" + 300 * "!")

    monkeypatch.setattr(plane, "draw_plane", fail)
    with pytest.raises(ResultsError, match=r"cannot be drawn so: strange numbers!{185}$"):
        save_picture(every, ViewRequest(), tmp_path / "a.png")


def test_the_command_lists_the_views_of_each_step(every):
    # That all of them can be drawn is for the page of tests/report/test_page.py to show.
    code, out, _ = call("plot", every.path, "--list")
    assert code == 0
    assert out.splitlines()[every.names.index("orbit")] == "orbit  orbit  orbit, profile, multipliers"
    assert len(out.splitlines()) == len(every.steps)
    assert call("plot", every.path, "--list", "--step", "nothing")[0] == 1


def test_a_picture_is_the_same_each_time(every):
    first, second = (render_image(every, ViewRequest("orbit", ("in_gain",))) for _ in range(2))
    assert first == second


def test_a_large_picture_becomes_a_png(every, monkeypatch):
    monkeypatch.setattr("pddecont.plot.pictures.MAX_SVG_BYTES", 100)
    media, contents = render_image(every, ViewRequest())
    assert media == "image/png"
    assert contents.startswith(b"\x89PNG")


def test_the_one_moving_view_is_named_in_the_advice():
    assert [view.name for view in VIEWS.values() if view.is_moving] == ["animate"]
