"""Files that a person names for output: what is there is replaced only if it is of the same kind, and then at once.

A whole file is written beside the place and renamed onto it, so that a full disk or a killed process leaves the old one
as it was. Links are not written through, as what they lead to was not named.
"""

from __future__ import annotations

import contextlib
import os
import secrets
from collections.abc import Callable, Iterator
from pathlib import Path

from pddecont.errors import ResultsError

# Bytes at a file's beginning that tell what it is.
HEAD_BYTES = 4096


def check_replaceable(path: Path, is_one: Callable[[bytes], bool], what: str) -> None:
    """Check that output may go to ``path``.

    Parameters
    ----------
    path
        Where the output is to go.
    is_one
        Whether a file that begins with some bytes is such an output.
    what
        That in words, such as "a picture".

    Raises
    ------
    ResultsError
        If ``path`` is a link, or no plain file, or a file that holds something else. An empty file may be replaced.
    """
    refuse_link(path)
    if not path.exists():
        return
    if not path.is_file():
        raise ResultsError(f"{path} is not a file that can hold {what}; give another -o")
    try:
        with path.open("rb") as stream:
            head = stream.read(HEAD_BYTES)
    except OSError as exc:
        raise ResultsError(f"{path} cannot be read: {exc.strerror}; check the file, or give another -o") from exc
    if head and not is_one(head):
        raise explain_other(path, what)


def refuse_link(path: Path) -> None:
    """Raise ResultsError if ``path`` is a link."""
    if path.is_symlink():
        raise ResultsError(
            f"{path} is a link to {os.readlink(path)}, and links are not written through; give that file with -o, or "
            "another one"
        )


def explain_other(path: Path, what: str) -> ResultsError:
    """Return the error for a file at ``path`` that is not ``what`` may be replaced there."""
    return ResultsError(f"{path} exists and is not {what}; it is left as it is. Give another -o, or move the file away")


@contextlib.contextmanager
def replace_whole(path: Path) -> Iterator[Path]:
    """Give the name of a file to write beside ``path``, with its suffix; it takes the place at once when all is well.

    Raises
    ------
    ResultsError
        If one of them cannot be written; ``path`` is as it was then.
    """
    part = path.with_name(f".pddecont-{secrets.token_hex(6)}.part{path.suffix}")
    try:
        os.close(os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666))
        try:
            yield part
            os.replace(part, path)
        finally:
            with contextlib.suppress(OSError):
                part.unlink(missing_ok=True)
    except OSError as exc:
        raise ResultsError(f"{path} cannot be written: {exc.strerror or exc}") from exc
