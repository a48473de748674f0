# %% [markdown]
# # Impacts and a delay
#
# A shipped model: a forced oscillator hits an elastic wall, and is steered by its velocity some time before ([the
# models](../models.md)). Its own run follows an orbit with one impact as the delay `tau_d` changes.

# %%
import numpy as np

import pddecont

results = pddecont.run("impact_oscillator")
results["in_delay"]

# %% [markdown]
# At `GR1` the orbit touches the wall inside a segment. Vertical lines are the events.

# %%
grazing = results["in_delay"].orbit("GR1")
grazing

# %% [markdown]
# The monitor `h_GR`, an extremum of the distance from the wall, is zero there. The special points of the branch:

# %%
special = results["in_delay"].to_pandas("special")
special[["label", "tau_d", "period", "contact_time", "h_GR", "note"]]

# %% [markdown]
# The same without the control, as `--without feedback` does on the command line. Two multipliers are left, and all
# that takes energy is the damping: their modulus is `exp(-zeta T)`.

# %%
plain = pddecont.run("impact_oscillator", without=["feedback"], until="orbit")
point = plain["orbit"].point()
abs(point.spectrum) - np.exp(-point.parameters["zeta"] * point.values["period"])

# %% [markdown]
# Pictures are matplotlib figures, or files of a size for print: `results.plot("branch.pdf", size="85mm")`. The page
# with all of this to explore is one line too: `results.report("page.html")`.

# %%
results.plot(view="orbit", labels=["GR1"])
