"""VTK's own readers find in the files of `sonopack convert` what the plain reader of the other tests finds; and, where there
is a screen or Xvfb, examples/vtk_picture.py draws grains, forces and a mode.

usage: test_export_vtk.py COMMAND SOURCE_DIR
"""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

COMMAND, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
try:
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy
except ImportError:
    print("no python3-vtk9")
    sys.exit(77)

import numpy as np

sys.path.insert(0, str(SOURCE / "tests/cli"))
from foreign import Vtp

FOLDER = pathlib.Path(tempfile.mkdtemp(prefix="sonopack-vtk-"))
PACKINGS = {"2.h5": {"grains": 60, "width": 8}, "3.h5": {"dimension": 3, "grains": 120, "width": 5, "depth": 5},
            "1.h5": {"kind": '"chain"', "dimension": 1, "grains": 8}}


def run(*words):
    result = subprocess.run([str(word) for word in words], cwd=FOLDER, text=True, capture_output=True, timeout=1200)
    assert result.returncode == 0, f"{words}: {result.stdout} {result.stderr}"


def read(reader, path):
    """What a reader of VTK makes of a file. Every complaint is an error."""
    complaints = []
    reader.AddObserver("ErrorEvent", lambda *_: complaints.append(path))
    reader.AddObserver("WarningEvent", lambda *_: complaints.append(path))
    reader.SetFileName(str(path))
    reader.Update()
    assert not complaints and reader.GetErrorCode() == 0, f"{path}: VTK complains"
    return reader.GetOutput()


def arrays(data):
    return {data.GetArrayName(k): vtk_to_numpy(data.GetArray(k)) for k in range(data.GetNumberOfArrays())}


def compare(path):
    theirs, ours = read(vtk.vtkXMLPolyDataReader(), path), Vtp(path)
    assert theirs.GetNumberOfPoints() == len(ours.points), path
    if len(ours.points):
        assert (vtk_to_numpy(theirs.GetPoints().GetData()) == ours.points).all(), f"{path}: points"
    cells = theirs.GetLines() if ours.cells.shape[1] == 2 else theirs.GetVerts()
    assert (vtk_to_numpy(cells.GetConnectivityArray()).reshape(ours.cells.shape) == ours.cells).all(), f"{path}: cells"
    for data, own in ((theirs.GetPointData(), ours.point), (theirs.GetCellData(), ours.cell), (theirs.GetFieldData(), ours.field)):
        found = arrays(data)
        assert set(found) == set(own), f"{path}: {set(found) ^ set(own)}"
        for name in own:
            assert found[name].shape == own[name].shape and (found[name] == own[name]).all(), f"{path}: {name}"
    return theirs


def test_files():
    for name, keys in PACKINGS.items():
        words = [word for key, value in keys.items() for word in ("--set", f"packing.{key}={value}")]
        run(COMMAND, "pack", "--quiet", *words, "-o", name)
        run(COMMAND, "convert", name, "o.vtp", "--times", 20, "--force")
        grains = compare(FOLDER / "o.vtp")
        contacts, walls = compare(FOLDER / "o-contacts.vtp"), compare(FOLDER / "o-walls.vtp")
        assert contacts.GetNumberOfLines() > 0 and walls.GetNumberOfLines() > 0
        blocks = read(vtk.vtkXMLMultiBlockDataReader(), FOLDER / "o.vtm")
        assert blocks.GetNumberOfBlocks() == 2, name
        assert blocks.GetBlock(0).GetNumberOfPoints() == grains.GetNumberOfPoints()
        assert blocks.GetBlock(1).GetNumberOfLines() == contacts.GetNumberOfLines()
        run(COMMAND, "convert", name, "wave.pvd", "--times", "0:20:3", "--force")
        for k in range(3):
            compare(FOLDER / f"wave-{k:04d}.vtp")
        print(f"{name}: {grains.GetNumberOfPoints()} grains, {contacts.GetNumberOfLines()} contacts")


def test_empty():
    """No contact at all."""
    (FOLDER / "g.tsv").write_text("# width = 8\n# height = 2\n# pressure = 1e-4\n# friction = 0\nid x y radius\n0 1 1 0.5\n")
    (FOLDER / "c.tsv").write_text("i j nx ny overlap\n")
    run(COMMAND, "convert", "g.tsv", "none.h5", "--contacts", "c.tsv")
    run(COMMAND, "convert", "none.h5", "none.vtp")
    assert compare(FOLDER / "none.vtp").GetNumberOfPoints() == 1
    assert compare(FOLDER / "none-contacts.vtp").GetNumberOfLines() == 0


def picture(screen, name):
    """The shares of a picture that are white, tubes and arrows, and how much of its width or height is filled."""
    run(*screen, sys.executable, SOURCE / "examples/vtk_picture.py", name, "p.png")
    image = read(vtk.vtkPNGReader(), FOLDER / "p.png")
    red, green, blue = vtk_to_numpy(image.GetPointData().GetScalars()).astype(int)[:, :3].T
    white = (red > 250) & (green > 250) & (blue > 250)
    tubes, arrows = (red > green + 60) & (red > blue + 60), (blue > red + 40) & (blue > green + 30)
    size = image.GetDimensions()
    drawn = np.nonzero(~white.reshape(size[1], size[0]))
    filled = max(np.ptp(where) / size[0] for where in drawn)
    result = [float(np.mean(part)) for part in (white, tubes, arrows)] + [float(filled)]
    print(name, "picture: white, tubes, arrows, filled:", *(f"{share:.4f}" for share in result))
    assert 0.1 < result[0] < 0.95 and 0.9 < filled < 0.99, result
    return result


def test_picture():
    screen = [] if os.environ.get("DISPLAY") else ["xvfb-run", "-a"]
    if screen and not shutil.which("xvfb-run"):
        print("no screen, and no xvfb-run: no picture")
        return
    for name in ("2.h5", "3.h5"):
        run(COMMAND, "convert", name, "p.vtp", "--times", 20, "--force")
        own = picture(screen, "p.vtp")
        assert own[1] > 0.003 and own[2] > 0.0003, own
        # the same picture in metres
        run(COMMAND, "convert", name, "si.vtp", "--times", 20, "--force", "--units", "si", "--material",
            "E=70 GPa,nu=0.22,rho=2500,d=1 mm")
        assert np.allclose(picture(screen, "si.vtp"), own, atol=0.005)
        # a frame: neither contacts nor box
        run(COMMAND, "convert", name, "wave.pvd", "--times", "0:20:3", "--force")
        frame = picture(screen, "wave-0002.vtp")
        assert frame[1] == 0 and frame[2] > 0.0003, frame
    run(COMMAND, "convert", "1.h5", "p.vtp", "--force")
    assert picture(screen, "p.vtp")[1] > 0.003


try:
    test_files()
    test_empty()
    test_picture()
finally:
    shutil.rmtree(FOLDER)
