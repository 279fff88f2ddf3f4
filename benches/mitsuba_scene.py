"""The sensor and the integrator of Mitsuba 3 for comparisons: box filter, `path` of depth 16, roulette after 8."""
import mitsuba as mi
import numpy as np


def sensor(scene, width, height):
    """The scene's sensor with a film of another size."""
    params = mi.traverse(scene.sensors()[0])

    def number(name):
        return float(np.ravel(params[name])[0])

    return mi.load_dict({
        "type": "perspective", "fov_axis": "x", "fov": number("x_fov"),
        "to_world": mi.ScalarTransform4f(np.array(params["to_world"].matrix, dtype=np.float64).reshape(4, 4)),
        "near_clip": number("near_clip"), "far_clip": number("far_clip"),
        "principal_point_offset_x": number("principal_point_offset_x"),
        "principal_point_offset_y": number("principal_point_offset_y"),
        "film": {"type": "hdrfilm", "width": width, "height": height, "rfilter": {"type": "box"},
                 "pixel_format": "rgb", "component_format": "float32"},
        "sampler": {"type": "independent"},
    })


def integrator():
    return mi.load_dict({"type": "path", "max_depth": 16, "rr_depth": 8})
