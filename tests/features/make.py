#!/usr/bin/env python3
"""Renders the scenes of tests/features with Mitsuba 3 (pip install mitsuba numpy) and writes references.tsv beside this file.

    LODESTAR_FEATURES_SCENES=DIR cargo test --release --test features write_scenes
    tests/features/make.py DIR [NAME...]

Scenes that DIR/likes.txt names have the picture of another scene and are left out. A scene whose text has not changed keeps
its row; with NAMEs, only these are rendered.

A row: the name, the CRC-32 of the scene's text, then mean and standard error of each color channel of each block of 6 x 6
pixels, block by block, from 4096 samples per pixel. Where the filter is a box, samples are taken one by one with Mitsuba's
integrator, so that their variance is known. Else the standard error is that of the mean of many pictures."""
import pathlib
import sys
import zlib

import mitsuba as mi
import numpy as np

SAMPLES, SIDE, WIDTH, HEIGHT = 4096, 6, 24, 18
# Samples per pixel of one wave of samples, and number of pictures of a scene whose filter is no box.
WAVE, PICTURES = 1024, 128
# Samples per pixel of scenes with media, in pictures of the scalar variant: some versions of LLVM cannot compile `volpath` with them.
OF_MEDIA = 2048
# Scenes that Mitsuba's scalar variant renders, in pictures: its other variants lose light at large coordinates, and some versions of LLVM
# cannot compile its `hair`.
SCALAR = ("ground-", "carpet", "far-", "huge-", "tiny-", "scale-1", "hair-")
OUT = pathlib.Path(__file__).with_name("references.tsv")


def sums(path):
    """Sum of the samples of each pixel, and of their squares."""
    scene = mi.load_file(str(path))
    sensor, integrator = scene.sensors()[0], scene.integrator()
    pixels = WIDTH * HEIGHT
    x, y = (np.tile(axis.reshape(-1), WAVE).astype(np.float32) for axis in np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT)))
    total, squares = np.zeros((pixels, 3)), np.zeros((pixels, 3))
    sampler = mi.load_dict({"type": "independent", "sample_count": WAVE})
    for seed in range(SAMPLES // WAVE):
        sampler.seed(seed + 1, pixels * WAVE)
        offset = sampler.next_2d()
        place = mi.Point2f((mi.Float(x) + offset.x) / WIDTH, (mi.Float(y) + offset.y) / HEIGHT)
        ray, weight = sensor.sample_ray_differential(0.0, sampler.next_1d(), place, sampler.next_2d())
        color, _valid, _more = integrator.sample(scene, sampler, ray)
        samples = np.array(color * weight, dtype=np.float64).T.reshape(WAVE, pixels, 3)
        total, squares = total + samples.sum(axis=0), squares + (samples**2).sum(axis=0)
    return total, squares


def blocks_of(pixels):
    return pixels.reshape(HEIGHT // SIDE, SIDE, WIDTH // SIDE, SIDE, 3).mean(axis=(1, 3)).reshape(-1)


def by_samples(path):
    mi.set_variant("llvm_ad_rgb")
    total, squares = sums(path)
    mean = total / SAMPLES
    variance = (squares / SAMPLES - mean**2).clip(0) / (SAMPLES - 1)
    return blocks_of(mean), (blocks_of(variance) / SIDE**2) ** 0.5


def by_pictures(path, samples):
    mi.set_variant("scalar_rgb")
    scene = mi.load_file(str(path))
    pictures = []
    for seed in range(PICTURES):
        picture = np.array(mi.render(scene, spp=samples // PICTURES, seed=seed + 1), dtype=np.float64)
        pictures.append(blocks_of(picture[:, :, :3]))
    return np.mean(pictures, axis=0), np.std(pictures, axis=0, ddof=1) / PICTURES**0.5


def rows():
    if not OUT.exists():
        return {}
    return {line.split("\t")[0]: line for line in OUT.read_text().splitlines()}


def main():
    folder, only = pathlib.Path(sys.argv[1]), sys.argv[2:]
    left_out = (folder / "likes.txt").read_text().split()
    names = sorted(path.stem for path in folder.glob("*.xml") if path.stem not in left_out)
    known = {name: row for name, row in rows().items() if name in names}
    for name in names:
        path = folder / f"{name}.xml"
        crc = f"{zlib.crc32(path.read_bytes()):08x}"
        if name not in only if only else name in known and known[name].split("\t")[1] == crc:
            continue
        text = path.read_text()
        samples = OF_MEDIA if "<medium" in text else SAMPLES
        pictures = name.startswith(SCALAR) or samples == OF_MEDIA or "<rfilter type='box'/>" not in text
        mean, error = by_pictures(path, samples) if pictures else by_samples(path)
        numbers = [f"{value:.5g}" for pair in zip(mean, error) for value in pair]
        known[name] = "\t".join([name, crc, *numbers])
        print(name, mean.mean(), flush=True)
        OUT.write_text("".join(known[name] + "\n" for name in sorted(known)))


main()
