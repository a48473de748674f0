"""The index of messages: what each text that says that something is wrong means, and what to do then.

It lies beside this file in ``messages``, one file a subject. The texts are those of the program with ``{}`` where they
vary, or the part of them that they can be told by; ``docs/messages.py`` finds all texts in the code.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path

HOLE = "{}"
FOLDER = Path(__file__).parent / "messages"
# A text of fewer letters says too little to be looked for inside another: it has to be the whole message.
FEWEST_LETTERS = 10
# Entries that one message is explained by, at most: its parts may have their own. One that is told by a far shorter
# text than the best is left out.
MOST_ENTRIES, FAR_SHORTER = 3, 0.5


@dataclass(frozen=True)
class Entry:
    """What one cause says, in one or several texts ``says``, why, and what helps."""

    subject: str
    says: tuple[str, ...]
    cause: str
    cure: str

    def match(self, message: str) -> int:
        """Return how many letters of its longest text that tells a message; 0 if none does."""
        return max((len(says.replace(HOLE, "")) for says in self.says if tells(says, message)), default=0)


def tells(says: str, message: str) -> bool:
    """Return whether a message is told by a text of the index: it holds it, with anything in its holes."""
    pattern = _compile(says)
    is_short = len(says.replace(HOLE, "").strip()) < FEWEST_LETTERS
    return bool(pattern.fullmatch(message) if is_short else pattern.search(message))


@cache
def _compile(says: str) -> re.Pattern[str]:
    return re.compile(".*?".join(re.escape(part) for part in says.split(HOLE)), re.S)


@cache
def read_entries() -> tuple[Entry, ...]:
    """Return all entries, subject by subject."""
    import yaml

    found = []
    for path in sorted(FOLDER.glob("*.yaml")):
        data = yaml.safe_load(path.read_text(encoding="utf-8"))
        found += [Entry(data["subject"], tuple(e["says"]), e["cause"], e["cure"]) for e in data["entries"]]
    return tuple(found)


def explain_message(message: str) -> list[Entry]:
    """Return the entries that explain a message as it was printed, the one that tells most of it first.

    Of a part of a message that no text tells these are the entries whose texts hold it.
    """
    text = " ".join(message.split())
    part = [entry for entry in read_entries() if len(text) >= FEWEST_LETTERS and any(text in s for s in entry.says)]
    found = sorted(((entry.match(text), k) for k, entry in enumerate(read_entries())), key=lambda m: (-m[0], m[1]))
    best = found[0][0] if found else 0
    told = [read_entries()[k] for letters, k in found if letters and letters >= FAR_SHORTER * best]
    return (told or part)[:MOST_ENTRIES]
