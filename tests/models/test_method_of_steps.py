"""Motions by the method of steps against closed forms."""

import math

import numpy as np
import pytest
from scipy.integrate import DOP853

from tests.models.method_of_steps import Motion, MotionError, Piece, same


def line(t, z, past):
    return [1.0]


def test_a_piece_is_the_dense_output_of_its_step():
    solver = DOP853(lambda t, z: [z[1], math.cos(3 * t) - z[0]], 0.3, [1.0, 2.0], 9.0, rtol=1e-6, first_step=0.5)
    for _ in range(8):
        solver.step()
        dense = solver.dense_output()
        piece = Piece(dense)
        assert all(np.allclose(piece(t), dense(t), atol=1e-14) for t in np.linspace(solver.t_old, solver.t, 9))


def test_jumps_come_back_through_a_delay_on_their_own_side():
    """x' = 1, back to 0 at x = 1; y' = x(t - 0.3), so y grows by 1/2 in each period."""
    motion = Motion(
        {"m": lambda t, z, past: [1.0, past(0.3)[0]]},
        {"m": [(lambda t, z, past: z[0] - 1, 1, lambda t, z, past: [0.0, z[1]], "m", "tooth")]},
        (0.3,),
        lambda t: [t % 1.0, 0.0],
        "m",
    ).run(5.5)
    assert np.allclose(motion.times("tooth"), [1, 2, 3, 4, 5], atol=1e-13)
    assert np.allclose(np.diff([z[1] for _, _, z in motion.events]), 0.5, atol=1e-13)
    assert motion(3.0, -1)[0] == pytest.approx(1.0, abs=1e-12)
    assert motion(3.0, 1)[0] == pytest.approx(0.0, abs=1e-12)


def test_a_jump_of_a_delayed_value_over_a_surface_is_an_event():
    """x' = 1 from 0.2 to 1: at its end x(t - 0.3) is 0.7, and jumps from 1 over 0.5 to 0.2 a delay later."""
    motion = Motion(
        {"m": line},
        {
            "m": [
                (lambda t, z, past: z[0] - 1, 1, lambda t, z, past: [0.2], "m", "tooth"),
                (lambda t, z, past: past(0.3)[0] - 0.5, -1, same, "m", "echo"),
            ]
        },
        (0.3,),
        lambda t: [0.2 + t],
        "m",
    ).run(3)
    assert np.allclose(motion.times("echo"), motion.times("tooth")[: len(motion.times("echo"))] + 0.3, atol=1e-12)
    assert len(motion.times("echo")) >= 2


def test_clocks_start_at_every_event_and_are_lost_where_no_segment_waits():
    """x' = 1 from 0 to 1: kicks come 1.3 after each tooth; in the mode 'deaf' nothing waits for them."""
    exits = {
        "m": [
            (lambda t, z, past: z[0] - 1, 1, lambda t, z, past: [0.0], "m", "tooth"),
            (None, 0, lambda t, z, past: [z[0] - 0.25], "m", "kick"),
        ],
        "deaf": [(lambda t, z, past: z[0] - 1, 1, lambda t, z, past: [0.0], "deaf", "tooth")],
    }
    start = {"clocks": {"tooth": [("kick", 1.3)]}, "pending": [(0.5, "kick")]}
    heard, deaf = (Motion({"m": line, "deaf": line}, exits, (), lambda t: [0.0], m, **start).run(4.9) for m in exits)
    assert np.allclose(heard.times("tooth"), [1.25, 2.25, 3.5, 4.75], atol=1e-12)
    assert np.allclose(heard.times("kick"), [0.5, 2.55, 3.55, 4.8], atol=1e-12)
    assert np.allclose(deaf.times("tooth"), [1, 2, 3, 4], atol=1e-12)
    assert len(deaf.times("kick")) == 0


def test_two_crossings_close_together_are_both_found():
    """cos t passes 1 - 1e-6 on its way up and down."""
    depth = 1e-6
    width = math.acos(1 - depth)
    motion = Motion(
        {"m": lambda t, z, past: [z[1], -z[0]]},
        {
            "m": [
                (lambda t, z, past: z[0] - 1 + depth, 1, same, "m", "up"),
                (lambda t, z, past: z[0] - 1 + depth, -1, same, "m", "down"),
            ]
        },
        (),
        lambda t: [0.0, 1.0],
        "m",
    ).run(20)
    tops = math.pi / 2 + 2 * math.pi * np.arange(3)
    assert np.allclose(motion.times("up"), tops - width, atol=1e-9)
    assert np.allclose(motion.times("down"), tops + width, atol=1e-9)


def test_a_motion_between_two_fields_that_point_at_each_other_slides():
    flows = {"plus": lambda t, z, past: [-1.0], "minus": lambda t, z, past: [1.0]}
    exits = {
        "plus": [(lambda t, z, past: z[0], -1, same, "minus", "down", "turn")],
        "minus": [(lambda t, z, past: z[0], 1, same, "plus", "up", "turn")],
    }
    with pytest.raises(MotionError, match=r"slides on 'turn' at t = 0\.(5|4999999)"):
        Motion(flows, exits, (), lambda t: [0.5], "plus").run(2)
