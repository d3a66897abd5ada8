#!/usr/bin/env python3
"""Makes the meshes of this directory with Gmsh.

    pip install gmsh==4.15.2
    python3 make_meshes.py

writes, beside this script,

    plate_on_cylinder.msh   MSH 4.1, ASCII    a plate close to a cylinder
    plate_on_cylinder.inp   Abaqus            the same nodes and elements
    torus_patch.msh         MSH 4.1, binary   a plate close to the crown of a torus

Each mesh has two physical surfaces: "master", coarse and curved, oriented towards +z, and "slave", finer,
oriented towards the master (-z). Between them the gap goes from about -0.5 mm (penetration) to some millimetres,
and every slave node projects inside the master, well away from its border. Lengths are in millimetres.

The same version of Gmsh gives the same files, byte for byte.
"""

import math
from pathlib import Path

import gmsh

DIRECTORY = Path(__file__).resolve().parent


def new_model(name):
    """Starts an empty model with options that do not depend on the user's configuration."""
    gmsh.clear()
    gmsh.model.add(name)
    gmsh.option.setNumber("General.NumThreads", 1)
    gmsh.option.setNumber("Mesh.Algorithm", 6)  # Frontal-Delaunay
    gmsh.option.setNumber("Mesh.RandomSeed", 1)
    gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 1)


def arc(centre, radius, first, last, horizontal):
    """A circular arc in the plane of `horizontal` and +z; angles in degrees, from +z towards `horizontal`."""

    def point(angle):
        sine, cosine = radius * math.sin(math.radians(angle)), radius * math.cos(math.radians(angle))
        offset = [sine * component for component in horizontal]
        return gmsh.model.occ.addPoint(centre[0] + offset[0], centre[1] + offset[1], centre[2] + cosine)

    ends = point(first), point(last)
    middle = gmsh.model.occ.addPoint(*centre)
    curve = gmsh.model.occ.addCircleArc(ends[0], middle, ends[1])
    gmsh.model.occ.remove([(0, middle)])
    return curve


def extruded(curve, direction):
    """The surface that a curve sweeps, and the curve at its end."""
    swept = gmsh.model.occ.extrude([(1, curve)], *direction)
    surface = next(tag for dimension, tag in swept if dimension == 2)
    end = next(tag for dimension, tag in swept if dimension == 1)
    return surface, end


def curves_of(surface):
    return [abs(tag) for _, tag in gmsh.model.getBoundary([(2, surface)], oriented=False)]


def divide(curve, intervals):
    gmsh.model.mesh.setTransfiniteCurve(curve, intervals + 1)


def direction_of(curve):
    """The axis (0, 1, 2) along which a curve's bounding box is longest."""
    box = gmsh.model.getBoundingBox(1, curve)
    extents = [box[axis + 3] - box[axis] for axis in range(3)]
    return extents.index(max(extents))


def divide_plate(surface, intervals):
    for curve in curves_of(surface):
        divide(curve, intervals)


def structured_quadrilaterals(surface):
    gmsh.model.mesh.setTransfiniteSurface(surface)
    gmsh.model.mesh.setRecombine(2, surface)


def orient(surfaces, upward):
    """Turns the elements of surfaces round where their normals have the wrong sign of z."""
    for surface in surfaces:
        kinds, _, nodes = gmsh.model.mesh.getElements(2, surface)
        corners = [gmsh.model.mesh.getNode(tag)[0] for tag in nodes[0][: 3 if kinds[0] == 2 else 4]]
        u, v = corners[1] - corners[0], corners[-1] - corners[0]
        if (u[0] * v[1] - u[1] * v[0] > 0) != upward:
            gmsh.model.mesh.reverse([(2, surface)])


def name_and_write(master, slave, path, binary):
    orient(master, upward=True)
    orient(slave, upward=False)
    gmsh.model.addPhysicalGroup(2, master, 1, "master")
    gmsh.model.addPhysicalGroup(2, slave, 2, "slave")
    gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
    gmsh.option.setNumber("Mesh.Binary", int(binary))
    gmsh.write(str(path))


def make_plate_on_cylinder(path):
    """Master: 120 degrees of a cylinder of radius 100 about the y axis, its top at z = 100;
    quadrilaterals where y < 0, triangles where y > 0. Slave: a plate of 60 x 60, slightly curved along y and tilted."""
    new_model("plate_on_cylinder")
    radius, half_length = 100.0, 60.0

    border = arc((0.0, -half_length, 0.0), radius, -60.0, 60.0, (1.0, 0.0, 0.0))
    with_quadrilaterals, middle = extruded(border, (0.0, half_length, 0.0))
    with_triangles, _ = extruded(middle, (0.0, half_length, 0.0))

    # The plate's lowest line is at the height of the cylinder's top less the penetration.
    plate_radius, half_width, penetration = 400.0, 30.0, 0.5
    half_angle = math.degrees(math.asin(half_width / plate_radius))
    centre = (8.0 - half_width, 5.0, radius - penetration + plate_radius)
    lowest = arc(centre, plate_radius, 180.0 - half_angle, 180.0 + half_angle, (0.0, 1.0, 0.0))
    plate, _ = extruded(lowest, (2.0 * half_width, 0.0, 0.0))
    gmsh.model.occ.rotate([(2, plate)], 0.0, 0.0, radius, 0.0, 1.0, 0.0, math.radians(1.5))

    gmsh.model.occ.synchronize()
    for surface, along in ((with_quadrilaterals, 5), (with_triangles, 6)):
        for curve in curves_of(surface):
            divide(curve, along if direction_of(curve) == 1 else 14)
    structured_quadrilaterals(with_quadrilaterals)
    divide_plate(plate, 18)
    gmsh.model.mesh.generate(2)
    name_and_write([with_quadrilaterals, with_triangles], [plate], path, binary=False)


def make_torus_patch(path):
    """Master: the crown of a torus whose axis is parallel to z; the crown passes through the origin, with the saddle
    on the side of -x. Slave: a flat plate of 30 x 30, slightly tilted."""
    new_model("torus_patch")
    major, minor = 120.0, 50.0

    profile = arc((0.0, 0.0, -minor), minor, -50.0, 50.0, (1.0, 0.0, 0.0))
    half_sweep = math.radians(25.0)
    axis = (-major, 0.0, 0.0, 0.0, 0.0, 1.0)
    gmsh.model.occ.rotate([(1, profile)], *axis, -half_sweep)
    swept = gmsh.model.occ.revolve([(1, profile)], *axis, 2.0 * half_sweep)
    crown = next(tag for dimension, tag in swept if dimension == 2)

    plate = gmsh.model.occ.addRectangle(-13.0, -16.0, -0.3, 30.0, 30.0)
    gmsh.model.occ.rotate([(2, plate)], 0.0, 0.0, 0.0, 1.0, 0.5, 0.0, math.radians(1.0))

    gmsh.model.occ.synchronize()
    for curve in curves_of(crown):
        divide(curve, 10)
    structured_quadrilaterals(crown)
    divide_plate(plate, 8)
    gmsh.model.mesh.generate(2)
    name_and_write([crown], [plate], path, binary=True)


def write_abaqus(mesh, path):
    """Writes the triangles and quadrilaterals of a mesh file as an Abaqus input file, set by set."""
    gmsh.clear()
    gmsh.open(str(mesh))
    element_types = {2: ("S3", 3), 3: ("S4", 4)}
    lines = ["*HEADING", "Plate on cylinder, millimetres", "** Made by make_meshes.py from the Gmsh mesh.", "*NODE"]
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    for tag, point in sorted(zip(tags, coordinates.reshape(-1, 3), strict=True), key=lambda node: node[0]):
        lines.append(f"{tag}, " + ", ".join(repr(float(x)) for x in point))
    for dimension, group in gmsh.model.getPhysicalGroups(2):
        name = gmsh.model.getPhysicalName(dimension, group)
        for surface in gmsh.model.getEntitiesForPhysicalGroup(dimension, group):
            for kind, elements, nodes in zip(*gmsh.model.mesh.getElements(2, surface), strict=True):
                element_type, count = element_types[kind]
                lines.append(f"*ELEMENT, TYPE={element_type}, ELSET={name}")
                for tag, corners in zip(elements, nodes.reshape(-1, count), strict=True):
                    lines.append(", ".join(str(number) for number in (tag, *corners)))
    for side in ("master", "slave"):
        lines += [f"*SURFACE, TYPE=ELEMENT, NAME={side}_surface", f"{side}, SPOS"]
    path.write_text("\n".join(lines) + "\n", encoding="ascii", newline="\n")


def main():
    gmsh.initialize(readConfigFiles=False)
    gmsh.option.setNumber("General.Terminal", 0)
    make_plate_on_cylinder(DIRECTORY / "plate_on_cylinder.msh")
    make_torus_patch(DIRECTORY / "torus_patch.msh")
    write_abaqus(DIRECTORY / "plate_on_cylinder.msh", DIRECTORY / "plate_on_cylinder.inp")
    gmsh.finalize()


if __name__ == "__main__":
    main()
