"""Renders scenes of Mitsuba, pbrt, glTF and USD with path guiding, on any Vulkan device.

>>> import lodestar
>>> picture = lodestar.render("scene.xml", spp=64)   # or a folder, a Scene, or Mitsuba's scene dictionary
>>> picture.radiance.shape                           # numpy, (height, width, 3), float32, linear sRGB
(256, 256, 3)
>>> picture.save("picture.exr")                      # all layers; a name in .png is for viewers

`render` renders from start to end, `Renderer` step by step. `load` reads a scene once for several renders. `compare` measures the
error of a picture, `merge` joins parts of one, `convert` writes a scene as a file of Mitsuba. `devices` lists the devices, `options` every keyword of `render`. Everything that
goes wrong raises `lodestar.Error` with one sentence that says what to do.
"""

from ._lodestar import (
    Error,
    Guide,
    Picture,
    Renderer,
    ScalarTransform4f,
    Scene,
    __version__,
    compare,
    convert,
    devices,
    load,
    merge,
    options,
    render,
    resume,
)

__all__ = [
    "Error",
    "Guide",
    "Picture",
    "Renderer",
    "ScalarTransform4f",
    "Scene",
    "__version__",
    "compare",
    "convert",
    "devices",
    "load",
    "merge",
    "options",
    "render",
    "resume",
]
