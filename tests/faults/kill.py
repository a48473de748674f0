"""A run killed again and again; started as a process of its own: ``python -m tests.faults.kill KIND WAY NUMBER SEED
FOLDER``.

Everything is imported and compiled once; each victim is a fork of that, so that it dies while it works and not while it
starts. WAY ``random`` kills at random instants; ``calls`` makes the victim kill itself before, in the middle of, and
after each call to the system that changes a file, one call after another until a run comes through. Prints one JSON
object.
"""

from __future__ import annotations

import json
import mmap
import os
import random
import shutil
import signal
import struct
import sys
import time
from pathlib import Path

from pddecont.results import file_structure, lock, read_results, writer
from pddecont.steps.execution import execute
from tests.faults.runs import contents, is_beginning, plan_of

CALLS = ("open", "pwrite", "replace", "ftruncate")


class Bench:
    """One run: how long it takes, what it gives, how many points a victim has finished."""

    def __init__(self, kind, folder):
        self.plan, self.folder = plan_of(kind), Path(folder)
        steps = [step.name for step in self.plan.steps]
        self.before = self.folder / "before.h5"
        if len(steps) > 1:
            execute(self.plan, self.before, until=steps[-2])
        for name in ("warm.h5", "whole.h5"):
            self.lay(self.folder / name)
            begun = time.perf_counter()
            execute(self.plan, self.folder / name, resume=True)
            self.seconds = time.perf_counter() - begun
        self.whole, self.contents = read_results(self.folder / "whole.h5"), contents(self.folder / "whole.h5")
        self.bytes = (self.folder / "whole.h5").read_bytes()
        self.finished = mmap.mmap(-1, 8)
        self.path = self.folder / "victim.h5"
        self.failures: list[str] = []

    def lay(self, path):
        """Put the file in place that the last step begins with: the steps before it are done."""
        path.unlink(missing_ok=True)
        if self.before.exists():
            shutil.copy(self.before, path)

    def victim(self, prepare):
        """Start a fork that does the last step; ``prepare`` is called in it first."""
        self.lay(self.path)
        self.finished[:] = struct.pack("q", 0)
        child = os.fork()
        if child:
            return child
        append, count = writer.StepWriter.append, [0]

        def counted(step_writer, *rows):
            append(step_writer, *rows)
            count[0] += 1
            self.finished[:] = struct.pack("q", count[0])

        writer.StepWriter.append = counted
        prepare()
        try:
            execute(self.plan, self.path, resume=True)
        finally:
            os._exit(0)

    def check(self, when):
        """Check what a victim left, then go on with it and compare with the run that nobody killed."""
        n = struct.unpack("q", self.finished[:])[0]
        try:
            if self.path.exists():
                left = read_results(self.path).steps
                kept = sum(map(len, left.values()))
                if kept < n:
                    self.failures.append(f"{when}: {n} points were finished, {kept} are there")
                if not all(is_beginning(step, self.whole.steps[name]) for name, step in left.items()):
                    self.failures.append(f"{when}: what is there is not what the uninterrupted run begins with")
            elif n:
                self.failures.append(f"{when}: {n} points were finished, the file is not there")
            execute(self.plan, self.path, resume=True)
            if self.path.read_bytes() != self.bytes and contents(self.path) != self.contents:
                self.failures.append(f"{when}: after --resume the file differs from an uninterrupted run's")
            litter = {p.name for p in self.folder.iterdir()} - {"whole.h5", "warm.h5", "victim.h5", "before.h5"}
            if litter:
                self.failures.append(f"{when}: left behind: {litter}")
        except Exception as exc:
            self.failures.append(f"{when}: {type(exc).__name__}: {exc}")


def at_random(bench, number, rng):
    """Kill ``number`` victims at instants spread over the last step; return how many had begun to write it, and how
    many tries it took.

    How long the step takes is learnt on the way, as a busy machine is slower: longer if a victim had not yet begun to
    write, shorter if it came through.
    """
    killed = tries = written = 0
    seconds = bench.seconds
    while killed < number and not bench.failures:
        tries += 1
        child = bench.victim(lambda: None)
        delay = rng.uniform(0.0, seconds)
        time.sleep(delay)
        os.kill(child, signal.SIGKILL)
        died = os.WIFSIGNALED(os.waitpid(child, 0)[1])
        had_written = bench.path.exists() and "last" in read_results(bench.path).steps
        seconds *= 0.9 if not died else 1.0 if had_written else 1.1
        killed, written = killed + died, written + had_written
        bench.check(f"after {delay:.4f} s")
    return {"killed": killed, "had_written": written, "tries": tries}


def at_calls(bench):
    """Kill a victim around its first call that changes a file, the next around the second, until one comes through."""
    killed = 0
    for number in range(1, 10_000):
        for moment in ("before", "within", "after"):
            child = bench.victim(lambda number=number, moment=moment: suicidal(number, moment))
            died = os.WIFSIGNALED(os.waitpid(child, 0)[1])
            if moment == "before" and not died:
                return {"killed": killed, "calls": number - 1}
            killed += died
            bench.check(f"{moment} call {number}")
    raise AssertionError("the run does not end")


def suicidal(number, moment):
    """Let this process kill itself around the call of a number; ``within`` a write it has written half of it."""
    count = [0]

    class Os:
        def __getattr__(self, name):
            real = getattr(os, name)
            if name not in CALLS:
                return real

            def call(*args, **options):
                count[0] += 1
                if count[0] != number:
                    return real(*args, **options)
                if moment == "within" and name == "pwrite":
                    real(args[0], args[1][: len(args[1]) // 2], args[2])
                elif moment == "after":
                    real(*args, **options)
                return os.kill(os.getpid(), signal.SIGKILL)

            return call

    for module in (file_structure, writer, lock):
        module.os = Os()


def main(kind, way, number, seed, folder):
    bench = Bench(kind, folder)
    begun = time.perf_counter()
    found = at_calls(bench) if way == "calls" else at_random(bench, int(number), random.Random(int(seed)))
    print(
        json.dumps(
            {
                **found,
                "seconds_of_a_run": bench.seconds,
                "seconds": time.perf_counter() - begun,
                "failures": bench.failures[:20],
                "n_failures": len(bench.failures),
                "points": sum(map(len, bench.whole.steps.values())),
            }
        )
    )


if __name__ == "__main__":
    main(*sys.argv[1:])
