"""The report page as a reader has it: in a browser, without network."""

import io
import json
import threading

import numpy as np
import pytest
from PIL import Image

from handgen.report import bends, view
from tests import small_report
from tests.browser import chromium, opened
from tests.small_report import FINGER, PRESSURES

DESK, PHONE = {"width": 1280, "height": 800}, {"width": 390, "height": 844}
SEEN = 40
"""Of 255: how much of a pixel the model covers."""
DRAWN = """() => {
  const shot = document.querySelector('#stage canvas');
  return shot.toDataURL('image/png').split(',')[1];
}"""


@pytest.fixture(scope="module")
def browser():
    with chromium() as found:
        yield found


@pytest.fixture(scope="module")
def survey(tmp_path_factory, browser):
    return small_report.surveyed(tmp_path_factory.mktemp("meshes"))


@pytest.fixture(scope="module")
def bent(survey):
    return small_report.bent(survey)


@pytest.fixture(scope="module")
def address(survey, bent, tmp_path_factory):
    folder = tmp_path_factory.mktemp("page")
    file = folder / "report.html"
    file.write_text(small_report.written(survey, bent, folder), encoding="utf-8")
    return file.as_uri()


@pytest.fixture
def desk(browser, address):
    page, asked, complaints = opened(browser, address, viewport=DESK)
    yield page
    page.context.close()
    assert complaints == []
    assert asked == [address]


def settle(page):
    """Two frames on: what was changed is drawn."""
    page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")


def silhouette(page) -> np.ndarray:
    """Pixels of the stage (rows, columns) that the model covers."""
    import base64

    settle(page)
    image = Image.open(io.BytesIO(base64.b64decode(page.evaluate(DRAWN)))).convert("RGBA")
    return np.asarray(image)[:, :, 3] > SEEN


def camera(page) -> list:
    return page.evaluate("[...handgen.camera.position.toArray(), ...handgen.camera.up.toArray()]")


def marker(page, finding: int) -> tuple[float, float]:
    """Middle of a finding's marker, pixels of the stage."""
    box = page.locator(f"#markers button[data-finding='{finding}']").bounding_box()
    stage = page.locator("#stage").bounding_box()
    return (box["x"] + box["width"] / 2 - stage["x"] - 1, box["y"] + box["height"] / 2 - stage["y"] - 1)


def test_shows_every_scene_and_its_parts(desk):
    scenes = desk.evaluate("[...document.getElementById('scene').options].map((o) => o.value)")
    assert scenes[:2] == ["hand", "bend"] and FINGER in scenes
    assert desk.locator("#parts input").count() == 22
    assert silhouette(desk).mean() > 0.1


def test_turns_by_pointer_and_by_keys(desk):
    before = camera(desk)
    stage = desk.locator("#stage").bounding_box()
    middle = stage["x"] + stage["width"] / 2, stage["y"] + stage["height"] / 2
    desk.mouse.move(*middle)
    desk.mouse.down()
    desk.mouse.move(middle[0] + 90, middle[1] + 30, steps=4)
    desk.mouse.up()
    settle(desk)
    dragged = camera(desk)
    assert np.abs(np.subtract(dragged, before)).max() > 10
    desk.locator("#stage").focus()
    desk.keyboard.press("ArrowRight")
    assert np.abs(np.subtract(camera(desk), dragged)).max() > 10
    desk.keyboard.press("b")
    settle(desk)
    np.testing.assert_allclose(camera(desk)[3:], [1, 0, 0], atol=1e-9)


def test_marker_stands_on_the_silhouette_where_its_corner_is(desk):
    """The finding's corner is the hand's farthest: from the palm, x up, no pixel is above it."""
    desk.evaluate("handgen.look('palm')")
    rows, columns = np.nonzero(silhouette(desk))
    top = rows.min()
    x, y = marker(desk, 0)
    assert abs(y - top) <= 2.0
    assert columns[rows == top].min() - 3 <= x <= columns[rows == top].max() + 3


def test_marker_of_a_part_goes_with_it_when_exploded(desk):
    """With the little finger's actuator alone: its farthest corner is the silhouette's, before and after."""
    desk.evaluate(f"""handgen.nodes().forEach(
      ({{row}}) => handgen.setVisible(row.name, row.name === 'actuators/{FINGER}'))""")
    for share in (0, 1):
        desk.evaluate(f"handgen.setExplode({share}); handgen.look('palm')")
        rows, columns = np.nonzero(silhouette(desk))
        along = np.array([columns, -rows]).T @ _heading(desk)
        far = along.max()
        assert abs(np.array([1.0, -1.0]) * marker(desk, 1) @ _heading(desk) - far) <= 3.0


def _heading(page) -> np.ndarray:
    """The finger's axis on the screen, right and up: from its way when exploded."""
    way = page.evaluate(f"handgen.nodes().find(({{row}}) => row.name === 'actuators/{FINGER}').row.apart")
    start, end = page.evaluate("handgen.onto([0, 0, 0])"), page.evaluate(f"handgen.onto({way})")
    heading = np.subtract(end, start) * (1.0, -1.0)
    return heading / np.linalg.norm(heading)


def test_explodes(desk):
    before = silhouette(desk)
    desk.locator("#explode").fill("100")
    after = silhouette(desk)
    assert (before != after).mean() > 0.05
    # Nothing lies in anything else: actuators are clear of the hand.
    assert desk.evaluate("""() => {
      const at = (name) => handgen.nodes().find(({row}) => row.name === name).mesh;
      const box = (mesh) => mesh.geometry.boundingBox.clone().applyMatrix4(mesh.matrix);
      return box(at('actuators/middle')).min.x > box(at('exoskeleton/hand')).max.x;
    }""")


def test_parts_are_switched(desk):
    desk.locator("#switches summary").click()
    desk.locator("#parts input[data-part='exoskeleton/hand']").uncheck()
    without = silhouette(desk).sum()
    desk.locator("#parts input[data-part='exoskeleton/hand']").check()
    assert without < 0.7 * silhouette(desk).sum()


def test_choosing_a_finding_goes_to_its_scene_and_place(desk):
    desk.locator("ol.findings li[data-finding='2'] button").click()
    settle(desk)
    assert desk.evaluate("handgen.scene().name") == FINGER
    stage = desk.locator("#stage").bounding_box()
    x, y = marker(desk, 2)
    assert abs(x - stage["width"] / 2) < 3 and abs(y - stage["height"] / 2) < 3
    assert "chosen" in desk.locator("ol.findings li[data-finding='2']").get_attribute("class")


@pytest.mark.parametrize(("value", "point"), [(15, 1), (30, 2)])
def test_the_slider_gives_the_solved_shape(desk, survey, bent, value, point):
    """The lowest place of the drawn finger is that of the solver's own nodes, to the steps of the page."""
    desk.evaluate("handgen.showScene('bend')")
    at_rest = silhouette(desk)
    desk.locator("#pressure").fill(str(value))
    assert (at_rest != silhouette(desk)).any()
    state = bent[FINGER].curve.states[point]
    hand = survey.loaded.hand
    both = np.vstack([state.positions["exoskeleton"], state.positions["exoskeleton"] * (1.0, -1.0, 1.0)])
    truth = bends.placed(hand, FINGER, both)
    box = desk.evaluate(f"""() => {{
      const {{mesh}} = handgen.nodes().find(({{row}}) => row.name === 'exoskeleton/{FINGER}');
      mesh.geometry.computeBoundingBox();
      const {{min, max}} = mesh.geometry.boundingBox;
      return [min.toArray(), max.toArray()];
    }}""")
    np.testing.assert_allclose(box, [truth.min(axis=0), truth.max(axis=0)], atol=0.01)
    assert f"{value} kPa" in desk.locator("#readout").inner_text()


def test_the_curve_follows_the_slider(desk):
    places = []
    for value in ("0", "30"):
        desk.evaluate("handgen.showScene('bend')")
        desk.locator("#pressure").fill(value)
        dot = desk.locator(f"#dot-{FINGER}-bend_angle_deg")
        places.append([float(dot.get_attribute("cx")), float(dot.get_attribute("cy"))])
    assert places[1][0] > places[0][0] + 20 and places[1][1] < places[0][1] - 20


def test_downloads_work_without_network(desk, survey):
    with desk.expect_download() as caught:
        desk.locator("button[data-download='checks']").click()
    with open(caught.value.path(), encoding="utf-8") as file:
        assert json.load(file) == survey.report
    assert caught.value.suggested_filename == "checks.json"


def test_what_a_file_says_is_text_not_markup(desk):
    assert desk.locator("ol.findings li b:text-is('here')").count() == 0
    assert "planted <b>here</b>" in desk.locator("ol.findings li[data-finding='0']").inner_text()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_fits_a_phone(browser, address, scheme):
    page, _, complaints = opened(browser, address, viewport=PHONE, device_scale_factor=2, has_touch=True,
                                 color_scheme=scheme)
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    assert page.evaluate("document.documentElement.dataset.theme") == scheme
    assert silhouette(page).mean() > 0.1
    assert complaints == []
    page.context.close()


def test_everything_can_be_named_by_a_screen_reader(desk):
    unnamed = desk.evaluate("""() => [...document.querySelectorAll('button, input, select, [role]')].filter(
      (each) => !(each.getAttribute('aria-label') || each.getAttribute('aria-labelledby')
        || each.textContent.trim() || (each.labels && each.labels.length) || each.hidden)
    ).map((each) => each.outerHTML)""")
    assert unnamed == []


def test_findings_are_numbered_worst_first_in_list_and_view_alike(desk):
    """Planted: warning, info, warning, warning."""
    numbers = [desk.locator(f"ol.findings li[data-finding='{n}'] .number").text_content() for n in range(4)]
    assert numbers == ["1", "4", "2", "3"]
    assert [desk.locator(f"#markers button[data-finding='{n}']").text_content() for n in (0, 1)] == ["1", "4"]


def test_choosing_a_marker_unfolds_its_words(desk):
    item = desk.locator("ol.findings li[data-finding='1']")
    assert not item.is_visible()
    desk.locator("#markers button[data-finding='1']").dispatch_event("click")
    assert item.is_visible()


def test_the_bent_hand_stays_in_the_frame_at_every_pressure(desk):
    desk.evaluate("handgen.showScene('bend')")
    for value in PRESSURES:
        desk.locator("#pressure").fill(str(value))
        covered = silhouette(desk)
        assert covered.any()
        assert not (covered[0].any() or covered[-1].any() or covered[:, 0].any() or covered[:, -1].any())


def test_keyboard_alone_reaches_and_moves_everything(desk):
    focus = "document.activeElement.id || document.activeElement.textContent.trim()"

    def tab_to(name):
        for _ in range(40):
            desk.keyboard.press("Tab")
            if desk.evaluate(focus) == name:
                return
        raise AssertionError(f"no way to {name}")

    desk.keyboard.press("Tab")
    assert desk.evaluate(focus) == "Skip the 3D view"
    tab_to("stage")
    before = camera(desk)
    desk.keyboard.press("ArrowUp")
    assert camera(desk) != before
    tab_to("explode")
    desk.keyboard.press("End")
    assert desk.locator("#explode-value").text_content() == "100 %"
    tab_to("Parts")
    desk.keyboard.press("Enter")
    desk.keyboard.press("Tab")
    desk.keyboard.press("Tab")  # "none"
    desk.keyboard.press("Enter")
    assert not silhouette(desk).any()
    desk.keyboard.press("Tab")
    desk.keyboard.press("Space")
    assert silhouette(desk).any()
    assert desk.evaluate("getComputedStyle(document.activeElement).outlineStyle") == "solid"


def test_theme_follows_the_system_until_the_reader_chooses(desk):
    theme = "document.documentElement.dataset.theme"
    for scheme in ("dark", "light", "dark"):
        desk.emulate_media(color_scheme=scheme)
        settle(desk)
        assert desk.evaluate(theme) == scheme
    desk.locator("#theme").click()
    assert desk.evaluate(theme) == "light"
    desk.emulate_media(color_scheme="light")
    settle(desk)
    desk.emulate_media(color_scheme="dark")
    settle(desk)
    assert desk.evaluate(theme) == "light"


def test_a_served_page_shows_errors_and_takes_up_the_next(browser, survey, bent, tmp_path):
    """The page asks nobody but its server; scene and side stay over the renewal."""
    maker = view.Maker(tmp_path / "hand.yaml", tmp_path)
    maker.serial, maker.page = 1, small_report.written(survey, bent, tmp_path, 1).encode()
    with view.Server(maker, 0) as server:
        threading.Thread(target=server.serve_forever, args=(0.02,), daemon=True).start()
        page, asked, complaints = opened(browser, server.address, offline=False, viewport=DESK)
        page.evaluate("handgen.showScene('bend'); handgen.setPressure(15); handgen.look('side')")
        side = page.evaluate("handgen.camera.up.toArray()")
        maker.problems = ["hand.yaml: fingers.index.<b>: unknown key"]
        page.get_by_text("hand.yaml: fingers.index.<b>: unknown key").wait_for()
        assert silhouette(page).any()
        maker.problems, maker.serial = [], 2
        maker.page = maker.page.replace(b'data-serial="1"', b'data-serial="2"')
        page.locator("html[data-serial='2']").wait_for()
        page.locator("#readout:has-text('15 kPa')").wait_for()
        assert page.locator("#news").is_hidden()
        assert page.evaluate("handgen.camera.up.toArray()") == pytest.approx(side, abs=1e-9)
        server.shutdown()
    page.context.close()
    assert complaints == []
    assert {url.removeprefix(server.address) for url in asked} == {"", "state"}
