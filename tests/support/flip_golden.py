#!/usr/bin/env python3
"""Prints the numbers of src/lab/image/flip/tests.rs: means and pixels of FLIP by its authors' tool.

    python3 -m venv /tmp/flip && /tmp/flip/bin/pip install flip-evaluator==1.7 && /tmp/flip/bin/python tests/support/flip_golden.py
"""
import numpy as np
import flip_evaluator as flip


def pair(width, height):
    """Reference and test image, linear: exact in f32, the same formula as in the test."""
    y, x, c = np.meshgrid(np.arange(height), np.arange(width), np.arange(3), indexing="ij")
    reference = ((x * (c + 1) + y * 3) % 32) / 32.0
    block = (x // 8 + y // 6) % 3 == c
    test = reference + np.where(block, 0.25, 0.0) - np.where((x * 5 + y * 7) % 11 == 0, 0.125, 0.0)
    return np.clip(reference, 0, 1).astype(np.float32), np.clip(test, 0, 1).astype(np.float32)


def high(image, offset):
    """The same over 12 stops: powers of two by column and row."""
    height, width, _ = image.shape
    y, x = np.meshgrid(np.arange(height), np.arange(width), indexing="ij")
    return (image * np.exp2((x // 4 + y // 5 + offset) % 12 - 6.0)[..., None]).astype(np.float32)


def srgb(linear):
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


for width, height in [(48, 32), (7, 45), (3, 2), (160, 90)]:
    reference, test = pair(width, height)
    for ppd in [None, 20.0]:
        parameters = {} if ppd is None else {"ppd": ppd}
        # The tool takes LDR as sRGB; encoded in f64, decoded by the tool.
        map_, mean, used = flip.evaluate(srgb(reference.astype(float)).astype(np.float32), srgb(test.astype(float)).astype(np.float32), "LDR", applyMagma=False, parameters=dict(parameters))
        at = map_[height // 2, width // 2].item()
        print(f"LDR {width}x{height} ppd {used['ppd']:.4f}: mean {mean:.7f} middle {at:.7f}")
        map_, mean, used = flip.evaluate(high(reference, 0), high(test, 0), "HDR", applyMagma=False, parameters=dict(parameters))
        at = map_[height // 2, width // 2].item()
        print(f"HDR {width}x{height} ppd {used['ppd']:.4f}: mean {mean:.7f} middle {at:.7f}"
              f" exposures {used['startExposure']:.5f} {used['stopExposure']:.5f} steps {used['numExposures']}")
