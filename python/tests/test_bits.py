"""Pictures have the bits of the command line."""

import pathlib
import subprocess
import sysconfig

import numpy as np
import pytest

import lodestar

COMMAND = pathlib.Path(sysconfig.get_path("scripts")) / "lodestar"
LAYERS = ["radiance", "variance", "samples", "hits", "albedo", "normal", "depth", "alpha"]

SETTINGS = [
    {},
    {"sampler": "bsdf"},
    {"sampler": "rejection-mix", "max_tries": 7, "epsilon": 0.25},
    {"nee": False, "seed": 7, "learner": "monte-carlo"},
    {"width": 40, "height": 24, "crop": (4, 2, 30, 20), "rfilter": "gaussian", "max_depth": 4},
    {"sampler": "quadtree", "nee": False},
    {"sample_offset": 64, "pattern": "independent", "steps": "even", "spp_per_step": 4},
    {"scale": 0.0625, "noise": 0.2, "grid": "auto", "decay": 0.9, "rr_depth": 2, "hide": None},
]


def arguments(settings):
    texts = {True: "on", False: "off"}
    for name, value in settings.items():
        text = ",".join(map(str, value)) if isinstance(value, tuple) else texts.get(value, str(value))
        yield f"--{name.replace('_', '-')}={text}"


def assert_same(picture, other):
    for layer in LAYERS:
        ours, theirs = getattr(picture, layer), getattr(other, layer)
        assert ours.dtype == theirs.dtype and ours.shape == theirs.shape, layer
        assert ours.tobytes() == theirs.tobytes(), layer


@pytest.mark.parametrize("at", range(len(SETTINGS)))
def test_bits_are_those_of_the_command_line(at, cornell, tmp_path):
    settings = {name: value for name, value in SETTINGS[at].items() if value is not None}
    size = {} if "width" in settings or "scale" in settings else {"width": 32}
    settings = {"spp": 12, **size, **settings}
    file = tmp_path / "picture.exr"
    subprocess.run([COMMAND, "render", cornell, "--quiet", "-o", file, *arguments(settings)], check=True)
    picture = lodestar.render(cornell, **settings)
    theirs = lodestar.Picture.read(file)
    assert_same(picture, theirs)
    assert picture.samples.max() > 0 and picture.radiance.mean() > 0.01
    ours, theirs = picture.attributes, theirs.attributes
    assert ours.keys() == theirs.keys()
    assert {name for name in ours if ours[name] != theirs[name]} <= {"seconds"}
    # Its own file has the same layers and the same header.
    picture.save(tmp_path / "own.exr")
    own = lodestar.Picture.read(tmp_path / "own.exr")
    assert_same(picture, own)
    assert own.attributes == picture.attributes


def test_another_seed_has_other_bits(cornell):
    first, second = (lodestar.render(cornell, width=16, spp=2, sampler="bsdf", seed=seed) for seed in (0, 1))
    assert first.radiance.tobytes() != second.radiance.tobytes()


def test_steps_and_scenes_in_memory_have_the_bits_of_one_render(cornell):
    whole = lodestar.render(cornell, width=24, spp=8)
    renderer = lodestar.Renderer(lodestar.load(cornell), width=24)
    while renderer.samples < 8:
        renderer.step()
    assert renderer.samples == 8
    assert_same(whole, renderer.picture())


def test_a_checkpoint_goes_on_to_the_same_bits(cornell, tmp_path):
    settings = {"width": 24, "spp": 8}
    whole = lodestar.render(cornell, **settings)
    renderer = lodestar.Renderer(lodestar.load(cornell), **settings)
    for _ in range(3):
        renderer.step()
    renderer.checkpoint(tmp_path / "a.ckpt")
    resumed = lodestar.resume(tmp_path / "a.ckpt")
    assert resumed.samples == 4 and resumed.settings == renderer.settings
    assert_same(whole, resumed.run())
    # The command line goes on with it, too.
    subprocess.run([COMMAND, "resume", tmp_path / "a.ckpt", "--quiet", "-o", tmp_path / "a.exr"], check=True)
    assert_same(whole, lodestar.Picture.read(tmp_path / "a.exr"))


def test_parts_merge_to_the_whole(cornell, tmp_path):
    settings = {"width": 24, "sampler": "bsdf"}
    parts = [lodestar.render(cornell, spp=8, sample_offset=offset, **settings) for offset in (0, 8)]
    parts[1].save(tmp_path / "b.exr")
    merged = lodestar.merge([parts[0], tmp_path / "b.exr"])
    whole = lodestar.render(cornell, spp=16, sample_offset=0, **settings)
    assert merged.radiance.tobytes() == whole.radiance.tobytes()
    assert (merged.samples == 16).all() and merged.stats is None
    with pytest.raises(lodestar.Error, match="also holds samples"):
        lodestar.merge([parts[0], parts[0]])


def test_comparisons_take_pictures_files_and_arrays(cornell, tmp_path):
    noisy, better = (lodestar.render(cornell, width=24, spp=spp, seed=spp) for spp in (2, 32))
    better.save(tmp_path / "better.exr")
    measured = lodestar.compare(noisy, better)
    assert measured == lodestar.compare(noisy.radiance, tmp_path / "better.exr")
    by_hand = np.mean((noisy.radiance.astype(float) - better.radiance) ** 2)
    assert np.isclose(measured["mse"], by_hand, rtol=1e-9) and measured["mse"] > 0
    assert lodestar.compare(better, better)["mse"] == 0
    both = noisy.radiance.astype(float), better.radiance.astype(float)
    smape = np.mean(np.abs(both[0] - both[1]) / (both[0] + both[1] + 0.01))
    assert 0 < measured["flip"] < 1 and np.isclose(measured["smape"], smape, rtol=1e-9)
    black = np.zeros_like(better.radiance)
    assert np.isnan(lodestar.compare(black, black)["mean_ratio"])
