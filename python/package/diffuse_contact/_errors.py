"""Exceptions. Every one has a ``code``, the stable word that the Rust error of the same reason has."""


class DiffuseContactError(Exception):
    """Something cannot be computed from what was given.

    Attributes:
        code: stable machine-readable word, such as ``"singular-fit"``.
        message: a sentence with the numbers that led to it.

    """

    def __init__(self, message: str, code: str) -> None:
        super().__init__(message, code)
        self.message = message
        self.code = code

    def __str__(self) -> str:
        return f"{self.message} [{self.code}]"


class InputError(DiffuseContactError, ValueError):
    """An argument has the wrong shape or type, or is none of the values there are."""


class ElementError(DiffuseContactError, ArithmeticError):
    """An element has no result. ``index`` is its place in the batch."""

    def __init__(self, message: str, code: str, index: int | None = None) -> None:
        super().__init__(message, code)
        self.index = index


class SurfaceError(DiffuseContactError, ValueError):
    """Facets and positions are no surface."""


class InterfaceError(DiffuseContactError, ValueError):
    """An interface cannot be made, paired or evaluated."""


class AssemblyError(DiffuseContactError, ValueError):
    """Nothing can be assembled."""


class BusyError(DiffuseContactError, RuntimeError):
    """The object is in use by another thread."""
