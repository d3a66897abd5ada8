"""Numbers are those of the Rust library to the last bit."""

import subprocess
from pathlib import Path

import numpy as np
import pytest

import diffuse_contact as dc
from diffuse_contact import _native

PACKAGE = Path(__file__).resolve().parents[1]
ELEMENTS = {
    "interface/diffuse": {},
    "interface/symmetric": {"symmetry": [([0, 0, 0], [0, 1, 0]), ([0, 0, 0], [1, 0, 0])]},
    "interface/layers": {"rule": "hull-layers"},
    "interface/held": {"weight": "cubic-interpolating", "frame_derivative": "held", "rule": "nearest"},
    "interface/node-to-facet": {"element": "node-to-facet"},
}


@pytest.fixture(scope="session")
def reference():
    command = ["cargo", "run", "--quiet", "--release", "--bin", "reference"]
    # The kernels that the module was compiled with need not be compiled again.
    if _native.HAS_FRICTION:
        command += ["--features", "friction"]
    text = subprocess.run(command, cwd=PACKAGE, check=True, capture_output=True, text=True).stdout
    arrays = {}
    for line in text.splitlines():
        name, *words = line.split(" ")
        if name.endswith("/outcomes"):
            arrays[name] = words
        else:
            arrays[name] = np.array([int(word, 16) for word in words if word], dtype=np.uint64).view(np.float64)
    return arrays


def same_bits(found, expected):
    found = np.ascontiguousarray(found, dtype=np.float64).reshape(-1)
    assert found.shape == expected.shape
    np.testing.assert_array_equal(found.view(np.uint64), expected.view(np.uint64))


def test_batches(reference):
    cases = sorted({name.rsplit("/", 1)[0] for name in reference if name.startswith("batch/")})
    assert len(cases) == 12
    for case in cases:
        _, weight, basis, derivative, nodes = case.split("/")
        nodes = int(nodes)
        slaves = reference[f"{case}/slaves"].reshape(-1, 3)
        masters = reference[f"{case}/masters"].reshape(-1, nodes, 3)
        options = {"basis": basis, "weight": weight, "frame_derivative": derivative}
        packed = dc.gap(slaves, masters, [0, 0, 1], packed=True, **options)
        for name in ("gap", "foot", "normal", "gradient", "hessian"):
            same_bits(getattr(packed, name), reference[f"{case}/{name}"])
        # The default support radius is the one written out, and M in full has the same entries.
        full = dc.gap(slaves, masters, [0, 0, 1], support_radius=reference[f"{case}/radii"], **options)
        same_bits(full.gap, reference[f"{case}/gap"])
        rows, columns = np.tril_indices(3 * (nodes + 1))
        same_bits(full.hessian[:, rows, columns], reference[f"{case}/hessian"])
        same_bits(full.hessian.transpose(0, 2, 1)[:, rows, columns], reference[f"{case}/hessian"])


def ints(reference, name, *shape):
    return reference[name].astype(np.int64).reshape(*shape)


def scene(reference, case, **options):
    """The interface of a case, and where its nodes are."""
    positions = reference[f"{case}/positions"].reshape(-1, 3)
    facets, slaves, slave_facets = (
        ints(reference, f"{case}/{name}", *shape)
        for name, shape in (("facets", (-1, 4)), ("slaves", (-1,)), ("slave_facets", (-1, 4)))
    )
    master = dc.MasterSurface(positions, facets)
    return dc.ContactInterface(master, slaves, positions, slave_facets=slave_facets, **options), positions


def same_matrix(reference, name, matrix):
    assert matrix.indptr.tolist() == ints(reference, f"{name}/offsets", -1).tolist()
    assert matrix.indices.tolist() == ints(reference, f"{name}/columns", -1).tolist()
    same_bits(matrix.data, reference[f"{name}/values"])


@pytest.mark.parametrize("threads", [1, 3])
@pytest.mark.parametrize("case", ELEMENTS)
def test_interfaces(reference, case, threads):
    dc.set_threads(threads)
    interface, positions = scene(reference, case, **ELEMENTS[case])
    report = interface.refresh_pairing(positions)
    assert [report.paired, report.fallbacks["extended"]] == ints(reference, f"{case}/paired", -1).tolist()
    interface.update(reference[f"{case}/moved"].reshape(-1, 3))
    contacts = interface.evaluate()
    assert contacts.outcomes == reference[f"{case}/outcomes"]
    assert contacts.outcomes.count("contact") > 20
    for name in ("gap", "foot", "normal"):
        same_bits(np.nan_to_num(getattr(contacts, name)), reference[f"{case}/{name}"])
    same_bits(contacts.area, reference[f"{case}/area"])
    found = [interface.contact(k) for k in range(len(contacts.gap))]
    gradients = [contact.gradient for contact in found if contact.gradient is not None]
    same_bits(np.concatenate(gradients), reference[f"{case}/gradients"])
    hessians = [
        contact.hessian[np.tril_indices(len(contact.hessian))] for contact in found if contact.outcome == "contact"
    ]
    same_bits(np.concatenate(hessians), reference[f"{case}/hessians"])
    multipliers = 0.5 * (np.arange(len(found)) % 5)
    for tangent in ("exact", "gauss-newton"):
        same_bits(interface.forces(1e3, multipliers=multipliers), reference[f"{case}/{tangent}/residual"])
        matrix = interface.tangent(1e3, multipliers=multipliers, tangent=tangent)
        same_matrix(reference, f"{case}/{tangent}", matrix)
    dc.set_threads(None)


@pytest.mark.parametrize("threads", [1, 3])
@pytest.mark.parametrize("element", ["diffuse", "node-to-facet"])
def test_friction(reference, element, threads):
    if element == "diffuse" and not _native.HAS_FRICTION:
        pytest.skip("built without friction")
    case = f"friction/{element}"
    law = {"penalty": 1e3, "friction": (0.2, 500.0)}
    dc.set_threads(threads)
    interface, positions = scene(reference, case, element=element)
    interface.refresh_pairing(positions)
    interface.accept(**law)
    for step in ("short", "long"):
        interface.refresh_pairing(reference[f"{case}/{step}/moved"].reshape(-1, 3))
        interface.evaluate()
        for tangent in ("exact", "gauss-newton"):
            same_bits(interface.forces(**law), reference[f"{case}/{step}/{tangent}/residual"])
            same_matrix(reference, f"{case}/{step}/{tangent}", interface.tangent(tangent=tangent, **law))
        report = interface.accept(**law)
        assert report.stuck + report.sliding > 10
        counts = [report.stuck, report.sliding, report.unanchored, report.dissipated]
        same_bits(counts, reference[f"{case}/{step}/report"])
        same_bits(interface.history, reference[f"{case}/{step}/history"])
    dc.set_threads(None)


def test_the_adaptive_tangent(reference):
    names = [dc.adaptive_tangent(*norms) for norms in reference["adaptive/norms"].reshape(-1, 2)]
    expected = ["exact" if is_exact else "gauss-newton" for is_exact in reference["adaptive/exact"]]
    assert names == expected and set(names) == {"exact", "gauss-newton"}
