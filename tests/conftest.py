"""Shared fixtures: the shipped hands, loaded once."""

from pathlib import Path

import pytest

PARAMS = Path(__file__).parent.parent / "params"


@pytest.fixture(scope="session")
def adult():
    from handgen.parameters.load import load

    return load(PARAMS / "adult.yaml").hand
