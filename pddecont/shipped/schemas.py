"""The JSON Schemas of both file formats; ``python -m pddecont.shipped.schemas`` writes them beside this file."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from pddecont.model.schema import ModelFile
from pddecont.steps.schema import RunBlock, RunFile


def schemas() -> dict[str, dict[str, Any]]:
    """Return each schema by the name of its file."""
    model = ModelFile.model_json_schema(by_alias=True)
    run = RunBlock.model_json_schema(by_alias=True)
    # The run block of a model file has the run file's keys.
    definitions = {**model.get("$defs", {}), **run.pop("$defs", {})}
    model["properties"]["run"] = run
    model["$defs"] = definitions
    return {"model.schema.json": model, "run.schema.json": RunFile.model_json_schema(by_alias=True)}


def text_of(schema: dict[str, Any]) -> str:
    """Return a schema as the text of its file."""
    return json.dumps({"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}, indent=2) + "\n"


if __name__ == "__main__":
    for name, schema in schemas().items():
        Path(__file__).with_name(name).write_text(text_of(schema))
