"""The output folder: owned, locked, and exchanged as a whole.

A build is written into a staging folder beside the final one and takes its place in a single
step, so that a kill at any moment leaves the old build or the new one. Files that stay the same
are hard links to the old build's, and files that the build does not own move over with it.
"""

from __future__ import annotations

import ctypes
import errno
import fcntl
import hashlib
import json
import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from handgen.errors import InputError, Problem

MANIFEST = "manifest.json"
CHECKS = "checks.json"
SCHEMAS = {MANIFEST: "handgen.manifest/1", CHECKS: "handgen.checks/1"}
"""By its index a folder is known as handgen's: a build's by the manifest, a check's by its report."""
CHECK_FOLDER = "checks"
RESULTS = (CHECK_FOLDER, "bend", "slices", "worksheet", "report", "diff")
"""What other verbs put beside a build: folders, or files of these names."""
RENAME_EXCHANGE = 2
AT_FDCWD = -100


class Store:
    """The folder `final` with what lies in it, if anything: a build, or what `index` names.

    Raises:
        InputError: `final` holds something that handgen did not write.
    """

    def __init__(self, final: Path, index: str = MANIFEST):
        self.final, self.index = final.resolve(), index
        self.name = self.final.name
        self.stage = self._beside("building", str(os.getpid()))
        self._check_owned()

    def _beside(self, what: str, which: str = "") -> Path:
        return self.final.parent / f".{self.name}.{what}{'-' + which if which else ''}"

    def _check_owned(self) -> None:
        def refuse(message: str) -> InputError:
            return InputError([Problem("--out", "", str(self.final), message,
                                       "a new or empty folder, or one that handgen built")])

        if self.final.is_file():
            raise refuse("is a file")
        if self.final == self.final.parent or os.path.ismount(self.final):
            raise refuse("is a mount point, which cannot be exchanged")
        if not self.final.exists() or all(self._of_a_verb(entry) for entry in self.final.iterdir()):
            return
        try:
            schema = json.loads((self.final / self.index).read_bytes())["schema"]
        except (OSError, ValueError, KeyError, TypeError):
            raise refuse(f"holds files and no {self.index} of handgen: not touched") from None
        if schema != SCHEMAS[self.index]:
            raise refuse(f"was written as {schema!r}; this version knows {SCHEMAS[self.index]!r}")

    def _of_a_verb(self, entry: Path) -> bool:
        """Whether `entry` is another verb's folder, or a lock or staging folder of one."""
        name = entry.name.removeprefix(".").split(".")[0]
        return self.index == MANIFEST and name in RESULTS

    @contextmanager
    def locked(self, waiting: Callable[[], None]) -> Iterator[int]:
        """Hold the folder against other builds; calls `waiting` if one is running.

        Yields a descriptor. Whoever inherits it holds the lock too, so that the workers of a
        killed build are waited for before their staging folder is taken away.
        """
        self.final.parent.mkdir(parents=True, exist_ok=True)
        lock = os.open(self._beside("lock"), os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
        try:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                waiting()
                fcntl.flock(lock, fcntl.LOCK_EX)
            self._recover()
            self._check_owned()
            yield lock
        finally:
            os.close(lock)

    def _recover(self) -> None:
        """Clear what a killed build left; under the lock every staging folder is stale."""
        aside = self._beside("previous")
        if aside.exists() and not self.final.exists():
            aside.rename(self.final)
        for stale in (aside, *self.final.parent.glob(f".{self.name}.building-*")):
            shutil.rmtree(stale, ignore_errors=True)

    def manifest(self) -> dict | None:
        """The manifest of the build in the folder."""
        try:
            return json.loads((self.final / MANIFEST).read_bytes())
        except FileNotFoundError:
            return None

    def report(self) -> dict | None:
        """The rules' report of the build in the folder; None if it is missing or damaged."""
        try:
            return json.loads((self.final / CHECKS).read_bytes())
        except (OSError, ValueError):
            return None

    def intact(self, files: dict[str, str]) -> bool:
        """Whether all `files` (path -> sha256) lie in the folder unchanged."""
        return all(digest_file(self.final / path) == sha for path, sha in files.items())

    def reuse(self, files: dict[str, str]) -> None:
        """Bring unchanged files of the old build into the staging folder."""
        for path in files:
            _link(self.final / path, self.stage / path)

    def same(self, contents: dict[str, bytes]) -> bool:
        """Whether the folder's files (path -> content) are these already."""
        return all(digest_file(self.final / path) == hashlib.sha256(content).hexdigest()
                   for path, content in contents.items())

    def write(self, contents: dict[str, bytes]) -> None:
        """New files (path -> content) into the staging folder."""
        for path, content in contents.items():
            target = self.stage / path
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(content)

    def carry_over(self, owned: set[str]) -> None:
        """Bring over whatever else lies in the folder: a user's notes, other verbs' results.

        `owned` are paths of files that the build replaces or drops, and of whole folders.
        """
        for folder, folders, files in os.walk(self.final):
            here = Path(folder).relative_to(self.final)
            for name in folders + files:
                source, path = Path(folder) / name, here / name
                if path.parts[0] in owned:
                    continue
                if source.is_dir() and not source.is_symlink():
                    if not any(o == str(path) or o.startswith(f"{path}/") for o in owned):
                        (self.stage / path).mkdir(parents=True, exist_ok=True)
                elif str(path) not in owned and not os.path.lexists(self.stage / path):
                    _link(source, self.stage / path)

    def commit(self) -> None:
        """Put the staging folder in the place of the final one."""
        _flush(self.stage)
        if not self.final.exists():
            self.stage.rename(self.final)
        elif not _exchange(self.stage, self.final):
            # Two steps: a kill between them leaves the old build aside, and the next run
            # brings it back.
            aside = self._beside("previous")
            self.final.rename(aside)
            self.stage.rename(self.final)
            shutil.rmtree(aside)
        _sync(self.final.parent)
        self.discard()

    def discard(self) -> None:
        shutil.rmtree(self.stage, ignore_errors=True)


def digest_file(path: Path) -> str | None:
    """sha256 of a file, None if there is none."""
    try:
        with open(path, "rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError:
        return None


def _link(source: Path, target: Path) -> None:
    target.parent.mkdir(parents=True, exist_ok=True)
    try:
        os.link(source, target, follow_symlinks=False)
    except OSError:  # a file system without hard links
        shutil.copy2(source, target, follow_symlinks=False)


def _flush(root: Path) -> None:
    """Everything under `root` on the disk, so that a power cut cannot follow the exchange."""
    for folder, _, files in os.walk(root):
        for name in files:
            path = Path(folder) / name
            if path.is_file() and not path.is_symlink() and path.stat().st_nlink == 1:
                _sync(path)
        _sync(Path(folder))


def _sync(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _exchange(one: Path, other: Path) -> bool:
    """Exchange two folders in one step (Linux); False where the system cannot."""
    try:
        rename = ctypes.CDLL(None, use_errno=True).renameat2
    except (OSError, AttributeError):
        return False
    if rename(AT_FDCWD, os.fsencode(one), AT_FDCWD, os.fsencode(other), RENAME_EXCHANGE) == 0:
        return True
    code = ctypes.get_errno()
    if code in (errno.ENOSYS, errno.EINVAL, errno.ENOTSUP):
        return False
    raise OSError(code, os.strerror(code), str(other))
