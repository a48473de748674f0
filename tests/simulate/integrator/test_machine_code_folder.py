"""The folder of the integrator's machine code is that of its sources."""

from pathlib import Path

from pddecont.codegen import choose_cache_folder
from pddecont.simulate import integrator


def test_every_source_counts(tmp_path):
    sources = sorted(Path(integrator.__file__).parent.glob("*.py"))
    assert integrator.find_machine_code() == choose_cache_folder(sources)
    assert integrator.find_machine_code() != choose_cache_folder(sources[1:])
