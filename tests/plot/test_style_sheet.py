"""Style sheets over the program's own settings."""

import os
import subprocess
import sys

import matplotlib
import pytest
from PIL import Image

from pddecont.errors import ResultsError
from pddecont.plot import ViewRequest, apply_style, save_picture


def test_a_style_sheet_goes_over_the_programs_settings(every, tmp_path):
    sheet = tmp_path / "mine.mplstyle"
    sheet.write_text("savefig.dpi: 40  # small\n")
    before = matplotlib.rcParams["savefig.dpi"]
    save_picture(every, ViewRequest("diagram", ("in_delay",)), tmp_path / "a.png")
    save_picture(every, ViewRequest("diagram", ("in_delay",)), tmp_path / "b.png", str(sheet))
    with Image.open(tmp_path / "a.png") as a, Image.open(tmp_path / "b.png") as b:
        assert a.size[0] == 4 * b.size[0]
    assert matplotlib.rcParams["savefig.dpi"] == before
    with apply_style("ggplot"):
        assert matplotlib.rcParams["axes.facecolor"] == matplotlib.style.library["ggplot"]["axes.facecolor"]
        assert matplotlib.rcParams["figure.constrained_layout.use"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("font.siz: 8\n", "Bad key font.siz"),
        ("font.size: huge\n", "huge"),
        ("just words\n", "Missing colon"),
        (b"\xff\xfe", "UTF-8"),
    ],
)
def test_what_is_wrong_in_a_style_sheet_is_said(tmp_path, text, message):
    sheet = tmp_path / "bad.mplstyle"
    sheet.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(ResultsError, match=message), apply_style(str(sheet)):
        pass


def test_the_nearest_to_an_unknown_style_is_suggested():
    with pytest.raises(ResultsError, match="did you mean 'ggplot'"), apply_style("ggplott"):
        pass
    # A style is no address: nothing is fetched.
    with pytest.raises(ResultsError, match="no such file"), apply_style("https://example.org/a.mplstyle"):
        pass


def test_a_home_folder_that_cannot_be_written_is_no_matter(tmp_path):
    code = (
        "import logging; from pddecont.plot.style_sheet import apply_style\n"
        "with apply_style(): import matplotlib.figure\n"
        "print(logging.getLogger('matplotlib').level)"
    )
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("XDG_", "MPL"))}
    for home in (str(tmp_path), os.devnull):
        done = subprocess.run(
            [sys.executable, "-c", code], env=environment | {"HOME": home}, capture_output=True, text=True, timeout=120
        )
        assert (done.stdout.strip(), done.stderr) == ("0", "")
