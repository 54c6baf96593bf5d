"""Sweeps that run: rows, store, resume, bad variants, kills, a scheduler of one's own."""

import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pandas as pd
import pytest

from handgen.sweep.store import MOST_DEATHS, Store
from handgen.sweep.work import retried
from tests.sweep_files import finished, process, surroundings, sweep_file

SPENT = ["wall_s"]
"""Columns that two runs need not share."""


def run(folder, *arguments, **environment):
    return finished(process(folder, *arguments, **environment))


def rows(folder):
    return pd.read_parquet(Path(folder) / "results.parquet")


def same(one, other):
    pd.testing.assert_frame_equal(one.drop(columns=SPENT), other.drop(columns=SPENT))


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """(folder, result, table) of the small sweep."""
    folder = tmp_path_factory.mktemp("sweep")
    code, result = run(folder, sweep_file(folder), "--out", "out", "--workers", "2")
    assert code == 0, result
    return folder, result, rows(folder / "out")


def test_one_row_a_variant(undisturbed):
    _, result, table = undisturbed
    assert result["statuses"] == {"done": 6} and result["computed"] == 6
    assert list(table["variant"]) == list(range(6)) and table["hash"].is_unique
    slot = "fingers.index.joints.*.slot_length"
    assert list(zip(table[slot], table["layers.internal"], strict=True)) == [
        (8, 1.4), (8, 1.5), (9, 1.4), (9, 1.5), (10, 1.4), (10, 1.5)]
    # The stub turns 0.02 rad a kPa.
    assert table["bend_angle_deg_20"].tolist() == pytest.approx([22.918] * 6, rel=1e-4)
    assert (table["hinge_strain"].diff().dropna() <= 1e-12).all()  # longer slots are bent less sharply
    assert result["best"][0]["variant"] == 0


def test_a_second_run_computes_nothing(undisturbed):
    folder, _, table = undisturbed
    code, result = run(folder, sweep_file(folder), "--out", "again", "--workers", "1", "--resume")
    assert code == 0 and result["computed"] == 0 and result["reused"] == 6
    pd.testing.assert_frame_equal(rows(folder / "again"), table)


def test_another_sweep_shares_what_is_the_same(undisturbed):
    folder, _, _ = undisturbed
    file = sweep_file(folder, name="other", vary={
        "layers.internal": [1.5], "fingers.index.joints.*.slot_length": [9, 11]})
    _, result = run(folder, file, "--out", "other", "--workers", "1")
    assert result["computed"] == 1 and result["reused"] == 1


def test_what_is_wrong_with_a_variant_is_its_row(tmp_path):
    file = sweep_file(tmp_path, vary={
        "layers.internal": [1.5, 50, 9.5], "fingers.index.joints.*.slot_length": [9], "bend.pressure": [20]})
    code, _ = run(tmp_path, file, "--out", "out", "--workers", "1")
    table = rows(tmp_path / "out")
    assert code == 0 and list(table["status"]) == ["done", "invalid", "invalid"]
    assert "layers.internal: too large" in table["reason"][1]
    assert table["bend_angle_deg"].isna().tolist() == [False, True, True]


def test_a_solver_that_stops_is_incomplete_and_nothing_is_feasible(tmp_path):
    file = sweep_file(tmp_path, vary={"layers.internal": [1.5]})
    code, result = run(tmp_path, file, "--out", "out", "--workers", "1", STUB_STOPS_AT="10")
    assert code == 1 and result["statuses"] == {"incomplete": 1} and result["feasible"] == 0
    assert "reached 0 kPa" in rows(tmp_path / "out")["reason"][0]


def test_a_variant_that_hangs_or_kills_its_worker_is_a_row(tmp_path):
    """The watchdog ends the process itself: the stub's own sleep, or a kernel that never returns."""
    file = sweep_file(tmp_path, vary={"layers.internal": [1.5], "bend.pressure": [10, 98, 99]},
                      time_limit=15.0)
    badly = {"STUB_HANGS_AT": "98", "STUB_DIES_AT": "99"}
    code, _ = run(tmp_path, file, "--out", "out", "--workers", "2", **badly)
    table = rows(tmp_path / "out")
    assert code == 0 and list(table["status"]) == ["done", "timeout", "killed"]
    assert table["reason"][1].startswith("after 15 s, busy in")
    assert table["reason"][2] == f"its worker died {MOST_DEATHS} times"
    assert not list((tmp_path / "cache").rglob("*.attempts"))
    # What ran out of time is tried again only with more of it.
    _, again = run(tmp_path, file, "--out", "out", "--workers", "1", **badly)
    assert again["computed"] == 0
    assert retried({"status": "timeout", "limit_s": 2.0}, 3.0) and not retried({"status": "killed"}, 3.0)


def test_a_torn_row_is_none(tmp_path):
    store = Store(tmp_path)
    store.write("ab" * 32, {"status": "done", "x": 1.5})
    assert store.read("ab" * 32) == {"status": "done", "x": 1.5}
    path = store.path("ab" * 32)
    path.write_bytes(path.read_bytes()[:-3])
    assert store.read("ab" * 32) is None and store.read("cd" * 32) is None


SLOW = 24


def slow(folder, count=SLOW):
    """A sweep of `count` variants; those that take PAUSE seconds go out three at a time."""
    return sweep_file(folder, vary={"layers.internal": [1.5], "bend.pressure": {
        "low": 10, "high": 40, "steps": count}}, bend={})


PAUSE = "0.15"


def kill_in_the_middle(folder, seed, *, worker: bool):
    """Start the slow sweep, kill its parent (or one of its workers) at random, return what it then says."""
    pick = random.Random(seed)
    running = process(folder, slow(folder), "--out", "out", "--workers", "2", STUB_SECONDS=PAUSE,
                      STUB_LOG=str(folder / "begun"))
    store = folder / "cache" / "sweep"
    waiting = time.monotonic() + 60
    while not list(store.rglob("*.attempts")) and time.monotonic() < waiting:
        time.sleep(0.02)
    time.sleep(pick.uniform(0.0, 1.5))
    if not worker:
        os.kill(running.pid, signal.SIGKILL)
        running.communicate()
        return None
    if workers := workers_of(running.pid):
        os.kill(pick.choice(workers), signal.SIGKILL)
    return finished(running)


def workers_of(parent):
    """Processes that compute: children of `parent` that Python spawned, without its resource tracker."""
    found = []
    for entry in Path("/proc").iterdir():
        if not entry.name.isdecimal():
            continue
        try:
            status, command = (entry / "stat").read_text(), (entry / "cmdline").read_bytes()
        except OSError:
            continue
        if int(status.rsplit(")", 1)[1].split()[1]) == parent and b"spawn_main" in command:
            found.append(int(entry.name))
    return found


def kept(folder):
    return {p.name: p.stat().st_mtime_ns for p in (folder / "cache" / "sweep").rglob("*.json")}


def check_kills(tmp_path, seeds, *, worker):
    whole = tmp_path / "whole"
    whole.mkdir()
    finished(process(whole, slow(whole), "--out", "out", "--workers", "2"))
    wanted = rows(whole / "out")
    for seed in seeds:
        folder = tmp_path / f"kill{seed}"
        folder.mkdir()
        told = kill_in_the_middle(folder, seed, worker=worker)
        before = kept(folder)
        if told is None:
            code, result = run(folder, slow(folder), "--out", "out", "--workers", "2", "--resume",
                               STUB_LOG=str(folder / "begun"))
            assert code == 0 and result["reused"] >= len(before) and result["computed"] <= SLOW - len(before)
        else:
            assert told[0] == 0
        after, begun = kept(folder), (folder / "begun").read_text().splitlines()
        assert before.items() <= after.items() and len(after) == SLOW  # nothing finished is lost
        # Begun again is only what was on a worker when it died: one, or both with their parent.
        assert len(set(begun)) == SLOW and len(begun) <= SLOW + (1 if worker else 2)
        same(rows(folder / "out"), wanted)


def test_a_killed_parent_loses_nothing(tmp_path):
    check_kills(tmp_path, [1], worker=False)


def test_a_killed_worker_loses_nothing(tmp_path):
    check_kills(tmp_path, [1], worker=True)


@pytest.mark.slow
@pytest.mark.parametrize("worker", [False, True])
def test_ten_kills_lose_nothing(worker, tmp_path):
    check_kills(tmp_path, range(10), worker=worker)


class Hall:
    """A scheduler and workers, started by hand."""

    def __init__(self, folder):
        self.place = folder / "scheduler.json"
        self.quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "cwd": folder,
                      "env": surroundings(folder, STUB_SECONDS="0.3")}
        self.started = []
        self._start("dask_scheduler", "--port", "0")
        waiting = time.monotonic() + 60
        while not self.place.exists() and time.monotonic() < waiting:
            time.sleep(0.05)
        self.address = json.loads(self.place.read_text())["address"]

    def _start(self, what, *more):
        self.started.append(subprocess.Popen(
            [sys.executable, "-m", f"distributed.cli.{what}", "--scheduler-file", str(self.place),
             "--no-dashboard", *more], **self.quiet))
        return self.started[-1]

    def worker(self):
        return self._start("dask_worker", "--nthreads", "1")

    def __enter__(self):
        return self

    def __exit__(self, *error):
        for one in reversed(self.started):
            one.terminate()
        for one in self.started:
            one.wait(60)


def test_workers_started_by_hand_give_the_same_table(undisturbed, tmp_path):
    _, _, table = undisturbed
    with Hall(tmp_path) as hall:
        hall.worker()
        hall.worker()
        code, result = run(tmp_path, sweep_file(tmp_path), "--out", "out", "--scheduler", hall.address)
        assert code == 0 and result["computed"] == 6
        same(rows(tmp_path / "out"), table)


@pytest.mark.slow
def test_a_worker_that_comes_is_used_and_one_that_leaves_is_survived(tmp_path):
    """The first one leaves for good: without the second nothing would come to an end."""
    with Hall(tmp_path) as hall:
        first = hall.worker()
        running = process(tmp_path, slow(tmp_path), "--out", "out", "--scheduler", hall.address)
        waiting = time.monotonic() + 120
        while len(kept(tmp_path)) < 2 and time.monotonic() < waiting:
            time.sleep(0.05)
        hall.worker()
        first.terminate()
        first.wait(60)
        code, result = finished(running, 300)
        assert code == 0 and result["statuses"] == {"done": SLOW}
    found = rows(tmp_path / "out")
    # The stub turns 0.02 rad a kPa.
    assert found["bend_angle_deg"].tolist() == pytest.approx((found["bend.pressure"] * 1.1459156).tolist())


def test_no_scheduler_there(tmp_path):
    code, result = run(tmp_path, sweep_file(tmp_path), "--scheduler", "nonsense://1")
    assert code == 2 and result["errors"][0]["path"] == "--scheduler"
