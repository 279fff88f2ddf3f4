"""Export: an evaluated scene as a Mitsuba XML file with its meshes and images in one folder."""

from __future__ import annotations

import copy
import hashlib
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Optional

from . import camera, falloff, hair, lights, materials, motion, suns, unsupported, volumes, world, xml
from .enclosures import Body, Box, Enclosures
from .grids import Grids
from .hashes import number_of_object
from .images import Images
from .instances import Shapes
from .meshes import Kept, Meshes, Part, Wanted
from .names import Names, id_of_part
from .nodes import Placed, Reader, Surroundings
from .report import Report
from .strands import Strands
from .volumes import Volume

SCENE_FILE = "scene.xml"
# Objects without a surface. That of a curve, a text or a metaball is an instance of its own, of the type MESH.
INVISIBLE = {"EMPTY", "ARMATURE", "LATTICE", "CAMERA", "LIGHT", "SPEAKER", "CURVE", "SURFACE", "FONT", "META", "LIGHT_PROBE"}
# Types of objects that Blender itself draws over the picture of any engine.
DRAWN = {"GREASEPENCIL", "GPENCIL"}


@dataclass
class Options:
    """Settings that the scene file holds."""

    max_depth: int = -1
    filter: str = "gaussian"


@dataclass
class Export:
    """What an export has written."""

    scene_file: Path
    report: Report
    film: camera.Film
    meshes_written: int
    names: Names = field(default_factory=Names)
    # Place of the camera in the middle of the time, and whether its rays are parallel.
    camera_place: Any = None
    is_orthographic: bool = False
    has_media: bool = False
    files: set[str] = field(default_factory=set)
    # Of all but the camera, where a viewport has asked for the export.
    digest: str = ""


@dataclass
class Viewed:
    """What a viewport shows of a scene."""

    # In place of the scene's camera.
    eye: Any
    # Whether it shows an instance of the depsgraph.
    shows: Callable[[Any], bool]
    kept: Kept


def export(depsgraph: Any, folder: Path, options: Options, frame_set: Optional[motion.FrameSet] = None) -> Export:
    """Writes a scene to `folder`. A `camera.Unsupported` says why it cannot be rendered. `frame_set` moves the scene in time."""
    exporter = _Exporter(depsgraph, folder, options)
    if depsgraph.scene.camera is None:
        raise camera.Unsupported("the scene has no camera")
    frame_set = frame_set or (lambda frame, subframe: depsgraph.scene.frame_set(frame, subframe=subframe))
    shutter = motion.shutter(depsgraph, frame_set, exporter.report)
    if shutter is None:
        return exporter.run()
    try:
        exporter.motions.record(shutter)
        return exporter.run()
    finally:
        shutter.close()


def export_view(depsgraph: Any, folder: Path, options: Options, viewed: Viewed) -> Export:
    """Writes a scene to `folder` as a viewport shows it, at one moment."""
    return _Exporter(depsgraph, folder, options, viewed).run()


class _Exporter:
    def __init__(self, depsgraph: Any, folder: Path, options: Options, viewed: Optional[Viewed] = None) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self.depsgraph, self.folder, self.options, self.viewed = depsgraph, folder, options, viewed
        self.report = Report()
        self.images = Images(folder, self.report)
        self.meshes = Meshes(folder, self.report, None if viewed is None else viewed.kept)
        self.names = Names()
        self.materials: dict[str, materials.Material] = {}
        # Ids of the materials by their keys.
        self.material_ids: dict[str, str] = {}
        self.parts: dict[Any, Any] = {}
        self.hair_files = hair.Files(self.meshes, self.report)
        self.hair_places = Kept()
        self.shapes = Shapes()
        self.enclosures = Enclosures(self.report)
        self.grid_files: set[str] = set()
        self.emitters: list[xml.Element] = []
        # Lamps for which points stand, with those points and the disks that may take their place.
        self.soft_lamps: list[tuple[falloff.SoftLamp, list[xml.Element], list[xml.Element]]] = []
        # Suns with an angle, and emitters of lamps that rays of surfaces do not find in Cycles.
        self.suns: list[suns.Sun] = []
        self.unfound: set[int] = set()
        # Names of the area lights among them.
        self.unfound_areas: list[str] = []
        self.surfaces_emit = self.has_glass = False
        # Whether the camera may see a surface or a lamp that emits.
        self.emits_in_view = False
        # A marker may bind another camera to another time of the shutter.
        self.camera = depsgraph.scene.camera if viewed is None else viewed.eye
        self.motions = motion.Motions(depsgraph, self.camera, self.report, self._strands_now)

    def run(self) -> Export:
        scene = self.depsgraph.scene_eval
        self.layer = self.depsgraph.view_layer_eval
        unsupported.report_scene(self.depsgraph, self.report)
        sensor, course = self._sensor(scene)
        for instance in self.depsgraph.object_instances:
            if self.viewed is None or self.viewed.shows(instance):
                self._instance(instance)
        environment = world.export(self._world(scene), self.images, self.report)
        self.enclosures.world = world.volume(self._world(scene), self.images, self.report)
        self.enclosures.show()
        around = self.enclosures.at(self.camera.matrix_world.translation, self.camera.name)
        if around is not None:
            xml.with_children(sensor, xml.ElementTree.Element("ref", {"id": around}))
        definitions = [self._definition(name) for name in self.materials]
        self._soften_lamps(definitions)
        hides = self._hides_emitters(scene, environment)
        environment = self._with_suns(scene, environment, definitions, hides, is_still=not course.keys)
        media = self.enclosures.elements
        integrator = xml.add(xml.plugin("integrator", "volpath" if media else "path"), "max_depth", self.options.max_depth)
        if media and self.options.max_depth >= 0:
            self.report.warn("scene", f"each scattering in a volume is one of the {self.options.max_depth} edges of a path")
        if hides:
            xml.add(integrator, "hide_emitters", True)
        root = xml.ElementTree.Element("scene", {"version": "3.0.0"})
        definitions = [*self.images.graph.elements(self.images.used_programs), *definitions]
        xml.with_children(root, *media, integrator, sensor, *definitions, *self.shapes.elements(len(self.materials)), *self.emitters)
        if environment is not None:
            xml.with_children(root, environment)
        exposure = float(getattr(getattr(scene, "cycles", None), "film_exposure", 1.0))
        if exposure != 1.0:
            for element in (*root.iter("emitter"), *root.iter("medium")):
                _brighten(element, exposure)
        self._report_light_through_surfaces()
        path = self.folder / SCENE_FILE
        with path.open("w", encoding="utf-8") as file:
            head, end, rest = xml.text_of(root).rpartition("</scene>")
            file.write(head)
            file.writelines(self.shapes.lines())
            file.write(end + rest)
        files = self.meshes.used | self.images.used | self.grid_files
        _remove_unused(self.folder, files)
        digest = "" if self.viewed is None else self._digest(each for each in root if each is not sensor)
        return Export(path, self.report, camera.film(scene.render), self.meshes.written, **self._for_compositing(), files=files, digest=digest)

    def _for_compositing(self) -> dict[str, Any]:
        """What an export says besides, for passes of what the camera sees first."""
        if self.viewed is not None:
            return {}
        place, is_orthographic = camera.place(self.camera), self.camera.data.type == "ORTHO"
        return {"names": self.names, "camera_place": place, "is_orthographic": is_orthographic, "has_media": bool(self.enclosures.elements)}

    def _sensor(self, scene: Any) -> tuple[xml.Element, xml.Course]:
        """`<sensor>`, and the course of the camera."""
        if self.viewed is not None:
            self.projection = self.camera.projection
            return self.camera.sensor(self.options.filter), xml.Course(self.camera.matrix_world)
        self.camera = self.camera.evaluated_get(self.depsgraph)
        course = self.motions.course(motion.CAMERA, self.camera.matrix_world, f'camera "{self.camera.name}"')
        sensor = camera.export(self.camera, course, scene, self.options.filter, self.report)
        if self.motions:
            xml.add(xml.add(sensor, "shutter_open", 0.0), "shutter_close", 1.0)
        self.projection = camera.projection(self.camera, scene, self.depsgraph)
        return sensor, course

    def _digest(self, elements: Iterable[xml.Element]) -> str:
        """Digest of elements and of all instances."""
        digest = hashlib.blake2b(digest_size=16)
        for each in elements:
            digest.update(xml.ElementTree.tostring(each))
        for line in self.shapes.lines():
            digest.update(line.encode())
        return digest.hexdigest()

    # ----------------------------------------------------------------------------------------------- instances

    def _instance(self, instance: Any) -> None:
        owner = instance.object
        if hair.shows_hair(instance, self.layer):
            self._hair(instance)
        if not instance.show_self:
            return
        if owner.type == "LIGHT":
            self._light(owner, self._course(instance))
        elif owner.type == "MESH" and self.layer.use_solid:
            course = self._course(instance)
            number = instance.random_id if instance.is_instance else number_of_object(owner.name)
            by = instance.parent if instance.is_instance else None
            self._surface(Placed(owner, course.matrix, number), course, by)
        elif owner.type == "VOLUME" and self.layer.use_volumes:
            self._volume(owner, instance.matrix_world.copy())
        elif owner.type not in (*INVISIBLE, *DRAWN) and owner.type not in ("MESH", "VOLUME", "CURVES"):
            self.report.warn(f'object "{owner.name}"', f"objects of the type {owner.type} are not supported; it is left out")

    def _name(self, owner: Any) -> Optional[str]:
        """Name of an object for compositors; None in a viewport, which has none."""
        return self.names.of_object(owner) if self.viewed is None else None

    def _course(self, instance: Any) -> xml.Course:
        matrix = instance.matrix_world.copy()
        if not self.motions:
            return xml.Course(matrix)
        return self.motions.course(motion.identity(instance), matrix, f'object "{instance.object.name}"')

    def _light(self, owner: Any, course: xml.Course) -> None:
        if owner.data.type == "AREA" and getattr(getattr(owner.data, "cycles", None), "is_portal", False):
            # A portal says where light comes in, and sheds none.
            return
        emitters = lights.export(owner.data, course, owner.name, self.report)
        unsupported.report_object(owner, self.report)
        self.emitters.extend(emitters)
        if not lights.is_found(owner.data):
            self.unfound.update(map(id, emitters))
            if owner.data.type == "AREA":
                self.unfound_areas.append(owner.name)
        sun = suns.sun(owner.data, course.matrix, emitters)
        if sun is not None:
            self.suns.append(sun)
            if owner.visible_camera and suns.is_in_view(sun, self.camera, self.depsgraph.scene_eval):
                self.report.warn(f'light "{owner.name}"', "a sun that the camera sees is not supported; it lights the scene alone")
        soft = falloff.soft_lamp(owner, course.matrix.translation)
        if soft is not None and emitters:
            self.soft_lamps.append((soft, emitters, lights.disks(owner.data, course, owner.name, self.report)))
        surfaces = [emitter for emitter in emitters if emitter.tag == "shape"]
        if owner.visible_camera:
            self.surfaces_emit |= bool(surfaces)
            self.emits_in_view |= bool(surfaces) and self._may_see(course, lights.corners(owner.data))
        else:
            lights.hide(surfaces)

    def _may_see(self, course: xml.Course, corners: Any) -> bool:
        """Whether the camera may see what lies within some corners, if nothing hides it."""
        from mathutils import Vector

        if self.viewed is not None or course.keys or self.motions:
            return True
        places = [course.matrix @ Vector(corner) for corner in corners]
        return camera.may_see(self.camera, self.depsgraph.scene_eval, places, 0.5 if self.camera.data.dof.use_dof else 0.1)

    def _soften_lamps(self, definitions: list[xml.Element]) -> None:
        """Replaces the points of lamps by disks, where a surface is so near that the soft falloff shows, and no mirror would show the disks."""
        lamps = [lamp for lamp, _, _ in self.soft_lamps]
        near = falloff.near_surfaces(lamps, self.depsgraph.object_instances)
        has_mirror = any(falloff.is_mirror(bsdf) for each in definitions for bsdf in each.iter("bsdf"))
        for name in self.unfound_areas if has_mirror else ():
            self.report.warn(f'light "{name}"', "an area light without Multiple Importance is not supported; mirrors show it")
        replaced: set[int] = set()
        for lamp, points, disks in self.soft_lamps:
            if lamp.name in near and has_mirror:
                self.report.warn(f'light "{lamp.name}"', falloff.warning(near[lamp.name]))
            elif lamp.name in near:
                replaced.update(map(id, points))
                self.emitters += disks
        self.emitters = [each for each in self.emitters if id(each) not in replaced]

    def _surface(self, placed: Placed, course: xml.Course, instancer: Optional[Any]) -> None:
        """Shows an object, which an instancer shows or none. Rays do not see what is invisible to them by either."""
        owner = placed.owner
        unsupported.report_object(owner, self.report)
        if instancer is not None:
            unsupported.report_object(instancer, self.report)
        is_unseen = not owner.visible_camera or not getattr(instancer, "visible_camera", True)
        name = self._name(owner)
        keys = [self._material(material, placed) for material in self._materials_of(owner)]
        if course.keys and any(self.materials[key].asks_for_object for key in keys):
            message = "its material asks for its place, and has that of the middle of the time in which the shutter is open"
            self.report.warn(f'object "{owner.name}"', message)
        if not is_unseen and any(self.materials[key].emission is not None for key in keys):
            self.emits_in_view |= self._may_see(course, owner.bound_box)
        parts = self._mesh_parts(owner, keys, is_kept=instancer is None)
        if any(self.materials[keys[part.slot]].is_fiber for part in parts):
            message = "Principled Hair on a mesh without strands is not supported; each face is the side of a fiber, which differs from Cycles"
            self.report.warn(f'object "{owner.name}"', message)
        shown = tuple((file, keys[part.slot], is_unseen) for part in parts for file in part.files)
        volume = self._volume_within(owner, keys)
        is_boundary = volume is not None or any(self.materials[key].below is not None for key in keys)
        region = self.enclosures.region(owner) if is_boundary else None
        if region is None:
            self.shapes.add((shown, ()), course, lambda: [self._shape(*each) for each in shown], name)
            return
        if is_unseen:
            self.report.warn(f'object "{owner.name}"', unsupported.UNSEEN_VOLUME)
            shown = tuple((file, key, False) for file, key, _ in shown)

        def show(around: Volume) -> None:
            sides = {key: self._sides(key, around, body) for _, key, _ in shown}
            media = tuple(tuple(side.items()) for _, key, _ in shown for side in sides[key])
            build = lambda: [xml.with_children(self._shape(*each), *copy.deepcopy(sides[each[1]])) for each in shown]  # noqa: E731
            self.shapes.add((shown, media), course, build, name)

        body = Body(owner.name, region, course.matrix, volume, show)
        self.enclosures.bodies.append(body)

    def _hair(self, instance: Any) -> None:
        """Shows the strands of an object."""
        owner, by = instance.object, instance.parent if instance.is_instance else None
        course = self._course(instance)
        unsupported.report_object(owner, self.report)
        if self.depsgraph.scene.render.use_motion_blur and hair.is_dynamic(owner):
            self.report.warn(f'object "{owner.name}"', "hair that moves by itself while the shutter is open is not supported; it moves with the object")
        is_unseen = not owner.visible_camera or not getattr(by, "visible_camera", True)
        number = instance.random_id if instance.is_instance else number_of_object(owner.name)
        placed = Placed(owner, course.matrix, number, has_strands=True)
        # Strands that stand in one place are round there.
        stretch = hair.stretch(course.matrix) if by is None and not course.keys else None
        shown = []
        for group in self._strands(owner):
            slots = self._materials_of(owner)
            key = self._material(slots[min(group.slot, len(slots) - 1)], placed)
            is_open = hair.is_open(group, self.materials[key], owner.type == "CURVES" or not instance.show_self)
            shown.append(((self._strand_file(owner, group, key, stretch), key, is_unseen), not is_open))
        if shown:
            build = lambda: [xml.add(self._shape(*each), "front_only", is_front) for each, is_front in shown]  # noqa: E731
            self.shapes.add((tuple(shown), "strands"), course, build, self._name(owner))

    def _strands(self, owner: Any) -> list[Strands]:
        """Strands of an object. Instances of one object share them."""
        key = "strands", owner.original.as_pointer(), owner.data.as_pointer()
        if key not in self.parts:
            kept = self.hair_places if self.viewed is None else self.viewed.kept
            self.parts[key] = hair.groups(owner, self.depsgraph.mode == "RENDER", self.depsgraph.scene, kept)
            self.motions.move_strands(owner, self.parts[key])
        return self.parts[key]

    def _strands_now(self, instance: Any, time: float) -> Optional[list[Strands]]:
        """Strands that an instance shows at the time of the shutter that the scene is at; None where they are not looked at."""
        if not hair.shows_hair(instance, self.depsgraph.view_layer_eval) or hair.is_dynamic(instance.object):
            return None
        # Points of the middle of the time are looked up once.
        kept = self.hair_places if time == 0.5 else None
        return hair.groups(instance.object, self.depsgraph.mode == "RENDER", self.depsgraph.scene, kept)

    def _strand_file(self, owner: Any, group: Strands, key: str, stretch: Any) -> str:
        material = self.materials[key]
        wanted = hair.wanted(material)
        known = "strands", id(group), wanted, None if stretch is None else stretch.tobytes()
        if known not in self.parts:
            self.parts[known] = self.hair_files.write(group, wanted, f'object "{owner.name}"', stretch)
        return self.parts[known]

    def _materials_of(self, owner: Any) -> list[Any]:
        """Materials of an object's slots."""
        override = self.layer.material_override
        return [override] if override is not None else [slot.material for slot in owner.material_slots] or [None]

    def _volume_within(self, owner: Any, keys: list[str]) -> Optional[Volume]:
        """Volume of an object's materials; None where no side of its surfaces needs a medium."""
        materials_ = (self.materials[key] for key in keys)
        used = [each for each in materials_ if each.volume is not None and not each.volume.is_empty]
        if not used:
            return None
        if used[0].asks_for_smoke and any(modifier.type == "FLUID" and modifier.fluid_type == "DOMAIN" for modifier in owner.modifiers):
            message = "smoke of a fluid domain is not supported; its volume is left out. Export it as a .vdb file for a Volume object"
            self.report.warn(f'object "{owner.name}"', message)
            return None
        return used[0].volume

    def _sides(self, key: str, around: Volume, body: Body) -> list[xml.Element]:
        """References to the media on the sides of a surface of a body."""
        below = self.materials[key].below
        if below is not None:
            return self.enclosures.sides(below, around, body.size)
        own = self.materials[key].volume
        if own is None or own.is_empty:
            return []
        within = around.plus(own, lambda message: self.report.warn(f'object "{body.name}"', message))
        return self.enclosures.sides(within, around, body.size)

    def _volume(self, owner: Any, matrix: Any) -> None:
        """Volume object: a box with the medium of its grids."""
        from mathutils import Matrix, Vector

        grids = Grids(owner, matrix, self.folder, self.grid_files, self.report)
        if grids.box is None:
            return
        unsupported.report_object(owner, self.report)
        if not owner.visible_camera:
            self.report.warn(f'object "{owner.name}"', unsupported.UNSEEN_VOLUME)
        volume = self._volume_of_grids(owner, grids)
        if owner.data.render.space == "OBJECT":
            # As in Cycles, a larger object is less dense.
            volume = volume.scaled(1.0 / max((matrix.to_3x3() @ Vector((1.0, 1.0, 1.0))).length / math.sqrt(3.0), 1e-9))

        def show(around: Volume) -> None:
            within = around.plus(volume, lambda message: self.report.warn(f'object "{name}"', message))
            cube = xml.with_children(xml.plugin("shape", "cube"), xml.plugin("bsdf", "null"))
            xml.with_children(cube, *self.enclosures.sides(within, around, body.size))
            place = grids.box @ Matrix.Translation((0.5, 0.5, 0.5)) @ Matrix.Diagonal((0.5, 0.5, 0.5, 1.0))
            self.shapes.add(("volume", len(self.enclosures.bodies), id(volume)), xml.Course(place), lambda: [cube])

        name = owner.name
        body = Body(name, Box(), grids.box, volume, show)
        self.enclosures.bodies.append(body)

    def _volume_of_grids(self, owner: Any, grids: Grids) -> Volume:
        material = next((slot.material for slot in owner.material_slots if slot.material is not None), None)
        if material is None or material.node_tree is None:
            # Cycles' default: a Principled Volume.
            return Volume((0.5,) * 3, ((volumes.ISOTROPIC, (0.5,) * 3),), density=grids.named("density"))
        output = material.node_tree.get_output_node("CYCLES") or material.node_tree.get_output_node("ALL")
        reader = Reader(f'material "{material.name}"', self.report, self.images)
        return (output and volumes.translate(reader, output.inputs["Volume"], grids)) or Volume()

    def _mesh_parts(self, owner: Any, keys: list[str], is_kept: bool) -> list[Part]:
        """Files of an object's mesh. Instances of one object or mesh share them."""
        used = [self.materials[key] for key in keys]
        wanted = [Wanted(m.uv_map, m.color_attribute, m.emission is not None) for m in used]
        key = (owner.data.as_pointer(), tuple(wanted))
        if key not in self.parts:
            self.parts[key] = self.meshes.export(owner, wanted, is_kept, self.motions.vertices(owner))
        return self.parts[key]

    def _shape(self, file: str, key: str, is_unseen: bool) -> xml.Element:
        """Mesh of a file with its material, without a place, which the camera may not see."""
        material = self.materials[key]
        self.has_glass |= material.is_glass
        self.surfaces_emit |= material.emission is not None and not is_unseen
        shape = xml.add(xml.plugin("shape", "ply"), "filename", file)
        if is_unseen:
            lights.hide([shape])
        xml.with_children(shape, xml.ElementTree.Element("ref", {"id": self.material_ids[key]}))
        if material.emission is not None:
            xml.with_children(shape, copy.deepcopy(material.emission))
        return shape

    # ----------------------------------------------------------------------------------------------- materials

    def _material(self, material: Optional[Any], placed: Placed) -> str:
        """Key of a material. One that asks for its object has a key for each place of each object, one that asks for the object's scale has
        one for each scale, and one that asks for strands has one for them."""
        key = "no material" if material is None else f"material {material.name_full}"
        scaled = f"{key} scaled by {sum(abs(scale) for scale in placed.matrix.to_scale()) / 3.0:.5g}"
        of = " of strands" if placed.has_strands else ""
        for known in (key + of, scaled + of, key, scaled):
            if known in self.materials and (known.endswith(of) or not self.materials[known].asks_for_strands):
                return known
        own = f"{key} of {placed.owner.name_full} {placed.random_id} {hash(tuple(map(tuple, placed.matrix))):x}{of}"
        if own not in self.materials:
            surroundings = Surroundings(placed, self.camera, self.projection)
            found = materials.translate(material, self.images, self.report, surroundings)
            if not found.asks_for_object:
                own = (scaled if found.asks_for_scale else key) + (of if found.asks_for_strands or found.layout is not None else "")
            self.materials[own] = found
            self.material_ids[own] = id_of_part(self.names.of_material(material), len(self.materials))
        return own

    def _definition(self, key: str) -> xml.Element:
        bsdf = self.materials[key].bsdf
        assert bsdf is not None
        bsdf.set("id", self.material_ids[key])
        return bsdf

    # ---------------------------------------------------------------------------------------------- whole scene

    def _world(self, scene: Any) -> Any:
        """World of the view layer, which may leave it out or have one of its own."""
        return (getattr(self.layer, "world_override", None) or scene.world) if self.layer.use_sky else None

    def _hides_emitters(self, scene: Any, environment: Optional[xml.Element]) -> bool:
        """Whether the camera sees no emitter: where the film is transparent, or there are lamps alone that it does not see."""
        if scene.render.film_transparent and self.emits_in_view:
            self.report.warn("scene", "with a transparent film, surfaces and lamps that emit are invisible to the camera")
        return scene.render.film_transparent or (environment is None and not self.surfaces_emit)

    def _with_suns(
        self, scene: Any, environment: Optional[xml.Element], definitions: list[xml.Element], hides: bool, is_still: bool
    ) -> Optional[xml.Element]:
        """Environment with the suns, where surfaces show them, it has one color, and the camera does not see the suns. One that moves might."""
        shows = self.has_glass or any(falloff.is_mirror(bsdf) for each in definitions for bsdf in each.iter("bsdf"))
        color = world.constant_color(environment)
        if not self.suns or not shows or color is None:
            return environment
        if not hides and (not is_still or any(suns.is_in_view(sun, self.camera, scene) for sun in self.suns)):
            return environment
        moved = {id(emitter) for sun in self.suns for emitter in sun.emitters}
        self.emitters = [each for each in self.emitters if id(each) not in moved]
        return world.of_picture(self.images.written(suns.picture(color, self.suns)))

    def _report_light_through_surfaces(self) -> None:
        # In Cycles, too, a lamp without size or without Multiple Importance is not found through glass. The parts of a lamp that has a size have weights.
        found = [each for each in self.emitters if id(each) not in self.unfound]
        weights = [float(child.get("value", "1")) for each in found for child in each if child.get("name") == "sampling_weight"]
        if self.has_glass and any(weight < 1.0 for weight in weights):
            message = "light of suns with an angle, and of lamps for which points stand, does not pass glass"
            self.report.warn("scene", message)


def _brighten(emitter: xml.Element, factor: float) -> None:
    """Multiplies the light of an emitter or a medium, as a film's exposure does."""
    for at, child in enumerate(list(emitter)):
        name = child.get("name")
        if name not in ("radiance", "intensity", "irradiance", "scale", "emission"):
            continue
        if child.tag == "texture":
            scale = xml.add(xml.plugin("texture", "scale", name), "scale", factor)
            del child.attrib["name"]
            emitter[at] = xml.with_children(scale, child)
        else:
            child.set("value", " ".join(xml.number(float(value) * factor) for value in child.get("value", "").split()))


def _remove_unused(folder: Path, used: set[str]) -> None:
    """Removes meshes and images of earlier exports."""
    for pattern in ("mesh-*.ply", "mesh-*.part", "image-*.exr", "image-*.png", "grid-*.vol", "grid-*.part"):
        for path in folder.glob(pattern):
            if path.name not in used:
                path.unlink(missing_ok=True)
