"""What is said for a report of a bug."""

import platform
import re
from importlib import metadata

from pddecont import __version__
from tests.cli.test_cli import call


def test_the_version_by_itself_is_one_line():
    assert call("--version") == (0, f"pddecont, version {__version__}\n", "")


def test_verbose_names_the_platform_and_every_library_whichever_stands_first():
    code, out, _ = call("--version", "--verbose")
    assert (code, out) == call("--verbose", "--version")[:2]
    said = dict(line.split(": ", 1) for line in out.splitlines()[1:])
    assert said["python"].startswith(platform.python_version()) and said["platform"] == platform.platform()
    needed = [re.split(r"[^\w.-]", text)[0] for text in metadata.requires("pddecont") if "extra" not in text]
    assert len(needed) > 8
    assert {name: said[name] for name in needed} == {name: metadata.version(name) for name in needed}


def test_a_library_that_is_missing_is_said_to_be(monkeypatch):
    from pddecont.cli.version import find_versions

    monkeypatch.setattr(metadata, "requires", lambda _: ["numpy>=2", "no_such_library_at_all>=1; extra == 'x'"])
    assert find_versions() == {"numpy": metadata.version("numpy"), "no_such_library_at_all": "not installed"}

    def fail(_):
        raise metadata.PackageNotFoundError

    monkeypatch.setattr(metadata, "requires", fail)
    assert "not known" in find_versions()["libraries"]


def test_verbose_alone_is_no_command():
    assert call("--verbose")[0] == 2
