"""What griffe, which reads the code for docs/reference/python_api.md, must be told of this package.

The names that a folder's door (``__init__.pyi``) lists are its public names. Constants are documented by the comment
above them. Names that docstrings mark as Sphinx does (``:func:`` before a name) are code.
"""

from __future__ import annotations

import itertools
import re
from typing import Any

import griffe

ROLE = re.compile(r":(?:func|class|meth|data):`~?([^`]*)`")


class Doors(griffe.Extension):
    """Makes the names of doors public."""

    def on_object(self, *, obj: griffe.Object, **_: Any) -> None:
        """Take the marks out of a docstring."""
        if obj.is_attribute and obj.docstring is None and obj.parent is not None and obj.parent.is_module:
            obj.docstring = read_comment(obj)
        if obj.docstring is not None:
            obj.docstring.value = ROLE.sub(r"`\1`", obj.docstring.value)

    def on_package(self, *, pkg: griffe.Module, **_: Any) -> None:
        """Export what the door of each folder names, in its order."""
        for folder in list_folders(pkg):
            folder.exports = [name for name, path in folder.imports.items() if path.startswith(f"{folder.path}.")]


def read_comment(constant: griffe.Object) -> griffe.Docstring | None:
    """Return the comment above a constant; one may stand above several."""
    lines = constant.module.source.splitlines()[: (constant.lineno or 1) - 1]
    code = list(itertools.takewhile(lambda line: line.strip() and not line.startswith("#"), reversed(lines)))
    above = lines[: len(lines) - len(code)]
    comment = list(itertools.takewhile(lambda line: line.startswith("# "), reversed(above)))
    text = " ".join(line[2:] for line in reversed(comment))
    return griffe.Docstring(text, parent=constant) if text else None


def list_folders(folder: griffe.Module) -> list[griffe.Module]:
    """Return a folder of the package and all folders in it."""
    inner = [module for module in folder.modules.values() if not module.is_alias and module.is_init_module]
    return [folder, *(found for module in inner for found in list_folders(module))]
