"""Cases in which Mitsuba 3.9.1 is known to be wrong (docs/differences.md), told from the text of a scene.

A scene of such a case is rendered and compared as others are. A difference in it is counted apart."""


def _bsdfs(root, *kinds):
    return [bsdf for bsdf in root.iter("bsdf") if bsdf.get("type") in kinds]


def _emitters(root, *kinds):
    return [emitter for emitter in root.iter("emitter") if emitter.get("type") in kinds]


def _value(parent, name):
    return next((child.get("value") for child in parent if child.get("name") == name), None)


def _is_mirrored(shape):
    signs = [value for scale in shape.iter("scale") for value in (scale.get("x"), scale.get("y"), scale.get("z"), scale.get("value")) if value]
    return sum(float(value) < 0.0 for value in signs) % 2 == 1


def mirrored_bump(root):
    """Relief on mirrored shapes."""
    return any(_is_mirrored(shape) and _bsdfs(shape, "bumpmap", "normalmap") for shape in root.iter("shape"))


def relief_without_uv(root):
    """Relief over anisotropic metal on meshes without texture coordinates."""
    meshes = [shape for shape in root.iter("shape") if shape.get("type") in ("ply", "obj")]
    return any(_bsdfs(shape, "bumpmap", "normalmap") and "alpha_u" in [each.get("name") for each in shape.iter("float")] for shape in meshes)


def blended_smooth_part(root):
    """A blend of two conductors, or of a smooth part and another: its samples have other weights than their density says."""
    smooth = ("conductor", "dielectric", "thindielectric", "plastic", "mask", "null")
    blends = _bsdfs(root, "blendbsdf")
    return any(_bsdfs(blend, *smooth) or len(_bsdfs(blend, "conductor", "roughconductor")) >= 2 for blend in blends)


def turned_sphere_lamp(root):
    """A textured sphere lamp that is turned: its two samplings disagree."""
    lamps = [shape for shape in root.iter("shape") if shape.get("type") == "sphere" and list(shape.iter("emitter"))]
    return any(list(lamp.iter("rotate")) and list(next(lamp.iter("emitter")).iter("texture")) for lamp in lamps)


def textured_cube_lamp(root):
    """A textured cube lamp: its six faces share the texture, and emitter sampling finds points of one of them only."""
    lamps = [shape for shape in root.iter("shape") if shape.get("type") == "cube"]
    return any(list(emitter.iter("texture")) for lamp in lamps for emitter in lamp.iter("emitter"))


def attributes_in_instances(root):
    """Vertex colors of a mesh that an instance shows are others than those of the mesh."""
    groups = [shape for shape in root.iter("shape") if shape.get("type") == "shapegroup"]
    return any(texture.get("type") == "mesh_attribute" for group in groups for texture in group.iter("texture"))


def hidden_lamp_lifts_clip(root):
    """A hidden lamp lifts `far_clip` for what is behind it."""
    hides = any(_value(integrator, "hide_emitters") == "true" for integrator in root.iter("integrator"))
    return hides and any(child.get("name") in ("far_clip", "near_clip") for child in root.iter("float")) and bool(_emitters(root, "area"))


def leaking_cube(root):
    """A cube that emits inwards leaks light, because a shadow ray ends 0.09 % of its length before the lamp."""
    lamps = [shape for shape in root.iter("shape") if list(shape.iter("emitter"))]
    return any(lamp.get("type") == "cube" and _value(lamp, "flip_normals") == "true" for lamp in lamps)


KNOWN = [mirrored_bump, relief_without_uv, blended_smooth_part, turned_sphere_lamp, textured_cube_lamp, attributes_in_instances, hidden_lamp_lifts_clip, leaking_cube]


def cases(root):
    """Names of the cases that a scene belongs to."""
    return [case.__name__ for case in KNOWN if case(root)]
