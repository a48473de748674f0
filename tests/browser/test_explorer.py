"""What a click or a key shows is what the file holds, for each view."""

import json

import numpy as np
import pytest

from pddecont.plot import interpolate_segments
from pddecont.reasons import make_reason
from pddecont.report.explanations import EXPLANATIONS
from pddecont.results import create_results, read_results
from pddecont.tables import find_main_table, make_table, read_label_map, read_multipliers, read_roots
from tests.browser.explored import write_value
from tests.plot import synthetic


def check_row(explored, step, place):
    """Compare the row that is shown with the table's, digit by digit, and return that."""
    rows = make_table(step, find_main_table(step.kind))
    shown = explored.row()
    for name, value in rows[place].items():
        assert shown[name] == write_value(value), name
    return rows[place]


def check_orbit(explored, step, row, x, y):
    """Compare the segments that are drawn with the polynomials that the file holds."""
    i, j = (list(step.meta["states"]).index(name) for name in (x, y))
    arcs = [arc[:, [i, j]] for _, arc in interpolate_segments(step, row)]
    for number, arc in enumerate(arcs):
        drawn = explored.values("point-orbit", number).T
        np.testing.assert_array_equal(drawn[[0, -1]], arc[[0, -1]].astype("f4"))
        known = {tuple(pair) for pair in arc.astype("f4").tolist()}
        assert len(drawn) > 5 and {tuple(pair) for pair in drawn.tolist()} <= known


def values_of(step, name):
    return [row[name] for row in make_table(step, find_main_table(step.kind))]


def test_a_click_shows_the_point_its_orbit_and_its_multipliers(explore, orbits):
    explored, step = explore(orbits), orbits.steps["in_gain"]
    explored.choose("view", "over K")
    monitor = step.meta["monitors"][0]
    explored.choose("y", monitor)
    for place in (1, len(step) // 2, len(step) - 2):
        explored.click(values_of(step, "K")[place], values_of(step, monitor)[place])
        row = check_row(explored, step, place)["index"]
        check_orbit(explored, step, row, "x", "v")
        drawn = explored.values("point-spectrum")
        expected = read_multipliers(step, row)
        assert explored.page.is_visible("#point-spectrum") == bool(len(expected))
        if len(expected):
            np.testing.assert_array_equal(drawn[0] + 1j * drawn[1], expected)
        assert f"point {place + 1} of {len(step)}" in explored.text("#explorer-status")


def test_keys_move_along_a_branch_and_to_labelled_points(explore, orbits):
    explored, step = explore(orbits), orbits.steps["in_gain"]
    explored.choose("view", "over K")
    explored.press("Home", "ArrowRight", "ArrowRight", "ArrowLeft")
    check_row(explored, step, 1)
    labelled = [place for place, row in enumerate(step.order) if step.labels[row]]
    explored.press("Home", *["PageDown"] * 2)
    place = [k for k in labelled if k > 0][1]
    found = check_row(explored, step, place)
    said = explored.text("#point-label")
    assert found["label"] in said and EXPLANATIONS[found["kind"]] in said
    assert f"point: {found['label']}" in explored.text("#point-start")
    explored.press("End", "ArrowRight")
    check_row(explored, step, len(step) - 1)


def test_up_and_down_change_the_step(explore, orbits):
    explored = explore(orbits)
    explored.choose("view", "over K")
    names = []
    for _ in range(3):
        names.append(explored.row()["step"])
        explored.press("ArrowDown")
    shown = explored.page.eval_on_selector_all(
        "#explorer-steps input:checked + label", "all => all.map((l) => l.textContent.split(' ')[0])"
    )
    assert set(names) <= set(shown)
    assert len(set(names)) == min(3, len(shown))


def test_any_two_signals_show_the_orbit_and_one_state_its_past(explore, simulated, tmp_path):
    explored, step = explore(simulated), simulated.steps["branch"]
    explored.choose("view", "over beta")
    explored.press("Home")
    row = int(step.order[0])
    for x, y in (("v", "x"), ("x", "x"), ("x", "v")):
        explored.page.select_option("#point-orbit-x", x)
        explored.page.select_option("#point-orbit-y", y)
        explored.wait()
        check_orbit(explored, step, row, x, y)
    # The wall, x = e, is drawn where x runs along an axis.
    shapes = explored.page.evaluate("() => document.getElementById('point-orbit').layout.shapes")
    wall = make_table(step, "points")[0]["e"]
    assert [(s["x0"], s["x1"]) for s in shapes] == [(wall, wall)]
    explored.page.select_option("#point-profile-of", "v")
    explored.wait()
    arcs = interpolate_segments(step, row)
    drawn = explored.values("point-profile")
    assert len(explored.traces("point-profile")) == 1
    assert np.nanmax(drawn[1]) == pytest.approx(max(arc[:, 1].max() for _, arc in arcs), rel=1e-3)
    assert np.nanmax(drawn[0]) == np.float32(arcs[-1][0][-1] - arcs[0][0][0])


def test_every_column_can_be_an_axis_and_lines_lie_on_the_points(explore, orbits):
    explored, step = explore(orbits), orbits.steps["in_gain"]
    explored.choose("view", "over K")
    others = [
        name
        for name in explored.page.eval_on_selector_all(
            "#explorer-steps label", "all => all.map((l) => l.textContent.split(' ')[0])"
        )
        if name != "in_gain"
    ]
    for number, label in enumerate(explored.page.query_selector_all("#explorer-steps label")):
        if label.text_content().split(" ")[0] in others:
            explored.page.uncheck(f"#explorer-steps li:nth-child({number + 1}) input")
    assert {"K", "period", "arclength", "error_estimate", "n_periods"} <= set(explored.options("x"))
    for x, y in (("K", "period"), ("arclength", "K")):
        explored.choose("x", x)
        explored.choose("y", y)
        lines = [t for t in explored.traces("diagram") if t["mode"] == "lines"]
        drawn = {(a, b) for t in lines for a, b in zip(t["x"], t["y"], strict=True) if a is not None}
        points = zip(step.points[x] if x == "arclength" else values_of(step, x), values_of(step, y), strict=True)
        expected = (
            np.array(sorted(points)) if x == "K" else np.column_stack([np.sort(step.points[x]), values_of(step, y)])
        )
        found = np.array(sorted(drawn))
        for point in expected:
            assert np.min(np.abs(found - point).max(axis=1)) < 1e-12


def test_steps_are_switched_on_and_off(explore, orbits):
    explored = explore(orbits)
    explored.choose("view", "over K")

    def count():
        return sum(len(t["x"]) for t in explored.traces("diagram") if t["mode"] == "lines")

    before, boxes = count(), explored.page.query_selector_all("#explorer-steps input:checked")
    assert len(boxes) > 1
    boxes[0].click()
    explored.wait()
    assert 0 < count() < before
    boxes[0].click()
    explored.wait()
    assert count() == before


def test_a_plane_shows_curves_and_their_points(explore, orbits):
    explored, step = explore(orbits), orbits.steps["grazing"]
    view = next(name for name in explored.options("view") if name.startswith("plane"))
    explored.choose("view", view)
    x, y = explored.page.input_value("#explorer-x"), explored.page.input_value("#explorer-y")
    assert {x, y} == {"K", "tau_d"}
    place = 3
    explored.click(values_of(step, x)[place], values_of(step, y)[place])
    check_row(explored, step, place)
    texts = ", ".join(text for trace in explored.traces("diagram") for text in trace["text"])
    assert all(step.labels[row] in texts for row in step.order if step.labels[row] and step.kind_of(row) != "EP")


def test_equilibria_show_their_roots(explore, resting):
    step = next(s for s in resting.steps.values() if s.kind == "equilibria" and len(s.meta["free"]) == 1)
    explored = explore(resting)
    explored.choose("view", f"over {step.meta['free'][0]}")
    while explored.row()["step"] != step.name:
        explored.press("ArrowDown")
    explored.press("Home")
    row = check_row(explored, step, 0)["index"]
    drawn = explored.values("point-spectrum")
    np.testing.assert_array_equal(drawn[0] + 1j * drawn[1], read_roots(step, row))
    assert explored.text("#point-spectrum-name") == "Characteristic roots"
    assert not explored.page.is_visible("#point-orbit")


def test_dots_of_a_sweep_are_returns_and_name_their_attractor(explore, simulated):
    explored, step = explore(simulated), simulated.steps["diagram"]
    explored.choose("view", "over beta")
    explored.choose("y", "x")
    place = len(values_of(step, "label")) - 1
    row = values_of(step, "index")[place]
    value = step.orbit(row)["returns"][0, 0]
    explored.click(values_of(step, "beta")[place], value)
    check_row(explored, step, place)
    assert explored.row()["x at returns"] == ", ".join(map(repr, step.orbit(row)["returns"][:, 0].tolist()))
    np.testing.assert_array_equal(explored.values("point-orbit").T, step.orbit(row)["returns"])


def test_a_basin_tells_each_start_its_attractor(explore, simulated):
    explored, step = explore(simulated), simulated.steps["map"]
    explored.choose("view", "basins: map")
    labels = read_label_map(step)
    for j, i in ((0, 0), (labels.shape[0] - 2, 3), (2, labels.shape[1] - 2)):
        explored.click(step.meta["x"][i], step.meta["y"][j])
        check_row(explored, step, labels[j, i])
        shown = explored.row()
        assert shown["x at the start"] == repr(step.meta["x"][i])
        assert shown["v at the start"] == repr(step.meta["y"][j])


def test_the_diagram_moves_and_zooms_by_mouse_and_keys(explore, orbits):
    explored = explore(orbits)
    whole = explored.ranges()
    explored.press("+", "Shift+ArrowRight")
    near = explored.ranges()
    assert np.ptp(near[0]) == pytest.approx(0.8 * np.ptp(whole[0]))
    assert np.mean(near[0]) > np.mean(whole[0])
    explored.press("0")
    assert explored.ranges() == whole
    box = explored.page.locator("#diagram").bounding_box()
    explored.page.mouse.move(box["x"] + 400, box["y"] + 200)
    explored.page.mouse.wheel(0, -300)
    explored.page.wait_for_timeout(500)
    assert np.ptp(explored.ranges()[0]) < np.ptp(whole[0])
    row = explored.row()
    explored.page.mouse.down()
    explored.page.mouse.move(box["x"] + 500, box["y"] + 200, steps=4)
    explored.page.mouse.up()
    explored.wait()
    assert explored.row() == row  # a drag is no click
    explored.page.click("#explorer-all")
    explored.wait()
    assert explored.ranges() == whole


def test_numbers_have_the_digits_that_the_file_holds(explore, tmp_path):
    numbers = [0.1, 1e-7, 1e-5, 1e-4, 123456.789, 1e15, 1e16, 1.5e21, 5e-324, 1e299, -0.0, 2 / 3, -1e-9, 100.0, np.nan]
    path = tmp_path / "numbers.h5"
    create_results(path, "model", "run", "run.yaml", "{}")
    rows = [synthetic.point(float(k), 0.1 * k, value, value) for k, value in enumerate(numbers)]
    synthetic.add(path, "in_gain", rows)
    results = read_results(path)
    explored = explore(results)
    explored.press("Home")
    for place in range(len(numbers)):
        check_row(explored, results.steps["in_gain"], place)
        explored.press("ArrowRight")


def test_two_files_are_shown_beside_each_other(explore, orbits, tmp_path):
    path = tmp_path / "other.h5"
    create_results(path, "model", "run", "run.yaml", "{}")
    synthetic.add(path, "in_gain", synthetic.gain(tau_d=2.0))
    explored = explore(orbits, read_results(path))
    explored.choose("view", "over K")
    titles = explored.page.eval_on_selector_all(
        "#explorer-steps input:checked + label", "all => all.map((l) => l.textContent)"
    )
    assert any(t.startswith("orbits: in_gain") for t in titles) and any(t.startswith("other: in_gain") for t in titles)
    while explored.row()["step"] != "other: in_gain":
        explored.press("ArrowDown")
    assert explored.row()["tau_d"] == "2.0"
    assert "file: other.h5" in explored.text("#point-start")


HOSTILE = "<img src=x onerror=window.hit=1></script><script>window.hit=1</script>"


def test_nothing_of_a_file_runs(explore, tmp_path):
    path = tmp_path / "h.h5"
    create_results(path, HOSTILE, HOSTILE + "run", HOSTILE, json.dumps({"numpy": HOSTILE}))
    rows = [
        synthetic.point(
            float(k),
            0.2 + k,
            3.8,
            1.0 + k,
            kind="LP",
            reason=make_reason("text", text=HOSTILE),
            signature="<b>N</b> <i>C</i>",
        )
        for k in range(3)
    ]
    synthetic.add(path, "step", rows)
    explored = explore(read_results(path))
    explored.press("Home", "ArrowRight")
    assert explored.page.evaluate("() => window.hit") is None
    assert HOSTILE in explored.text("#point-label")
    assert explored.page.query_selector("#explorer img, #explorer b") is None


def test_the_run_file_and_the_row_can_be_copied(explore, orbits):
    explored = explore(orbits)
    explored.page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    for button, expected in (
        ("#point-copy-start", explored.text("#point-start")),
        ("#point-copy-row", "".join(f"{name}\t{text}\n" for name, text in explored.row().items())),
    ):
        explored.page.click(button)
        explored.page.wait_for_selector("#point-copied:text-is('copied')")
        assert explored.page.evaluate("() => navigator.clipboard.readText()") == expected
        explored.press("ArrowRight", "ArrowLeft")  # takes the word away again
