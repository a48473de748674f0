"""The part of a page that can be used: data, script and library in the page itself, and what the page may run.

The page's policy allows two scripts, each by the hash of its text: this program's own, and plotly. Nothing that a
results file holds is among them; it reaches the script as numbers and text within a block of letters.
"""

from __future__ import annotations

import base64
import hashlib
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

from markupsafe import Markup

from pddecont.report.page_data import make_page_data
from pddecont.results import Results

SCRIPTS = ("data", "text", "curves", "layers", "diagram", "point", "state", "live", "")
POLICY = (
    "default-src 'none'; {scripts}img-src data: blob:; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'"
)


@dataclass(frozen=True)
class ExplorerParts:
    """What a page holds of the explorer: its script as it stands there, its data and the library as letters."""

    script: Markup
    data: str
    library: str


def make_explorer(results: Sequence[Results]) -> ExplorerParts | None:
    """Return the explorer of some results files; None where there is nothing that it shows."""
    data = make_page_data(results)
    return ExplorerParts(Markup(read_script()), data, pack_library()) if data else None


def write_policy(with_scripts: bool) -> str:
    """Return what a page may load and run: images within it, and the two scripts where it has them."""
    hashes = " ".join(hash_script(text) for text in (read_script(), read_library()))
    return POLICY.format(scripts=f"script-src {hashes}; " if with_scripts else "")


def hash_script(text: str) -> str:
    """Return how a policy names a script by its text."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


@cache
def read_script() -> str:
    """Return the explorer's own script, whose parts lie in files of their own."""
    folder = files("pddecont.report")
    parts = [(folder / f"explorer{'_' * bool(name)}{name}.js").read_text(encoding="utf-8") for name in SCRIPTS]
    return '"use strict";\n(() => {\n' + "".join(parts) + "})();\n"


@cache
def read_library() -> str:
    """Return the text of plotly.js, as the package plotly brings it."""
    from plotly.offline import get_plotlyjs

    return str(get_plotlyjs())


@cache
def pack_library() -> str:
    """Return plotly.js, deflated, in letters."""
    return base64.b64encode(zlib.compress(read_library().encode(), 9)).decode()
