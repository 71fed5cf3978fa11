#!/usr/bin/env python3
"""Renders scenes/cloud by étendue and by Mitsuba 3 or Cycles, interleaved, and prints relMSE × CPU seconds of both.

    bench/cloud.py --etendue target/release/etendue --spp 16 --peer-spp 16
    bench/cloud.py --peer cycles --peer-spp 16

It needs numpy, OpenEXR and mitsuba or bpy: run it with the python of the environment that shared/peers/setup.sh makes. relMSE is
the variance between seeds over the squared mean of all pictures plus .01 of its mean squared; times are processor seconds of
rendering, without loading and without the peer's first picture, which compiles. Pictures: 256², box filter, unlimited depth
(étendue: 512 events). The means are compared, too: Mitsuba's map has its first and last rows at the poles, so that the sky
differs by some 1e-4.
"""
import argparse
import json
import math
import subprocess
import time
from pathlib import Path

import numpy as np

from media_scenes import cycles_layer, read_exr, turn

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
    image = np.array(mi.render(scene, spp=arguments.peer_spp, seed=seed), float)
    return image, time.process_time() - begun


def cycles_scene(size, out):
    import bpy
    bpy.utils.expose_bundled_modules()
    import mathutils
    import openvdb
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    upright = mathutils.Quaternion((1, 0, 0), math.pi / 2)

    def add(name, data, material=None):
        placed = bpy.data.objects.new(name, data)
        # Y up becomes Z up.
        placed.rotation_mode, placed.rotation_quaternion = "QUATERNION", upright
        if material:
            data.materials.append(material)
        scene.collection.objects.link(placed)
        return placed

    def shader(name, socket, kind):
        material = bpy.data.materials.new(name)
        material.use_nodes = True
        tree = material.node_tree
        tree.nodes.clear()
        node, output = tree.nodes.new(kind), tree.nodes.new("ShaderNodeOutputMaterial")
        tree.links.new(node.outputs[0], output.inputs[socket])
        return material, tree, node

    header = np.frombuffer((CLOUD / "cloud.vol").read_bytes()[8:24], "<i4")
    cells = np.frombuffer((CLOUD / "cloud.vol").read_bytes()[48:], "<f4").reshape(header[2], header[1], header[0])
    low, high = np.frombuffer((CLOUD / "cloud.vol").read_bytes()[24:48], "<f4").reshape(2, 3).astype(float)
    grid, step = openvdb.FloatGrid(0.0), (high - low) / header[:3]
    grid.copyFromArray(np.ascontiguousarray(cells.transpose(2, 1, 0)))
    grid.name, grid.gridClass = "density", openvdb.GridClass.FOG_VOLUME
    rows = np.diag([*step, 1.0])
    rows[3, :3] = low + 0.5 * step
    grid.transform = openvdb.createLinearTransform(rows.tolist())
    openvdb.write(str(out / "cloud.vdb"), grids=[grid])
    volume = bpy.data.volumes.new("cloud")
    volume.filepath = str(out / "cloud.vdb")
    material, tree, scatter = shader("cloud", "Volume", "ShaderNodeVolumeScatter")
    density, times = tree.nodes.new("ShaderNodeAttribute"), tree.nodes.new("ShaderNodeMath")
    density.attribute_name, times.operation, times.inputs[1].default_value = "density", "MULTIPLY", 24.0
    tree.links.new(density.outputs["Fac"], times.inputs[0])
    tree.links.new(times.outputs[0], scatter.inputs["Density"])
    scatter.inputs["Color"].default_value, scatter.inputs["Anisotropy"].default_value = (1, 1, 1, 1), 0.8
    add("cloud", volume, material)
    meadow = bpy.data.meshes.new("meadow")
    meadow.from_pydata([(-40, 0, -40), (-40, 0, 40), (40, 0, 40), (40, 0, -40)], [], [(0, 1, 2), (0, 2, 3)])
    material, _, diffuse = shader("meadow", "Surface", "ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = (0.12, 0.16, 0.07, 1)
    add("meadow", meadow, material)
    world = bpy.data.worlds.new("sky")
    world.use_nodes = True
    picture = world.node_tree.nodes.new("ShaderNodeTexEnvironment")
    picture.image = bpy.data.images.load(str(CLOUD / "env.exr"))
    picture.image.colorspace_settings.name = "Linear Rec.709"
    world.node_tree.links.new(picture.outputs[0], world.node_tree.nodes["Background"].inputs["Color"])
    scene.world = world
    node = next(node for node in json.loads((CLOUD / "scene.gltf").read_text())["nodes"] if "camera" in node)
    x, y, z, w = node["rotation"]
    lens = bpy.data.cameras.new("camera")
    lens.angle, lens.clip_start, lens.clip_end = math.radians(50.0), 1e-3, 1e4
    scene.camera = add("camera", lens)
    scene.camera.rotation_quaternion = upright @ mathutils.Quaternion((w, x, y, z))
    scene.camera.location = upright @ mathutils.Vector(node["translation"])
    render, cycles = scene.render, scene.cycles
    render.resolution_x = render.resolution_y = size
    render.threads_mode, render.threads = "FIXED", 2
    render.image_settings.media_type, render.image_settings.file_format = "MULTI_LAYER_IMAGE", "OPEN_EXR_MULTILAYER"
    render.image_settings.color_depth = "32"
    cycles.device, cycles.pixel_filter_type, cycles.use_adaptive_sampling, cycles.use_denoising = "CPU", "BOX", False, False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.light_sampling_threshold = 0
    for bounces in ("max", "diffuse", "glossy", "transmission", "volume", "transparent_max"):
        setattr(cycles, f"{bounces}_bounces", 512)
    return bpy, scene


def render_cycles(arguments, made, seed):
    bpy, scene = made
    path = arguments.out / f"cycles-{seed}.exr"
    scene.cycles.samples, scene.cycles.seed, scene.render.filepath = arguments.peer_spp, seed, str(path)
    begun = time.process_time()
    bpy.ops.render.render(write_still=True)
    return cycles_layer(path), time.process_time() - begun


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--etendue", default=str(ROOT / "target" / "release" / "etendue"))
    parser.add_argument("--out", type=Path, default=ROOT / "bench" / "out" / "cloud")
    parser.add_argument("--methods", nargs="+", default=["path", "bdpt"])
    parser.add_argument("--variant", default="llvm_ad_rgb")
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--spp", type=int, default=16)
    parser.add_argument("--peer", choices=["mitsuba", "cycles"], default="mitsuba")
    parser.add_argument("--peer-spp", type=int, default=16)
    parser.add_argument("--seeds", type=int, default=4)
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    if arguments.peer == "mitsuba":
        import mitsuba as mi
        mi.set_variant(arguments.variant)
        scene = mi.load_dict(mitsuba_scene(mi, arguments.size))
        peer = lambda seed: render_mitsuba(arguments, mi, scene, seed)
    else:
        made = cycles_scene(arguments.size, arguments.out)
        peer = lambda seed: render_cycles(arguments, made, seed)
    peer(999)
    rows = {name: ([], []) for name in [arguments.peer, *arguments.methods]}
    for seed in range(1, arguments.seeds + 1):
        for name, (images, times) in rows.items():
            made = peer(seed) if name == arguments.peer else render_etendue(arguments, name, seed)
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
