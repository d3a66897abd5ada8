"""JAX: vmap of the Hessian, compiled by XLA, one thread.

Run by itself it is a worker: `python jax_rival.py WHAT BATCH INPUTS RESULTS` reads inputs from a file, compiles,
writes the results to another, and then answers every line, a number of seconds, with a time.
"""

import json
import os
import pathlib
import subprocess
import sys
import time

import numpy as np

import model
from elements import HELD, split_held


class Rival:
    """A worker process with the compiled function of one number of nodes."""

    name = "jax"

    def __init__(self, folder, what, elements, batch):
        self.what, self.elements = what, elements
        folder.mkdir(parents=True, exist_ok=True)
        inputs, results = (folder / f"jax-{what}-{elements.nodes}-{part}.npy" for part in ("inputs", "results"))
        np.save(inputs, elements.inputs())
        flags = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"
        environment = {**os.environ, "XLA_FLAGS": flags, "JAX_PLATFORMS": "cpu", "JAX_ENABLE_X64": "1"}
        environment |= {"OMP_NUM_THREADS": "1"}
        command = [sys.executable, __file__, what, str(batch), inputs, results]
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
        self.process = subprocess.Popen(command, env=environment, text=True, **pipes)
        self.results = results
        self.facts = self.answer()

    def answer(self):
        """Next line of the worker."""
        line = self.process.stdout.readline()
        if not line:
            raise RuntimeError(f"the JAX worker has ended with exit code {self.process.wait()}")
        return json.loads(line)

    def run(self, seconds):
        """Nanoseconds an element."""
        self.process.stdin.write(f"{seconds}\n")
        self.process.stdin.flush()
        return self.answer()["ns_per_element"]

    def difference(self):
        """Largest difference from the generated kernels."""
        size = 3 * (self.elements.nodes + 1)
        results = np.load(self.results)
        hessians = results[:, 1 + size :].reshape(-1, size, size)
        return self.elements.difference(self.what, results[:, 0], results[:, 1 : 1 + size], hessians)

    def close(self):
        """Ends the worker."""
        self.process.stdin.close()
        self.process.wait()


def compiled(what, size, batch):
    """The function for a batch of inputs, and how long XLA took."""
    import jax
    import jax.numpy as jnp

    def value(x, held):
        frame, radius, point, foot, inverse = split_held(held)
        positions = x.reshape(-1, 3)
        offsets = (positions[1:] - positions[0]) @ frame.reshape(3, 3).T / radius
        a, b, z = offsets.T
        s = a * a + b * b
        w = 1 - 3 * s + 2 * s * jnp.sqrt(s)
        p = jnp.stack([jnp.ones_like(a), a, b, a * a, a * b, b * b], 1)
        # Twice as fast here as factors unrolled or by Cholesky.
        alpha = jnp.linalg.solve((w[:, None] * p).T @ p, (w * z) @ p)
        if what == "surface":
            return model.surface(alpha, radius, point)
        return model.gap(alpha, radius, foot, inverse, jnp.sqrt)

    def all_three(inputs):
        x, held = inputs[:size], inputs[size:]
        f, gradient = jax.value_and_grad(value)(x, held)
        return f, gradient, jax.hessian(value)(x, held)

    start = time.perf_counter()
    lowered = jax.jit(jax.vmap(all_three)).lower(jax.ShapeDtypeStruct((batch, size + HELD), np.float64))
    return lowered.compile(), time.perf_counter() - start


def work(what, batch, inputs, results):
    """The worker."""
    if hasattr(os, "sched_setaffinity"):
        # XLA has threads that no flag takes away.
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    import jax

    inputs = np.load(inputs)
    size = inputs.shape[1] - HELD
    function, compile_s = compiled(what, size, batch)
    repeated = jax.device_put(inputs[np.arange(batch) % len(inputs)])
    f, gradient, hessian = (np.asarray(part) for part in function(repeated))
    rows = [f[:, None], gradient, hessian.reshape(batch, -1)]
    np.save(results, np.hstack(rows)[: min(batch, len(inputs))])
    print(json.dumps({"compile_s": compile_s, "batch": batch}), flush=True)
    for line in sys.stdin:
        seconds, calls, start = float(line), 0, time.perf_counter()
        while calls == 0 or time.perf_counter() - start < seconds:
            jax.block_until_ready(function(repeated))
            calls += 1
        elapsed = time.perf_counter() - start
        print(json.dumps({"ns_per_element": 1e9 * elapsed / (calls * batch)}), flush=True)


if __name__ == "__main__":
    work(sys.argv[1], int(sys.argv[2]), pathlib.Path(sys.argv[3]), pathlib.Path(sys.argv[4]))
