"""A picture of a packing that `sonopack convert P.h5 P.vtp` has written, with Python and VTK and without a screen:
grains as spheres, normal forces as tubes, and a mode or a snapshot, if the file has one, as arrows.

usage: python3 vtk_picture.py P.vtp P.png
"""
import sys

import vtk


def read(name):
    reader = vtk.vtkXMLPolyDataReader()
    reader.SetFileName(name)
    reader.Update()
    return reader.GetOutput()


def actor(source, color, opacity=1.0):
    mapper = vtk.vtkPolyDataMapper()
    mapper.SetInputConnection(source.GetOutputPort())
    mapper.ScalarVisibilityOff()
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
    largest = lines.GetPointData().GetArray("normal_force").GetRange()[1]
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


def draw(name, picture, size=900):
    grains, contacts = read(name), read(name.removesuffix(".vtp") + "-contacts.vtp")
    flat = grains.GetFieldData().GetArray("dimension").GetValue(0) < 3
    moving = grains.GetPointData().HasArray("displacement")
    renderer = vtk.vtkRenderer()
    renderer.SetBackground(1, 1, 1)
    renderer.UseDepthPeelingOn()  # translucent spheres in the right order
    renderer.AddActor(actor(spheres(grains), (0.75, 0.79, 0.85), 0.35))
    if contacts.GetNumberOfCells() > 0:
        renderer.AddActor(actor(tubes(contacts, 0.15), (0.75, 0.15, 0.10)))
    if moving:
        renderer.AddActor(actor(arrows(grains, 1.5), (0.05, 0.25, 0.60)))
    camera = renderer.GetActiveCamera()
    if flat:
        camera.ParallelProjectionOn()
    else:  # z is up
        camera.SetPosition(1, -2, 0.6)
        camera.SetViewUp(0, 0, 1)
    renderer.ResetCamera()
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(0)
    window.SetAlphaBitPlanes(1)
    window.SetSize(size, size)
    window.AddRenderer(renderer)
    window.Render()
    image = vtk.vtkWindowToImageFilter()
    image.SetInput(window)
    writer = vtk.vtkPNGWriter()
    writer.SetInputConnection(image.GetOutputPort())
    writer.SetFileName(picture)
    writer.Write()


if __name__ == "__main__":
    draw(*sys.argv[1:3])
