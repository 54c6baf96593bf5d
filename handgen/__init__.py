"""handgen: from one parameter file to a soft pneumatic hand that can be printed, cast and assembled.

In a notebook or a CAD viewer:

    import handgen
    parts = handgen.parts("params/adult.yaml")
    show_object(parts["exoskeleton/index"])

`load` gives the validated definition, `parts` its parts by name (a `Part` has `.mesh`, `.solid`
and shows itself in CQ-editor and ocp-vscode), `check` judges them, `build` writes them all, `bend`
says how a finger moves, `measure_stl` what there is to know of any STL. They are imported when first used, so
that the command line starts at once.
"""

from importlib import import_module

__version__ = "0.1.0"
__all__ = ["bend", "build", "check", "load", "measure_stl", "parts"]

_HOMES = {
    "load": "handgen.parameters.load",
    "parts": "handgen.geometry.catalogue",
    "build": "handgen.builder",
    "check": "handgen.builder",
    "bend": "handgen.bending",
    "measure_stl": "handgen.checks.mesh_report",
}


def __getattr__(name: str):
    if name in _HOMES:
        return getattr(import_module(_HOMES[name]), name)
    raise AttributeError(f"module 'handgen' has no attribute {name!r}")
