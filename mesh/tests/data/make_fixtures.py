#!/usr/bin/env python3
"""Makes the Gmsh files of this directory, which the reader's tests read.

    pip install gmsh==4.15.2
    python3 make_fixtures.py

`block_ascii.msh` and `block_binary.msh` are one mesh: a block of 2 x 1 x 1 with 2 x 1 x 1 hexahedra, parametric
nodes and physical groups of every dimension, one of them reversed, one without a name. `block_gmsh.inp` is the same as
Abaqus input. `serendipity.msh` and `lagrange.msh` hold one block each of tetrahedra, wedges (the first only) and hexahedra of second
order with straight edges. The other files are what the reader has to refuse. (`cae.inp` is written by hand.)
"""

import os
from pathlib import Path

import gmsh

DIRECTORY = Path(__file__).resolve().parent


def write(name, **options):
    for option, value in options.items():
        gmsh.option.setNumber(f"Mesh.{option}", value)
    # Abaqus input has the name it was written under in its heading.
    gmsh.write(name)


def square():
    gmsh.clear()
    gmsh.model.add("square")
    gmsh.model.occ.addRectangle(0, 0, 0, 1, 1)
    gmsh.model.occ.synchronize()
    gmsh.model.mesh.setTransfiniteAutomatic()
    for _, curve in gmsh.model.getEntities(1):
        gmsh.model.mesh.setTransfiniteCurve(curve, 2)
    gmsh.model.mesh.generate(2)
    gmsh.model.addPhysicalGroup(2, [1], 1, "square")


def block():
    gmsh.clear()
    gmsh.model.add("block")
    gmsh.model.occ.addBox(0, 0, 0, 2, 1, 1)
    gmsh.model.occ.synchronize()
    for _, curve in gmsh.model.getEntities(1):
        box = gmsh.model.getBoundingBox(1, curve)
        gmsh.model.mesh.setTransfiniteCurve(curve, 3 if box[3] - box[0] > 1.5 else 2)
    for _, surface in gmsh.model.getEntities(2):
        gmsh.model.mesh.setTransfiniteSurface(surface)
        gmsh.model.mesh.setRecombine(2, surface)
    gmsh.model.mesh.setTransfiniteVolume(1)
    gmsh.model.mesh.generate(3)

    def sides(axis, low, high):
        centre = {surface: gmsh.model.occ.getCenterOfMass(2, surface)[axis] for _, surface in gmsh.model.getEntities(2)}
        return [surface for surface, x in centre.items() if abs(x - low) < 1e-9 or abs(x - high) < 1e-9]

    gmsh.model.addPhysicalGroup(3, [1], 1, "the block")
    gmsh.model.addPhysicalGroup(2, sides(2, 1, 1), 2, "top")
    gmsh.model.addPhysicalGroup(2, [-surface for surface in sides(2, 1, 1)], 3, "top reversed")
    gmsh.model.addPhysicalGroup(2, sides(0, 0, 2), 4)
    gmsh.model.addPhysicalGroup(1, [1], 5, "edge")
    gmsh.model.addPhysicalGroup(0, [1], 6, "corner")


def second_order(name, incomplete):
    gmsh.clear()
    gmsh.model.add(name)
    gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
    for x, recombine in [(2, False), (4, True)][int(not incomplete):]:
        base = gmsh.model.occ.addRectangle(x, 0, 0, 1, 1)
        gmsh.model.occ.synchronize()
        gmsh.model.mesh.setTransfiniteSurface(base)
        if recombine:
            gmsh.model.mesh.setRecombine(2, base)
        gmsh.model.occ.extrude([(2, base)], 0, 0, 1, numElements=[1], recombine=True)
    gmsh.model.occ.synchronize()
    for _, curve in gmsh.model.getEntities(1):
        gmsh.model.mesh.setTransfiniteCurve(curve, 2)
    gmsh.model.mesh.generate(3)
    gmsh.option.setNumber("Mesh.SecondOrderIncomplete", int(incomplete))
    gmsh.model.mesh.setOrder(2)
    for _, volume in gmsh.model.getEntities(3):
        sides = [surface for _, surface in gmsh.model.getBoundary([(3, volume)], oriented=False)]
        gmsh.model.addPhysicalGroup(3, [volume], volume, f"solid {volume}")
        gmsh.model.addPhysicalGroup(2, sides, volume, f"skin {volume}")
    write(f"{name}.msh", MshFileVersion=4.1, Binary=0, SaveParametric=0)


def main():
    os.chdir(DIRECTORY)
    gmsh.initialize(readConfigFiles=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setNumber("General.NumThreads", 1)
    block()
    write("block_ascii.msh", MshFileVersion=4.1, Binary=0, SaveParametric=1)
    write("block_binary.msh", MshFileVersion=4.1, Binary=1, SaveParametric=1)
    write("block_gmsh.inp", SaveGroupsOfElements=1, SaveGroupsOfNodes=0, SaveParametric=0)
    square()
    write("version_2.msh", MshFileVersion=2.2, Binary=0, SaveParametric=0)
    gmsh.model.mesh.setOrder(3)
    write("third_order.msh", MshFileVersion=4.1)
    gmsh.model.mesh.setOrder(1)
    gmsh.model.mesh.partition(2)
    write("partitioned.msh", MshFileVersion=4.1)
    second_order("serendipity", True)
    second_order("lagrange", False)
    gmsh.finalize()


if __name__ == "__main__":
    main()
