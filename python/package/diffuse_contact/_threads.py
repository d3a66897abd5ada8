"""The threads that evaluate."""

from . import _native
from ._arrays import count


def set_threads(number: int | None) -> None:
    """Sets the number of threads of this process, 1 to 1024.

    ``None`` stands for the environment variable ``RAYON_NUM_THREADS`` or, without it, one per core. Under MPI, where
    every rank is a process, 1 is right. Results do not depend on it.
    """
    _native.set_threads(None if number is None else count("the number of threads", number))


def thread_count() -> int:
    """Number of threads that evaluate in this process."""
    return _native.thread_count()
