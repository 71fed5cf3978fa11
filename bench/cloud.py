#!/usr/bin/env python3
"""Renders scenes/cloud by étendue and by Mitsuba 3, interleaved, and prints relMSE × CPU seconds of both.

    bench/cloud.py --etendue target/release/etendue --spp 16 --mitsuba-spp 16

It needs numpy, OpenEXR and mitsuba: run it with the python of the environment that shared/peers/setup.sh makes. relMSE is
the variance between seeds over the squared mean of all pictures plus .01 of its mean squared; times are processor seconds of
rendering, without loading and without Mitsuba's first picture, which compiles. Pictures: 256², box filter, unlimited depth
(étendue: 512 events). The means are compared, too: Mitsuba's map has its first and last rows at the poles, so that the sky
differs by some 1e-4.
"""
import argparse
import json
import subprocess
import time
from pathlib import Path

import numpy as np

from media_scenes import read_exr, turn

ROOT = Path(__file__).resolve().parent.parent
CLOUD = ROOT / "scenes" / "cloud"


def camera(mi):
    """The camera of scene.gltf, which looks along -Z as all of glTF; Mitsuba's look along +Z and to the left."""
    nodes = json.loads((CLOUD / "scene.gltf").read_text())["nodes"]
    node = next(node for node in nodes if "camera" in node)
    x, y, z, w = node["rotation"]
    forward = np.array([-2 * (x * z + w * y), -2 * (y * z - w * x), -(1 - 2 * (x * x + y * y))])
    origin = np.array(node["translation"])
    return mi.ScalarTransform4f().look_at(origin=list(origin), target=list(origin + forward), up=[0, 1, 0])


def mitsuba_scene(mi, size):
    """The scene as a dictionary."""
    low, high = np.frombuffer((CLOUD / "cloud.vol").read_bytes()[24:48], "<f4").reshape(2, 3).astype(float)
    place = mi.ScalarTransform4f().translate(list((low + high) / 2)).scale(list((high - low) / 2))
    colour = {"type": "rgb", "value": [1.0, 1.0, 1.0]}
    medium = {"type": "heterogeneous", "scale": 24.0, "albedo": colour, "phase": {"type": "hg", "g": 0.8},
              "sigma_t": {"type": "gridvolume", "filename": str(CLOUD / "cloud.vol"), "use_grid_bbox": True, "raw": True}}
    meadow = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.12, 0.16, 0.07]}}
    film = {"type": "hdrfilm", "width": size, "height": size, "rfilter": {"type": "box"}, "pixel_format": "rgb",
            "component_format": "float32"}
    return {
        "type": "scene",
        "integrator": {"type": "volpath", "max_depth": -1, "rr_depth": 32},
        "sensor": {"type": "perspective", "fov": 50.0, "near_clip": 1e-3, "far_clip": 1e4, "film": film,
                   "to_world": camera(mi), "sampler": {"type": "independent"}},
        "cloud": {"type": "cube", "to_world": place, "bsdf": {"type": "null"}, "interior": medium},
        "meadow": {"type": "rectangle", "bsdf": {"type": "twosided", "inner": meadow},
                   "to_world": mi.ScalarTransform4f().rotate([1, 0, 0], -90).scale([40, 40, 1])},
        "sky": {"type": "envmap", "filename": str(CLOUD / "env.exr"), "to_world": mi.ScalarTransform4f(turn(1, 90.0))},
    }


def render_etendue(arguments, method, seed):
    out, report = arguments.out / f"{method}-{seed}.exr", arguments.out / f"{method}-{seed}.json"
    out.unlink(missing_ok=True)
    subprocess.run([arguments.etendue, "render", CLOUD / "scene.gltf", "--method", method, "--size", f"{arguments.size}x{arguments.size}",
                    "--filter", "box", "--spp", str(arguments.spp), "--replicates", "1", "--seed", str(seed), "-o", out,
                    "--report", report, "--quiet"], check=True)
    return read_exr(out), json.loads(report.read_text())["render"]["cpu_seconds"]


def render_mitsuba(arguments, mi, scene, seed):
    begun = time.process_time()
    image = np.array(mi.render(scene, spp=arguments.mitsuba_spp, seed=seed), float)
    return image, time.process_time() - begun


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--etendue", default=str(ROOT / "target" / "release" / "etendue"))
    parser.add_argument("--out", type=Path, default=ROOT / "bench" / "out" / "cloud")
    parser.add_argument("--methods", nargs="+", default=["path", "bdpt"])
    parser.add_argument("--variant", default="llvm_ad_rgb")
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--spp", type=int, default=16)
    parser.add_argument("--mitsuba-spp", type=int, default=16)
    parser.add_argument("--seeds", type=int, default=4)
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    import mitsuba as mi
    mi.set_variant(arguments.variant)
    scene = mi.load_dict(mitsuba_scene(mi, arguments.size))
    render_mitsuba(arguments, mi, scene, 999)
    rows = {name: ([], []) for name in ["mitsuba", *arguments.methods]}
    for seed in range(1, arguments.seeds + 1):
        for name, (images, times) in rows.items():
            made = render_mitsuba(arguments, mi, scene, seed) if name == "mitsuba" else render_etendue(arguments, name, seed)
            images.append(made[0])
            times.append(made[1])
    every = np.mean([image for images, _ in rows.values() for image in images], 0)
    for name, (images, times) in rows.items():
        variance = np.var(images, 0, ddof=1)
        relmse = np.mean(variance / (every ** 2 + 0.01 * every.mean() ** 2))
        mean = np.array([image.mean() for image in images])
        print(f"{name:8s} relMSE {relmse:.4g}, {np.mean(times):.2f} CPU s, product {relmse * np.mean(times):.4g}, "
              f"mean {mean.mean():.5f} ± {mean.std(ddof=1) / len(mean) ** 0.5:.5f}")


if __name__ == "__main__":
    main()
