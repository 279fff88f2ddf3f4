"""Hair of particle systems and hair curves, beside Cycles and as arrays."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import bpy
import hair_scenes
import numpy as np
import pytest
import scenes
import support
from lodestar import export, strands, tubes
from lodestar.hashes import lookup3
from lodestar.meshes import Kept

# Blender before 5 shows polylines as splines.
SCENES = [name for name in hair_scenes.ALL if name != "polylines" or bpy.app.version >= (5, 0, 0)]


def pictures(scene: Any, name: str, samples: int = 256) -> tuple[np.ndarray, np.ndarray]:
    """Cycles' picture and Lodestar's."""
    return tuple(support.colors(support.render(scene, engine, samples, name)) for engine in ("CYCLES", "LODESTAR"))  # type: ignore[return-value]


def exported(folder: Path) -> export.Export:
    return export.export(bpy.context.evaluated_depsgraph_get(), folder, export.Options())


@pytest.mark.parametrize("name", SCENES)
def test_agrees_with_cycles(name: str) -> None:
    theirs, ours = pictures(hair_scenes.ALL[name](), name)
    found, ratio = support.deviation(ours, theirs), support.mean_ratio(ours, theirs)
    print(f"{name}: largest deviation {found:.4f}, ratio of means {ratio:.4f}")
    assert found < 0.03 and abs(ratio - 1.0) < 0.01


@pytest.mark.parametrize(
    "parametrization,inputs",
    [
        ("COLOR", dict(Color=(0.6, 0.3, 0.1))),
        ("COLOR", dict(Color=(0.6, 0.3, 0.1), Offset=0.3, Roughness=0.15)),
        ("MELANIN", dict(Melanin=0.2, Melanin_Redness=0.4, Tint=(0.9, 0.5, 0.3))),
        ("MELANIN", dict(Melanin=0.3, Melanin_Redness=0.4, Random_Color=0.8, Random_Roughness=0.5)),
        ("ABSORPTION", dict(Absorption_Coefficient=(0.2, 0.5, 1.0), Roughness=0.2, Radial_Roughness=0.6)),
    ],
    ids=["color", "offset", "melanin", "by chance", "absorption"],
)
def test_fibers_agree_with_cycles(parametrization: str, inputs: dict[str, Any]) -> None:
    """Principled Hair. That its scales turn the other way is found."""
    theirs, ours = pictures(hair_scenes.fibers(parametrization, **inputs), "fibers")
    found, ratio = support.deviation(ours, theirs), support.mean_ratio(ours, theirs)
    print(f"{parametrization}: largest deviation {found:.4f}, ratio of means {ratio:.4f}")
    assert found < 0.03 and abs(ratio - 1.0) < 0.01
    if "Offset" in inputs:
        turned = support.colors(support.render(hair_scenes.fibers(parametrization, **{**inputs, "Offset": -inputs["Offset"]}), "LODESTAR", 256, "turned"))
        assert support.deviation(turned, theirs) > 0.03


def test_other_hair_is_named(tmp_path: Path) -> None:
    """The model Huang and the older node are rendered as others, and a coat is left out."""
    for kind, words in (("HUANG", "model Huang"), ("COAT", "coat"), ("OLD", "a diffuse surface of its color")):
        scene = hair_scenes.fibers("COLOR", Color=(0.6, 0.3, 0.1))
        surface = scene.objects["fibers"].data.materials[0]
        node = next(each for each in surface.node_tree.nodes if each.type == "BSDF_HAIR_PRINCIPLED")
        if kind == "HUANG":
            if not hasattr(node, "model"):
                continue
            node.model = kind
        elif kind == "COAT":
            node.inputs["Coat"].default_value = 0.5
        else:
            scene.objects["fibers"].data.materials[0] = scenes.simple("old", "ShaderNodeBsdfHair", Color=(0.6, 0.3, 0.1))
        warnings = exported(tmp_path).report.warnings
        assert len(warnings) == 1 and words in warnings[0], warnings


def test_hair_shaders_on_meshes_are_named(tmp_path: Path) -> None:
    """A mesh with a fiber's material, but not one that only gives it to its strands."""
    scene = hair_scenes.fibers("COLOR", Color=(0.6, 0.3, 0.1))
    fiber = scene.objects["fibers"].data.materials[0]
    ground = scenes.plane(scene, "ground", 1.0, scenes.diffuse("gray", (0.5, 0.5, 0.5)))
    ground.data.materials.append(fiber)
    hair_scenes.furry(ground, 10, 0.3, material=2)
    assert exported(tmp_path / "strands").report.warnings == []
    ground.data.polygons[0].material_index = 1
    warnings = exported(tmp_path / "mesh").report.warnings
    assert len(warnings) == 1 and warnings[0].startswith('object "ground": Principled Hair on a mesh'), warnings


def test_twin_thinner_strands_are_found() -> None:
    """The comparison finds strands that are a fifth thinner."""
    scene = hair_scenes.textured()
    theirs = support.colors(support.render(scene, "CYCLES", 256, "twin"))
    scene.objects["ground"].particle_systems[0].settings.radius_scale *= 0.8
    ours = support.colors(support.render(scene, "LODESTAR", 256, "twin"))
    assert support.deviation(ours, theirs) > 0.03


def test_nothing_is_left_out(tmp_path: Path) -> None:
    """Scenes of hair export without a warning."""
    for name in SCENES:
        hair_scenes.ALL[name]()
        assert not exported(tmp_path).report.warnings, name


@pytest.mark.parametrize("kind,files", [("PATH", 2), ("NONE", 1), ("OBJECT", 1)])
def test_only_paths_are_strands(tmp_path: Path, kind: str, files: int) -> None:
    scene = hair_scenes.lit()
    ground = scenes.plane(scene, "ground", 3.0, scenes.diffuse("gray", (0.5, 0.5, 0.5)))
    hair_scenes.furry(ground, 5, 0.5, render_type=kind)
    assert len(exported(tmp_path).files) == files


def test_a_view_layer_may_leave_hair_out(tmp_path: Path) -> None:
    hair_scenes.hair_curves().view_layers[0].use_strand = False
    assert len(exported(tmp_path).files) == 1


def test_instances_of_strands_share_a_file(tmp_path: Path) -> None:
    hair_scenes.instances()
    found = exported(tmp_path)
    # The floor, the ball, its strands and the hair curves.
    assert len(found.files) == 4 and found.scene_file.read_text().count('name="front_only"') == 2


def test_thick_open_strands_are_seen_from_inside(tmp_path: Path) -> None:
    """As in Cycles on processors. Light meets thin strands, and those that are closed at their tips and have roots in a surface, from outside."""
    for thickness, tip, has_inside in ((0.08, 0.5, True), (0.08, 0.0, False), (0.01, 0.5, False)):
        scene = hair_scenes.lit()
        ground = scenes.plane(scene, "ground", 3.0, scenes.diffuse("gray", (0.5, 0.5, 0.5)))
        hair_scenes.furry(ground, 5, 0.5, radius_scale=thickness, tip_radius=tip, use_close_tip=tip == 0.0)
        assert ('name="front_only" value="false"' in exported(tmp_path).scene_file.read_text()) == has_inside


def test_strands_without_a_surface_are_left_out(tmp_path: Path) -> None:
    """Strands without length or thickness, of which some may be all."""
    scene = hair_scenes.lit()
    gray = scenes.diffuse("gray", (0.5, 0.5, 0.5))
    still, thin, good = np.zeros((3, 3)), hair_scenes.bent(1)[0], hair_scenes.bent(1)[0]
    radii = [np.full(3, 0.1), np.zeros(len(thin)), np.full(len(good), 0.1)]
    hair_scenes.curves(scene, "one", [still, thin, good], radii, gray)
    hair_scenes.curves(scene, "none", [still, thin], radii[:2], gray)
    assert len(exported(tmp_path).files) == 1


def test_a_viewport_looks_points_up_once() -> None:
    """Points of strands are kept until their object has another shape."""
    scene = hair_scenes.lit()
    ground = scenes.plane(scene, "ground", 3.0, scenes.diffuse("gray", (0.5, 0.5, 0.5)))
    kept, asked = Kept(), []
    look_up = lambda: asked.append(1) or np.zeros((1, 2, 3))  # noqa: E731
    for _ in range(2):
        kept.places(ground, "hair", look_up)
        kept.drop_others()
    assert len(asked) == 1
    kept.forget({scene.camera.session_uid})
    kept.places(ground, "hair", look_up)
    assert len(asked) == 1
    kept.forget({ground.session_uid})
    kept.places(ground, "hair", look_up)
    assert len(asked) == 2


# ------------------------------------------------------------------------------------------------------------------ tubes


def spline(count: int, radius: float, points: int = 9) -> tubes.Splines:
    """Strands that are bent, whose radius falls to 0."""
    generator = np.random.default_rng(1)
    z = np.linspace(0.0, 1.0, points)
    made = np.zeros((count, points, 4))
    made[:, :, :3] = generator.random((count, 1, 3))
    made[:, :, 0] += generator.normal(size=(count, 1)) * 0.3 * z**2
    made[:, :, 2] += z
    made[:, :, 3] = radius * (1.0 - z)
    return tubes.Splines(made.reshape(-1, 4), np.full(count, points))


@pytest.mark.parametrize("sides", tubes.SIDES)
def test_rings_have_the_radius_on_average(sides: int) -> None:
    corner, half = tubes._corner(sides), math.pi / sides
    angles = half * (np.arange(1000) + 0.5) / 1000.0
    assert abs(np.mean(corner * math.cos(half) / np.cos(angles)) - 1.0) < 1e-5


def test_tubes_lie_on_their_splines() -> None:
    """Corners are at their distance from the spline, normals point outward and agree with the triangles."""
    found = spline(20, 0.05)
    quality = found.quality()
    rings = found.rings(quality)
    made = tubes.mesh(rings, tubes.frames(rings), quality.sides, has_seam=False)
    segment = found.first_segments[made.strand] + made.segment
    point, first, _ = found.at(segment, made.u)
    outward = made.positions - point[:, :3]
    distance = np.linalg.norm(outward, axis=1)
    assert np.abs(distance - tubes._corner(quality.sides) * np.maximum(point[:, 3], 0.0)).max() < 1e-9
    assert np.abs(np.sum(outward * first[:, :3], axis=1)).max() < 1e-9
    assert (np.sum(outward * made.normals, axis=1) >= 0.0).all() and np.abs(np.linalg.norm(made.normals, axis=1) - 1.0).max() < 1e-9
    a, b, c = (made.positions[made.triangles[:, corner]] for corner in range(3))
    facing = np.sum(np.cross(b - a, c - a) * made.normals[made.triangles].sum(axis=1), axis=1)
    assert (facing > 0.0).all()


def test_tubes_are_as_fine_as_all_their_times_need() -> None:
    """A strand that is straight at first and bends later has the rings of the bent one, and one that grows a tip has the tip's triangles."""
    z = np.linspace(0.0, 1.0, 9)
    straight = tubes.Splines(np.stack([0 * z, 0 * z, z, 0 * z + 0.01], axis=1), np.array([9]))
    bent = tubes.Splines(np.stack([np.sin(3.0 * z), 0 * z, z, 0 * z + 0.01], axis=1), np.array([9]))
    assert straight.quality().pieces[0] < bent.quality().pieces[0] <= straight.quality(bent).pieces[0]
    quality = straight.quality(bent)
    rings = bent.rings_like(straight.rings(quality))
    middle, _, _ = bent.at(rings.segment[:-1] + 0, 0.5 * (rings.u[:-1] + np.where(rings.segment[1:] == rings.segment[:-1], rings.u[1:], 1.0)))
    chord = 0.5 * (rings.center[1:] + rings.center[:-1])
    same = rings.segment[1:] == rings.segment[:-1]
    assert np.linalg.norm(middle[same, :3] - chord[same], axis=1).max(initial=0.0) < 0.01


def test_tubes_that_move_do_not_twist() -> None:
    """Vertices of splines that turn as a whole turn with them, but for a small twist, and have the radius."""
    found = spline(20, 0.05)
    quality = found.quality()
    rings = found.rings(quality)
    across = tubes.frames(rings)
    angle = 0.4
    turn = np.array([[1, 0, 0], [0, math.cos(angle), -math.sin(angle)], [0, math.sin(angle), math.cos(angle)]])
    moved = tubes.Splines(np.column_stack([found.points[:, :3] @ turn.T, found.points[:, 3]]), found.counts).rings_like(rings)
    assert np.abs(moved.center - rings.center @ turn.T).max() < 1e-12
    first, second = (tubes.mesh(*each, quality.sides, has_seam=False) for each in ((rings, across), (moved, tubes.frames_like(across, moved))))
    assert np.array_equal(first.triangles, second.triangles)
    distance = np.linalg.norm(second.positions - first.positions @ turn.T, axis=1)
    assert distance.max() < 0.1 * 0.05
    # The twin: frames that begin anew.
    anew = tubes.mesh(moved, -tubes.frames(moved), quality.sides, has_seam=False)
    assert np.linalg.norm(anew.positions - first.positions @ turn.T, axis=1).max() > 0.05


@pytest.mark.parametrize("count", [1, 2000, 100_000])
def test_many_strands_have_fewer_triangles_each(count: int) -> None:
    """All numbers are finite, straight lines stay near the strands, and there are as many triangles as were counted, but for the tips."""
    found = spline(count, 0.003)
    quality = found.quality()
    assert quality.triangles <= max(tubes.MANY_TRIANGLES, tubes.MANY_OF_A_STRAND * count) and quality.is_coarse == (count > 10_000)
    rings = found.rings(quality)
    assert (np.bincount(rings.strand) == quality.pieces + 1).all()
    made = tubes.mesh(rings, tubes.frames(rings), quality.sides, has_seam=False)
    assert np.isfinite(made.positions).all() and np.isfinite(made.normals).all()
    # The ring of a tip is a point.
    assert len(made.triangles) == quality.triangles - count * quality.sides and made.triangles.max() < len(made.positions)
    is_piece = (rings.strand[1:] == rings.strand[:-1]) & (rings.segment[1:] == rings.segment[:-1])
    on_spline, _, _ = found.at((found.first_segments[rings.strand] + rings.segment)[:-1], 0.5 * (rings.u[1:] + rings.u[:-1]))
    coarseness = (tubes.SIDES_OF_THIN / quality.sides) ** 2
    begin, step = rings.center[:-1], np.diff(rings.center, axis=0)
    off = (np.linalg.norm(np.cross(on_spline[:, :3] - begin, step), axis=1) / np.linalg.norm(step, axis=1))[is_piece]
    assert off.max(initial=0.0) < 1.5 * coarseness * tubes.SAG_OF_LENGTH * found.lengths.max()


def test_places_are_asked_for_once() -> None:
    """The points of 3,000 strands are looked up once each."""

    class System:
        asked = 0

        def co_hair(self, owner: Any, particle_no: int, step: int) -> Any:
            self.asked += 1
            return (particle_no, step, 1.0) if step < 3 else (0.0, 0.0, 0.0)

    scene = hair_scenes.lit()
    owner, system = scene.objects["area"], System()
    owner.matrix_world.identity()
    owner.location, owner.rotation_euler = (0, 0, 0), (0, 0, 0)
    bpy.context.view_layer.update()
    places = strands._places(system, owner, 10, 3000, 5)
    assert system.asked == 15_000 and places.shape == (3000, 5, 3)
    # Beyond its end, a strand stays there.
    assert (places[:, 3] == places[:, 2]).all() and (places[:, 2, 1] == 2.0).all() and places[7, 0, 0] == 17.0


def test_numbers_by_chance_are_those_of_cycles() -> None:
    """Hashes of the strand's number and 0, alike for one number and for an array."""
    made = strands.Strands(np.zeros((4, 4)), np.array([2, 2]), 0, False, np.array([0, 1]), None)
    assert np.allclose(made.randoms(), [lookup3(0, 0) / 0xFFFFFFFF, lookup3(1, 0) / 0xFFFFFFFF])


def test_polylines_are_hulls_of_spheres() -> None:
    """Corners of a bent polyline with ends lie near the spheres and cones, none inside, and the length is that of the ends, too."""
    points = np.array([[0, 0, 0, 0.1], [0, 0, 1, 0.1], [1, 0, 1, 0.1]], float)
    found = tubes.Polylines(points, np.array([3]))
    quality = found.quality()
    rings = found.rings(quality)
    made = tubes.mesh(rings, tubes.frames(rings), quality.sides, has_seam=False)

    def distance(p: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        share = np.clip((p - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
        return np.linalg.norm(p - a - share[:, None] * (b - a), axis=1)

    near = np.minimum(distance(made.positions, points[0, :3], points[1, :3]), distance(made.positions, points[1, :3], points[2, :3]))
    # On the inner side of the joint, rings lie within the other tube.
    is_outer = ~((made.positions[:, 0] > -1e-9) & (made.positions[:, 2] < 1.0 + 1e-9))
    assert np.abs(near[is_outer] / 0.1 - 1.0).max() < 0.02
    assert abs(made.positions[:, 2].min() + 0.1) < 1e-9 and abs(made.positions[:, 0].max() - 1.1) < 1e-9
