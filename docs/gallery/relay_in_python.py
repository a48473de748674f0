# %% [markdown]
# # A relay, from a mapping to a data frame
#
# A model may be a mapping with the keys of a [model file](../reference/model_file.md), so that nothing has to be on
# disk. This relay switches when the value a time `tau` ago passes zero, and what it pulls grows by itself: `x' = a x
# - 1` or `a x + 1`.

# %%
import numpy as np

import pddecont

relay = {
    "name": "relay",
    "states": ["x"],
    "parameters": {"a": 0.5, "tau": 1},
    "units": {"x": "mm", "t": "s", "a": "1/s", "tau": "s"},
    "modes": {"pull": {"x'": "a*x - 1"}, "push": {"x'": "a*x + 1"}},
    "events": {"switch": "x(t - tau)"},
    "segments": {
        "pull": {"mode": "pull", "event": "switch", "direction": "falling", "to": "push"},
        "push": {"mode": "push", "event": "switch", "direction": "rising", "to": "pull"},
    },
    "initial": {"mode": "pull", "x": 0.1},
}

# %% [markdown]
# A run is a list of steps: simulate, find the periodic orbit that the motion comes to, follow it as `a` changes.

# %%
results = pddecont.run(
    relay,
    steps=[
        {"name": "transient", "simulate": {"t_end": 60}},
        {"name": "orbit", "orbit": {"from": "transient"}},
        {"name": "branch", "continue": {"from": "orbit", "free": ["a"], "range": {"a": [0.3, 0.65]}}},
    ],
    monitors={"top": "max(x)"},
)
results

# %% [markdown]
# After `x` passes zero it goes on for the time `tau`, so that its highest value is `(exp(a tau) - 1)/a`. The branch
# says the same:

# %%
branch = results["branch"].arrays()
exact = np.expm1(branch["a"]) / branch["a"]
float(np.max(np.abs(branch["top"] / exact - 1)))

# %% [markdown]
# One orbit of the branch, and the whole branch as a data frame of pandas; units, and what each column means, are in
# its `attrs`.

# %%
results["branch"].orbit("EP2")

# %%
frame = results["branch"].to_pandas()
frame[["a", "top", "period", "stable", "error_estimate"]].head()

# %%
frame.attrs["units"]
