"""JSON Schema of a parameter file, from the same models that validate it; editors complete on it."""

from __future__ import annotations

from typing import Any

from handgen.parameters.model import Hand

DIALECT = "https://json-schema.org/draft/2020-12/schema"
EXTENDS = {
    "type": "string",
    "minLength": 1,
    "description": "parameter file that this one builds on, relative to this file: mappings are merged "
                   "key by key, lists and values replace, null removes",
}
PARTIAL = "_variant"


def json_schema() -> dict[str, Any]:
    """A whole file needs every key that has no default; one that `extends` another may leave any out."""
    whole = Hand.model_json_schema(by_alias=True, ref_template="#/$defs/{model}")
    definitions = whole.pop("$defs")
    title = whole.pop("title")
    definitions["Hand"] = whole
    variants = {f"{name}{PARTIAL}": _variant(schema) for name, schema in definitions.items()}
    variants[f"Hand{PARTIAL}"]["properties"]["extends"] = EXTENDS
    return {
        "$schema": DIALECT,
        "title": title,
        "type": "object",
        "if": {"required": ["extends"]},
        "then": {"$ref": f"#/$defs/Hand{PARTIAL}"},
        "else": {"$ref": "#/$defs/Hand"},
        "$defs": {**definitions, **variants},
    }


def _variant(definition: dict) -> dict:
    """The same mapping in a file that extends another: nothing is required, null removes a key.

    Lists replace, so their entries stay whole.
    """
    variant = {key: value for key, value in definition.items() if key != "required"}
    if "properties" in definition:
        variant["properties"] = {name: _removable(p) for name, p in definition["properties"].items()}
    return variant


def _removable(schema: dict) -> dict:
    """A property that may also be null and whose mapping may be incomplete."""
    schema = dict(schema)
    outside = {key: schema.pop(key) for key in ("description", "default", "title") if key in schema}
    choices = schema.pop("anyOf", None) or [schema]
    choices = [{"$ref": c["$ref"] + PARTIAL} if "$ref" in c else dict(c) for c in choices]
    for choice in choices:
        if isinstance(choice.get("additionalProperties"), dict):
            choice["additionalProperties"] = {"anyOf": [choice["additionalProperties"], {"type": "null"}]}
    if {"type": "null"} not in choices:
        choices.append({"type": "null"})
    return {**outside, "anyOf": choices}
