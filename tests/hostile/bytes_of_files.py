"""Results files with bytes changed, read by forks of one process: ``python -m tests.hostile.bytes_of_files FILE NUMBER
SEED``.

The HDF5 library is given files that it was never meant to see; what it does with them must not reach the process that
reports. Prints one JSON object: how many files were read, refused, and how many ended the process, with the seeds of
those.
"""

from __future__ import annotations

import json
import os
import random
import resource
import signal
import sys
import tempfile
import traceback
from pathlib import Path

from pddecont.errors import PddecontError
from pddecont.results import read_results
from pddecont.tables import has_multipliers, list_tables, make_table, summarise

BATCH = 50


def changed(data, seed):
    """Return ``data`` with some bytes changed, cut or moved; most changes are where the file's structure stands."""
    rng = random.Random(seed)
    data = bytearray(data)
    structure = [i for i, byte in enumerate(data) if byte] or [0]
    for _ in range(rng.choice((1, 1, 2, 4, 16))):
        at = rng.choice((rng.randrange(len(data)), rng.choice(structure), rng.randrange(min(len(data), 4096))))
        at, way = min(at, len(data) - 1), rng.randrange(6)
        if way < 3:
            data[at] = rng.choice((0, 1, 0x7F, 0x80, 0xFF, rng.randrange(256), data[at] ^ (1 << rng.randrange(8))))
        elif way == 3:
            data[at : at + 8] = rng.choice(
                (0, 1, 2**31, 2**32 - 1, 2**62, 2**63, 2**64 - 1, rng.randrange(2**20))
            ).to_bytes(8, "little")
        elif way == 4:
            other, n = rng.randrange(len(data)), rng.randrange(1, 64)
            data[at : at + n] = data[other : other + n]
        else:
            del data[at : at + rng.randrange(1, 64)]
    return bytes(data)


def look(path):
    """Read a file as ``info`` and ``export`` do; return whether it could be read."""
    try:
        results = read_results(path)
        summarise(results)
        for step in results.steps.values():
            for name in list_tables(step.kind):
                if len(step) and (name != "multipliers" or has_multipliers(step)):
                    make_table(step, name)
    except PddecontError as exc:
        assert len(str(exc)) < 2000
        return False
    return True


def main(file, number, seed):
    data = Path(file).read_bytes()
    found = {"read": 0, "refused": 0, "ended": []}
    seeds = range(int(seed), int(seed) + int(number))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.h5"
        for first in range(seeds[0], seeds[-1] + 1, BATCH):
            batch, outcome = [s for s in seeds if first <= s < first + BATCH], Path(folder) / "outcome"
            while batch:
                outcome.write_text("")
                child = os.fork()
                if not child:
                    resource.setrlimit(resource.RLIMIT_AS, (3 << 30, 3 << 30))
                    try:
                        with outcome.open("a", buffering=1) as stream:
                            for s in batch:
                                signal.alarm(20)
                                path.write_bytes(changed(data, s))
                                stream.write(f"{'read' if look(path) else 'refused'}\n")
                    except BaseException:
                        traceback.print_exc()
                    finally:
                        os._exit(0)
                status = os.waitpid(child, 0)[1]
                lines = outcome.read_text().split()
                for line in lines:
                    found[line] += 1
                if len(lines) < len(batch):
                    found["ended"].append((batch[len(lines)], status))
                batch = batch[len(lines) + 1 :]
    print(json.dumps(found))


if __name__ == "__main__":
    main(*sys.argv[1:])
