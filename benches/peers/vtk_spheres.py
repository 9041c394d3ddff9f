#!/usr/bin/env python3
"""Measures VTK's sphere mapper, off screen, as on a machine without a graphics card.

    vtk_spheres.py SCENE WIDTH HEIGHT THREADS RUNS [IMAGE]

One point a sphere with its radius and colour, drawn by `vtkOpenGLSphereMapper` as impostors (PyVista's points as spheres
are these), without light, in a window that is nowhere on a screen; Mesa's llvmpipe runs the shaders on THREADS threads.
A run sends the points anew, as those of another scene would be, draws, and reads the picture back. Prints one line of
JSON as the other peers do. Needs PyPI's vtk and numpy.
"""

import json
import os
import sys
import time

# Mesa reads it when it is loaded, VTK when it makes a window.
os.environ["LP_NUM_THREADS"] = sys.argv[4] if len(sys.argv) > 4 else "1"
os.environ["LIBGL_ALWAYS_SOFTWARE"] = "1"

import numpy
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401 (makes the window's class known)
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkPoints, vtkUnsignedCharArray
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkRenderingCore import vtkActor, vtkRenderer, vtkRenderWindow
from vtkmodules.vtkRenderingOpenGL2 import vtkOpenGLSphereMapper


def read(path):
    with open(path) as file:
        words = (word for line in file for word in line.split("#")[0].split())
        header = [next(words) for _ in range(10)]
        numbers = [float(word) for word in words if word != "S"]
    spheres = numpy.array(numbers).reshape(-1, 7)
    viewport = [float(word) for word in header[1:4]]
    background = [int(word) for word in header[5:8]]
    return viewport, background, spheres[:, :4].astype("float32"), spheres[:, 4:].astype("uint8")


def poly_data(spheres, colours):
    """VTK's camera looks along -z with x to the right."""
    data = vtkPolyData()
    points = vtkPoints()
    points.SetData(numpy_to_vtk(spheres[:, :3] * numpy.float32([1, 1, -1]), deep=True))
    data.SetPoints(points)
    # One vertex for each point: without cells the data has no bounds and is not drawn.
    every = numpy.arange(len(spheres) + 1, dtype="int64")
    vertices = vtkCellArray()
    vertices.SetData(numpy_to_vtk(every, deep=True), numpy_to_vtk(every[:-1], deep=True))
    data.SetVerts(vertices)
    radii = numpy_to_vtk(spheres[:, 3].copy(), deep=True)
    radii.SetName("radius")
    rgb = numpy_to_vtk(colours, deep=True)
    rgb.SetName("colour")
    data.GetPointData().AddArray(radii)
    data.GetPointData().SetScalars(rgb)
    return data


def set_camera(camera, viewport, size, spheres):
    """Its pixel i is the middle of the i-th of `width` cells: the window is one cell wider than the viewport."""
    width, height, distance = viewport
    across, up = (extent / max(count - 1, 1) * count / distance for extent, count in zip((width, height), size))
    camera.SetPosition(0, 0, 0)
    camera.SetFocalPoint(0, 0, -1)
    camera.SetViewUp(0, 1, 0)
    camera.SetViewAngle(numpy.degrees(2 * numpy.arctan(up / 2)))
    camera.SetUseExplicitAspectRatio(True)
    camera.SetExplicitAspectRatio(across / up)
    near, far = (spheres[:, 2] - spheres[:, 3]).min(), (spheres[:, 2] + spheres[:, 3]).max()
    camera.SetClippingRange(max(0.99 * near, 1e-6 * far), 1.01 * far)


def main():
    scene, size, runs = sys.argv[1], (int(sys.argv[2]), int(sys.argv[3])), int(sys.argv[5])
    viewport, background, spheres, colours = read(scene)
    mapper = vtkOpenGLSphereMapper()
    mapper.SetScaleArray("radius")
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().LightingOff()
    renderer = vtkRenderer()
    renderer.SetBackground(*(value / 255 for value in background))
    renderer.AddActor(actor)
    window = vtkRenderWindow()
    window.SetOffScreenRendering(True)
    window.SetMultiSamples(0)
    window.SetSize(*size)
    window.AddRenderer(renderer)
    set_camera(renderer.GetActiveCamera(), viewport, size, spheres)
    pixels = vtkUnsignedCharArray()
    build, trace = [], []
    for run in range(-1, runs):  # the first makes the window and its shaders
        start = time.perf_counter()
        mapper.SetInputData(poly_data(spheres, colours))
        built = time.perf_counter()
        window.Render()
        window.GetPixelData(0, 0, size[0] - 1, size[1] - 1, 0, pixels, 0)
        end = time.perf_counter()
        if run >= 0:
            build.append(1e3 * (built - start))
            trace.append(1e3 * (end - built))
    print(json.dumps({"mode": "sphere mapper", "build": build, "trace": trace}))
    if len(sys.argv) > 6:
        rows = vtk_to_numpy(pixels).reshape(size[1], size[0], 3)[::-1]
        with open(sys.argv[6], "wb") as file:
            file.write(b"P6\n%d %d\n255\n" % size + rows.tobytes())


if __name__ == "__main__":
    main()
