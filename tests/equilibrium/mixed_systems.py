"""Models that read the past in every way, with their characteristic function and count of roots written once more."""

import cmath

import numpy as np
from mpmath import mp, mpc

from tests.equilibrium.motions import make_motion

# At rest x = y = 0: the delays are t1, t2 and t3 there, and the integral is taken from low to high.
MIXED = {
    "name": "mixed",
    "states": ["x", "y"],
    "parameters": dict.fromkeys(
        ["a11", "a12", "a21", "a22", "b11", "b12", "b21", "c11", "c22", "c12", "d1", "d2", "q", "low", "high"], 0.1
    )
    | {"t1": 1.0, "t2": 0.7, "t3": 0.4},
    "modes": {
        "m": {
            "x'": "a11*x + a12*y + b11*x(t - t1 - 0.3*x) + b12*y(t - t2*exp(x*y)) + c11*x'(t - t3 - y(t - t1)**2)"
            " + c12*y'(t - t1 - 0.3*x) + d1*integral(exp(-q*s)*(y(t - s) + x(t - s)**2), s, low, high + x**2)",
            "y'": "a21*x + a22*y + b21*x(t - t2*exp(x*y))*(1 + y) + c22*y'(t - t3 - y(t - t1)**2)"
            " + d2*integral(s*x(t - s), s, low, high + x)",
        }
    },
    "initial": {"x": 0.1},
}
MOTION, PARAMETERS = make_motion(MIXED)


def draw(seed):
    """Return random parameters by name: past rates come to less than one together."""
    rng = np.random.default_rng(seed)
    p = dict(zip(MIXED["parameters"], PARAMETERS.tolist(), strict=True))
    for name in ("a11", "a12", "a21", "a22", "b11", "b12", "b21"):
        p[name] = float(rng.normal())
    for name in ("d1", "d2"):
        p[name] = float(2.0 * rng.normal())
    c11, c22, c12 = rng.uniform(-0.7, 0.7, size=3) * rng.integers(0, 2, size=3)
    scale = 10.0 ** rng.uniform(-0.7, 0.5)
    p |= {"c11": float(c11), "c22": float(c22), "c12": float(0.4 * c12), "q": float(rng.uniform(-1, 2))}
    p |= {name: float(scale * rng.uniform(0.05, 1.0)) for name in ("t1", "t2", "t3")}
    p["low"] = float(scale * rng.uniform(0, 0.5))
    return p | {"high": p["low"] + float(scale * rng.uniform(0.1, 1.0))}


def linearise(p):
    """Return the program's characteristic matrix at rest."""
    return MOTION.linearise(np.zeros(2), np.array([p[name] for name in MIXED["parameters"]]))


def find_determinant(p, z, exp=cmath.exp):
    """Return det Delta(z) by hand; integrals in closed form: of exp(-r s), and of s exp(-r s)."""
    low, high = p["low"], p["high"]

    def whole(r):
        return (exp(-r * low) - exp(-r * high)) / r

    def moment(r):
        return (low * exp(-r * low) - high * exp(-r * high)) / r + whole(r) / r

    one, two, three = exp(-z * p["t1"]), exp(-z * p["t2"]), exp(-z * p["t3"])
    xx = z - p["a11"] - p["b11"] * one - z * p["c11"] * three
    xy = -p["a12"] - p["b12"] * two - z * p["c12"] * one - p["d1"] * whole(z + p["q"])
    yx = -p["a21"] - p["b21"] * two - p["d2"] * moment(z)
    yy = z - p["a22"] - z * p["c22"] * three
    return xx * yy - xy * yx


def correct_root(p, root):
    """Return the zero of the determinant near a root, in many digits."""
    with mp.workdps(40):
        exact = {name: mp.mpf(value) for name, value in p.items()}
        return complex(mp.findroot(lambda z: find_determinant(exact, z, mp.exp), mpc(root), tol=1e-60, verify=False))


def count_unstable(p, radius, aside=1e-7):
    """Return how many zeros lie in the half disc around zero to the right, by the turns of the determinant along it."""
    with np.errstate(all="ignore"):
        down = aside + 1j * np.linspace(radius, -radius, 40_001)
        along = radius * np.exp(1j * np.linspace(-np.pi / 2, np.pi / 2, 20_001)) + aside
        contour = np.concatenate([down, along[1:]])
        values = find_determinant(p, contour, np.exp)
    turns = np.angle(values[1:] / values[:-1])
    assert np.max(np.abs(turns)) < 1.0, "the contour is too coarse"
    return round(float(np.sum(turns)) / (2 * np.pi))


def bound_roots(p):
    """Return what no unstable root exceeds in modulus: rows of moduli, Delta = z (I - N) - A."""
    width = p["high"] - p["low"]
    kernel = width * max(np.exp(-p["q"] * p["low"]), np.exp(-p["q"] * p["high"]))
    sizes = np.abs([[p["a11"], p["a12"]], [p["a21"], p["a22"]]]) + np.abs(
        [[p["b11"], abs(p["b12"]) + abs(p["d1"]) * kernel], [abs(p["b21"]) + abs(p["d2"]) * p["high"] * width, 0.0]]
    )
    rates = np.abs([[p["c11"], p["c12"]], [0.0, p["c22"]]])
    inverse = np.linalg.inv(np.eye(2) - rates)
    return float(np.max(np.sum(inverse @ sizes, axis=1)))
