"""``pddecont explore`` as a user types it."""

import json

import pytest

from pddecont.results import read_results
from tests.cli.test_cli import call


@pytest.fixture(scope="module")
def explored(tmp_path_factory):
    path = tmp_path_factory.mktemp("explored") / "a.h5"
    code, out, err = call(
        *("explore", "bouncing_ball", "--over", "G=0.3:1.2", "--starts", 8, "--check", 8, "-o", path, "--workers", 2)
    )
    assert code == 0, err
    return path, out, err


def test_it_says_a_sentence_a_branch_and_how_it_goes(explored):
    _, out, err = explored
    assert "branch_1, from sweep A1: G 0.349066 to 1.2, 22 of 49 points stable; LP1 PD1; down: reached" in out
    assert "orbit_1: converged" in err
    assert "motions that settle lie on them" in err


def test_what_it_leaves_is_shown_by_the_other_commands(explored, tmp_path):
    path, _, _ = explored
    code, out, err = call("export", path, "--table", "branches")
    assert code == 0, err
    assert out.startswith("branch,from,depth,curve,low,high,points,stable,special,images,outcome\nbranch_1,sweep A1,0,")
    assert call("export", path, "--step", "branch_1", "--table", "special")[0] == 0
    assert "explore" in call("info", path)[1]
    assert call("plot", path, "-o", tmp_path / "a.png")[0] == 0
    assert call("report", path, "-o", tmp_path / "a.html")[0] == 0
    assert "Branches" in (tmp_path / "a.html").read_text()
    assert call("plot", path, "--step", "branch_1", "-o", tmp_path / "b.png")[0] == 0


def test_one_worker_writes_the_same_file(explored, tmp_path):
    path = tmp_path / "a.h5"
    code, out, _ = call(
        *("explore", "bouncing_ball", "--over", "G=0.3:1.2", "--starts", 8, "--check", 8, "-o", path, "--json")
    )
    assert code == 0
    assert path.read_bytes() == explored[0].read_bytes()
    assert [step["name"] for step in json.loads(out)["steps"]] == list(read_results(path).names)


@pytest.mark.parametrize(
    ("args", "code", "message"),
    [
        (["bouncing_ball"], 2, "Missing option '--over'"),
        (["bouncing_ball", "--over", "G=1"], 2, "expected NAME=LOW:HIGH"),
        (["bouncing_ball", "--over", "H=0:1"], 1, "'H' is not a parameter"),
        (["bouncing_ball", "--over", "G=1:0"], 1, "the range is empty"),
        (["nothing", "--over", "G=0:1"], 1, "does not exist"),
        (["bouncing_ball", "--over", "G=0:1", "--resume", "--overwrite"], 2, "exclude each other"),
        (["bouncing_ball", "--over", "G=0:1", "--without", "hand"], 1, "hand"),
    ],
)
def test_what_is_wrong_is_told(args, code, message, in_folder):
    found, _, err = call("explore", *args)
    assert found == code
    assert message in err


def test_a_shipped_model_is_named_so_that_the_file_tells_no_folder(explored):
    results = read_results(explored[0])
    assert results.run_text.startswith("model: bouncing_ball\n")
