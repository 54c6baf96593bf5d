"""STEP files (AP214, mm) with names and colours, the same bytes every time.

OCCT's XCAF writer carries the names, but leaves traces of the run: the time, a counter that lives
as long as the process, and colours in the order of memory addresses. The first two are rewritten;
the colours are left to `_styles`, which appends the same entities in the order of the bodies.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

from handgen.errors import EngineError

if TYPE_CHECKING:
    import cadquery

    Colour = tuple[float, float, float]
    Body = tuple[str, cadquery.Shape, Colour]

FILE_NAME = re.compile(rb"FILE_NAME\(.*?\);\r?\n", re.DOTALL)
OCCURRENCE = re.compile(rb"(NEXT_ASSEMBLY_USAGE_OCCURRENCE\(')\d+(')")
BREP = re.compile(rb"^#(\d+) = (?:MANIFOLD_SOLID_BREP|BREP_WITH_VOIDS)\(", re.MULTILINE)
REPRESENTATION = re.compile(
    rb"ADVANCED_BREP_SHAPE_REPRESENTATION\('[^']*',\s*\(([#\d,\s]*)\),\s*#(\d+)\);")
LAST = re.compile(rb"^#(\d+) = ", re.MULTILINE)
END = b"ENDSEC;\nEND-ISO-10303-21;"


def write(path: Path, name: str, bodies: list[Body]) -> None:
    """Write `bodies` (name, solid, sRGB 0..1) to `path`: one product, or an assembly of several.

    Raises:
        EngineError: OCCT's writer gave up.
    """
    from OCP.Interface import Interface_Static
    from OCP.STEPCAFControl import STEPCAFControl_Writer
    from OCP.STEPControl import STEPControl_StepModelType

    document = _document(name, bodies)
    writer = STEPCAFControl_Writer()
    writer.SetColorMode(False)
    writer.SetNameMode(True)
    for key in ("xstep.cascade.unit", "write.step.unit"):
        Interface_Static.SetCVal_s(key, "MM")
    done = writer.Transfer(document, STEPControl_StepModelType.STEPControl_AsIs)
    if not done or int(writer.Write(str(path))) != 1:
        raise EngineError(f"{name}: OCCT could not write {path.name}")
    content = path.read_bytes()
    path.write_bytes(normalise(content, name).replace(
        END, _styles(content, name, [colour for _, _, colour in bodies]) + END))


def normalise(content: bytes, name: str) -> bytes:
    """The same file without what changes from run to run."""
    header = (f"FILE_NAME('{name}.step','1970-01-01T00:00:00',(''),(''),"
              "'Open CASCADE','handgen','');\n")
    content = FILE_NAME.sub(lambda _: header.encode(), content, count=1)
    counter = iter(range(1, content.count(b"NEXT_ASSEMBLY_USAGE_OCCURRENCE") + 1))
    return OCCURRENCE.sub(lambda m: m[1] + str(next(counter)).encode() + m[2], content)


def _document(name: str, bodies: list[Body]):
    """XCAF document: the part alone, or an assembly `name` with one component per body."""
    from OCP.TCollection import TCollection_ExtendedString
    from OCP.TDataStd import TDataStd_Name
    from OCP.TDocStd import TDocStd_Document
    from OCP.TopLoc import TopLoc_Location
    from OCP.XCAFApp import XCAFApp_Application
    from OCP.XCAFDoc import XCAFDoc_DocumentTool

    document = TDocStd_Document(TCollection_ExtendedString("BinXCAF"))
    XCAFApp_Application.GetApplication_s().InitDocument(document)
    shapes = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    shapes.SetAutoNaming_s(False)

    def named(label, text):
        TDataStd_Name.Set_s(label, TCollection_ExtendedString(text))
        return label

    parent = named(shapes.NewShape(), name) if len(bodies) > 1 else None
    for body, solid, _ in bodies:
        label = named(shapes.NewShape(), body)
        shapes.SetShape(label, solid.wrapped)
        if parent is not None:
            named(shapes.AddComponent(parent, label, TopLoc_Location()), body)
    shapes.UpdateAssemblies()
    return document


def _styles(content: bytes, name: str, colours: list[Colour]) -> bytes:
    """Presentation entities that colour the solids of each representation (ISO 10303-46)."""
    solids = set(BREP.findall(content))
    shown = [([i for i in re.findall(rb"\d+", items) if i in solids], context)
             for items, context in REPRESENTATION.findall(content)]
    if len(shown) != len(colours) or not all(items for items, _ in shown):
        raise EngineError(f"{name}: STEP holds {len(shown)} representations of {len(colours)} bodies")
    at = max(map(int, LAST.findall(content))) + 1
    lines = []
    for (items, context), (red, green, blue) in zip(shown, colours, strict=True):
        styled = [f"#{at + 7 + i}" for i in range(len(items))]
        lines += [
            f"#{at} = COLOUR_RGB('',{red:.6f},{green:.6f},{blue:.6f});",
            f"#{at + 1} = FILL_AREA_STYLE_COLOUR('',#{at});",
            f"#{at + 2} = FILL_AREA_STYLE('',(#{at + 1}));",
            f"#{at + 3} = SURFACE_STYLE_FILL_AREA(#{at + 2});",
            f"#{at + 4} = SURFACE_SIDE_STYLE('',(#{at + 3}));",
            f"#{at + 5} = SURFACE_STYLE_USAGE(.BOTH.,#{at + 4});",
            f"#{at + 6} = PRESENTATION_STYLE_ASSIGNMENT((#{at + 5}));",
            *(f"{s} = STYLED_ITEM('color',(#{at + 6}),#{item.decode()});"
              for s, item in zip(styled, items, strict=True)),
            f"#{at + 7 + len(items)} = MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION('',"
            f"({','.join(styled)}),#{context.decode()});",
        ]
        at += 8 + len(items)
    return ("\n".join(lines) + "\n").encode()
