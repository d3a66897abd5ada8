"""The threads that evaluate, and the instructions they use."""

from . import _native
from ._arrays import count
from ._errors import InputError


def set_threads(number: int | None) -> None:
    """Sets the number of threads of this process, 1 to 1024.

    ``None`` stands for the environment variable ``RAYON_NUM_THREADS`` or, without it, one per core. Under MPI, where
    every rank is a process, 1 is right. Results do not depend on it.
    """
    _native.set_threads(None if number is None else count("the number of threads", number))


def thread_count() -> int:
    """Number of threads that evaluate in this process; 1 where none could be started."""
    return _native.thread_count()


def set_isa(name: str) -> None:
    """Chooses the vector instructions of this process: ``"scalar"``, ``"avx2"``, ``"avx512"`` or ``"neon"``.

    To be called before the first evaluation. Without it the widest are used that the machine has, or those that the
    environment variable ``DIFFUSE_CONTACT_ISA`` names. Results with different instructions differ by rounding.

    Raises:
        InputError: if the machine does not have them, or others have been in use before.

    """
    if not isinstance(name, str):
        message = f"the name of instructions is a text, not {name!r}"
        raise InputError(message, "invalid-option")
    _native.set_isa(name)


def isa() -> str:
    """The vector instructions in use, such as ``"avx2"``."""
    return _native.isa()
