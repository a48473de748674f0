"""Orbits of points, and of several steps over one another."""

import pytest

from tests.plot.synthetic import point


def test_a_panel_for_each_special_point_or_those_asked_for(every, show):
    assert [axes.get_title() for axes in show(every, "orbit", ("in_gain",)).axes] == [
        "LP1  $K$ = 0.3",
        "GR1  $K$ = 0.5",
    ]
    assert len(show(every, "orbit", ("in_gain",), indices=(0, 1, 2)).axes) == 3
    [axes] = show(every, "orbit", ("orbit",)).axes
    assert (axes.get_xlabel(), axes.get_ylabel(), axes.get_title()) == ("$x$", "$v$", "")
    [axes] = show(every, "orbit", ("orbit",), x="v", y="x").axes
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("$v$", "$x$")


def test_orbits_with_the_same_parameters_share_a_panel(made, show):
    steps = {name: ([point(0.0, K, 3, 1)], {"kind": "orbit"}) for name, K in (("a", 0.1), ("b", 0.2), ("c", 0.1))}
    one, other = show(made(**steps), "orbit", ("a", "b", "c")).axes
    assert (one.get_title(), other.get_title()) == ("$K$ = 0.1", "$K$ = 0.2")
    assert [text.get_text() for text in one.get_legend().get_texts()] == ["a", "c"]


@pytest.mark.parametrize("view", ["orbit", "profile"])
def test_of_one_state_an_orbit_is_its_profile(made, show, view, monkeypatch):
    from tests.plot import synthetic

    whole = synthetic.circle
    monkeypatch.setattr(
        synthetic, "circle", lambda signature: whole(signature) | {"states": whole(signature)["states"][:, :1]}
    )
    monkeypatch.setattr(synthetic, "STATES", ("x",))
    results = made(o=([point(0.0, 0.1, 3, 1) | {"surfaces": [[1.0, 0.9]]}], {"kind": "orbit"}))
    [axes] = show(results, view).axes
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("$t$", "$x$")
