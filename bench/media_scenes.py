#!/usr/bin/env python3
"""Renders small scenes with participating media by étendue and by Mitsuba 3 and tests whether the pictures agree.

    bench/media_scenes.py --etendue target/release/etendue --out bench/out/media
    bench/media_scenes.py --only grid-lamp smooth-map --methods path bdpt

It needs numpy, OpenEXR and mitsuba: run it with the python of the environment that shared/peers/setup.sh makes. Each
scene is described once and written as glTF and as a dictionary of Mitsuba. Both programs render it with the same number
of seeds and a box filter, without a limit of the path depth. Tested are:

- the mean of the image: the ratio of the two programs is within --mean of 1;
- that mean and 4×4 tiles, each channel: Welch's test on the means by seed of both programs, with Holm's correction for
  all tests of a run; differences below --tolerance of the value are allowed, for rounding and interpolation of maps;
- where a closed form is known, both programs against it in the same way.

The exit code is 1 if a test fails. Conventions: glTF's axes (Y up) for both; emitters are one-sided; diffuse is Lambert
and two-sided; spots are sharp, since their fall-off differs; alpha is that of GGX, glTF's roughness its root.
Mitsuba masks reflection by rough glass by the product of both directions and étendue by their correlated form: alpha is
so small here that the difference is below the noise. Mitsuba's maps begin a quarter turn from étendue's and have texels
at the poles: each program gets the same sky at its own texels.
"""
import argparse
import json
import math
import struct
import subprocess
import sys
import time
import zlib
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import OpenEXR

ROOT = Path(__file__).resolve().parent.parent
TILES = 4

# --- descriptions ------------------------------------------------------------------------------------------------------


@dataclass
class Medium:
    """What fills a body, with coefficients per unit of length, and its boundary: null, smooth or rough."""
    scattering: tuple
    absorption: tuple
    phase: object = "isotropic"  # as extras.etendue.phase
    boundary: str = "null"
    ior: float = 1.5
    alpha: float = 0.1
    grid: object = None  # densities, indexed by z, y, x
    bounds: tuple = ((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))  # box of the grid

    def index(self):
        return 1.0 if self.boundary == "null" else self.ior

    def roughness(self):
        return math.sqrt(self.alpha) if self.boundary == "rough" else 0.0


@dataclass
class Thing:
    """A mesh with its place and what it is made of: one of diffuse, emission and medium."""
    name: str
    mesh: tuple
    place: np.ndarray = field(default_factory=lambda: np.eye(4))
    diffuse: tuple = None
    emission: tuple = None
    medium: Medium = None


@dataclass
class Spot:
    position: tuple
    target: tuple
    intensity: tuple
    angle: float  # half the cone, degrees


@dataclass
class Scene:
    name: str
    things: list
    spp: int  # for each seed
    environment: object = None  # a radiance or "map"
    spot: Spot = None
    origin: tuple = (0.0, 0.6, 5.0)
    target: tuple = (0.0, 0.0, 0.0)
    fov: float = 36.0
    closed_form: object = None  # function of the scene and the size of the image


# --- meshes and transforms ---------------------------------------------------------------------------------------------


def box(low, high):
    """A box whose faces look outwards."""
    corners = [(x, y, z) for z in (low[2], high[2]) for y in (low[1], high[1]) for x in (low[0], high[0])]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return corners, [t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))]


def cube(half=1.0):
    return box((-half,) * 3, (half,) * 3)


def rectangle(a, b, c, d):
    """It looks to where its corners run counter-clockwise."""
    return [a, b, c, d], [(0, 1, 2), (0, 2, 3)]


def turn(axis, degrees):
    """A rotation about axis 0, 1 or 2."""
    cos, sin = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.eye(4)
    matrix[i, i], matrix[i, j], matrix[j, i], matrix[j, j] = cos, -sin, sin, cos
    return matrix


def shift(x, y, z):
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


def looking(origin, target):
    """The place of a camera or spot of glTF, which looks along its -Z."""
    origin, target = np.array(origin, float), np.array(target, float)
    back = (origin - target) / np.linalg.norm(origin - target)
    right = np.cross((0.0, 1.0, 0.0), back)
    right /= np.linalg.norm(right)
    matrix = np.eye(4)
    matrix[:3, :] = np.stack([right, np.cross(back, right), back, origin], -1)
    return matrix


# --- the scenes --------------------------------------------------------------------------------------------------------

TILTED = turn(1, 35.0) @ turn(0, 20.0)
FLOOR = Thing("floor", rectangle((-3, -1.6, 3), (3, -1.6, 3), (3, -1.6, -3), (-3, -1.6, -3)), diffuse=(0.7, 0.6, 0.5))
LAMP = Thing("lamp", rectangle((0.6, 2.4, 0.6), (0.6, 2.4, -0.6), (1.8, 1.8, -0.6), (1.8, 1.8, 0.6)),
             emission=(9.0, 8.0, 6.0))


def grey(x):
    return (x, x, x)


def filled(medium, mesh=None, place=TILTED):
    return Thing("medium", mesh or cube(), place, medium=medium)


def under_environments():
    """A tilted cube of each boundary under a constant environment and under a map."""
    media = {"null": Medium(grey(1.2), grey(0.3)), "smooth": Medium(grey(1.2), grey(0.3), boundary="smooth"),
             "rough": Medium(grey(1.2), grey(0.3), boundary="rough")}
    for boundary, medium in media.items():
        yield Scene(f"{boundary}-constant", [filled(medium)], 128, environment=1.0)
        yield Scene(f"{boundary}-map", [filled(medium)], 128, environment="map")


def under_lamps():
    yield Scene("area-lamp", [filled(Medium((1.5, 1.2, 0.9), (0.1, 0.1, 0.4), 0.3)), FLOOR, LAMP], 512)
    spot = Spot((2.6, 2.4, 1.2), (0.0, 0.0, 0.0), (40.0, 30.0, 25.0), 16.0)
    yield Scene("spot", [filled(Medium(grey(1.0), grey(0.2), "rayleigh")), FLOOR], 1024, spot=spot)
    glowing = Thing("glowing", cube(0.35), shift(0.3, 0.2, -0.1) @ turn(2, 30.0), emission=(6.0, 5.0, 4.0))
    yield Scene("emitter-inside", [filled(Medium(grey(1.5), (0.2, 0.4, 0.6), -0.4)), glowing, FLOOR], 1024)
    solid = Thing("solid", cube(0.45), turn(0, 40.0) @ turn(2, 30.0), diffuse=(0.8, 0.3, 0.2))
    two_lobes = Medium(grey(0.8), grey(0.1), (0.7, -0.4, 0.65))
    yield Scene("object-inside", [filled(two_lobes), solid, FLOOR, LAMP], 512)


def with_colours():
    chromatic = Medium((0.4, 1.5, 4.0), (0.1, 0.3, 1.0))
    yield Scene("chromatic", [filled(chromatic)], 128, environment="map")
    forward = Medium((2.7, 2.1, 1.2), (0.3, 0.9, 1.8), 0.8)
    yield Scene("forward-colour", [filled(forward)], 128, environment="map")


def densities(size, seed, contrast):
    """Random densities from 0 to about `contrast`, a third of them 0; indexed by z, y, x."""
    values = np.random.default_rng(seed).uniform(-0.5, 1.0, size[::-1])
    return (contrast * np.maximum(values, 0.0) ** 2).astype("<f4")


def with_grids():
    low, high = (-1.0, -0.8, -1.1), (1.0, 0.9, 0.7)
    medium = Medium(grey(1.6), grey(0.4), grid=densities((5, 7, 4), 1, 3.0), bounds=(low, high))
    yield Scene("grid-lamp", [filled(medium, box(low, high), turn(1, 15.0)), FLOOR, LAMP], 512)
    low, high = (-1.2, -0.7, -0.9), (0.8, 1.0, 1.0)
    medium = Medium((0.9, 0.7, 0.5), (0.1, 0.3, 0.5), 0.5, grid=densities((16, 12, 20), 2, 8.0), bounds=(low, high))
    turned = shift(0.2, 0.1, 0.0) @ turn(2, 25.0) @ TILTED
    yield Scene("grid-turned", [filled(medium, box(low, high), turned), LAMP], 512, environment="map")


def primary_rays(scene, size, points=6):
    """Directions of Gauss points of each pixel, [row, column, sub-row, sub-column, axis], and the shares of the points."""
    at, weights = np.polynomial.legendre.leggauss(points)
    offsets = ((np.arange(size)[:, None] + 0.5 + 0.5 * at) / size * 2 - 1) * math.tan(math.radians(scene.fov) / 2)
    x, y = offsets[None, :, None, :], -offsets[:, None, :, None]
    local = np.stack(np.broadcast_arrays(x, y, -1.0), -1)
    directions = local @ looking(scene.origin, scene.target)[:3, :3].T
    return directions / np.linalg.norm(directions, axis=-1, keepdims=True), np.outer(weights, weights) / 4


def density_at(medium, points):
    """The density in the coordinates of the mesh, linear between the centres of cells and constant beyond."""
    if medium.grid is None:
        return np.ones(points.shape[:-1])
    low, high = np.array(medium.bounds)
    values, sides = medium.grid.astype(float), np.array(medium.grid.shape[::-1])
    at = np.clip((points - low) / (high - low) * sides - 0.5, 0, sides - 1)
    first = np.minimum(at.astype(int), np.maximum(sides - 2, 0))
    part, total = at - first, 0.0
    for corner in np.ndindex(2, 2, 2):
        share = np.prod(np.where(corner, part, 1 - part), -1)
        x, y, z = np.moveaxis(np.minimum(first + corner, sides - 1), -1, 0)
        total = total + share * values[z, y, x]
    return total


def transmittance(scene, size, steps=400):
    """The mean over each pixel of exp(-depth) where the first thing, a box, only absorbs. Needs pixels without edges."""
    thing, image = scene.things[0], np.empty((size, size, 3))
    inverse, corners = np.linalg.inv(thing.place), np.array(thing.mesh[0])
    origin = (inverse @ [*scene.origin, 1.0])[:3]
    rays, shares = primary_rays(scene, size)
    for row, local in enumerate(rays @ inverse[:3, :3].T):
        planes = np.stack([(corners.min(0) - origin) / local, (corners.max(0) - origin) / local])
        start, end = planes.min(0).max(-1), planes.max(0).min(-1)
        along = start[..., None] + (end - start)[..., None] * (np.arange(steps) + 0.5) / steps
        depth = density_at(thing.medium, origin + along[..., None] * local[..., None, :]).mean(-1) * (end - start)
        image[row] = np.einsum("xijc,ij->xc", np.exp(-depth[..., None] * thing.medium.absorption), shares)
    return image


def absorbers():
    """Boxes wider than the view before an environment of radiance 1."""
    bounds = ((-4.0, -4.0, -1.4), (4.0, 4.0, 0.0))
    view = {"environment": 1.0, "origin": (0.0, 0.0, 3.0), "closed_form": transmittance}
    yield Scene("absorber", [filled(Medium(grey(0.0), (0.2, 0.9, 2.5)), box(*bounds), np.eye(4))], 1024, **view)
    thin = Medium(grey(0.0), grey(1.5), grid=densities((14, 11, 3), 3, 2.0), bounds=bounds)
    turned = turn(2, 20.0) @ turn(1, 12.0)
    yield Scene("absorber-grid", [filled(thin, box(*bounds), turned)], 1024, **view)


def all_scenes():
    return [*under_environments(), *under_lamps(), *with_colours(), *with_grids(), *absorbers()]


# --- files that both programs read -------------------------------------------------------------------------------------


def write_exr(path, image):
    OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage},
                 {"RGB": np.ascontiguousarray(image, np.float32)}).write(str(path))


def read_exr(path):
    channels = OpenEXR.File(str(path), separate_channels=True).channels()
    return np.stack([channels[name].pixels for name in "RGB"], -1).astype(float)


def cycles_layer(path):
    """The combined layer of a picture by Cycles."""
    with OpenEXR.File(str(path)) as file:
        for part in file.parts:
            for name, channel in part.channels.items():
                if name.endswith("Combined") or name in ("RGBA", "RGB"):
                    return np.asarray(channel.pixels[..., :3], float)
            found = {name.rsplit(".", 1)[-1]: channel.pixels for name, channel in part.channels.items() if "Combined" in name}
            if {"R", "G", "B"} <= found.keys():
                return np.stack([np.asarray(found[c], float) for c in "RGB"], -1)
    raise SystemExit(f"{path}: no layer Combined")


def sky(w):
    """A smooth radiance without any symmetry in the unit direction `w`: three lobes of light over a gradient."""
    radiance = 0.3 + 0.2 * (w[..., 1:2] + 1) * np.array([0.6, 0.8, 1.2])
    lobes = [((0.8, 0.5, 0.3), 30.0, (9, 7, 4)), ((-0.5, 0.1, 0.85), 12.0, (1, 3, 2)), ((-0.3, -0.6, -0.7), 8.0, (2, 1, 3))]
    for axis, exponent, colour in lobes:
        cos = w @ (np.array(axis) / np.linalg.norm(axis))
        radiance = radiance + np.exp(exponent * (cos[..., None] - 1)) * np.array(colour)
    return radiance


def write_maps(folder, width=1024, height=512):
    """The sky at the texels of étendue's maps and of Mitsuba's, whose first and last rows are at the poles."""
    phi = (0.5 - (np.arange(width) + 0.5) / width) * 2 * math.pi
    rows = {"map": (np.arange(height) + 0.5) / height, "map-mitsuba": np.arange(height) / (height - 1)}
    for name, v in rows.items():
        theta = v[:, None] * math.pi
        w = np.stack(np.broadcast_arrays(np.sin(theta) * np.cos(phi), np.cos(theta), -np.sin(theta) * np.sin(phi)), -1)
        write_exr(folder / f"{name}.exr", sky(w))


def write_grid(path, medium):
    """Mitsuba's binary volume, version 3."""
    z, y, x = medium.grid.shape
    (low, high), header = medium.bounds, b"VOL\x03"
    header += struct.pack("<5i6f", 1, x, y, z, 1, *low, *high)
    path.write_bytes(header + medium.grid.tobytes())


def write_ply(path, mesh):
    positions, triangles = mesh
    head = ["ply", "format ascii 1.0", f"element vertex {len(positions)}"] + [f"property float {a}" for a in "xyz"]
    head += [f"element face {len(triangles)}", "property list uchar int vertex_indices", "end_header"]
    lines = [" ".join(repr(float(x)) for x in p) for p in positions] + [f"3 {a} {b} {c}" for a, b, c in triangles]
    path.write_text("\n".join(head + lines) + "\n")


def seeds(arguments, scene):
    """Others in each scene: a program's errors would be alike in scenes that are alike."""
    first = zlib.crc32(scene.name.encode()) % 1_000_000 + arguments.seed
    return range(first, first + arguments.seeds)


def write_shared(folder, scene):
    folder.mkdir(parents=True, exist_ok=True)
    for thing in scene.things:
        write_ply(folder / f"{thing.name}.ply", thing.mesh)
        if thing.medium and thing.medium.grid is not None:
            write_grid(folder / f"{thing.name}.vol", thing.medium)


# --- étendue -----------------------------------------------------------------------------------------------------------


def surface(colour, roughness):
    return {"baseColorFactor": [*map(float, colour), 1.0], "metallicFactor": 0.0, "roughnessFactor": roughness}


def gltf_medium(thing):
    medium, shortest = thing.medium, max(thing.medium.absorption)
    volume = {"thicknessFactor": 1.0}
    if shortest > 0.0:
        volume["attenuationDistance"] = 1.0 / shortest
        volume["attenuationColor"] = [math.exp(-x / shortest) for x in medium.absorption]
    ours = {}
    if max(medium.scattering) > 0.0:
        ours |= {"scattering": list(medium.scattering), "phase": medium.phase}
    if medium.grid is not None:
        ours["density"] = f"{thing.name}.vol"
    return {"pbrMetallicRoughness": surface(grey(1.0), medium.roughness()),
            "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1.0},
                           "KHR_materials_ior": {"ior": medium.index()}, "KHR_materials_volume": volume},
            "extras": {"etendue": ours}}


def gltf_material(thing):
    if thing.medium:
        return gltf_medium(thing)
    lambert = {"KHR_materials_specular": {"specularFactor": 0.0}}
    if thing.diffuse:
        return {"pbrMetallicRoughness": surface(thing.diffuse, 1.0), "doubleSided": True, "extensions": lambert}
    strength = max(thing.emission)
    return {"pbrMetallicRoughness": surface(grey(0.0), 1.0), "emissiveFactor": [x / strength for x in thing.emission],
            "extensions": {**lambert, "KHR_materials_emissive_strength": {"emissiveStrength": strength}}}


def columns(matrix):
    return [float(x) for x in matrix.T.flatten()]


def gltf_meshes(scene):
    """The meshes with their accessors, views and buffer."""
    data, views, accessors, meshes = bytearray(), [], [], []
    for i, thing in enumerate(scene.things):
        positions, triangles = np.array(thing.mesh[0], "<f4"), np.array(thing.mesh[1], "<u4").flatten()
        bounds = {"min": positions.min(0).tolist(), "max": positions.max(0).tolist()}
        for array, target, rest in ((positions, 34962, {"componentType": 5126, "type": "VEC3", **bounds}),
                                    (triangles, 34963, {"componentType": 5125, "type": "SCALAR"})):
            accessors.append({"bufferView": len(views), "count": len(array), **rest})
            views.append({"buffer": 0, "byteOffset": len(data), "byteLength": array.nbytes, "target": target})
            data += array.tobytes()
        primitive = {"attributes": {"POSITION": 2 * i}, "indices": 2 * i + 1, "material": i}
        meshes.append({"name": thing.name, "primitives": [primitive]})
    return {"meshes": meshes, "accessors": accessors, "bufferViews": views,
            "buffers": [{"byteLength": len(data), "uri": "scene.bin"}]}, bytes(data)


def write_gltf(folder, scene):
    geometry, data = gltf_meshes(scene)
    nodes = [{"name": t.name, "mesh": i, "matrix": columns(t.place)} for i, t in enumerate(scene.things)]
    nodes.append({"name": "camera", "camera": 0, "matrix": columns(looking(scene.origin, scene.target))})
    lens = {"yfov": math.radians(scene.fov), "aspectRatio": 1.0, "znear": 0.001}
    materials = [{"name": t.name, **gltf_material(t)} for t in scene.things]
    used = {e for m in materials for e in m["extensions"]}
    document = {"asset": {"version": "2.0", "generator": "etendue bench/media_scenes.py"}, "scene": 0, "nodes": nodes,
                "cameras": [{"type": "perspective", "perspective": lens}], "materials": materials, **geometry}
    if spot := scene.spot:
        strength, angle = max(spot.intensity), math.radians(spot.angle)
        light = {"type": "spot", "intensity": strength, "color": [x / strength for x in spot.intensity],
                 "spot": {"innerConeAngle": angle - 1e-5, "outerConeAngle": angle}}
        document["extensions"] = {"KHR_lights_punctual": {"lights": [light]}}
        place = columns(looking(spot.position, spot.target))
        nodes.append({"name": "spot", "matrix": place, "extensions": {"KHR_lights_punctual": {"light": 0}}})
        used.add("KHR_lights_punctual")
    document["extensionsUsed"] = sorted(used)
    document["scenes"] = [{"nodes": list(range(len(nodes)))}]
    (folder / "scene.bin").write_bytes(data)
    (folder / "scene.gltf").write_text(json.dumps(document, indent=1))


def render_etendue(arguments, folder, scene, method):
    """One image for each seed."""
    images, out = [], folder / f"etendue-{method}.exr"
    options = ["--method", method, "--filter", "box", "--replicates", "1", "--size", f"{arguments.size}x{arguments.size}"]
    options += ["--strict", "--quiet", "--no-config", "--spp", str(scene.spp), "-o", str(out)]
    if scene.environment is not None:
        options += ["--env", str(arguments.out / "map.exr") if scene.environment == "map" else str(scene.environment)]
    for seed in seeds(arguments, scene):
        command = [arguments.etendue, "render", folder / "scene.gltf", *options, "--seed", str(seed)]
        subprocess.run([str(part) for part in command], check=True, stdout=subprocess.DEVNULL)
        images.append(read_exr(out))
    write_exr(out, np.mean(images, 0))
    return np.array(images)


# --- Mitsuba -----------------------------------------------------------------------------------------------------------


def mitsuba_rgb(values):
    return {"type": "rgb", "value": [float(x) for x in values]}


def mitsuba_phase(phase):
    if isinstance(phase, str):
        return {"type": phase}
    if isinstance(phase, tuple):
        return {"type": "blendphase", "weight": 1 - phase[2], "first": mitsuba_phase(phase[0]),
                "second": mitsuba_phase(phase[1])}
    return {"type": "hg", "g": phase}


def mitsuba_medium(mi, folder, thing):
    """A medium whose σt is at most 1 times a scale, since Mitsuba takes colours for reflectances."""
    medium = thing.medium
    total = np.add(medium.scattering, medium.absorption)
    if medium.grid is None:
        kind, density = "homogeneous", mitsuba_rgb(total / total.max())
    else:
        assert np.allclose(total, total[0]), "Mitsuba's grid of one channel has a grey σt"
        kind = "heterogeneous"
        density = {"type": "gridvolume", "filename": str(folder / f"{thing.name}.vol"), "use_grid_bbox": True, "raw": True,
                   "to_world": mi.ScalarTransform4f(thing.place)}
    return {"type": kind, "sigma_t": density, "scale": float(total.max()), "phase": mitsuba_phase(medium.phase),
            "albedo": mitsuba_rgb(np.array(medium.scattering) / total)}


def mitsuba_boundary(medium):
    indices = {"int_ior": medium.index(), "ext_ior": 1.0}
    return {"null": {"type": "null"}, "smooth": {"type": "dielectric", **indices},
            "rough": {"type": "roughdielectric", "distribution": "ggx", "alpha": medium.alpha, **indices}}[medium.boundary]


def mitsuba_shape(mi, folder, thing):
    shape = {"type": "ply", "filename": str(folder / f"{thing.name}.ply"), "face_normals": True,
             "to_world": mi.ScalarTransform4f(thing.place)}
    if thing.medium:
        return {**shape, "bsdf": mitsuba_boundary(thing.medium), "interior": mitsuba_medium(mi, folder, thing)}
    if thing.diffuse:
        lambert = {"type": "diffuse", "reflectance": mitsuba_rgb(thing.diffuse)}
        return {**shape, "bsdf": {"type": "twosided", "inner": lambert}}
    black = {"type": "diffuse", "reflectance": mitsuba_rgb(grey(0.0))}
    return {**shape, "bsdf": black, "emitter": {"type": "area", "radiance": mitsuba_rgb(thing.emission)}}


# The edge of étendue's spots is a squared ramp of this width in the cosine, as in glTF's sample code: a third of its light
# stays. Mitsuba gets the sharp cone of as much light.
RAMP = 1e-3


def mitsuba_lights(mi, arguments, scene):
    lights = {}
    if scene.environment == "map":
        quarter = mi.ScalarTransform4f(turn(1, 90.0))
        lights["env"] = {"type": "envmap", "filename": str(arguments.out / "map-mitsuba.exr"), "to_world": quarter}
    elif scene.environment is not None:
        lights["env"] = {"type": "constant", "radiance": mitsuba_rgb(grey(scene.environment))}
    if spot := scene.spot:
        place = mi.ScalarTransform4f().look_at(origin=spot.position, target=spot.target, up=(0, 1, 0))
        angle = math.degrees(math.acos(math.cos(math.radians(spot.angle)) + RAMP * 2 / 3))
        lights["spot"] = {"type": "spot", "to_world": place, "intensity": mitsuba_rgb(spot.intensity),
                          "cutoff_angle": angle, "beam_width": angle - 1e-3}
    return lights


def mitsuba_scene(mi, arguments, folder, scene):
    film = {"type": "hdrfilm", "width": arguments.size, "height": arguments.size, "rfilter": {"type": "box"},
            "pixel_format": "rgb", "component_format": "float32"}
    sensor = {"type": "perspective", "fov": scene.fov, "near_clip": 1e-3, "far_clip": 1e4, "film": film,
              "to_world": mi.ScalarTransform4f().look_at(origin=scene.origin, target=scene.target, up=(0, 1, 0)),
              "sampler": {"type": "independent"}}
    integrator = {"type": arguments.integrator, "max_depth": -1, "rr_depth": 32}
    shapes = {f"thing-{t.name}": mitsuba_shape(mi, folder, t) for t in scene.things}
    return {"type": "scene", "integrator": integrator, "sensor": sensor, **shapes, **mitsuba_lights(mi, arguments, scene)}


def render_mitsuba(mi, arguments, folder, scene):
    """One image for each seed."""
    loaded = mi.load_dict(mitsuba_scene(mi, arguments, folder, scene))
    spp = scene.spp * arguments.mitsuba_factor
    images = [np.array(mi.render(loaded, spp=spp, seed=seed), float) for seed in seeds(arguments, scene)]
    write_exr(folder / f"mitsuba-{arguments.integrator}.exr", np.mean(images, 0))
    return np.array(images)


# --- statistics --------------------------------------------------------------------------------------------------------


def beta_fraction(a, b, x):
    """The continued fraction of the incomplete beta function by Lentz's method."""
    tiny, c = 1e-300, 1.0
    d = 1 - (a + b) * x / (a + 1)
    d = 1 / (d if abs(d) > tiny else tiny)
    result = d
    for m in range(1, 1000):
        for factor in (m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m)),
                       -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1))):
            d, c = 1 + factor * d, 1 + factor / c
            d, c = 1 / (d if abs(d) > tiny else tiny), c if abs(c) > tiny else tiny
            result *= d * c
        if abs(d * c - 1) < 1e-14:
            break
    return result


def incomplete_beta(a, b, x):
    """The regularised incomplete beta function."""
    if x <= 0.0 or x >= 1.0:
        return float(x >= 1.0)
    if x > (a + 1) / (a + b + 2):
        return 1 - incomplete_beta(b, a, 1 - x)
    log = math.lgamma(a + b) - math.lgamma(a) - math.lgamma(b) + a * math.log(x) + b * math.log1p(-x)
    return math.exp(log) * beta_fraction(a, b, x) / a


def two_sided(t, degrees):
    return incomplete_beta(degrees / 2, 0.5, degrees / (degrees + t * t))


def welch(first, second, tolerance):
    """The p-value that the means differ by no more than `tolerance` of the second; a closed form is one value."""
    if not np.isfinite([*first, *second]).all():
        return 0.0
    variances = [x.var(ddof=1) / len(x) if len(x) > 1 else 0.0 for x in (first, second)]
    excess = abs(first.mean() - second.mean()) - tolerance * abs(second.mean())
    if excess <= 0.0:
        return 1.0
    error = sum(variances)
    if error <= 0.0:
        return 0.0
    degrees = error**2 / sum(v * v / (len(x) - 1) for v, x in zip(variances, (first, second)) if len(x) > 1)
    return two_sided(excess / math.sqrt(error), degrees)


def tiles(images):
    """Means of the tiles by seed, row, column and channel."""
    count, side = len(images), images.shape[1] // TILES
    return images.reshape(count, TILES, side, TILES, side, 3).mean((2, 4))


def holm(values):
    """Holm's adjusted p-values."""
    order, adjusted, largest = np.argsort(values), np.empty(len(values)), 0.0
    for rank, index in enumerate(order):
        largest = max(largest, min(1.0, (len(values) - rank) * values[index]))
        adjusted[index] = largest
    return adjusted


@dataclass
class Comparison:
    """Two sets of images of a scene, and the p-values of the mean and of the tiles by place."""
    scene: str
    what: str
    ratio: float
    noise: float
    places: list
    values: list

    def smallest(self):
        return min(range(len(self.values)), key=self.values.__getitem__)


def relative_noise(images):
    """The standard error of the image's mean over the mean; 0 for one image."""
    means = images.mean((1, 2, 3))
    return means.std(ddof=1) / math.sqrt(len(means)) / means.mean() if len(means) > 1 else 0.0


def compare(scene, what, first, second, tolerance):
    """Compares images by seed."""
    parts, places, values = [tiles(first), tiles(second)], [], []
    for channel, name in enumerate("RGB"):
        places.append(f"mean {name}")
        values.append(welch(*(x[..., channel].mean((1, 2)) for x in (first, second)), tolerance))
        for row in range(TILES):
            for column in range(TILES):
                places.append(f"tile {row},{column} {name}")
                values.append(welch(*(x[:, row, column, channel] for x in parts), tolerance))
    ratio = first.mean() / second.mean()
    return Comparison(scene, what, ratio, math.hypot(relative_noise(first), relative_noise(second)), places, values)


# --- the program -------------------------------------------------------------------------------------------------------


def examine(mi, arguments, scene):
    """Renders a scene by both programs and returns the comparisons."""
    folder = arguments.out / scene.name
    write_shared(folder, scene)
    write_gltf(folder, scene)
    start = time.time()
    peer = render_mitsuba(mi, arguments, folder, scene)
    times, found = [f"mitsuba {time.time() - start:.1f} s"], []
    exact = scene.closed_form and scene.closed_form(scene, arguments.size)[None]
    if exact is not None:
        found.append(compare(scene.name, "mitsuba/exact", peer, exact, arguments.tolerance))
    for method in arguments.methods:
        start = time.time()
        ours = render_etendue(arguments, folder, scene, method)
        times.append(f"{method} {time.time() - start:.1f} s")
        found.append(compare(scene.name, f"{method}/mitsuba", ours, peer, arguments.tolerance))
        if exact is not None:
            found.append(compare(scene.name, f"{method}/exact", ours, exact, arguments.tolerance))
        noises = f"noise {relative_noise(ours):.3%}, mitsuba's {relative_noise(peer):.3%}"
        print(f"{scene.name}: {method}: {found[-1].ratio:.5f}, {noises}", file=sys.stderr)
    print(f"{scene.name}: {', '.join(times)}", file=sys.stderr, flush=True)
    return found


def report(comparisons, arguments):
    """Prints the table and returns whether all tests passed."""
    adjusted, start, passed = holm([p for c in comparisons for p in c.values]), 0, True
    print(f"{'scene':16} {'what':18} {'ratio':>9} {'noise':>8}  {'smallest p':>10} {'by Holm':>9}  at")
    for c in comparisons:
        least, end = c.smallest(), start + len(c.values)
        by_holm = adjusted[start:end].min()
        agrees = abs(c.ratio - 1) <= arguments.mean and by_holm >= arguments.level
        print(f"{c.scene:16} {c.what:18} {c.ratio:9.5f} {c.noise:8.3%}  {c.values[least]:10.2e} {by_holm:9.2e}"
              f"  {c.places[least]}{'' if agrees else '  FAILED'}")
        start, passed = end, passed and agrees
    print(f"{len(adjusted)} tests at the level {arguments.level:g} together; means within {arguments.mean:.2%}: "
          f"{'passed' if passed else 'FAILED'}")
    return passed


def parsed():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--etendue", type=Path, default=ROOT / "target/release/etendue")
    parser.add_argument("--out", type=Path, default=ROOT / "bench/out/media", help="folder of scenes and images")
    parser.add_argument("--only", nargs="+", metavar="SCENE", help="only these scenes")
    parser.add_argument("--methods", nargs="+", default=["path"], help="methods of étendue, each compared")
    parser.add_argument("--variant", default="llvm_ad_rgb", help="variant of Mitsuba, of kind rgb")
    parser.add_argument("--integrator", default="volpathmis", help="volpath or volpathmis")
    parser.add_argument("--seeds", type=int, default=12, help="images of each program")
    parser.add_argument("--seed", type=int, default=0, help="added to all seeds")
    parser.add_argument("--spp", type=int, default=1, metavar="FACTOR", help="multiplies the samples per pixel")
    parser.add_argument("--mitsuba-factor", type=int, default=1, help="multiplies those of Mitsuba once more")
    parser.add_argument("--size", type=int, default=32, help="width and height, a multiple of 4")
    parser.add_argument("--level", type=float, default=1e-3, help="of all tests together")
    parser.add_argument("--mean", type=float, default=0.003, help="largest relative difference of image means")
    parser.add_argument("--tolerance", type=float, default=1e-4, help="relative difference that no test counts")
    return parser.parse_args()


def main():
    arguments = parsed()
    import mitsuba as mi  # after the options: it takes a while
    mi.set_variant(arguments.variant)
    arguments.out, arguments.etendue = arguments.out.resolve(), arguments.etendue.resolve()
    arguments.out.mkdir(parents=True, exist_ok=True)
    write_maps(arguments.out)
    scenes = [s for s in all_scenes() if not arguments.only or s.name in arguments.only]
    if unknown := set(arguments.only or []) - {s.name for s in scenes}:
        sys.exit(f"media_scenes.py: there is no scene {', '.join(sorted(unknown))}")
    for scene in scenes:
        scene.spp *= arguments.spp
    comparisons = [found for scene in scenes for found in examine(mi, arguments, scene)]
    sys.exit(0 if report(comparisons, arguments) else 1)


if __name__ == "__main__":
    main()
