"""What pyproject.toml cannot say: how compiled parts are made, and what an index shows of the README."""

import importlib.util
import re
import sys
from pathlib import Path

from setuptools import Extension, setup

NATIVE = Path("pddecont") / "native"
PARTS = ("integrator", "assembly")
# Sums and products are rounded one by one, as Python does it, on every processor.
FLAGS = ["-O3", "-ffp-contract=off"]


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


def describe(readme):
    """Return a README without what leads into the repository: pictures, and links but for their words.

    Of pictures in tables their words stay.

    The pages go with the source archive; nowhere on the web do they have an address that a link could name.
    """
    text = re.sub(r"^!\[[^]]*\]\((?!\w+:)[^)]*\)\n\n?", "", readme, flags=re.M)
    text = re.sub(r"!\[([^]]*)\]\((?!\w+:)[^)]*\)", r"\1", text)
    return re.sub(r"\[([^]]+)\]\((?!\w+:)[^)]*\)", r"\1", text)


setup(
    ext_modules=[make_extension(part) for part in PARTS],
    long_description=describe(Path("README.md").read_text(encoding="utf-8")),
    long_description_content_type="text/markdown",
)
