"""CSV tables of a lab -> measurements files."""

import json
from pathlib import Path

import pytest
import yaml

from handgen.cli import main
from handgen.errors import InputError
from handgen.measurements.load import load_measurements
from handgen.measurements.wide import import_table

HAND = Path("params/adult.yaml").resolve()
HEAD = ("id,part,load.quantity,observable.quantity,orientation,path,resolution,sensor.pressure_sigma,"
        "held_out,0,20,40,60")
TABLE = HEAD + """
up,assembly,pressure,tip_drop,palm_down,loading,0.5,3.5,false,38.5,61,74,81.5
up,assembly,pressure,tip_drop,palm_down,loading,0.5,3.5,false,40,,75,81.5
down,assembly,pressure,tip_drop,palm_down,unloading,0.5,,yes,41,64,76,
free,actuator,pressure,elongation,weightless,loading,0.5,3.5,,,5,12,23
"""


def test_a_table_becomes_tests_with_their_repeats(tmp_path):
    (tmp_path / "lab.csv").write_text(TABLE)
    found = import_table(tmp_path / "lab.csv", tmp_path / "lab.yaml", hand=HAND, finger="index")
    up, down, free = load_measurements(tmp_path / "lab.yaml").measurements.tests
    assert up == found.measurements.tests[0]
    assert up.load.values == [0, 20, 40, 60] and up.repeats == [[38.5, 61, 74, 81.5], [40, None, 75, 81.5]]
    assert (up.resolution, up.sensor.pressure_sigma, up.held_out) == (0.5, 3.5, False)
    assert down.load.values == [40, 20, 0] and down.repeats == [[76, 64, 41]] and down.held_out
    assert free.load.values == [20, 40, 60] and free.observable.unit == "mm" and free.path == "loading"
    assert found.hand.file.samefile(HAND)
    assert [p.name for p in tmp_path.iterdir() if p.name.startswith(".")] == []


def test_a_wrong_word_and_a_wrong_number_are_told_at_once(tmp_path):
    rows = [HEAD, "a,assembly,presure,tip_drop,palm_down,loading,0.5,,,38,x,75,81",
            "b,actuator,pressure,elongation,sideway,loading,0.5,,,,5,12,23"]
    (tmp_path / "lab.csv").write_text("\n".join(rows))
    with pytest.raises(InputError) as error:
        import_table(tmp_path / "lab.csv", tmp_path / "lab.yaml", hand=HAND, finger="index")
    assert [(p.path, p.suggestion) for p in error.value.problems] == [
        ("line 2, column load.quantity", "pressure"), ("line 2, column 20.0", None),
        ("line 3, column orientation", "sideways")]


def test_semicolons_bring_decimal_commas(tmp_path):
    rows = ["ID;Part;Load quantity;Observable quantity;0,07;0,16", "w;exoskeleton;tip_load;tip_drop;66,5;74"]
    (tmp_path / "lab.csv").write_text("\ufeff" + "\n".join(rows))
    found = import_table(tmp_path / "lab.csv", tmp_path / "lab.yaml", hand=HAND, finger="index")
    assert found.measurements.tests[0].repeats == [[66.5, 74]]
    assert found.measurements.tests[0].load.values == [0.07, 0.16]


@pytest.mark.parametrize(("line", "path", "word"), [
    ("id,prt,load.quantity,observable.quantity,0\nx,assembly,pressure,tip_drop,1", "line 1", "part"),
    ("id,part,load.quantity,observable.quantity\nx,assembly,pressure,tip_drop", "line 1", "load"),
    ("id,part,load.quantity,observable.quantity,0,20\nx,assembly,pressure,tip_drop,1,a", "line 2", "number"),
    ("id,part,load.quantity,observable.quantity,0,20\nx,assembly,pressure,tip_drop,1", "line 2", "fields"),
    ("id,part,load.quantity,observable.quantity,0,20\nx,assembly,pressure,tip_drop,1,2\nx,actuator,pressure,"
     "tip_drop,1,2", "line 3", "differs"),
    ("id,part,load.quantity,observable.quantity,0,20\nx,assembly,weight,tip_drop,1,2", "load", ""),
    ("id\n", "", "no readings"),
])
def test_what_is_wrong_is_said_by_line_and_nothing_is_written(tmp_path, line, path, word):
    (tmp_path / "lab.csv").write_text(line)
    with pytest.raises(InputError) as caught:
        import_table(tmp_path / "lab.csv", tmp_path / "out" / "lab.yaml", hand=HAND, finger="index")
    assert any(path in p.path and word in f"{p.message} {p.allowed}" for p in caught.value.problems)
    assert all(p.file == str(tmp_path / "lab.csv") for p in caught.value.problems)
    assert [p.name for p in tmp_path.iterdir()] == ["lab.csv"]


def test_what_is_wrong_with_the_hand_is_said_of_its_file(tmp_path):
    (tmp_path / "lab.csv").write_text(TABLE)
    (tmp_path / "bad.yaml").write_text(HAND.read_text().replace("handgen.hand/1", "handgen.hand/0"))
    for hand in (tmp_path / "bad.yaml", tmp_path / "none.yaml"):
        with pytest.raises(InputError) as caught:
            import_table(tmp_path / "lab.csv", tmp_path / "out" / "lab.yaml", hand=hand, finger="index")
        assert {p.file for p in caught.value.problems} == {str(hand)}
    assert not (tmp_path / "out").exists()


def test_the_verb_writes_a_file_that_can_be_read(tmp_path, capsys):
    (tmp_path / "lab.csv").write_text(TABLE)
    arguments = ["measurements", "import", str(tmp_path / "lab.csv"), "--hand", str(HAND)]
    assert main([*arguments, "--out", str(tmp_path), "--name", "our lab", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    data = yaml.safe_load(Path(said["file"]).read_text())
    assert said["tests"] == ["up", "down", "free"] and data["name"] == "our lab"
    assert main(["measurements", "import", str(tmp_path / "none.csv"), "--hand", str(HAND)]) == 2
