"""Arguments that several verbs share, and the kinds of their values."""

from __future__ import annotations

import argparse


def params(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("params", metavar="PARAMS", help="parameter file, e.g. params/adult.yaml")


def workers(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--workers", type=count, default=None, metavar="N",
                        help="processes to work with (default: one a core)")


def count(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is no whole number of at least 1")
    return int(text)


def whole(text: str) -> int:
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"{text!r} is no whole number")
    return int(text)


def port(text: str) -> int:
    if not text.isdecimal() or int(text) > 65535:
        raise argparse.ArgumentTypeError(f"{text!r} is no port: 0 to 65535")
    return int(text)
