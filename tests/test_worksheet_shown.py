"""The worksheet as it is seen: pictures of an actuator's own parts, and the page on paper."""

import base64
import io
import re

import numpy as np
import pytest
from PIL import Image

from handgen.errors import EngineError
from handgen.geometry.tooling import COLOURS, tooling
from handgen.worksheet import pictures, worksheet
from tests.browser import chromium
from tests.conftest import PARAMS

A4 = (595.0, 842.0)
"""Points."""
ROLES = ("mould_a", "mould_b", "mould_base", "core_large", "core_small", "suspender", "plug", "collar")


def hues(uri):
    """How many pixels of a picture are of the hue of each colour: light and shade leave that alone."""
    image = Image.open(io.BytesIO(base64.b64decode(uri.split(",")[1]))).convert("RGB")
    pixels = np.asarray(image, float).reshape(-1, 3)
    pixels = pixels[np.ptp(pixels, axis=1) > 40]
    directions = pixels / np.linalg.norm(pixels, axis=1)[:, None]

    def count(colour):
        return int((directions @ (np.array(colour) / np.linalg.norm(colour)) > 0.995).sum())

    return count


def drawn(draw, *arguments):
    try:
        return hues(draw(*arguments))
    except EngineError as error:
        pytest.skip(f"this machine cannot draw: {error}")


def test_pictures_show_the_parts_of_each_step(adult):
    numbers = {role: f"L{letter}" for role, letter in zip(ROLES, "abcdefgh", strict=True)}
    parts = drawn(pictures.tools, tooling(adult, "little"), numbers)
    for role in ("mould_a", "core_large", "core_small", "suspender"):
        assert parts(COLOURS[role]) > 300, role
    poured = drawn(pictures.filled, adult, "little")
    for colour in (COLOURS["core_large"], COLOURS["core_small"], COLOURS["suspender"], pictures.THREAD):
        assert poured(colour) > 300, colour


def test_captions_are_the_numbers_on_the_parts():
    assert pictures._label("mould_a", "index a") == "index a"
    assert pictures._label("mould_a", "O1a") == "O1a mould a"
    assert pictures._label("core_large", "Id") == "Id core large"


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pictures, "tools", lambda parts, numbers: "data:image/png;base64,AAAA")
        patch.setattr(pictures, "filled", lambda hand, name: "data:image/png;base64,BBBB")
        folder = tmp_path_factory.mktemp("worksheet")
        worksheet(PARAMS / "adult.yaml", folder)
    return folder / "worksheet.html"


def test_the_page_prints_on_a4_with_a_sheet_for_every_actuator(file):
    with chromium() as browser:
        page = browser.new_context(offline=True, color_scheme="dark").new_page()
        page.goto(file.as_uri())
        page.emulate_media(media="print")
        # As wide as what the margins leave of A4.
        page.set_viewport_size({"width": 695, "height": 1000})
        assert page.evaluate("document.documentElement.scrollWidth") <= 695
        assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
        breaks = page.evaluate(
            "[...document.querySelectorAll('.sheet')].map(s => getComputedStyle(s).breakBefore)")
        assert breaks == ["page"] * 9
        pdf = page.pdf(prefer_css_page_size=True)
    sizes = re.findall(rb"/MediaBox \[0 0 ([\d.]+) ([\d.]+)\]", pdf)
    assert 10 <= len(sizes) <= 16
    for width, height in sizes:
        assert (float(width), float(height)) == pytest.approx(A4, abs=1.0)


def test_the_page_fits_a_phone(file):
    with chromium() as browser:
        page = browser.new_context(offline=True, viewport={"width": 390, "height": 844}).new_page()
        page.goto(file.as_uri())
        assert page.evaluate("document.documentElement.scrollWidth") <= 390
