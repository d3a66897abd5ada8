import functools
import itertools
import json
import os
import pickle
import subprocess
import sys
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

import diffuse_contact as dc

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
from contact import carriers_of  # noqa: E402
from scene import facets_on, on_master, on_slave  # noqa: E402

# One core may have to serve all ranks, which should not wait for one another at full speed; and a container's only
# user may be root.
ENVIRONMENT = {
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_mpi_yield_when_idle": "1",
    "OMP_NUM_THREADS": "1",
}
PENALTY, LIMIT = 2e4, 0.6

# A run takes some 10 s.
SECONDS = 300


@pytest.fixture(scope="module")
def mesh(tmp_path_factory):
    """The file of the mesh, and what is in it."""

    @functools.cache
    def written(fine=1):
        folder = tmp_path_factory.mktemp("mesh")
        file, arrays = folder / "mesh.xdmf", folder / "mesh.npz"
        program = [sys.executable, HERE / "scene.py", file, "--fine", str(fine), "--arrays", arrays]
        subprocess.run(program, env={**os.environ, **ENVIRONMENT}, check=True, timeout=SECONDS)
        with np.load(arrays) as found:
            return file, found["nodes"], found["cells"]

    return written


@pytest.fixture(scope="module")
def run(tmp_path_factory, mesh):
    @functools.cache
    def results(ranks, partitioner="dolfinx", *options):
        folder = tmp_path_factory.mktemp("dolfinx")
        named = dict(zip(options[::2], options[1::2], strict=True))
        fine, limit = int(named.get("--fine", 1)), float(named.get("--limit", LIMIT))
        file, nodes, cells = mesh(fine)
        # With -m mpi4py a rank that raises ends the others, which would wait for it.
        program = [sys.executable, "-m", "mpi4py", HERE / "press.py", file, "--results", folder]
        command = ["mpirun", "--oversubscribe", "-n", str(ranks), *program, "--partitioner", partitioner, *options]
        environment = {**os.environ, **ENVIRONMENT}
        done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=SECONDS)
        if "no-friction-kernels" in done.stderr:
            pytest.skip("the module was built without friction")
        assert done.returncode == 0, done.stderr
        parts = [pickle.loads((folder / f"{rank}.pickle").read_bytes()) for rank in range(ranks)]
        return json.loads(done.stdout.splitlines()[-1]), Results(parts, nodes, cells, limit / fine)

    return results


class Results:
    """What all ranks have, by the numbers of the input."""

    def __init__(self, parts, first, cells, limit):
        self.first, self.limit = first, limit
        self.master_facets, self.slave_facets = (facets_on(first, cells, is_on) for is_on in (on_master, on_slave))
        nodes = np.concatenate([part["nodes"] for part in parts])
        assert np.array_equal(np.sort(nodes), np.arange(len(nodes)))
        self.displacements = np.concatenate([part["displacements"] for part in parts])[np.argsort(nodes)]
        slaves = np.concatenate([part["slaves"] for part in parts])
        self.slaves, order = np.unique(slaves, return_index=True)
        assert len(self.slaves) == len(slaves)
        self.forces = np.concatenate([part["slave_forces"] for part in parts])[order]
        # A rank without an interface has none to tell of.
        contacts = [contact for part in parts for contact in part["contacts"] or [None] * len(part["slaves"])]
        self.contacts = [contacts[k] for k in order]

    def compare_with_the_whole(self):
        """All slaves against an interface of the whole surface at the same positions, bit for bit."""
        interface = dc.ContactInterface(
            dc.MasterSurface(self.first, self.master_facets),
            self.slaves,
            self.first,
            slave_facets=self.slave_facets,
            distance_limit=self.limit,
        )
        assert np.array_equal(self.slaves, np.unique(self.slave_facets))
        interface.refresh_pairing(self.first + self.displacements)
        interface.evaluate("hessian")
        touching = 0
        for k, found in enumerate(self.contacts):
            expected = interface.contact(k)
            if found is None:
                assert expected.outcome == "too-far"
                continue
            outcome, masters, area, gap, gradient, hessian = found
            assert (outcome, area) == (expected.outcome, expected.area)
            if outcome != "contact":
                continue
            assert gap == expected.gap
            touching += gap < 0
            assert_same_rows(masters, gradient, hessian, expected)
        return touching

    def over_faces_of_the_whole(self):
        """Gaps and pressures of all slaves by an interface of all faces."""
        surface = dc.MasterSurface(self.first, self.master_facets)
        interface = dc.FaceInterface(surface, self.slave_facets, self.first, distance_limit=self.limit)
        interface.refresh(self.first + self.displacements)
        contacts = interface.evaluate(PENALTY)
        assert np.array_equal(self.slaves, interface.slaves)
        return contacts.gap, contacts.pressure


def assert_same_rows(masters, gradient, hessian, expected):
    """Lists of nodes may be older than the whole's: what both do not list is zero."""
    axes = np.arange(3)
    both = np.intersect1d(masters, expected.masters)

    def rows(names):
        place = np.concatenate([[0], 1 + np.searchsorted(names, both)])
        return (3 * place[:, np.newaxis] + axes).reshape(-1)

    for names, n, m in ((masters, gradient, hessian), (expected.masters, expected.gradient, expected.hessian)):
        others = np.setdiff1d(np.arange(len(n)), rows(names))
        assert not n[others].any() and not m[others].any()
    ours, theirs = rows(masters), rows(expected.masters)
    assert np.array_equal(gradient[ours], expected.gradient[theirs])
    assert np.array_equal(hessian[np.ix_(ours, ours)], expected.hessian[np.ix_(theirs, theirs)])


def test_the_contact_force(run):
    result, found = run(1)
    assert result["force"][2] == pytest.approx(1057.3709678, rel=1e-8)
    # The block has been slid off the top of the arch, which pushes it back.
    assert result["force"][0] == pytest.approx(20.046326235, rel=1e-8)
    assert abs(result["force"][1]) < 1e-9
    assert found.compare_with_the_whole() == 50
    # The plate's four steps of (0.1, 0, −0.1).
    plate = found.first[:, 2] > 2 - 1e-9
    assert plate.sum() == 55 and np.abs(found.displacements[plate] - [0.4, 0, -0.4]).max() < 1e-12


def test_newton_converges_quadratically(run):
    result, _ = run(1)
    assert max(result["iterations"]) <= 7
    for residuals in result["residuals"]:
        # Over the contact force: once small, each is below a multiple of the square of the one before.
        relative = [residual / result["force"][2] for residual in residuals]
        steps = [(before, after) for before, after in itertools.pairwise(relative) if before < 1e-3]
        assert steps
        for before, after in steps:
            assert after < 10 * before**2 + 1e-13


def assert_same(found, expected):
    (result, found), (one, expected) = found, expected
    assert result["iterations"] == one["iterations"] and result["renewals"] == one["renewals"]
    assert np.abs(found.displacements - expected.displacements).max() < 1e-14
    assert np.abs(found.forces - expected.forces).max() < 1e-14 * one["force"][2]


@pytest.mark.parametrize(
    ("ranks", "partitioner", "press"), [(2, "strips", 4), (4, "blocks", 1), (4, "dolfinx", 1), (8, "random", 1)]
)
def test_ranks_make_no_difference(run, ranks, partitioner, press):
    options = () if press == 4 else ("--press", str(press))
    one, expected = run(1, "dolfinx", *options)
    result, found = run(ranks, partitioner, *options)
    assert sum(result["slaves_of_ranks"]) == 55
    assert max(result["slaves_of_ranks"]) - min(result["slaves_of_ranks"]) <= 1
    assert found.compare_with_the_whole() == expected.compare_with_the_whole() >= 25
    assert_same((result, found), (one, expected))


#: So near that the slaves at the ends of the block have nothing below them.
NARROW = ("--limit", "0.03")


def test_a_rank_without_a_window_serves_the_others(run):
    lowered = (*NARROW, "--press", "0", "--lower", "0.01")
    one, expected = run(1, "dolfinx", *lowered)
    result, found = run(12, "strips", *lowered)
    assert min(result["masters_of_ranks"]) == 0 < max(result["masters_of_ranks"])
    assert found.compare_with_the_whole() == expected.compare_with_the_whole() > 0
    # Slaves whose contact begins later have a history then, and gaps are asked of all ranks.
    pressed = (*NARROW, "--press", "2", "--way", "0.2", "--friction", "0.2")
    one, expected = run(1, "dolfinx", *pressed)
    result, found = run(12, "strips", *pressed, "--linear", "gamg", "--tangent", "operator")
    assert one["force"][0] == pytest.approx(result["force"][0], rel=1e-8)
    assert np.abs(found.displacements - expected.displacements).max() < 1e-9


def test_a_rank_without_a_window_serves_faces(run):
    options = ("--fine", "8", *NARROW, "--integration", "faces", "--press", "0", "--lower", "0.001")
    result, found = run(12, "strips", *options)
    assert min(result["masters_of_ranks"]) == 0 < max(result["masters_of_ranks"])
    gap, pressure = found.over_faces_of_the_whole()
    ours = np.array([contact[:2] if contact else (np.nan, 0.0) for contact in found.contacts])
    assert np.array_equal(ours[:, 0], gap, equal_nan=True)
    assert np.array_equal(ours[:, 1], pressure)


#: Of a facet that is sent: numbers, owners and positions of its corners.
FACET = 200


def test_no_rank_holds_or_receives_the_whole_surface(run):
    fine = ("--fine", "6", "--press", "0", "--lower", "0.02")
    one, whole = run(1, "dolfinx", *fine)
    assert whole.compare_with_the_whole() > 50
    facets = 54 * 30
    assert sum(one["sent_of_ranks"][0].values()) == sum(one["received_of_ranks"][0][0].values()) == 0
    result, found = run(4, "blocks", *fine)
    assert result["renewals"] == [] and found.compare_with_the_whole() == whole.compare_with_the_whole()
    # Each reads its part of the file.
    assert max(result["read_of_ranks"]) < 0.26 * one["read_of_ranks"][0]
    assert max(result["bytes_of_ranks"]) < 0.6 * one["bytes_of_ranks"][0]
    assert max(result["masters_of_ranks"]) < 0.6 * one["masters_of_ranks"][0]
    sent, received = (Counter() for _ in range(2))
    for of_rank, (first,) in zip(result["sent_of_ranks"], result["received_of_ranks"], strict=True):
        sent.update(of_rank)
        received.update(first)
        # What all ranks get are eight boxes and a few numbers.
        assert first["boxes"] < 3 * (8 * 6 * 8 + 200)
        # The own quarter need not come: a gather of the surface would bring three quarters of it.
        assert 0 < first["surface"] < 0.35 * FACET * facets
        surface = sum(first[what] for what in ("surface", "demands", "slaves", "windows"))
        assert surface < 0.45 * one["bytes_of_ranks"][0]
    assert all(received[what] == sent[what] for what in sent)


def test_an_increment_brings_vectors_of_the_halo_alone(run):
    # So short a way that windows hold.
    options = ("--fine", "6", "--press", "1", "--lower", "0.02", "--way", "0.1")
    result, _ = run(4, "blocks", *options)
    assert result["renewals"] == [1]
    # Positions of all masters, for the window and for the part: a gather would bring three quarters of them.
    whole = 2 * 24 * 55 * 31
    for (_, received), vectors in zip(result["received_of_ranks"], result["vectors_of_ranks"], strict=True):
        # Where lists of nodes change, the rows of the pattern go to their owners.
        assert 0 < received["vectors"] and set(received) <= {"vectors", "pattern"}
        assert 0 < vectors < 0.45 * whole


def test_a_slide_over_all_partitions_with_friction(run):
    options = ("--friction", "0.2", "--press", "1", "--slide", "4")
    one, expected = run(1, "dolfinx", *options)
    assert one["renewals"][-1] >= 4
    assert abs(one["force"][0]) > 0.05 * one["force"][2]
    result, found = run(4, "strips", *options)
    assert result["iterations"] == one["iterations"] and result["renewals"] == one["renewals"]
    # The way is the same, too: the residuals of all iterations, as far as they are not rounding.
    for found_way, way in zip(result["residuals"], one["residuals"], strict=True):
        assert np.allclose(found_way, way, rtol=1e-8, atol=1e-9)
    assert np.abs(found.displacements - expected.displacements).max() < 1e-11
    assert np.abs(found.forces - expected.forces).max() < 1e-11 * one["force"][2]


def test_faces_with_friction_on_any_number_of_ranks(run):
    options = ("--integration", "faces", "--friction", "0.2", "--press", "1", "--slide", "2")
    one, expected = run(1, "dolfinx", *options)
    assert abs(one["force"][0]) > 0.05 * one["force"][2]
    assert "slip" in {state for *_, state in expected.contacts}
    result, found = run(3, "random", *options)
    assert result["iterations"] == one["iterations"] and result["renewals"] == one["renewals"]
    assert max(result["iterations"]) <= 7
    assert np.abs(found.displacements - expected.displacements).max() < 1e-11
    assert np.abs(found.forces - expected.forces).max() < 1e-11 * one["force"][2]
    assert [state for *_, state in found.contacts] == [state for *_, state in expected.contacts]


@pytest.mark.parametrize(("ranks", "partitioner"), [(2, "strips"), (4, "blocks"), (8, "dolfinx")])
def test_faces_are_those_of_the_whole_surface(run, ranks, partitioner):
    # Thirty-six facets along the arch: of four ranks none knows all of them.
    options = ("--fine", "4", "--integration", "faces", "--press", "0", "--lower", "0.02")
    result, found = run(ranks, partitioner, *options)
    assert partitioner != "blocks" or max(result["masters_of_ranks"]) < 0.8 * 37 * 21
    gap, pressure = found.over_faces_of_the_whole()
    assert (pressure > 0).sum() > 20
    ours = np.array([contact[:2] for contact in found.contacts])
    assert np.array_equal(np.isnan(ours[:, 0]), np.isnan(gap))
    assert np.array_equal(ours[:, 0], gap, equal_nan=True)
    assert np.array_equal(ours[:, 1], pressure)


@pytest.mark.parametrize("tangent", ["assembled", "operator"])
def test_multigrid_gives_the_same(run, tangent):
    one, expected = run(1, "dolfinx", "--press", "1")
    result, found = run(2, "strips", "--linear", "gamg", "--tangent", tangent, "--press", "1")
    assert np.abs(found.displacements - expected.displacements).max() < 1e-9
    # Newton's systems of an increment, and that of the prediction. PETSc 3.22 takes some more than 3.18.
    assert max(np.array(result["linear"]) / (np.array(result["iterations"]) + 1)) < 25
    assert one["force"][2] == pytest.approx(result["force"][2], rel=1e-9)
    assert tangent == "assembled" or result["shell_error"] < 1e-13


def test_the_operator_has_friction(run):
    options = ("--friction", "0.2", "--press", "1", "--slide", "1")
    one, expected = run(1, "dolfinx", *options)
    result, found = run(2, "strips", "--linear", "gamg", "--tangent", "operator", *options)
    assert result["shell_error"] < 1e-13
    assert np.abs(found.displacements - expected.displacements).max() < 1e-9
    assert one["force"][0] == pytest.approx(result["force"][0], rel=1e-8)


@pytest.mark.parametrize("friction", [(), ("--friction", "0.2")])
def test_faces_have_an_operator(run, friction):
    options = ("--integration", "faces", "--press", "1", *friction)
    one, expected = run(1, "dolfinx", *options)
    result, found = run(3, "strips", "--linear", "gamg", "--tangent", "operator", *options)
    assert result["shell_error"] < 1e-13
    assert np.abs(found.displacements - expected.displacements).max() < 1e-9
    assert one["force"][2] == pytest.approx(result["force"][2], rel=1e-8)


def test_a_hundredfold_penalty_costs_no_iterations(run):
    options = ("--linear", "gamg", "--tangent", "operator", "--press", "1")
    soft, _ = run(2, "strips", *options)
    hard, _ = run(2, "strips", *options, "--penalty", "2e6")
    # The residual's norm, as a line search would have it, ends between two kinks here.
    assert max(hard["iterations"]) <= 10
    soft, hard = (max(np.array(of["linear"]) / (np.array(of["iterations"]) + 1)) for of in (soft, hard))
    assert hard < 1.25 * soft


def test_a_rank_that_raises_ends_the_others():
    program = "from mpi4py import MPI; assert MPI.COMM_WORLD.rank != 1, 'on purpose'; MPI.COMM_WORLD.barrier()"
    command = ["mpirun", "--oversubscribe", "-n", "2", sys.executable, "-m", "mpi4py", "-c", program]
    done = subprocess.run(command, env={**os.environ, **ENVIRONMENT}, capture_output=True, text=True, timeout=60)
    assert done.returncode != 0 and "on purpose" in done.stderr


@pytest.mark.parametrize(
    ("row", "nodes"),
    [
        ([-1.0], []),
        ([2.0, 0.1, 5.0, -1.0, 0.3, 7.0, 0.0, 0.7], [5, 7]),
        ([1.5, -0.5, 6.0, -1.0, 1.0], [6]),
        ([-2.0, 1.0, 9.0, -1.0, 1.0, 2.0, 0.1, 3.0, -1.0, 0.4, 4.0, -1.0, 0.6], [9, 3, 4]),
        ([-2.0, 1.0, 9.0, -1.0, 1.0, 2.5, -0.1, 3.0, -1.0, 0.4, 4.0, -1.0, 0.6], [9, 3, 4]),
    ],
)
def test_a_history_names_the_nodes_that_a_slave_sticks_to(row, nodes):
    assert dc.split_history(row)[0].tolist() == row
    assert carriers_of(np.array(row)).tolist() == nodes
