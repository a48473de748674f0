"""Machine code is kept in a folder for each state of its sources."""

from pathlib import Path

import pytest

from pddecont.codegen import cache as cache_module
from pddecont.codegen import choose_cache_folder, describe_cache_failure, find_cache_folder


@pytest.fixture
def sources(tmp_path):
    files = [tmp_path / name for name in ("a.py", "b.py")]
    for path in files:
        path.write_text(path.name)
    return files


def test_a_change_in_any_source_makes_another_folder(sources):
    before = choose_cache_folder(sources)
    assert choose_cache_folder(reversed(sources)) == before
    sources[1].write_text("changed")
    assert choose_cache_folder(sources) != before
    sources[1].write_text("b.py")
    assert choose_cache_folder(sources) == before


def test_environment_variables_move_it(sources, monkeypatch):
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", "/x")
    assert choose_cache_folder(sources).parent == Path("/x/pddecont")
    monkeypatch.setenv("NUMBA_CACHE_DIR", "/n")
    assert choose_cache_folder(sources).parent == Path("/n")
    monkeypatch.delenv("NUMBA_CACHE_DIR")
    monkeypatch.delenv("XDG_CACHE_HOME")
    assert choose_cache_folder(sources).parent == Path.home() / ".cache" / "pddecont"


@pytest.fixture
def blocked(tmp_path, monkeypatch):
    """A cache folder that cannot be made: a file is in its way."""
    (tmp_path / "file").write_text("")
    (tmp_path / "tmp").mkdir()
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "file" / "cache"))
    monkeypatch.setattr(cache_module.tempfile, "gettempdir", lambda: str(tmp_path / "tmp"))
    cache_module.can_be_written.cache_clear()
    return tmp_path


def test_a_folder_that_cannot_be_written_is_replaced_by_one_that_can_and_it_is_said(sources, blocked):
    folder = find_cache_folder(sources)
    assert folder is not None
    assert folder.parent.parent == blocked / "tmp"
    assert folder.parent.stat().st_mode & 0o777 == 0o700
    assert "is kept in" in describe_cache_failure()
    assert "set NUMBA_CACHE_DIR" in describe_cache_failure()


def test_without_any_folder_nothing_is_kept_and_it_is_said(sources, blocked, monkeypatch):
    monkeypatch.setattr(cache_module.tempfile, "gettempdir", lambda: str(blocked / "file"))
    assert find_cache_folder(sources) is None
    assert "every run compiles it anew" in describe_cache_failure()


def test_a_temporary_folder_that_others_may_write_to_is_not_used(sources, blocked):
    folder = find_cache_folder(sources)
    assert folder is not None
    folder.parent.chmod(0o777)
    cache_module.can_be_written.cache_clear()
    assert find_cache_folder(sources) is None


def test_no_home_folder_is_no_error(sources, monkeypatch):
    for name in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)

    def fail():
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setattr(Path, "home", fail)
    assert find_cache_folder(sources) is not None
    assert describe_cache_failure() == ""
