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
import os
import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NoReturn, TextIO

from handgen import __version__
from handgen.errors import EngineError, GeometryError, InputError, Problem
from handgen.verbs import VERBS
from handgen.verbs.verb import BAD_INPUT, ENGINE, Output

INTERNAL, INTERRUPTED, PIPE_CLOSED = 70, 130, 141
COMMAND_LINE = "command line"
USERS_ERRORS = {errno.EACCES, errno.EPERM, errno.EROFS, errno.ENOTDIR, errno.EISDIR, errno.EEXIST,
                errno.ENOENT, errno.ENAMETOOLONG, errno.EINVAL, errno.ELOOP}
"""System errors that another path would mend; a full disk is none of them."""


# Parsing


class _Parser(argparse.ArgumentParser):
    """Reports a wrong command line like any other bad input."""

    def error(self, message: str) -> NoReturn:
        raise InputError([Problem(COMMAND_LINE, "", None, message, allowed=self.format_usage().strip())])


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
