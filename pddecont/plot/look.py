"""The look of pictures while they are drawn: this program's own, and a style sheet over it."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from pddecont.errors import ResultsError, suggest
from pddecont.plot.style import RC


@contextmanager
def look(style: str | None = None) -> Iterator[None]:
    """Give matplotlib the settings of all pictures, then those of ``style`` (a file, or the name of a style of matplotlib)."""
    import matplotlib

    with matplotlib.rc_context({**RC, **(sheet(style) if style else {})}):
        yield


def sheet(style: str) -> Any:
    """Return the settings of a style sheet.

    Raises
    ------
    ResultsError
        If there is none of this name, or a line of the file is no setting of matplotlib.
    """
    import matplotlib.style

    if Path(style).is_file():
        return _settings(style)
    library = matplotlib.style.library
    if style in library:
        return library[style]
    raise ResultsError(f"--style {style}: there is no such file and no such style{suggest(style, library)} (styles: "
                       f"{', '.join(name for name in sorted(library) if not name.startswith('_'))})")  # fmt: skip


def _settings(file: str) -> Any:
    import matplotlib

    # Of a key that it does not know matplotlib only tells its log.
    told = _Told()
    logger = logging.getLogger("matplotlib")
    logger.addHandler(told)
    propagate, logger.propagate = logger.propagate, False
    try:
        found = matplotlib.rc_params_from_file(file, fail_on_error=True, use_default_template=False)
    except UnicodeDecodeError as exc:
        raise ResultsError(f"--style {file}: not text in UTF-8") from exc
    except (ValueError, TypeError) as exc:
        raise ResultsError(f"--style {file}: {exc}") from exc
    finally:
        logger.removeHandler(told)
        logger.propagate = propagate
    if told.lines:
        raise ResultsError(f"--style {file}: {told.lines[0]}; expected lines such as 'font.size: 8'")
    return found


class _Told(logging.Handler):
    """Keeps the first line of each message."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.lines: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        """Keep a message."""
        self.lines.append(record.getMessage().strip().splitlines()[0])
