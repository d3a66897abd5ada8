import functools
import itertools
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

HERE = Path(__file__).resolve().parent
# One core may have to serve all ranks, and a container's only user may be root.
ENVIRONMENT = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "OMP_NUM_THREADS": "1"}

# A run takes some 20 s.
SECONDS = 600


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    @functools.cache
    def results(ranks):
        path = tmp_path_factory.mktemp("dolfinx") / "results.npz"
        # With -m mpi4py a rank that raises ends the others, which would wait for it.
        program = [sys.executable, "-m", "mpi4py", HERE / "press.py", path]
        command = ["mpirun", "--oversubscribe", "-n", str(ranks), *program]
        environment = {**os.environ, **ENVIRONMENT}
        done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=SECONDS)
        assert done.returncode == 0, done.stderr
        with np.load(path) as arrays:
            return json.loads(done.stdout.splitlines()[-1]), dict(arrays)

    return results


def test_the_contact_force(run):
    result, arrays = run(1)
    assert result["force"][2] == pytest.approx(1060.5854055, rel=1e-8)
    # The block has been slid off the top of the arch, which pushes it back.
    assert result["force"][0] == pytest.approx(19.817235224, rel=1e-8)
    assert abs(result["force"][1]) < 1e-9
    assert result["touching"] == 50
    assert result["penetration"] == pytest.approx(0.01112481396, rel=1e-8)
    # The plate's four steps of (0.1, 0, −0.1), and the work of its force and the slaves' is of the same force.
    assert np.abs(arrays["displacements"][-55:] - [0.4, 0, -0.4]).max() < 1e-12
    assert arrays["forces"].sum() == pytest.approx(np.linalg.norm(result["force"]), rel=0.02)


def test_newton_converges_quadratically(run):
    result, _ = run(1)
    assert result["iterations"] == [6, 6, 6, 6]
    for residuals in result["residuals"]:
        # Over the contact force, without the two that the plate's step makes: once small, each is below a multiple
        # of the square of the one before.
        relative = [residual / result["force"][2] for residual in residuals[2:]]
        steps = [(before, after) for before, after in itertools.pairwise(relative) if before < 1e-3]
        assert steps
        for before, after in steps:
            assert after < 10 * before**2 + 1e-13


@pytest.mark.parametrize("ranks", [2, 4])
def test_ranks_make_no_difference(run, ranks):
    one, expected = run(1)
    many, found = run(ranks)
    assert many["iterations"] == one["iterations"]
    assert len(many["slaves_of_ranks"]) == ranks and sum(many["slaves_of_ranks"]) == 55
    assert min(many["slaves_of_ranks"]) > 0
    np.testing.assert_allclose(found["displacements"], expected["displacements"], rtol=0, atol=1e-10)
    np.testing.assert_allclose(
        found["forces"] / expected["forces"].max(), expected["forces"] / expected["forces"].max(), rtol=0, atol=1e-10
    )
    np.testing.assert_allclose(many["force"], one["force"], rtol=0, atol=1e-10 * one["force"][2])


def test_a_rank_that_raises_ends_the_others():
    program = "from mpi4py import MPI; assert MPI.COMM_WORLD.rank != 1, 'on purpose'; MPI.COMM_WORLD.barrier()"
    command = ["mpirun", "--oversubscribe", "-n", "2", sys.executable, "-m", "mpi4py", "-c", program]
    done = subprocess.run(command, env={**os.environ, **ENVIRONMENT}, capture_output=True, text=True, timeout=60)
    assert done.returncode != 0 and "on purpose" in done.stderr
