"""Explorations in words and as tables: the branches, how each ended, and what lies on none of them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from pddecont.reasons import Reason
from pddecont.results import Step
from pddecont.tables.branch_endings import BRANCH_ENDS

Row = dict[str, Any]
# What becomes of a lead, and what a motion that was looked at looks like.
OF_LEADS = ("followed", "repeated", "failed", "left")
ON_TORUS = "on_torus"
# Denominators of locked rotation numbers that are told.
MAX_DENOMINATOR = 256
LOOKS = {
    "periodic": "periodic",
    "rest": "at rest",
    "irregular": "without a period that was found",
    "unsettled": "not settled in the time that it was given",
    "chaos": "chaotic: its largest Lyapunov exponent is positive",
    "torus": "on a torus: without period, its largest Lyapunov exponent is zero",
    "away": "going away without bound",
    "halted": "halted",
}
# What is said of a motion that lies on a branch which is not known to be stable there.
NOT_STABLE = {
    "no": "as if on {}, which is not stable there",
    "unknown": "as if on {}, of which it is not known whether it is stable there",
}
# Motions of one look whose places are said.
MAX_PLACES = 8
STOPS = {
    "time": "the time was over: --resume goes on",
    "max_branches": "as many branches as allowed were begun: --resume with more goes on",
    "depth": "beyond 'depth'",
}


def list_branches(step: Step) -> list[Row]:
    """Return one row a branch of an exploration, and one a lead that led to none, in order of discovery."""
    rows = []
    for i in range(len(step)):
        reason = step.reason(i)
        if reason.code not in OF_LEADS:
            continue
        v = reason.values
        row: Row = {"branch": v.get("step", ""), "from": v["origin"], "depth": v["depth"], "curve": v.get("curve", "")}
        row |= {"low": v.get("low"), "high": v.get("high"), "points": v.get("n_points"), "stable": v.get("n_stable")}
        row |= {"special": v.get("special", ""), "images": v.get("images", ""), "outcome": describe_lead(reason)}
        rows.append(row)
    return rows


def list_motions(step: Step) -> list[Row]:
    """Return one row a motion that was compared with the branches, with the branch that it lies on."""
    rows = []
    for i in range(len(step)):
        reason = step.reason(i)
        if reason.code in (*OF_LEADS, ON_TORUS):
            continue
        v, p = reason.values, step.points
        row: Row = {"label": step.labels[i]}
        row |= {name: float(x) for name, x in zip(step.meta["parameters"], p["parameters"][i], strict=True)}
        row |= {
            "branch": v.get("branch", "") if reason.code != "unexplained" else "",
            "motion": v.get("motion", ""),
            "look": LOOKS.get(str(v["look"]), str(v["look"])),
        }
        row |= {"period": float(p["period"][i]), "lyapunov": float(p["lyapunov"][i])}
        row |= {"lyapunov_error": float(p["lyapunov_error"][i])}
        for name, low, high in zip(step.meta["states"], p["lowest"][i], p["highest"][i], strict=True):
            row |= {f"lowest_{name}": float(low), f"highest_{name}": float(high)}
        note = NOT_STABLE[str(v["stable"])].format(v["branch"]) if "stable" in v else ""
        row |= {"image": str(v.get("way", "")), "beside": str(v["branch"]) if "stable" in v else ""}
        rows.append({**row, "found": f"{v['sweep']} {v['point']}".strip(), "note": note or str(v.get("detail", ""))})
    return rows


def list_unexplained(step: Step) -> list[Row]:
    """Return the rows of :func:`list_motions` that settle, and lie on no branch."""
    return [row for row in list_motions(step) if row["label"]]


def list_tori(step: Step) -> list[Row]:
    """Return one row a value of the parameter to which a torus was followed: what it has become there.

    The rotation number lies between 0 and 1/2; of a torus that is locked to a period it is a fraction.
    """
    rows = []
    for i in range(len(step)):
        reason = step.reason(i)
        if reason.code != ON_TORUS:
            continue
        v, p = reason.values, step.points
        row: Row = {"torus": str(v["sweep"]), "from": str(v["origin"])}
        row |= {name: float(x) for name, x in zip(step.meta["parameters"], p["parameters"][i], strict=True)}
        rotation = float(v.get("rotation", np.nan))
        locked = str(v["look"]) == "periodic" and np.isfinite(rotation)
        row |= {"look": LOOKS.get(str(v["look"]), str(v["look"])), "rotation": rotation}
        row |= {"rotation_error": float(v.get("rotation_error", np.nan))}
        row |= {"locked": str(Fraction(rotation).limit_denominator(MAX_DENOMINATOR)) if locked else ""}
        row |= {"period": float(p["period"][i]), "lyapunov": float(p["lyapunov"][i])}
        rows.append({**row, "lyapunov_error": float(p["lyapunov_error"][i]), "point": str(v["point"])})
    return rows


def name_settled(reason: Reason) -> str:
    """Return in a few words what a motion at a place of the plane settled to."""
    motion = str(reason.values.get("motion", ""))
    return LOOKS.get(motion, motion).partition(":")[0]


def describe_lead(reason: Reason) -> str:
    """Return what became of a lead: how its branch ended, or why there is none."""
    v = reason.values
    match reason.code:
        case "followed":
            ends = [
                f"{way}: {BRANCH_ENDS.get(str(v[way]), (str(v[way]), ''))[0]}" for way in ("down", "up") if way in v
            ]
            return "; ".join(ends)
        case "repeated":
            return f"the same as {v['same']}"
        case "failed":
            return f"not followed: {v['why']}"
        case _:
            return f"left: {STOPS.get(str(v['why']), str(v['why']))}"


def describe_exploration(step: Step, ending: Reason) -> str:
    """Return what an exploration came to, in a sentence."""
    v = ending.values
    curves = f", {v['n_curves']} curves" if v["n_curves"] else ""
    text = f"{v['n_branches']} branches{curves}; {v['n_explained']} of {v['n_motions']} motions that settle lie on them"
    looks = Counter(str(step.reason(i).values["look"]) for i in range(len(step)) if step.labels[i])
    if looks:
        counts = ", ".join(f"{n} {LOOKS.get(look, look).partition(':')[0]}" for look, n in looks.items())
        text += f", not explained: {counts}"
    for key, what in (("n_failed", "could not be followed"), ("n_left", "were left")):
        text += f"; {v[key]} {what}" if v[key] else ""
    text += f"; {v['n_halted']} motions do not settle" if v["n_halted"] else ""
    return text + (f"; {STOPS[str(v['stopped'])]}" if v["stopped"] else "")


def describe_exploration_lines(step: Step) -> list[str]:
    """Return an exploration in a sentence a branch, and one a kind of motion that lies on none."""
    (name, *_) = step.meta["free"]
    lines, left = [], Counter[str]()
    for row in list_branches(step):
        if row["points"] is None:
            if row["branch"]:
                lines.append(f"{row['branch']}, from {row['from']}: {row['outcome']}")
            else:
                left[row["outcome"]] += 1
            continue
        special = f"; {row['special']}" if row["special"] else ""
        if row["curve"]:
            where = f"curve of {row['curve']} points, {name} {row['low']:.6g} to {row['high']:.6g}"
            lines.append(f"{row['branch']}, from {row['from']}: {where}{special}; {row['outcome']}")
            continue
        where = f"{name} {row['low']:.6g} to {row['high']:.6g}, {row['stable']} of {row['points']} points stable"
        images = f"; and its images by {row['images']}" if row["images"] else ""
        lines.append(f"{row['branch']}, from {row['from']}: {where}{special}{images}; {row['outcome']}")
    lines += [f"{n} more to follow were {outcome}" for outcome, n in left.items()]
    if not left and any(ending.values["stopped"] == "time" for ending in step.endings):
        lines.append(STOPS["time"])
    lines += [f"curves meet at {' = '.join(points)}" for points in step.meta.get("meetings", ())]
    tori: dict[str, list[Row]] = {}
    for row in list_tori(step):
        tori.setdefault(f"{row['torus']}, from {row['from']}", []).append(row)
    lines += [_describe_torus(name, torus, rows) for torus, rows in tori.items()]
    alike: dict[str, list[Row]] = {}
    for row in list_unexplained(step):
        alike.setdefault(f"{row['look']}, {row['note']}" if row["beside"] else row["look"], []).append(row)
    lines += [_describe_alike(step, look, rows) for look, rows in alike.items()]
    return lines


def _describe_torus(name: str, torus: str, rows: Sequence[Row]) -> str:
    """Return what became of a torus over a parameter of this name."""
    values = [row[name] for row in rows]
    rotations = [row["rotation"] for row in rows if np.isfinite(row["rotation"]) and not row["locked"]]
    looks = Counter(row["look"].partition(":")[0] for row in rows)
    counts = ", ".join(f"{n} {look}" for look, n in looks.items())
    text = f"{torus}: {name} {min(values):.6g} to {max(values):.6g}, {counts}"
    if rotations:
        text += f"; rotation number {min(rotations):.6g} to {max(rotations):.6g}"
    locked = list(dict.fromkeys(row["locked"] for row in rows if row["locked"]))
    return f"{text}; locked to {', '.join(locked)}" if locked else text


def _describe_alike(step: Step, look: str, rows: Sequence[Row]) -> str:
    """Return what motions look like that lie on no branch, where they are, and their exponents."""
    places = []
    for row in rows[:MAX_PLACES]:
        where = ", ".join(f"{key} = {row[key]:.6g}" for key in step.meta["free"])
        exponent = f", exponent {row['lyapunov']:.3g}" if np.isfinite(row["lyapunov"]) else ""
        places.append(f"{row['label']} ({where}{exponent})")
    more = f" and {len(rows) - MAX_PLACES} more" if len(rows) > MAX_PLACES else ""
    return f"on no branch, {look}: {', '.join(places)}{more}"
