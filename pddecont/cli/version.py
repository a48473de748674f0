"""``pddecont --version``, and with ``--verbose`` what a report of a bug needs."""

from __future__ import annotations

import click


def show_version(context: click.Context, parameter: click.Parameter, asked: bool) -> None:
    """Write the version, with ``--verbose`` the platform and every library too, and end."""
    if not asked or context.resilient_parsing:
        return
    from pddecont.version import __version__

    click.echo(f"pddecont, version {__version__}")
    if context.params.get("verbose"):
        for name, value in describe_installation().items():
            click.echo(f"{name}: {value}")
    context.exit()


def describe_installation() -> dict[str, str]:
    """Return the platform and the version of each library, by name; nothing that says whose machine it is."""
    import platform

    import numpy as np

    blas = np.show_config(mode="dicts")["Build Dependencies"]["blas"]
    return {
        "python": f"{platform.python_version()} ({platform.python_implementation()}, {platform.python_compiler()})",
        "platform": platform.platform(),
        "machine": f"{platform.machine()}, {_count_cores()} cores to use",
        **find_versions(),
        "numpy's BLAS": f"{blas.get('name', '?')} {blas.get('version', '?')}",
    }


def find_versions() -> dict[str, str]:
    """Return the version of each library that this program names, or that it is not installed."""
    import re
    from importlib import metadata

    try:
        asked = metadata.requires("pddecont") or []
    except metadata.PackageNotFoundError:
        return {"libraries": "not known: pddecont runs without being installed"}
    versions = {}
    for name in dict.fromkeys(re.split(r"[^\w.-]", text, maxsplit=1)[0] for text in asked):
        try:
            versions[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            versions[name] = "not installed"
    return versions


def _count_cores() -> int:
    import os

    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
