"""The settings that matplotlib has while pictures are drawn: this program's own, and a style sheet over them."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any

from pddecont.errors import ResultsError, suggest
from pddecont.plot.sizes import JOURNAL_WIDTH, PictureSize
from pddecont.plot.style import JOURNAL_SETTINGS, SETTINGS


@contextmanager
def apply_style(style: str | None = None, size: PictureSize | None = None) -> Iterator[None]:
    """Give matplotlib this program's settings, then those of ``style``: a file, or a style that matplotlib has.

    A picture of a ``size`` has it as ``figure.figsize``, which figures take for theirs; a style may say so too.
    """
    matplotlib = _import_quietly()
    journal = JOURNAL_SETTINGS if size is not None and size.width < JOURNAL_WIDTH else {}
    asked: dict[Any, Any] = {"figure.figsize": (size.width, size.height)} if size is not None else {}
    with matplotlib.rc_context({**SETTINGS, **journal, **(read_style_sheet(style) if style else {}), **asked}):
        yield


def _import_quietly() -> ModuleType:
    """Return matplotlib, which does not say where it keeps its cache if the home folder cannot be written."""
    logger = logging.getLogger("matplotlib")
    level = logger.level
    logger.setLevel(logging.ERROR)
    try:
        import matplotlib
    finally:
        logger.setLevel(level)
    return matplotlib


def list_styles() -> list[str]:
    """Return the names of the styles that matplotlib has."""
    from matplotlib.style import library

    return sorted(name for name in library if not name.startswith("_"))


def read_style_sheet(style: str) -> Mapping[Any, Any]:
    """Return the settings of a style sheet.

    Raises
    ------
    ResultsError
        If there is none of this name, or a line of the file is no setting of matplotlib.
    """
    import matplotlib.style

    if Path(style).is_file():
        return _read_file(style)
    library = matplotlib.style.library
    if style in library:
        return library[style]
    raise ResultsError(
        f"--style {style}: there is no such file and no such style{suggest(style, library)} (styles: "
        f"{', '.join(list_styles())})"
    )


def _read_file(file: str) -> Mapping[Any, Any]:
    import matplotlib

    # Of a key that it does not know matplotlib only writes to its log.
    log = _FirstLines()
    logger = logging.getLogger("matplotlib")
    logger.addHandler(log)
    propagate, logger.propagate = logger.propagate, False
    try:
        found = matplotlib.rc_params_from_file(file, fail_on_error=True, use_default_template=False)
    except UnicodeDecodeError as exc:
        raise ResultsError(f"--style {file}: not text in UTF-8") from exc
    except (ValueError, TypeError) as exc:
        raise ResultsError(f"--style {file}: {exc}") from exc
    finally:
        logger.removeHandler(log)
        logger.propagate = propagate
    if log.lines:
        raise ResultsError(f"--style {file}: {log.lines[0]}; expected lines such as 'font.size: 8'")
    return found


class _FirstLines(logging.Handler):
    """Keeps the first line of each message."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.lines: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        """Keep a message."""
        self.lines.append(record.getMessage().strip().splitlines()[0])
