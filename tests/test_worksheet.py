"""The worksheet: silicone against what the printed tooling leaves open, numbers as embossed, the page."""

import json
import math
import re
from html.parser import HTMLParser

import manifold3d
import numpy as np
import pytest

from handgen import cli
from handgen.errors import EngineError
from handgen.geometry.actuator import thread_length
from handgen.geometry.casting import Setup
from handgen.geometry.tooling import tooling
from handgen.parameters.load import load
from handgen.worksheet import bill, pictures, prints, sheet
from handgen.worksheet.silicone import FIRST, SECOND, TIP, Portion, portion, pours
from tests.conftest import PARAMS
from tests.variant import changed

ADULT = str(PARAMS / "adult.yaml")
PRIVATE_ROOM = 3.0
"""mm around the cavity that hold nothing else that is open: the mould's wall is 5 mm."""


# Silicone


def solid(part):
    mesh = part.triangles
    return manifold3d.Manifold(manifold3d.Mesh(np.array(mesh.vertices, np.float32),
                                               np.array(mesh.faces, np.uint32)))


def left_open(hand, name, core, start, end):
    """mm3 that the tooling leaves open around a core from x = start to end: the largest room there."""
    setup, parts = Setup(hand, name), {part.role: part for part in tooling(hand, name)}
    out = max(setup.base, setup.cup if start < 0 else 0.0) + (PRIVATE_ROOM if start >= 0 else 0.0)
    room = manifold3d.Manifold.cube((end - start, 2 * out, 2 * out)).translate((start, -out, -out))
    for role in ("mould_a", "mould_b", "mould_base", core):
        room -= solid(parts[role])
    return max(piece.volume() for piece in room.decompose())


@pytest.mark.parametrize("name", ["index", "middle", "ring", "little", "thumb", "opposition_1"])
def test_silicone_is_what_the_tooling_leaves_open(name, adult):
    check_volumes(adult, name)


def test_silicone_of_a_tip_that_is_filled_afterwards():
    hand = load(PARAMS / "thesis_finger.yaml").hand
    check_volumes(hand, "index")
    made = pours(hand, "index")
    assert [pour.layer for pour in made] == [FIRST, SECOND, TIP]
    # The hole of the core's salience and 2 mm of chamber.
    assert 10 < made[2].cavity < 200


def check_volumes(hand, name):
    setup, (first, second, *_) = Setup(hand, name), pours(hand, name)
    thread = math.pi * setup.thread.diameter**2 / 4 * thread_length(hand, name)
    large = left_open(hand, name, "core_large", 0.0, setup.length)
    small = left_open(hand, name, "core_small", 0.0, setup.length)
    assert first.cavity == pytest.approx(large - thread, rel=0.01)
    assert second.cavity == pytest.approx(small - large, rel=0.01)
    level = setup.top * hand.casting.cup_fill / 100
    assert first.cup == pytest.approx(left_open(hand, name, "core_large", level, 0.0), rel=0.01)
    assert second.cup == pytest.approx(left_open(hand, name, "core_small", level, 0.0), rel=0.01)


def test_a_and_b_are_what_is_poured_and_lost(adult):
    one = Portion.of(10.0, adult.casting)
    assert (one.ml, one.a_ml, one.b_ml) == pytest.approx((11.5, 5.75, 5.75))
    assert one.a_g == one.b_g == pytest.approx(5.75 * 1.07)
    casting = changed(adult, casting__silicone__mix_ratio=4.0, casting__mixing_loss=0.0).casting
    other = Portion.of(10.0, casting)
    assert (other.a_ml, other.b_ml) == pytest.approx((8.0, 2.0))
    made = pours(adult, "index")
    assert portion(made, adult.casting).ml == pytest.approx(1.15 * sum(p.cavity + p.cup for p in made) / 1000)


def test_an_empty_cup_takes_nothing(adult):
    made = pours(changed(adult, casting__cup_fill=0.0), "little")
    assert [pour.cup for pour in made] == [0.0, 0.0]


# Prints and materials


def test_numbers_are_those_that_stand_on_the_parts(adult, tmp_path):
    listed = {one.part.name: one for one in prints.prints(adult, tmp_path)}
    assert len(listed) == 62
    for name, one in listed.items():
        texts = list(prints.embossed(one.part.shape))
        assert one.embossed == bool(texts) and (not texts or texts == [one.number])
        if name.startswith("tooling"):
            assert one.embossed == (one.part.role not in ("plug", "collar"))
    numbers = [one.number for one in listed.values()]
    assert len(set(numbers)) == len(numbers)
    assert listed["tooling/opposition_1/core_small"].number == "O1e"
    assert listed["tooling/little/plug"].number == "Lg"


def test_times_are_of_these_parts_and_settings_only(adult, tmp_path):
    from handgen.slicing.slice import asked_key

    part = next(one.part for one in prints.prints(adult, tmp_path) if one.part.name == "tooling/index/plug")
    row = {"part": part.name, "slicer": "cura", "gcode": "a", "key": "", "sha256": "", "print_time_s": 60.0,
           "filament_g": 2.0, "asked": asked_key(adult, part)}
    (tmp_path / "slices.json").write_text(json.dumps([row]))
    known = {one.part.name: one for one in prints.prints(adult, tmp_path)}[part.name]
    assert known.slice == row and prints.total([known, known]) == (120.0, 4.0, 0)
    for other in (changed(adult, printing__tooling__speed=41.0), changed(adult, seal__plug_length=9.0),
                  changed(adult, printing__tooling__part_adhesion={"plug": "none"})):
        one = {one.part.name: one for one in prints.prints(other, tmp_path)}[part.name]
        assert one.slice is None and prints.total([one]) == (0, 0, 1)


def test_the_source_could_not_have_filled_its_hand_in_30_hours(adult, tmp_path):
    """Notes on the source: 111.2 cm3 at 0.35 mm x 0.1 mm x 20 mm/s take at least 44 h."""
    hand = next(one for one in prints.prints(adult, tmp_path) if one.part.name == "exoskeleton/hand")
    assert prints.least_hours(111_209.0, hand.profile) == pytest.approx(44.1, abs=0.1)


def test_the_bill_adds_up_what_it_knows(adult, tmp_path):
    printed = prints.prints(adult, tmp_path)
    mixed = [Portion.of(10.0, adult.casting), Portion.of(20.0, adult.casting)]
    lines = {line.item: line for line in bill.bill(adult, printed, mixed)}
    total, without = bill.cost(list(lines.values()))
    # Nothing is sliced yet.
    assert without == [f"{name} filament, 1.75 mm" for name in ("Ninjaflex", "Filaflex 82A", "PLA")]
    a, b = lines["Ecoflex 00-50 part A"], lines["Ecoflex 00-50 part B"]
    assert a.ml == b.ml == pytest.approx(17.25) and a.price == pytest.approx(17.25 * 1.07 / 1000 * 40)
    metres = sum(thread_length(adult, n) + 2 * 150.0 for n in adult.actuators.present()) / 1000
    assert lines["PET thread, 0.15 mm"].price == pytest.approx(0.02 * metres)
    assert total == pytest.approx(2 * a.price + 0.02 * metres + 7 * 0.4 * 1.2 + 9)
    bare = changed(adult, prices=type(adult.prices)())
    assert bill.cost(bill.bill(bare, printed, mixed)) == (0, list(lines))


# The page


class Reader(HTMLParser):
    """Fails on tags that do not close in order."""

    VOID = ("meta", "img", "br", "line")

    def __init__(self):
        super().__init__()
        self.open, self.words, self.links = [], [], []

    def handle_starttag(self, tag, attrs):
        self.links += [value for key, value in attrs if key in ("src", "href")]
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        if tag not in self.VOID:
            assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] != "style":
            self.words.append(data)


@pytest.fixture
def undrawn(monkeypatch):
    """Pictures in a moment."""
    monkeypatch.setattr(pictures, "tools", lambda parts, numbers: "data:image/png;base64,AAAA")
    monkeypatch.setattr(pictures, "filled", lambda hand, name: "data:image/png;base64,BBBB")


def test_the_page_says_what_to_do(undrawn, tmp_path, capsys):
    assert cli.main(["worksheet", ADULT, "--out", str(tmp_path), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    html = (tmp_path / "worksheet.html").read_text()
    reader = Reader()
    reader.feed(html)
    assert reader.open == [] and len(reader.links) == 14
    assert all(link.startswith("data:") for link in reader.links)
    assert "@import" not in html and "url(" not in html
    text = " ".join(" ".join(reader.words).split())
    for name in ("index a", "index b", "Ic", "Id", "Ie", "If", "Ig", "O2e", "little b"):
        assert name in text
    assert "put the suspender <b>If</b> on top" in html
    # Every pour of the day is in one mix, and no mix is larger than its pours and loss.
    assert sorted(map(tuple, (fill for mix in told["mixes"] for fill in mix["fills"]))) == sorted(
        (pour["actuator"], pour["layer"]) for pour in told["pours"])
    poured = sum(p["cavity_mm3"] + p["cup_mm3"] for p in told["pours"]) / 1000
    assert sum(mix["ml"] for mix in told["mixes"]) == pytest.approx(1.15 * poured, rel=1e-3)
    for mix in told["mixes"]:
        assert f"A {mix['a_g']:.1f} g + B {mix['b_g']:.1f} g" in text
    assert set(told["days"]) == {"1", "2", "7"} and told["prints"]["not_sliced"] == 57
    for words in ("2 h at 80 degC, then 1 h at 100 degC", "20 kPa", "Loctite 401", "cure 3 h",
                  "18 min after A met B", "about 30 h", "92 g", "round numbers of European shops"):
        assert words in text, words
    assert not re.search(r"\b(nan|None|inf)\b", text)


def test_a_finger_alone_is_what_is_needed(undrawn, tmp_path, capsys):
    assert cli.main(["worksheet", str(PARAMS / "thesis_finger.yaml"), "--out", str(tmp_path), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["prints"]["not_sliced"] == 9 and told["cost"]["sum"] == 0
    html = (tmp_path / "worksheet.html").read_text()
    assert "for trials" not in html
    assert "no prices: give them" in html and "Tips are filled afterwards" in html


def test_fewer_moulds_make_a_longer_day(undrawn, tmp_path, capsys):
    assert cli.main(["worksheet", ADULT, "--out", str(tmp_path), "--moulds", "2", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["mould_sets"] == 2 and told["days"]["1"]["hours"] > told["days"]["2"]["hours"] > 24
    assert told["mixes"][-1]["start_min"] > 60 * 20


def test_a_machine_that_cannot_draw_costs_the_pictures_only(monkeypatch, tmp_path, capsys):
    def fail(*_):
        raise EngineError("no display")

    monkeypatch.setattr(pictures, "tools", fail)
    assert cli.main(["worksheet", ADULT, "--out", str(tmp_path)]) == 0
    assert sheet.LEFT_OUT in capsys.readouterr().err
    assert "<img" not in (tmp_path / "worksheet.html").read_text()


def test_castings_that_cannot_be_are_refused(tmp_path, capsys):
    assert cli.main(["worksheet", ADULT, "--out", str(tmp_path / "out"), "--moulds", "0", "--json"]) == 2
    capsys.readouterr()
    file = tmp_path / "hasty.yaml"
    file.write_text(f"schema: handgen.hand/1\nextends: {ADULT}\nname: hasty\ncasting: {{mould_sets: 0, "
                    "silicone: {pot_life: 5}, cure_temperature: 16, mixing_loss: -1}\n")
    assert cli.main(["worksheet", str(file), "--out", str(tmp_path / "out"), "--json"]) == 2
    errors = json.loads(capsys.readouterr().out)["errors"]
    assert {"casting.mould_sets", "casting.mixing_loss"} <= {e["path"] for e in errors}
    file.write_text(f"schema: handgen.hand/1\nextends: {ADULT}\nname: hasty\n"
                    "casting: {silicone: {pot_life: 5}, cure_temperature: 16}\n")
    assert cli.main(["worksheet", str(file), "--out", str(tmp_path / "out"), "--json"]) == 2
    errors = json.loads(capsys.readouterr().out)["errors"]
    assert {e["path"] for e in errors} == {"casting.silicone.pot_life", "casting.cure_temperature"}
    assert not (tmp_path / "out").exists()
