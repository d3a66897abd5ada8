import dataclasses
import multiprocessing
import os
import subprocess
import sys
import threading

import numpy as np
import pytest

import diffuse_contact as dc


def grid(cells):
    """Positions and facets of a plane grid."""
    k = np.arange((cells + 1) ** 2)
    positions = np.column_stack([k % (cells + 1), k // (cells + 1), np.zeros(len(k))]).astype(float)
    first = np.arange(cells**2) % cells + (cells + 1) * (np.arange(cells**2) // cells)
    return positions, np.column_stack([first, first + 1, first + cells + 2, first + cells + 1])


def large_interface():
    masters, facets = grid(60)
    slaves, _ = grid(59)
    positions = np.vstack([masters, slaves + [0.5, 0.5, -0.01]])
    interface = dc.ContactInterface(dc.MasterSurface(positions, facets), np.arange(3721, 3721 + 3600), positions)
    interface.refresh_pairing(positions)
    return interface, positions


def test_two_threads_on_one_interface_are_refused_with_a_sentence():
    interface, positions = large_interface()
    refusals, others, stop = [], [], threading.Event()

    def work():
        while not stop.is_set():
            try:
                interface.update(positions)
                interface.evaluate("hessian")
            except dc.BusyError as error:
                refusals.append(error)
                if len(refusals) > 5:
                    stop.set()
            except dc.InterfaceError as error:
                # Between another thread's update and evaluation.
                assert error.code == "not-evaluated"
            except BaseException as error:
                others.append(error)
                stop.set()

    workers = [threading.Thread(target=work) for _ in range(3)]
    for worker in workers:
        worker.start()
    stop.wait(60)
    stop.set()
    for worker in workers:
        worker.join()
    assert not others
    assert refusals, "the GIL is released during an evaluation, so another thread has to get in its way"
    assert refusals[0].code == "busy" and "in use by another thread" in str(refusals[0])
    interface.update(positions)
    assert interface.evaluate().is_contact.all()


def test_threads_with_an_interface_each_agree():
    results = [None] * 4

    def work(k):
        interface, _ = large_interface()
        results[k] = interface.evaluate().gap

    workers = [threading.Thread(target=work, args=(k,)) for k in range(4)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    for gap in results[1:]:
        np.testing.assert_array_equal(gap, results[0])


def test_the_number_of_threads_can_be_set():
    dc.set_threads(2)
    assert dc.thread_count() == 2
    for bad in (0, -1, 5000, 1.5, True):
        with pytest.raises(dc.InputError):
            dc.set_threads(bad)
    dc.set_threads(None)
    assert dc.thread_count() >= 1


def test_instructions_are_chosen_before_the_first_evaluation():
    """Results of one process are made with the same instructions."""
    used = dc.isa()
    dc.set_isa(used)
    assert used in ("scalar", "avx2", "avx512", "neon")
    with pytest.raises(dc.InputError, match='"sse9" is none of scalar'):
        dc.set_isa("sse9")
    if used != "scalar":
        with pytest.raises(dc.InputError, match="comes too late"):
            dc.set_isa("scalar")
    program = "import diffuse_contact as dc; dc.set_isa('scalar'); print(dc.isa())"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "scalar"
    environment = {**os.environ, "DIFFUSE_CONTACT_ISA": "sse9"}
    program = "import diffuse_contact as dc; print(dc.isa())"
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.strip() in ("scalar", "avx2", "avx512", "neon")
    assert "DIFFUSE_CONTACT_ISA=sse9 is not among" in done.stderr


def _gap_in_child(queue):
    interface, _ = large_interface()
    queue.put(float(interface.evaluate("value").gap[0]))


_worker = {}


def _make_in_worker(positions, facets, slaves, options):
    interface = dc.ContactInterface(dc.MasterSurface(positions, facets), slaves, positions, **options)
    interface.refresh_pairing(positions)
    _worker["interface"] = interface


def _gaps_in_worker(positions):
    _worker["interface"].update(positions)
    return _worker["interface"].evaluate("value")


def test_a_pool_makes_its_interfaces_from_arrays():
    masters, facets = grid(8)
    slaves, _ = grid(3)
    positions = np.vstack([masters, slaves + [2.3, 2.4, -0.01]])
    numbers = np.arange(len(masters), len(positions))
    interface = dc.ContactInterface(dc.MasterSurface(positions, facets), numbers, positions, weight="wendland-c2")
    interface.refresh_pairing(positions)
    moved = positions + 0.001 * np.sin(np.arange(positions.size)).reshape(positions.shape)
    interface.update(moved)
    made_of = (positions, facets, numbers, dataclasses.asdict(interface.options))
    context = multiprocessing.get_context("spawn")
    with context.Pool(1, initializer=_make_in_worker, initargs=made_of) as pool:
        contacts = pool.apply_async(_gaps_in_worker, (moved,)).get(timeout=120)
        with pytest.raises(TypeError, match="cannot be pickled"):
            pool.apply_async(_gaps_in_worker, (interface,)).get(timeout=120)
    np.testing.assert_array_equal(contacts.gap, interface.evaluate("value").gap)


def test_a_forked_process_gets_threads_of_its_own():
    interface, _ = large_interface()
    expected = float(interface.evaluate("value").gap[0])
    context = multiprocessing.get_context("fork")
    queue = context.Queue()
    child = context.Process(target=_gap_in_child, args=(queue,))
    child.start()
    assert queue.get(timeout=60) == expected
    child.join(60)
    assert child.exitcode == 0
