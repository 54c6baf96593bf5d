"""A diagnosis that is interrupted, or killed, keeps every bend that was solved and leaves no worker."""

import os
import re
import signal
import subprocess
import sys
import time

import pytest

COUNT = 30
SCRIPT = f"""
from dataclasses import replace
from handgen.bending.model import load_model
from handgen.cli import main
from handgen.discrepancy import run
from handgen.discrepancy.simulated import Simulation
from handgen.discrepancy.worker import Bends
from handgen.measurements.load import load_measurements

def bends(measurements, progress, workers, **others):
    measured = load_measurements(measurements)
    test = measured.test("actuator-pressure")
    found = Bends(workers, progress)
    simulation = Simulation(measured, [test], load_model("literature")[0], found)
    row = simulation.row().requests[0]
    found.curves([replace(row, case=replace(row.case, pressures=(1e-3 + 1e-5 * i,))) for i in range({COUNT})],
                 "bends")
    progress(f"solved {{found.solved}}")
    raise SystemExit(0)

if __name__ == "__main__":
    run.diagnose = bends
    raise SystemExit(main(["diagnose", "params/measurements/coimbra_index.yaml"]))
"""


def begun(script, cache):
    return subprocess.Popen(
        [sys.executable, str(script)], stderr=subprocess.PIPE, text=True, start_new_session=True,
        env={**os.environ, "HANDGEN_CACHE": str(cache), "PYTHONPATH": os.getcwd()})


def until(process, pattern):
    for line in process.stderr:
        if found := re.search(pattern, line):
            return found
    return pytest.fail(f"no line with {pattern}")


def session(leader):
    """Processes that `leader` began, itself left out."""
    found = subprocess.run(["ps", "-o", "pid=", "-s", str(leader)], capture_output=True, text=True).stdout
    return {int(pid) for pid in found.split()} - {leader}


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGKILL])
def test_nothing_that_was_solved_is_lost(how, tmp_path):
    (tmp_path / "script.py").write_text(SCRIPT)
    process = begun(tmp_path / "script.py", tmp_path / "cache")
    done = int(until(process, r"bends: (\d+) of").group(1))
    os.kill(process.pid, how)
    assert process.wait(60) == (130 if how == signal.SIGINT else -signal.SIGKILL)
    process.stderr.close()
    end = time.monotonic() + 60
    while session(process.pid) and time.monotonic() < end:
        time.sleep(0.2)
    assert not session(process.pid)
    kept = len(list((tmp_path / "cache" / "bend").glob("*.npz")))
    assert done <= kept
    again = begun(tmp_path / "script.py", tmp_path / "cache")
    assert int(until(again, r"solved (\d+)").group(1)) == COUNT - kept
    assert again.wait(60) == 0
    again.stderr.close()
