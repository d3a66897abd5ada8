"""Messages between ranks that have something to say to one another, and how many bytes they take."""

from __future__ import annotations

from collections import Counter

import numpy as np
from mpi4py import MPI


class Exchange:
    """Messages of arrays. Every call is collective, but ranks send to those alone for which they have something."""

    def __init__(self, comm: MPI.Comm) -> None:
        self.comm = comm
        #: Bytes that this rank has sent to others and received from them, and messages sent, by what they were.
        self.sent, self.received, self.messages = Counter(), Counter(), Counter()
        self._tag = 0

    def gather(self, what: str, array: np.ndarray) -> list[np.ndarray]:
        """The arrays of all ranks, of any length: for a few numbers of each rank."""
        self.sent[what] += array.nbytes * (self.comm.size - 1)
        self.messages[what] += self.comm.size - 1
        arrays = self.comm.allgather(array)
        self.received[what] += sum(of.nbytes for rank, of in enumerate(arrays) if rank != self.comm.rank)
        return arrays

    def to(self, what: str, messages: dict[int, tuple[np.ndarray, ...]]) -> dict[int, tuple[np.ndarray, ...]]:
        """Sends a row of arrays to each of some ranks; returns what has come, by ascending rank.

        Nobody knows from whom something comes: who has been heard says so, and when all have, nothing is under way.
        """
        self._tag = (self._tag + 1) % 1000
        here, under_way = {}, []
        for rank, arrays in messages.items():
            if rank == self.comm.rank:
                here[rank] = arrays
                continue
            self.sent[what] += sum(array.nbytes for array in arrays)
            self.messages[what] += 1
            under_way.append(self.comm.issend(arrays, dest=rank, tag=self._tag))
        status, end = MPI.Status(), None
        while True:
            if self.comm.iprobe(source=MPI.ANY_SOURCE, tag=self._tag, status=status):
                source = status.Get_source()
                here[source] = self.comm.recv(source=source, tag=self._tag)
                self.received[what] += sum(array.nbytes for array in here[source])
            elif end is None:
                if all(request.Test() for request in under_way):
                    end = self.comm.Ibarrier()
            elif end.Test():
                return dict(sorted(here.items()))

    def largest(self, number: float) -> float:
        """The largest of the numbers of all ranks; NaN if one is."""
        found = np.array([number, float(np.isnan(number))])
        self.comm.Allreduce(MPI.IN_PLACE, found, op=MPI.MAX)
        return float("nan") if found[1] else float(found[0])
