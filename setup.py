"""What pyproject.toml cannot say: how the parts that are compiled are made of their sources."""

import importlib.util
import sys
from pathlib import Path

from setuptools import Extension, setup

NATIVE = Path("pddecont") / "native"
PARTS = ("integrator", "assembly")
# Sums and products are rounded one by one, as Python does it, on every processor.
FLAGS = ["-O2", "-ffp-contract=off"]


def make_extension(part):
    """Return the extension module of a folder of sources; their text for Cython is written first."""
    spec = importlib.util.spec_from_file_location("unite", NATIVE / "unite.py")
    unite = importlib.util.module_from_spec(spec)
    sys.modules["unite"] = unite
    spec.loader.exec_module(unite)
    written = Path("build") / "native" / f"compiled_{part}.pyx"
    written.parent.mkdir(parents=True, exist_ok=True)
    written.write_text(unite.unite(NATIVE / part, f"pddecont.native.{part}"), encoding="utf-8")
    return Extension(f"pddecont.native.compiled_{part}", [str(written)], extra_compile_args=FLAGS)


setup(ext_modules=[make_extension(part) for part in PARTS])
