"""Scenes and small renders that several tests share. The tests use the installed package only."""

import os
import pathlib

import pytest

import lodestar

FOLDER = pathlib.Path(__file__).resolve().parent


def pytest_report_header():
    return f"lodestar {lodestar.__version__} from {pathlib.Path(lodestar.__file__).parent}"


@pytest.fixture(scope="session")
def scenes() -> pathlib.Path:
    """Folder of the repository's scenes."""
    return pathlib.Path(os.environ.get("LODESTAR_TEST_SCENES", FOLDER.parents[1] / "scenes"))


@pytest.fixture(scope="session")
def cornell(scenes) -> str:
    return str(scenes / "cornell-box" / "scene.xml")


def room(lamp=(0.0, 1.9, 0.0)):
    """A small room in code, with a lamp below its ceiling."""
    transform = lodestar.ScalarTransform4f
    gray = {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.6, 0.5, 0.4]}}}
    wall = {"type": "rectangle", "bsdf": {"type": "ref", "id": "gray"}}
    return {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 6},
        "sensor": {
            "type": "perspective",
            "fov": 60.0,
            "to_world": transform().look_at(origin=[0, 1, 3.5], target=[0, 1, 0], up=[0, 1, 0]),
            "film": {"type": "hdrfilm", "width": 32, "height": 24, "rfilter": {"type": "box"}},
            "sampler": {"type": "independent", "sample_count": 4},
        },
        "gray": gray,
        "floor": {**wall, "to_world": transform().rotate([1, 0, 0], -90).scale(2)},
        "back": {**wall, "to_world": transform().translate([0, 1, -2]).scale([2, 1, 1])},
        "lamp": {
            "type": "rectangle",
            "to_world": transform().translate(lamp).rotate([1, 0, 0], 90).scale(0.3),
            "emitter": {"type": "area", "radiance": {"type": "rgb", "value": [10.0, 9.0, 8.0]}},
        },
        "ball": {"type": "sphere", "center": [0.4, 0.5, 0.0], "radius": 0.5, "bsdf": {"type": "ref", "id": "gray"}},
    }


@pytest.fixture
def room_scene():
    return room()
