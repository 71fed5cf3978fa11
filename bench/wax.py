#!/usr/bin/env python3
"""Renders scenes/wax by étendue (random walk and diffusion models) and by Cycles's random walk, interleaved, and prints
relMSE × CPU seconds of each.

    bench/wax.py --etendue target/release/etendue --seeds 3

It needs numpy, OpenEXR and bpy: run it with the python of the environment that shared/peers/setup.sh makes. Each relMSE is the
variance between seeds over the squared mean of that renderer's own pictures plus .01 of its mean squared, since the pictures
differ: Cycles lets light into a body like a diffuse surface does, without refraction, and takes a colour and a mean free path.
It gets the colour of a deep body of our wax (the inverse of [KullaConty17]) and its mean free path. Times are processor seconds of
rendering, without loading. Pictures: 256², box filter.
"""
import argparse
import json
import math
import resource
import subprocess
from pathlib import Path

import numpy as np

from media_scenes import cycles_layer, read_exr

ROOT = Path(__file__).resolve().parent.parent
WAX = ROOT / "scenes" / "wax"
ABSORPTION, SCATTERING, INDEX = np.array([2.0, 8.0, 40.0]), np.array([900.0, 1000.0, 1100.0]), 1.44
ETENDUE = {"walk": [], "photon-beam": ["--subsurface", "photon-beam"], "burley": ["--subsurface", "burley"]}


def colour():
    """The reflectance of diffuse light by a deep body of the medium, after van de Hulst."""
    s = np.sqrt(ABSORPTION / (ABSORPTION + SCATTERING))
    return (1 - s) * (1 - 0.139 * s) / (1 + 1.17 * s)


def meshes():
    """Positions, triangles and material of all meshes, Y up, with the matrix of their node left out: none has one."""
    gltf, data = json.loads((WAX / "scene.gltf").read_text()), (WAX / "scene.bin").read_bytes()

    def read(index, kind, width):
        accessor = gltf["accessors"][index]
        view = gltf["bufferViews"][accessor["bufferView"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        return np.frombuffer(data, kind, accessor["count"] * width, start).reshape(-1, width)

    for node in gltf["nodes"]:
        if "mesh" in node:
            for primitive in gltf["meshes"][node["mesh"]]["primitives"]:
                kind = {5125: "<u4", 5123: "<u2"}[gltf["accessors"][primitive["indices"]]["componentType"]]
                positions, corners = read(primitive["attributes"]["POSITION"], "<f4", 3), read(primitive["indices"], kind, 1)
                smooth = "NORMAL" in primitive["attributes"]
                yield node["name"], positions, corners.reshape(-1, 3), gltf["materials"][primitive["material"]]["name"], smooth


def material(bpy, name):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    if name == "floor":
        shader = tree.nodes.new("ShaderNodeBsdfDiffuse")
        shader.inputs["Color"].default_value = (0.4, 0.4, 0.42, 1)
    elif name == "light":
        shader = tree.nodes.new("ShaderNodeEmission")
        front = tree.nodes.new("ShaderNodeNewGeometry")
        strength = tree.nodes.new("ShaderNodeMath")
        strength.operation = "MULTIPLY_ADD"
        strength.inputs[1].default_value, strength.inputs[2].default_value = -40.0, 40.0
        tree.links.new(front.outputs["Backfacing"], strength.inputs[0])
        tree.links.new(strength.outputs[0], shader.inputs["Strength"])
        made.cycles.emission_sampling = "FRONT"
    else:
        scattered = tree.nodes.new("ShaderNodeSubsurfaceScattering")
        scattered.falloff = "RANDOM_WALK"
        scattered.inputs["Color"].default_value = (*colour(), 1)
        scattered.inputs["Radius"].default_value = tuple(1 / (ABSORPTION + SCATTERING))
        scattered.inputs["Scale"].default_value = 1.0
        scattered.inputs["IOR"].default_value = INDEX
        scattered.inputs["Roughness"].default_value = 0.0
        glossy = tree.nodes.new("ShaderNodeBsdfAnisotropic")
        glossy.inputs["Roughness"].default_value = 0.0
        fresnel = tree.nodes.new("ShaderNodeFresnel")
        fresnel.inputs["IOR"].default_value = INDEX
        shader = tree.nodes.new("ShaderNodeMixShader")
        tree.links.new(fresnel.outputs[0], shader.inputs[0])
        tree.links.new(scattered.outputs[0], shader.inputs[1])
        tree.links.new(glossy.outputs[0], shader.inputs[2])
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return made


def cycles_scene(size):
    import bpy
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    materials = {}
    for name, positions, triangles, surface, smooth in meshes():
        mesh = bpy.data.meshes.new(name)
        # Y up becomes Z up: (x, y, z) is (x, -z, y).
        mesh.from_pydata(positions[:, [0, 2, 1]] * [1, -1, 1], [], triangles.tolist())
        mesh.polygons.foreach_set("use_smooth", [smooth] * len(triangles))
        if surface not in materials:
            materials[surface] = material(bpy, surface)
        mesh.materials.append(materials[surface])
        scene.collection.objects.link(bpy.data.objects.new(name, mesh))
    world = bpy.data.worlds.new("none")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0, 0, 0, 1)
    scene.world = world
    camera = bpy.data.cameras.new("camera")
    camera.angle, camera.clip_start = math.radians(40.0), 1e-3
    placed = bpy.data.objects.new("camera", camera)
    placed.location, placed.rotation_euler = (0.0, -1.1, 0.4), (math.radians(90 - 15), 0, 0)
    scene.collection.objects.link(placed)
    scene.camera = placed
    render, cycles = scene.render, scene.cycles
    render.resolution_x = render.resolution_y = size
    render.threads_mode, render.threads = "FIXED", 2
    render.image_settings.media_type, render.image_settings.file_format = "MULTI_LAYER_IMAGE", "OPEN_EXR_MULTILAYER"
    render.image_settings.color_depth = "32"
    scene.view_settings.view_transform = "Raw"
    cycles.device, cycles.pixel_filter_type, cycles.use_adaptive_sampling, cycles.use_denoising = "CPU", "BOX", False, False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.light_sampling_threshold = cycles.blur_glossy = 0
    for bounces in ("max", "diffuse", "glossy", "transmission", "volume", "transparent_max"):
        setattr(cycles, f"{bounces}_bounces", 64)
    return bpy, scene


def render_cycles(bpy, scene, out, spp, seed):
    path = out / f"cycles-{seed}.exr"
    scene.cycles.samples, scene.cycles.seed, scene.render.filepath = spp, seed, str(path)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_utime
    bpy.ops.render.render(write_still=True)
    return path, resource.getrusage(resource.RUSAGE_SELF).ru_utime - before


def render_etendue(arguments, name, options, seed):
    out, report = arguments.out / f"{name}-{seed}.exr", arguments.out / f"{name}-{seed}.json"
    out.unlink(missing_ok=True)
    size = f"{arguments.size}x{arguments.size}"
    subprocess.run([arguments.etendue, "render", WAX / "scene.gltf", *options, "--size", size, "--filter", "box", "--spp", str(arguments.spp),
                    "--replicates", "1", "--seed", str(seed), "-o", out, "--report", report, "--quiet"], check=True, capture_output=True)
    return read_exr(out), json.loads(report.read_text())["render"]["cpu_seconds"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--etendue", default="target/release/etendue")
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--cycles-spp", type=int, default=64)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--out", type=Path, default=ROOT / "bench" / "out" / "wax")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    bpy, scene = cycles_scene(arguments.size)
    pictures, seconds = {}, {}
    for seed in range(1, arguments.seeds + 1):
        for name, options in ETENDUE.items():
            image, cpu = render_etendue(arguments, name, options, seed)
            pictures.setdefault(name, []).append(image), seconds.setdefault(name, []).append(cpu)
        path, cpu = render_cycles(bpy, scene, arguments.out, arguments.cycles_spp, seed)
        pictures.setdefault("cycles", []).append(cycles_layer(path)), seconds.setdefault("cycles", []).append(cpu)
    for name, images in pictures.items():
        stack = np.stack(images).mean(-1)
        mean, variance = stack.mean(0), stack.var(0, ddof=1)
        relative = variance / (mean ** 2 + 0.01 * mean.mean() ** 2)
        cpu = float(np.mean(seconds[name]))
        print(f"{name:12} relMSE {relative.mean():.4g} (median {np.median(relative):.3g}), {cpu:.2f} s, product {relative.mean() * cpu:.4g}, "
              f"mean {stack.mean():.5f}")


if __name__ == "__main__":
    main()
