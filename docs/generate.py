"""Write docs/reference/ from the schemas of both file formats and from the commands: ``make reference``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from click.testing import CliRunner

from pddecont.cli import COMMANDS, group
from pddecont.data import read_entries
from pddecont.data.message_index import HOLE
from pddecont.steps.json_schema import make_schemas

FOLDER = Path(__file__).parent / "reference"
FORMULA = "number or expression"
MODEL_NOTE = """\
What `pddecont run` and `pddecont check` read as a model. The run block `run:` has the keys of a
[run file](run_file.md) but `model`. Expressions: numbers, declared names, `+ - * / **`, parentheses, `pi`, `t`, delayed
values `name(t - delay)`, rates `name'(t - delay)`, `integral(expression, s, low, high)` over lags s
([delays of every kind](../howto/delays.md)), and
`sin cos tan asin acos atan atan2 sinh cosh tanh exp log sqrt`; in models that give `equations` also
`sign heaviside abs max min clip deadzone where coulomb hysteresis mod square`
([what they are](../howto/equations.md)). Conditions (`when`): expressions compared with `> >= < <=`, joined by `and`,
`or`, `not`. A mapping takes names that you choose to what is
said."""
RUN_NOTE = """\
What `pddecont run` reads as a run. A number may be an expression in the parameters where the table says so. `from`
takes the name of a step, or a mapping to be more exact. A mapping takes names that you choose to what is said."""

MESSAGES_NOTE = """\
What the program says where something is wrong, or ends, or is worth knowing: why, and what to do. `...` stands for what
varies; often only the part by which a message can be told is listed. `pddecont explain "MESSAGE"` finds the entry of
a message that was printed:

```text
$ pddecont run model.yaml 2>&1 | pddecont explain
```"""

RUN_BLOCK = "A run without its model: what stands under ``run`` in a model file."
STEP = "One step of a run; exactly one of its kinds."


def pages() -> dict[str, str]:
    """Return the text of every generated page by the name of its file."""
    made = make_schemas()
    model, run = made["model.schema.json"], made["run.schema.json"]
    model["properties"]["run"] = {"description": RUN_BLOCK, "type": "run block"}
    join_steps(run)
    return {
        "model_file.md": file_page("Model file", MODEL_NOTE, model),
        "run_file.md": file_page("Run file", RUN_NOTE, run),
        "commands.md": commands_page(),
        "messages.md": messages_page(),
    }


def join_steps(run: dict[str, Any]) -> None:
    """Put one definition of a step in place of those of each kind, which differ in the kind's own key alone."""
    names = names_in(run["properties"]["steps"])
    kinds = [run["$defs"].pop(name) for name in names]
    keys = {key: value for kind in kinds for key, value in kind["properties"].items()}
    needed = [key for key in keys if all(key in kind["required"] for kind in kinds)]
    run["$defs"]["Step"] = {"description": STEP, "properties": keys, "required": needed}
    run["properties"]["steps"]["items"] = {"$ref": "#/$defs/Step"}


def file_page(name: str, note: str, schema: dict[str, Any]) -> str:
    """Return the page of a file format: its keys, then the keys of every mapping in it, in the order they are met."""
    definitions = schema.get("$defs", {})
    parts = [
        f"# {name}\n\nWritten from the schema by `make reference`.\n\n{note}\n\n## Top "
        f"level\n\n{table(schema, definitions)}"
    ]
    waiting, seen = names_in(schema["properties"]), set()
    while waiting:
        key = waiting.pop(0)
        if key not in seen:
            seen.add(key)
            parts.append(
                f"## {key}\n\n{ticked(definitions[key]['description'])}\n\n{table(definitions[key], definitions)}"
            )
            waiting = names_in(definitions[key].get("properties", {})) + waiting
    return "\n\n".join(parts) + "\n"


def table(schema: dict[str, Any], definitions: dict[str, Any]) -> str:
    """Return the keys of a mapping as a table: key, value, default, meaning."""
    needed = schema.get("required", [])
    lines = ["| Key | Value | Default | Meaning |", "|---|---|---|---|"]
    for key, value in schema.get("properties", {}).items():
        meaning = value.get("description") or next((definitions[n]["description"] for n in names_in(value)), "")
        default = "required" if key in needed else shown(value.get("default"))
        lines.append(f"| `{key}` | {kind(value)} | {default} | {ticked(meaning).rstrip('.').replace('|', ' or ')} |")
    if schema.get("additionalProperties") is True:
        lines.append(f"| any state | {FORMULA} | the model's | its value |")
    return "\n".join(lines)


def kind(schema: dict[str, Any]) -> str:
    """Return in words what value a schema asks for."""
    if "$ref" in schema:
        name = schema["$ref"].rsplit("/", 1)[1]
        return f"[{name}](#{name.lower()})"
    choice = schema.get("anyOf") or schema.get("oneOf")
    if choice:
        kinds = list(dict.fromkeys(kind(s) for s in choice if s.get("type") != "null"))
        joined = " or ".join(kinds)
        return joined.replace("number or text", FORMULA)
    if "enum" in schema:
        return ", ".join(f"`{v}`" for v in schema["enum"])
    if schema.get("type") == "array":
        return f"list of: {kind(schema.get('items', {}))}"
    if schema.get("type") == "object":
        inner = schema.get("additionalProperties")
        return f"mapping to: {kind(inner)}" if isinstance(inner, dict) else "mapping"
    words = {"string": "text", "integer": "whole number", "boolean": "true or false"}
    return words.get(schema.get("type", "any"), schema.get("type", "any")) + limits(schema)


def limits(schema: dict[str, Any]) -> str:
    """Return the bounds of a number."""
    signs = {"minimum": "&ge;", "exclusiveMinimum": ">", "maximum": "&le;", "exclusiveMaximum": "<"}
    found = [f"{sign} {schema[key]}" for key, sign in signs.items() if key in schema]
    return f", {', '.join(found)}" if found else ""


def names_in(schema: Any) -> list[str]:
    """Return the definitions that a schema refers to, in order."""
    if isinstance(schema, dict):
        own = [schema["$ref"].rsplit("/", 1)[1]] if isinstance(schema.get("$ref"), str) else []
        return own + [name for value in schema.values() for name in names_in(value)]
    return [name for value in schema for name in names_in(value)] if isinstance(schema, list) else []


def shown(default: Any) -> str:
    """Return a default as YAML would have it; nothing where leaving the key out means nothing."""
    words = {None: "", True: "`true`", False: "`false`"}
    return words[default] if default is None or isinstance(default, bool) else f"`{default}`"


def ticked(text: str) -> str:
    """Return a docstring's double backticks as Markdown's single ones."""
    return text.replace("``", "`").replace("\n", " ")


def commands_page() -> str:
    """Return the page of the command line: every command with all its options."""
    parts = ["# Commands\n\nWritten from the program's own help by `make reference`.", help_of()]
    parts += [f"## {name}\n\n{help_of(name)}" for name in COMMANDS]
    parts.append("""\
## Exit codes

| Code | Meaning |
|---|---|
| 0 | done |
| 1 | the model, run file or results file is wrong |
| 2 | wrong usage |
| 3 | a computation did not converge; what was computed before it is kept |
| 130 | interrupted; likewise kept |""")
    return "\n\n".join(parts) + "\n"


def messages_page() -> str:
    """Return the page of all messages: by subject what they say, why, and what to do."""
    parts = [f"# Messages\n\nWritten from the index of messages by `make reference`.\n\n{MESSAGES_NOTE}"]
    subject = ""
    for entry in read_entries():
        if entry.subject != subject:
            subject = entry.subject
            parts.append(f"## {subject}")
        says = "\n".join(f"- `{text.replace(HOLE, '...')}`" for text in entry.says)
        parts.append(f"{says}\n\n**Cause.** {entry.cause}\n\n**Cure.** {entry.cure}\n\n---")
    return "\n\n".join(parts) + "\n"


def help_of(*words: str) -> str:
    """Return what ``pddecont WORDS --help`` prints, 100 columns wide."""
    result = CliRunner().invoke(
        group, [*words, "--help"], prog_name="pddecont", terminal_width=100, max_content_width=100
    )
    return f"```text\n{result.output.rstrip()}\n```"


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for file, text in pages().items():
        (FOLDER / file).write_text(text)
