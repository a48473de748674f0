"""Write the model of a chain of impact oscillators.

``python models/oscillator_chain.py 50 > models/oscillator_chain_50.yaml``

Every mass hangs on its own spring and on its neighbours', is driven alike, steered by its own delayed velocity, and
hits a wall of its own; the walls stand farther away along the chain, so that no two masses hit at once and only the
first few hit at all.
"""

import sys


def chain(n: int) -> str:
    """Return the model of ``n`` oscillators, 2 n states, as YAML."""
    masses = range(1, n + 1)

    def coupling(i: int) -> str:
        left, right = (f"x{j}" if 1 <= j <= n else "0" for j in (i - 1, i + 1))
        return f"c*({left} - 2*x{i} + {right})".replace("(0 - ", "(-").replace(" + 0)", ")")

    modes = "".join(
        f"    x{i}': v{i}\n    v{i}': force - x{i} - 2*zeta*v{i} + {coupling(i)} + K*(v{i}(t - tau) - v{i})\n"
        for i in masses
    )
    events = "".join(f"  hit{i}: x{i} - e - {i - 1}*gap\n" for i in masses)
    resets = "".join(f"  bounce{i}: {{v{i}: -r*v{i}}}\n" for i in masses)
    segments = "".join(
        f"  hit{i}: {{mode: free, event: hit{i}, direction: rising, reset: bounce{i}, to: free}}\n" for i in masses
    )
    reference = (
        "made for this library: the impact oscillator of Páez Chávez, Zhang, Liu (2020), eq. (3.10), coupled to its "
        "like, hard walls"
    )
    title = f"A chain of {n} coupled impact oscillators with delayed velocity feedback"
    return f"""# {title}; written by oscillator_chain.py.
name: oscillator_chain_{n}
reference: "{reference}"
states: [{", ".join(f"x{i}, v{i}" for i in masses)}]
parameters: {{omega: 1.1, a: 1, zeta: 0.1, c: 0.2, r: 0.6, e: 0.8, gap: 0.8, K: 0.1, tau: 1.5}}
definitions:
  force: a*cos(omega*t)
forcing: {{period: 2*pi/omega}}
modes:
  free:
{modes}events:
{events}resets:
{resets}segments:
{segments}effects:
  feedback: {{set: {{K: 0}}}}
  coupling: {{set: {{c: 0}}}}
initial: {{mode: free}}
run:
  mesh: {{degree: 6, tol: 1.0e-6}}
  monitors: {{x1_max: max(x1)}}
  steps:
    - {{name: transient, simulate: {{t_end: 60*2*pi/omega}}}}
    - {{name: orbit, orbit: {{from: transient}}}}
    - {{name: branch, continue: {{from: orbit, free: [K], range: {{K: [0.09, 0.11]}}}}}}
"""


if __name__ == "__main__":
    print(chain(int(sys.argv[1])), end="")
