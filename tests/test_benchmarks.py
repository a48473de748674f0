"""What benchmarks time has to run: the steps that they do by themselves, not by a whole run."""

from benchmarks.effects import HAND, context_of, followed
from pddecont.results import read_results


def test_a_run_without_effects_step_by_step(tmp_path):
    path = tmp_path / "hand.h5"
    context = context_of(HAND, (), path)
    followed(context)
    steps = read_results(path).steps
    assert list(steps) == [step.name for step in context.plan.steps[1:]]
    assert all(step.done for step in steps.values())
