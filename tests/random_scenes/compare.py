"""Comparison of a scene's block means, as Lodestar and Mitsuba estimate them.

Both give a mean and a standard error for each color channel of each block of 6 x 6 pixels: Lodestar by its variance layer, Mitsuba by
the spread of many pictures. A block is suspicious where the difference is more than LIMIT standard errors. A scene differs if a block
is suspicious to the same side in each of several rounds, with new seeds and four times the samples each time."""

import dataclasses
import pathlib
import subprocess

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
mi.set_log_level(mi.LogLevel.Error)

SIDE = 6
# Mitsuba's number of pictures, and the number of rounds.
PICTURES, ROUNDS = 16, 3
# Standard errors that a difference must have, and what rounding may differ by: a share of the block and of the picture.
LIMIT, OF_BLOCK, OF_PICTURE = 4.5, 1.0e-3, 1.0e-4
SECONDS = 600


class Refused(Exception):
    """One of the two does not render the scene."""

    def __init__(self, who, why):
        super().__init__(f"{who}: {why}")
        self.who, self.why = who, why


@dataclasses.dataclass
class Verdict:
    """What a comparison found. `z` has the largest score of the last round, `ratio` that of the means."""

    differs: bool
    z: float
    ratio: float
    rounds: int


def blocks(pixels):
    """Means of blocks."""
    height, width = pixels.shape[:2]
    return pixels[: height // SIDE * SIDE, : width // SIDE * SIDE].reshape(height // SIDE, SIDE, width // SIDE, SIDE, 3).mean(axis=(1, 3))


def by_lodestar(binary, path, options, samples, seed):
    """Block means and their standard errors."""
    out = pathlib.Path(path).with_suffix(".exr")
    line = [binary, "render", str(path), "--spp", str(samples), "--seed", str(seed), "-o", str(out), "--overwrite", "--quiet", *options]
    try:
        done = subprocess.run(line, capture_output=True, text=True, timeout=SECONDS)
    except subprocess.TimeoutExpired:
        raise Refused("lodestar", f"no picture after {SECONDS} s") from None
    if done.returncode != 0:
        raise Refused("lodestar", done.stderr.strip().splitlines()[-1] if done.stderr.strip() else f"exit code {done.returncode}")
    bitmap = mi.Bitmap(str(out))
    names = [field.name for field in bitmap.struct_()]
    layer = np.array(bitmap, dtype=np.float64)
    of = lambda prefix: layer[:, :, [names.index(prefix + channel) for channel in "RGB"]]
    return blocks(of("")), (blocks(of("variance.")) / SIDE**2) ** 0.5


def by_mitsuba(path, samples, seed):
    """Block means and their standard errors."""
    try:
        scene = mi.load_file(str(path))
        pictures = [
            blocks(np.array(mi.render(scene, spp=max(samples // PICTURES, 1), seed=seed * PICTURES + at), dtype=np.float64)[:, :, :3])
            for at in range(PICTURES)
        ]
    except RuntimeError as error:
        raise Refused("mitsuba", str(error).strip().splitlines()[-1]) from None
    return np.mean(pictures, axis=0), np.std(pictures, axis=0, ddof=1) / PICTURES**0.5


def compare(binary, path, options=(), seed=1, samples=256, rounds=ROUNDS, factor=1.0):
    """Verdict on the scene at `path`. `factor` multiplies Lodestar's light."""
    side = None
    for at in range(rounds):
        ours, our_error = by_lodestar(binary, path, options, samples, seed + at)
        theirs, their_error = by_mitsuba(path, samples, seed + at)
        rounding = OF_BLOCK * np.abs(theirs) + OF_PICTURE * np.abs(theirs).mean() + 1.0e-7
        ours, our_error = factor * ours, factor * our_error
        if not (np.isfinite(ours).all() and np.isfinite(theirs).all()):
            return Verdict(True, float("inf"), float("nan"), at + 1)
        z = (ours - theirs) / np.sqrt(our_error**2 + their_error**2 + rounding**2)
        suspicious = np.where(np.abs(z) > LIMIT, np.sign(z), 0.0)
        side = suspicious if side is None else np.where(side == suspicious, side, 0.0)
        verdict = Verdict(bool(side.any()), float(np.abs(z).max()), float(ours.mean() / max(theirs.mean(), 1.0e-12)), at + 1)
        if not verdict.differs:
            break
        samples *= 4
    return verdict
