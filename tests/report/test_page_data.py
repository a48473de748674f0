"""What the explorer holds is what the file holds: every number of every point, orbits, multipliers, attractors."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as stn

from pddecont.plot import interpolate_segments
from pddecont.report.packed_arrays import TYPES, ArrayPacker
from pddecont.report.page_data import is_explored, make_page_data
from pddecont.report.page_data_orbits import LEAST_SAMPLES, MOST_NUMBERS, MOST_SAMPLES, choose_places, choose_samples
from pddecont.results import read_results
from pddecont.tables import (
    find_attractors,
    find_main_table,
    make_table,
    name_motion,
    read_label_map,
    read_multipliers,
    read_roots,
)
from tests.plot import equilibria, synthetic
from tests.report.page_reader import PageData
from tests.runs import run

SIMULATED = synthetic.SIMULATIONS | {
    "steps": [s for s in synthetic.SIMULATIONS["steps"] if s["name"] in ("t", "o", "branch", "diagram", "map")]
}


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("data")
    return [
        read_results(synthetic.write_all(folder / "orbits.h5")),
        read_results(equilibria.write_resting(folder / "resting.h5")),
        run(SIMULATED, folder / "simulated.h5"),
    ]


@pytest.fixture(scope="module")
def data(files):
    return PageData(make_page_data(files))


def each_step(files, data):
    for number, results in enumerate(files):
        for step in results.steps.values():
            if is_explored(step):
                yield step, data.step(step.name, number)


@settings(max_examples=60, deadline=None)
@given(
    st.lists(
        st.sampled_from(TYPES).flatmap(lambda kind: stn.arrays(np.dtype(kind), st.integers(0, 9))),
        min_size=1,
        max_size=4,
    ),
    st.text(max_size=9),
)
def test_arrays_come_back_bit_by_bit(arrays, text):
    packer = ArrayPacker()
    places = [packer.add(values, values.dtype.str) for values in arrays]
    packed = PageData(packer.pack({"text": text, "places": places}))
    assert packed.header == {"text": text, "places": places}
    for values, place in zip(arrays, places, strict=True):
        assert packed.read(place).tobytes() == values.tobytes()


def test_every_number_of_every_point_is_that_of_the_table(files, data):
    kinds = set()
    for step, shown in each_step(files, data):
        rows = make_table(step, find_main_table(step.kind))
        kinds.add(step.kind)
        assert shown["points"]["n"] == len(rows) > 0
        assert [name for name, _, _ in shown["points"]["columns"]][: len(rows[0])] == list(rows[0])
        for name in rows[0]:
            found, expected = data.column(shown, name), [row[name] for row in rows]
            if isinstance(found, list):
                assert found == expected
            else:
                np.testing.assert_array_equal(found, [np.nan if v is None else float(v) for v in expected], name)
    assert kinds == {"orbit", "continue", "equilibrium", "equilibria", "sweep", "basin"}


def test_columns_beyond_the_table_are_the_files_own(files, data):
    step, shown = next((s, d) for s, d in each_step(files, data) if s.name == "branch")
    for name in ("arclength", "clearance", "trivial_error", "n_periods"):
        np.testing.assert_array_equal(data.column(shown, name), step.points[name][step.order])


def test_orbits_are_points_of_their_own_polynomials(files, data):
    n_orbits = 0
    for step, shown in each_step(files, data):
        own = shown.get("orbits")
        if not own:
            assert "segment" not in step.orbits
            continue
        counts, samples = data.read(own["segments"]), data.read(own["samples"])
        time, values = data.read(own["time"]), data.read(own["values"]).reshape(len(own["signals"]), -1)
        assert data.read(own["held"]).tolist() == list(range(len(step)))
        first, n_states, at = 0, len(step.meta["states"]), 0
        for place, row in enumerate(step.order):
            arcs = interpolate_segments(step, int(row))
            past = interpolate_segments(step, int(row), "delayed") if len(own["signals"]) > n_states else None
            assert counts[place] == len(arcs)
            for k, (t, arc) in enumerate(arcs):
                n = samples[at]
                inside = slice(first, first + n)
                chosen = choose_places(len(t), n)
                np.testing.assert_array_equal(time[inside], (t - arcs[0][0][0])[chosen].astype("f4"))
                np.testing.assert_array_equal(values[:n_states, inside].T, arc[chosen].astype("f4"))
                if past:
                    np.testing.assert_array_equal(values[n_states:, inside].T, past[k][1][chosen].astype("f4"))
                first, at = first + n, at + 1
            signature = own["signatures"][data.read(own["signature"])[place]]
            assert len(signature.split()) == len(arcs)
            highest, lowest = (data.read(side).reshape(n_states, -1)[:, place] for side in own["extents"])
            together = np.vstack([arc for _, arc in arcs])
            np.testing.assert_array_equal((highest, lowest), (together.max(axis=0), together.min(axis=0)))
            n_orbits += 1
        surfaces = data.read(own["surfaces"]).reshape(len(step), own["n_surfaces"], n_states + 1)
        np.testing.assert_array_equal(surfaces, step.points["surfaces"][step.order])
    assert n_orbits > 10


def test_multipliers_and_roots_are_the_files_own(files, data):
    seen = set()
    for step, shown in each_step(files, data):
        if not (own := shown.get("spectra")):
            continue
        read = {"multipliers": read_multipliers, "roots": read_roots}[own["what"]]
        seen.add(own["what"])
        expected = [read(step, int(row)) for row in step.order]
        assert data.read(own["n"]).tolist() == [len(values) for values in expected]
        found = data.read(own["real"]) + 1j * data.read(own["imaginary"])
        np.testing.assert_array_equal(found, np.concatenate(expected))
    assert seen == {"multipliers", "roots"}


def test_attractors_have_their_classes_and_returns_and_basins_their_maps(files, data):
    results = files[2]
    for name in ("diagram", "map"):
        step, shown = results.steps[name], data.step(name, 2)
        own, rows = shown["attractors"], find_attractors(step)
        ends = np.cumsum(data.read(own["n_returns"]))
        returns = data.read(own["returns"]).reshape(len(step.meta["states"]), -1).T
        for place, row in enumerate(rows):
            expected = step.orbit(int(row))["returns"]
            np.testing.assert_array_equal(returns[ends[place] - len(expected) : ends[place]], expected)
            assert own["classes"][data.read(own["class"])[place]].endswith(name_motion(step, int(row)))
        assert len(own["colours"]) == len(set(own["colours"])) == len(own["classes"])
    labels = data.read(own["map"]).reshape(len(data.read(own["y"])), -1)
    np.testing.assert_array_equal(labels, read_label_map(step))
    np.testing.assert_array_equal(data.read(own["x"]), step.meta["x"])
    assert own["over"] == step.meta["over"]


@pytest.mark.parametrize("n_orbits", [1, 20, 1000, 10_000, 300_000])
@pytest.mark.parametrize("n_signals", [2, 5, 200])
def test_orbits_of_long_branches_have_fewer_points_and_then_are_fewer(n_orbits, n_signals):
    n_samples, stride = choose_samples(n_orbits, n_signals)
    assert LEAST_SAMPLES <= n_samples <= MOST_SAMPLES
    assert n_orbits * n_signals * n_samples <= MOST_NUMBERS * stride
    assert stride == 1 or (n_samples == LEAST_SAMPLES and n_orbits * n_signals * n_samples > MOST_NUMBERS)


@given(st.integers(2, 500), st.integers(0, 500))
def test_both_ends_of_a_line_are_shown_and_no_point_twice(n, n_samples):
    places = choose_places(n, n_samples)
    assert places[0] == 0 and places[-1] == n - 1
    assert np.all(np.diff(places) > 0)
    assert len(places) <= max(2, n_samples)


def test_special_points_keep_their_orbits_where_others_have_none(files, monkeypatch):
    monkeypatch.setattr("pddecont.report.page_data_orbits.MOST_NUMBERS", 2000)
    step = files[0].steps["in_gain"]
    data = PageData(make_page_data(files[:1]))
    held = data.read(data.step("in_gain")["orbits"]["held"])
    labelled = np.array([bool(step.labels[row]) for row in step.order])
    assert np.all(held[labelled] >= 0) and np.any(held < 0)
    assert held[held >= 0].tolist() == list(range(np.count_nonzero(held >= 0)))
