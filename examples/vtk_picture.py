"""A picture of a packing that `sonopack convert P.h5 P.vtp` has written, with Python and VTK and without a screen:
grains as spheres, normal forces as tubes, a mode or a snapshot, if the file has one, as arrows, and the box as lines.
A frame of a series (wave-0005.vtp of wave.pvd) has grains and arrows only.

usage: python3 vtk_picture.py P.vtp P.png
"""
import pathlib
import sys

import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy


def read(name):
    if not pathlib.Path(name).is_file():
        sys.exit(f"{name}: no such file")
    reader = vtk.vtkXMLPolyDataReader()
    reader.SetFileName(name)
    reader.Update()
    return reader.GetOutput()


def mean_diameter(grains):
    """The size to which tubes and arrows are drawn: the file may be in metres."""
    return 2 * np.mean(vtk_to_numpy(grains.GetPointData().GetArray("radius")))


def is_flat(grains):
    """Two dimensions or one. A frame does not give the dimension, but its heights do."""
    dimension = grains.GetFieldData().GetArray("dimension")
    if dimension:
        return dimension.GetValue(0) < 3
    low, high = grains.GetBounds()[4:]
    return low == high


def actor(source, color, opacity=1.0):
    mapper = vtk.vtkPolyDataMapper()
    mapper.SetInputConnection(source.GetOutputPort())
    mapper.ScalarVisibilityOff()
    mapper.Update()
    result = vtk.vtkActor()
    result.SetMapper(mapper)
    result.GetProperty().SetColor(*color)
    result.GetProperty().SetOpacity(opacity)
    return result


def spheres(grains):
    """A sphere of the grain's radius at each point."""
    ball = vtk.vtkSphereSource()
    ball.SetRadius(1)
    ball.SetThetaResolution(24)
    ball.SetPhiResolution(24)
    glyph = vtk.vtkGlyph3D()
    glyph.SetInputData(grains)
    glyph.SetSourceConnection(ball.GetOutputPort())
    glyph.SetInputArrayToProcess(0, 0, 0, vtk.vtkDataObject.FIELD_ASSOCIATION_POINTS, "radius")
    glyph.SetScaleModeToScaleByScalar()
    return glyph


def tubes(contacts, widest):
    """A tube along each contact, as wide as its normal force is large: the largest has the radius `widest`."""
    to_points = vtk.vtkCellDataToPointData()
    to_points.SetInputData(contacts)
    to_points.Update()
    lines = to_points.GetPolyDataOutput()
    lines.GetPointData().SetActiveScalars("normal_force")
    largest = max(lines.GetPointData().GetArray("normal_force").GetRange()[1], 1e-300)
    tube = vtk.vtkTubeFilter()
    tube.SetInputData(lines)
    tube.SetVaryRadiusToVaryRadiusByAbsoluteScalar()
    tube.SetNumberOfSides(12)
    scaled = vtk.vtkArrayCalculator()  # the radius is the active scalar itself
    scaled.SetInputData(lines)
    scaled.AddScalarArrayName("normal_force")
    scaled.SetFunction(f"normal_force*{widest / largest}")
    scaled.SetResultArrayName("radius")
    tube.SetInputConnection(scaled.GetOutputPort())
    return tube


def arrows(grains, longest):
    largest = max(grains.GetPointData().GetArray("displacement").GetRange(-1)[1], 1e-300)
    arrow = vtk.vtkArrowSource()
    glyph = vtk.vtkGlyph3D()
    glyph.SetInputData(grains)
    glyph.SetSourceConnection(arrow.GetOutputPort())
    glyph.SetInputArrayToProcess(1, 0, 0, vtk.vtkDataObject.FIELD_ASSOCIATION_POINTS, "displacement")
    glyph.SetVectorModeToUseVector()
    glyph.SetScaleModeToScaleByVector()
    glyph.SetScaleFactor(longest / largest)
    return glyph


def box_lines(box, tilt):
    """The box, tilted or not, in which a contact across a periodic edge ends outside."""
    outline = vtk.vtkOutlineSource()
    x, y, z = (box.GetComponent(0, k) for k in range(3))
    xy, xz, yz = (tilt.GetComponent(0, k) for k in range(3)) if tilt else (0, 0, 0)
    corners = [(a * x + b * xy + c * xz, b * y + c * yz, c * z) for c in (0, 1) for b in (0, 1) for a in (0, 1)]
    outline.SetBoxTypeToOriented()
    outline.SetCorners([number for corner in corners for number in corner])
    return outline


def actors(name):
    """What is drawn of a file, and whether it is flat."""
    grains, contacts = read(name), pathlib.Path(name.removesuffix(".vtp") + "-contacts.vtp")
    diameter, box = mean_diameter(grains), grains.GetFieldData().GetArray("box")
    drawn = [actor(spheres(grains), (0.75, 0.79, 0.85), 0.35)]
    if contacts.exists() and (lines := read(str(contacts))).GetNumberOfCells() > 0:
        drawn.append(actor(tubes(lines, 0.15 * diameter), (0.75, 0.15, 0.10)))
    if grains.GetPointData().HasArray("displacement"):
        drawn.append(actor(arrows(grains, 1.5 * diameter), (0.05, 0.25, 0.60)))
    if box:
        drawn.append(actor(box_lines(box, grains.GetFieldData().GetArray("tilt")), (0.4, 0.4, 0.4)))
    return drawn, is_flat(grains)


def fill(renderer, drawn, share):
    """Moves and zooms the camera until what is drawn fills `share` of the picture's width or height."""
    renderer.ResetCamera()
    camera = renderer.GetActiveCamera()
    matrix = camera.GetCompositeProjectionTransformMatrix(1, -1, 1)
    view = np.array([[matrix.GetElement(i, j) for j in range(4)] for i in (0, 1, 3)])
    low, high = np.full(2, np.inf), np.full(2, -np.inf)
    for each in drawn:
        points = vtk_to_numpy(each.GetMapper().GetInput().GetPoints().GetData())
        x, y, w = view[:, :3] @ points.T + view[:, 3:]
        low, high = np.minimum(low, [min(x / w), min(y / w)]), np.maximum(high, [max(x / w), max(y / w)])
    camera.SetWindowCenter(*(low + high) / 2)  # the picture reaches from -1 to 1
    camera.Zoom(share * 2 / max(high - low))


def draw(name, picture, size=900):
    drawn, flat = actors(name)
    renderer = vtk.vtkRenderer()
    renderer.SetBackground(1, 1, 1)
    renderer.UseDepthPeelingOn()  # translucent spheres in the right order
    for each in drawn:
        renderer.AddActor(each)
    camera = renderer.GetActiveCamera()
    if flat:
        camera.ParallelProjectionOn()
    else:  # z is up
        camera.SetPosition(1, -2, 0.6)
        camera.SetViewUp(0, 0, 1)
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(0)
    window.SetAlphaBitPlanes(1)
    window.SetSize(size, size)
    window.AddRenderer(renderer)
    fill(renderer, drawn, 0.95)
    window.Render()
    image = vtk.vtkWindowToImageFilter()
    image.SetInput(window)
    writer = vtk.vtkPNGWriter()
    writer.SetInputConnection(image.GetOutputPort())
    writer.SetFileName(picture)
    writer.Write()


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    draw(*sys.argv[1:3])
