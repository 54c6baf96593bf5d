"""The command line: exit codes, what goes to which stream, how wrong commands are answered."""

import errno
import json
import os
import signal
import subprocess
import sys

import jsonschema
import pytest

import handgen
import handgen.builder
from handgen import cli
from handgen.errors import EngineError, GeometryError
from tests.strategies import PARAMS

ADULT = str(PARAMS / "adult.yaml")
PATIENCE = 600
"""Seconds after which a process hangs, on however busy a machine."""
FINDING = {"rule": "wall.minimum", "severity": "error", "part": "exoskeleton/index", "measured": 0.5,
           "limit": 0.8, "unit": "mm", "where": None, "message": "a wall is too thin",
           "fix": "raise base_outer_diameter", "source": ""}
RESULT = {"name": "adult", "out": "outputs/adult", "manifest": "outputs/adult/manifest.json",
          "checks": {"schema": "handgen.checks/1", "passed": True, "findings": [], "rules": []},
          "passed": True}


def run(*arguments: str, **options) -> subprocess.CompletedProcess:
    return subprocess.run([sys.executable, "-m", "handgen.cli", *arguments],
                          capture_output=True, text=True, timeout=PATIENCE, **options)


@pytest.fixture
def build(monkeypatch):
    """Replaces the build by one that does what a test asks, and records how it was called."""

    def replace(action):
        calls = []

        def fake(*arguments, **options):
            calls.append((arguments, options))
            return action(options) if callable(action) else action

        monkeypatch.setattr(handgen.builder, "build", fake)
        return calls

    return replace


def raising(error: BaseException):
    def action(options):
        raise error
    return action


# Streams and exit codes


def test_a_passing_build_exits_0_with_its_result_alone_on_stdout(build, capfd):
    def action(options):
        options["progress"]("[1/1] exoskeleton/index")
        print("a library's remark")
        os.write(1, b"a CAD kernel's remark\n")
        return RESULT

    calls = build(action)
    code = cli.main(["build", ADULT, "--json", "--out", "here", "--part", "index*", "tooling/*",
                     "--part", "hand", "--no-verify", "--workers", "2"])
    out, err = capfd.readouterr()
    assert code == 0
    assert json.loads(out) == RESULT
    assert all(words in err for words in ("[1/1] exoskeleton/index", "library's remark", "kernel's remark"))
    [((params,), options)] = calls
    del options["progress"]
    assert params == ADULT
    assert options == {"out": "here", "parts": ["index*", "tooling/*", "hand"], "verify": False, "workers": 2}


def test_defaults_of_build(build, capsys):
    calls = build(RESULT)
    assert cli.main(["build", ADULT]) == 0
    out, err = capsys.readouterr()
    assert out == "" and "passes" in err and "outputs/adult" in err
    [(_, options)] = calls
    assert options["verify"] is True
    assert options["out"] is options["parts"] is options["workers"] is None


def test_a_failing_design_exits_1_and_says_how_to_mend_it(build, capsys):
    build({**RESULT, "passed": False, "manifest": None,
           "checks": {**RESULT["checks"], "passed": False, "findings": [FINDING]}})
    assert cli.main(["build", ADULT]) == 1
    err = capsys.readouterr().err
    assert all(words in err for words in
               ("wall.minimum", "a wall is too thin", "raise base_outer_diameter", "nothing printable"))


def test_quiet_says_nothing(build, capsys):
    def action(options):
        options["progress"]("working")
        return RESULT

    build(action)
    assert cli.main(["build", ADULT, "--quiet"]) == 0
    assert capsys.readouterr() == ("", "")


def test_an_impossible_part_is_bad_input(build, capsys):
    build(raising(GeometryError("tooling/thumb/core_small", "actuators.thumb", "no chamber is left")))
    assert cli.main(["build", ADULT, "--json"]) == 2
    [error] = json.loads(capsys.readouterr().out)["errors"]
    assert error == {"file": ADULT, "path": "actuators.thumb", "value": None, "allowed": None,
                     "message": "tooling/thumb/core_small: no chamber is left", "suggestion": None}


def test_an_engine_that_gives_up_exits_3(build, capsys):
    build(raising(EngineError("OCCT gave up after 3 of 7 parts")))
    assert cli.main(["build", ADULT, "--json"]) == 3
    out, err = capsys.readouterr()
    assert "3 of 7 parts" in json.loads(out)["errors"][0]["message"]
    assert "3 of 7 parts" in err and "Traceback" not in err


@pytest.mark.parametrize(("number", "code"), [
    (errno.EACCES, 2), (errno.ENOTDIR, 2), (errno.EROFS, 2), (errno.ENOSPC, 3), (errno.EIO, 3)])
def test_a_system_error_is_the_users_only_if_another_folder_helps(number, code, build, capsys):
    build(raising(OSError(number, os.strerror(number), "/some/folder")))
    assert cli.main(["build", ADULT, "--json"]) == code
    [error] = json.loads(capsys.readouterr().out)["errors"]
    assert error["file"] == "/some/folder" and error["message"] == os.strerror(number)


def test_a_mistake_in_handgen_looks_like_no_other_end(build, capsys):
    build(raising(ZeroDivisionError("oops")))
    assert cli.main(["build", ADULT]) == 70
    err = capsys.readouterr().err
    assert "ZeroDivisionError: oops" in err and "report" in err


def test_interrupted(build, capsys):
    build(raising(KeyboardInterrupt()))
    assert cli.main(["build", ADULT]) == 130
    assert capsys.readouterr().err == "interrupted\n"


# Wrong commands


@pytest.mark.parametrize(("arguments", "path", "suggestion"), [
    (["biuld", "x.yaml"], "VERB", "build"),
    (["build", "x.yaml", "--prat", "index"], "--prat", "--part"),
    (["schema", "--otu=here"], "--otu", "--out"),
    (["build", "x.yaml", "--wokers=3"], "--wokers", "--workers"),
    (["build"], "", None),
    ([], "", None),
    (["build", "x.yaml", "--workers", "none"], "", None),
    (["build", "x.yaml", "--workers", "0"], "", None),
    (["build", "x.yaml", "--out"], "", None),
])
def test_a_wrong_command_is_answered_like_bad_input(arguments, path, suggestion, capsys):
    assert cli.main([*arguments, "--json"] if arguments != ["build", "x.yaml", "--out"]
                    else ["build", "x.yaml", "--json", "--out"]) == 2
    error = json.loads(capsys.readouterr().out)["errors"][0]
    assert (error["file"], error["path"], error["suggestion"]) == ("command line", path, suggestion)
    assert cli.main(arguments) == 2
    out, err = capsys.readouterr()
    assert out == "" and "nothing was written" in err


def test_all_unknown_options_are_named(capsys):
    assert cli.main(["build", "x.yaml", "--verfy", "--colour=red", "--json"]) == 2
    errors = json.loads(capsys.readouterr().out)["errors"]
    assert [e["path"] for e in errors] == ["--verfy", "--colour"]


def test_options_are_not_abbreviated(capsys):
    assert cli.main(["build", "x.yaml", "--no-ver"]) == 2


# Schema


def test_schema_prints_a_json_schema(capsys):
    assert cli.main(["schema"]) == 0
    schema = json.loads(capsys.readouterr().out)
    jsonschema.Draft202012Validator.check_schema(schema)
    assert cli.main(["schema", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == schema


def test_schema_into_a_folder(tmp_path, capsys):
    assert cli.main(["schema", "--out", str(tmp_path / "a" / "b"), "--json"]) == 0
    path = json.loads(capsys.readouterr().out)["schema"]
    with open(path, encoding="utf-8") as file:
        jsonschema.Draft202012Validator.check_schema(json.load(file))


def test_schema_into_a_file_is_refused(tmp_path, capsys):
    (tmp_path / "file").touch()
    assert cli.main(["schema", "--out", str(tmp_path / "file" / "below"), "--json"]) == 2
    assert json.loads(capsys.readouterr().out)["errors"][0]["file"].startswith(str(tmp_path / "file"))


# In a process of its own


def test_help_and_version_go_to_stdout():
    done = run("--help")
    assert done.returncode == 0 and done.stderr == ""
    assert all(verb in done.stdout for verb in cli.VERBS)
    for verb in cli.VERBS:
        assert all(option in run(verb, "--help").stdout for option in ("--out", "--json", "--quiet"))
    assert run("--version").stdout == f"handgen {handgen.__version__}\n"


def test_help_is_quick_and_imports_nothing_heavy():
    code = ("import sys, time\n"
            "from handgen.cli import main\n"
            "try:\n    main(['--help'])\nexcept SystemExit:\n    pass\n"
            "print(time.process_time(), *sys.modules, file=sys.stderr)")
    seconds, *modules = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True,
                                       check=True).stderr.split()
    assert float(seconds) < 0.3
    assert not {"pydantic", "numpy", "yaml", "cadquery", "trimesh"} & set(modules)


def test_colour_is_for_terminals_only():
    assert "\033" not in run("biuld").stderr


@pytest.mark.skipif(not hasattr(os, "openpty"), reason="needs a pseudo-terminal")
@pytest.mark.parametrize(("environment", "coloured"), [({}, True), ({"NO_COLOR": "1"}, False)])
def test_colour_on_a_terminal(environment, coloured):
    ours, theirs = os.openpty()
    clean = {key: value for key, value in os.environ.items() if key != "NO_COLOR"}
    subprocess.run([sys.executable, "-m", "handgen.cli", "biuld"], stderr=theirs,
                   env={**clean, **environment}, timeout=PATIENCE)
    os.close(theirs)
    assert (b"\033[" in os.read(ours, 10_000)) is coloured
    os.close(ours)


def test_a_reader_that_leaves_early_is_no_error():
    """The schema is longer than a pipe holds, so the writer meets the closed end."""
    process = subprocess.Popen([sys.executable, "-m", "handgen.cli", "schema"],
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    process.stdout.read(1)
    process.stdout.close()
    assert process.wait(PATIENCE) == 141
    assert process.stderr.read() == b""
    process.stderr.close()


def test_closed_standard_streams_are_no_error():
    done = subprocess.run([sys.executable, "-c", "import os, sys; os.close(1); os.close(2); "
                           "os.execv(sys.executable, [sys.executable, '-m', 'handgen.cli', 'schema'])"],
                          timeout=PATIENCE)
    assert done.returncode == 0


def test_ctrl_c_ends_cleanly(tmp_path):
    """While a build is at work; also where whoever runs the tests ignores the signal, as a job in the
    background does: the process is given the terminal's way of it."""
    code = ("import signal, sys, time, handgen.builder\n"
            "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
            "def slow(*args, **options):\n"
            f"    options['progress']('started'); time.sleep({2 * PATIENCE})\n"
            "handgen.builder.build = slow\n"
            "from handgen.cli import main\n"
            "sys.exit(main(['build', 'x.yaml']))")
    process = subprocess.Popen([sys.executable, "-c", code], stderr=subprocess.PIPE, text=True, cwd=tmp_path)
    assert process.stderr.readline() == "started\n"
    process.send_signal(signal.SIGINT)
    assert process.wait(PATIENCE) == 130
    assert process.stderr.read() == "interrupted\n"
    process.stderr.close()
