"""The right-hand side of all that is integrated: states, the chain of the paper's section 2.2, and their tangent."""

from __future__ import annotations

from pddecont.native.arrays import Floats
from pddecont.native.calls import call
from pddecont.native.integrator.core import Core
from pddecont.native.integrator.history import read_delayed, read_states
from pddecont.native.integrator.past_reads import read_for_derivatives, read_past


def evaluate_rhs(c: Core, mode: int, t: float, y: Floats, dy: Floats) -> None:
    """Write dy/dt at ``t`` in ``mode`` to ``dy``.

    ``y`` is [states, the chain's variables w_k of each delayed value's stages (derivative k times delta^k), the tangent
    of all these].
    """
    n, m = c.n, c.n_pairs
    # Both are called from here, so that a model without lags that vary has no further call.
    if c.is_general == 1:
        read_past(c, t, y, c.xd, 0)
    else:
        read_states(c, t, y, c.xd, 0)
    for i in range(n):
        dy[i] = 0.0
    call(c.field[mode], c.field_case[mode], t, y, c.xd, c.p, dy)
    if c.chain_n > 0:
        _evaluate_chain(c, y, dy, 0)
    if c.tangent == 1:
        if c.is_general == 1:
            read_for_derivatives(c, t, y, c.xd)
        read_delayed(c, t, y, c.xd_slope, 1)
        for i in range(n * (n + m)):
            c.jacobian[i] = 0.0
        call(c.field_jacobian[mode], c.field_case[mode], t, y, c.xd, c.p, c.jacobian)
        for i in range(n):
            slope = 0.0
            for j in range(n):
                slope += c.jacobian[i * n + j] * y[c.n_full + j]
            for j in range(m):
                slope += c.jacobian[n * n + i * m + j] * c.xd_slope[j]
            dy[c.n_full + i] = slope
        if c.chain_n > 0:
            _evaluate_chain(c, y, dy, c.n_full)


def _evaluate_chain(c: Core, y: Floats, dy: Floats, first: int) -> None:
    """Write the slopes of the chains from ``first`` on: sum_k u_i^(k) delta^k / k! = u_{i-1}, eqs. (2.4)-(2.7).

    ``first`` is where the states that they follow begin in ``y``: 0, or that of the tangent.
    """
    order = c.chain_order
    for i in range(c.n_pairs):
        delta = c.tau[c.pair_delay[i]] / c.chain_n
        for stage in range(c.chain_n):
            base = first + c.n + (i * c.chain_n + stage) * order
            missing = y[base - order] if stage > 0 else y[first + c.pair_state[i]]
            factorial = 1.0
            for k in range(order):
                if k > 0:
                    factorial *= k
                    dy[base + k - 1] = y[base + k] / delta if delta > 0.0 else 0.0
                missing -= y[base + k] / factorial
            dy[base + order - 1] = missing * factorial * order / delta if delta > 0.0 else 0.0
