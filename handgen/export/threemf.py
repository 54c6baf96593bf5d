"""3MF: one object in millimetres with a name, the same bytes every time.

Written directly (3MF core specification 1.3), because the usual writers put random identifiers
and the present time into the file. A package is a zip of three small XML documents.
"""

from __future__ import annotations

import io
import zipfile
from typing import TYPE_CHECKING
from xml.sax.saxutils import escape, quoteattr

import numpy as np

if TYPE_CHECKING:
    from handgen.geometry.mesh_kernel import Triangles

EPOCH = (1980, 1, 1, 0, 0, 0)
"""The earliest time a zip can hold: the same for every file."""
CONTENT_TYPES = """<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>
<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>
</Types>
"""
RELATIONSHIPS = """<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
<Relationship Target="/3D/3dmodel.model" Id="rel0" \
Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>
</Relationships>
"""
MODEL = """<?xml version="1.0" encoding="UTF-8"?>
<model unit="millimeter" xml:lang="en-US" \
xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02">
<metadata name="Title">{title}</metadata>
<metadata name="Application">handgen</metadata>
<resources>
<basematerials id="1"><base name={material} displaycolor="{colour}"/></basematerials>
<object id="2" type="model" name={name} pid="1" pindex="0"><mesh>
<vertices>
{vertices}</vertices>
<triangles>
{triangles}</triangles>
</mesh></object>
</resources>
<build><item objectid="2"/></build>
</model>
"""


def to_bytes(mesh: Triangles, name: str, material: str, colour: tuple[float, float, float]) -> bytes:
    """The mesh (mm) as a 3MF package with one object called `name`; `colour` is sRGB 0..1."""
    points = np.asarray(mesh.vertices, np.float32)
    # Nine digits bring back every float32 exactly.
    model = MODEL.format(
        title=escape(name),
        name=quoteattr(name),
        material=quoteattr(material),
        colour="#" + "".join(f"{round(255 * c):02X}" for c in colour),
        vertices="".join(f'<vertex x="{x:.9g}" y="{y:.9g}" z="{z:.9g}"/>\n' for x, y, z in points.tolist()),
        triangles="".join(
            f'<triangle v1="{a}" v2="{b}" v3="{c}"/>\n' for a, b, c in np.asarray(mesh.faces).tolist()),
    )
    package = io.BytesIO()
    with zipfile.ZipFile(package, "w") as archive:
        for path, text in (("[Content_Types].xml", CONTENT_TYPES), ("_rels/.rels", RELATIONSHIPS),
                           ("3D/3dmodel.model", model)):
            entry = zipfile.ZipInfo(path, EPOCH)
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, text.encode(), compresslevel=3)
    return package.getvalue()
