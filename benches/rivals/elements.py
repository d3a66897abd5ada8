"""The benchmark's elements as arrays, and what the generated kernels make of them."""

import json
import subprocess

import numpy as np

import model

# What is held while differentiating, after the coordinates: frame (t1, t2, normal), R, point, foot over R, inverse
# Jacobian of the foot equations.
HELD = 9 + 1 + 2 + 2 + 3


def split_held(held):
    """Frame as nine numbers, R, point, foot, inverse Jacobian."""
    return held[:9], held[9], (held[10], held[11]), (held[12], held[13]), (held[14], held[15], held[16])


class Elements:
    """Elements with `nodes` master nodes each."""

    def __init__(self, program, nodes, count):
        text = subprocess.run([program, str(nodes), str(count)], check=True, capture_output=True).stdout
        entries = json.loads(text)["elements"]
        self.nodes = nodes
        self.coordinates = np.array([np.ravel([entry["slave"], *entry["masters"]]) for entry in entries])
        self.held = np.array([held(entry) for entry in entries])
        self.expected = {what: [entry[what] for entry in entries] for what in ("surface", "gap")}

    def inputs(self):
        """Coordinates and what is held, one row for each element."""
        return np.hstack([self.coordinates, self.held])

    def difference(self, what, values, gradients, hessians):
        """Largest difference of value, gradient and Hessian from the generated kernels; relative to R or to the
        largest entry. `hessians` are squares or packed lower triangles."""
        size = 3 * (self.nodes + 1)
        lower = np.tril_indices(size)
        worst = 0.0
        for k, expected in enumerate(self.expected[what]):
            hessian = np.asarray(hessians[k])
            hessian = hessian[lower] if hessian.shape == (size, size) else hessian
            worst = max(
                worst,
                abs(values[k] - expected["value"]) / self.held[k, 9],
                relative(gradients[k], expected["gradient"]),
                relative(hessian, expected["hessian"]),
            )
        return worst


def relative(found, expected):
    """Largest difference over the largest entry; a NaN comes through as infinity."""
    expected = np.asarray(expected)
    difference = np.max(np.abs(np.asarray(found) - expected)) / np.max(np.abs(expected))
    return float(difference) if np.isfinite(difference) else float("inf")


def held(entry):
    """What is held while differentiating, in the order of `HELD`."""
    frame, radius = np.array(entry["frame"]), entry["support_radius"]
    offsets = (np.array(entry["masters"]) - np.array(entry["slave"])) @ frame.T / radius
    alpha = model.coefficients(*offsets.T, np.sum, np.sqrt)
    foot, inverse = model.find_foot(alpha)
    return np.concatenate([frame.ravel(), [radius], entry["point"], foot, inverse])
