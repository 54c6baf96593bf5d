"""Verbs that ask the simulation: bends, what was measured, what a model lacks, many hands."""

from __future__ import annotations

import argparse

from handgen import tables
from handgen.verbs import argument
from handgen.verbs.verb import ENGINE, FAILED, PASSED, Output, Verb

# bend


def _bend_arguments(parser: argparse.ArgumentParser) -> None:
    argument.params(parser)
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
                        help="solid, rod, reference, revolution for a free actuator, or one that another "
                             "package brings (solid); section for the opposition")
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
    parser.add_argument("--seed", type=argument.whole, default=0, metavar="N",
                        help="of the fingers within tolerance (0)")
    parser.add_argument("--workers", type=argument.count, default=2, metavar="N",
                        help="processes to simulate with (2)")


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
    parser.add_argument("--workers", type=argument.count, default=None, metavar="N",
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
    return PASSED if result["feasible"] and result["held"] != 0 else FAILED


VERBS = {
    "bend": Verb("how a finger moves under pressure, weights, an obstacle", _bend_arguments, _bend),
    "validate": Verb("bend what was measured and say how far each model is off", _validate_arguments,
                     _validate),
    "effects": Verb("physical effects that a model file can switch on", _effects_arguments, _effects),
    "diagnose": Verb("find what a model lacks to explain measurements, and add it", _diagnose_arguments,
                     _diagnose),
    "measurements": Verb("measurements files from tables (CSV)", _measurements_arguments, _measurements),
    "sweep": Verb("vary what a hand is made of, compare the variants, find the best", _sweep_arguments,
                  _sweep),
}
