"""The README's picture of the report page: `python -m tests.report_picture PAGE PNG`."""

from __future__ import annotations

import io
import sys
from pathlib import Path

from PIL import Image

from tests.browser import chromium, opened

SIZE = {"width": 1280, "height": 800}
PRESSURE = 60
COLOURS = 128
"""Enough for a page of few colours; a third of the bytes."""


def picture(page: Path, target: Path) -> None:
    """The page as it opens, with the hand under PRESSURE, kPa."""
    with chromium() as browser:
        shown, _, complaints = opened(browser, page.resolve().as_uri(), viewport=SIZE, color_scheme="light")
        if complaints:
            raise SystemExit("\n".join(complaints))
        shown.evaluate(f"handgen.showScene('bend'); handgen.setPressure({PRESSURE})")
        shown.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
        image = Image.open(io.BytesIO(shown.screenshot())).convert("RGB")
    image.quantize(COLOURS, dither=Image.Dither.NONE).save(target, optimize=True)


if __name__ == "__main__":
    picture(Path(sys.argv[1]), Path(sys.argv[2]))
