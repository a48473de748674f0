"""Small periodic orbits of delay equations by harmonic balance in many digits, and the cubic coefficient they show.

Nothing here comes from the program: an equation is a Python function ``field(read, p)`` that returns f, and
``read(i, lag, m)`` is the m-th derivative of state i a lag ago, which may be made of other values that are read.
Integrals are sums of such values (``integrate``). Next to a Hopf point p_0, omega_0 the orbits have

    x(t) = x_0 + 2 Re(z q e^(i omega t)) + ...,    p = p_0 + p_2 |z|^2 + ...,    omega = omega_0 + omega_2 |z|^2 + ...

With z' = (i omega_0 + lambda'(p_0) (p - p_0)) z + c1 z |z|^2 that says c1 = i omega_2 - lambda' p_2. The orbit is
solved for at |z| = AMPLITUDE, at which terms of higher order are of the order of its square. The derivatives that
lambda needs are differences, too, in as many digits.
"""

from dataclasses import dataclass

from mpmath import mp, mpc, mpf

mp.dps = 60
AMPLITUDE, DIFFERENCE = mpf("1e-9"), mpf("1e-15")
# Harmonics, and points of time: what is left out is of the order of AMPLITUDE^4.
K, N = 3, 9
NEWTON_STEPS = 8
# Points of integrals: over lags of the order of one less than the differences is left.
N_POINTS = 24


def _make_points():
    """Return Gauss points and weights on 0 .. 1, by Newton's method on Legendre's polynomial."""
    found = []
    for k in range(N_POINTS):
        u = mp.cos(mp.pi * (k + mpf(3) / 4) / (N_POINTS + mpf(1) / 2))
        for _ in range(8):
            before, value = mpf(1), u
            for m in range(2, N_POINTS + 1):
                before, value = value, ((2 * m - 1) * u * value - (m - 1) * before) / m
            slope = N_POINTS * (u * value - before) / (u**2 - 1)
            u -= value / slope
        found.append(((1 + u) / 2, 1 / ((1 - u**2) * slope**2)))
    return found


POINTS = _make_points()


def integrate(function, low, high):
    """Return the integral of a smooth function of the lag."""
    return (high - low) * sum(w * function(low + (high - low) * u) for u, w in POINTS)


@dataclass(frozen=True)
class Birth:
    """A Hopf point: frequency, eigenvector with |q| = 1, lambda'(p), the cubic coefficient, d |z|^2 / d p."""

    parameter: float
    states: list
    frequency: float
    vector: list
    speed: complex
    cubic: complex
    growth: float


def find_birth(field, states, frequency, parameter, amplitude=AMPLITUDE):
    """Return the Hopf point near a guess: ``field(read, p)``, one parameter p; orbits are those of an ``amplitude``."""
    n = len(states)
    x0, omega0, p0 = _find_hopf(field, [mpf(s) for s in states], mpf(frequency), mpf(parameter))
    matrix = _characteristic(field, x0, p0, 1j * omega0)
    q = _find_null(matrix)
    after = _follow_root(field, x0, p0 + DIFFERENCE, 1j * omega0)
    before = _follow_root(field, x0, p0 - DIFFERENCE, 1j * omega0)
    speed = (after - before) / (2 * DIFFERENCE)
    start = [*x0]
    for k in range(1, K + 1):
        for i in range(n):
            start += [(amplitude * q[i]).real, (amplitude * q[i]).imag] if k == 1 else [mpf(0), mpf(0)]
    solved = _newton(lambda u: _balance(field, n, q, u, amplitude), [*start, omega0, p0])
    p2, omega2 = (solved[-1] - p0) / amplitude**2, (solved[-2] - omega0) / amplitude**2
    cubic = 1j * omega2 - speed * p2
    return Birth(
        float(p0), [float(x) for x in x0], float(omega0), [complex(z) for z in q], complex(speed), complex(cubic),
        float(1 / p2),
    )  # fmt: skip


def _newton(function, guess):
    """Return a zero of a real function of as many unknowns, by Newton's method with differences."""
    x = list(guess)
    for _ in range(NEWTON_STEPS):
        value = function(x)
        columns = []
        for j in range(len(x)):
            moved = list(x)
            moved[j] += mpf("1e-30")
            columns.append([(a - b) / mpf("1e-30") for a, b in zip(function(moved), value, strict=True)])
        matrix = mp.matrix(len(x), len(x))
        for j, column in enumerate(columns):
            for i, entry in enumerate(column):
                matrix[i, j] = entry
        step = mp.lu_solve(matrix, -mp.matrix(value))
        x = [a + b for a, b in zip(x, step, strict=True)]
    return x


def _find_rest(field, x, p):
    return _newton(lambda u: field(lambda i, lag, m=0: u[i] if m == 0 else mpf(0), p), x)


def _characteristic(field, x, p, root):
    """Return Delta(root) = root I - df/dx e^(- root lag) by differences along exponential motions."""
    n, h = len(x), mpf("1e-20")
    matrix = mp.matrix(n, n)
    for j in range(n):
        after, before = (
            field(
                lambda i, lag, m=0, j=j, s=s: (
                    (x[i] if m == 0 else 0) + (s * root**m * mp.exp(-root * lag) if i == j else 0)
                ),
                p,
            )
            for s in (h, -h)
        )
        for i in range(n):
            matrix[i, j] = (root if i == j else 0) - (after[i] - before[i]) / (2 * h)
    return matrix


def _find_hopf(field, x, omega, p):
    n = len(x)

    def equations(u):
        matrix = _characteristic(field, u[:n], u[-1], 1j * u[n])
        determinant = mp.det(matrix)
        return [*field(lambda i, lag, m=0: u[i] if m == 0 else mpf(0), u[-1]), determinant.real, determinant.imag]

    solved = _newton(equations, [*x, omega, p])
    return solved[:n], solved[n], solved[-1]


def _follow_root(field, x, p, root):
    """Return the root near another of the equilibrium at another parameter."""
    rest = _find_rest(field, x, p)

    def equations(u):
        determinant = mp.det(_characteristic(field, rest, p, mpc(u[0], u[1])))
        return [determinant.real, determinant.imag]

    return mpc(*_newton(equations, [mp.re(root), mp.im(root)]))


def _find_null(matrix):
    """Return the null vector of length one, by inverse iteration."""
    n = matrix.rows
    shifted = matrix + mpf("1e-40") * mp.eye(n)
    q = mp.matrix([mpc(1 + i) for i in range(n)])
    for _ in range(3):
        q = mp.lu_solve(shifted, q)
        q /= mp.norm(q)
    return list(q)


def _balance(field, n, q, u, amplitude):
    """Return omega x' - f of harmonics 0 to K, and conj(q) . X_1 - amplitude (real and imaginary part)."""
    omega, p = u[-2], u[-1]
    mean, parts = u[:n], u[n:-2]
    harmonics = [[mpc(parts[2 * (k * n + i)], parts[2 * (k * n + i) + 1]) for i in range(n)] for k in range(K)]
    turned = {}

    def turn(lag):
        """Return e^(-i k omega lag) for all harmonics."""
        if lag not in turned:
            one = mp.expj(-omega * lag)
            turned[lag] = [one**k for k in range(1, K + 1)]
        return turned[lag]

    values = []
    for j in range(N):
        here = [mp.expjpi(mpf(2 * j * k) / N) for k in range(1, K + 1)]

        def read(i, lag, m=0, here=here):
            total = mpc(0)
            for k, (X, w, e) in enumerate(zip(harmonics, turn(lag), here, strict=True), 1):
                total += (1j * k * omega) ** m * X[i] * w * e
            return (mean[i] if m == 0 else 0) + 2 * total.real

        values.append(field(read, p))
    rows = [sum(f[i] for f in values) / N for i in range(n)]
    for k in range(1, K + 1):
        for i in range(n):
            transformed = sum(f[i] * mp.expjpi(-mpf(2 * j * k) / N) for j, f in enumerate(values)) / N
            left = 1j * k * omega * harmonics[k - 1][i] - transformed
            rows += [left.real, left.imag]
    projected = sum(mp.conj(a) * b for a, b in zip(q, harmonics[0], strict=True)) - amplitude
    return [*rows, projected.real, projected.imag]
