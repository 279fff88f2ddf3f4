#!/usr/bin/env python3
"""Writes values.json: FLIP of two small pictures by the authors' program (pip install flip-evaluator numpy; version 1.7).

The pictures are formulas, which `src/image/flip.rs` repeats.
"""
import json
from pathlib import Path

import flip_evaluator as flip
import numpy as np

WIDTH, HEIGHT = 48, 32


def picture(of):
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
    return np.stack([of(x, y, c) for c in range(3)], axis=-1).astype(np.float32)


def reference(x, y, c):
    """Steps, dots and a bright square, between 1/64 and 33."""
    steps = ((x // 8 + 2 * (y // 8) + c) % 5) / 8 + 1 / 64
    dots = np.where((x % 7 == 3) & (y % 6 == 2), 0.5, 0)
    return steps + dots + np.where((x > 30) & (x < 36) & (y > 20) & (y < 26), 32, 0)


def image(x, y, c):
    """The reference with noise and without some dots."""
    noise = 1 + (((x * 7 + y * 13 + c * 5) % 32) / 16 - 1) / 4
    return reference(x, y, c) * noise + np.where((x % 14 == 3) & (y % 6 == 2), -0.25, 0)


def shown(of):
    """Display values: the values over 2, at most 1, through the sRGB curve."""
    linear = np.minimum(picture(of) / 2, 1)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055).astype(np.float32)


def values(a, b, kind):
    errors, mean, parameters = flip.evaluate(b, a, kind, applyMagma=False)
    errors = np.asarray(errors, dtype=np.float64).reshape(HEIGHT, WIDTH)
    # Every fifth value of every fourth row.
    return {
        "mean": float(mean),
        "map": [round(float(v), 6) for v in errors[::4, ::5].ravel()],
        # Not used for displayed pictures, where the first two are infinite.
        "exposures": [parameters[k] for k in ("startExposure", "stopExposure", "numExposures")] if kind == "HDR" else [],
    }


written = {
    "displayed": values(shown(image), shown(reference), "LDR"),
    "hdr": values(picture(image), picture(reference), "HDR"),
}
path = Path(__file__).with_name("values.json")
path.write_text(json.dumps(written, indent=1) + "\n")
