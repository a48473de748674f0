# %% [markdown]
# # From rest to oscillation
#
# Wright's equation `x' = -K x(t - 1) (1 + x)` rests at `x = 0` while `K < pi/2`, and oscillates beyond. Every
# equilibrium in a box is found and proved to be there; the one at zero is followed through its Hopf point, and from
# there the orbits that are born.

# %%
import math

import pddecont

model = {"name": "wright", "states": ["x"], "parameters": {"K": 1.2}, "modes": {"only": {"x'": "-K*x(t - 1)*(1 + x)"}}}
results = pddecont.run(
    model,
    steps=[
        {"name": "rest", "equilibrium": {"search": {"x": [-2, 2]}}},
        {"name": "line", "continue": {"from": {"step": "rest", "point": "EQ2"}, "free": ["K"], "range": {"K": [1, 2]}}},
        {
            "name": "born",
            "continue": {
                "from": {"step": "line", "point": "HB1"},
                "branch": "switch",
                "free": ["K"],
                "range": {"K": [1.5, 2]},
                "stability": True,
            },
        },
    ],
    monitors={"top": "max(x)", "bottom": "min(x)"},
)
results["rest"]

# %% [markdown]
# The Hopf point lies at `K = pi/2`, where a pair of characteristic roots is `+-i pi/2`:

# %%
hopf = results["line"].point("HB1")
hopf

# %%
hopf.parameters["K"] - math.pi / 2, hopf.spectrum[:2]

# %% [markdown]
# The orbits that are born there are stable; their period begins at `2 pi/(pi/2) = 4`.

# %%
results["born"]

# %%
results.plot(steps=["born"], y="period")
