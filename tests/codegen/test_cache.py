"""Machine code is kept in a folder for each state of its sources."""

from pathlib import Path

import pytest

from pddecont.codegen import choose_cache_folder


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
