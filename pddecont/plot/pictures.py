"""Views of results files as figures, as images and as picture files."""

from __future__ import annotations

import io
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pddecont.errors import ResultsError
from pddecont.output import check_replaceable, replace_whole
from pddecont.plot.engineering import use_engineering_form
from pddecont.plot.registry import VIEWS
from pddecont.plot.several_files import select_steps
from pddecont.plot.sizes import PictureSize
from pddecont.plot.style import MOVING_DPI
from pddecont.plot.style_sheet import apply_style
from pddecont.plot.ticks import thin_ticks
from pddecont.plot.view import ViewRequest
from pddecont.results import Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure

STILL_SUFFIXES = (".png", ".svg", ".pdf")
MOVING_SUFFIXES = (".gif", ".mp4")
FRAMES_PER_SECOND = 12
# An SVG of more bytes is slow to show: a PNG is the better image then.
MAX_SVG_BYTES = 1_000_000
# What would say when a picture was drawn, left out: by format.
_UNDATED: dict[str, dict[str, Any]] = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}
# Letters of a message of matplotlib's that are passed on.
MAX_REASON = 200


def draw_picture(results: Results | Sequence[Results], request: ViewRequest) -> Figure:
    """Return a view of a results file, or of several in one picture, as a matplotlib figure.

    Raises
    ------
    ResultsError
        If there is nothing to draw so, or the view moves.
    """
    from matplotlib.figure import Figure

    view, steps = select_steps(_list_files(results), request)
    if view.is_moving:
        raise ResultsError(f"the view '{view.name}' moves; it goes into a file ({', '.join(MOVING_SUFFIXES)})")
    figure = view.drawing.draw(steps, request)
    assert isinstance(figure, Figure)
    use_engineering_form(figure)
    thin_ticks(figure)
    return figure


def render_image(results: Results, request: ViewRequest) -> tuple[str, bytes]:
    """Return a view of a results file as (media type, contents): SVG, or PNG where that would be large.

    Raises
    ------
    ResultsError
        If there is nothing to draw so.
    """
    with apply_style(), _explain_errors(results), io.BytesIO() as stream:
        figure = draw_picture(results, request)
        figure.savefig(stream, format="svg", metadata=_UNDATED["svg"])
        if stream.tell() <= MAX_SVG_BYTES:
            return "image/svg+xml", stream.getvalue()
        stream.seek(0)
        stream.truncate()
        figure.savefig(stream, format="png")
        return "image/png", stream.getvalue()


def save_picture(
    results: Results | Sequence[Results],
    request: ViewRequest,
    path: Path,
    style: str | None = None,
    size: PictureSize | None = None,
) -> None:
    """Write a view of a results file, or of several in one picture, to ``path``, whose suffix says in which format.

    ``style`` is a style sheet over this program's own settings. The same contents give the same bytes.

    Raises
    ------
    ResultsError
        If the suffix is not that of such a picture, ``path`` is a link or holds something else than a picture, the
        file cannot be written, there is nothing to draw so, or no room for it in a picture of that ``size``.
    """
    is_moving = request.view in VIEWS and VIEWS[request.view].is_moving
    _check_suffix(path, is_moving)
    check_replaceable(path, is_picture, "a picture")
    with replace_whole(path) as part, apply_style(style, size), _explain_errors(results), _refuse_crowding(size):
        if is_moving:
            _save_animation(results, request, part)
        else:
            metadata = _UNDATED.get(path.suffix.lower().removeprefix("."))
            draw_picture(results, request).savefig(part, metadata=metadata)


def _list_files(results: Results | Sequence[Results]) -> Sequence[Results]:
    return [results] if isinstance(results, Results) else results


def is_picture(head: bytes) -> bool:
    """Whether a file that begins so is a picture of a kind that is written here."""
    if head.startswith((b"\x89PNG\r\n\x1a\n", b"%PDF-", b"GIF8")) or head[4:8] == b"ftyp":
        return True
    return head.lstrip().startswith((b"<?xml", b"<svg", b"<!DOCTYPE svg")) and b"<svg" in head


def _save_animation(results: Results | Sequence[Results], request: ViewRequest, path: Path) -> None:
    from matplotlib.animation import Animation, FFMpegWriter, PillowWriter

    view, steps = select_steps(_list_files(results), request)
    is_gif = path.suffix.lower() == ".gif"
    if not is_gif and not FFMpegWriter.isAvailable():
        raise ResultsError("MP4 is written by the program 'ffmpeg', which was not found; install it, or write a .gif")
    animation = view.drawing.draw(steps, request)
    assert isinstance(animation, Animation)
    animation.save(path, (PillowWriter if is_gif else FFMpegWriter)(fps=FRAMES_PER_SECOND), dpi=MOVING_DPI)


def _check_suffix(path: Path, is_moving: bool) -> None:
    suffix = path.suffix.lower()
    if suffix in MOVING_SUFFIXES and not is_moving:
        raise ResultsError(
            f"{path}: '{suffix}' holds moving pictures; give '--view animate', or one of {', '.join(STILL_SUFFIXES)}"
        )
    allowed = MOVING_SUFFIXES if is_moving else STILL_SUFFIXES
    if suffix not in allowed:
        what = "moving pictures" if is_moving else "pictures"
        raise ResultsError(f"{path}: {what} are {', '.join(allowed)}; found '{path.suffix or 'no suffix'}'")


@contextmanager
def _refuse_crowding(size: PictureSize | None) -> Iterator[None]:
    """Turn matplotlib's warning that nothing has room in a picture of a ``size`` that was asked for into an error."""
    with warnings.catch_warnings():
        if size is not None:
            warnings.filterwarnings("error", message="constrained_layout not applied", category=UserWarning)
        try:
            yield
        except UserWarning as exc:
            raise ResultsError(
                "there is no room for all this in a picture of that size; give a greater one, a width alone, or fewer "
                "points"
            ) from exc


@contextmanager
def _explain_errors(results: Results | Sequence[Results]) -> Iterator[None]:
    """Turn what matplotlib and numpy raise for strange numbers into ResultsError."""
    try:
        with np.errstate(all="ignore"):
            yield
    except (ValueError, OverflowError, np.linalg.LinAlgError) as exc:
        # Axes cannot be laid out for numbers that are not finite, or too large to be subtracted.
        reason = " ".join(str(exc).split())[:MAX_REASON]
        paths = " and ".join(str(one.path) for one in _list_files(results))
        raise ResultsError(f"what {paths} holds cannot be drawn so: {reason}") from exc
