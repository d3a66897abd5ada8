#!/usr/bin/env python3
"""Draws the diffuse surface over its facets: `python3 surface.py [picture.png]`.

The master is a wavy patch of coarse facets. Slave nodes are laid on a fine grid all over it and paired with it; the
foot of each is a point of the diffuse surface. As the surface at a point is the fit of the nodes around it, and so
belongs to a slave that sits there, the slaves are moved to their feet until they stay: what is left is drawn.
"""

# %% A wavy patch of 8 × 8 quadrilaterals, outside above.
import sys

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

import diffuse_contact as dc

if len(sys.argv) > 1:
    plt.switch_backend("Agg")

CELLS = 8
x, y = np.meshgrid(np.arange(CELLS + 1.0), np.arange(CELLS + 1.0))
height = 1.1 * np.sin(np.pi * x / 4) * np.cos(np.pi * y / 5)
masters = np.column_stack([x.ravel(), y.ravel(), height.ravel()])
corner = (np.arange(CELLS)[:, np.newaxis] * (CELLS + 1) + np.arange(CELLS)).ravel()
facets = np.column_stack([corner, corner + 1, corner + CELLS + 2, corner + CELLS + 1])

# %% Slave nodes on a fine grid over the facets: the bilinear interpolation of the corners.
FINE = 65
s = np.linspace(0.0, CELLS, FINE)
columns, rows = np.meshgrid(s, s)
i, j = np.minimum(columns.astype(int), CELLS - 1), np.minimum(rows.astype(int), CELLS - 1)
a, b = columns - i, rows - j
low = (1 - a) * height[j, i] + a * height[j, i + 1]
high = (1 - a) * height[j + 1, i] + a * height[j + 1, i + 1]
flat = (1 - b) * low + b * high
points = np.column_stack([columns.ravel(), rows.ravel(), flat.ravel()])

# %% Pair them; move them to their feet until the gaps vanish. `normal` is that of the diffuse surface.
master = dc.MasterSurface(masters, facets)
slaves = len(masters) + np.arange(len(points))
positions = np.vstack([masters, points])
interface = dc.ContactInterface(master, slaves, positions, weight="cubic-interpolating")
for iteration in range(20):
    # Slaves that still move by more than a little may find others nearest to them.
    if iteration < 3:
        interface.refresh_pairing(positions)
    else:
        interface.update(positions)
    contacts = interface.evaluate("value")
    found = contacts.is_contact
    positions[slaves[found]] = contacts.foot[found]
    if np.nanmax(np.abs(contacts.gap)) < 1e-6:
        break
print(f"{found.sum()} of {found.size} points lie on the surface to {np.nanmax(np.abs(contacts.gap)):.1e}")

# %% Draw facets with their nodes, and the surface coloured by its distance from the facets.
surface = positions[slaves].copy()
surface[~found] = np.nan
grid = surface.reshape(FINE, FINE, 3)
distance = (surface - points)[:, 2].reshape(FINE, FINE)
limit = np.nanmax(np.abs(distance))
print(f"and have risen by {np.nanmin(distance):.3f} to {np.nanmax(distance):.3f} from their facets")
colours = matplotlib.colormaps["RdBu"](0.5 + 0.5 * np.nan_to_num(distance) / limit)

figure = plt.figure(figsize=(10, 4.6), layout="constrained")
left = figure.add_subplot(1, 2, 1, projection="3d", title="facets")
left.add_collection3d(Poly3DCollection(masters[facets], facecolors="0.85", edgecolors="0.4", shade=True))
left.scatter(*masters.T, s=8, color="black", depthshade=False)
right = figure.add_subplot(1, 2, 2, projection="3d", title="diffuse surface over the facets' edges")
right.plot_surface(*np.moveaxis(grid, -1, 0), facecolors=colours, rcount=FINE, ccount=FINE, linewidth=0, shade=True)
for loop in masters[facets[:, [0, 1, 2, 3, 0]]]:
    right.plot(*loop.T, color="0.3", linewidth=0.6, zorder=10)
for axes in (left, right):
    axes.set(xlim=(0, CELLS), ylim=(0, CELLS), zlim=(-1.6, 1.6), xlabel="x", ylabel="y", zlabel="z")
    axes.set_box_aspect((CELLS, CELLS, 3.2))
    axes.view_init(elev=38, azim=-60)
scale = matplotlib.cm.ScalarMappable(matplotlib.colors.Normalize(-limit, limit), "RdBu")
figure.colorbar(scale, ax=right, shrink=0.6, label="rise of a point from its facet, z")

if len(sys.argv) > 1:
    figure.savefig(sys.argv[1], dpi=76)
else:
    plt.show()
