"""The 3D diffuse contact element of Chamoret, Rassineux and Bergheau (2008).

The master surface is a moving least squares fit through its nodes, so that the normal does not jump; gap, gradient N
and Hessian M are exact. ``gap`` evaluates many elements on arrays; ``ContactInterface`` pairs slave nodes with a
``MasterSurface`` and assembles forces and tangent. Coordinates are global, in one length unit of the caller's choice;
the gap is positive apart and negative penetrating; derivatives are ordered slave, master 1, …, master n.
"""

from ._batch import STATUS_CODES, GapBatch, gap
from ._errors import (
    AssemblyError,
    BusyError,
    DiffuseContactError,
    ElementError,
    InputError,
    InterfaceError,
    SurfaceError,
)
from ._faces import FaceContacts, FaceInterface, FacePoints, FaceReport, flat_facets
from ._interface import ContactInterface, CsrMap, Options, adaptive_tangent
from ._law import Coulomb, DecayingCoefficient, TabulatedCoefficient, TabulatedPressure
from ._native import __version__
from ._operator import TangentOperator
from ._part import Extents, PartDemands, SurfacePart
from ._results import (
    Contact,
    ContactFeet,
    Contacts,
    CutBack,
    FrictionReport,
    GapJump,
    MaterialNodes,
    Pairing,
    RefreshReport,
    SlaveFriction,
    SlaveGap,
)
from ._surface import MasterSurface, tributary_areas
from ._threads import isa, set_isa, set_threads, thread_count
from ._window import Window, boxes_around, split_history

__all__ = [
    "STATUS_CODES",
    "AssemblyError",
    "BusyError",
    "Contact",
    "ContactFeet",
    "ContactInterface",
    "Contacts",
    "Coulomb",
    "CsrMap",
    "CutBack",
    "DecayingCoefficient",
    "DiffuseContactError",
    "ElementError",
    "Extents",
    "FaceContacts",
    "FaceInterface",
    "FacePoints",
    "FaceReport",
    "FrictionReport",
    "GapBatch",
    "GapJump",
    "InputError",
    "InterfaceError",
    "MasterSurface",
    "MaterialNodes",
    "Options",
    "Pairing",
    "PartDemands",
    "RefreshReport",
    "SlaveFriction",
    "SlaveGap",
    "SurfaceError",
    "SurfacePart",
    "TabulatedCoefficient",
    "TabulatedPressure",
    "TangentOperator",
    "Window",
    "__version__",
    "adaptive_tangent",
    "boxes_around",
    "flat_facets",
    "gap",
    "isa",
    "set_isa",
    "set_threads",
    "split_history",
    "thread_count",
    "tributary_areas",
]
