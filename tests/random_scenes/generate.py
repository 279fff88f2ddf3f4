"""Small random scenes in Mitsuba's format, put together as real scenes are: each of a seed, with its meshes and images in one folder."""

import math
import pathlib
import random
import struct
import xml.etree.ElementTree as ElementTree
import zlib

WIDTH, HEIGHT = 24, 18
METALS = ("Au", "Ag", "Cu", "Al", "W", "Cr")
GLASSES = ("bk7", "water", "diamond", "acrylic glass")


def plugin(tag, kind, name=None, **attributes):
    named = {} if name is None else {"name": name}
    return ElementTree.Element(tag, {"type": kind, **named, **attributes})


def text(value):
    return ", ".join(f"{each:.4f}" for each in value) if isinstance(value, (tuple, list)) else str(value)


def add(parent, tag, name, value):
    """Adds a parameter, and returns `parent`."""
    value = f"{value:.4f}" if isinstance(value, float) else str(value).lower() if isinstance(value, bool) else text(value)
    ElementTree.SubElement(parent, tag, {"name": name, "value": value})
    return parent


class Generator:
    """Maker of the scene of a seed."""

    def __init__(self, seed, folder):
        self.random, self.folder, self.files, self.groups = random.Random(seed), pathlib.Path(folder), 0, 0
        self.folder.mkdir(parents=True, exist_ok=True)

    # ------------------------------------------------------------------------------------------------ numbers

    def chance(self, probability):
        return self.random.random() < probability

    def pick(self, *choices):
        return self.random.choice(choices)

    def number(self, low, high):
        return self.random.uniform(low, high)

    def color(self, low, high):
        if self.chance(0.3):
            return (self.number(low, high),) * 3
        return tuple(self.number(low, high) for _ in range(3))

    def turn(self):
        """Axis of length 1, and an angle."""
        z, phi = self.number(-1, 1), self.number(0, 2 * math.pi)
        r = math.sqrt(1 - z * z)
        return {"x": f"{r * math.cos(phi):.7f}", "y": f"{r * math.sin(phi):.7f}", "z": f"{z:.7f}", "angle": f"{self.number(-180, 180):.3f}"}

    # -------------------------------------------------------------------------------------------------- files

    def file(self, ending, content):
        self.files += 1
        name = f"file{self.files}.{ending}"
        (self.folder / name).write_bytes(content)
        return name

    def png(self):
        """Image of bytes: noise, a gradient or stripes."""
        width, height, pattern = self.pick(1, 2, 5, 8, 16), self.pick(1, 3, 8, 16), self.pick("noise", "gradient", "stripes")
        base = [self.number(20, 230) for _ in range(3)]

        def texel(x, y):
            if pattern == "noise":
                return bytes(self.random.randrange(10, 240) for _ in range(3))
            share = (x + 0.5) / width if pattern == "gradient" else float((x + y) % 2)
            return bytes(int(channel * (0.3 + 0.7 * share)) for channel in base)

        rows = b"".join(b"\0" + b"".join(texel(x, y) for x in range(width)) for y in range(height))
        chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
        return self.file("png", b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))

    def pfm(self, width, height, low, high):
        """Image of floats."""
        numbers = [self.number(low, high) for _ in range(3 * width * height)]
        return self.file("pfm", f"PF\n{width} {height}\n-1.0\n".encode() + struct.pack(f"<{len(numbers)}f", *numbers))

    def mesh(self):
        """A bumpy square or a ball, as OBJ or PLY, with normals, coordinates and colors or without."""
        n, is_ball = self.pick(3, 6), self.chance(0.5)
        amplitude = self.number(0.0, 0.25)
        vertices, triangles = [], []
        for i in range(n + 1):
            for j in range(2 * n + 1 if is_ball else n + 1):
                u, v = j / (2 * n if is_ball else n), i / n
                if is_ball:
                    theta, phi = math.pi * (0.02 + 0.96 * v), 2 * math.pi * u
                    p = (math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta))
                    normal = p
                else:
                    slope = 5.0 * amplitude * math.cos(5.0 * u)
                    p, length = (2 * u - 1, 2 * v - 1, 2 * amplitude * math.sin(5.0 * u)), math.hypot(slope, 1.0)
                    normal = (-slope / length, 0.0, 1.0 / length)
                vertices.append((*p, *normal, u, v))
        columns = 2 * n + 1 if is_ball else n + 1
        for i in range(n):
            for j in range(columns - 1):
                a = i * columns + j
                quad = (a, a + columns, a + columns + 1, a + 1) if is_ball else (a, a + 1, a + columns + 1, a + columns)
                triangles += [(quad[0], quad[1], quad[2]), (quad[0], quad[2], quad[3])]
        has_normals, has_uv, colored = self.chance(0.6), self.chance(0.7), self.chance(0.3)
        if not colored and self.chance(0.5):
            lines = ["v %.6f %.6f %.6f" % v[:3] for v in vertices]
            lines += ["vt %.6f %.6f" % v[6:] for v in vertices if has_uv] + ["vn %.6f %.6f %.6f" % v[3:6] for v in vertices if has_normals]
            corner = lambda k: f"{k + 1}/{k + 1 if has_uv else ''}/{k + 1 if has_normals else ''}".rstrip("/")
            lines += ["f " + " ".join(corner(k) for k in triangle) for triangle in triangles]
            return "obj", self.file("obj", "\n".join(lines).encode() + b"\n"), False
        names = ["x", "y", "z"] + ["nx", "ny", "nz"] * has_normals + ["u", "v"] * has_uv + ["r", "g", "b"] * colored
        head = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}", *(f"property float {name}" for name in names)]
        head += [f"element face {len(triangles)}", "property list uchar int vertex_indices", "end_header", ""]
        body = b""
        for v in vertices:
            row = [*v[:3], *(v[3:6] if has_normals else ()), *(v[6:] if has_uv else ())]
            row += [self.number(0.1, 0.9) for _ in range(3)] if colored else []
            body += struct.pack(f"<{len(row)}f", *row)
        body += b"".join(struct.pack("<B3i", 3, *triangle) for triangle in triangles)
        return "ply", self.file("ply", "\n".join(head).encode() + body), colored

    # ------------------------------------------------------------------------------------------------- textures

    def texture(self, name, low=0.05, high=0.9, colored=True):
        """A bitmap or a checkerboard; `colored` is False for numbers."""
        if self.chance(0.35):
            texture = plugin("texture", "checkerboard", name)
            for key in ("color0", "color1"):
                add(texture, "rgb", key, self.color(low, high) if colored else (self.number(low, high),) * 3)
        else:
            is_float = self.chance(0.4)
            path = self.pfm(self.pick(2, 7), self.pick(2, 5), low, high) if is_float else self.png()
            texture = add(plugin("texture", "bitmap", name), "string", "filename", path)
            if is_float or not colored or self.chance(0.3):
                add(texture, "boolean", "raw", True)
            add(texture, "string", "filter_type", self.pick("nearest", "bilinear"))
            add(texture, "string", "wrap_mode", self.pick("repeat", "mirror", "clamp"))
        if self.chance(0.4):
            transform = ElementTree.SubElement(texture, "transform", {"name": "to_uv"})
            ElementTree.SubElement(transform, "scale", {"x": f"{self.number(0.5, 4):.3f}", "y": f"{self.number(0.5, 4):.3f}"})
            if self.chance(0.5):
                ElementTree.SubElement(transform, "translate", {"x": f"{self.number(-1, 1):.3f}", "y": f"{self.number(-1, 1):.3f}"})
        return texture

    def colored(self, parent, name, low=0.05, high=0.9, texture=0.35):
        """Adds a color, a spectrum or a texture."""
        if self.chance(texture):
            parent.append(self.texture(name, low, high))
        elif self.chance(0.1):
            parent.append(add(plugin("texture", "uniform", name), "float", "value", self.number(low, high)))
        elif self.chance(0.1):
            add(parent, "spectrum", name, "400:{:.3f}, 550:{:.3f}, 700:{:.3f}".format(*self.color(low, high)))
        else:
            add(parent, "rgb", name, self.color(low, high))
        return parent

    # ---------------------------------------------------------------------------------------------------- BSDFs

    def facets(self, bsdf, textured=True):
        add(bsdf, "string", "distribution", self.pick("beckmann", "ggx"))
        if self.chance(0.3):
            add(add(bsdf, "float", "alpha_u", self.number(0.1, 0.5)), "float", "alpha_v", self.number(0.1, 0.5))
        elif textured and self.chance(0.2):
            bsdf.append(self.texture("alpha", 0.1, 0.5, colored=False))
        else:
            add(bsdf, "float", "alpha", self.number(0.08, 0.5))
        if self.chance(0.2):
            add(bsdf, "boolean", "sample_visible", False)
        return bsdf

    def metal(self, bsdf):
        if self.chance(0.6):
            add(bsdf, "string", "material", self.pick(*METALS))
        else:
            add(add(bsdf, "rgb", "eta", self.color(0.3, 2.0)), "rgb", "k", self.color(1.0, 4.0))
        return self.colored(bsdf, "specular_reflectance", 0.5, 1.0, 0.2) if self.chance(0.3) else bsdf

    def opaque(self):
        """BSDF that reflects, from one side."""
        kind = self.pick("diffuse", "diffuse", "roughconductor", "conductor", "plastic", "roughplastic", "principled", "principled")
        bsdf = plugin("bsdf", kind)
        if kind == "diffuse":
            return self.colored(bsdf, "reflectance")
        if kind in ("conductor", "roughconductor"):
            self.metal(bsdf)
            return self.facets(bsdf) if kind == "roughconductor" else bsdf
        if kind in ("plastic", "roughplastic"):
            self.colored(bsdf, "diffuse_reflectance")
            add(bsdf, "float", "int_ior", self.number(1.3, 1.9))
            if self.chance(0.4):
                add(bsdf, "boolean", "nonlinear", True)
            if kind == "roughplastic":
                add(add(bsdf, "string", "distribution", self.pick("beckmann", "ggx")), "float", "alpha", self.number(0.08, 0.4))
            return bsdf
        self.colored(bsdf, "base_color")
        add(bsdf, "float", "roughness", self.number(0.2, 0.9))
        for name in ("metallic", "specular", "spec_tint", "sheen", "clearcoat", "clearcoat_gloss", "flatness", "anisotropic"):
            if self.chance(0.2):
                add(bsdf, "float", name, self.number(0.05, 0.95))
        return bsdf

    def glass(self):
        """BSDF of a body that light passes."""
        kind = self.pick("dielectric", "roughdielectric", "thindielectric", "principled")
        bsdf = plugin("bsdf", kind)
        if kind == "principled":
            add(add(bsdf, "float", "spec_trans", self.number(0.3, 1.0)), "float", "roughness", self.number(0.2, 0.7))
            return add(self.colored(bsdf, "base_color", texture=0.1), "float", "eta", self.number(1.2, 1.8))
        if self.chance(0.5):
            add(bsdf, "string", "int_ior", self.pick(*GLASSES))
        else:
            add(bsdf, "float", "int_ior", self.number(1.1, 2.2))
        if kind == "roughdielectric":
            add(add(bsdf, "string", "distribution", self.pick("beckmann", "ggx")), "float", "alpha", self.number(0.1, 0.5))
        return bsdf

    def bsdf(self, depth=0):
        """BSDF with modifiers, nested as exporters nest them."""
        if depth < 2 and self.chance(0.45):
            kind = self.pick("twosided", "twosided", "mask", "blendbsdf", "bumpmap", "normalmap")
            if kind == "twosided":
                parent = plugin("bsdf", kind)
                parent.extend(self.relief(self.opaque()) if self.chance(0.2) else self.opaque() for _ in range(self.pick(1, 1, 1, 2)))
                return parent
            if kind == "mask":
                parent = plugin("bsdf", kind)
                if self.chance(0.4):
                    parent.append(self.texture("opacity", 0.1, 0.9, colored=False))
                else:
                    add(parent, "float", "opacity", self.number(0.2, 0.9))
                parent.append(self.bsdf(depth + 1))
                return parent
            if kind == "blendbsdf":
                parent = plugin("bsdf", kind)
                if self.chance(0.4):
                    parent.append(self.texture("weight", 0.1, 0.9, colored=False))
                else:
                    add(parent, "float", "weight", self.number(0.1, 0.9))
                parent.extend([self.bsdf(depth + 1), self.bsdf(depth + 1)])
                return parent
            return self.relief(self.opaque(), kind)
        if self.chance(0.03):
            return plugin("bsdf", "null")
        return self.glass() if self.chance(0.15) else self.opaque()

    def relief(self, bsdf, kind=None):
        kind = kind or self.pick("bumpmap", "normalmap")
        parent = plugin("bsdf", kind)
        if kind == "bumpmap":
            texture = add(plugin("texture", "bitmap"), "string", "filename", self.pfm(8, 8, 0.0, 0.2))
            add(add(texture, "boolean", "raw", True), "string", "wrap_mode", self.pick("repeat", "clamp"))
            parent.append(texture)
            add(parent, "float", "scale", self.number(0.1, 1.0))
        else:
            numbers = [c for _ in range(16) for c in (self.number(0.4, 0.6), self.number(0.4, 0.6), 0.95)]
            path = self.file("pfm", b"PF\n4 4\n-1.0\n" + struct.pack("<48f", *numbers))
            texture = add(plugin("texture", "bitmap", "normalmap"), "string", "filename", path)
            parent.append(add(texture, "boolean", "raw", True))
        parent.append(bsdf)
        return parent

    # --------------------------------------------------------------------------------------------------- shapes

    def placed(self, shape, spread=1.0, uneven=True, size=(0.2, 0.6)):
        """Adds a chain of transforms."""
        transform = ElementTree.SubElement(shape, "transform", {"name": "to_world"})
        if uneven and self.chance(0.3):
            ElementTree.SubElement(transform, "scale", {axis: f"{self.number(0.5, 1.5):.3f}" for axis in "xyz"})
        if uneven and self.chance(0.1):
            ElementTree.SubElement(transform, "scale", {self.pick(*"xyz"): "-1"})
        ElementTree.SubElement(transform, "scale", {"value": f"{self.number(*size):.4f}"})
        for _ in range(self.pick(0, 1, 1, 2)):
            ElementTree.SubElement(transform, "rotate", self.turn())
        place = {axis: f"{self.number(-spread, spread):.4f}" for axis in "xyz"}
        ElementTree.SubElement(transform, "translate", place)
        return shape

    def geometry(self):
        """Shape without a surface, and whether it may be scaled unevenly, and whether it has vertex colors."""
        kind = self.pick("sphere", "sphere", "rectangle", "disk", "cube", "cylinder", "mesh", "mesh", "mesh")
        if kind == "mesh":
            kind, path, colored = self.mesh()
            shape = add(plugin("shape", kind), "string", "filename", path)
            if self.chance(0.3):
                add(shape, "boolean", "face_normals", True)
            return shape, True, colored
        shape = plugin("shape", kind)
        if self.chance(0.1):
            add(shape, "boolean", "flip_normals", True)
        return shape, kind not in ("sphere", "cylinder"), False

    def shape(self):
        shape, uneven, colored = self.geometry()
        self.placed(shape, uneven=uneven)
        if colored:
            diffuse = plugin("bsdf", "diffuse")
            diffuse.append(add(plugin("texture", "mesh_attribute", "reflectance"), "string", "name", "vertex_color"))
            parent = plugin("bsdf", "twosided")
            parent.append(diffuse)
            shape.append(parent)
        else:
            shape.append(self.bsdf())
        return shape

    def group(self):
        """A shapegroup and its instances."""
        self.groups += 1
        group = plugin("shape", "shapegroup", id=f"group{self.groups}")
        group.extend(self.shape() for _ in range(self.pick(1, 2)))
        instances = []
        for _ in range(self.pick(1, 2)):
            instance = plugin("shape", "instance")
            ElementTree.SubElement(instance, "ref", {"id": f"group{self.groups}"})
            instances.append(self.placed(instance, 0.8, uneven=False, size=(0.4, 0.9)))
        return [group, *instances]

    # ------------------------------------------------------------------------------------------------- emitters

    def lamp(self):
        """Shape that emits."""
        kind = self.pick("rectangle", "disk", "sphere", "sphere", "cube")
        shape = self.placed(plugin("shape", kind), 1.5, uneven=False, size=(0.1, 0.4))
        for translate in shape.iter("translate"):
            translate.set("y", f"{self.number(0.8, 2.0):.4f}")
        emitter = plugin("emitter", "area")
        if self.chance(0.2):
            emitter.append(add(add(plugin("texture", "bitmap", "radiance"), "string", "filename", self.pfm(3, 2, 2.0, 20.0)), "boolean", "raw", True))
        else:
            add(emitter, "rgb", "radiance", self.color(3.0, 20.0))
        shape.append(emitter)
        return shape

    def light(self):
        """Emitter of the scene besides the environment."""
        kind = self.pick("point", "spot", "directional", "projector")
        emitter = plugin("emitter", kind)
        place = ", ".join(f"{self.number(1.5, 3.0) * self.pick(-1, 1):.4f}" for _ in range(2))
        origin = f"{place.split(', ')[0]}, {self.number(1.0, 3.0):.4f}, {place.split(', ')[1]}"
        if kind == "point":
            x, y, z = origin.split(", ")
            ElementTree.SubElement(emitter, "point", {"name": "position", "x": x, "y": y, "z": z})
            return add(emitter, "rgb", "intensity", self.color(2.0, 15.0))
        if kind == "directional":
            direction = {axis: f"{self.number(-1, 1):.4f}" for axis in "xz"}
            ElementTree.SubElement(emitter, "vector", {"name": "direction", **direction, "y": f"{self.number(-2, -0.5):.4f}"})
            return add(emitter, "rgb", "irradiance", self.color(0.5, 3.0))
        transform = ElementTree.SubElement(emitter, "transform", {"name": "to_world"})
        ElementTree.SubElement(transform, "lookat", {"origin": origin, "target": text([self.number(-0.3, 0.3) for _ in range(3)]), "up": "0, 0, 1"})
        if kind == "spot":
            cutoff = self.number(15.0, 50.0)
            add(add(emitter, "float", "cutoff_angle", cutoff), "float", "beam_width", cutoff * self.number(0.3, 0.9))
            return add(emitter, "rgb", "intensity", self.color(5.0, 30.0))
        texture = add(plugin("texture", "bitmap", "irradiance"), "string", "filename", self.pfm(self.pick(2, 4), self.pick(2, 4), 1.0, 20.0))
        emitter.append(add(texture, "boolean", "raw", True))
        return add(emitter, "float", "fov", self.number(20.0, 60.0))

    def environment(self):
        if self.chance(0.5):
            return add(plugin("emitter", "constant"), "rgb", "radiance", self.color(0.1, 1.0))
        emitter = add(plugin("emitter", "envmap"), "string", "filename", self.pfm(self.pick(4, 8, 16), self.pick(3, 8), 0.05, 2.0))
        if self.chance(0.5):
            transform = ElementTree.SubElement(emitter, "transform", {"name": "to_world"})
            ElementTree.SubElement(transform, "rotate", self.turn())
        return add(emitter, "float", "scale", self.number(0.3, 1.5)) if self.chance(0.4) else emitter

    # ---------------------------------------------------------------------------------------------------- scene

    def integrator(self):
        integrator = plugin("integrator", "direct" if self.chance(0.1) else "path")
        if integrator.get("type") == "path":
            add(integrator, "integer", "max_depth", self.pick(2, 3, 4, 6, 8))
            if self.chance(0.4):
                add(integrator, "integer", "rr_depth", self.pick(1, 3, 50))
        if self.chance(0.2):
            add(integrator, "boolean", "hide_emitters", True)
        return integrator

    def sensor(self):
        kind = self.pick("perspective", "perspective", "perspective", "thinlens", "orthographic")
        sensor = plugin("sensor", kind)
        transform = ElementTree.SubElement(sensor, "transform", {"name": "to_world"})
        if kind == "orthographic":
            ElementTree.SubElement(transform, "scale", {"value": f"{self.number(1.0, 1.8):.4f}"})
        phi, height, distance = self.number(0, 2 * math.pi), self.number(-0.2, 0.9), self.number(3.0, 4.5)
        origin = (distance * math.cos(phi), distance * height, distance * math.sin(phi))
        target = [self.number(-0.2, 0.2) for _ in range(3)]
        ElementTree.SubElement(transform, "lookat", {"origin": text(origin), "target": text(target), "up": self.pick("0, 1, 0", "0.1, 1, 0")})
        if kind != "orthographic":
            add(sensor, "float", "fov", self.number(25.0, 55.0))
            if self.chance(0.3):
                add(sensor, "string", "fov_axis", self.pick("x", "y", "smaller", "larger", "diagonal"))
        if kind == "perspective" and self.chance(0.15):
            add(sensor, "float", "principal_point_offset_x", self.number(-0.2, 0.2))
        if kind == "thinlens":
            add(add(sensor, "float", "aperture_radius", self.number(0.02, 0.2)), "float", "focus_distance", self.number(2.5, 4.5))
        if self.chance(0.1):
            add(add(sensor, "float", "near_clip", self.number(0.05, 2.5)), "float", "far_clip", self.number(4.0, 9.0))
        film = add(add(plugin("film", "hdrfilm"), "integer", "width", WIDTH), "integer", "height", HEIGHT)
        add(add(film, "string", "pixel_format", "rgb"), "boolean", "sample_border", True)
        # Mitsuba's scalar variant has a wrong table of the gaussian filter.
        film.append(plugin("rfilter", "box" if self.chance(0.75) else "tent"))
        sensor.append(film)
        return sensor

    def scene(self):
        """The whole scene."""
        root = ElementTree.Element("scene", {"version": "3.0.0"})
        root.extend([self.integrator(), self.sensor()])
        if self.chance(0.7):
            ground = plugin("shape", "rectangle")
            transform = ElementTree.SubElement(ground, "transform", {"name": "to_world"})
            ElementTree.SubElement(transform, "rotate", {"x": "1", "angle": "-90"})
            ElementTree.SubElement(transform, "scale", {"value": "4"})
            ElementTree.SubElement(transform, "translate", {"y": "-0.9"})
            ground.append(self.bsdf() if self.chance(0.4) else self.opaque())
            root.append(ground)
        for _ in range(self.pick(1, 2, 3, 4)):
            root.append(self.shape())
        if self.chance(0.2):
            root.extend(self.group())
        has_environment, lamps, lights = self.chance(0.6), self.pick(0, 1, 1, 2), self.pick(0, 0, 1)
        if not has_environment and lamps + lights == 0:
            lamps = 1
        root.extend(self.lamp() for _ in range(lamps))
        root.extend(self.light() for _ in range(lights))
        if has_environment:
            root.append(self.environment())
        if any(bsdf.get("type") in ("mask", "null", "thindielectric") for bsdf in root.iter("bsdf")):
            _let_light_pass(root.find("integrator"))
        return root


def _let_light_pass(integrator):
    """Makes an integrator one whose shadow rays pass holes and thin glass, as Lodestar's do. It counts no surfaces that it passes."""
    integrator.set("type", "volpath")
    for depth in [child for child in integrator if child.get("name") == "max_depth"]:
        integrator.remove(depth)


def write(root, folder, name="scene.xml"):
    """Writes a scene beside its files, and returns its path."""
    path = pathlib.Path(folder) / name
    copy = ElementTree.fromstring(ElementTree.tostring(root))
    ElementTree.indent(copy)
    path.write_text(ElementTree.tostring(copy, encoding="unicode") + "\n")
    return path
