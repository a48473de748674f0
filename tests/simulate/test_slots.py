"""Places of those that compute at once: never more than there are, those whose turn it is first."""

import threading

from pddecont.simulate import Slots, Workers, map_in_order


def test_early_ones_take_what_is_free():
    slots = Slots(2)
    slots.sit()
    assert slots.take_early() and not slots.take_early()
    slots.stand()
    slots.stand()
    assert slots.take_early()


def test_whoever_waits_comes_before_early_ones():
    slots, begun = Slots(1), threading.Event()
    assert slots.take_early()
    thread = threading.Thread(target=lambda: (slots.sit(), begun.set()))
    thread.start()
    while not slots._waiting:
        pass
    assert not slots.take_early() and not begun.is_set()
    slots.give()
    thread.join()
    assert begun.is_set() and not slots.take_early()


def test_who_is_to_be_told_hears_of_free_places():
    slots, heard = Slots(3), []
    slots.on_free = lambda: heard.append(slots.take_early())
    slots.sit()
    with slots.hold(2):
        assert not slots.take_early()
    slots.stand()
    assert heard == [True, True]


def test_threads_share_places_with_others():
    """Three places, one held by another: two threads at once, and nobody is early while there is work."""
    slots, lock, counts, early = Slots(3), threading.Lock(), [0], []
    slots.sit()
    assert slots.take_early()
    slots.on_free = lambda: None
    most = []

    def work(chunk):
        with lock:
            counts[0] += 1
            most.append(counts[0])
        early.append(slots.take_early())
        threading.Event().wait(0.005)
        with lock:
            counts[0] -= 1
        return chunk

    assert list(map_in_order(Workers(3, None, slots), work, range(30))) == list(range(30))
    assert max(most) == 2 and not any(early)
    slots.sit()
    assert slots.take_early() and not slots.take_early()
