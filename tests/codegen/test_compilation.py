"""numba compiles as this program wants it, and is left as it was for everybody else."""

import numba
from numba import config, njit

from pddecont.codegen.announcement import tell_compilation
from pddecont.codegen.compilation import compile_when_called, compiler_settings


def settings():
    return str(config.CACHE_DIR), int(config.OPT), numba.core.config.OPT._raw_value


def test_settings_hold_inside_only(tmp_path):
    before = settings()
    with compiler_settings(tmp_path):
        assert str(tmp_path) == config.CACHE_DIR
    assert settings() == before


def test_the_integrator_leaves_what_numba_is_set_to():
    before = settings()
    import pddecont.simulate.integrator.advance

    assert pddecont.simulate.integrator.advance.run is not None
    assert settings() == before
    assert njit(lambda x: x + 1)(1) == 2


def test_what_is_compiled_anew_is_told_once_and_what_is_read_from_disk_is_not(tmp_path):
    told = []
    with tell_compilation(lambda: told.append("compiled")):
        function = compile_when_called(double, tmp_path)
        assert function(3) == 6
        assert function(0.5) == 1.0
    assert told == ["compiled"]
    assert list(tmp_path.rglob("*.nbi"))
    with tell_compilation(lambda: told.append("again")):
        assert compile_when_called(double, tmp_path)(3) == 6
    assert told == ["compiled"]


def test_without_a_folder_it_is_compiled_and_not_kept():
    assert compile_when_called(double, None)(4) == 8


def double(x):
    return 2 * x
