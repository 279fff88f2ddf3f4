"""Renders: layers, callbacks, interruptions, errors, guides, threads."""

import _thread
import io
import os
import pathlib
import signal
import subprocess
import sys
import sysconfig
import threading
import time

import numpy as np
import pytest

import lodestar
from conftest import room

SMALL = {"width": 16, "height": 12, "sampler": "bsdf"}
ENDLESS = {**SMALL, "time": 600}


def test_layers_have_their_shapes_and_meanings(room_scene):
    picture = lodestar.render(room_scene, spp=8)
    shapes = {name: getattr(picture, name).shape for name in ("radiance", "variance", "albedo", "normal")}
    assert set(shapes.values()) == {(24, 32, 3)}
    assert picture.samples.shape == picture.hits.shape == picture.depth.shape == picture.alpha.shape == (24, 32)
    assert picture.radiance.dtype == np.float32 and picture.samples.dtype == np.uint32
    assert (picture.samples == 8).all() and picture.ending == "samples"
    center = (14, 19)  # on the ball
    assert np.allclose(picture.albedo[center], [0.6, 0.5, 0.4], atol=0.02)
    assert 2.5 < picture.depth[center] < 3.6 and picture.normal[center][2] > 0.5
    assert (picture.alpha == picture.hits / 8).all()
    assert picture.variance.min() >= 0 and picture.variance.max() > 0
    with pytest.raises(ValueError, match="read-only"):
        picture.radiance[0, 0, 0] = 1
    assert picture.radiance is picture.radiance
    stats = picture.stats
    assert stats["totals"]["spp"] == 8 and stats["settings"]["seed"] == 0 and len(stats["steps"]) == 4
    assert "32 x 24" in repr(picture)


def test_pictures_are_written(room_scene, tmp_path):
    picture = lodestar.render(room_scene, **SMALL, spp=4)
    png = picture._repr_png_()
    picture.save(tmp_path / "a.png")
    assert png.startswith(b"\x89PNG") and (tmp_path / "a.png").read_bytes() == png
    assert picture.png(exposure=2.0) != png and picture.png(tone="paper") != png
    matplotlib = pytest.importorskip("matplotlib.image")
    shown = matplotlib.imread(io.BytesIO(png))
    linear = np.clip(picture.radiance, 0, 1)
    curve = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    assert np.abs(shown[..., :3] - curve).max() < 0.6 / 255
    with pytest.raises(lodestar.Error, match="must end in .exr, .png, .jpg, .tif or .hdr"):
        picture.save(tmp_path / "a.gif")
    with pytest.raises(lodestar.Error, match="cannot be written"):
        picture.save(tmp_path / "missing" / "a.exr")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.png"]


def test_a_callback_sees_every_step(room_scene):
    seen = []

    def callback(renderer):
        seen.append((renderer.samples, renderer.picture().radiance.mean(), renderer.fraction))

    picture = lodestar.render(room_scene, spp=8, callback=callback)
    assert [samples for samples, _, _ in seen] == [1, 2, 4, 8]
    assert seen[-1][1] == picture.radiance.mean() and [fraction for *_, fraction in seen][2:] == [0.5, 1.0]


def test_a_callback_ends_the_render(room_scene):
    picture = lodestar.render(room_scene, spp=100, callback=lambda renderer: renderer.samples < 3)
    assert picture.ending == "stopped" and (picture.samples == 4).all()


@pytest.mark.parametrize("answer", [False, np.False_, np.bool_(0), 0, ""])
def test_an_answer_that_is_false_ends_the_render(room_scene, answer):
    assert (lodestar.render(room_scene, spp=8, callback=lambda _: answer).samples == 1).all()


@pytest.mark.parametrize("answer", [None, True, np.True_, 1, "on"])
def test_other_answers_go_on(room_scene, answer):
    assert (lodestar.render(room_scene, spp=2, callback=lambda _: answer).samples == 2).all()


CHILD = """
import multiprocessing, sys
import lodestar
from conftest import room

def work(_):
    try:
        lodestar.render(room(), spp=1)
    except lodestar.Error as error:
        return str(error)
    return "rendered"

if __name__ == "__main__":
    if sys.argv[2] == "after":
        lodestar.render(room(), spp=1)
    with multiprocessing.get_context(sys.argv[1]).Pool(1) as pool:
        print(pool.map(work, [0])[0])
"""


@pytest.mark.parametrize("method, order, answer", [
    ("fork", "after", 'multiprocessing.set_start_method("spawn")'),
    ("fork", "before", "rendered"),
    ("spawn", "after", "rendered"),
])
def test_a_forked_child_is_told_what_to_do(tmp_path, method, order, answer):
    script = tmp_path / "child.py"
    script.write_text(CHILD)
    environment = {**os.environ, "PYTHONPATH": str(pathlib.Path(__file__).parent)}
    run = subprocess.run([sys.executable, script, method, order], env=environment, capture_output=True, text=True, timeout=120)
    assert run.returncode == 0 and answer in run.stdout, run.stdout + run.stderr


def test_an_exception_of_a_callback_comes_through(room_scene):
    def callback(renderer):
        raise ZeroDivisionError("in the callback")

    with pytest.raises(ZeroDivisionError, match="in the callback"):
        lodestar.render(room_scene, spp=4, callback=callback)


def test_ctrl_c_ends_a_render_with_the_picture_so_far(room_scene):
    renderer = lodestar.Renderer(room_scene, **ENDLESS)
    renderer.step(1)
    timer = threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT))
    timer.start()
    picture = renderer.run()
    timer.join()
    assert picture.ending == "stopped" and picture.samples.min() >= 1 and picture.radiance.mean() > 0
    assert picture.stats["totals"]["seconds"] < 60


def test_ctrl_c_in_a_callback_ends_the_render(room_scene):
    def callback(renderer):
        if renderer.samples >= 2:
            _thread.interrupt_main()

    picture = lodestar.render(room_scene, **ENDLESS, callback=callback)
    assert picture.ending == "stopped" and picture.samples.min() >= 2


def test_ctrl_c_before_the_first_sample_is_an_exception(room_scene):
    renderer = lodestar.Renderer(room_scene, **ENDLESS)
    with pytest.raises(KeyboardInterrupt):
        # The signal waits for the call below.
        _thread.interrupt_main()
        renderer.run()


def test_another_thread_ends_a_render(room_scene):
    renderer = lodestar.Renderer(room_scene, **{**ENDLESS, "width": 64, "height": 48})
    timer = threading.Timer(0.3, renderer.stop)
    timer.start()
    # One step of so many samples would take minutes.
    done = renderer.step(200_000)
    timer.join()
    assert 0 < done < 200_000 and renderer.seconds < 60
    assert renderer.picture().radiance.mean() > 0 and renderer.run().ending == "stopped" and renderer.samples == done


def test_other_signals_raise_what_their_handlers_raise(room_scene):
    def handler(number, frame):
        raise TimeoutError("too long")

    before = signal.signal(signal.SIGALRM, handler)
    try:
        renderer = lodestar.Renderer(room_scene, **ENDLESS)
        signal.setitimer(signal.ITIMER_REAL, 0.2)
        with pytest.raises(TimeoutError, match="too long"):
            renderer.run()
    finally:
        signal.signal(signal.SIGALRM, before)
    # The picture so far is still there.
    assert renderer.picture().radiance.shape == (12, 16, 3)


def test_the_interpreter_is_free_while_a_render_runs(room_scene):
    renderer = lodestar.Renderer(room_scene, **{**SMALL, "width": 64, "height": 48})
    counted, done = 0, threading.Event()

    def render():
        renderer.step(64)
        done.set()

    thread = threading.Thread(target=render)
    thread.start()
    while not done.is_set():
        counted += 1
        time.sleep(0.001)
    thread.join()
    assert renderer.samples == 64 and counted > 3


def test_each_thread_may_have_a_renderer(room_scene):
    scene = lodestar.load(room_scene)
    alone = [lodestar.render(scene, spp=4, seed=seed).radiance for seed in range(3)]
    together = [None] * 3

    def render(seed):
        together[seed] = lodestar.render(scene, spp=4, seed=seed).radiance

    threads = [threading.Thread(target=render, args=(seed,)) for seed in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(a.tobytes() == b.tobytes() for a, b in zip(alone, together))


def test_threads_may_share_a_renderer(room_scene):
    renderer = lodestar.Renderer(room_scene, **SMALL)
    threads = [threading.Thread(target=renderer.step, args=(2,)) for _ in range(4)]
    for thread in threads:
        thread.start()
    for _ in range(20):
        assert renderer.picture().samples.max() <= 8
    for thread in threads:
        thread.join()
    assert renderer.samples == 8


ERRORS = [
    ({"spp": 0}, "'--spp <N>': 0 is not in 1"),
    ({"sampler": "produkt"}, "did you mean product"),
    ({"grid": 64}, "--grid is 64, but must lie between"),
    ({"width": 32, "scale": 2}, "cannot be used with"),
    ({"sampler": "bsdf", "directions": 8}, "--directions is used by the samplers"),
    ({"time": -1}, "give a time above 0"),
    ({"seed": "x"}, "invalid value 'x' for '--seed"),
    ({"crop": (1, 2)}, "write it as X,Y,W,H"),
    ({"device": "no such device"}, "no such device"),
    ({"checkpoint_every": 3}, "--checkpoint FILE is missing"),
    ({"noise": 5}, "--noise is 5, but must lie between"),
]


@pytest.mark.parametrize("at", range(len(ERRORS)))
def test_errors_have_the_sentences_of_the_command_line(at, cornell, tmp_path):
    settings, words = ERRORS[at]
    with pytest.raises(lodestar.Error) as caught:
        lodestar.render(cornell, **settings)
    sentence = str(caught.value)
    assert words in sentence and "\n" not in sentence
    arguments = [
        f"--{name.replace('_', '-')}={','.join(map(str, value)) if isinstance(value, tuple) else value}"
        for name, value in settings.items()
    ]
    command = pathlib.Path(sysconfig.get_path("scripts")) / "lodestar"
    told = subprocess.run([command, "render", cornell, *arguments], capture_output=True, text=True, cwd=tmp_path)
    assert told.returncode in (1, 2)
    assert f"error: {sentence}" in told.stderr


def test_wrong_keywords_are_type_errors(cornell):
    with pytest.raises(TypeError, match="`sppp` is no keyword of a render; did you mean `spp`"):
        lodestar.render(cornell, sppp=3)
    for keyword, hint in [
        ("output", "only the command line has the option --output"),
        ("denoise", "only the command line has the option --denoise"),
        ("samples", "`spp` sets the samples per pixel"),
        ("max_bounces", "`max_depth` sets the longest path in edges"),
    ]:
        with pytest.raises(TypeError, match=f"`{keyword}` is no keyword of a render; {hint}"):
            lodestar.render(cornell, **{keyword: 3})
    with pytest.raises(TypeError, match="`spp` cannot be a value of the type `object`"):
        lodestar.render(cornell, spp=object())
    with pytest.raises(TypeError, match="expected a path"):
        lodestar.render(3)


def test_files_at_fault_are_named(tmp_path):
    with pytest.raises(lodestar.Error, match="missing.xml: cannot be read"):
        lodestar.render(tmp_path / "missing.xml")
    (tmp_path / "bad.xml").write_text("<scene version='3.0.0'>\n<shape type='blob'/>\n</scene>")
    with pytest.raises(lodestar.Error, match="bad.xml:2: shape plugin `blob` is not supported"):
        lodestar.load(tmp_path / "bad.xml")
    (tmp_path / "bad.ckpt").write_bytes(b"nothing")
    with pytest.raises(lodestar.Error, match="bad.ckpt"):
        lodestar.resume(tmp_path / "bad.ckpt")


def test_scenes_in_code_have_no_checkpoint(room_scene, tmp_path):
    renderer = lodestar.Renderer(room_scene, **SMALL)
    with pytest.raises(lodestar.Error, match="was made in memory"):
        renderer.checkpoint(tmp_path / "a.ckpt")


def test_a_step_cut_short_has_no_checkpoint(cornell, tmp_path):
    renderer = lodestar.Renderer(cornell, width=16)
    for _ in range(3):
        renderer.step()
    renderer.step(1)  # The schedule has four samples here.
    with pytest.raises(lodestar.Error, match="take whole steps"):
        renderer.checkpoint(tmp_path / "a.ckpt")


def test_without_a_driver_the_message_is_that_of_devices(cornell, tmp_path):
    program = "import lodestar, sys\nfor act in (lodestar.devices, lambda: lodestar.render(sys.argv[1], spp=1)):\n"
    program += "    try: act()\n    except lodestar.Error as error: print(error)\n"
    nothing = {**os.environ, "VK_DRIVER_FILES": str(tmp_path / "no.json"), "VK_ICD_FILENAMES": str(tmp_path / "no.json")}
    told = subprocess.run([sys.executable, "-c", program, cornell], env=nothing, capture_output=True, text=True, check=True)
    by_command = subprocess.run([sys.executable, "-m", "lodestar", "devices"], env=nothing, capture_output=True, text=True)
    assert by_command.returncode == 1
    sentences = told.stdout.splitlines()
    assert len(sentences) == 2 and sentences[0] == sentences[1]
    assert by_command.stderr.strip() == f"lodestar: error: {sentences[0]}" and "VK_" in sentences[0]


def test_devices_are_listed():
    devices = lodestar.devices()
    assert sum(device["default"] for device in devices) == 1
    assert all(isinstance(device["name"], str) for device in devices)


def test_the_guide_knows_where_light_comes_from(room_scene):
    renderer = lodestar.Renderer(room_scene, nee=False, directions=16, grid=4)
    renderer.step(64)
    guide = renderer.guide
    cells, bins = guide.radiance.shape
    assert guide.cells.shape == (cells, 2, 3) and guide.directions.shape == (bins, 3) and bins == guide.side**2 == 256
    assert np.allclose(np.linalg.norm(guide.directions, axis=1), 1)
    assert (guide.cells[:, 0] < guide.cells[:, 1]).all()
    # A point of the floor, before the ball: the lamp is above it.
    pixel = (16, 22)
    position, normal = guide.surface_at(pixel)
    assert abs(position[1]) < 0.01 and normal[1] > 0.99
    learned = guide.radiance_at(pixel)
    assert learned.shape == (16, 16) and (learned == guide.radiance_at_point(position)).all()
    brightest = guide.directions[learned.argmax()]
    to_lamp = np.array([0, 1.9, 0]) - position
    assert brightest @ to_lamp / np.linalg.norm(to_lamp) > 0.85
    inside = ((guide.cells[:, 0] <= position) & (position <= guide.cells[:, 1])).all(axis=1)
    assert any((guide.radiance[cell] == learned.ravel()).all() for cell in np.flatnonzero(inside))
    with pytest.raises(lodestar.Error, match="--pixel 99,0"):
        guide.radiance_at((99, 0))
    # Later steps leave this guide as it is.
    before = guide.radiance.copy()
    renderer.step(16)
    assert (guide.radiance == before).all() and (renderer.guide.radiance != before).any()
    with pytest.raises(lodestar.Error, match="learns nothing"):
        lodestar.Renderer(room_scene, **SMALL).guide


@pytest.mark.parametrize("sampler", ["product", "rejection-mix", "sphere-inversion"])
def test_a_guide_is_used_again(sampler):
    settings = {"nee": False, "sampler": sampler, "width": 24, "height": 18}
    teacher = lodestar.Renderer(room(), **settings, seed=1)
    teacher.step(64)
    guide = teacher.guide
    # The same scene: the new render begins where the old one ended.
    begun = lodestar.Renderer(room(), **settings, seed=2, guide=guide)
    assert (begun.guide.radiance == guide.radiance).all()
    # Another place of the lamp: cells take what their neighbors have learned.
    moved = room(lamp=(0.6, 1.2, 0.3))
    taught = lodestar.Renderer(moved, **settings, seed=2, guide=guide)
    fresh = lodestar.Renderer(moved, **settings, seed=2)
    assert taught.guide.radiance.shape[1] == guide.radiance.shape[1]
    known = {row.tobytes() for row in guide.radiance}
    assert all(row.tobytes() in known for row in taught.guide.radiance)
    # A guide never changes the expected picture.
    means = []
    for renderer in (taught, fresh):
        renderer.step(512)
        picture = renderer.picture()
        error = np.sqrt(picture.variance.astype(float).sum()) / picture.radiance[..., 0].size
        means.append((picture.radiance.astype(float).sum() / picture.radiance[..., 0].size, error))
    (first, error), (second, other_error) = means
    assert abs(first - second) < 5 * np.hypot(error, other_error)


def test_guides_that_do_not_fit_are_refused(room_scene):
    renderer = lodestar.Renderer(room_scene, seed=1, directions=16)
    renderer.step(2)
    guide = renderer.guide
    with pytest.raises(lodestar.Error, match="--seed 1 up to number 2 already"):
        lodestar.Renderer(room_scene, seed=1, directions=16, guide=guide)
    with pytest.raises(lodestar.Error, match="another directions"):
        lodestar.Renderer(room_scene, seed=2, directions=32, guide=guide)
    with pytest.raises(TypeError):
        lodestar.Renderer(room_scene, guide=3)
    # A guide remembers all its teachers.
    second = lodestar.Renderer(room_scene, seed=2, directions=16, guide=guide)
    second.step(1)
    with pytest.raises(lodestar.Error, match="--seed 1 up to number 2 already"):
        lodestar.Renderer(room_scene, seed=1, directions=16, guide=second.guide)


def test_the_camera_changes_and_the_guide_stays(room_scene):
    settings = {"nee": False, "directions": 16}
    look_at = lodestar.ScalarTransform4f().look_at(origin=[1, 1.2, 3], target=[0, 0.8, 0], up=[0, 1, 0])
    camera = {**room_scene["sensor"], "fov": 50.0, "to_world": look_at}
    other = lodestar.load({**room_scene, "sensor": camera})
    pictures = []
    for changed in (camera, other):
        renderer = lodestar.Renderer(room_scene, seed=1, width=32, height=24, **settings)
        renderer.step(8)
        guide, before = renderer.guide, renderer.guide.surface_at((16, 22))
        renderer.set_camera(changed)
        renderer.set_size(24, 20)
        assert renderer.samples == 0 and (renderer.guide.radiance == guide.radiance).all()
        assert renderer.guide.surface_at((16, 18)) != before
        renderer.step(8)
        pictures.append(renderer.picture().radiance)
    anew = lodestar.Renderer(other, seed=2, width=24, height=20, guide=guide, **settings)
    anew.step(8)
    pictures.append(anew.picture().radiance)
    assert (pictures[0] == pictures[1]).all() and (pictures[0] == pictures[2]).all()
    with pytest.raises(TypeError, match="dictionary of a sensor"):
        renderer.set_camera(3)
    with pytest.raises(lodestar.Error, match="between 0 and 180|fov"):
        renderer.set_camera({**camera, "fov": 200.0})
    with pytest.raises(lodestar.Error, match="width"):
        renderer.set_size(0, 4)


def test_the_scene_changes_and_the_guide_stays(room_scene, tmp_path):
    settings = {"nee": False, "directions": 16}
    ball = {"type": "sphere", "center": [0.3, 0.5, 0.2], "radius": 0.3, "bsdf": {"type": "diffuse"}}
    changed = {**room_scene, "ball": ball}
    pictures = []
    for scene in (changed, lodestar.load(changed)):
        renderer = lodestar.Renderer(room_scene, seed=1, width=32, height=24, **settings)
        renderer.step(8)
        guide, before = renderer.guide, renderer.guide.surface_at((16, 12))
        renderer.set_scene(scene)
        assert renderer.samples == 0 and renderer.settings["seed"] == 2
        # The surfaces that pixels show are those of the new scene.
        assert renderer.guide.surface_at((16, 12)) != before
        renderer.step(8)
        pictures.append(renderer.picture().radiance)
    anew = lodestar.Renderer(changed, seed=2, width=32, height=24, guide=guide, **settings)
    anew.step(8)
    pictures.append(anew.picture().radiance)
    assert (pictures[0] == pictures[1]).all() and (pictures[0] == pictures[2]).all()
    with pytest.raises(lodestar.Error, match="missing.xml"):
        renderer.set_scene(tmp_path / "missing.xml")
    with pytest.raises(lodestar.Error, match="lodestar.load"):
        renderer.set_scene(lodestar.load(changed), camera="fit")
    # What was refused has changed nothing.
    assert renderer.samples == 8 and (renderer.picture().radiance == pictures[0]).all()


def test_a_scene_in_a_file_is_read_again(room_scene, tmp_path):
    file = tmp_path / "scene.xml"
    text = '<scene version="3.0.0"><shape type="ply"><string name="filename" value="a.ply"/></shape><emitter type="constant"/></scene>'
    corners = ("0 0 0", "1 0 0", "0 1 0"), ("0 0 0", "1 0 0", "1 1 0")
    ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
    ply += "property list uchar int vertex_indices\nend_header\n"

    def write(at):
        (tmp_path / "a.ply").write_text(ply + "\n".join(corners[at]) + "\n3 0 1 2\n")
        os.utime(tmp_path / "a.ply", (at, at))

    file.write_text(text)
    write(0)
    settings = {"camera": "fit", "width": 32, "height": 24}
    renderer = lodestar.Renderer(file, sampler="bsdf", **settings)
    for at in (1, 1, 0):
        write(at)
        renderer.set_scene(file, camera="fit")
        renderer.step(2)
        anew = lodestar.Renderer(file, sampler="bsdf", **settings)
        anew.step(2)
        assert (renderer.picture().radiance == anew.picture().radiance).all()


def test_a_stop_ends_with_another_view(room_scene):
    renderer = lodestar.Renderer(room_scene, seed=1, width=32, height=24)
    renderer.stop()
    assert renderer.step(4) == 0
    renderer.set_scene(room_scene)
    assert renderer.step(4) == 4
    renderer.stop()
    assert renderer.step(4) == 4
    renderer.set_size(24, 20)
    assert renderer.step(4) == 4
    renderer.stop()
    renderer.set_camera({"type": "perspective", "fov": 40.0})
    assert renderer.step(4) == 4


def test_a_renderer_takes_the_device_of_another(room_scene):
    first = lodestar.Renderer(room_scene, seed=1, width=32, height=24)
    second = lodestar.Renderer(room_scene, seed=1, width=32, height=24, device=first)
    for renderer in (first, second):
        renderer.step(4)
    assert (first.picture().radiance == second.picture().radiance).all()
    # It outlives the first one.
    del first
    assert second.step(4) == 8


def test_a_guide_is_a_file(room_scene, tmp_path):
    renderer = lodestar.Renderer(room_scene, seed=1, directions=16)
    with pytest.raises(lodestar.Error, match="learned nothing yet"):
        renderer.write_guide(tmp_path / "room.guide")
    renderer.step(2)
    renderer.write_guide(tmp_path / "room.guide")
    begun = lodestar.Renderer(room_scene, seed=2, directions=16, guide=tmp_path / "room.guide")
    assert begun.guide.radiance.shape == renderer.guide.radiance.shape and (begun.guide.radiance > 0).any()
    with pytest.raises(lodestar.Error, match="--seed 1 up to number 2 already"):
        lodestar.Renderer(room_scene, seed=1, directions=16, guide=str(tmp_path / "room.guide"))
    with pytest.raises(TypeError, match="`guide` sets the guide"):
        lodestar.Renderer(room_scene, guide_from="room.guide")


def test_checkpoints_are_kept_by_keyword(cornell, tmp_path):
    file = tmp_path / "a.ckpt"
    lodestar.render(cornell, width=16, spp=2, checkpoint=file)
    assert lodestar.resume(file, spp=4).run().samples.max() == 4
    with pytest.raises(lodestar.Error, match="holds 4 samples per pixel"):
        lodestar.render(cornell, width=16, spp=3, checkpoint=file)
    assert lodestar.render(cornell, width=16, spp=6, checkpoint=file).samples.max() == 6


def test_the_command_is_there():
    command = pathlib.Path(sysconfig.get_path("scripts")) / "lodestar"
    version = subprocess.run([command, "--version"], capture_output=True, text=True, check=True).stdout
    assert version == f"lodestar {lodestar.__version__}\n"
    assert subprocess.run([command, "nonsense"], capture_output=True).returncode == 2


def test_the_command_ends_by_ctrl_c_with_its_picture(cornell, tmp_path):
    command = pathlib.Path(sysconfig.get_path("scripts")) / "lodestar"
    arguments = ["render", cornell, "--width", "16", "--time", "600", "-o", tmp_path / "a.exr", "--write-every", "0.1"]
    child = subprocess.Popen([command, *arguments], stderr=subprocess.PIPE, text=True)
    while not (tmp_path / "a.exr").exists():
        assert child.poll() is None
        time.sleep(0.05)
    child.send_signal(signal.SIGINT)
    told = child.communicate()[1]
    assert child.returncode == 130 and "Traceback" not in told
    assert lodestar.Picture.read(tmp_path / "a.exr").samples.max() > 0


def test_a_picture_is_denoised_where_the_library_is(cornell):
    picture = lodestar.render(cornell, width=16, spp=2)
    with pytest.raises(lodestar.Error, match="give one of cpu, sycl, cuda, hip, metal"):
        picture.denoise(device="mine")
    with pytest.raises(lodestar.Error, match="setup.sh --oidn"):
        picture.denoise(oidn="there/is/none")
    if os.environ.get("LODESTAR_OIDN"):
        denoised = picture.denoise()
        assert denoised.shape == picture.radiance.shape and denoised.dtype == np.float32
        assert np.isfinite(denoised).all() and not np.array_equal(denoised, picture.radiance)
