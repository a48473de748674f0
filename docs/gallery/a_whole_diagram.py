# %% [markdown]
# # A whole diagram
#
# `pddecont.explore` finds what there is by itself: motions from many starts, the equilibria of a box, every branch
# that goes through them, and what branches off. Here a pitchfork with a small imperfection `e` breaks in two.

# %%
import pddecont

e = 0.05
model = {
    "name": "imperfect_pitchfork",
    "states": ["x"],
    "parameters": {"a": 1, "e": e},
    "modes": {"only": {"x'": "a*x - x**3 + e"}},
}
results = pddecont.explore(model, {"a": [-1, 1.5]}, starts=8, check=8)
results["explore"]

# %% [markdown]
# The fold of the lower branch has a closed form: `3 x**2 = a` and `a x - x**3 + e = 0`, so that `x = -(e/2)**(1/3)`.

# %%
fold = results["branch_2"].point("LP1")
fold

# %%
fold.state["x"] + (e / 2) ** (1 / 3)

# %% [markdown]
# All branches in one picture, and as a table:

# %%
results.plot()

# %%
results["explore"].to_pandas("branches")
