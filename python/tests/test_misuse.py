"""What a caller can pass by mistake ends in an exception of ours, with a code."""

import os
import subprocess
import sys

import numpy as np
import pytest

import diffuse_contact as dc

UP = [0, 0, 1]
HUGE = 10**400


def refuses(code, call, *arguments, error=dc.InputError, **options):
    with pytest.raises(error) as caught:
        call(*arguments, **options)
    assert caught.value.code == code, caught.value
    assert len(caught.value.message.split()) > 3
    return caught.value.message


def misaligned(values):
    values = np.asarray(values, dtype=np.float64)
    buffer = np.empty(values.nbytes + 1, dtype=np.uint8)[1:]
    array = buffer.view(np.float64).reshape(values.shape)
    array[...] = values
    assert not array.flags.aligned
    return array


def test_misaligned_arrays_are_read_and_not_written(elements, scene):
    slaves, masters = elements
    expected = dc.gap(slaves, masters, UP)
    np.testing.assert_array_equal(dc.gap(misaligned(slaves), misaligned(masters), UP).hessian, expected.hessian)
    interface = scene.evaluated()
    interface.update(misaligned(scene.positions))
    interface.evaluate()
    message = refuses("wrong-array", interface.forces, 1.0, out=misaligned(np.zeros(255)))
    assert "aligned" in message
    out = dc.GapBatch.empty(5, 9)
    bad = dc.GapBatch(misaligned(out.gap), out.foot, out.normal, out.gradient, out.hessian, out.status)
    assert "aligned" in refuses("wrong-shape", dc.gap, slaves, masters, UP, out=bad)


def test_entries_that_are_masked_are_refused(elements):
    slaves, masters = elements
    mask = np.zeros(np.shape(slaves), dtype=bool)
    whole = np.ma.masked_array(slaves, mask=mask)
    np.testing.assert_array_equal(dc.gap(whole, masters, UP).gap, dc.gap(slaves, masters, UP).gap)
    mask[1, 2] = True
    message = refuses("wrong-type", dc.gap, np.ma.masked_array(slaves, mask=mask), masters, UP)
    assert "masked" in message


def test_facets_that_are_none(scene):
    for corners, code in (
        (3, "wrong-shape"),
        (None, "wrong-shape"),
        ([[0, 1, 2, 3], 5], "wrong-shape"),
        ([[0, 1, 2], [0, 1, 2, 3], 5], "wrong-shape"),
        ([np.array(3), np.array([1, 2, 3])], "wrong-shape"),
        ("facets", "wrong-shape"),
        ([[0, 1, HUGE]], "wrong-type"),
        ({0: 1}, "wrong-shape"),
    ):
        refuses(code, dc.MasterSurface, scene.positions, corners)
        refuses(code, dc.tributary_areas, scene.positions, corners)


def test_numbers_of_any_size(scene):
    interface = scene.evaluated()
    for ask in (interface.forces, interface.normal_forces, interface.cut_back):
        refuses("invalid-option", ask, HUGE)
    for k in (HUGE, 2**64, 2**63):
        refuses("invalid-option", interface.contact, k)
        refuses("invalid-option", dc.set_threads, k)
        refuses("invalid-option", scene.interface, max_layers=k)
        refuses("invalid-option", dc.GapBatch.empty, k, 9)
    refuses("invalid-option", interface.contact, -HUGE)
    refuses("no-such-slave", interface.contact, 2**62)
    refuses("wrong-type", interface.contact, 1.0)
    dofs = np.full((85, 3), -1)
    dofs[0, 0] = np.iinfo(np.int64).max
    refuses("invalid-option", scene.interface, dofs=dofs)
    refuses("wrong-type", interface.update, [[HUGE] * 3] * 85)


def test_ragged_rows_and_tuples_of_another_length(scene):
    interface = scene.evaluated()
    ragged = [[[0, 0, 0], [1, 1]]]
    refuses("wrong-shape", interface.forces, 1.0, friction=(0.3,))
    refuses("wrong-shape", interface.forces, 1.0, friction=(0.3, 1e4, 5.0, 99.0))
    refuses("wrong-shape", interface.csr_map, (np.arange(3), np.arange(3), np.arange(3)))
    refuses("wrong-shape", interface.window, ragged, 0.1)
    refuses("wrong-shape", dc.flat_facets, [[[1, 2], [3]]])
    nothing = np.empty((0, 3)), np.empty((0, 4), dtype=int)
    numbers = {"node_numbers": [], "facet_numbers": [], "known": [[0] * 3] * 2, "extents": dc.Extents.of(*nothing)}
    refuses("wrong-shape", dc.SurfacePart, *nothing, owned=[[True], [True, False]], **numbers)
    refuses("wrong-type", dc.SurfacePart, *nothing, owned=[0, 1], **numbers)


def test_batches_that_there_cannot_be():
    refuses("invalid-option", dc.GapBatch.empty, -1, 9)
    refuses("invalid-option", dc.GapBatch.empty, 5, -1)
    refuses("wrong-type", dc.GapBatch.empty, 5.0, 9)
    refuses("invalid-option", dc.GapBatch.empty, 5, 9, "values")
    refuses("wrong-type", dc.GapBatch.empty, 5, 9, np.array(["value", "gradient"]))
    refuses("wrong-type", dc.GapBatch.empty, 5, 9, packed=1)
    refuses("too-large", dc.GapBatch.empty, 2**40, 2**20)


def test_names_are_judged_without_elements():
    nothing = np.empty((0, 3)), np.empty((0, 9, 3)), UP
    for name in ("weight", "basis", "frame_derivative", "mode", "on_error"):
        refuses("invalid-option", dc.gap, *nothing, **{name: "wrong"})
        refuses("invalid-option", dc.gap, *nothing, **{name: "\ud800"})
        refuses("wrong-type", dc.gap, *nothing, **{name: np.array(["wrong", "right"])})
    refuses("wrong-type", dc.gap, *nothing, packed=np.array([True, False]))
    refuses("wrong-type", dc.gap, *nothing, out=3)
    refuses("wrong-shape", dc.gap, *nothing, support_radius=[[1.0], [1.0, 2.0]])
    assert dc.gap(*nothing, frames=np.eye(3), packed=True).hessian.shape == (0, 465)


def test_arrays_of_one_call_that_share_memory_are_named(elements, scene):
    slaves, masters = elements
    out = dc.GapBatch.empty(5, 9)
    shared = dc.GapBatch(out.gap, out.foot, out.foot, out.gradient, out.hessian, out.status)
    assert "out.foot and out.normal" in refuses("overlap", dc.gap, slaves, masters, UP, out=shared)
    slaves = slaves.copy()
    shared = dc.GapBatch(out.gap, slaves, out.normal, out.gradient, out.hessian, out.status)
    assert "slaves and out.foot" in refuses("overlap", dc.gap, slaves, masters, UP, out=shared)
    interface = dc.ContactInterface(
        scene.master(), scene.slaves, scene.positions, dofs=np.vstack([np.full((84, 3), -1), [[0, 1, 2]]]), equations=4
    )
    interface.refresh_pairing(scene.positions)
    interface.evaluate()
    both = np.ones(4)
    assert "multipliers and out" in refuses("overlap", interface.forces, 1.0, multipliers=both, out=both)
    np.testing.assert_array_equal(both, 1)


def test_arrays_over_one_buffer_are_named_whatever_objects_they_belong_to(elements, scene):
    """numpy knows of no common base, and neither does the compiled part."""

    def two(count):
        memory = bytearray(8 * count)
        both = np.frombuffer(memory), np.frombuffer(memory)
        both[0][:] = 1.0
        return both

    interface = scene.evaluated()
    one, other = two(4)
    fewer = dc.ContactInterface(
        scene.master(), scene.slaves, scene.positions, dofs=np.vstack([np.full((84, 3), -1), [[0, 1, 2]]]), equations=4
    )
    fewer.refresh_pairing(scene.positions)
    fewer.evaluate()
    assert "multipliers and out" in refuses("overlap", fewer.forces, 1.0, multipliers=one, out=other)
    refuses("overlap", fewer.tangent_values, 1.0, multipliers=one, out=other)
    refuses("overlap", fewer.csr_map(fewer.tangent(1.0)).add, other, 1.0, multipliers=one)
    np.testing.assert_array_equal(one, 1)
    one, other = two(255)
    refuses("overlap", interface.operator(1.0).add_product, one, other)
    # Parts that lie beside one another are different arrays.
    values = np.zeros(interface.pattern()[1].size + 4)
    interface.tangent_values(1.0, multipliers=values[:4], out=values[4:])
    assert (values[4:] != 0).any()
    slaves, masters = elements
    out = dc.GapBatch.empty(5, 9)
    one, other = two(15)
    shared = dc.GapBatch(out.gap, one.reshape(5, 3), other.reshape(5, 3), out.gradient, out.hessian, out.status)
    assert "out.foot and out.normal" in refuses("overlap", dc.gap, slaves, masters, UP, out=shared)


def test_sizes_are_told():
    """By the compiled part too, which checks what the package has checked once more."""
    from types import SimpleNamespace

    from diffuse_contact import _native

    inputs = SimpleNamespace(
        slaves=np.zeros((2, 3)),
        masters=np.zeros((1, 9, 3)),
        outward=np.array([[0.0, 0.0, 1.0]]),
        frames=None,
        support_radius=None,
        basis="quadratic",
        weight="cubic",
        frame_derivative="co-moving",
    )
    out = dc.GapBatch.empty(2, 9, "value")
    flat = {"gradient": out.gradient.reshape(-1), "hessian": out.hessian.reshape(-1)}
    outputs = SimpleNamespace(gap=out.gap, foot=out.foot, normal=out.normal, status=out.status, **flat)
    message = refuses("wrong-shape", _native.gap_batch, inputs, outputs, "value", False)
    assert message == "masters has 9 entries, but 2 slaves need 18"


def test_where_no_threads_can_be_made_the_calling_ones_work():
    """Several threads ask at once for a pool whose threads need more memory than there can be."""
    program = """
import sys, threading
import numpy as np
import diffuse_contact as dc

grid = [[x, y, 0.1 * x] for x in (-1.0, 0.0, 1.0) for y in (-1.0, 0.0, 1.0)]
slaves, masters = np.array([[0.1, 0.2, 0.3]] * 64), np.array([grid] * 64)
sys.setswitchinterval(1e-6)
start = threading.Barrier(6)
answers = []

def work():
    start.wait()
    for _ in range(200):
        batch = dc.gap(slaves, masters, [0, 0, 1], mode="value")
        answers.append((dc.thread_count(), batch.gap.tolist()))

workers = [threading.Thread(target=work) for _ in range(6)]
for worker in workers:
    worker.start()
for worker in workers:
    worker.join()
height = (0.3 - 0.01) / 1.01**0.5
assert len(answers) == 1200
for count, gaps in answers:
    assert count == 1 and len(gaps) == 64 and all(abs(gap - height) < 1e-12 for gap in gaps), (count, gaps[0])
"""
    environment = {**os.environ, "RUST_MIN_STACK": str(1 << 60)}
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
