"""Studies: the samples of a scene, kept in a store, and tables of them."""
from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from . import _core
from ._core import Floats, Path, c_path, call, documented, text_of
from ._native import ffi, lib
from ._packing import Packing
from ._records import Front, Moduli, ProbeModuli, Statics, StudyProgress
from ._scene import Scene
from ._table import Table
from ._watch import Watch


class Sample:
    """One sample of a store, with its results. What was not made is None."""

    def __init__(self, store: Store, samples: Any, struct: Any) -> None:
        self._store = store
        self._samples = samples  # the memory
        self._c = struct
        self.name: str = text_of(struct.name)
        self.kind: str = _core.words("sp_pack_kind")[int(struct.kind)]
        self.dim, self.grains, self.seed = int(struct.dim), int(struct.grains), int(struct.seed)
        self.width, self.pressure, self.friction = float(struct.width), float(struct.pressure), float(struct.friction)
        self.height = float(struct.height)
        #: what the scene sets: packing.fraction (0: the pressure), and how far the path of strain is (stage 0: no path)
        self.fraction, self.stage, self.strain = float(struct.fraction), int(struct.stage), float(struct.strain)
        self.failed = bool(struct.failed)
        self.reason: str = text_of(struct.reason)

    def _part(self, name: str, cls: type[Any], bit: int) -> Any:
        return _core.record(cls, getattr(self._c, name)) if self._c.have & bit else None

    @property
    def front(self) -> Front | None:
        """The first front at the top wall."""
        return self._part("front", Front, lib.SP_WANT_CTOF)  # type: ignore[no-any-return]

    @property
    def statics(self) -> Statics | None:
        """Densities, contacts, forces and stress."""
        return self._part("statics", Statics, lib.SP_WANT_STATICS)  # type: ignore[no-any-return]

    @property
    def moduli(self) -> Moduli | None:
        """Elastic moduli and speeds of long waves."""
        return self._part("moduli", Moduli, lib.SP_WANT_MODULI)  # type: ignore[no-any-return]

    @property
    def probes(self) -> list[ProbeModuli] | None:
        """Apparent moduli: sine 1, sine 2, lines 1, lines 3."""
        if not self._c.have & lib.SP_WANT_PROBES:
            return None
        return [_core.record(ProbeModuli, self._c.probe[k]) for k in range(lib.SP_PROBES)]

    @property
    def planes(self) -> list[tuple[float, Front]]:
        """Heights of planes, and the fronts there."""
        return [(float(self._c.plane[k]), _core.record(Front, self._c.plane_front[k])) for k in range(self._c.planes)]

    def packing(self) -> Packing:
        """Reads the packing of this sample."""
        out = _core.new("sp_packing", lib.sp_packing_free, lib.sp_packing_none)
        with self._store._lock:
            call(lib.sp_store_read, self._store._c, self.name.encode(), out, ffi.NULL, ffi.NULL)
        return Packing(out)

    def _arrays(self) -> Any:
        out = _core.new("sp_sample_arrays", lib.sp_sample_arrays_free, lib.sp_sample_arrays_none)
        with self._store._lock:
            call(lib.sp_store_read, self._store._c, self.name.encode(), ffi.NULL, ffi.NULL, out)
        return out

    def signal(self) -> tuple[Floats, Floats] | None:
        """Reads times and force of the stored signal; None if there is none (study.want with "signal")."""
        arrays = self._arrays()
        n = int(arrays.signal.n)
        if n == 0:
            return None
        return _core.view(arrays, arrays.signal.t, (n,)), _core.view(arrays, arrays.signal.f, (n,))

    def frequencies(self) -> Floats | None:
        """Reads all frequencies of the network; None if they are not stored (study.want with "spectrum")."""
        arrays = self._arrays()
        return _core.view(arrays, arrays.omega, (int(arrays.modes),)) if arrays.modes else None

    def __repr__(self) -> str:
        state = f"failed: {self.reason}" if self.failed else f"height {self.height:.6g} d"
        return f"<Sample {self.name}: {self.grains} grains, pressure {self.pressure:g} E*, seed {self.seed}, {state}>"


class Store:
    """A folder of samples. Iterating gives a Sample each; several processes may use a store at once."""

    def __init__(self, folder: Path, *, create: bool = False) -> None:
        out = ffi.new("sp_store **")
        call(lib.sp_store_open, c_path(folder), create, out)
        self._c = ffi.gc(out[0], lib.sp_store_close)
        self.folder = folder
        self._lock = threading.Lock()  # the library leaves this to its callers
        #: reasons why files of the store could not be read, after samples()
        self.bad: list[str] = []

    def samples(self, scene: Scene | None = None) -> list[Sample]:
        """All samples, or those of a scene."""
        count, array, bad = ffi.new("int64_t *"), ffi.new("sp_sample **"), ffi.new("int64_t *")
        err = ffi.new("sp_error *")
        with self._lock:
            status = lib.sp_store_samples(self._c, count, array, bad, err)
        if status != lib.SP_OK:
            _core.check(status, err)
        self.bad = [text_of(err.text)] * min(int(bad[0]), 1)
        memory = ffi.gc(array[0], lib.sp_free)
        samples = [Sample(self, memory, array[0] + k) for k in range(count[0])]
        return samples if scene is None else _of_scene(scene, samples)

    def __iter__(self) -> Iterator[Sample]:
        return iter(self.samples())

    def __len__(self) -> int:
        return len(self.samples())

    @documented("sp_study_table")
    def table(self, name: str, scene: Scene | None = None, *, samples: Iterable[Sample] | None = None,
              level: float = 0.95) -> Table:
        """A table of the samples: ctof, scaling, planes, statics, moduli, probes or ensemble.

        scene: only its samples. samples: those of the caller's choice. Samples that differ in more than pressure and
        size are not averaged (Refused): choose among them.
        """
        chosen = list(samples) if samples is not None else self.samples(scene)
        chosen.sort(key=lambda sample: sample.name)
        array = ffi.new("sp_sample[]", max(len(chosen), 1))
        for k, sample in enumerate(chosen):
            array[k] = sample._c[0]
        options = ffi.new("sp_table_options *", {"level": level})
        table = _core.new("sp_table", lib.sp_table_free, lib.sp_table_none)
        call(lib.sp_study_table, name.encode(), len(chosen), array, options, table)
        return Table(table)

    def __repr__(self) -> str:
        return f"Store({str(self.folder)!r})"


def _of_scene(scene: Scene, samples: list[Sample]) -> list[Sample]:
    """The samples that the scene makes; of their results those that were made as it says, as the command has it."""
    by_name = {sample.name: sample for sample in samples}
    found, name = [], ffi.new("char[]", lib.SP_NAME_MAX)
    for k in range(scene.samples):
        one = ffi.new("sp_scene *")
        call(lib.sp_study_scene, scene._c, k, one)
        lib.sp_sample_name(one, name)
        sample = by_name.pop(text_of(name), None)
        if sample is not None:
            _hide_other_parts(one, sample._c)
            found.append(sample)
    return found


def _hide_other_parts(scene: Any, sample: Any) -> None:
    parts = int(lib.sp_sample_parts(scene, sample))
    missing = int(lib.sp_want_parts(scene.want)) & ~parts
    if not sample.failed and missing:
        if not sample.lacks & missing or not text_of(sample.reason):
            sample.reason = b"it lacks a part that is wanted: not made yet"
        sample.lacks = missing
    for wanted, part in ((scene.planes > 0, lib.SP_WANT_PLANES),
                         (scene.want & lib.SP_WANT_SIGNAL, lib.SP_WANT_SIGNAL)):
        if wanted:
            sample.have &= parts | ~int(part) & 0xffffffff


@documented("sp_study_run")
def study(scene: Scene, store: Path | Store, *, jobs: int = 1, threads: int = 1, retry: bool = False,
          shard: tuple[int, int] = (1, 1), progress: Callable[[StudyProgress], object] | None = None) -> Store:
    """Computes the samples of a scene that are not in the store yet, `jobs` at a time, and returns the store.

    progress is called with a StudyProgress some four times a second; it may return False to stop (Interrupted). Ctrl-C
    raises KeyboardInterrupt. Finished samples are kept either way, and the next call continues.
    """
    call(lib.sp_scene_check_sweeps, scene._c)
    # a handle of its own, so that the progress function and other threads may read the store meanwhile
    into = Store(store.folder if isinstance(store, Store) else store, create=True)
    lib.sp_store_retry(into._c, retry)
    struct = ffi.new("sp_scene *", scene._c[0])
    options = ffi.new("sp_study_options *", {"jobs": jobs, "shard": shard[0], "shards": shard[1], "threads": threads})
    start = None
    if name := text_of(getattr(struct, "from")):
        start = Packing.read(name)
        call(lib.sp_pack_spec_from, ffi.addressof(struct, "pack"), start._c)
        if not struct.material.young > 0:
            struct.material = start._c.material
        setattr(options, "from", start._c)
    sink = ffi.new("sp_study_sink *", lib.sp_store_sink(into._c))
    watch = Watch(progress)
    watch.run(lib.sp_study_run, struct, options, sink, lib.sonopack_study_watch, watch.handle,
              ffi.new("sp_study_progress *"))
    return store if isinstance(store, Store) else into
