"""Who waits for the compiler hears of it once."""

from pddecont.codegen.announcement import announce_compilation, tell_compilation


def test_the_latest_listener_hears_of_it_once():
    told = []
    with tell_compilation(lambda: told.append("run")):
        announce_compilation()
        announce_compilation()
        with tell_compilation(lambda: told.append("part")):
            announce_compilation()
    announce_compilation()
    assert told == ["run", "part"]
