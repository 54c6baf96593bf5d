"""Names the Debian package that brings a system library which an engine cannot find."""

from __future__ import annotations

import re

PACKAGES = {
    "libGL.so.1": "libgl1",
    "libEGL.so.1": "libegl1",
    "libOSMesa.so": "libosmesa6",
    "libGLU.so.1": "libglu1-mesa",
    "libX11.so.6": "libx11-6",
    "libXrender.so.1": "libxrender1",
    "libXext.so.6": "libxext6",
    "libXcursor.so.1": "libxcursor1",
    "libXft.so.2": "libxft2",
    "libXinerama.so.1": "libxinerama1",
    "libXfixes.so.3": "libxfixes3",
    "libSM.so.6": "libsm6",
    "libICE.so.6": "libice6",
    "libfontconfig.so.1": "libfontconfig1",
    "libfreetype.so.6": "libfreetype6",
    "libexpat.so.1": "libexpat1",
    "libgomp.so.1": "libgomp1",
}
LIBRARY = re.compile(r"(lib[\w+-]+\.so(?:\.\d+)*)")
RENDERING = "libegl1 libgl1-mesa-dri"
"""What off-screen rendering needs on a machine without a display."""


def explain(error: ImportError) -> str:
    """What to install for `error`."""
    found = LIBRARY.search(str(error))
    if not found:
        return f"cannot import {error.name or 'a module'}: {error}"
    library = found[1]
    package = next((p for name, p in PACKAGES.items() if library.startswith(name)), None)
    how = f"on Debian: apt install {package}" if package else "install the package that brings it"
    return f"the system library {library} is missing; {how}"
