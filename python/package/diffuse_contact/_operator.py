"""The tangent as an operator."""

from __future__ import annotations

from typing import Any, NoReturn

import numpy as np
import scipy.sparse.linalg

from . import _native
from ._arrays import Floats, floats, new, refuse_overlap, vector
from ._errors import BusyError, InputError


class TangentOperator(scipy.sparse.linalg.LinearOperator):
    """K = −∂R/∂x without a matrix, at the positions and by the law it was made for, float64.

    ``ContactInterface.operator`` makes it. It is a scipy ``LinearOperator``: ``operator @ v``, sums with matrices made
    operators by ``scipy.sparse.linalg.aslinearoperator``, and the iterative solvers of scipy take it. A product differs
    from that of the assembled matrix by rounding and does not depend on the number of threads. Without friction it is
    symmetric. Held are N and the factors of M of each contact that carries force, with friction a packed triangle. It
    serves one thread at a time; others get a ``BusyError``.
    """

    def __init__(self, operator: _native.Operator, is_symmetric: bool) -> None:
        self._operator = operator
        self._is_symmetric = is_symmetric
        equations, self._contacts, self._bytes = operator.sizes()
        super().__init__(np.dtype(np.float64), (equations, equations))

    @property
    def contacts(self) -> int:
        """Number of contacts that carry force."""
        return self._contacts

    @property
    def is_symmetric(self) -> bool:
        """Whether K is its own transpose: without friction. With it there is no product with the transpose."""
        return self._is_symmetric

    @property
    def nbytes(self) -> int:
        """Memory of the operator, bytes."""
        return self._bytes

    def add_product(self, v: Any, out: Floats) -> Floats:
        """Adds K v to a vector, which is returned. Both have shape (equations,).

        Raises:
            AssemblyError: for another length, or if a sum overflows; ``out`` then holds anything.
            InputError: for arrays of another type.

        """
        v = floats("v", v, "equations")
        self._call({"v": v}, out, lambda: self._operator.add_product(v, out))
        return out

    def diagonal(self) -> Floats:
        """The diagonal of K, shape (equations,), force per length."""
        out = self._zeros()
        self._operator.add_diagonal(out)
        return out

    def _zeros(self) -> Floats:
        out = new("product", self.shape[0])
        out.fill(0.0)
        return out

    def _call(self, read: dict[str, Any], out: Any, call: Any) -> None:
        vector("out", out)
        try:
            call()
        except BusyError as error:
            refuse_overlap(error, read, {"out": out})

    def _matvec(self, x: Any) -> Floats:
        return self.add_product(np.ravel(x), self._zeros())

    def _rmatvec(self, x: Any) -> Floats:
        return self._transpose()._matvec(x)

    def _adjoint(self) -> TangentOperator:
        return self._transpose()

    def _transpose(self) -> TangentOperator:
        if not self._is_symmetric:
            raise InputError("with friction there is no product with the transpose", "not-symmetric")
        return self

    def __reduce__(self) -> NoReturn:
        raise TypeError("a TangentOperator cannot be pickled or copied: make one in each process")

    def __repr__(self) -> str:
        return f"<TangentOperator of {self.contacts} contacts, {self.shape[0]} equations>"
