"""What a materials library holds: substances, parameter sets, what tables print, and the corrections."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import Strict, model_validator

from handgen.materials import energies
from handgen.materials.energies.ogden import Convention
from handgen.materials.law import Law, law, ogden_law
from handgen.parameters.quantity import Model, item, quantity

MEGAPASCALS = {"Pa": 1e-6, "kPa": 1e-3, "MPa": 1.0, "GPa": 1e3, "psi": 6894.757293168361e-6}
"""Units of stress that constants and readings may be written in, in MPa."""
Unit = Literal["Pa", "kPa", "MPa", "GPa", "psi"]
Numbers = Annotated[tuple[float, ...], Strict(False)]
Texts = Annotated[tuple[str, ...], Strict(False)]


class Reading(Model):
    """One number of a manufacturer's bulletin that a law can be held against."""

    strain: float = quantity("-", 0, 20, "nominal strain; 0 for a tensile modulus at the start")
    stress: float = quantity("", 0, 1e9, "nominal stress at that strain, or the modulus, in `unit`")
    unit: Unit = item("unit of the stress")
    source: str = item("key of `sources`, or where exactly the number stands", min_length=1)
    note: str = item("what to keep in mind about it", default="")

    @property
    def megapascals(self) -> float:
        return self.stress * MEGAPASCALS[self.unit]


class Elastic(Model):
    """A stiff material that strains little: linear isotropic."""

    young: float = quantity("", 0, 1e12, "Young's modulus in `unit`")
    unit: Unit = item("unit of Young's modulus")
    poisson: float = quantity("-", 0, 0.4999, "Poisson's ratio")
    source: str = item("key of `sources`, or where exactly the numbers stand", min_length=1)

    @property
    def young_mpa(self) -> float:
        """Young's modulus, MPa."""
        return self.young * MEGAPASCALS[self.unit]


class Material(Model):
    """A substance by the name that parameter files use."""

    kind: Literal["silicone", "TPU", "PET"] = item("family")
    density: float = quantity("kg/m3", 500, 3000, "density of the substance itself")
    source: str = item("where the density comes from", min_length=1)
    readings: Annotated[tuple[Reading, ...], Strict(False)] = item("the bulletin's numbers", default=())
    elastic: Elastic | None = item("constants of a stiff material", default=None)
    notes: Texts = item("what to know before using it", default=())


class Printed(Model):
    """A set exactly as a table of the source prints it."""

    table: str = item("number of the table", min_length=1)
    unit: Unit = item("unit in the table's head")
    constants: dict[str, float | None] = item("symbol as printed: number; null where the table leaves it out")
    incompressibility: float | None = item("D of the source's solver, no part of the law", default=None)


class Correction(Model):
    """One difference between a table and what is used, with its reason."""

    what: str = item("`unit`, or the symbol of a constant", min_length=1)
    printed: float | str | None = item("as printed; null for left out")
    used: float | str = item("as used")
    why: str = item("the reason", min_length=1)


class ParameterSet(Model):
    """Constants of a law for a material, as corrected; `printed` keeps what the tables say."""

    material: str = item("key of `materials`")
    law: str = item("a file of handgen.materials.energies")
    convention: Convention | None = item("Ogden's convention; other laws have none", default=None)
    unit: Unit = item("unit of the constants")
    constants: dict[str, float | Numbers] = item("by the names of the law's CONSTANTS")
    density: float | None = quantity(
        "kg/m3", 500, 3000, "density this set was used with, where not the material's", default=None
    )
    tuned_from: str | None = item("set of the library whose constants a tuning started from", default=None)
    strain: Numbers = item("nominal strains [from, to] that the constants were fitted on; 1 is 100 %")
    source: str = item("key of `sources`")
    printed: Annotated[tuple[Printed, ...], Strict(False)] = item("as the tables print it", default=())
    corrections: Annotated[tuple[Correction, ...], Strict(False)] = item("printed -> used", default=())
    assumed: Texts = item("what no source says", default=())
    notes: Texts = item("what to know before using it", default=())

    @model_validator(mode="after")
    def _is_a_law(self) -> ParameterSet:
        if self.law not in energies.names():
            raise ValueError(f"there is no law {self.law!r}; there are {', '.join(energies.names())}")
        if (self.law == "ogden") != (self.convention is not None):
            raise ValueError("an Ogden set, and no other, names its convention")
        if len(self.strain) != 2 or not 0 <= self.strain[0] < self.strain[1]:
            raise ValueError("strain should be [from, to], rising, not negative")
        self.build()
        return self

    def build(self, convention: Convention | None = None) -> Law:
        """The law as corrected; an Ogden set can be misread in another `convention` on purpose.

        Raises:
            ValueError: a `convention` for a law that has none.
        """
        if convention and self.law != "ogden":
            raise ValueError(f"{self.law} has no convention to be misread in")
        return _build(self.law, self.constants, self.unit, convention or self.convention)

    @property
    def symbols(self) -> dict[str, float]:
        """The constants by the symbols of the source's tables: C_10, mu_1, alpha_1."""
        if self.law != "ogden":
            return {key.replace("c", "C_"): value for key, value in self.constants.items()}
        return {
            f"{key}_{k}": value
            for key in ("mu", "alpha")
            for k, value in enumerate(self.constants[key], start=1)
        }

    def as_printed(self, table: str) -> Law:
        """The law that the source's `table` prints, unit and all, in Table 5.1's convention "mu/alpha".

        Raises:
            ValueError: the set is not in that table, or the table leaves a constant out.
        """
        printed = next((p for p in self.printed if p.table == table), None)
        if printed is None:
            raise ValueError(f"Table {table} does not hold this set")
        given = printed.constants
        if missing := [s for s, used in self.symbols.items() if used and given.get(s) is None]:
            raise ValueError(f"Table {table} leaves out {', '.join(missing)}")
        numbers = {symbol: given.get(symbol, 0.0) for symbol in self.symbols}
        if self.law != "ogden":
            constants = {symbol.replace("C_", "c"): value for symbol, value in numbers.items()}
            return _build(self.law, constants, printed.unit, None)
        pairs = [[v for s, v in numbers.items() if s.startswith(key)] for key in ("mu", "alpha")]
        return _build("ogden", dict(zip(("mu", "alpha"), pairs, strict=True)), printed.unit, "mu/alpha")


class Library(Model):
    """library.yaml."""

    schema_: Literal["handgen.materials/1"] = item("format of the file", alias="schema")
    sources: dict[str, str] = item("where numbers come from, by key")
    materials: dict[str, Material] = item("substances by the name that parameter files use")
    sets: dict[str, ParameterSet] = item("parameter sets by name")


def _build(name: str, constants: Mapping, unit: Unit, convention: Convention | None) -> Law:
    scale = MEGAPASCALS[unit]
    if name != "ogden":
        if lists := [key for key, value in constants.items() if not isinstance(value, (int, float))]:
            raise ValueError(f"{name} takes one number as {', '.join(lists)}")
        return law(name, {key: scale * value for key, value in constants.items()})
    if set(constants) != {"mu", "alpha"} or any(isinstance(c, (int, float)) for c in constants.values()):
        raise ValueError("an Ogden set has a list of mu and a list of alpha")
    return ogden_law([scale * mu for mu in constants["mu"]], constants["alpha"], convention)
