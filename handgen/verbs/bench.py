"""Verbs for the one who prints and casts."""

from __future__ import annotations

import argparse

from handgen import tables
from handgen.verbs import argument
from handgen.verbs.verb import ENGINE, FAILED, PASSED, Output, Verb

# slice


def _slice_arguments(parser: argparse.ArgumentParser) -> None:
    argument.params(parser)
    parser.add_argument("--slicer", dest="slicers", metavar="NAME", nargs="+", action="extend",
                        help="prusaslicer, cura (both)")
    parser.add_argument("--part", dest="parts", metavar="NAME", nargs="+", action="extend",
                        help="only these parts: names or globs (index*, tooling/*)")
    parser.add_argument("--workers", type=argument.count, default=None, metavar="N",
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
    argument.params(parser)


def _profiles(arguments: argparse.Namespace, output: Output) -> int:
    from handgen.slicing.profile_files import write

    written = write(arguments.params, arguments.out)
    output.result({"files": written}, "\n".join(written))
    return PASSED


# worksheet


def _worksheet_arguments(parser: argparse.ArgumentParser) -> None:
    argument.params(parser)
    parser.add_argument("--moulds", type=argument.count, default=None, metavar="N",
                        help="moulds that stand filled at once (casting.mould_sets)")


def _worksheet(arguments: argparse.Namespace, output: Output) -> int:
    from handgen.worksheet import worksheet

    result = worksheet(arguments.params, out=arguments.out, moulds=arguments.moulds, progress=output.note)
    output.result(result, tables.planned(result))
    return PASSED


VERBS = {
    "slice": Verb("print time and filament of every part, from PrusaSlicer and Cura", _slice_arguments,
                  _slice),
    "profiles": Verb("write slicer profiles of the print settings (to slicer_profiles/)", _profiles_arguments,
                     _profiles),
    "worksheet": Verb("a page that leads through printing, casting, sealing, assembling",
                      _worksheet_arguments, _worksheet),
}
