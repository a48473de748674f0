"""The JSON Schemas of both file formats; ``python -m pddecont.steps.json_schema FOLDER`` writes them."""

from __future__ import annotations

import inspect
import json
import sys
from pathlib import Path
from typing import Any

from pddecont.bifurcation import list_kinds
from pddecont.equilibrium import CURVE_NAMES, NAMES
from pddecont.model import ModelFile
from pddecont.runfile import RunBlock, RunFile, make_run_types
from pddecont.steps.registry import BUILTIN

DIALECT = "https://json-schema.org/draft/2020-12/schema"


def make_schemas() -> dict[str, dict[str, Any]]:
    """Return each schema by the name of its file."""
    block_type, file_type = make_run_types(BUILTIN)
    model = ModelFile.model_json_schema(by_alias=True)
    block, run = block_type.model_json_schema(by_alias=True), file_type.model_json_schema(by_alias=True)
    for schema, title, describes in ((block, "RunBlock", RunBlock), (run, "RunFile", RunFile)):
        schema |= {"title": title, "description": inspect.getdoc(describes)}
        labels = list(dict.fromkeys([*(kind.label for kind in list_kinds()), *NAMES, *CURVE_NAMES]))
        detect = schema["$defs"]["Continue"]["properties"]["detect"]["anyOf"][0]
        detect["items"] = {"enum": labels, "type": "string"}
    # The run block of a model file has the run file's keys.
    model["$defs"] = {**model.get("$defs", {}), **block.pop("$defs", {})}
    model["properties"]["run"] = block
    return {"model.schema.json": model, "run.schema.json": run}


def format_schema(schema: dict[str, Any]) -> str:
    """Return a schema as the text of its file."""
    return json.dumps({"$schema": DIALECT, **schema}, indent=2) + "\n"


if __name__ == "__main__":
    for file, schema in make_schemas().items():
        (Path(sys.argv[1]) / file).write_text(format_schema(schema))
