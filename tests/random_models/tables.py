"""What random models showed, as tables of docs/reliability.md."""

from __future__ import annotations

from collections import Counter, defaultdict

from tests.random_models.program import TOO_LONG

COLUMNS = (
    "family",
    "models",
    "with an orbit",
    "given up",
    "periods",
    "worst deviation",
    "multipliers",
    "worst multiplier",
    "at a limit",
    "too sensitive",
    "said to be none",
    "refused, a motion",
    "wrong, unsaid",
)


def summarise_trials(trials):
    """Return (head, lines) of the table of families, and of the table of attractors."""
    families = defaultdict(list)
    for trial in trials:
        families[trial["family"]].append(trial)
    lines = [_family(name, members) for name, members in sorted(families.items())]
    attractors = Counter()
    for trial in trials:
        attractors.update(trial["attractors"])
    found = [[where, f"{number:,}"] for where, number in attractors.most_common()]
    return (list(COLUMNS), [*lines, _family("all", trials)]), (["where a swept attractor is", "number"], found)


def _family(name, trials):
    def total(key):
        return f"{sum(t[key] for t in trials):,}"

    return [
        name,
        f"{len(trials):,}",
        f"{sum(t['outcome'] == 'compared' for t in trials):,}",
        f"{sum(t['outcome'] == TOO_LONG for t in trials):,}",
        total("n_points"),
        f"{max((t['worst_orbit'] for t in trials), default=0.0):.2g}",
        total("n_multipliers"),
        f"{max((t['worst_multiplier'] for t in trials), default=0.0):.1e}",
        total("at_limit"),
        total("too_sensitive"),
        total("warned"),
        f"{sum(len(t['refused']) for t in trials):,}",
        f"{sum(len(t['faults']) for t in trials):,}",
    ]
