"""Random models by the number: ``python -m tests.random_models FIRST NUMBER [FOLDER]``.

Each model is one line; tables of all follow. FOLDER gets ``trials.jsonl``, one model a line, and what is wrong as run
files that show it, with what was said and what is true. Models of different seeds may be tried side by side. One that
takes longer than LIMIT is given up, and counted.
"""

import sys
from dataclasses import asdict

from tests.random_models.driver import try_seeds
from tests.random_models.generator import draw_model
from tests.random_models.program import make_run
from tests.random_models.trial import try_model
from tests.reliability import RANDOM, page

if __name__ == "__main__":
    first, number = int(sys.argv[1]), int(sys.argv[2])
    tried = try_seeds(range(first, first + number), draw_model, make_run, try_model, *sys.argv[3:4])
    print(page([{"section": RANDOM, "trial": asdict(trial)} for trial in tried]))
