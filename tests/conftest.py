"""Shared fixtures: the shipped hands, loaded once; a solver of another package."""

import signal
from pathlib import Path

import pytest

PARAMS = Path(__file__).parent.parent / "params"

# What runs in the background inherits an ignored Ctrl-C, and so would the commands that tests interrupt.
signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session")
def adult():
    from handgen.parameters.load import load

    return load(PARAMS / "adult.yaml").hand


@pytest.fixture
def stub(monkeypatch, tmp_path):
    """Hangs in `tests.bend_stub` as another package would; returns the folder of the cache."""
    from handgen.bending import solvers
    from tests import bend_stub

    monkeypatch.setattr(solvers, "entry_points",
                        lambda group: [bend_stub.ENTRY] if group == solvers.GROUP else [])
    cache = tmp_path / "cache"
    monkeypatch.setenv("HANDGEN_CACHE", str(cache))
    return cache
