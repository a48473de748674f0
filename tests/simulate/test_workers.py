"""Work in chunks comes back in their order, whoever does it."""

import functools
import threading
import time

import pytest

from pddecont.simulate import Workers, map_in_order
from pddecont.simulate.workers import AHEAD


def wait_and_square(scale, k):
    time.sleep(0.002 * (k % 3))
    return scale * k * k


@pytest.mark.parametrize("number", [1, 3])
def test_results_come_in_the_order_of_the_chunks(number):
    work = functools.partial(wait_and_square, 10)
    assert list(map_in_order(Workers(number), work, range(20))) == [10 * k * k for k in range(20)]


def test_threads_work_at_the_same_time():
    meeting = threading.Barrier(3, timeout=20)
    assert list(map_in_order(Workers(3), lambda k: (meeting.wait(), k)[1], range(3))) == [0, 1, 2]


@pytest.mark.parametrize("number", [1, 2])
def test_chunks_are_handed_out_as_results_are_taken(number):
    started = []
    results = map_in_order(Workers(number), lambda k: started.append(k) or k, range(100))
    assert next(results) == 0
    assert len(started) <= AHEAD * number
    results.close()


@pytest.mark.parametrize("number", [1, 2])
def test_an_error_comes_out_where_its_chunk_is(number):
    def work(k):
        if k == 3:
            raise ValueError("chunk 3")
        return k

    results = map_in_order(Workers(number), work, range(9))
    assert [next(results) for _ in range(3)] == [0, 1, 2]
    with pytest.raises(ValueError, match="chunk 3"):
        next(results)


def test_no_chunks_no_results():
    assert list(map_in_order(Workers(2), wait_and_square, [])) == []
