"""The tangent as an operator."""

from __future__ import annotations

from typing import Any, NoReturn

import numpy as np
import scipy.sparse.linalg

from . import _native
from ._arrays import Floats, check_overlap, floats, new, vector


class TangentOperator(scipy.sparse.linalg.LinearOperator):
    """K = −∂R/∂x without a matrix, at the positions and by the law it was made for, float64.

    ``ContactInterface.operator`` makes it. It is a scipy ``LinearOperator``: ``operator @ v``, sums with matrices made
    operators by ``scipy.sparse.linalg.aslinearoperator``, and the iterative solvers of scipy take it. A product differs
    from that of the assembled matrix by rounding and does not depend on the number of threads. Held are N and the
    factors of M of each contact that carries force; with friction N, the gradient of the slip, and a triangle of
    numbers. Without friction K is symmetric. The operator serves one thread at a time; others get a ``BusyError``.
    """

    def __init__(self, operator: _native.Operator) -> None:
        self._operator = operator
        equations, self._contacts, self._bytes = operator.sizes()
        super().__init__(np.dtype(np.float64), (equations, equations))

    @property
    def contacts(self) -> int:
        """Number of contacts that carry force."""
        return self._contacts

    @property
    def nbytes(self) -> int:
        """Memory of the operator, bytes."""
        return self._bytes

    def add_product(self, v: Any, out: Floats) -> Floats:
        """Adds K v to a vector, which is returned. Both have shape (equations,).

        ``operator.T @ v`` is Kᵀ v.

        Raises:
            AssemblyError: for another length, or if a sum overflows; ``out`` then holds anything.
            InputError: for arrays of another type.

        """
        return self._add(v, out, is_transposed=False)

    def diagonal(self) -> Floats:
        """The diagonal of K, shape (equations,), force per length."""
        out = self._zeros()
        self._operator.add_diagonal(out)
        return out

    def _zeros(self) -> Floats:
        out = new("product", self.shape[0])
        out.fill(0.0)
        return out

    def _add(self, v: Any, out: Floats, *, is_transposed: bool) -> Floats:
        v = floats("v", v, "equations")
        check_overlap({"v": v}, {"out": vector("out", out)})
        self._operator.add_product(v, out, is_transposed)
        return out

    def _matvec(self, x: Any) -> Floats:
        return self._add(np.ravel(x), self._zeros(), is_transposed=False)

    def _rmatvec(self, x: Any) -> Floats:
        return self._add(np.ravel(x), self._zeros(), is_transposed=True)

    def __reduce__(self) -> NoReturn:
        raise TypeError("a TangentOperator cannot be pickled or copied: make one in each process")

    def __repr__(self) -> str:
        return f"<TangentOperator of {self.contacts} contacts, {self.shape[0]} equations>"
