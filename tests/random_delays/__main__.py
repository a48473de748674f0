"""Random models with delays of every kind by the number: ``python -m tests.random_delays FIRST NUMBER [FOLDER]``.

Each model is one line. FOLDER gets ``trials.jsonl``, one model a line, and the run files of models at fault.
"""

import sys
from collections import Counter

from tests.random_delays.generator import draw_model
from tests.random_delays.trial import make_short_run, try_model
from tests.random_models.driver import try_seeds

if __name__ == "__main__":
    first, number = int(sys.argv[1]), int(sys.argv[2])
    tried = try_seeds(range(first, first + number), draw_model, make_short_run, try_model, *sys.argv[3:4])
    print(Counter(t.outcome for t in tried), sum(t.n_points for t in tried), "points")
    print("worst", max(t.worst_orbit for t in tried), "at fault", [t.seed for t in tried if t.at_fault])
