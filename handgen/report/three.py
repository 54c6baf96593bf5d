"""three.js with its TrackballControls (MIT), out of the viewer that trimesh ships."""

from __future__ import annotations

import io
import zipfile
from importlib import resources

from handgen.errors import EngineError

PLACE = ("resources", "templates", "viewer.zip")
TEMPLATE = "viewer.html.template"
OPENS, CLOSES = "<script>", "</script>"
OWN = "var camera,controls,scene,renderer"
"""Where trimesh's own script begins behind the libraries."""
NEEDED = ("THREE={}", "class TrackballControls", "THREE.TrackballControls=TrackballControls")


def script() -> str:
    """JavaScript that defines THREE and THREE.TrackballControls.

    Raises:
        EngineError: this trimesh ships another viewer.
    """
    import trimesh

    try:
        content = resources.files("trimesh").joinpath(*PLACE).read_bytes()
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            page = archive.read(TEMPLATE).decode("utf-8")
        start = page.index(OPENS) + len(OPENS)
        found = page[start:page.index(OWN, start)]
    except (OSError, KeyError, ValueError, zipfile.BadZipFile) as error:
        raise EngineError(f"trimesh {trimesh.__version__} ships no three.js where one is looked for ({error})"
                          ) from error
    missing = [word for word in NEEDED if word not in found]
    if missing or CLOSES in found:
        raise EngineError(f"trimesh {trimesh.__version__} ships another three.js, without "
                          f"{', '.join(missing) or 'an end'}")
    return found
