"""The page printed/layouts: datasets of our HDF5 files and columns of our tables, told by files that are made here."""
import pathlib
import re
import subprocess
import tempfile

SPHERES = {"dimension": 3, "width": 4.9, "depth": 5.1, "pressure": "1e-3"}
CELL = {"dimension": 3, "cell": "periodic", "grains": 200, "width": 5.5, "depth": 5.5, "path.strain": "[0, 0, 0, 0, 0, 0.01]"}
PACKINGS = {  # keys of the group packing
    "spheres": SPHERES | {"grains": 70, "gravity": "1e-7"},
    "box": {"cell": "box", "grains": 60, "width": 8},
    "mixed": CELL | {"types.fraction": "[0.5, 0.5]", "types.density": "[1, 2]", "types.friction": "[0.5, 0.3, 0.1]"},
}
STUDIES = {  # the same, and what else
    "all": (SPHERES | {"grains": 200, "protocol": "quick"}, {
        "signal.planes": "[3, 4, 5]", "signal.until": 40,
        "study.want": '["ctof", "statics", "moduli", "signal", "probes", "planes", "spectrum"]'}),
    "staged": (CELL | {"kind": "minimum", "friction": 0, "fraction": 0.7}, {"study.want": '["moduli"]'}),
    "lacking": ({"kind": "chain", "friction": 0, "grains": 20100}, {"study.want": '["spectrum"]'}),
}
TABLES = [f"{words} spheres.h5" for words in (
    "check", "statics", "moduli", "clusters", "modes", "modes --prestress", "spectrum dos", "signal", "front", "sensitivity")]
TABLES += [f"column --set column.output={output} --set column.taps=10 --set column.points=2 --set column.to=1" for output in (
    "trajectory", "strobe", "energy", "density", "compare", "lyapunov", "bifurcation")]


def settings(packing, others={}):
    keys = {f"packing.{key}": value for key, value in packing.items()} | others
    return [word for key, value in keys.items() for word in ("--set", f"{key}={value}")]


def make_files(command):
    """Packings with every dataset that one may have, modes, motions that may grow, and stores."""
    for name, keys in PACKINGS.items():
        command("pack", "-o", f"{name}.h5", "--material", "E=70e9,nu=0.22,rho=2500,d=1e-3", *settings(keys))
    for name, (keys, others) in STUDIES.items():
        command("study", "--store", name, "--set", "study.samples=1", *settings(keys, others))
    command("modes", "spheres.h5", "--lowest", "20", "--zero", "--vectors", "modes.h5")
    command("modes", "spheres.h5", "--prestress", "--lowest", "13", "--vectors", "motions.h5")


def make_linear(path):
    """Two grains with masses and stiffnesses of their own, the first frame of a series."""
    import sonopack
    from sonopack.formats.frames import Series
    contacts = {"i": [0, 1, 0], "j": [1, sonopack.TOP, sonopack.BOTTOM], "kn": [1] * 3, "kt": [1] * 3, "overlap": [1e-4] * 3}
    packing = sonopack.Packing.from_arrays([[1, 0.5], [1, 1.5]], [0.5, 0.5], contacts, box=(3, 2), pressure=1e-4, friction=0.5,
                                           mass=[1, 2], inertia=[1, 2])
    Series().add(packing, 0).save(str(path))


def letters(file):
    """What lengths of arrays are, from three on."""
    lengths = {"n": "modes/omega", "n - R": "modes/vector_error", "N - G": "modes/rattler", "G": "modes/grain",
               "G f": "modes/mass", "N": "particles/grains/radius", "P": "connectivity/contacts", "C": "sonopack/contacts/overlap",
               "W": "sonopack/walls/contacts", "T": "signal/t", "F": "results/spectrum/omega", "H": "results/planes/height"}
    found = {len(file[path]): letter for letter, path in lengths.items() if path in file and len(file[path]) > 2}
    return found if "modes" in file else {3: "D"} | found


def datasets(paths):
    """Name, type and shape, unit and content of each dataset of the files; of a name with several contents all of them."""
    import h5py
    rows = {}
    for path in paths:
        with h5py.File(path) as file:
            names = letters(file)

            def note(name, item):
                if isinstance(item, h5py.Dataset):
                    kind = "text" if item.dtype.kind == "S" else item.dtype.name
                    shape = "".join(f"[{names.get(size, size)}]" for size in item.shape)
                    told = rows.setdefault(f"/{name}", ({}, {}, {}))
                    told[0].setdefault(item.ndim, f"{kind} {shape}".strip())
                    told[1][item.attrs["unit"].decode()] = told[2][item.attrs["description"].decode()] = ""
            file.visititems(note)
    return [[name, " or ".join(shapes.values()), " or ".join(units), "; or: ".join(texts)]
            for name, (shapes, units, texts) in sorted(rows.items())]


def columns(words, table):
    """A row for a table: its columns with their units."""
    head = re.search(r"^[^#\n].*", table, re.M)[0].split("\t")
    units = dict(re.findall(r"(\S+) \[([^]]*)\]", " ".join(re.findall(r"^# units:(.*)", table, re.M))))
    return [words, ", ".join(name + (f" [{units[name]}]" if name in units else "") for name in head)]


def as_table(head, rows):
    escaped = [[re.sub(r"([\\|*_<$])", r"\\\1", cell) for cell in row] for row in rows]
    return "\n".join("| " + " | ".join(row) + " |" for row in [head, ["---"] * len(head), *escaped]) + "\n"


def page(program):
    with tempfile.TemporaryDirectory(prefix="sonopack-layouts-") as place:
        folder = pathlib.Path(place)

        def command(*words):
            return subprocess.run([program, *words, "-q"], cwd=folder, check=True, stdout=subprocess.PIPE, text=True).stdout
        make_files(command)
        make_linear(folder / "linear.h5")
        samples = datasets(sorted(folder.glob("*/*.h5")))
        parts = {"Packings": datasets([folder / f"{name}.h5" for name in (*PACKINGS, "linear")]),
                 "Modes": datasets([folder / "modes.h5"]), "Motions": datasets([folder / "motions.h5"]),
                 "Samples": [row for row in samples if row[0].startswith(("/results", "/signal"))]}
        tables = [columns(words.split(" --set column.taps")[0], command(*words.split())) for words in TABLES]
    text = "# Datasets and columns\n\n[file-format.md](../file-format.md) says what the letters are.\n"
    for title, rows in parts.items():
        text += f"\n## {title}\n\n" + as_table(["dataset", "type, shape", "unit", "content"], rows)
    text += "\n## Tables\n\n" + as_table(["command", "columns"], tables)
    from sonopack.formats import options
    roles = [[role, ", ".join(names.split())] for role, names in (options.OF_GRAINS | options.OF_CONTACTS).items() if names]
    return text + "\n## Columns of other programs\n\n" + as_table(["role", "names"], roles)
