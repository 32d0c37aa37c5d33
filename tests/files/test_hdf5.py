"""HDF5 packings seen from outside: the layout as h5py reads it, and forged, damaged and foreign files, each of which must
give its reason (exit status 1) and never a crash or a wrong packing."""
import os
import random
import resource
import shutil
import subprocess
import sys
import tempfile

import h5py
import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "cli"))
from cells import box_of_disks, lattice, write_packing  # noqa: E402
from command import sanitized, warmly  # noqa: E402
from common import expect, faults, names_all, packed_zeros  # noqa: E402

COMMAND, SOURCE = sys.argv[1], sys.argv[2]
REFERENCE = os.path.join(SOURCE, "packings", "reference", "packing_N200_p1e-4.txt")
SEED = 20240611
FOLDER = tempfile.mkdtemp(prefix="sonopack-hdf5-")


if not sanitized():  # such a build maps terabytes
    resource.setrlimit(resource.RLIMIT_AS, (4 << 30, 4 << 30))  # a file must not make the reader ask for the moon


def run(*words):
    return subprocess.run([COMMAND, *words], capture_output=True, text=True, timeout=1200)


def path(name):
    return os.path.join(FOLDER, name)


def to_text(source):
    """Reads a packing by converting it: its exit status, what it says, and the text (None if it failed)."""
    out = path("out.txt")
    if os.path.exists(out):
        os.remove(out)
    result = warmly("convert", source, out)
    text = open(out).read() if os.path.exists(out) else None
    expect((result.returncode == 0) == (text is not None), f"{source}: status {result.returncode} and a file, or not")
    return result.returncode, result.stderr, text


def refused(source):
    """Exit status and reason of a command that only reads the packing."""
    result = run("statics", source)
    return result.returncode, result.stderr


GOOD = path("good.h5")
made = run("convert", REFERENCE, GOOD)
expect(made.returncode == 0, "convert to HDF5: " + made.stderr)
GOOD_TEXT = to_text(GOOD)[2]


# ---- the layout ------------------------------------------------------------------------------------------------------
def test_layout():
    lines = open(REFERENCE).read().split("\n")
    grains = np.array([line.split() for line in lines[2:202]], dtype=float)
    contacts = np.array([line.split() for line in lines[202:] if line], dtype=float)
    with h5py.File(GOOD, "r") as f:
        names = []
        f.visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None)
        for name in names:
            for attribute in ("unit", "description"):
                expect(len(f[name].attrs.get(attribute, b"")) > 0, f"{name} has the attribute {attribute}")
        expect(list(f["h5md"].attrs["version"]) == [1, 1], "version of H5MD")
        expect(f["h5md/author"].attrs["name"] and f["h5md/creator"].attrs["name"] == b"sonopack", "author, creator")
        box = f["particles/grains/box"]
        expect(box.attrs["dimension"] == 2 and list(box.attrs["boundary"]) == [b"periodic", b"none"], "box")
        expect(list(box["edges"]) == [24, 8.6958069203285007], "edges")
        x = f["particles/grains/position/value"]
        expect(x.shape == (1, 200, 2) and (x[0] == grains[:, :2]).all(), "positions, bit for bit")
        expect(f["particles/grains/position/step"].shape == (1,), "step")
        r = f["particles/grains/radius"][:]
        expect((r == grains[:, 2]).all(), "radii")
        expect(np.allclose(f["particles/grains/mass"], 4 / 3 * np.pi * r**3, rtol=1e-15), "masses")
        expect((f["sonopack/rattler"][:] == grains[:, 3]).all(), "rattlers")
        pairs, walls = f["connectivity/contacts"], f["sonopack/walls/contacts"]
        expect(f[pairs.attrs["particles_group"]].name == "/particles/grains", "reference to the particles")
        order = np.lexsort((contacts[:, 1], contacts[:, 0], -np.minimum(contacts[:, 1], 0)))
        contacts = contacts[order]
        expect(pairs[:].min() >= 0 and walls[:, 0].min() >= 0 and walls[:, 1].max() < 0, "walls are no particles")
        expect((np.concatenate([pairs, walls]) == contacts[:, :2]).all(), "pairs, then contacts with walls")
        expect((f["sonopack/contacts/normal"][:] == contacts[:, 2:4]).all(), "normals")
        expect((f["sonopack/contacts/overlap"][:] == contacts[:, 4]).all(), "overlaps")
        expect((f["sonopack/contacts/normal_force"][:] == contacts[:, 5]).all(), "normal forces")
        tangent = np.column_stack((-contacts[:, 3], contacts[:, 2])) * contacts[:, 6:7]
        ft = f["sonopack/contacts/tangential_force"][:]
        expect(np.allclose(ft, tangent, rtol=3e-16, atol=0), "tangential forces to an ulp")
        expect("sonopack/seconds" not in f, "no time of the making: equal packings are equal files")
        expect(f["sonopack/seed"][()] == 1 and f["sonopack"].attrs["format"] == 1, "seed, format")


# ---- forgeries -------------------------------------------------------------------------------------------------------
ARRAYS = ["particles/grains/position/value", "particles/grains/radius", "particles/grains/box/edges",
          "sonopack/contacts/normal", "sonopack/contacts/overlap", "sonopack/contacts/normal_force",
          "sonopack/contacts/tangential_force"]
NUMBERS = ["sonopack/pressure", "sonopack/friction", "sonopack/poisson", "sonopack/residual"]
INTEGERS = ["sonopack/dimension", "sonopack/seed", "sonopack/steps", "connectivity/contacts",
            "sonopack/walls/contacts"]


def replace(f, name, data, **options):
    del f[name]
    f.create_dataset(name, data=data, **options)


def forgery(forge, *parts, of=GOOD):
    """Applies forge to a copy: it must fail with all parts in the reason, the file's name among them."""
    copy = path("forged.h5")
    shutil.copy(of, copy)
    with h5py.File(copy, "r+") as f:
        forge(f)
    status, reason = refused(copy)
    expect(status == 1, f"{parts}: exit status {status}")
    for part in ("forged.h5",) + parts:
        expect(names_all(reason, part), f"'{part}' in: {reason}")
    expect(reason.count("\n") == 1, f"one line: {reason}")


def variation(change, what):
    """Applies a harmless change: the packing must read the same."""
    copy = path("changed.h5")
    shutil.copy(GOOD, copy)
    with h5py.File(copy, "r+") as f:
        change(f)
    status, reason, text = to_text(copy)
    expect(status == 0 and text == GOOD_TEXT, f"{what}: {reason}")


def set_element(name, index, value):
    def forge(f):
        data = np.array(f[name][()])
        data[index] = value
        replace(f, name, data)
    return forge


def test_missing():
    for name in ARRAYS + NUMBERS + INTEGERS[:-1] + ["sonopack/wall"]:
        forgery(lambda f: f.pop(name), "/" + name)
    forgery(lambda f: f.pop("sonopack/walls/contacts"), "/sonopack/contacts/normal")
    for group in ("sonopack", "connectivity", "particles", "particles/grains/box", "sonopack/contacts"):
        forgery(lambda f: f.pop(group), group.split("/")[0])
    forgery(lambda f: f["sonopack"].attrs.pop("format"), "format")
    forgery(lambda f: f["particles/grains/box"].attrs.pop("boundary"), "boundary")


def test_types_and_shapes():
    wrong = [lambda shape: np.zeros(shape, "i8"), lambda shape: "text", lambda shape: np.zeros(shape, "c16")]
    for k, name in enumerate(ARRAYS + NUMBERS):  # each of one wrong type, the first array and number of all three
        for data in wrong if name in (ARRAYS[0], NUMBERS[0]) else wrong[k % 3:][:1]:
            forgery(lambda f: replace(f, name, data(f[name].shape)), "/" + name)
    for name in INTEGERS:
        forgery(lambda f: replace(f, name, np.zeros(f[name].shape)), "/" + name)
    for name in ARRAYS + ["connectivity/contacts", "sonopack/walls/contacts"]:
        forgery(lambda f: replace(f, name, f[name][()][..., np.newaxis]), "/" + name)
        forgery(lambda f: replace(f, name, f[name][()].ravel()[0]), "/" + name)
        if name != "particles/grains/radius" and not name.endswith("/contacts"):
            forgery(lambda f: replace(f, name, np.concatenate([f[name]] * 2, axis=-1)), "/" + name)
    forgery(lambda f: replace(f, "connectivity/contacts", np.zeros((295, 3), "i4")), "/connectivity/contacts", "2")
    forgery(lambda f: replace(f, "particles/grains/radius", np.full(199, 0.5)), "/particles/grains/", "199")
    forgery(lambda f: replace(f, "particles/grains/radius", h5py.Empty("f8")), "/particles/grains/radius")
    forgery(lambda f: replace(f, "sonopack/pressure", [1e-4]), "/sonopack/pressure")
    forgery(lambda f: replace(f, "sonopack/wall", 1), "/sonopack/wall")
    forgery(lambda f: replace(f, "sonopack/wall", "rubber"), "/sonopack/wall", "rigid grain")

    def group_for_dataset(f):
        del f["sonopack/pressure"]
        f.create_group("sonopack/pressure")
    forgery(group_for_dataset, "/sonopack/pressure")
    for value in ("1", 1.0, [1, 1]):
        forgery(lambda f: f["sonopack"].attrs.__setitem__("format", value), "format")
    forgery(lambda f: f["sonopack"].attrs.__setitem__("format", 4), "format 4")
    forgery(lambda f: f["sonopack"].attrs.__setitem__("format", 3), "/sonopack/cell")
    boundary = [b"periodic", b"periodic"]
    forgery(lambda f: f["particles/grains/box"].attrs.__setitem__("boundary", boundary), "boundary", "periodic none")


def test_values():
    for k, name in enumerate(ARRAYS[:-1] + NUMBERS[:3]):
        for value in (np.nan, (np.inf, -np.inf)[k % 2]):
            forgery(set_element(name, () if name in NUMBERS else (0,) * (3 if "position" in name else 1), value))
    forgery(set_element("sonopack/contacts/tangential_force", (5, 0), np.nan), "5")
    forgery(set_element("particles/grains/radius", 3, 0.0), "3")
    forgery(set_element("particles/grains/radius", 3, -0.5), "3")
    forgery(set_element("particles/grains/position/value", (0, 7, 0), 24.5), "7")
    for end in (0, 1):
        for value in (200, (2**31 - 1, -3)[end]):
            forgery(set_element("connectivity/contacts", (9, end), value), "9")
            forgery(set_element("sonopack/walls/contacts", (0, end), value))
    huge = lambda f: replace(f, "connectivity/contacts", f["connectivity/contacts"][()].astype("i8") + 2**40)
    forgery(huge, "0")
    forgery(set_element("sonopack/contacts/normal", (9, 0), 0.9), "9")
    forgery(set_element("sonopack/contacts/overlap", 9, -0.1), "9")
    forgery(set_element("sonopack/contacts/normal_force", 9, -1e-9), "9")
    forgery(lambda f: replace(f, "connectivity/contacts", f["connectivity/contacts"][()][::-1]), "contact")
    for value in (0, 4, -1):
        forgery(lambda f: replace(f, "sonopack/dimension", value), "dimension")
    for name, value in (("pressure", -1e-4), ("pressure", 0.0), ("friction", -0.1), ("poisson", 0.6)):
        forgery(lambda f: replace(f, "sonopack/" + name, value))


def test_data_from_elsewhere():
    name = "particles/grains/radius"
    other = path("other.h5")
    with h5py.File(other, "w") as f:
        f["radius"] = np.full(200, 0.5)
    with open(path("raw"), "wb") as raw:
        raw.write(bytes(1600))

    def external_link(f):
        del f[name]
        f[name] = h5py.ExternalLink(other, "/radius")

    def soft_link(f):
        f["elsewhere"] = f[name][()]
        del f[name]
        f[name] = h5py.SoftLink("/elsewhere")

    def external_data(f):
        del f[name]
        f.create_dataset(name, (200,), "f8", external=[(path("raw"), 0, 1600)])

    def virtual_data(f):
        del f[name]
        layout = h5py.VirtualLayout((200,), "f8")
        layout[:] = h5py.VirtualSource(other, "radius", (200,))
        f.create_virtual_dataset(name, layout)

    for forge in (external_link, soft_link, external_data, virtual_data):
        forgery(forge, "/" + name)


def test_sizes_nobody_has():
    def claim(name, shape, **options):
        def forge(f):
            kind = f[name].dtype
            del f[name]
            f.create_dataset(name, shape, kind, **options)
        return forge
    most = 2**31 - 2
    forgery(claim("particles/grains/radius", (most,), chunks=(1024,)), "/particles/grains/radius")
    forgery(claim("particles/grains/radius", (most // 4,), chunks=(1024,)), "/particles/grains/radius")
    forgery(claim("particles/grains/radius", (most // 4,)), "/particles/grains/radius")
    forgery(claim("particles/grains/radius", (2**60,), chunks=(1024,)), "/particles/grains/radius")
    forgery(claim("connectivity/contacts", (most // 4, 2), chunks=(1024, 2)), "/connectivity/contacts")

    def one_chunk_of_many(f):
        claim("particles/grains/radius", (most // 4,), chunks=(1024,))(f)
        f["particles/grains/radius"][:1024] = 0.5
    forgery(one_chunk_of_many, "/particles/grains/radius")
    forgery(lambda f: replace(f, "particles/grains/radius", np.zeros(0)))


def test_layouts_that_cost_too_much():
    """Files of a few MB that would take gigabytes or many seconds, were the layout not judged before the data."""
    radius, pairs, kind = "particles/grains/radius", "connectivity/contacts", np.arange(2, dtype="i4")

    def anew(name, shape, chunks, fill, dtype="f8", **options):
        def forge(f):
            del f[name]
            fill(f.create_dataset(name, shape, dtype, chunks=chunks, **options))
        return forge

    def first(data):
        return lambda dataset: dataset.__setitem__(slice(0, len(data)), data)

    def packed(size):
        return lambda dataset: dataset.id.write_direct_chunk((0,), packed_zeros(size))
    entries = 2**29 - 2**17  # the largest number of grains that is allowed, but for what makes it whole megabytes
    forgery(anew(radius, (entries,), (entries,), packed(8 * entries), compression="gzip"), radius, "chunks")
    forgery(anew(radius, (200,), (2**24,), first(np.full(200, 0.5)), maxshape=(None,), compression="gzip"), radius, "chunks")
    # in chunks of 64 MB: other arrays have fewer entries
    chunk = packed_zeros(2**26)
    forgery(anew(radius, (2**28,), (2**23,), lambda d: [d.id.write_direct_chunk((k * 2**23,), chunk)
                                                       for k in range(32)], compression="gzip"), "position", str(2**28))
    # all in one chunk of 72 MB, as other programs write each frame: judged like any other
    frame = np.repeat(np.random.default_rng(1).random(3 * 2**18), 12)
    forgery(anew(radius, frame.shape, frame.shape, first(frame), compression="gzip", compression_opts=1), "position",
            str(len(frame)))
    forgery(anew(pairs, (60000, 2), (1, 2), first(np.tile(kind, (60000, 1))), "i4"), pairs, "chunks")
    forgery(anew(pairs, (2**27, 2), (2**20, 2), first(kind[np.newaxis]), "i4"), pairs, "hold")
    # more contacts than pairs of grains
    forgery(anew(pairs, (2**21, 2), None, first(np.tile(kind, (2**21, 1))), "i4"), "contacts", "200")


def test_filters():
    """Only those that are needed: for any other HDF5 would look for a plugin on the machine and run it."""
    radius = "particles/grains/radius"
    for filters in ([(32000, ())], [(h5py.h5z.FILTER_SCALEOFFSET, (0, 3))], [(h5py.h5z.FILTER_DEFLATE, (9,))] * 2):
        def forge(f):
            data = f[radius][()]
            del f[radius]
            plist = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
            plist.set_chunk((200,))
            for code, values in filters:
                plist.set_filter(code, h5py.h5z.FLAG_OPTIONAL, values)
            space = h5py.h5s.create_simple((200,))
            h5py.h5d.create(f.id, radius.encode(), h5py.h5t.IEEE_F64LE, space, plist)
            f[radius].id.write_direct_chunk((0,), data.tobytes(), 2**len(filters) - 1)
        forgery(forge, radius, "filter")


def test_harmless_changes():
    name = "sonopack/contacts/normal"
    variation(lambda f: replace(f, name, f[name][()], compression="gzip", shuffle=True), "compressed")
    variation(lambda f: replace(f, name, f[name][()].astype(">f8")), "big endian")
    variation(lambda f: replace(f, "connectivity/contacts", f["connectivity/contacts"][()].astype("i8")), "64-bit indices")
    variation(lambda f: replace(f, "sonopack/wall", "rigid"), "text of variable length")
    variation(lambda f: replace(f, "sonopack/wall", np.bytes_("rigid")), "text of fixed length")
    variation(lambda f: f.create_dataset("notes", data="mine"), "a dataset of somebody else")
    variation(lambda f: f.pop("sonopack/rattler"), "rattlers are derived")


# ---- periodic cells, tilted ones and boxes ---------------------------------------------------------------------------
TILTED = lattice(2, tilt=0.3)
SHEARED = lattice(3, tilt=0.2)
BOX = box_of_disks()


def again(name):
    """The packing as our program has written it."""
    return path(name + "-again.h5")


def made(name, packing):
    write_packing(path(name), packing)
    return path(name)


def test_files_of_h5py_are_read_and_written_again():
    for name, packing in (("tilted", TILTED), ("sheared", SHEARED), ("box", BOX), ("straight", lattice(2))):
        first, second = made(name + ".h5", packing), again(name)
        result = warmly("convert", first, second)
        expect(result.returncode == 0, f"{name}: {result.stderr}")
        with h5py.File(first) as a, h5py.File(second) as b:
            expect(b["sonopack"].attrs["format"] == 3, f"{name}: format")
            expect(b["sonopack/cell"][()] == a["sonopack/cell"][()], f"{name}: cell")
            words = [b"none" if name == "box" else b"periodic"] * packing["dim"]
            expect(list(b["particles/grains/box"].attrs["boundary"]) == words, f"{name}: boundary")
            for part in ("particles/grains/box/edges", "particles/grains/position/value", "sonopack/gravity",
                         "sonopack/contacts/normal", "connectivity/contacts"):
                expect(np.array_equal(a[part][()], b[part][()]), f"{name}: {part}, bit for bit")
        expect(run("check", second).returncode == 0, f"{name}: the audit")


def test_edges_are_a_matrix_only_where_they_must():
    shapes = {"tilted": (2, 2), "sheared": (3, 3), "box": (2,), "straight": (2,)}
    for name, shape in shapes.items():
        with h5py.File(again(name)) as f:
            expect(f["particles/grains/box/edges"].shape == shape, f"{name}: edges of H5MD")


def edges(change):
    def forge(f):
        matrix = f["particles/grains/box/edges"][()]
        change(matrix)
        replace(f, "particles/grains/box/edges", matrix)
    return forge


def test_forged_cells():
    for source in ("tilted", "box"):
        forgery(lambda f: f.pop("sonopack/cell"), "/sonopack/cell", of=again(source))
        forgery(lambda f: f.pop("sonopack/gravity"), "/sonopack/gravity", of=again(source))
        forgery(lambda f: replace(f, "sonopack/cell", "sphere"), "/sonopack/cell", "sphere", of=again(source))
        forgery(lambda f: replace(f, "sonopack/cell", 1), "/sonopack/cell", of=again(source))
        forgery(lambda f: replace(f, "sonopack/gravity", np.nan), "gravity", of=again(source))
        forgery(lambda f: replace(f, "sonopack/gravity", 1), "/sonopack/gravity", of=again(source))
        forgery(lambda f: replace(f, "sonopack/cell", "piston"), "boundary", of=again(source))
        forgery(lambda f: f["sonopack"].attrs.__setitem__("format", 1), "boundary", of=again(source))
    for source in ("tilted", "sheared", "box", "straight"):
        forgery(lambda f: replace(f, "particles/grains/box/edges", np.ones(4)), "/particles/grains/box/edges", of=again(source))
    forgery(lambda f: replace(f, "particles/grains/box/edges", 5.0), "/particles/grains/box/edges", of=again("sheared"))
    forgery(lambda f: replace(f, "sonopack/cell", "periodic"), "boundary", of=again("box"))
    forgery(lambda f: replace(f, "particles/grains/box/edges", np.eye(2)), "/particles/grains/box/edges", of=again("box"))

    def upper(m):
        m[0, 1] = 1e-3
    forgery(edges(upper), "/particles/grains/box/edges", of=again("tilted"))
    forgery(edges(upper), "/particles/grains/box/edges", of=again("sheared"))

    def far(m):
        m[1, 0] = 0.6 * m[0, 0]
    forgery(edges(far), "tilt", of=again("tilted"))
    forgery(edges(far), "tilt", of=again("sheared"))

    def undefined(m):
        m[1, 0] = np.nan
    forgery(edges(undefined), of=again("tilted"))

    def outside(f):
        x = f["particles/grains/position/value"][()]
        x[0, 3, 0] += 50
        replace(f, "particles/grains/position/value", x)
    forgery(outside, "3", of=again("tilted"))

    def wall(number):
        def forge(f):
            walls = f["sonopack/walls/contacts"][()]
            walls[-1, 1] = number
            replace(f, "sonopack/walls/contacts", walls)
        return forge
    for number in (-5, -7):  # of three dimensions; of none
        forgery(wall(number), str(number), of=again("box"))

    def wall_in_periodic(f):
        pairs = f["connectivity/contacts"][()]
        pairs[-1, 1] = -1
        replace(f, "connectivity/contacts", pairs)
    forgery(wall_in_periodic, of=again("straight"))


# ---- damage ----------------------------------------------------------------------------------------------------------
def test_truncation():
    data = open(GOOD, "rb").read()
    lengths = sorted(set(list(range(0, 100, 25)) + [len(data) * k // 7 for k in range(7)] + [len(data) - 1]))
    for length in lengths:
        with open(path("short.h5"), "wb") as f:
            f.write(data[:length])
        status, reason = refused(path("short.h5"))
        expect(status == 1 and "short.h5" in reason, f"first {length} of {len(data)} bytes: {status} {reason}")


def test_foreign_files():
    with h5py.File(path("foreign.h5"), "w") as f:
        f["data/temperature"] = np.arange(10.0)
    status, reason = refused(path("foreign.h5"))
    expect(status == 1 and "/sonopack" in reason and "foreign.h5" in reason, reason)
    with open(path("picture.h5"), "wb") as f:
        f.write(b"\x89PNG\r\n\x1a\n" + bytes(100))
    for name, part in (("picture.h5", "picture.h5"), ("nowhere.h5", "No such file"), ("", "Is a directory")):
        status, reason = refused(path(name))
        expect(status == 1 and names_all(reason, part), f"{name}: {status} {reason}")
    with open(path("words.h5"), "w") as f:
        f.write("nothing of the kind\n")
    status, reason = refused(path("words.h5"))
    expect(status == 1 and names_all(reason, "words.h5"), reason)


def test_flipped_bytes(count=20):
    """All that the packing needs lies under checksums: a flipped bit gives a reason, or hits what nobody reads."""
    data = bytearray(open(GOOD, "rb").read())
    draw = random.Random(SEED)
    print("seed of the flips:", SEED)
    noticed = 0
    for _ in range(count):
        copy = bytearray(data)
        at = draw.randrange(len(copy))
        for _ in range(draw.choice((1, 1, 1, 4, 64))):
            copy[at] ^= 1 << draw.randrange(8)
            at = min(len(copy) - 1, at + draw.randrange(1, 9))
        with open(path("flipped.h5"), "wb") as f:
            f.write(copy)
        status, reason = refused(path("flipped.h5"))
        text = to_text(path("flipped.h5"))[2] if status == 0 else None
        noticed += status == 1
        expect(status in (0, 1), f"flip at {at}: status {status} {reason[-300:]}")
        expect("HDF5: infinite loop" not in reason, f"flip at {at}: HDF5 prints on its own: {reason[:300]}")
        expect(status == 1 or text == GOOD_TEXT, f"flip at {at}: another packing was read")
    print(f"{count} damaged files, {noticed} noticed")
    expect(noticed > count // 2, "flips were noticed")


for name, test in list(globals().items()):
    if name.startswith("test_"):
        before = len(faults)
        test()
        print("ok" if len(faults) == before else "FAILED", name)
shutil.rmtree(FOLDER)
print(*faults, sep="\n")
sys.exit(1 if faults else 0)
