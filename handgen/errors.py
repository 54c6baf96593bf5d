"""The few errors a caller can catch; each says what is wrong, where, and how to mend it."""

from __future__ import annotations

from dataclasses import asdict, dataclass


class HandgenError(Exception):
    """Base of every error that handgen raises on purpose."""


@dataclass(frozen=True)
class Problem:
    """One thing wrong with an input, as the contract's `errors` list states it."""

    file: str
    path: str
    value: object
    message: str
    allowed: str | None = None
    suggestion: str | None = None

    def as_dict(self) -> dict:
        return asdict(self)

    def __str__(self) -> str:
        text = f"{self.file}: {self.path or '(whole file)'}: {self.message}"
        if self.value is not None:
            text += f" (got {self.value!r})"
        if self.allowed:
            text += f"; allowed: {self.allowed}"
        if self.suggestion:
            text += f"; did you mean {self.suggestion!r}?"
        return text


class InputError(HandgenError):
    """Bad input: carries all of its problems at once. Exit code 2; nothing was written."""

    def __init__(self, problems: list[Problem]):
        self.problems = list(problems)
        super().__init__("\n".join(map(str, self.problems)))


class GeometryError(HandgenError):
    """A part cannot be made from otherwise valid parameters.

    `path` is the key path of the parameter to change; `part` the part that fails.
    """

    def __init__(self, part: str, path: str, message: str):
        self.part, self.path, self.message = part, path, message
        super().__init__(f"{part}: {message} (change {path})")


class EngineError(HandgenError):
    """An engine (CAD kernel, solver, slicer, renderer) gave up; says how far it got. Exit code 3."""
