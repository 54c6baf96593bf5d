"""Verbs that show a design, or what changes between two."""

from __future__ import annotations

import argparse

from handgen import tables
from handgen.verbs import argument
from handgen.verbs.verb import FAILED, PASSED, Output, Verb

# report


def _report_arguments(parser: argparse.ArgumentParser) -> None:
    argument.params(parser)
    parser.add_argument("--fingers", metavar="NAME", nargs="+", action="extend",
                        help="bend only these, or none (all)")
    argument.workers(parser)


def _report(arguments: argparse.Namespace, output: Output) -> int:
    from handgen.report import report

    result = report(arguments.params, arguments.out, arguments.fingers, progress=output.note,
                    workers=arguments.workers)
    output.result(result, tables.reported(result, output.style))
    return PASSED if result["passed"] else FAILED


# view


def _view_arguments(parser: argparse.ArgumentParser) -> None:
    argument.params(parser)
    parser.add_argument("--port", type=argument.port, default=8765, metavar="N",
                        help="of 127.0.0.1; 0 takes any that is free (8765)")
    argument.workers(parser)


def _view(arguments: argparse.Namespace, output: Output) -> int:
    from handgen.report.view import view

    view(arguments.params, arguments.out, arguments.port, workers=arguments.workers, progress=output.note)
    return PASSED


# diff


def _diff_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("params", metavar="A", help="parameter file, e.g. params/adult.yaml")
    parser.add_argument("other", metavar="B", help="another one, e.g. a variant of it")
    parser.add_argument("--quick", action="store_true",
                        help="only what is known without making a part or running a rule")
    parser.add_argument("--bend", dest="solving", action="store_true",
                        help="solve the bends that are not known yet (seconds a finger)")
    argument.workers(parser)


def _diff(arguments: argparse.Namespace, output: Output) -> int:
    from handgen.diff import diff, said

    result = diff(arguments.params, arguments.other, arguments.out, quick=arguments.quick,
                  solving=arguments.solving, progress=output.note, workers=arguments.workers)
    output.result(result, said.told(result, output.style))
    return FAILED if result["b"]["passed"] is False else PASSED


VERBS = {
    "report": Verb("write one page that shows the whole design", _report_arguments, _report),
    "view": Verb("serve that page on this machine, anew at every save", _view_arguments, _view),
    "diff": Verb("what changes between two parameter files: parts, masses, times, rules, bend",
                 _diff_arguments, _diff),
}
