"""Shared fixtures: the shipped hands, loaded once."""

from pathlib import Path

import pytest

PARAMS = Path(__file__).parent.parent / "params"


@pytest.fixture(scope="session")
def adult():
    import yaml

    from handgen.parameters.model import Hand

    return Hand.model_validate(yaml.safe_load((PARAMS / "adult.yaml").read_text()))
