"""What tests of `handgen bend` share: files, the command in this process or in one of its own."""

import json
import os
import subprocess
import sys
from pathlib import Path

import yaml

from handgen import cli
from tests import bend_stub
from tests.strategies import ADULT, PARAMS, write

ADULT_FILE = str(PARAMS / "adult.yaml")
ROOT = PARAMS.parent


def changed_file(folder: Path, **values) -> str:
    """The adult hand with values at key paths, dots written as double underscores."""
    data = json.loads(json.dumps(ADULT))
    for path, value in values.items():
        *keys, last = path.split("__")
        node = data
        for key in keys:
            node = node.setdefault(key, {})
        node[last] = value
    return str(write(data, folder))


def model_file(folder: Path, **values) -> str:
    """The model `literature` with other values."""
    data = yaml.safe_load((PARAMS / "models" / "literature.yaml").read_text(encoding="utf-8"))
    del data["assumed"]
    path = Path(folder) / "model.yaml"
    path.write_text(yaml.safe_dump(data | {"name": "own"} | values), encoding="utf-8")
    return str(path)


def command(capsys, *arguments: str) -> tuple[int, dict, str]:
    """(exit code, JSON, what people read) of `handgen bend ... --json`."""
    code = cli.main(["bend", *arguments, "--json"])
    out, err = capsys.readouterr()
    return code, json.loads(out), err


def process(folder: Path, *arguments: str, **environment) -> subprocess.Popen:
    """`handgen bend` in a process of its own, in `folder`, with the stub installed there."""
    if not (site := Path(folder) / "site").exists():
        bend_stub.install(site)
    path = os.pathsep.join([str(ROOT), str(site)])
    return subprocess.Popen(
        [sys.executable, "-m", "handgen.cli", "bend", ADULT_FILE, *arguments], cwd=folder, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        env={**os.environ, "PYTHONPATH": path, "HANDGEN_CACHE": str(Path(folder) / "cache"), **environment})
