"""Labels cover neither each other nor marks nor curves."""

import numpy as np
import pytest

from pddecont.plot.point_labels import PointLabel, place_labels, sample_curves
from tests.plot.drawn import boxes, texts
from tests.plot.synthetic import point


def overlap(a, b):
    return np.prod(np.clip(np.minimum(a[2:], b[2:]) - np.maximum(a[:2], b[:2]), 0, None))


def test_labels_do_not_cover_one_another(made, show):
    kinds = ["LP", "PD", "GR"]
    rows = [
        point(float(k), K, 3, K * K, kind=kinds[k % 3] if 20 < k < 36 else "")
        for k, K in enumerate(np.linspace(0, 1, 60))
    ]
    found = boxes(show(made(b=(rows, {}))).axes[0])
    assert len(found) == 15
    for i, a in enumerate(found):
        assert all(overlap(a, b) < 0.15 * np.prod(a[2:] - a[:2]) for b in found[i + 1 :])


def test_labels_lie_inside_the_axes_and_off_curves(axes):
    x = np.linspace(0, 1, 101)
    axes.plot(x, np.sin(7 * x))
    labels = [PointLabel(f"LP{k}", x[k], np.sin(7 * x[k])) for k in range(0, 101, 5)]
    place_labels(axes, labels)
    found = boxes(axes)
    frame = axes.get_window_extent().extents
    curve = sample_curves(axes) * axes.figure.dpi / 72.0
    assert len(found) == len(labels)
    for box in found:
        assert np.all(box[:2] >= frame[:2]) and np.all(box[2:] <= frame[2:])
        # The descent of a text without letters that go down is empty.
        ink = box + np.array([1.0, 0.2, -1.0, -0.1]) * np.array([1.0, box[3] - box[1], 1.0, box[3] - box[1]])
        assert not np.any(np.all((curve > ink[:2]) & (curve < ink[2:]), axis=1))


def test_a_label_that_goes_far_gets_a_line(axes):
    axes.plot([0, 1], [0, 1], "o")
    # A wall of curves around the point.
    for gap in np.linspace(-0.06, 0.06, 25):
        axes.plot([0.4, 0.6], [0.5 + gap, 0.5 + gap])
    place_labels(axes, [PointLabel("LP1", 0.5, 0.5), PointLabel("LP2", 0.1, 0.7)])
    assert texts(axes)["LP1"].arrow_patch is not None
    assert texts(axes)["LP2"].arrow_patch is None


def test_points_in_one_place_share_a_label(made, show):
    steps = {
        name: ([point(0.0, 0.2, 3, 1, kind=kind), point(1.0, 0.5, 3, 2)], {})
        for name, kind in (("a", "PD"), ("b", "BP"), ("c", "PD"))
    }
    assert set(texts(show(made(**steps)).axes[0])) == {"PD1, BP1"}


@pytest.mark.parametrize("labels", [[], [PointLabel("LP1", np.nan, 0.0)]])
def test_what_has_no_place_has_no_label(axes, labels):
    place_labels(axes, labels)
    assert not axes.texts


def test_places_are_the_same_each_time():
    from matplotlib.figure import Figure

    def place():
        axes = Figure().subplots()
        axes.plot([0, 1, 2], [0, 1, 0])
        place_labels(axes, [PointLabel(f"LP{k}", 0.1 * k, 0.1 * k) for k in range(10)])
        return [text.get_position() for text in axes.texts]

    assert place() == place()


def test_curves_are_sampled_a_few_points_apart(axes):
    axes.plot([0, 1], [0, 1])
    axes.plot([0.5, np.nan, 0.7], [0.5, 0.6, 0.7], "o", ls="")
    axes.axvline(0.5)  # half in the axes' own units: no curve
    found = sample_curves(axes)
    steps = np.hypot(*np.diff(found[:-2], axis=0).T)
    assert steps == pytest.approx(steps[0])
    assert 3.0 <= steps[0] < 3.2


def test_labels_without_room_are_left_out_and_counted(axes):
    angles = np.linspace(0, 2 * np.pi, 80, endpoint=False)
    x, y = 0.5 + 0.03 * np.cos(angles), 0.5 + 0.03 * np.sin(angles)
    axes.plot(x, y, "o")
    axes.set(xlim=(0, 1), ylim=(0, 1))
    place_labels(axes, [PointLabel(f"PD{k}", *place) for k, place in enumerate(zip(x, y, strict=True))])
    found = boxes(axes)
    assert 10 < len(found) < 80
    for i, a in enumerate(found):
        assert all(overlap(a, b) < 0.15 * np.prod(a[2:] - a[:2]) for b in found[i + 1 :])
    n_written = sum(len(text.split(", ")) for text in texts(axes))
    assert axes.get_title(loc="right") == f"{80 - n_written} labels left out: no room"
