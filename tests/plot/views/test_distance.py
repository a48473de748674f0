"""Chains of growing length beside the delay equation."""

import json
import shutil

import h5py
import pytest

from pddecont.errors import ResultsError
from pddecont.plot import ViewRequest, draw_picture
from pddecont.plot.style import COLOURS
from pddecont.plot.views.distance import draw_enlarged, draw_family, has_distances
from tests.cli.test_cli import call
from tests.plot.drawn import coloured


def test_longer_chains_are_drawn_fuller_and_the_delay_equation_over_them(compared, axes):
    draw_family(axes, compared.step("fine"), "x", "v")
    opacities = [line.get_alpha() for line in axes.lines if line.get_linestyle() == "-"]
    assert len(opacities) == 4 and opacities == sorted(opacities)
    assert coloured(axes, "--") == [COLOURS[1]]
    assert all((line.get_xydata()[0] == line.get_xydata()[-1]).all() for line in axes.lines)


def test_the_enlargement_is_centred_on_an_event(compared, axes):
    draw_enlarged(axes, compared.step("fine"), "x", "v")
    assert sum(axes.get_xlim()) / 2 == pytest.approx(1.0)
    assert sum(axes.get_ylim()) / 2 == pytest.approx(0.0, abs=1e-12)


def test_every_step_has_a_panel_with_what_differs_above(compared, show):
    titles = [axes.get_title() for axes in show(compared, "distance").axes if axes.get_visible()]
    assert titles == ["$K$ = 0.3", "enlarged, with the events", "$K$ = 0.2", "$K$ = 0.3"]
    assert [axes.get_title() for axes in show(compared, "distance", ("fine",)).axes][2] == "fine"


DAMAGES = [
    ("null", "'ends' is not a list of states"),
    ("[]", "'ends' is empty, but distances from what it should hold are there"),
    ("[[1]]", "'ends' is not a list of states"),
    ("", "step 'fine' has no 'ends'; the file is damaged"),
]


@pytest.mark.parametrize(("ends", "message"), DAMAGES)
def test_without_events_there_is_an_error(compared, tmp_path, ends, message):
    path = tmp_path / "damaged.h5"
    shutil.copy(compared.path, path)
    with h5py.File(path, "r+") as file:
        meta = json.loads(file["steps/fine/meta"][()])
        del file["steps/fine/meta"], meta["ends"]
        text = json.dumps(meta | ({"ends": json.loads(ends)} if ends else {})).encode()
        file.create_dataset("steps/fine/meta", data=text, dtype=h5py.string_dtype("utf-8", len(text)))
    code, out, err = call("plot", path, "--view", "distance", "-o", tmp_path / "p.svg")
    assert (code, out) == (1, "")
    assert message in err
    assert not (tmp_path / "p.svg").exists()


def test_only_chains_have_a_distance(every, compared):
    assert has_distances(compared.step("fine"))
    with pytest.raises(ResultsError, match="not as distance"):
        draw_picture(every, ViewRequest("distance", ("in_gain",)))
