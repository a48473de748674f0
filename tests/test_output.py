"""Nothing that a person owns is replaced unasked, and nothing is left half written."""

import errno
import os

import pytest

import pddecont
from pddecont.errors import ResultsError
from pddecont.output import check_replaceable, replace_whole
from pddecont.results import create_results, read_results
from tests.cli.test_cli import call
from tests.faults.runs import KINDS, MODEL
from tests.plot import synthetic
from tests.runs import change, to_yaml

RUN = change(MODEL, "run.steps", KINDS["simulate"])
PRECIOUS = "a year of work\n"


@pytest.fixture
def model(tmp_path):
    path = tmp_path / "m.yaml"
    path.write_text(to_yaml(RUN))
    return path


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    return synthetic.write_all(tmp_path_factory.mktemp("output") / "r.h5")


@pytest.mark.parametrize("option", ["--overwrite", "--resume"])
def test_a_run_never_replaces_its_own_model(model, option):
    code, _, err = call("run", model, "-o", model, option)
    assert code == 1
    assert f"{model} is the model file of this run and is left as it is" in err
    assert model.read_text() == to_yaml(RUN)


def test_a_run_never_replaces_its_run_file_by_another_name_of_it(model, tmp_path):
    run = tmp_path / "r.yaml"
    run.write_text(to_yaml({"model": "m.yaml", **RUN["run"]}))
    os.link(run, tmp_path / "other.h5")
    code, _, err = call("run", run, "-o", tmp_path / "other.h5", "--overwrite")
    assert code == 1
    assert "is the run file of this run" in err
    assert (tmp_path / "other.h5").read_text() == run.read_text()


def test_python_replaces_no_model_either(model):
    for steps in (None, KINDS["simulate"]):
        with pytest.raises(ResultsError, match="is left as it is"):
            pddecont.run(model, steps=steps, output=model, overwrite=True)
    assert model.read_text() == to_yaml(RUN)


@pytest.mark.parametrize("contents", [PRECIOUS.encode(), b"\x89HDF\r\n\x1a\n" + bytes(600)])
def test_a_run_replaces_nothing_but_results(model, tmp_path, contents):
    notes = tmp_path / "notes.txt"
    notes.write_bytes(contents)
    code, _, err = call("run", model, "-o", notes, "--overwrite")
    assert code == 1
    assert f"{notes} exists and is not a results file; it is left as it is" in err
    assert notes.read_bytes() == contents


def test_hdf5_of_another_program_is_left_as_it_is(model, tmp_path):
    import h5py

    path = tmp_path / "data.h5"
    with h5py.File(path, "w") as file:
        file["steps"] = 1.0
        file.attrs["format_version"] = 2
    before = path.read_bytes()
    with pytest.raises(ResultsError, match="is not a results file"):
        create_results(path, "m", "r", "s", "{}", overwrite=True)
    assert path.read_bytes() == before


def test_an_empty_file_and_results_are_replaced(model, tmp_path):
    path = tmp_path / "new.h5"
    path.touch()
    for _ in range(2):
        assert call("run", model, "-o", path, "--overwrite", "-q")[0] == 0
        assert list(read_results(path).steps) == ["last"]


@pytest.mark.parametrize("option", [[], ["--overwrite"], ["--resume"]])
def test_a_run_writes_through_no_link(model, tmp_path, option):
    notes, link, dangling = tmp_path / "notes.txt", tmp_path / "link.h5", tmp_path / "dangling.h5"
    notes.write_text(PRECIOUS)
    link.symlink_to(notes)
    dangling.symlink_to(tmp_path / "nothing")
    for path in (link, dangling):
        code, _, err = call("run", model, "-o", path, *option)
        assert code == 1
        assert "links are not written through; give that file with -o" in err
        assert path.is_symlink()
    assert notes.read_text() == PRECIOUS
    assert not (tmp_path / "nothing").exists()


@pytest.mark.parametrize(("command", "name"), [("plot", "p.png"), ("plot", "p.svg"), ("report", "p.html")])
def test_pictures_and_pages_replace_only_their_like(results, tmp_path, command, name):
    path = tmp_path / name
    path.write_text(PRECIOUS)
    code, _, err = call(command, results, "-o", path)
    assert code == 1
    assert "it is left as it is" in err
    assert path.read_text() == PRECIOUS
    link = tmp_path / f"link{path.suffix}"
    link.symlink_to(path)
    code, _, err = call(command, results, "-o", link)
    assert code == 1
    assert "links are not written through" in err
    assert path.read_text() == PRECIOUS
    path.unlink()
    link.unlink()
    for _ in range(2):
        assert call(command, results, "-o", path)[0] == 0
    assert [p.name for p in tmp_path.iterdir()] == [name]


def test_a_page_of_another_program_is_left_as_it_is(results, tmp_path):
    path = tmp_path / "index.html"
    path.write_text("<!DOCTYPE html>\n<html><head><title>My home</title></head></html>\n")
    before = path.read_text()
    code, _, err = call("report", results, "-o", path)
    assert code == 1
    assert "is not a report of pddecont" in err
    assert path.read_text() == before


def test_a_full_disk_leaves_the_old_file_whole(tmp_path):
    path = tmp_path / "page.html"
    path.write_text("the good page")
    with (
        pytest.raises(ResultsError, match=r"page\.html cannot be written: No space left on device"),
        replace_whole(path) as part,
    ):
        part.write_text("half a pa")
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    assert path.read_text() == "the good page"
    assert [p.name for p in tmp_path.iterdir()] == ["page.html"]


@pytest.mark.parametrize("command", ["plot", "report"])
def test_pages_and_pictures_on_a_full_disk_leave_the_old_ones(results, tmp_path, monkeypatch, command):
    path = tmp_path / {"plot": "p.png", "report": "p.html"}[command]
    assert call(command, results, "-o", path)[0] == 0
    before = path.read_bytes()

    def full(source, target):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "replace", full)
    code, _, err = call(command, results, "-o", path)
    assert code == 1
    assert "cannot be written: No space left on device" in err
    assert path.read_bytes() == before
    assert len(list(tmp_path.iterdir())) == 1


def test_a_folder_is_named(tmp_path):
    with pytest.raises(ResultsError, match="is not a file that can hold a picture"):
        check_replaceable(tmp_path, lambda head: True, "a picture")
