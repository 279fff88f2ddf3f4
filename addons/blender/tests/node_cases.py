"""Settings of Blender's nodes whose values are compared. Each makes nodes in a tree and returns an output socket."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

Build = Callable[[Any], Any]


def node(tree: Any, kind: str, **settings: Any) -> Any:
    """Node with properties."""
    made = tree.nodes.new(f"ShaderNode{kind}")
    for name, value in settings.items():
        setattr(made, name, value)
    return made


def link(tree: Any, value: Any, socket: Any) -> None:
    """Links an output to an input, or sets the input's value."""
    if hasattr(value, "links"):
        tree.links.new(value, socket)
    else:
        socket.default_value = value


def position(tree: Any) -> Any:
    """Position in the world."""
    return node(tree, "NewGeometry").outputs["Position"]


def scaled(tree: Any, factor: float, shift: float = 0.0) -> Any:
    """Position times a number plus a number."""
    made = node(tree, "VectorMath", operation="MULTIPLY_ADD")
    link(tree, position(tree), made.inputs[0])
    made.inputs[1].default_value, made.inputs[2].default_value = (factor,) * 3, (shift,) * 3
    return made.outputs[0]


def component(tree: Any, vector: Any, axis: int) -> Any:
    """One coordinate."""
    made = node(tree, "SeparateXYZ")
    link(tree, vector, made.inputs[0])
    return made.outputs[axis]


def color(tree: Any, factor: float = 0.4, shift: float = 0.5) -> Any:
    """Color that varies, partly outside [0, 1]."""
    made = node(tree, "CombineXYZ")
    for axis in range(3):
        link(tree, component(tree, scaled(tree, factor * (1.0 + 0.3 * axis), shift), axis), made.inputs[axis])
    return made.outputs[0]


def other_color(tree: Any) -> Any:
    """Another color that varies."""
    made = node(tree, "VectorMath", operation="SINE")
    link(tree, scaled(tree, 3.0, 0.7), made.inputs[0])
    return color_of(tree, made.outputs[0])


def color_of(tree: Any, vector: Any) -> Any:
    """Vector from [-1, 1] to [0, 1]."""
    made = node(tree, "VectorMath", operation="MULTIPLY_ADD")
    link(tree, vector, made.inputs[0])
    made.inputs[1].default_value = made.inputs[2].default_value = (0.5,) * 3
    return made.outputs[0]


def made_of(kind: str, output: Any = 0, inputs: dict[Any, Any] | None = None, **settings: Any) -> Build:
    """Node with inputs: constants, or functions that make outputs."""

    def build(tree: Any) -> Any:
        made = node(tree, kind, **settings)
        for name, value in (inputs or {}).items():
            named = [s for at, s in enumerate(made.inputs) if name in (at, s.name, s.identifier)]
            socket = next((s for s in named if s.enabled), named[0])
            link(tree, value(tree) if callable(value) else value, socket)
        return next(s for at, s in enumerate(made.outputs) if output in (at, s.name, s.identifier) and s.enabled)

    return build


def x(factor: float, axis: int = 0, shift: float = 0.0) -> Build:
    """One coordinate times a number plus a number."""
    return lambda tree: component(tree, scaled(tree, factor, shift), axis)


MATH = """ADD SUBTRACT MULTIPLY DIVIDE MULTIPLY_ADD POWER LOGARITHM SQRT INVERSE_SQRT ABSOLUTE EXPONENT MINIMUM MAXIMUM LESS_THAN
GREATER_THAN SIGN COMPARE SMOOTH_MIN SMOOTH_MAX ROUND FLOOR CEIL TRUNC FRACT MODULO FLOORED_MODULO WRAP SNAP PINGPONG SINE COSINE
TANGENT ARCSINE ARCCOSINE ARCTANGENT ARCTAN2 SINH COSH TANH RADIANS DEGREES""".split()
# Functions whose values have no range near 0, and what keeps them away from it.
SHIFTED = {"DIVIDE", "LOGARITHM", "INVERSE_SQRT", "POWER"}
VECTOR_MATH = """ADD SUBTRACT MULTIPLY DIVIDE MULTIPLY_ADD CROSS_PRODUCT PROJECT REFLECT REFRACT FACEFORWARD DOT_PRODUCT DISTANCE LENGTH
SCALE NORMALIZE ABSOLUTE POWER SIGN MINIMUM MAXIMUM FLOOR CEIL FRACTION MODULO WRAP SNAP SINE COSINE""".split()
BLENDS = """MIX DARKEN MULTIPLY BURN LIGHTEN SCREEN DODGE ADD OVERLAY SOFT_LIGHT LINEAR_LIGHT DIFFERENCE EXCLUSION SUBTRACT DIVIDE HUE
SATURATION COLOR VALUE""".split()
FRACTALS = "FBM MULTIFRACTAL HYBRID_MULTIFRACTAL RIDGED_MULTIFRACTAL HETERO_TERRAIN".split()
METRICS = "EUCLIDEAN MANHATTAN CHEBYCHEV MINKOWSKI".split()


def cases() -> Iterator[tuple[str, Build]]:
    """Names and builders of all cases."""
    yield from _arithmetic()
    yield from _colors()
    yield from _textures()
    yield from _inputs()


def _arithmetic() -> Iterator[tuple[str, Build]]:
    for operation in MATH:
        shift = 4.0 if operation in SHIFTED else 0.1
        inputs = {0: x(1.3, 0, shift), 1: x(0.9, 1, shift), 2: 0.6}
        if operation in ("SINH", "COSH", "TANH", "EXPONENT", "TANGENT"):
            inputs = {0: x(0.5)}
        yield f"math {operation}", made_of("Math", 0, inputs, operation=operation)
    yield "math clamped", made_of("Math", 0, {0: x(1.0), 1: x(1.0, 1)}, operation="ADD", use_clamp=True)
    for operation in VECTOR_MATH:
        shift = 4.0 if operation in SHIFTED else 0.2
        inputs = {0: lambda t, s=shift: scaled(t, 1.1, s), 1: lambda t, s=shift: scaled(t, 0.7, s + 0.6), 2: (0.3, -0.2, 0.1), 3: 0.8}
        yield f"vector {operation}", made_of("VectorMath", _vector_output(operation), inputs, operation=operation)
    for kind in ("LINEAR", "STEPPED", "SMOOTHSTEP", "SMOOTHERSTEP"):
        inputs = {"Value": x(0.7), "From Min": -0.5, "From Max": 1.1, "To Min": 0.3, "To Max": -0.8}
        yield f"map range {kind}", made_of("MapRange", 0, inputs, interpolation_type=kind)
        vector = {"Vector": lambda t: scaled(t, 0.7), "From_Min_FLOAT3": (-0.5, 0.2, 0.0), "To_Max_FLOAT3": (2.0, 0.5, -1.0)}
        yield f"map vector {kind}", made_of("MapRange", "Vector", vector, interpolation_type=kind, data_type="FLOAT_VECTOR", clamp=False)
    yield "clamp", made_of("Clamp", 0, {"Value": x(1.0), "Min": -0.4, "Max": 0.7})
    yield "clamp range", made_of("Clamp", 0, {"Value": x(1.0), "Min": 0.7, "Max": -0.4}, clamp_type="RANGE")
    for kind in ("POINT", "TEXTURE", "VECTOR", "NORMAL"):
        constant = {"Vector": position, "Location": (0.3, -0.2, 0.5), "Rotation": (0.4, 0.7, -1.1), "Scale": (1.5, 0.6, -2.0)}
        if kind == "VECTOR" or kind == "NORMAL":
            del constant["Location"]
        yield f"mapping {kind}", made_of("Mapping", 0, constant, vector_type=kind)
        linked = {**constant, "Rotation": lambda t: scaled(t, 0.5), "Scale": lambda t: scaled(t, 0.2, 2.0)}
        yield f"mapping {kind} linked", made_of("Mapping", 0, linked, vector_type=kind)
    for kind in ("AXIS_ANGLE", "X_AXIS", "EULER_XYZ"):
        inputs = {"Vector": position, "Center": (0.2, 0.4, -0.1)}
        inputs.update({"Rotation": (0.3, 0.5, 0.9)} if kind == "EULER_XYZ" else {"Angle": x(0.8)})
        if kind == "AXIS_ANGLE":
            inputs["Axis"] = (0.2, 0.5, 1.0)
        yield f"rotate {kind}", made_of("VectorRotate", 0, inputs, rotation_type=kind, invert=kind == "EULER_XYZ")


def _vector_output(operation: str) -> str:
    return "Value" if operation in ("DOT_PRODUCT", "DISTANCE", "LENGTH") else "Vector"


def _colors() -> Iterator[tuple[str, Build]]:
    for blend in BLENDS:
        divisor = (0.3, 0.0, 1.7, 1.0) if blend == "DIVIDE" else other_color
        inputs = {"Factor_Float": x(0.3, 0, 0.5), "A_Color": color_case, "B_Color": divisor}
        yield f"mix {blend}", made_of("Mix", "Result_Color", inputs, data_type="RGBA", blend_type=blend)
    inputs = {"Factor_Float": x(0.6, 0, 0.5), "A_Float": x(1.0), "B_Float": 0.4}
    yield "mix float", made_of("Mix", "Result_Float", inputs, data_type="FLOAT", clamp_factor=False)
    inputs = {"Factor_Vector": lambda t: scaled(t, 0.5), "A_Vector": position, "B_Vector": (0.1, 0.9, -0.3)}
    yield "mix vector", made_of("Mix", "Result_Vector", inputs, data_type="VECTOR", factor_mode="NON_UNIFORM")
    yield "hue saturation", made_of("HueSaturation", 0, {"Hue": 0.7, "Saturation": 1.4, "Value": 0.8, "Color": color_case, "Fac": 0.9})
    yield "bright contrast", made_of("BrightContrast", 0, {"Color": color_case, "Contrast": 0.5, 1: 0.1})
    yield "gamma", made_of("Gamma", 0, {"Color": color_case, "Gamma": 2.2})
    yield "invert", made_of("Invert", 0, {"Color": color_case, 0: 0.7})
    yield "gray", made_of("RGBToBW", 0, {0: color_case})
    for mode in ("RGB", "HSV", "HSL"):
        for at in range(3):
            yield f"separate {mode} {at}", made_of("SeparateColor", at, {0: other_color}, mode=mode)
        yield f"combine {mode}", made_of("CombineColor", 0, {at: x(0.2, at, 0.5) for at in range(3)}, mode=mode)
    for interpolation in ("LINEAR", "CONSTANT", "EASE", "B_SPLINE"):
        yield f"ramp {interpolation}", ramp(interpolation, "Color")
    yield "ramp alpha", ramp("LINEAR", "Alpha")
    yield "curves of colors", curves("RGBCurve", {"Color": color_case}, 4)
    yield "curves of vectors", curves("VectorCurve", {"Vector": position}, 3)
    yield "curve of numbers", curves("FloatCurve", {"Value": x(0.4, 0, 0.5)}, 1)
    yield "blackbody", made_of("Blackbody", 0, {0: 3200.0})


def color_case(tree: Any) -> Any:
    """The color that most cases change."""
    return color(tree)


def ramp(interpolation: str, output: str) -> Build:
    """Color ramp of four stops."""

    def build(tree: Any) -> Any:
        made = node(tree, "ValToRGB")
        link(tree, component(tree, scaled(tree, 0.5, 0.5), 0), made.inputs[0])
        made.color_ramp.interpolation = interpolation
        elements = made.color_ramp.elements
        elements[0].position, elements[0].color = 0.1, (0.9, 0.1, 0.2, 1.0)
        elements[1].position, elements[1].color = 0.9, (0.1, 0.3, 0.8, 0.2)
        elements.new(0.35).color = (0.0, 1.0, 0.5, 0.7)
        elements.new(0.6).color = (0.6, 0.2, 0.9, 0.4)
        return made.outputs[output]

    return build


def curves(kind: str, inputs: dict[Any, Any], count: int) -> Build:
    """Curves with a bend in each."""

    def build(tree: Any) -> Any:
        made = node(tree, kind)
        for at in range(count):
            made.mapping.curves[at].points.new(0.3 + 0.1 * at, 0.6 - 0.1 * at)
        made.mapping.update()
        for name, value in inputs.items():
            link(tree, value(tree), made.inputs[name])
        return made.outputs[0]

    return build


def _textures() -> Iterator[tuple[str, Build]]:
    for dimensions in ("1D", "2D", "3D", "4D"):
        place = {"Vector": position, "W": x(1.1, 1), "Scale": 2.3}
        for kind in FRACTALS:
            octaves = {"Detail": 2.4, "Roughness": 0.6, "Lacunarity": 2.1, "Offset": 0.7, "Gain": 1.2}
            used = {name: value for name, value in {**place, **octaves}.items() if _has(dimensions, kind, name)}
            normalize = {} if kind != "FBM" else {"normalize": dimensions != "2D"}
            yield f"noise {dimensions} {kind}", made_of("TexNoise", 0, used, noise_dimensions=dimensions, noise_type=kind, **normalize)
        used = {name: value for name, value in {**place, "Distortion": 0.8, "Detail": 1.0}.items() if _has(dimensions, "FBM", name)}
        yield f"noise {dimensions} color", made_of("TexNoise", "Color", used, noise_dimensions=dimensions)
        # Each bit of the coordinates counts, so they are not computed.
        exact = {"Vector": position, "W": lambda tree: component(tree, position(tree), 1)}
        used = {name: value for name, value in exact.items() if _has(dimensions, "FBM", name)}
        yield f"white noise {dimensions}", made_of("TexWhiteNoise", "Color", used, noise_dimensions=dimensions)
        yield from _voronoi(dimensions)
    for profile in ("SIN", "SAW", "TRI"):
        inputs = {"Vector": position, "Scale": 0.6, "Distortion": 1.5, "Detail": 1.5, "Detail Scale": 1.3, "Phase Offset": 0.4}
        yield f"wave bands {profile}", made_of("TexWave", 0, inputs, wave_profile=profile, bands_direction="DIAGONAL")
        yield f"wave rings {profile}", made_of("TexWave", 1, inputs, wave_type="RINGS", wave_profile=profile, rings_direction="Y")
    for depth in (0, 2, 5, 10):
        yield f"magic {depth}", made_of("TexMagic", 0, {"Vector": position, "Scale": 0.7, "Distortion": 1.2}, turbulence_depth=depth)
    for kind in ("LINEAR", "QUADRATIC", "EASING", "DIAGONAL", "SPHERICAL", "QUADRATIC_SPHERE", "RADIAL"):
        yield f"gradient {kind}", made_of("TexGradient", 1, {"Vector": lambda t: scaled(t, 0.5, 0.1)}, gradient_type=kind)
    yield "checker", made_of("TexChecker", 0, {"Vector": position, "Color1": (0.9, 0.2, 0.1, 1), "Color2": (0.1, 0.3, 0.8, 1), "Scale": 2.7})
    yield "checker factor", made_of("TexChecker", 1, {"Vector": position, "Scale": 3.1})
    bricks = {"Vector": position, "Scale": 2.0, "Mortar Size": 0.05, "Mortar Smooth": 0.6, "Bias": -0.1}
    yield "brick", made_of("TexBrick", 0, bricks, squash=0.7, squash_frequency=3, offset=0.4, offset_frequency=2)
    yield "brick factor", made_of("TexBrick", 1, bricks)


def _has(dimensions: str, kind: str, name: str) -> bool:
    if name in ("Offset", "Gain"):
        return kind in ("HYBRID_MULTIFRACTAL", "RIDGED_MULTIFRACTAL") or (name == "Offset" and kind == "HETERO_TERRAIN")
    return {"W": dimensions in ("1D", "4D"), "Vector": dimensions != "1D"}.get(name, True)


def _voronoi(dimensions: str) -> Iterator[tuple[str, Build]]:
    place = {"Vector": position, "W": x(1.1, 1), "Scale": 1.9, "Randomness": 0.9}
    place = {name: value for name, value in place.items() if _has(dimensions, "FBM", name)}
    common = {"voronoi_dimensions": dimensions}
    outputs = ["Distance", "Color", "W" if dimensions == "1D" else "Position"]
    for feature in ("F1", "F2", "SMOOTH_F1"):
        for output in outputs:
            yield f"voronoi {dimensions} {feature} {output}", made_of("TexVoronoi", output, place, feature=feature, **common)
    yield f"voronoi {dimensions} edge", made_of("TexVoronoi", "Distance", place, feature="DISTANCE_TO_EDGE", **common)
    yield f"voronoi {dimensions} radius", made_of("TexVoronoi", "Radius", place, feature="N_SPHERE_RADIUS", **common)
    octaves = {**place, "Detail": 1.6, "Roughness": 0.7, "Lacunarity": 2.2}
    yield f"voronoi {dimensions} octaves", made_of("TexVoronoi", "Distance", octaves, normalize=True, **common)
    edges = made_of("TexVoronoi", "Distance", octaves, feature="DISTANCE_TO_EDGE", normalize=True, **common)
    yield f"voronoi {dimensions} edge octaves", edges
    if dimensions != "1D":
        for metric in METRICS[1:]:
            exponent = {"Exponent": 1.7} if metric == "MINKOWSKI" else {}
            yield f"voronoi {dimensions} {metric}", made_of("TexVoronoi", "Distance", {**place, **exponent}, distance=metric, **common)


def _inputs() -> Iterator[tuple[str, Build]]:
    for output in ("Generated", "Normal", "UV", "Object", "Camera", "Window", "Reflection"):
        yield f"coordinate {output}", made_of("TexCoord", output)
    for output in ("Position", "Normal", "True Normal", "Incoming", "Backfacing"):
        yield f"geometry {output}", made_of("NewGeometry", output)
    for output in ("Location", "Color", "Alpha", "Object Index", "Material Index", "Random"):
        yield f"object {output}", made_of("ObjectInfo", output)
    for output in ("View Vector", "View Z Depth", "View Distance"):
        yield f"camera {output}", made_of("CameraData", output)
    yield "fresnel", made_of("Fresnel", 0, {"IOR": 1.45})
    yield "layer weight", made_of("LayerWeight", "Fresnel", {"Blend": 0.3})
    yield "layer facing", made_of("LayerWeight", "Facing", {"Blend": x(0.2, 0, 0.5)})
