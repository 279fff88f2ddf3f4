"""Drawing: a picture in a region of Blender's window. Blender converts its linear colors for the screen afterwards."""

from __future__ import annotations

from typing import Any, Optional

import numpy as np

from .viewport import Shown


# Largest number of a texture's format.
MOST = 65504.0


class Canvas:
    """The texture of the newest picture."""

    def __init__(self) -> None:
        self._drawn: Optional[tuple[Shown, bool]] = None
        self._texture: Optional[Any] = None

    def draw(self, engine: Any, scene: Any, picture: Shown) -> None:
        """Draws a picture over what the region shows already, where the picture is transparent or does not reach."""
        import gpu

        is_transparent = scene.render.film_transparent
        if self._drawn is None or self._drawn[0] is not picture or self._drawn[1] != is_transparent:
            self._texture, self._drawn = _texture(picture, is_transparent), (picture, is_transparent)
        before = gpu.state.blend_get()
        gpu.state.blend_set("ALPHA_PREMULT")
        engine.bind_display_space_shader(scene)
        try:
            _rectangle(self._texture, picture)
        finally:
            engine.unbind_display_space_shader()
            gpu.state.blend_set(before)


def _texture(picture: Shown, is_transparent: bool) -> Any:
    import gpu

    colors = np.minimum(picture.colors, MOST)
    if not is_transparent:
        colors[..., 3] = 1.0
    height, width = colors.shape[:2]
    pixels = gpu.types.Buffer("FLOAT", colors.size, colors.ravel())
    return gpu.types.GPUTexture((width, height), format="RGBA16F", data=pixels)


def _rectangle(texture: Any, picture: Shown) -> None:
    """Draws a texture into the view's window. What it has beyond the window is cut off."""
    import gpu
    from gpu_extras.batch import batch_for_shader

    x, y, width, height = picture.view.window
    right, top = width / picture.place[2], height / picture.place[3]
    places = ((x, y), (x + width, y), (x + width, y + height), (x, y + height))
    shader = gpu.shader.from_builtin("IMAGE")
    batch = batch_for_shader(shader, "TRI_FAN", {"pos": places, "texCoord": ((0.0, 0.0), (right, 0.0), (right, top), (0.0, top))})
    shader.uniform_sampler("image", texture)
    batch.draw(shader)
