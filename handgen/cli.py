"""The command line: parse, call, print. No physics, no geometry, nothing heavy before it is needed.

Results go to standard output (JSON with `--json`), everything else to standard error. Exit codes:
0 done and passed, 1 done and failed a rule, 2 bad input, 3 an engine gave up; 130 interrupted.
"""

from __future__ import annotations

import argparse
import contextlib
import difflib
import errno
import io
import json
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, NoReturn, TextIO

from handgen import __version__, tables
from handgen.errors import EngineError, GeometryError, InputError, Problem

PASSED, FAILED, BAD_INPUT, ENGINE, INTERNAL, INTERRUPTED, PIPE_CLOSED = 0, 1, 2, 3, 70, 130, 141
COMMAND_LINE = "command line"
USERS_ERRORS = {errno.EACCES, errno.EPERM, errno.EROFS, errno.ENOTDIR, errno.EISDIR, errno.EEXIST,
                errno.ENOENT, errno.ENAMETOOLONG, errno.EINVAL, errno.ELOOP}
"""System errors that another path would mend; a full disk is none of them."""


@dataclass(frozen=True)
class Output:
    """Where a verb writes: results, and what only people read."""

    results: TextIO
    people: TextIO
    as_json: bool = False
    quiet: bool = False

    def result(self, data: Any, table: str = "") -> None:
        """The verb's result: JSON for programs, or a table for people."""
        if self.as_json:
            print(json.dumps(data, indent=2, allow_nan=False), file=self.results)
        elif table and not self.quiet:
            print(table, file=self.people)

    def note(self, text: str) -> None:
        """Progress and remarks."""
        if not self.quiet:
            print(text, file=self.people, flush=True)

    def style(self, text: str, code: str) -> str:
        """`text` in an ANSI style, on a terminal that wants colours."""
        coloured = self.people.isatty() and "NO_COLOR" not in os.environ
        return f"\033[{code}m{text}\033[0m" if coloured else text


@dataclass(frozen=True)
class Verb:
    """One command: its help, its own arguments, and what it runs; returns the exit code."""

    help: str
    arguments: Callable[[argparse.ArgumentParser], None]
    run: Callable[[argparse.Namespace, Output], int]


# build


def _build_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("params", metavar="PARAMS", help="parameter file, e.g. params/adult.yaml")
    parser.add_argument("--part", dest="parts", metavar="NAME", nargs="+", action="extend",
                        help="only these parts: names or globs (index*, tooling/*)")
    parser.add_argument("--no-verify", dest="verify", action="store_false",
                        help="write even a design that fails a rule; the manifest says so")
    parser.add_argument("--workers", type=_count, default=None, metavar="N",
                        help="processes to work with (default: one a core)")


def _build(arguments: argparse.Namespace, output: Output) -> int:
    from handgen.builder import build

    result = build(arguments.params, out=arguments.out, parts=arguments.parts, verify=arguments.verify,
                   progress=output.note, workers=arguments.workers)
    output.result(result, tables.built(result, output.style))
    return PASSED if result["passed"] else FAILED


# check


def _check_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("params", metavar="PARAMS", help="parameter file, e.g. params/adult.yaml")
    parser.add_argument("--workers", type=_count, default=None, metavar="N",
                        help="processes to work with (default: one a core)")


def _check(arguments: argparse.Namespace, output: Output) -> int:
    from handgen.builder import check

    result = check(arguments.params, out=arguments.out, progress=output.note, workers=arguments.workers)
    output.result(result["checks"], tables.checked(result, output.style))
    return PASSED if result["passed"] else FAILED


# bend


def _bend_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("params", metavar="PARAMS", help="parameter file, e.g. params/adult.yaml")
    parser.add_argument("--finger", metavar="NAME", help="which finger (index)")
    parser.add_argument("--part", default="assembly", metavar="WHAT",
                        help="assembly, exoskeleton, actuator, or opposition: the angle of the thumb's hinge "
                             "(assembly)")
    parser.add_argument("--pressures", nargs="+", metavar="KPA",
                        help="start:end:step or a list, kPa, rising (0:100:10)")
    parser.add_argument("--tip-loads", nargs="+", metavar="N", help="weights that hang on the fingertip")
    parser.add_argument("--orientation", metavar="HOW",
                        help="palm_down, palm_up, sideways or weightless (palm_down)")
    parser.add_argument("--obstacle", metavar="MM",
                        help="a rigid plane so far below the palm side: gives the fingertip's force")
    parser.add_argument("--model", metavar="FILE",
                        help="materials and friction: a name of params/models or a file (the first there "
                             "is of calibrated, literature)")
    parser.add_argument("--solver", metavar="NAME",
                        help="solid, reference, or one that another package brings (solid); section for the "
                             "opposition")
    parser.add_argument("--refine", default="0", metavar="N", help="0 to 3: each halves the elements (0)")
    parser.add_argument("--no-cache", dest="keep", action="store_false",
                        help="solve even what was solved before, and keep nothing")


def _bend(arguments: argparse.Namespace, output: Output) -> int:
    from handgen import bending

    asked = bending.request(
        arguments.params, finger=arguments.finger, part=arguments.part, pressures=arguments.pressures,
        tip_loads=arguments.tip_loads, orientation=arguments.orientation, obstacle=arguments.obstacle,
        model=arguments.model, solver=arguments.solver, refine=arguments.refine)
    bending.target(asked, arguments.out)
    found = bending.solve(asked, keep=arguments.keep, progress=output.note)
    folder = bending.write(found, arguments.out, output.note)
    document = found.document
    output.result(document, tables.bent(document, found.reached, str(folder), output.style))
    if not found.complete and (output.as_json or output.quiet):
        print(f"handgen: {found.reached}", file=output.people)
    return PASSED if found.complete else ENGINE


# slice


def _slice_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("params", metavar="PARAMS", help="parameter file, e.g. params/adult.yaml")
    parser.add_argument("--slicer", dest="slicers", metavar="NAME", nargs="+", action="extend",
                        help="prusaslicer, cura (both)")
    parser.add_argument("--part", dest="parts", metavar="NAME", nargs="+", action="extend",
                        help="only these parts: names or globs (index*, tooling/*)")
    parser.add_argument("--workers", type=_count, default=None, metavar="N",
                        help="slicers that run at once (default: one a core)")


def _slice(arguments: argparse.Namespace, output: Output) -> int:
    from handgen.slicing.slice import slice_parts

    result = slice_parts(arguments.params, out=arguments.out, slicers=arguments.slicers,
                         parts=arguments.parts, progress=output.note, workers=arguments.workers)
    output.result(result["rows"], tables.sliced(result, output.style))
    if result["failed"]:
        print(f"handgen: {len(result['rows'])} slices are kept; {'; '.join(result['failed'])}",
              file=output.people)
        return ENGINE
    return PASSED if result["passed"] else FAILED


# profiles


def _profiles_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("params", metavar="PARAMS", help="parameter file, e.g. params/adult.yaml")


def _profiles(arguments: argparse.Namespace, output: Output) -> int:
    from handgen.slicing.profile_files import write

    written = write(arguments.params, arguments.out)
    output.result({"files": written}, "\n".join(written))
    return PASSED


# worksheet


def _worksheet_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("params", metavar="PARAMS", help="parameter file, e.g. params/adult.yaml")
    parser.add_argument("--moulds", type=_count, default=None, metavar="N",
                        help="moulds that stand filled at once (casting.mould_sets)")


def _worksheet(arguments: argparse.Namespace, output: Output) -> int:
    from handgen.worksheet import worksheet

    result = worksheet(arguments.params, out=arguments.out, moulds=arguments.moulds, progress=output.note)
    output.result(result, tables.planned(result))
    return PASSED


# validate


def _validate_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("measurements", metavar="MEASUREMENTS", nargs="?",
                        help="measurements file (the source's: params/measurements/coimbra_index.yaml)")
    parser.add_argument("--models", metavar="FILE", nargs="+",
                        help="names of params/models or files (literature thesis calibrated)")
    parser.add_argument("--no-cache", dest="keep", action="store_false",
                        help="solve even what was solved before, and keep nothing")


def _validate(arguments: argparse.Namespace, output: Output) -> int:
    from pathlib import Path

    from handgen.bending import validation, validation_files

    file = Path(arguments.measurements or validation.MEASUREMENTS)
    folder = Path(arguments.out or Path("outputs") / file.stem)
    found = validation.validate(file, arguments.models or validation.MODELS, keep=arguments.keep,
                                progress=output.note)
    document = validation_files.write(found, folder)
    output.result(document, tables.validated(document, str(folder), output.style))
    return PASSED if document["complete"] else ENGINE


# effects


def _effects_arguments(parser: argparse.ArgumentParser) -> None:
    """No arguments of its own."""


def _effects(arguments: argparse.Namespace, output: Output) -> int:
    from handgen.effects.registry import document as listed

    document = listed()
    output.result(document, tables.effects(document, output.style))
    return PASSED


# diagnose


def _diagnose_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("measurements", metavar="MEASUREMENTS",
                        help="measurements file, e.g. params/measurements/coimbra_index.yaml")
    parser.add_argument("--params", metavar="FILE", help="another hand than the measurements name")
    parser.add_argument("--model", metavar="FILE", help="what to diagnose: a name of params/models or a file")
    parser.add_argument("--seed", type=_whole, default=0, metavar="N",
                        help="of the fingers within tolerance (0)")
    parser.add_argument("--workers", type=_count, default=2, metavar="N", help="processes to simulate with "
                                                                               "(2)")


def _diagnose(arguments: argparse.Namespace, output: Output) -> int:
    from pathlib import Path

    from handgen.discrepancy import files, run

    folder = Path(arguments.out or Path("outputs") / Path(arguments.measurements).stem)
    files.expect(folder)
    found = run.diagnose(arguments.measurements, params=arguments.params, model=arguments.model,
                         seed=arguments.seed, workers=arguments.workers, progress=output.note)
    document = files.write(found, folder)
    output.result(document, tables.diagnosed(document, str(folder), output.style))
    return PASSED if document["verdict"] == "none" else FAILED


# measurements


def _measurements_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("action", choices=["import"], help="import: a wide CSV table becomes a measurements "
                                                           "file")
    parser.add_argument("table", metavar="CSV", help="a row a repeat, a column a load")
    parser.add_argument("--hand", metavar="FILE", required=True, help="parameter file of the hand that was "
                                                                      "measured")
    parser.add_argument("--finger", metavar="NAME", default="index", help="which finger (index)")
    parser.add_argument("--name", metavar="TEXT", help="of the campaign (the table's name)")
    parser.add_argument("--source", metavar="TEXT", help="where the numbers come from")


def _measurements(arguments: argparse.Namespace, output: Output) -> int:
    from pathlib import Path

    from handgen.measurements.wide import import_table

    stem = Path(arguments.table).stem
    target = Path(arguments.out or Path("outputs") / stem) / f"{stem}.yaml"
    found = import_table(arguments.table, target, hand=arguments.hand, finger=arguments.finger,
                         name=arguments.name, source=arguments.source).measurements
    rows = sum(len(test.repeats) for test in found.tests)
    output.result({"file": str(target), "tests": [test.id for test in found.tests], "repeats": rows},
                  f"{len(found.tests)} tests, {rows} repeats: {target}")
    return PASSED


# sweep


def _sweep_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("words", metavar="SWEEP", nargs="+",
                        help="SWEEP.yaml runs it; plan SWEEP.yaml says how many, how long, how much; "
                             "show FOLDER makes tables, plots and a page of what was found")
    parser.add_argument("--workers", type=_count, default=None, metavar="N",
                        help="processes to work with, a thread each (default: one a core)")
    parser.add_argument("--scheduler", metavar="ADDRESS",
                        help="of a running Dask scheduler (tcp://...), instead of a local cluster")
    parser.add_argument("--resume", action="store_true",
                        help="take up an interrupted run; a plain run does the same")


def _sweep(arguments: argparse.Namespace, output: Output) -> int:
    from handgen import sweep
    from handgen.sweep import said

    action, file = sweep.action(arguments.words)
    if action == "plan":
        plan = sweep.plan(file, workers=arguments.workers)
        output.result(plan, said.planned(plan))
        return PASSED
    if action == "show":
        shown = sweep.show(file, arguments.out)
        output.result(shown, said.shown(shown))
        return PASSED
    result = sweep.run(file, out=arguments.out, workers=arguments.workers, scheduler=arguments.scheduler,
                       progress=output.note)
    output.result(result, said.ran(result))
    if not set(result["statuses"]) & {"done", "incomplete"}:
        return ENGINE if set(result["statuses"]) - {"invalid", "refused"} else FAILED
    return PASSED if result["feasible"] else FAILED


# measure


def _measure_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("stl", metavar="STL", help="any STL file, in mm")


def _measure(arguments: argparse.Namespace, output: Output) -> int:
    from handgen.checks.mesh_report import measure_stl

    report = measure_stl(arguments.stl)
    if arguments.out is not None:
        os.makedirs(arguments.out, exist_ok=True)
        with open(os.path.join(arguments.out, "measure.json"), "w", encoding="utf-8") as file:
            file.write(json.dumps(report, indent=2, allow_nan=False) + "\n")
    output.result(report, tables.measured(report, output.style))
    return PASSED if report["passed"] else FAILED


# diff


def _diff_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("params", metavar="A", help="parameter file, e.g. params/adult.yaml")
    parser.add_argument("other", metavar="B", help="another one, e.g. a variant of it")
    parser.add_argument("--quick", action="store_true",
                        help="only what is known without making a part or running a rule")
    parser.add_argument("--bend", dest="solving", action="store_true",
                        help="solve the bends that are not known yet (seconds a finger)")
    parser.add_argument("--workers", type=_count, default=None, metavar="N",
                        help="processes to work with (default: one a core)")


def _diff(arguments: argparse.Namespace, output: Output) -> int:
    from handgen.diff import diff, said

    result = diff(arguments.params, arguments.other, arguments.out, quick=arguments.quick,
                  solving=arguments.solving, progress=output.note, workers=arguments.workers)
    output.result(result, said.told(result, output.style))
    return FAILED if result["b"]["passed"] is False else PASSED


# report


def _report_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("params", metavar="PARAMS", help="parameter file, e.g. params/adult.yaml")
    parser.add_argument("--fingers", metavar="NAME", nargs="+", action="extend",
                        help="bend only these, or none (all)")
    parser.add_argument("--workers", type=_count, default=None, metavar="N",
                        help="processes to work with (default: one a core)")


def _report(arguments: argparse.Namespace, output: Output) -> int:
    from handgen.report import report

    result = report(arguments.params, arguments.out, arguments.fingers, progress=output.note,
                    workers=arguments.workers)
    output.result(result, tables.reported(result, output.style))
    return PASSED if result["passed"] else FAILED


# view


def _view_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("params", metavar="PARAMS", help="parameter file, e.g. params/adult.yaml")
    parser.add_argument("--port", type=_port, default=8765, metavar="N",
                        help="of 127.0.0.1; 0 takes any that is free (8765)")
    parser.add_argument("--workers", type=_count, default=None, metavar="N",
                        help="processes to work with (default: one a core)")


def _view(arguments: argparse.Namespace, output: Output) -> int:
    from handgen.report.view import view

    view(arguments.params, arguments.out, arguments.port, workers=arguments.workers, progress=output.note)
    return PASSED


# schema


def _schema_arguments(parser: argparse.ArgumentParser) -> None:
    """No arguments of its own."""


def _schema(arguments: argparse.Namespace, output: Output) -> int:
    from handgen.parameters.schema import json_schema

    text = json.dumps(json_schema(), indent=2)
    if arguments.out is None:
        print(text, file=output.results)
        return PASSED
    os.makedirs(arguments.out, exist_ok=True)
    path = os.path.join(arguments.out, "hand.schema.json")
    with open(path, "w", encoding="utf-8") as file:
        file.write(text + "\n")
    output.result({"schema": path}, path)
    return PASSED


VERBS = {
    "check": Verb("run every design rule and say what will fail", _check_arguments, _check),
    "build": Verb("make the printable, castable parts of a parameter file", _build_arguments, _build),
    "bend": Verb("how a finger moves under pressure, weights, an obstacle", _bend_arguments, _bend),
    "slice": Verb("print time and filament of every part, from PrusaSlicer and Cura", _slice_arguments,
                  _slice),
    "profiles": Verb("write slicer profiles of the print settings (to slicer_profiles/)", _profiles_arguments,
                     _profiles),
    "worksheet": Verb("a page that leads through printing, casting, sealing, assembling",
                      _worksheet_arguments, _worksheet),
    "validate": Verb("bend what was measured and say how far each model is off", _validate_arguments,
                     _validate),
    "effects": Verb("physical effects that a model file can switch on", _effects_arguments, _effects),
    "diagnose": Verb("find what a model lacks to explain measurements, and add it", _diagnose_arguments,
                     _diagnose),
    "measurements": Verb("measurements files from tables (CSV)", _measurements_arguments, _measurements),
    "sweep": Verb("vary what a hand is made of, compare the variants, find the best", _sweep_arguments,
                  _sweep),
    "measure": Verb("size, volume, walls and watertightness of any STL", _measure_arguments, _measure),
    "diff": Verb("what changes between two parameter files: parts, masses, times, rules, bend",
                 _diff_arguments, _diff),
    "report": Verb("write one page that shows the whole design", _report_arguments, _report),
    "view": Verb("serve that page on this machine, anew at every save", _view_arguments, _view),
    "schema": Verb("print the JSON Schema of parameter files (for editors)", _schema_arguments, _schema),
}


# Parsing


class _Parser(argparse.ArgumentParser):
    """Reports a wrong command line like any other bad input."""

    def error(self, message: str) -> NoReturn:
        raise InputError([Problem(COMMAND_LINE, "", None, message, allowed=self.format_usage().strip())])


def _count(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is no whole number of at least 1")
    return int(text)


def _whole(text: str) -> int:
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"{text!r} is no whole number")
    return int(text)


def _port(text: str) -> int:
    if not text.isdecimal() or int(text) > 65535:
        raise argparse.ArgumentTypeError(f"{text!r} is no port: 0 to 65535")
    return int(text)


def _parser() -> _Parser:
    parser = _Parser(prog="handgen", allow_abbrev=False,
                     description="From one parameter file to a soft pneumatic hand that can be "
                                 "printed, cast and assembled.")
    parser.add_argument("--version", action="version", version=f"handgen {__version__}")
    verbs = parser.add_subparsers(dest="verb", metavar="VERB", required=True)
    for name, verb in VERBS.items():
        sub = verbs.add_parser(name, help=verb.help, description=verb.help, allow_abbrev=False)
        verb.arguments(sub)
        sub.add_argument("--out", metavar="DIR", help="output folder (default: outputs/<name>/)")
        sub.add_argument("--json", action="store_true", help="results as JSON on standard output")
        sub.add_argument("--quiet", action="store_true", help="no progress, no tables")
    return parser


def _parse(argv: Sequence[str]) -> argparse.Namespace:
    """The parsed command line.

    Raises:
        InputError: unknown verb or options, each with the nearest valid one.
    """
    first = next((word for word in argv if not word.startswith("-")), None)
    if first is not None and first not in VERBS:
        raise InputError([Problem(COMMAND_LINE, "VERB", first, "unknown verb", "one of " + ", ".join(VERBS),
                                  _nearest(first, VERBS))])
    parser = _parser()
    arguments, unknown = parser.parse_known_args(argv)
    if unknown:
        options = _options(parser, arguments.verb)
        raise InputError([
            Problem(COMMAND_LINE, word.split("=")[0], word, f"`{arguments.verb}` does not know this",
                    "one of " + ", ".join(options), _nearest(word.split("=")[0], options))
            for word in unknown])
    return arguments


def _options(parser: argparse.ArgumentParser, verb: str) -> list[str]:
    subparsers = next(a for a in parser._actions if isinstance(a, argparse._SubParsersAction))
    return [o for action in subparsers.choices[verb]._actions for o in action.option_strings]


def _nearest(word: str, valid: Sequence[str] | dict) -> str | None:
    return next(iter(difflib.get_close_matches(word, list(valid), n=1, cutoff=0.5)), None)


# Running


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit code. Only `--help` and `--version` end in SystemExit."""
    argv = sys.argv[1:] if argv is None else list(argv)
    sys.stdout, sys.stderr = (stream or io.StringIO() for stream in (sys.stdout, sys.stderr))
    try:
        code = _run(argv, Output(sys.stdout, sys.stderr, "--json" in argv, "--quiet" in argv))
        sys.stdout.flush()
        return code
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:
        # The reader has left; Python's own flush at exit must not complain about it again.
        with contextlib.suppress(OSError, ValueError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return PIPE_CLOSED


def _run(argv: Sequence[str], output: Output) -> int:
    file = COMMAND_LINE
    try:
        arguments = _parse(argv)
        file = getattr(arguments, "params", file)
        with _results_alone() as results:
            code = VERBS[arguments.verb].run(arguments, replace(output, results=results))
            results.flush()
        return code
    except InputError as error:
        return _refuse(error.problems, output)
    except GeometryError as error:
        return _refuse([Problem(file, error.path, None, f"{error.part}: {error.message}")], output)
    except EngineError as error:
        return _give_up(str(error), file, output)
    except (BrokenPipeError, KeyboardInterrupt):
        raise
    except OSError as error:
        message = error.strerror or str(error)
        if error.errno in USERS_ERRORS:
            return _refuse([Problem(str(error.filename or file), "", None, message)], output)
        return _give_up(message, str(error.filename or file), output)
    except Exception:
        import traceback

        traceback.print_exc(file=output.people)
        print("handgen: this is a mistake in handgen itself; please report it", file=output.people)
        return INTERNAL


def _refuse(problems: Sequence[Problem], output: Output) -> int:
    """Every error, by file: as the contract's JSON or for people."""
    if output.as_json:
        output.result({"errors": [problem.as_dict() for problem in problems]})
        return BAD_INPUT
    for file in dict.fromkeys(problem.file for problem in problems):
        print(output.style(file, "1"), file=output.people)
        for problem in (p for p in problems if p.file == file):
            print(_sentence(problem, output), file=output.people)
    count = len(problems)
    print(f"{count} error{'s' if count > 1 else ''}; nothing was written", file=output.people)
    return BAD_INPUT


def _sentence(problem: Problem, output: Output) -> str:
    where = output.style(problem.path, "31") + ": " if problem.path else ""
    got = "" if problem.value is None else f", got {problem.value!r}"
    allowed = f"\n      allowed: {problem.allowed}" if problem.allowed else ""
    mend = f"\n      did you mean {output.style(problem.suggestion, '32')}?" if problem.suggestion else ""
    return f"  {where}{problem.message}{got}{allowed}{mend}"


def _give_up(message: str, file: str, output: Output) -> int:
    if output.as_json:
        output.result({"errors": [Problem(file, "", None, message).as_dict()]})
    print(f"handgen: {message}", file=output.people)
    return ENGINE


@contextlib.contextmanager
def _results_alone() -> Iterator[TextIO]:
    """Standard output for results alone: what CAD kernels print there goes to standard error."""
    stdout = sys.stdout
    try:
        saved = os.dup(1)
        own = stdout.fileno() == 1
    except io.UnsupportedOperation:
        own = False
    except OSError:
        yield stdout
        return
    stdout.flush()
    os.dup2(2, 1)
    results = os.fdopen(os.dup(saved), "w", encoding="utf-8") if own else stdout
    try:
        with contextlib.redirect_stdout(sys.stderr):
            yield results
    finally:
        os.dup2(saved, 1)
        os.close(saved)
        if own:
            with contextlib.suppress(BrokenPipeError):
                results.close()


if __name__ == "__main__":
    sys.exit(main())
