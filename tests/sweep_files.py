"""Sweeps for tests: small files, and a solver that answers at once or misbehaves on purpose."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import yaml

from tests import bend_stub
from tests.strategies import PARAMS

ROOT = PARAMS.parent
SMALL = {
    "schema": "handgen.sweep/1", "name": "small", "base": str(PARAMS / "adult.yaml"),
    "vary": {"fingers.index.joints.*.slot_length": [8, 9, 10], "layers.internal": [1.4, 1.5]},
    "solver": "stub", "bend": {"pressures": [0, 20]}, "objectives": {"bend_angle_deg": "maximise"},
}


def sweep_file(folder: Path, **values) -> Path:
    """The small sweep with other values at its keys; None takes a key away."""
    data = {k: v for k, v in {**SMALL, **values}.items() if v is not None}
    path = Path(folder) / "sweep.yaml"
    path.write_text(yaml.safe_dump(data, sort_keys=False), encoding="utf-8")
    return path


def process(folder: Path, *arguments: str, **environment) -> subprocess.Popen:
    """`handgen sweep ... --json` in a process group of its own, the stub installed."""
    return subprocess.Popen(
        [sys.executable, "-m", "handgen.cli", "sweep", *map(str, arguments), "--json"], cwd=folder, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True,
        env=surroundings(folder, **environment))


def surroundings(folder: Path, **environment) -> dict[str, str]:
    """The environment of sweeps and workers: the stub on the path, a store of its own."""
    if not (site := Path(folder) / "site").exists():
        bend_stub.install(site)
    return {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), str(site)]),
            "HANDGEN_CACHE": str(Path(folder) / "cache"), **environment}


def finished(running: subprocess.Popen, seconds: float = 120) -> tuple[int, dict]:
    """(exit code, JSON) of a process."""
    out, err = running.communicate(timeout=seconds)
    try:
        return running.returncode, json.loads(out)
    except ValueError:
        raise AssertionError(f"exit {running.returncode}: {out}\n{err}") from None
