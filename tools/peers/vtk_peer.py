"""VTK's side of `brick bench peers`: draws what it is told and says how long it took.

The first line on stdin is the scene, as JSON; every other line is {"way", "mode", "frame", "picture"}. For each one line of
JSON goes to stdout. A picture is float32 RGB, row 0 on top, over black.
"""

import array
import json
import sys
import time

import vtk

TYPES = {"u8": vtk.VTK_UNSIGNED_CHAR, "i8": vtk.VTK_SIGNED_CHAR, "u16": vtk.VTK_UNSIGNED_SHORT, "i16": vtk.VTK_SHORT,
         "f32": vtk.VTK_FLOAT}

SURFACES = {"flying-edges": vtk.vtkFlyingEdges3D, "marching-cubes": vtk.vtkMarchingCubes}


def read_volume(scene):
    reader = vtk.vtkImageReader2()
    reader.SetFileName(scene["volume"])
    reader.SetFileDimensionality(3)
    reader.SetDataExtent(0, scene["dims"][0] - 1, 0, scene["dims"][1] - 1, 0, scene["dims"][2] - 1)
    reader.SetDataSpacing(scene["spacing"])
    reader.SetDataOrigin(scene["origin"])
    reader.SetDataScalarType(TYPES[scene["type"]])
    reader.SetDataByteOrderToLittleEndian()
    reader.FileLowerLeftOn()
    reader.Update()
    return reader.GetOutput()


def functions(scene):
    """The transfer function as VTK has it: colour and opacity piecewise linear in the value. Of two points at one value, a
    jump, VTK keeps the last, so the first moves down by a little."""
    colour, opacity = vtk.vtkColorTransferFunction(), vtk.vtkPiecewiseFunction()
    colour.AllowDuplicateScalarsOn()
    opacity.AllowDuplicateScalarsOn()
    for value, r, g, b, a in scene["points"]:
        colour.AddRGBPoint(value, r, g, b)
        opacity.AddPoint(value, a)
    return colour, opacity


def property_of(scene, mode):
    p = vtk.vtkVolumeProperty()
    p.SetInterpolationTypeToLinear()
    p.SetScalarOpacityUnitDistance(scene["unit_mm"])
    if mode == "iso":
        # The surface as a step of opacity: the fixed-point mapper knows no other.
        colour, opacity = vtk.vtkColorTransferFunction(), vtk.vtkPiecewiseFunction()
        colour.AddRGBPoint(scene["isovalue"], *scene["iso_rgb"])
        opacity.AllowDuplicateScalarsOn()
        opacity.AddPoint(scene["isovalue"], 0.0)
        opacity.AddPoint(scene["isovalue"], 1.0)
    else:
        colour, opacity = functions(scene)
    p.SetColor(colour)
    p.SetScalarOpacity(opacity)
    if mode != "dvr":
        p.ShadeOn()
        light(p, scene)
    return p


def light(p, scene):
    p.SetAmbient(scene["ambient"])
    p.SetDiffuse(scene["diffuse"])
    p.SetSpecular(scene["specular"])
    p.SetSpecularPower(scene["shininess"])


class Stage:
    """One way to draw one mode, with its own window."""

    def __init__(self, scene, image, way, mode):
        self.scene, self.image, self.way = scene, image, way
        self.window = vtk.vtkRenderWindow()
        self.window.SetOffScreenRendering(1)
        self.window.SetMultiSamples(0)
        self.window.SetSize(*scene["size"])
        self.renderer = vtk.vtkRenderer()
        self.renderer.SetBackground(0, 0, 0)
        self.window.AddRenderer(self.renderer)
        self.contour = None
        if way in SURFACES:
            self.add_surface(SURFACES[way]())
        else:
            self.add_volume(mode)

    def add_volume(self, mode):
        if self.way == "gpu":
            mapper = vtk.vtkGPUVolumeRayCastMapper()
            mapper.UseJitteringOff()
            mapper.AutoAdjustSampleDistancesOff()
            mapper.LockSampleDistanceToInputSpacingOff()
            mapper.SetMaxMemoryInBytes(1 << 33)
        else:
            mapper = vtk.vtkFixedPointVolumeRayCastMapper()
            mapper.AutoAdjustSampleDistancesOff()
        mapper.SetInputData(self.image)
        mapper.SetSampleDistance(self.scene["step_mm"])
        mapper.SetImageSampleDistance(1.0)
        volume = vtk.vtkVolume()
        volume.SetMapper(mapper)
        p = property_of(self.scene, mode)
        if mode == "iso" and self.way == "gpu":
            mapper.SetBlendModeToIsoSurface()
            p.GetIsoSurfaceValues().SetValue(0, self.scene["isovalue"])
            opacity = vtk.vtkPiecewiseFunction()
            opacity.AddPoint(self.scene["isovalue"], 1.0)
            p.SetScalarOpacity(opacity)
        volume.SetProperty(p)
        self.renderer.AddVolume(volume)

    def add_surface(self, contour):
        self.contour = contour
        self.contour.SetInputData(self.image)
        self.contour.SetValue(0, self.scene["isovalue"])
        self.contour.ComputeNormalsOn()
        self.contour.ComputeScalarsOff()
        mapper = vtk.vtkPolyDataMapper()
        mapper.SetInputConnection(self.contour.GetOutputPort())
        mapper.ScalarVisibilityOff()
        actor = vtk.vtkActor()
        actor.SetMapper(mapper)
        actor.GetProperty().SetColor(*self.scene["iso_rgb"])
        actor.GetProperty().SetInterpolationToPhong()
        light(actor.GetProperty(), self.scene)
        self.renderer.AddActor(actor)

    def aim(self, camera):
        c = self.renderer.GetActiveCamera()
        c.SetPosition(camera["eye"])
        c.SetFocalPoint(camera["look"])
        c.SetViewUp(camera["up"])
        if camera["ortho"] > 0:
            c.ParallelProjectionOn()
            c.SetParallelScale(camera["ortho"] / 2)
        else:
            c.ParallelProjectionOff()
            c.SetViewAngle(camera["fov"])
        self.renderer.ResetCameraClippingRange()

    def draw(self, camera):
        """Seconds: of extraction, if there is a surface; of the picture until its pixels are in memory; the pixels."""
        extraction = 0.0
        if self.contour:
            self.contour.Modified()
            start = time.perf_counter()
            self.contour.Update()
            extraction = time.perf_counter() - start
        self.aim(camera)
        pixels = vtk.vtkUnsignedCharArray()
        start = time.perf_counter()
        self.window.Render()
        self.window.GetPixelData(0, 0, self.scene["size"][0] - 1, self.scene["size"][1] - 1, 0, pixels, 0)
        return extraction, time.perf_counter() - start, pixels


def save(pixels, size, path):
    data, row = memoryview(pixels).cast("B"), 3 * size[0]
    with open(path, "wb") as file:
        for y in reversed(range(size[1])):
            array.array("f", [v / 255.0 for v in data[y * row:(y + 1) * row]]).tofile(file)


def main():
    scene = json.loads(sys.stdin.readline())
    image = read_volume(scene)
    stages = {}
    print(json.dumps({"version": vtk.vtkVersion().GetVTKVersion()}), flush=True)
    for line in sys.stdin:
        order = json.loads(line)
        key = order["way"], order["mode"]
        if key not in stages:
            stages[key] = Stage(scene, image, *key)
        extraction, seconds, pixels = stages[key].draw(scene["cameras"][order["frame"]])
        if order["picture"]:
            save(pixels, scene["size"], order["picture"])
        print(json.dumps({"extraction": extraction, "seconds": seconds}), flush=True)


if __name__ == "__main__":
    main()
