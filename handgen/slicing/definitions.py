"""Cura's definitions of its settings, and their formulas worked out.

CuraEngine reads the definitions but none of the formulas (`value`) in them: told only `speed_print`, it
prints walls at its default. Cura's window works them out before it calls the engine; so does this.
"""

from __future__ import annotations

import ast
import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from handgen.errors import EngineError

RESOURCES = Path("/usr/share/cura/resources")
"""Where Debian's `cura` puts them."""
PLAIN = {"abs": abs, "all": all, "any": any, "bool": bool, "float": float, "int": int, "len": len, "map": map,
         "max": max, "min": min, "round": round, "str": str, "sum": sum, "math": math}
"""What a formula may call, beside the settings of the one extruder."""


class Definitions:
    """All settings of a machine with one extruder: its definition and what that inherits."""

    def __init__(self, machine: str, extruder: str, resources: Path = RESOURCES):
        self.machine, self.resources = machine, resources
        self.settings: dict[str, dict[str, Any]] = {}
        for folder, name in (("definitions", machine), ("extruders", extruder)):
            for file in self._chain(folder, name):
                _collect(file.get("settings", {}), self.settings)
                for key, facts in file.get("overrides", {}).items():
                    self.settings.setdefault(key, {}).update(facts)

    def _chain(self, folder: str, name: str) -> list[dict]:
        """The file and what it inherits, the most general first."""
        for place in (folder, "definitions"):
            path = self.resources / place / f"{name}.def.json"
            if path.is_file():
                break
        else:
            raise EngineError(f"Cura's definition {name}.def.json is missing in {self.resources}; "
                              "on Debian: apt install cura")
        found = json.loads(path.read_text(encoding="utf-8"))
        base = found.get("inherits")
        return [*(self._chain(folder, base) if base else ()), found]

    @property
    def search_path(self) -> str:
        """For CuraEngine, which looks for inherited files there."""
        return f"{self.resources / 'definitions'}:{self.resources / 'extruders'}"

    def resolve(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """Every setting's value when `given` are set by hand and all others follow.

        Raises:
            EngineError: a given setting that these definitions do not know, or a formula that cannot be
                worked out.
        """
        unknown = sorted(given.keys() - self.settings.keys())
        if unknown:
            raise EngineError(f"Cura's {self.machine} knows no {', '.join(unknown)}")
        return _Resolution(self.settings, given).all()


class _Resolution:
    def __init__(self, settings: Mapping[str, dict], given: Mapping[str, Any]):
        self.settings = settings
        self.values = dict(given)
        self.open: list[str] = []
        self.functions = PLAIN | {
            "extruderValue": lambda number, key: self.value(key),
            "extruderValues": lambda key: [self.value(key)],
            "extruderValueFromContainer": lambda number, key, container: self.value(key),
            "valueFromContainer": lambda key, container: self.value(key),
            "resolveOrValue": self.value,
            "defaultExtruderPosition": lambda: "0",
            "anyExtruderWithMaterial": lambda key: "0",
            "anyExtruderNrWithOrDefault": lambda key: "0",
        }

    def all(self) -> dict[str, Any]:
        return {key: self.value(key) for key in self.settings}

    def value(self, key: str) -> Any:
        """The value of one setting, after those that its formula names."""
        if key not in self.values:
            facts = self.settings[key]
            formula = facts.get("value")
            if not isinstance(formula, str):
                self.values[key] = facts.get("default_value") if formula is None else formula
                return self.values[key]
            if key in self.open:
                raise EngineError(f"Cura's formulas go in a circle: {' -> '.join([*self.open, key])}")
            self.open.append(key)
            self.values[key] = self._work_out(key, formula)
            self.open.pop()
        return self.values[key]

    def _work_out(self, key: str, formula: str) -> Any:
        try:
            tree = ast.parse(formula.strip(), mode="eval")
            names = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
            known = {name: self.value(name) for name in names & self.settings.keys()}
            return eval(compile(tree, key, "eval"), {"__builtins__": {}, **self.functions, **known})
        except EngineError:
            raise
        except Exception as error:
            raise EngineError(f"Cura's formula for {key}, {formula!r}: {error}") from error


def _collect(settings: Mapping[str, dict], found: dict[str, dict]) -> None:
    """Settings of all categories and levels into one mapping."""
    for key, facts in settings.items():
        if facts.get("type") != "category":
            found[key] = {k: v for k, v in facts.items() if k != "children"}
        _collect(facts.get("children", {}), found)
