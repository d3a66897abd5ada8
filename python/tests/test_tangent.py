"""The tangent in other forms: as an operator, in a matrix of the host, without holding M."""

import pickle
import threading

import numpy as np
import pytest
import scipy.sparse
import scipy.sparse.linalg

import diffuse_contact as dc

PENALTY = 1e3


@pytest.mark.parametrize("tangent", ["exact", "gauss-newton"])
@pytest.mark.parametrize("options", [{}, {"element": "node-to-facet"}, {"symmetry": [([0, 0, 0], [1, 0, 0])]}])
def test_the_operator_is_the_matrix(scene, options, tangent):
    dofs = np.arange(255).reshape(85, 3)[::-1].copy()
    dofs[:4] = -1
    interface = scene.evaluated(dofs=dofs, equations=260, **options)
    multipliers = [0.0, 3.0, 0.5, 0.0]
    law = {"multipliers": multipliers, "tangent": tangent}
    matrix = interface.tangent(PENALTY, **law)
    operator = interface.operator(PENALTY, **law)
    assert isinstance(operator, scipy.sparse.linalg.LinearOperator) and operator.dtype == np.float64
    assert operator.shape == matrix.shape == (260, 260) and operator.contacts == 4 and operator.nbytes > 0
    v = np.random.default_rng(5).normal(size=(260, 2))
    products = [operator @ v, operator.T @ v, operator.H @ v]
    if hasattr(operator, "__array_ufunc__"):
        # Older versions of scipy take no array on the left.
        products.append((v.T @ operator).T)
    for product in products:
        np.testing.assert_allclose(product, matrix @ v, rtol=0, atol=1e-13 * abs(matrix).max())
    np.testing.assert_allclose(operator.diagonal(), matrix.diagonal(), rtol=0, atol=1e-13 * abs(matrix).max())
    out = np.ones(260)
    assert operator.add_product(v[:, 0], out) is out
    np.testing.assert_array_equal(out, 1.0 + operator @ v[:, 0])
    # It stays what it is, and a solver of scipy takes its sum with a matrix.
    interface.update(scene.positions + 0.01)
    np.testing.assert_allclose(operator @ v, matrix @ v, rtol=0, atol=1e-13 * abs(matrix).max())
    solid = 5e3 * scipy.sparse.identity(260, format="csr")
    # The tolerance is the default one, since its name depends on scipy's version.
    found, info = scipy.sparse.linalg.minres(scipy.sparse.linalg.aslinearoperator(solid) + operator, v[:, 0])
    assert info == 0
    assert np.linalg.norm((solid + matrix) @ found - v[:, 0]) < 1e-3 * np.linalg.norm(v[:, 0])


def test_an_operator_needs_no_evaluation_and_refuses_what_is_none(scene):
    interface = scene.interface()
    interface.refresh_pairing(scene.positions)
    operator = interface.operator(PENALTY)
    assert operator.contacts == 4 and "4 contacts, 255 equations" in repr(operator)
    with pytest.raises(dc.AssemblyError) as caught:
        interface.operator(-1.0)
    assert caught.value.code == "invalid-penalty"
    with pytest.raises(dc.AssemblyError) as caught:
        operator.add_product(np.zeros(3), np.zeros(255))
    assert caught.value.code == "output-length"
    v = np.zeros(255)
    for out, code in ((v, "overlap"), (np.zeros(255, dtype=np.float32), "wrong-array"), (None, "wrong-array")):
        with pytest.raises(dc.InputError) as caught:
            operator.add_product(v, out)
        assert caught.value.code == code
    with pytest.raises(dc.InputError):
        operator @ np.full(255, 1j)
    with pytest.raises(TypeError):
        pickle.dumps(operator)


def test_an_operator_serves_one_thread_at_a_time(scene):
    interface = scene.interface()
    interface.refresh_pairing(scene.positions)
    operator, v = interface.operator(PENALTY), np.ones(255)
    expected, wrong = operator @ v, []

    def work():
        for _ in range(200):
            try:
                if not np.array_equal(operator @ v, expected):
                    wrong.append("another product")
            except dc.BusyError:
                pass

    threads = [threading.Thread(target=work) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong


def host_matrix(interface, index):
    """The pattern and a diagonal with other values, its index arrays of a type."""
    offsets, columns = interface.pattern()
    size = interface.equations
    shape = (size, size)
    matrix = scipy.sparse.csr_matrix((np.full(len(columns), 2.0), columns.copy(), offsets.copy()), shape=shape)
    matrix = (matrix + 3.0 * scipy.sparse.identity(size, format="csr")).tocsr()
    matrix.sort_indices()
    matrix.indices, matrix.indptr = matrix.indices.astype(index), matrix.indptr.astype(index)
    return matrix


@pytest.mark.parametrize("index", [np.int32, np.int64])
def test_the_tangent_is_added_to_a_matrix_of_the_host(scene, index):
    interface = scene.evaluated()
    matrix = host_matrix(interface, index)
    before = matrix.copy()
    entries = interface.csr_map(matrix)
    assert (entries.entries, entries.equations) == (matrix.nnz, 255)
    for law in ({}, {"tangent": "gauss-newton", "multipliers": [1.0, 0.0, 2.0, 0.0]}):
        matrix.data[:] = before.data
        data = matrix.data
        assert entries.add(matrix.data, PENALTY, **law) == 4
        assert matrix.data is data
        expected = before + interface.tangent(PENALTY, **law)
        assert abs(matrix - expected).max() <= 1e-13 * abs(expected).max()
    # Row offsets and columns serve as well, and lists of numbers.
    same = interface.csr_map((matrix.indptr.tolist(), matrix.indices))
    assert same.add(before.data.copy(), PENALTY) == 4
    # It belongs to lists of nodes.
    moved = scene.positions + np.where(np.arange(85) > 80, 0.6, 0.0)[:, np.newaxis] * [1, 1, 0]
    assert interface.refresh_pairing(moved).rebuilt
    data = matrix.data.copy()
    for code, error in (("not-evaluated", dc.InterfaceError), ("pattern-mismatch", dc.AssemblyError)):
        with pytest.raises(error) as caught:
            entries.add(matrix.data, PENALTY)
        assert caught.value.code == code
        interface.evaluate("gradient")
    np.testing.assert_array_equal(matrix.data, data)
    with pytest.raises(TypeError):
        pickle.dumps(entries)


def test_what_is_no_matrix_of_the_host_is_refused(scene):
    interface = scene.evaluated()
    matrix = host_matrix(interface, np.int32)
    lacking = scipy.sparse.identity(255, format="csr")
    for wrong, error, code in (
        (lacking, dc.AssemblyError, "missing-entry"),
        ((matrix.indptr[:-1], matrix.indices), dc.AssemblyError, "output-length"),
        ((matrix.indptr[::-1], matrix.indices), dc.AssemblyError, "invalid-row"),
        (matrix.tocsc(), dc.InputError, "wrong-type"),
        (matrix.toarray(), dc.InputError, "wrong-type"),
        ((matrix.indptr, matrix.data), dc.InputError, "wrong-type"),
    ):
        with pytest.raises(error) as caught:
            interface.csr_map(wrong)
        assert caught.value.code == code
    entries = interface.csr_map(matrix)
    with pytest.raises(dc.AssemblyError) as caught:
        entries.add(np.zeros(3), PENALTY)
    assert caught.value.code == "output-length"
    with pytest.raises(dc.InputError):
        entries.add(matrix.data.astype(np.float32), PENALTY)
    data = np.ones(matrix.nnz)
    with pytest.raises(dc.InputError) as caught:
        entries.add(data, PENALTY, multipliers=data[:4])
    assert caught.value.code == "overlap" and (data == 1.0).all()


def test_the_exact_tangent_needs_no_hessian_held(scene):
    interface = scene.evaluated()
    expected = interface.tangent(PENALTY)
    interface.evaluate("gradient")
    assert interface.contact(0).hessian is None
    found = interface.tangent(PENALTY)
    np.testing.assert_array_equal(found.data, expected.data)
    added = interface.tangent_values(PENALTY, out=np.ones(expected.nnz))
    # On top of 1, four slaves in turn are rounded as 1 is, even where they leave less.
    np.testing.assert_allclose(added, 1.0 + expected.data, rtol=1e-14, atol=4 * np.finfo(float).eps)
    # Index arrays are made once, of 32 bits, and shared until lists of nodes change.
    offsets, columns = interface.pattern()
    assert offsets.dtype == columns.dtype == np.int32 and not columns.flags.writeable
    assert np.shares_memory(found.indices, columns) and np.shares_memory(expected.indices, columns)
    interface.refresh_pairing(scene.positions)
    interface.evaluate("gradient")
    assert interface.pattern()[1] is columns
    interface.evaluate("value")
    with pytest.raises(dc.AssemblyError) as caught:
        interface.tangent(PENALTY)
    assert caught.value.code == "derivative-length"
