"""Calls in no order with arguments that nobody expects: a result or an exception of ours, never a crash.

Where there is a result its numbers are finite.

About two seconds from a fixed seed; with ``DC_FUZZ_SECONDS=600`` other seeds, for that long.
"""

import os
import random
import threading
import time

import numpy as np
from conftest import Scene

import diffuse_contact as dc

SECONDS = os.environ.get("DC_FUZZ_SECONDS")
#: Calls from one seed.
CALLS = 400
ODD_NUMBERS = (0.0, -0.0, -1.0, 1e-320, 1e-160, 1e75, 1e76, 1e300, np.inf, -np.inf, np.nan)
ODD_THINGS = (
    None,
    True,
    3,
    -1,
    2**31,
    2**63,
    2**64,
    10**400,
    10**5000,
    0.5,
    1e300,
    np.nan,
    1j,
    "cubic",
    "\ud800",
    b"x",
    (),
    [],
    {},
    {1, 2},
    [[]],
    [[1], [1, 2]],
    [10**400],
    object(),
    len,
    np.array(3),
    np.float32(1),
    np.array(["a"]),
    np.array([None, 1]),
    np.zeros((0, 3)),
    np.zeros((2, 3, 4)),
    np.array(["2020-01-01"], dtype="datetime64"),
    np.ma.masked_array([1.0, 2.0], mask=[True, False]),
)
WORDS = (
    "value",
    "gradient",
    "hessian",
    "cubic",
    "cubic-interpolating",
    "wendland-c2",
    "quadratic",
    "linear",
    "co-moving",
    "held",
    "diffuse",
    "node-to-facet",
    "domains",
    "hull-layers",
    "hull-radius",
    "nearest",
    "exact",
    "gauss-newton",
    "raise",
    "status",
    "full",
    "lower",
)


class Fuzz:
    """Interfaces, and calls to them, from one seed."""

    def __init__(self, seed):
        self.random = random.Random(seed)
        self.numbers = np.random.default_rng(seed)
        self.scene = Scene()
        self.interfaces = [self.scene.evaluated()]
        self.lock = threading.Lock()
        self.results = {}

    def one_in(self, count):
        return self.random.randrange(count) == 0

    def odd(self, value, often=25):
        """Mostly the value itself."""
        return self.random.choice(ODD_THINGS) if self.one_in(often) else value

    def array(self, values, is_read=True):
        """An array with other numbers, type, shape, order, alignment or strides now and then."""
        values = np.array(values, dtype=float)
        while is_read and self.one_in(6) and values.size:
            values.reshape(-1)[self.random.randrange(values.size)] = self.random.choice(ODD_NUMBERS)
        kind = self.random.randrange(24)
        with np.errstate(all="ignore"):
            if kind == 0:
                return values.astype(self.random.choice(["f4", "f2", ">f8", "g", "c16", "O", "U9", "?", "i8", "u1"]))
        if kind == 1:
            return np.asfortranarray(values)
        if kind == 2 and values.ndim:
            return np.repeat(values, 2, axis=0)[::2]
        if kind == 3:
            buffer = np.empty(values.nbytes + 1, dtype=np.uint8)[1:]
            array = buffer.view(float).reshape(values.shape)
            array[...] = values
            return array
        if kind == 4:
            return values.tolist()
        if kind == 5:
            return values[: self.random.randrange(len(values) + 1)] if values.ndim else values
        if kind == 6:
            return values.reshape(-1)
        if kind == 7:
            values.flags.writeable = False
        return self.odd(values)

    def indices(self, values, large=2**31):
        values = np.array(values)
        if self.one_in(8) and values.size:
            place = self.random.randrange(values.size)
            values.reshape(-1)[place] = self.random.choice([-1, -2, 0, 1, 80, 85, large, 2**62, -(2**62)])
        if self.one_in(12):
            values = values.astype(self.random.choice(["i4", "u8", "i1", "f8", "O"]))
        return self.odd(values)

    def positions(self):
        scale = self.random.choice([0.0, 0.01, 0.3, 3.0])
        moved = self.scene.positions + scale * self.numbers.normal(size=(85, 3))
        moved[81:, 2] += self.random.choice([0.0, 0.0, -0.3, 2.0, -40.0])
        return self.array(moved)

    def word(self, *words):
        return self.odd(self.random.choice(words if self.random.randrange(12) else WORDS))

    def interface(self):
        with self.lock:
            return self.random.choice(self.interfaces)

    def some(self, **options):
        """Some of the options."""
        return {name: value() for name, value in options.items() if self.one_in(4)}

    def create(self):
        scene = self.scene
        master = dc.MasterSurface(self.positions(), self.indices(scene.facets))
        options = self.some(
            element=lambda: self.word("diffuse", "node-to-facet"),
            weight=lambda: self.word("cubic", "cubic-interpolating", "wendland-c2"),
            frame_derivative=lambda: self.word("co-moving", "held"),
            rule=lambda: self.word("domains", "hull-layers", "hull-radius", "nearest"),
            basis=lambda: self.word("quadratic", "linear"),
            layers=lambda: self.odd(self.random.randrange(5), 4),
            max_layers=lambda: self.odd(self.random.randrange(9), 4),
            neighbours=lambda: self.odd(self.random.randrange(30), 4),
            candidates=lambda: self.odd(self.random.randrange(90), 4),
            linear_fallback=lambda: self.odd(self.one_in(2), 4),
            radius_factor=lambda: self.odd(1 + self.random.random(), 4),
            feature_angle=lambda: self.odd(180 * self.random.random(), 4),
            distance_limit=lambda: self.odd(self.random.choice([0.5, 3.0, *ODD_NUMBERS]), 4),
            slave_facets=lambda: self.indices(scene.slave_facets),
            symmetry=lambda: self.odd([([self.odd(0.0), 0.0, 0.0], [self.odd(1.0, 20), 0.0, 0.0])]),
            # A system of 2³¹ equations is none too many, but for this machine's memory.
            dofs=lambda: self.indices(np.arange(255).reshape(85, 3), large=300),
        )
        if "dofs" in options and self.one_in(3):
            equations = self.odd(self.random.choice([255, 300, 4]))
            options["equations"] = 2**62 if equations is ODD_THINGS[4] else equations
        interface = dc.ContactInterface(self.odd(master), self.indices(scene.slaves), self.positions(), **options)
        with self.lock:
            self.interfaces.append(interface)
            del self.interfaces[:-6]
        return []

    def refresh(self):
        interface = self.interface()
        report = interface.refresh_pairing(self.positions())
        assert report.frozen or report.paired + sum(report.without.values()) == len(interface.slaves)
        return []

    def update(self):
        self.interface().update(self.positions())
        return []

    def follow(self):
        assert self.interface().follow(self.positions()) in (False, True)
        return []

    def evaluate(self):
        contacts = self.interface().evaluate(self.word("value", "gradient", "hessian"))
        assert len(contacts.outcomes) == len(contacts.gap)
        found = contacts.is_contact
        return [contacts.gap[found], contacts.foot[found], contacts.normal[found], contacts.area]

    def look(self):
        interface, k = self.interface(), self.odd(self.random.randrange(5))
        what = self.random.randrange(7)
        if what == 0:
            contact = interface.contact(k)
            return [array for array in (contact.gap, contact.gradient, contact.hessian) if array is not None]
        if what == 1:
            return [interface.pairing(k).positions]
        if what == 2:
            factor = interface.cut_back(self.odd(0.25)).factor
            assert 0.1 <= factor <= 1
            return [factor]
        if what == 3:
            (interface.thaw if self.random.randrange(4) else interface.freeze)()
        if what == 4:
            assert len(repr(interface)) < 200 and interface.equations >= 0
        if what == 5:
            return [interface.contacts.penetration]
        if what == 6:
            feet = interface.foot_derivatives()
            return [feet.gap[feet.is_contact], feet.weights, feet.foot_jacobian, feet.normal_jacobian]
        return []

    def assemble(self):
        interface, penalty = self.interface(), self.odd(self.random.choice([1e3, 1e3, *ODD_NUMBERS]), 12)
        options = {}
        if self.one_in(3):
            options["multipliers"] = self.array(self.numbers.random(4))
        what = self.random.randrange(6)
        if what == 0:
            if self.one_in(2):
                options["out"] = self.array(np.zeros(255), is_read=False)
            return [interface.forces(penalty, **options)]
        if what == 1:
            return [interface.normal_forces(penalty, **options)]
        if what == 2:
            return [interface.pressures(penalty, **options)]
        if self.one_in(2):
            options["tangent"] = self.word("exact", "gauss-newton")
        if what == 3:
            return [interface.tangent(penalty, **options).data]
        if what == 4:
            options["triangle"] = self.word("full", "lower")
            return [interface.triplets(penalty, **options)[2]]
        offsets, columns = interface.pattern()
        if self.one_in(2):
            options["out"] = self.array(np.zeros(len(columns)), is_read=False)
        assert offsets[-1] == len(columns)
        return [interface.tangent_values(penalty, **options)]

    def gap(self):
        count, nodes = self.random.choice([0, 1, 5, 70]), self.random.choice([0, 3, 6, 9, 9, 13])
        masters = np.stack([np.arange(nodes) % 3 - 1.0, np.arange(nodes) // 3 - 1.0, np.zeros(nodes)], axis=-1)
        masters = masters + self.random.choice([0.0, 0.1, 1e6]) * self.numbers.normal(size=(count, nodes, 3))
        options = self.some(
            frames=lambda: self.array(np.eye(3)),
            support_radius=lambda: self.array(2 + self.numbers.random(count)),
            basis=lambda: self.word("quadratic", "linear"),
            weight=lambda: self.word("cubic", "cubic-interpolating", "wendland-c2"),
            frame_derivative=lambda: self.word("co-moving", "held"),
            mode=lambda: self.word("value", "gradient", "hessian"),
            packed=lambda: self.odd(self.one_in(2)),
            out=lambda: self.odd(dc.GapBatch.empty(count, nodes)),
        )
        options["on_error"] = self.word("status", "status", "raise")
        slaves = self.array(0.3 * self.numbers.normal(size=(count, 3)))
        result = dc.gap(slaves, self.array(masters), self.array([0.0, 0.0, 1.0]), **options)
        assert "other" not in result.codes()
        arrays = (result.gap, result.foot, result.normal, result.gradient, result.hessian)
        return [array[result.ok] for array in arrays]

    def surface(self):
        positions, corners = self.positions(), self.indices(self.scene.facets)
        if self.one_in(3):
            # Areas of large facets may be too large for a number.
            dc.tributary_areas(positions, corners)
            return []
        surface = dc.MasterSurface(positions, corners)
        assert surface.border_edges.shape[1] == 2 and len(surface.nodes)
        surface.node_normals(self.positions())
        return []

    def call(self):
        """One call; what came of it is counted."""
        kind = self.random.choice(
            [self.create, self.refresh, self.refresh, self.update, self.evaluate, self.evaluate, self.look, self.look]
            + [self.follow, self.assemble, self.assemble, self.gap, self.surface]
        )
        with np.errstate(all="ignore"):
            try:
                for array in kind():
                    assert np.isfinite(array).all(), kind.__name__
                code = "ok"
            except dc.DiffuseContactError as error:
                assert error.code and len(error.message.split()) > 2 and str(error), error.code
                code = error.code
        with self.lock:
            self.results[code] = self.results.get(code, 0) + 1


def fuzz(seed):
    """Calls from one seed, some of them from several threads at once."""
    fuzz = Fuzz(seed)
    for _ in range(CALLS):
        fuzz.call()
    failures = []

    def work():
        try:
            for _ in range(CALLS // 8):
                fuzz.call()
        except BaseException as error:
            failures.append(error)

    workers = [threading.Thread(target=work) for _ in range(3)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join(120)
        assert not worker.is_alive(), f"seed {seed}: threads wait for each other"
    if failures:
        raise failures[0]
    return fuzz.results


def test_odd_calls_end_in_exceptions_of_ours():
    start = time.monotonic()
    results, seeds = {}, 0
    while time.monotonic() - start < float(SECONDS or 2) or seeds < 2:
        seeds += 1
        try:
            found = fuzz(seeds)
        except BaseException as error:
            error.add_note(f"seed {seeds}")
            raise
        for code, count in found.items():
            results[code] = results.get(code, 0) + count
    print(f"{sum(results.values())} calls from {seeds} seeds: {results}")
    assert results["ok"] > 100
    for code in ("wrong-shape", "wrong-type", "invalid-option", "not-evaluated", "non-finite-position"):
        assert results.get(code), results
