"""Verbs that make or judge the parts of a hand."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from handgen import atomic, tables
from handgen.verbs import argument
from handgen.verbs.verb import FAILED, PASSED, Output, Verb

# build


def _build_arguments(parser: argparse.ArgumentParser) -> None:
    argument.params(parser)
    parser.add_argument("--part", dest="parts", metavar="NAME", nargs="+", action="extend",
                        help="only these parts: names or globs (index*, tooling/*)")
    parser.add_argument("--no-verify", dest="verify", action="store_false",
                        help="write even a design that fails a rule; the manifest says so")
    argument.workers(parser)


def _build(arguments: argparse.Namespace, output: Output) -> int:
    from handgen.builder import build

    result = build(arguments.params, out=arguments.out, parts=arguments.parts, verify=arguments.verify,
                   progress=output.note, workers=arguments.workers)
    output.result(result, tables.built(result, output.style))
    return PASSED if result["passed"] else FAILED


# check


def _check_arguments(parser: argparse.ArgumentParser) -> None:
    argument.params(parser)
    argument.workers(parser)


def _check(arguments: argparse.Namespace, output: Output) -> int:
    from handgen.builder import check

    result = check(arguments.params, out=arguments.out, progress=output.note, workers=arguments.workers)
    output.result(result["checks"], tables.checked(result, output.style))
    return PASSED if result["passed"] else FAILED


# measure


def _measure_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("stl", metavar="STL", help="any STL file, in mm")


def _measure(arguments: argparse.Namespace, output: Output) -> int:
    from handgen.checks.mesh_report import measure_stl

    report = measure_stl(arguments.stl)
    if arguments.out is not None:
        text = json.dumps(report, indent=2, allow_nan=False) + "\n"
        atomic.write(Path(arguments.out) / "measure.json", text)
    output.result(report, tables.measured(report, output.style))
    return PASSED if report["passed"] else FAILED


# schema


def _schema_arguments(parser: argparse.ArgumentParser) -> None:
    """No arguments of its own."""


def _schema(arguments: argparse.Namespace, output: Output) -> int:
    from handgen.parameters.schema import json_schema

    text = json.dumps(json_schema(), indent=2)
    if arguments.out is None:
        print(text, file=output.results)
        return PASSED
    path = Path(arguments.out) / "hand.schema.json"
    atomic.write(path, text + "\n")
    output.result({"schema": str(path)}, str(path))
    return PASSED


VERBS = {
    "build": Verb("make the printable, castable parts of a parameter file", _build_arguments, _build),
    "check": Verb("run every design rule and say what will fail", _check_arguments, _check),
    "measure": Verb("size, volume, walls and watertightness of any STL", _measure_arguments, _measure),
    "schema": Verb("print the JSON Schema of parameter files (for editors)", _schema_arguments, _schema),
}
