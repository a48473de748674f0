"""Write the model of delayed logistic growth that spreads by diffusion, in cells side by side.

``python models/diffusive_logistic.py 200 > diffusive_logistic_200.yaml``

The equation u_t = d u_xx + r u (1 - u(t - 1)) on 0 < x < 1, nothing passing the ends, by second differences. Where all
cells are alike they do what one does, and a perturbation in the shape of a mode of the Laplacian stays in that mode:
each has multipliers of its own, those of an equation of two states.
"""

import sys

DIFFUSION = 0.002


def diffusive_logistic(n: int) -> str:
    """Return the model of ``n`` cells, one state each, as YAML."""
    cells = [f"u{i}" for i in range(1, n + 1)]
    neighbours = zip(cells[:1] + cells[:-1], cells, cells[1:] + cells[-1:], strict=True)
    rates = "".join(
        f"    {u}': D*({left} - 2*{u} + {right}) + r*{u}*(1 - {u}(t - 1))\n" for left, u, right in neighbours
    )
    return f"""name: diffusive_logistic_{n}
reference: "the equation of Hutchinson, Ann. N. Y. Acad. Sci. 50 (1948) 221-246, with diffusion"
states: [{", ".join(cells)}]
parameters: {{r: 1.8, D: {DIFFUSION * n**2!r}}}
modes:
  growth:
{rates}initial: {{{", ".join(f"{u}: 1.2" for u in cells)}}}
"""


if __name__ == "__main__":
    print(diffusive_logistic(int(sys.argv[1])), end="")
