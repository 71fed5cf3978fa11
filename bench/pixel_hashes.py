#!/usr/bin/env python3
"""Pixel hashes of small renders: ten scenes by every method.

    bench/pixel_hashes.py target/release/etendue --write before.txt   # before a change that must not alter pixels
    bench/pixel_hashes.py target/release/etendue --check before.txt   # after it: exit code 1 names what differs

Renders are 24x24 with 4 samples per pixel, on Embree and obvhs alike. A binary of any optimisation level will do, but hashes of two levels
may differ: compare like with like. It takes about a minute with an optimised binary.
"""

import argparse
import concurrent.futures
import json
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
SCENES = [
    "scenes/cornell-box/scene.gltf",
    "scenes/veach-mis/scene.gltf",
    "scenes/sphere-lamp/scene.gltf",
    "scenes/modified-cornell/scene.gltf",
    "scenes/glass-caustic/scene.gltf",
    "scenes/ajar-door/scene.gltf",
    "scenes/textured-box/scene.gltf",
    "scenes/mirror-caustic/scene.gltf",
    "scenes/met/touching/glass-on-table-01.gltf",
    "scenes/met/nested-media/wedge-1.33-1.5.gltf",
]
METHODS = ["path-naive", "path-nee", "path", "light", "bdpt", "pssmlt", "mmlt", "mlt"]


def pixel_hash(binary, scene, method, backend):
    with tempfile.TemporaryDirectory() as folder:
        line = [binary, "render", str(ROOT / scene), "--method", method, "--backend", backend, "--size", "24x24", "--spp", "4"]
        line += ["--threads", "1", "--quiet", "--json", "--output", f"{folder}/x.exr"]
        ran = subprocess.run(line, capture_output=True, text=True)
        if ran.returncode != 0:
            return f"exit code {ran.returncode}: {ran.stderr.strip().splitlines()[-1]}"
        return json.loads(ran.stdout)["pixel_hash"]


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("binary")
    arguments.add_argument("--write", metavar="FILE")
    arguments.add_argument("--check", metavar="FILE")
    arguments.add_argument("--backends", default="embree,obvhs")
    given = arguments.parse_args()
    jobs = [(s, m, b) for s in SCENES for m in METHODS for b in given.backends.split(",")]
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        hashes = list(pool.map(lambda job: pixel_hash(given.binary, *job), jobs))
    lines = [f"{scene} {method} {backend} {found}" for (scene, method, backend), found in zip(jobs, hashes)]
    if given.write:
        pathlib.Path(given.write).write_text("\n".join(lines) + "\n")
    if given.check:
        before = pathlib.Path(given.check).read_text().splitlines()
        differing = sorted(set(lines) ^ set(before))
        print("\n".join(differing) if differing else f"all {len(lines)} hashes are equal")
        sys.exit(1 if differing else 0)
    if not given.write:
        print("\n".join(lines))


if __name__ == "__main__":
    main()
