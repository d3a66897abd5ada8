import numpy as np
import pytest

import diffuse_contact as dc

SQUARES = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [1, 1, 0], [2, 1, 0]], dtype=float)


def test_facets_of_three_and_four_corners():
    for corners in (
        [[0, 1, 4, 3], [1, 2, 5], [1, 5, 4]],
        np.array([[0, 1, 4, 3], [1, 2, 5, -1], [1, 5, 4, -1]]),
        [np.array([0, 1, 4, 3]), (1, 2, 5), [1, 5, 4]],
    ):
        surface = dc.MasterSurface(SQUARES, corners)
        assert surface.facets.tolist() == [[0, 1, 4, 3], [1, 2, 5, -1], [1, 5, 4, -1]]
        assert surface.nodes.tolist() == [0, 1, 2, 3, 4, 5]
        assert surface.border_edges.shape == (6, 2)
        assert "3 facets" in repr(surface)
    triangles = dc.MasterSurface(SQUARES, np.array([[1, 2, 5], [1, 5, 4]], dtype=np.int32))
    assert triangles.nodes.tolist() == [1, 2, 4, 5]
    np.testing.assert_array_equal(triangles.node_normals(SQUARES)[:, :2], 0)


def test_the_caller_s_array_stays_the_caller_s():
    corners = np.array([[0, 1, 4, 3], [1, 2, 5, 4]], dtype=np.int64)
    surface = dc.MasterSurface(SQUARES, corners)
    corners[:] = 0
    assert surface.facets.tolist() == [[0, 1, 4, 3], [1, 2, 5, 4]]
    surface.facets[:] = 0
    assert surface.facets.tolist() == [[0, 1, 4, 3], [1, 2, 5, 4]]


def test_areas():
    areas = dc.tributary_areas(SQUARES, [[0, 1, 4, 3], [1, 2, 5, 4]])
    np.testing.assert_allclose(areas, [0.25, 0.5, 0.25, 0.25, 0.5, 0.25])


@pytest.mark.parametrize(
    ("corners", "error", "code"),
    [
        ([], dc.SurfaceError, "empty-surface"),
        (np.empty((0, 4), dtype=int), dc.SurfaceError, "empty-surface"),
        ([[0, 1, 6]], dc.SurfaceError, "node-out-of-range"),
        ([[0, 1, 1]], dc.SurfaceError, "repeated-node"),
        ([[0, 1, 2]], dc.SurfaceError, "no-area"),
        ([[0, 4, 1, 3]], dc.SurfaceError, "not-cyclic"),
        ([[0, 1, 4, 3], [1, 4, 5, 2]], dc.SurfaceError, "inconsistent-orientation"),
        ([[0, -1, 4, 3]], dc.InputError, "negative-index"),
        ([[0, 1, 4, -2]], dc.InputError, "negative-index"),
        ([[0, 1, 4, 3, 2]], dc.InputError, "wrong-shape"),
        ([[0, 1, 4, 3], [1, 2]], dc.InputError, "facet-corners"),
        ([[0.0, 1.0, 4.0]], dc.InputError, "wrong-type"),
        ([0, 1, 4], dc.InputError, "wrong-shape"),
        (np.array([[0, 1, 2**64 - 1]], dtype=np.uint64), dc.InputError, "wrong-type"),
    ],
)
def test_bad_surfaces_are_refused(corners, error, code):
    with pytest.raises(error) as caught:
        dc.MasterSurface(SQUARES, corners)
    assert caught.value.code == code


def test_bad_positions_are_refused():
    bad = SQUARES.copy()
    bad[4, 2] = np.inf
    with pytest.raises(dc.SurfaceError) as caught:
        dc.MasterSurface(bad, [[0, 1, 4, 3]])
    assert caught.value.code == "non-finite-position"
    with pytest.raises(dc.InputError):
        dc.MasterSurface(SQUARES.reshape(-1), [[0, 1, 4, 3]])
    with pytest.raises(dc.SurfaceError) as caught:
        dc.MasterSurface(SQUARES, [[0, 1, 4, 3]]).node_normals(SQUARES[:2])
    assert caught.value.code == "too-few-positions"
