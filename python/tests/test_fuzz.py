"""No argument crashes: every call returns, or raises an exception that Python's programs expect."""

import os

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import lodestar
from conftest import room

EXAMPLES = int(os.environ.get("LODESTAR_FUZZ_EXAMPLES", 150))
EXPECTED = (lodestar.Error, TypeError, ValueError, OverflowError)
bounded = settings(max_examples=EXAMPLES, deadline=None, suppress_health_check=list(HealthCheck), derandomize=True)

NAMES = [option["name"] for option in lodestar.options()]
WORDS = sorted({word for option in lodestar.options() for word in option["words"]})

scalars = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.integers(-2, 70),
    st.floats(),
    st.text(max_size=8),
    st.sampled_from(WORDS),
    st.binary(max_size=4),
    st.complex_numbers(),
    st.builds(np.float32, st.floats(width=32)),
    st.builds(np.int8, st.integers(-128, 127)),
    st.builds(object),
)
arrays = st.builds(
    lambda shape, value, kind: np.full(shape, value).astype(kind),
    st.lists(st.integers(0, 4), max_size=3),
    st.sampled_from([0, 1, -1, 3]),
    st.sampled_from(["f4", "f8", "i4", "u1", "?", "c8", "O", "U4"]),
)
values = st.recursive(
    st.one_of(scalars, arrays),
    lambda inner: st.one_of(
        st.lists(inner, max_size=4), st.tuples(inner, inner), st.dictionaries(st.text(max_size=4), inner, max_size=3)
    ),
    max_leaves=6,
)


@pytest.fixture(autouse=True, scope="module")
def folder(tmp_path_factory):
    """A folder of their own for files that a fuzzed name may make."""
    before = os.getcwd()
    os.chdir(tmp_path_factory.mktemp("fuzz"))
    yield
    os.chdir(before)


def attempt(call, *arguments, **keywords):
    try:
        return call(*arguments, **keywords)
    except EXPECTED as error:
        assert str(error), type(error)


TINY = {"type": "scene", "a": {"type": "sphere"}}


@bounded
@given(st.dictionaries(st.sampled_from([name for name in NAMES if name != "kernel_dir"]), values, max_size=4))
def test_any_settings(keywords):
    # There is no such device, so no render begins.
    attempt(lodestar.Renderer, TINY, **{**keywords, "device": "no such device"})


@bounded
@given(st.dictionaries(st.text(max_size=8), values, max_size=3))
def test_any_keywords(keywords):
    for name in ("scene", "guide", "callback"):
        keywords.pop(name, None)
    attempt(lodestar.render, TINY, **{**keywords, "device": "no such device"})


@bounded
@given(values)
def test_any_scene(value):
    attempt(lodestar.load, value)


PLUGINS = ["sphere", "rectangle", "mesh", "obj", "diffuse", "twosided", "perspective", "area", "point", "rgb", "ref"]
PLUGINS += ["bitmap", "spectrum", "instance", "shapegroup", "path", "hdrfilm", "blendbsdf", "envmap", "uniform"]
KEYS = ["radius", "center", "to_world", "vertices", "faces", "bsdf", "emitter", "radiance", "value", "id", "filename"]
KEYS += ["reflectance", "fov", "film", "width", "max_depth", "weight", "shape", "type", "mesh_index", "normals"]
objects = st.recursive(
    st.fixed_dictionaries({"type": st.sampled_from(PLUGINS)}),
    lambda inner: st.builds(
        lambda plugin, entries: {"type": plugin, **entries},
        st.sampled_from(PLUGINS),
        st.dictionaries(st.sampled_from(KEYS), st.one_of(inner, values), max_size=4),
    ),
    max_leaves=8,
)


@bounded
@given(st.dictionaries(st.text(max_size=5), objects, max_size=4))
def test_any_objects(entries):
    scene = attempt(lodestar.load, {**entries, "type": "scene"})
    if scene is not None:
        assert isinstance(scene.summary, dict) and scene.fingerprint


@bounded
@given(values, values)
def test_any_pictures(first, second):
    attempt(lodestar.compare, first, second)
    attempt(lodestar.merge, first)
    attempt(lodestar.resume, first)
    attempt(lodestar.Picture.read, first)


@bounded
@given(values, values, values)
def test_any_transforms(first, second, third):
    transform = lodestar.ScalarTransform4f()
    attempt(lodestar.ScalarTransform4f, first)
    attempt(transform.translate, first)
    attempt(transform.scale, first)
    attempt(transform.rotate, first, second)
    attempt(transform.look_at, first, second, third)
    attempt(lambda: transform @ first)


RENDERER = lodestar.Renderer(room(), width=8, height=6, directions=16, grid=2)


@bounded
@given(values)
def test_any_call_of_a_renderer(value):
    guide, picture = RENDERER.guide, RENDERER.picture()
    for call in (guide.radiance_at, guide.radiance_at_point, guide.surface_at, RENDERER.run, RENDERER.checkpoint):
        if not callable(value) and value is not None and not isinstance(value, (str, bytes)):
            attempt(call, value)
    attempt(picture.png, tone=value)
    attempt(picture.png, exposure=value)
    if not isinstance(value, int) or value <= 0:
        attempt(RENDERER.step, value)
