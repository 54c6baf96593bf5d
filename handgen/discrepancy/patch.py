"""What was found, as a model file that `handgen bend --model` takes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from handgen import atomic
from handgen.bending.model import BendModel, Choice
from handgen.discrepancy.nuisance import STIFFNESS
from handgen.discrepancy.refit import Fitted
from handgen.effects import catalogue

NOTICEABLE = 0.01
"""Share by which a stiffness must have moved to be written as a set of its own."""
STRESSES = ("mu",)
"""Constants of an Ogden law that are stresses; its exponents are none."""


def write(
    path: Path,
    model: BendModel,
    fitted: Fitted,
    materials: Mapping[str, str],
    *,
    head: Sequence[str],
    tests: Sequence[str],
) -> None:
    """Write `model` with what was fitted, beside and renamed.

    `materials`: body -> material; `head`: lines of the comment above; `tests`: ids that it was fitted on.
    """
    import yaml

    data = document(model, fitted, materials, tests)
    text = "".join(f"# {line}\n" for line in head) + yaml.safe_dump(
        data, sort_keys=False, allow_unicode=True, width=110
    )
    atomic.write(path, text)


def document(
    model: BendModel, fitted: Fitted, materials: Mapping[str, str], tests: Sequence[str]
) -> dict[str, Any]:
    """The model file's data."""
    data = model.model_dump(mode="json", by_alias=True, exclude_none=True)
    data["name"] = f"{model.name}-diagnosed"[:64]
    data["description"] = f"{model.name}, as the diagnosis of {', '.join(tests)} left it"[:400]
    stiffness = {body: float(np.exp(fitted.nuisances().get(f"stiffness {body}", 0.0))) for body in STIFFNESS}
    factors = {materials[body]: factor for body, factor in stiffness.items() if body in materials}
    data["materials"] = {
        name: _material(choice, factors.get(name, 1.0)) for name, choice in model.materials.items()
    }
    data["effects"] = [one.model_dump() for one in model.effects] + [
        {"id": name, "parameters": {key: _short(value) for key, value in values.items()}}
        for name, values in fitted.effects().items()
    ]
    data["fitted"] = sorted({*model.fitted, *tests})
    data["assumed"] = {**model.assumed, **_uncertain(fitted, factors, materials)}
    data.setdefault("sources", {})
    return data


def _uncertain(fitted: Fitted, factors: Mapping[str, float], materials: Mapping[str, str]) -> dict[str, str]:
    """Of each number: what it is worth."""
    found = {}
    for name, values in fitted.effects().items():
        units = {p.name: p.unit for p in catalogue()[name].parameters}
        for key, value in values.items():
            sigma = fitted.sigma(name, key)
            unit = "" if units[key] == "1" else f" {units[key]}"
            found[f"effects.{name}.{key}"] = (
                f"{_short(value)}{unit}, standard deviation {_short(sigma)}; fitted"
            )
    for body, material in materials.items():
        if abs(factors.get(material, 1.0) - 1) > NOTICEABLE:
            sigma = fitted.sigma(None, f"stiffness {body}")
            found[f"materials.{material}"] = (
                f"stresses {factors[material]:.3f} times the set's, standard deviation {100 * sigma:.0f} %; "
                f"fitted"
            )
    return found


def _material(choice: Choice, factor: float) -> str | dict[str, Any]:
    """The library's name, or a set of its own whose stresses are `factor` times as large."""
    named = not choice.name.startswith("materials.")
    if named and abs(factor - 1) <= NOTICEABLE:
        return choice.name
    parameters = choice.parameters
    data = parameters.model_dump(
        mode="json", exclude_none=True, exclude={"material", "printed", "corrections", "tuned_from"}
    )
    data["constants"] = {
        name: value if parameters.law == "ogden" and name not in STRESSES else _times(value, factor)
        for name, value in data["constants"].items()
    }
    return data


def _times(value: float | list[float], factor: float) -> float | list[float]:
    return [_short(factor * one) for one in value] if isinstance(value, list) else _short(factor * value)


def _short(value: float) -> float:
    return float(f"{value:.5g}")
