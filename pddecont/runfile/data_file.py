"""Files of data that a run file names."""

from __future__ import annotations

from pathlib import Path

from pddecont.errors import RunError
from pddecont.model import decode

# Enough for a thousand states at a thousand times.
MAX_DATA_BYTES = 20_000_000


def read_data_file(path: Path) -> str:
    """Return the text of a file of data.

    Raises
    ------
    RunError
        If it is not there, no plain file, too large or no text.
    """
    if path.exists() and not path.is_file():
        raise RunError.at(str(path), 0, 0, "is not a plain file; check the path")
    try:
        with path.open("rb") as stream:
            raw = stream.read(MAX_DATA_BYTES + 1)
    except (OSError, ValueError) as exc:
        what = exc.strerror if isinstance(exc, OSError) and exc.strerror else str(exc)
        raise RunError.at(str(path), 0, 0, f"cannot be read: {what}; check the path") from exc
    if len(raw) > MAX_DATA_BYTES:
        raise RunError.at(str(path), 0, 0, f"is larger than {MAX_DATA_BYTES} bytes; leave rows or digits out")
    return decode(raw, path, RunError)
