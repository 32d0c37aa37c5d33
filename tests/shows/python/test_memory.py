"""Arrays outlive the objects that they came from, cannot be written to, are no copies; nothing leaks."""
import ctypes
import gc
import os
import weakref

import numpy as np
from common import SOURCE, raised

import sonopack
from sonopack import Packing, Scene

TEXT = SOURCE / "packings/reference/packing_N600_p1e-4.txt"
CHAIN = Scene(packing={"kind": "chain", "dimension": 1, "grains": 20})


class Mallinfo(ctypes.Structure):
    """mallinfo2 of glibc."""

    _fields_ = [(name, ctypes.c_size_t) for name in ("arena", "ordblks", "smblks", "hblks", "hblkhd", "usmblks", "fsmblks",
                                                     "uordblks", "fordblks", "keepcost")]


LIBC = ctypes.CDLL(None)
if hasattr(LIBC, "mallinfo2"):
    LIBC.mallinfo2.restype = Mallinfo


def in_use():
    """Bytes that malloc has given out, and bytes in memory, which include what the allocator keeps for later."""
    gc.collect()
    allocated = 0
    if hasattr(LIBC, "mallinfo2"):
        info = LIBC.mallinfo2()
        allocated = info.uordblks + info.hblkhd
    with open("/proc/self/statm") as file:
        return allocated, int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def flat(work, times, limit):
    """The memory after the first quarter of the repetitions is that after all of them."""
    for _ in range(times // 4):
        work()
    before = in_use()
    for _ in range(times - times // 4):
        work()
    grown = [now - then for now, then in zip(in_use(), before)]
    assert max(grown) < limit, f"{work.__name__}: {grown} bytes more after {times} repetitions"


def test_no_copies():
    packing = Packing.read(TEXT)
    assert np.shares_memory(packing.x, packing.x), "one place"
    assert np.shares_memory(packing.contacts["fn"], packing.contacts), "fields of one array"
    network = packing.network()
    signal = network.signal(points=50)
    assert np.shares_memory(signal.F, signal.f), "F of f"
    table = sonopack.Table.from_columns({"t": [1.0, 2.0], "F": [3.0, 4.0]})
    assert np.shares_memory(table["t"], table["t"]), "columns"
    harmonic = network.harmonic([0.1], damping=0.1)
    assert np.shares_memory(harmonic.F, harmonic.f), "complex numbers of pairs"
    assert packing.x.nbytes == 600 * 24 and not packing.x.flags.owndata, packing.x.flags


def test_read_only():
    packing = Packing.read(TEXT)
    for array in (packing.x, packing.r, packing.contacts["fn"], packing.network().springs["kn"]):
        raised(ValueError, array.__setitem__, 0, 1.0)
    raised(ValueError, setattr, packing.x.flags, "writeable", True)


def arrays():
    """Arrays whose owners are gone."""
    packing = Packing.read(TEXT)
    network = packing.network()
    modes, signal = network.modes(lowest=4), network.signal(points=50)
    table = sonopack.Table.from_columns({"t": np.arange(1000.0)})
    store = sonopack.study(Scene(packing={"grains": 40, "width": 8}, study={"want": ["spectrum"]}), "store")
    return [packing.x, packing.contacts["fn"], network.springs, network.mass, modes.omega, modes.vectors, signal.F,
            table["t"], network.csc()[0], network.dos(bins=7).density, store.samples()[0].frequencies(),
            sonopack.Column(taps=1).table()["y1"]]


def test_views_outlive():
    kept = arrays()
    copies = [array.copy() for array in kept]
    for _ in range(3):  # whatever is free is written over
        gc.collect()
        churn = [np.full(size, 255, np.uint8) for size in (80, 800, 8000, 80000, 800000) for _ in range(50)]
        packings = [Packing.read(TEXT) for _ in range(5)]
    del churn, packings
    for array, copy in zip(kept, copies):
        assert (array == copy).all(), array


def test_freed():
    """An owner goes as soon as its last array does."""
    packing = Packing.make(CHAIN)
    struct = weakref.ref(packing._c)
    x = packing.x[3:5]
    del packing
    assert struct() is not None, "the array keeps it"
    del x
    gc.collect()
    assert struct() is None, "nothing keeps it"


def test_packings_do_not_leak():
    def one():
        packing = Packing.make(CHAIN)
        packing.x.sum()
        packing.contacts["fn"].sum()

    flat(one, 10_000, 500_000)  # each holds 4 kB


def test_results_do_not_leak():
    packing = Packing.make(CHAIN)

    def one():
        network = packing.network()
        network.modes().vectors.sum()
        network.signal(points=11).F.sum()
        network.csc()
        network.dos(bins=5)
        network.harmonic([0.1], damping=0.1)
        sonopack.Table.from_columns({"t": np.arange(100.0)}).text()

    flat(one, 800, 500_000)


def test_errors_do_not_leak():
    network = Packing.make(CHAIN).network()

    def one():
        raised(sonopack.InvalidInput, Scene, packing={"pressure": -1})
        raised(sonopack.SonopackError, network.signal, points=1)
        raised(sonopack.SonopackError, Packing.read, "none.h5")
        raised(sonopack.Interrupted, sonopack.Column(taps=40, output="energy").table, progress=lambda share: False)

    flat(one, 2000, 500_000)


def test_files_are_closed():
    before = len(os.listdir("/proc/self/fd"))
    Packing.make(CHAIN).save("P.h5")
    for _ in range(20):
        Packing.read("P.h5")
        sonopack.study(Scene(packing={"grains": 40, "width": 8}), "store").samples()
    gc.collect()
    assert len(os.listdir("/proc/self/fd")) <= before + 1, (before, os.listdir("/proc/self/fd"))
