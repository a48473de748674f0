"""What benchmarks time has to run: the steps that they do by themselves, not by a whole run."""

from benchmarks.continuation import split
from benchmarks.effects import HAND, context_of, followed
from pddecont.results import read_results


def test_a_run_without_effects_step_by_step(tmp_path):
    path = tmp_path / "hand.h5"
    context = context_of(HAND, (), path)
    followed(context)
    steps = read_results(path).steps
    assert list(steps) == [step.name for step in context.plan.steps[1:]]
    assert all(step.done for step in steps.values())


def test_where_the_time_of_a_newton_step_goes(capsys):
    """Every part is measured, and the measured ones together take less than the whole: none is counted twice."""
    split(meshes=(10,))
    row = capsys.readouterr().out.splitlines()[2]
    unknowns, *parts, ms = (float(entry) for entry in row.split())
    assert unknowns > 100 and ms > 0
    assert len(parts) == 4 and all(part > 0 for part in parts)
