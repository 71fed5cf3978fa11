#!/usr/bin/env python3
"""Writes the scenes that étendue is compared with its peers on, as glTF 2.0: scene.gltf and scene.bin in the folder of
each name given, all of them without a name. Needs Python 3.8 and its standard library; the output is deterministic.

    scenes/make.py                # all of them, in half a minute
    scenes/make.py cornell-box

But for the spheres, whose radiance is known in closed form, the textured box, wax, the volumetric caustic and the scenes for
Metropolis light transport (door-2cm, caustic-pool, mirror-caustic), the numbers are those of shared/peers/scenes.py, which the reference images were rendered from. Its
conventions and what becomes of them here:

- Z up, metres; glTF is Y up: (x, y, z) becomes (x, z, -y), a rotation, so windings stay.
- Emission is constant radiance, one-sided along the counter-clockwise normal, on a black absorber: black base colour,
  specularFactor 0, emissiveFactor at most 1 with KHR_materials_emissive_strength for the scale, single-sided.
- Diffuse is exactly Lambert and two-sided: metallicFactor 0, roughnessFactor 1, specularFactor 0, doubleSided.
- A mirror reflects its colour at every angle: metallicFactor 1, roughnessFactor 0, extras.etendue.fresnel "constant".
- A GGX plate does the same at roughnessFactor √α.
- Glass: KHR_materials_transmission, _ior and _volume (a thickness above 0 makes it solid).
- The horizontal field of view is the vertical one, the image being square.
- Environments are lat-long maps about the vertical, the same picture for everyone: env.exr, named in render.toml.
- Spheres are icospheres with the same vertices in the same order; meshes without normals are flat, as glTF says.
"""
import itertools
import json
import math
import random
import struct
import sys
import zlib
from pathlib import Path

HERE = Path(__file__).resolve().parent

# --- meshes: (positions, triangles, normals or None), Z up ---------------------------------------------------------


def quad(a, b, c, d):
    return [a, b, c, d], [(0, 1, 2), (0, 2, 3)], None


def box(lo, hi, angle=0.0, pivot=None):
    """A box turned about the vertical through its centre or another point."""
    corners = [(x, y, z) for z in (lo[2], hi[2]) for y in (lo[1], hi[1]) for x in (lo[0], hi[0])]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    cx, cy = pivot or ((lo[0] + hi[0]) / 2, (lo[1] + hi[1]) / 2)
    cos, sin = math.cos(angle), math.sin(angle)
    turned = [((x - cx) * cos - (y - cy) * sin + cx, (x - cx) * sin + (y - cy) * cos + cy, z) for x, y, z in corners]
    return turned, [t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))], None


def normalized(v):
    length = math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
    return (v[0] / length, v[1] / length, v[2] / length)


def icosphere(levels, centre, radius):
    """An icosahedron, each triangle split in four `levels` times, with the sphere's own normals."""
    t = (1 + 5**0.5) / 2
    points = [(-1, t, 0), (1, t, 0), (-1, -t, 0), (1, -t, 0), (0, -1, t), (0, 1, t),
              (0, -1, -t), (0, 1, -t), (t, 0, -1), (t, 0, 1), (-t, 0, -1), (-t, 0, 1)]
    triangles = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2),
                 (10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11),
                 (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    points = [normalized(p) for p in points]
    for _ in range(levels):
        points, triangles = subdivided(points, triangles)
    positions = [tuple(n * radius + c for n, c in zip(p, centre)) for p in points]
    return positions, triangles, points


def subdivided(points, triangles):
    def edge(a, b):
        return (a, b) if a < b else (b, a)

    edges = sorted({edge(*e) for a, b, c in triangles for e in ((a, b), (b, c), (c, a))})
    middle = {e: len(points) + i for i, e in enumerate(edges)}
    midpoints = [normalized(tuple(x + y for x, y in zip(points[a], points[b]))) for a, b in edges]
    cut = [(a, b, c, middle[edge(a, b)], middle[edge(b, c)], middle[edge(c, a)]) for a, b, c in triangles]
    split = [(a, ab, ca) for a, b, c, ab, bc, ca in cut]
    split += [(b, bc, ab) for a, b, c, ab, bc, ca in cut]
    split += [(c, ca, bc) for a, b, c, ab, bc, ca in cut]
    split += [(ab, bc, ca) for a, b, c, ab, bc, ca in cut]
    return points + midpoints, split


def terrain(waves, cells, half):
    """A square grid whose height is a sum of waves (amplitude, frequency, angle, phase, phase of the modulation)."""
    n = cells + 1
    axis = [i * (2 * half / cells) - half for i in range(n)]
    # sin(a + b) = sin a cos b + cos a sin b with a of x alone and b of y alone: products in place of 24 million sines.
    across = []
    for amplitude, frequency, angle, phase, modulation in waves:
        a = [frequency * 2 * math.cos(angle) * x + phase + 0.7 * math.sin(frequency * x + modulation) for x in axis]
        across.append(([amplitude * math.sin(t) for t in a], [amplitude * math.cos(t) for t in a]))
    points = []
    for y in axis:
        row = [0.0] * n
        for (_, frequency, angle, _, _), (sines, cosines) in zip(waves, across):
            b = frequency * 2 * math.sin(angle) * y
            cos, sin = math.cos(b), math.sin(b)
            row = [z + s * cos + c * sin for z, s, c in zip(row, sines, cosines)]
        points.extend((x, y, z) for x, z in zip(axis, row))
    corners = [(i, i + 1, i + n + 1, i + n) for j in range(cells) for i in range(j * n, j * n + cells)]
    return points, [(a, b, c) for a, b, c, _ in corners] + [(a, c, d) for a, _, c, d in corners], None


def ring(centre, inner, outer, height, segments):
    """A ring that stands on the plane through `centre`: inside, outside and top, each with its own normals."""
    turns = [2 * math.pi * i / segments for i in range(segments)]
    around = [(math.cos(t), math.sin(t)) for t in turns]

    def loop(radius, z):
        return [(centre[0] + radius * c, centre[1] + radius * s, centre[2] + z) for c, s in around]

    bands = [(loop(inner, height), loop(inner, 0.0), [(-c, -s, 0.0) for c, s in around]),
             (loop(outer, 0.0), loop(outer, height), [(c, s, 0.0) for c, s in around]),
             (loop(outer, height), loop(inner, height), [(0.0, 0.0, 1.0)] * segments)]
    points, triangles, normals = [], [], []
    for low, high, directions in bands:
        base = len(points)
        points, normals = points + low + high, normals + 2 * directions
        for i in range(segments):
            a, b = base + i, base + (i + 1) % segments
            triangles += [(a, b, b + segments), (a, b + segments, a + segments)]
    return points, triangles, normals


def ripples(waves, cells, lo, hi, level):
    """A grid over a rectangle whose height is a sum of sines (length, angle, phase, amplitude), with the normals of that sum."""
    waves = [(2 * math.pi / length * math.cos(a), 2 * math.pi / length * math.sin(a), phase, height) for length, a, phase, height in waves]
    axes = [[l + (h - l) * i / cells for i in range(cells + 1)] for l, h in zip(lo, hi)]
    points, normals = [], []
    for y in axes[1]:
        for x in axes[0]:
            angles = [(kx, ky, height, kx * x + ky * y + phase) for kx, ky, phase, height in waves]
            points.append((x, y, level + sum(height * math.sin(t) for _, _, height, t in angles)))
            slopes = [(height * kx * math.cos(t), height * ky * math.cos(t)) for kx, ky, height, t in angles]
            normals.append(normalized((-sum(s for s, _ in slopes), -sum(s for _, s in slopes), 1.0)))
    n = cells + 1
    corners = [(j * n + i, j * n + i + 1, j * n + i + n + 1, j * n + i + n) for j in range(cells) for i in range(cells)]
    return points, [t for a, b, c, d in corners for t in ((a, b, c), (a, c, d))], normals


def checkered(origin, u, v, columns, rows, colors):
    """Square tiles, a mesh for each of two colours: (mesh, colour) of both."""
    def at(i, j):
        return tuple(o + i * a + j * b for o, a, b in zip(origin, u, v))

    def mesh(odd):
        cells = [(i, j) for j in range(rows) for i in range(columns) if (i + j) % 2 == odd]
        points = [at(*p) for i, j in cells for p in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))]
        return points, [(4 * k + a, 4 * k + b, 4 * k + c) for k in range(len(cells)) for a, b, c in ((0, 1, 2), (0, 2, 3))], None

    return [(mesh(odd), color) for odd, color in enumerate(colors)]


# --- materials -----------------------------------------------------------------------------------------------------


def surface(color, metallic, roughness):
    return {"baseColorFactor": [*color, 1.0], "metallicFactor": metallic, "roughnessFactor": roughness}


def diffuse(*color):
    return {"pbrMetallicRoughness": surface(color, 0.0, 1.0), "doubleSided": True,
            "extensions": {"KHR_materials_specular": {"specularFactor": 0.0}}}


def emitter(*radiance):
    strength = float(max(radiance))
    return {"pbrMetallicRoughness": surface((0.0, 0.0, 0.0), 0.0, 1.0),
            "emissiveFactor": [x / strength for x in radiance],
            "extensions": {"KHR_materials_specular": {"specularFactor": 0.0},
                           "KHR_materials_emissive_strength": {"emissiveStrength": strength}}}


def mirror(*color):
    return {"pbrMetallicRoughness": surface(color, 1.0, 0.0), "doubleSided": True,
            "extras": {"etendue": {"fresnel": "constant"}}}


def plate(alpha, *color):
    return {**mirror(*color), "pbrMetallicRoughness": surface(color, 1.0, math.sqrt(alpha))}


def glass(ior, thickness):
    return {"pbrMetallicRoughness": surface((1.0, 1.0, 1.0), 0.0, 0.0),
            "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1.0},
                           "KHR_materials_ior": {"ior": ior},
                           "KHR_materials_volume": {"thicknessFactor": thickness}}}


def medium(ior, absorption, scattering, phase="isotropic"):
    """What fills a body, with coefficients per metre of red, green and blue; an index of 1 is a boundary that nothing sees."""
    shortest = max(absorption)
    volume = {"thicknessFactor": 1.0}
    if shortest > 0.0:
        volume |= {"attenuationDistance": 1.0 / shortest, "attenuationColor": [math.exp(-x / shortest) for x in absorption]}
    clear = glass(ior, 1.0)
    return {**clear, "extensions": {**clear["extensions"], "KHR_materials_volume": volume},
            "extras": {"etendue": {"scattering": list(scattering), "phase": phase}}}


def textured():
    """Half plastic, half metal: colour, roughness and metalness by texture."""
    texture = {"baseColorTexture": {"index": 0}, "metallicRoughnessTexture": {"index": 1}}
    return {"pbrMetallicRoughness": {**surface((1.0, 1.0, 1.0), 1.0, 1.0), **texture}, "doubleSided": True}


# --- scenes: (name, mesh, material) of each object, and the materials --------------------------------------------------

COLOURS = {"white": diffuse(0.725, 0.71, 0.68), "red": diffuse(0.63, 0.065, 0.05), "green": diffuse(0.14, 0.45, 0.091)}
# Origin, angle above the horizon, field of view, and angle to the right of the peers' +Y, which is glTF's -Z, the direction of an
# unrotated camera.
CAMERA = ((0.0, -3.9, 1.0), 0.0, 39.3)
CAMERAS = {"landscape": ((0.0, -2.3, 1.1), math.atan2(-1.1, 2.3), 45.0),
           "veach-mis": ((0.0, -11.0, 4.0), math.atan2(-2.3, 11.0), 42.0),
           "ajar-door": ((-1.3, -1.8, 1.35), math.atan2(-0.4, math.hypot(1.65, 3.8)), 60.0, math.atan2(1.65, 3.8)),
           "caustic-pool": ((0.0, -2.5, 1.9), math.radians(-46.0), 48.0),
           "mirror-caustic": ((0.0, -2.8, 1.15), math.radians(11.0), 32.0),
           "many-lights": ((0.0, -11.0, 6.0), math.atan2(-6.0, 10.0), 50.0),
           "street": ((0.6, -6.0, 1.7), math.radians(4.0), 62.0), "hall": ((0.8, 0.6, 1.7), math.radians(-6.0), 62.0),
           "cloud": ((0.0, -3.2, 0.9), math.radians(14.0), 50.0), "wax": ((0.0, -1.1, 0.4), math.radians(-15.0), 40.0),
           "sphere-lamp": ((0.0, -0.8, 0.0), 0.0, 60.0), "sphere-cap": ((0.0, -0.8, 0.0), math.radians(25.0), 60.0)}
CAMERAS["door-2cm"] = CAMERAS["ajar-door"]
# Point lights: position and radiant intensity.
LAMPS = {"sphere-lamp": ((0.0, 0.0, 0.0), math.pi)}

ROOM = [
    ("floor", quad((-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)), "white"),
    ("ceiling", quad((-1, -1, 2), (-1, 1, 2), (1, 1, 2), (1, -1, 2)), "white"),
    ("back", quad((-1, 1, 0), (1, 1, 0), (1, 1, 2), (-1, 1, 2)), "white"),
    ("left", quad((-1, -1, 0), (-1, 1, 0), (-1, 1, 2), (-1, -1, 2)), "red"),
    ("right", quad((1, -1, 0), (1, -1, 2), (1, 1, 2), (1, 1, 0)), "green"),
]
TALL = ("tall", box((-0.63, 0.0, 0), (-0.05, 0.58, 1.2), 0.29), "white")
SHORT = ("short", box((0.05, -0.65, 0), (0.63, -0.07, 0.6), -0.29), "white")


def cornell_box():
    light = quad((-0.25, -0.2, 1.98), (-0.25, 0.2, 1.98), (0.25, 0.2, 1.98), (0.25, -0.2, 1.98))
    return ROOM + [TALL, SHORT, ("light", light, "light")], {**COLOURS, "light": emitter(17, 12, 4)}


def textured_box():
    objects, materials = cornell_box()
    return [(n, m, material if material == "light" else "textured") for n, m, material in objects], \
        {"textured": textured(), "light": materials["light"]}


def modified_cornell():
    light = quad((-0.25, -0.25, 1.8), (0.25, -0.25, 1.8), (0.25, 0.25, 1.8), (-0.25, 0.25, 1.8))
    ball = icosphere(6, (0.4, -0.4, 0.37), 0.36)
    materials = {**COLOURS, "light": emitter(30, 25, 18), "mirror": mirror(0.95, 0.95, 0.95)}
    return ROOM + [TALL, ("light", light, "light"), ("ball", ball, "mirror")], materials


def foggy_box():
    """The Cornell box in fog, as the comparison's S8."""
    objects, materials = cornell_box()
    light = quad((-0.25, -0.25, 1.98), (-0.25, 0.25, 1.98), (0.25, 0.25, 1.98), (0.25, -0.25, 1.98))
    fog = ("fog", box((-1.05, -1.05, -0.05), (1.05, 1.05, 2.05)), "fog")
    materials = {**materials, "light": emitter(34, 24, 8), "fog": medium(1.0, (0.05,) * 3, (0.45,) * 3)}
    return [o for o in objects if o[0] != "light"] + [("light", light, "light"), fog], materials


def wax():
    """A ball, a block and a leaf of wax, lit from behind."""
    # Reduced scattering and absorption per metre of a paraffin of whiter red than blue; the mean free path is a millimetre.
    body = medium(1.44, (2.0, 8.0, 40.0), (900.0, 1000.0, 1100.0), 0.0)
    light = quad((-0.5, 0.6, 1.3), (-0.5, 1.0, 0.9), (0.5, 1.0, 0.9), (0.5, 0.6, 1.3))
    floor = quad((-3, -3, 0), (3, -3, 0), (3, 3, 0), (-3, 3, 0))
    things = [("ball", icosphere(5, (-0.3, 0.0, 0.151), 0.15)), ("block", box((0.1, -0.1, 0.001), (0.3, 0.1, 0.25), 0.5)),
              ("leaf", box((-0.05, -0.2, 0.001), (0.1, -0.19, 0.18), -0.3))]
    objects = [("floor", floor, "floor"), ("light", light, "light")] + [(name, mesh, "wax") for name, mesh in things]
    return objects, {"floor": diffuse(0.4, 0.4, 0.42), "light": emitter(40, 40, 40), "wax": body}


def volumetric_caustic():
    """A glass ball in thin fog under a small lamp: the cone of light that it gathers is seen in the air."""
    light = quad((-0.05, -0.05, 1.95), (-0.05, 0.05, 1.95), (0.05, 0.05, 1.95), (0.05, -0.05, 1.95))
    fog = ("fog", box((-0.99, -0.99, 0.01), (0.99, 0.99, 1.99)), "fog")
    ball = ("ball", icosphere(6, (0.0, 0.0, 1.2), 0.3), "glass")
    inner = glass(1.5, 0.6)
    inner["extras"] = {"etendue": {"priority": 1}}
    dark = {name: diffuse(*(0.2 * x for x in COLOURS[name]["pbrMetallicRoughness"]["baseColorFactor"][:3])) for name in COLOURS}
    materials = {**dark, "light": emitter(900, 850, 700), "glass": inner, "fog": medium(1.0, (0.0,) * 3, (0.15,) * 3, 0.5)}
    return ROOM + [ball, ("light", light, "light"), fog], materials


def cloud():
    """A small cloud over a meadow. The cloud itself is a medium of render.toml in the box of its density."""
    meadow = quad((-40, -40, 0), (40, -40, 0), (40, 40, 0), (-40, 40, 0))
    return [("meadow", meadow, "meadow")], {"meadow": diffuse(0.12, 0.16, 0.07)}


def glass_caustic():
    light = quad((0.32, 0.12, 1.9), (0.32, 0.28, 1.9), (0.48, 0.28, 1.9), (0.48, 0.12, 1.9))
    ball = icosphere(6, (0, 0, 0.47), 0.45)
    materials = {**COLOURS, "light": emitter(120, 110, 90), "glass": glass(1.5, 0.9)}
    return ROOM + [("ball", ball, "glass"), ("light", light, "light")], materials


def ajar_door(angle=0.28, radiance=(60, 55, 45)):
    """A room lit by a lamp in the next one through the gap of a door turned by `angle`, after the scene of [Veach97 §11.5]."""
    x0, x1, top = 0.2, 1.1, 2.0
    shell = [quad((-2, -2, 0), (2, -2, 0), (2, 6, 0), (-2, 6, 0)), quad((-2, -2, 2.5), (-2, 6, 2.5), (2, 6, 2.5), (2, -2, 2.5)),
             quad((-2, -2, 0), (-2, -2, 2.5), (2, -2, 2.5), (2, -2, 0)), quad((-2, 6, 0), (2, 6, 0), (2, 6, 2.5), (-2, 6, 2.5)),
             quad((2, -2, 0), (2, -2, 2.5), (2, 6, 2.5), (2, 6, 0))]
    wall = [box((-2, 2, 0), (x0, 2.1, 2.5)), box((x1, 2, 0), (2, 2.1, 2.5)), box((x0, 2, top), (x1, 2.1, 2.5))]
    legs = [((-0.85, -0.05), (-0.75, 0.05)), ((0.55, 0.65), (0.65, 0.75)), ((0.55, -0.05), (0.65, 0.05)), ((-0.85, 0.65), (-0.75, 0.75))]
    table = [box((-0.9, -0.1, 0.6), (0.7, 0.8, 0.66))] + [box((*a, 0), (*b, 0.6)) for a, b in legs]
    door = box((x0 + 0.005, 2.0, 0.005), (x1 - 0.01, 2.04, top - 0.01), -angle, (x0, 2.0))
    light = quad((1.99, 2.8, 0.6), (1.99, 2.8, 2.2), (1.99, 5.2, 2.2), (1.99, 5.2, 0.6))
    objects = [(f"shell{i}", mesh, "white") for i, mesh in enumerate(shell)]
    objects += [("left", quad((-2, -2, 0), (-2, 6, 0), (-2, 6, 2.5), (-2, -2, 2.5)), "red")]
    objects += [(f"wall{i}", mesh, "white") for i, mesh in enumerate(wall)] + [("door", door, "door")]
    objects += [(f"table{i}", mesh, "door") for i, mesh in enumerate(table)]
    objects += [("cube", box((-0.6, 0.2, 0.661), (-0.25, 0.55, 1.0), 0.4), "white")]
    objects += [("ball", icosphere(6, (0.3, 0.35, 0.882), 0.22), "mirror"), ("light", light, "light")]
    materials = {"white": COLOURS["white"], "red": COLOURS["red"], "door": diffuse(0.45, 0.3, 0.18),
                 "mirror": mirror(0.95, 0.95, 0.95), "light": emitter(*radiance)}
    return objects, materials


def door_2cm():
    """The same door turned until its back edge is 2 cm from the corner of the wall."""
    return ajar_door(0.0648, (3600, 3300, 2700))


# Length, angle and phase of each wave of the pool.
RIPPLES = [(0.8, 0.35, 0.4), (0.63, 1.9, 2.1), (0.5, 2.75, 5.0), (0.4, 1.1, 1.3), (0.34, 0.1, 3.7), (0.28, 2.2, 0.9)]


def caustic_pool():
    """A tiled basin under moving water and a small lamp: caustics on the floor, seen through the water that casts them."""
    half, depth, tile, level = 1.5, 1.0, 0.25, -0.12
    n, high = round(2 * half / tile), round(depth / tile)
    low = -depth
    x, y, z = (tile, 0, 0), (0, tile, 0), (0, 0, tile)
    tiles = checkered((-half, -half, low), x, y, n, n, ("pale", "blue"))
    for origin, along in (((-half, -half, low), y), ((half, -half, low), y), ((-half, -half, low), x), ((-half, half, low), x)):
        tiles += checkered(origin, along, z, n, high, ("pale", "blue"))
    # Deck around the basin, and two walls behind it.
    deck = [quad((-3, half, 0), (3, half, 0), (3, 3, 0), (-3, 3, 0)), quad((-3, -3, 0), (3, -3, 0), (3, -half, 0), (-3, -half, 0)),
            quad((-3, -half, 0), (-half, -half, 0), (-half, half, 0), (-3, half, 0)),
            quad((half, -half, 0), (3, -half, 0), (3, half, 0), (half, half, 0))]
    walls = [quad((-3, 3, 0), (3, 3, 0), (3, 3, 3), (-3, 3, 3)), quad((-3, -3, 0), (-3, 3, 0), (-3, 3, 3), (-3, -3, 3))]
    # The curvature of a wave decides where it focuses: they share one.
    waves = [(length, angle, phase, 1.5 * (length / (2 * math.pi))**2) for length, angle, phase in RIPPLES]
    reach = half + 0.05  # through the walls of the basin, so that nothing passes between wall and water
    water = ripples(waves, 128, (-reach, -reach), (reach, reach), level)
    light = quad((-0.66, 0.34, 2.3), (-0.66, 0.46, 2.3), (-0.54, 0.46, 2.3), (-0.54, 0.34, 2.3))
    objects = [(f"tiles{i}", mesh, color) for i, (mesh, color) in enumerate(tiles)]
    objects += [(f"deck{i}", mesh, "deck") for i, mesh in enumerate(deck)] + [(f"wall{i}", mesh, "white") for i, mesh in enumerate(walls)]
    materials = {"pale": diffuse(0.7, 0.72, 0.7), "blue": diffuse(0.2, 0.42, 0.55), "deck": diffuse(0.55, 0.45, 0.36),
                 "white": COLOURS["white"], "water": glass(1.33, 1.0), "light": emitter(1500, 1400, 1200)}
    return objects + [("water", water, "water"), ("light", light, "light")], materials


def mirror_caustic():
    """A golden ring and a glass ball under a small lamp on a table above the eye: a mirror alone shows the top and its caustics."""
    top = 1.25
    room = [("floor", quad((-2, -3, 0), (2, -3, 0), (2, 2, 0), (-2, 2, 0)), "white"),
            ("ceiling", quad((-2, -3, 3), (-2, 2, 3), (2, 2, 3), (2, -3, 3)), "white"),
            ("back", quad((-2, 2, 0), (2, 2, 0), (2, 2, 3), (-2, 2, 3)), "white"),
            ("front", quad((-2, -3, 0), (-2, -3, 3), (2, -3, 3), (2, -3, 0)), "white"),
            ("left", quad((-2, -3, 0), (-2, 2, 0), (-2, 2, 3), (-2, -3, 3)), "red"),
            ("right", quad((2, -3, 0), (2, -3, 3), (2, 2, 3), (2, 2, 0)), "green")]
    # The lower edge of the mirror is at the back wall, its upper edge leans into the room.
    lean, low, tall, wide = math.radians(30), 1.3, 1.6, 1.0
    y, z = 1.9 - tall * math.sin(lean), low + tall * math.cos(lean)
    glass_plate = quad((-wide, 1.9, low), (wide, 1.9, low), (wide, y, z), (-wide, y, z))
    legs = [((x - 0.04, y - 0.04, 0), (x + 0.04, y + 0.04, top - 0.05)) for x in (-0.9, 0.9) for y in (0.1, 1.4)]
    table = [box((-1.0, 0.0, top - 0.05), (1.0, 1.5, top))] + [box(*leg) for leg in legs]
    light = icosphere(2, (-1.3, 0.15, 2.3), 0.05)
    objects = room + [(f"table{i}", mesh, "table") for i, mesh in enumerate(table)]
    objects += [("mirror", glass_plate, "mirror"), ("ring", ring((-0.35, 0.7, top), 0.32, 0.34, 0.17, 128), "gold"),
                ("ball", icosphere(5, (0.42, 0.75, top + 0.221), 0.22), "glass"), ("light", (*light[:2], None), "light")]
    materials = {**COLOURS, "table": diffuse(0.6, 0.58, 0.55), "mirror": mirror(0.95, 0.95, 0.95), "gold": mirror(0.95, 0.75, 0.4),
                 "glass": glass(1.5, 0.44), "light": emitter(800, 740, 640)}
    return objects, materials


# Angle and phase of each wave of the landscape, three an octave: numpy's default_rng(7), uniform(0, 6.28).
WAVES = [
    (3.925599530277309, 5.634502670088934), (4.871306134739815, 1.4143011531409169), (1.8850442692424958, 5.485915637088525),
    (0.03306611267180927, 5.157314467443772), (5.005596012562851, 2.9386315038585664), (1.903043640425289, 1.7485128439928566),
    (1.6005810104679026, 2.7950792009430208), (3.1685630662559467, 3.4759633710278126), (6.251741779967986, 4.97791685266237),
    (3.9072855608905015, 6.210669727442237), (1.3521386249195615, 1.0061315726272637), (3.8467487148346335, 0.27595580999748753),
    (0.2240721506981838, 3.2335017913042057), (2.927773839042816, 5.759813615651113), (3.951540878203546, 3.2286588206449474),
    (3.120365174271207, 1.5543937103316376), (0.0740664804069368, 1.2082854642277507), (4.34596171913795, 1.25981022663833),
    (2.320688030581858, 0.023451040087036988), (5.212699743154962, 0.9700155890658423), (1.6805236326605726, 5.528485926999604),
    (3.2014862859736977, 5.320103547177659), (4.017423808399065, 4.658321549432463), (0.5745923997959268, 3.3983831982443493),
]


def landscape():
    waves = [(0.13 / 2 ** (i // 3), 1.3 * 2 ** (i // 3), angle, phase, i % 3) for i, (angle, phase) in enumerate(WAVES)]
    return [("ground", terrain(waves, 1000, 2.0), "ground")], {"ground": diffuse(0.5, 0.45, 0.4)}


def lit_plates():
    """Veach's plates [Veach97 §9.2]: each is turned so that the middle light is mirrored to the camera."""
    eye, lights = CAMERAS["veach-mis"][0], (0.0, 3.0, 4.6)

    def minus(a, b):
        return tuple(x - y for x, y in zip(a, b))

    floor = quad((-20, -20, -1.2), (20, -20, -1.2), (20, 6, -1.2), (-20, 6, -1.2))
    back = quad((-20, 6, -1.2), (20, 6, -1.2), (20, 6, 20), (-20, 6, 20))
    objects, materials = [("floor", floor, "white"), ("back", back, "white")], {"white": diffuse(0.4, 0.4, 0.4)}
    for i, (alpha, y, z) in enumerate(zip((0.01, 0.035, 0.1, 0.25), (1.2, -0.6, -2.4, -4.2), (2.0, 1.1, 0.35, -0.25))):
        centre = (0.0, y, z)
        to_eye, to_light = normalized(minus(eye, centre)), normalized(minus(lights, centre))
        n = normalized(tuple(a + b for a, b in zip(to_eye, to_light)))
        width, up = 3.6, (0.0, 0.62 * n[2], -0.62 * n[1])  # n × x, half as deep as the plate
        corners = [(sx * width, y + sy * up[1], z + sy * up[2]) for sx, sy in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
        materials[f"plate{i}"] = plate(alpha, 0.99, 0.99, 0.99)
        objects.append((f"plate{i}", quad(*corners), f"plate{i}"))
    colors = ((1, 0.6, 0.5), (0.6, 1, 0.6), (0.5, 0.7, 1), (1, 1, 0.7))
    for i, (x, radius, color) in enumerate(zip((-3.1, -1.2, 0.8, 3.1), (0.04, 0.12, 0.36, 0.9), colors)):
        ball = icosphere(3, (x, lights[1], lights[2]), radius)
        materials[f"light{i}"] = emitter(*(c * 1.6 / radius**2 for c in color))
        objects.append((f"light{i}", (*ball[:2], None), f"light{i}"))
    materials["fill"] = emitter(2.0, 2.0, 2.0)
    return objects + [("fill", quad((-2, -9, 10), (-2, -5, 10), (2, -5, 10), (2, -9, 10)), "fill")], materials


def inside_of_sphere():
    """A unit sphere of flat triangles that face inwards."""
    positions, triangles, _ = icosphere(4, (0.0, 0.0, 0.0), 1.0)
    return positions, [(a, c, b) for a, b, c in triangles]


def sphere_lamp():
    return [("sphere", (*inside_of_sphere(), None), "gray")], {"gray": diffuse(0.5, 0.5, 0.5)}


def sphere_cap():
    positions, triangles = inside_of_sphere()
    in_cap = [sum(positions[i][2] for i in t) / 3 > 0.8 for t in triangles]
    cap, rest = ([t for t, inside in zip(triangles, in_cap) if inside == side] for side in (True, False))
    gray = diffuse(0.5, 0.5, 0.5)
    lamp = {**emitter(10.0, 10.0, 10.0), "pbrMetallicRoughness": surface((0.5, 0.5, 0.5), 0.0, 1.0)}
    return [("sphere", (positions, rest, None), "gray"), ("cap", (positions, cap, None), "lamp")], {"gray": gray, "lamp": lamp}


def merged(meshes):
    """One mesh of several without normals."""
    points, triangles = [], []
    for positions, faces, _ in meshes:
        triangles += [tuple(len(points) + i for i in face) for face in faces]
        points += positions
    return points, triangles, None


def on_sphere(numbers):
    z, turn = numbers.uniform(-1, 1), numbers.uniform(0, 2 * math.pi)
    r = math.sqrt(1 - z * z)
    return (r * math.cos(turn), r * math.sin(turn), z)


def many_lights():
    """Ten thousand triangles of 4 cm that float over hills, in eight colours, each in a direction of its own."""
    numbers = random.Random(5)

    def height(x, y):
        return 0.5 * math.sin(0.7 * x) * math.cos(0.6 * y) + 0.2 * math.sin(1.9 * x + 1) * math.sin(2.3 * y)

    n = 120
    axis = [24 * i / (n - 1) - 12 for i in range(n)]
    corners = [(j * n + i, j * n + i + 1, j * n + i + n + 1, j * n + i + n) for j in range(n - 1) for i in range(n - 1)]
    ground = [(x, y, height(x, y)) for y in axis for x in axis], [t for a, b, c, d in corners for t in ((a, b, c), (a, c, d))], None
    boxes = []
    for _ in range(120):
        x, y, w, h = (numbers.uniform(*span) for span in ((-9, 9), (-9, 9), (0.15, 0.5), (0.4, 1.8)))
        z = height(x, y)
        boxes.append(box((x - w, y - w, z - 0.4), (x + w, y + w, z + h), numbers.uniform(0.1, 1.5)))

    def lamp():
        x, y = numbers.uniform(-9.5, 9.5), numbers.uniform(-9.5, 9.5)
        centre, a, b = (x, y, height(x, y) + numbers.uniform(0.15, 2.2)), on_sphere(numbers), on_sphere(numbers)
        b = normalized(cross(a, b))
        corners = ((1.0, 0.0), (-0.5, 0.866), (-0.5, -0.866))
        return [tuple(c + 0.02 * (s * p + t * q) for c, p, q in zip(centre, a, b)) for s, t in corners], [(0, 1, 2)], None

    colors = ((1, 0.5, 0.2, 60), (0.2, 0.6, 1, 30), (1, 1, 1, 100), (0.3, 1, 0.4, 15),
              (1, 0.2, 0.3, 200), (1, 0.9, 0.5, 40), (0.6, 0.3, 1, 80), (0.5, 1, 1, 400))
    lamps = [(f"lights{k}", merged([lamp() for _ in range(1250)]), f"lights{k}") for k in range(8)]
    materials = {f"lights{k}": emitter(*(c * strength for c in rgb)) for k, (*rgb, strength) in enumerate(colors)}
    return [("ground", ground, "ground"), ("boxes", merged(boxes), "box")] + lamps, \
        {"ground": diffuse(0.5, 0.5, 0.5), "box": diffuse(0.6, 0.55, 0.5), **materials}


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def street():
    """A wet street at night: lamps of 6 m on both sides, houses with lit windows, signs in colours."""
    numbers = random.Random(11)
    houses, windows, signs, posts, lamps = [], [[], [], []], [[], [], []], [], []
    for side in (-1, 1):
        y = -4.0
        while y < 60:
            width, depth, height = numbers.uniform(5, 9), numbers.uniform(4, 7), 3.2 * numbers.randint(2, 6)
            x = side * numbers.uniform(5.2, 5.6)
            front, back = sorted((x, x + side * depth))
            houses.append(box((front, y, 0), (back, y + width, height)))
            columns = int((width - 0.8) / 1.5)
            for floor in range(1, int(height / 3.2)):
                for column in range(columns):
                    if numbers.random() < 0.45:
                        left, low = y + 0.8 + 1.5 * column, 3.2 * floor + 0.9
                        numbers.choice(windows).append(facing(side, x - side * 0.02, (left, low), (left + 0.9, low + 1.5)))
            for _ in range(numbers.randint(0, 2)):
                left, low = y + numbers.uniform(0.5, width - 2.5), numbers.uniform(2.6, 3.1)
                numbers.choice(signs).append(facing(side, x - side * 0.06, (left, low), (left + numbers.uniform(0.6, 2.0), low + 0.35)))
            y += width + numbers.choice((0.0, 0.0, 1.2))
        for y in range(0, 60, 8):
            x = side * 3.8
            posts.append(box((x - 0.05, y - 0.05, 0), (x + 0.05, y + 0.05, 6.0)))
            arm = x - side * 0.9
            low, high = sorted((x, arm - side * 0.25))
            posts.append(box((low, y - 0.06, 6.0), (high, y + 0.06, 6.08)))
            lamps.append(quad((arm - 0.2, y - 0.1, 5.99), (arm - 0.2, y + 0.1, 5.99), (arm + 0.2, y + 0.1, 5.99), (arm + 0.2, y - 0.1, 5.99)))
    ground = [("road", quad((-3.4, -12, 0), (3.4, -12, 0), (3.4, 70, 0), (-3.4, 70, 0)), "wet"),
              ("pavement", merged([box((s * 4.5 - 1.1, -12, -0.1), (s * 4.5 + 1.1, 70, 0.12)) for s in (-1, 1)]), "stone")]
    glows = {"warm": (9, 6, 3), "white": (7, 7, 6.5), "cold": (3, 4.5, 6), "red": (30, 3, 2), "green": (2, 24, 9), "blue": (3, 8, 36)}
    lit = [(name, merged(quads), name) for name, quads in zip(glows, windows + signs)]
    wet = {"pbrMetallicRoughness": surface((0.04, 0.04, 0.045), 0.0, 0.22)}
    return ground + [("houses", merged(houses), "plaster"), ("posts", merged(posts), "iron"), ("lamps", merged(lamps), "lamp")] + lit, {
        "wet": wet, "stone": {"pbrMetallicRoughness": surface((0.25, 0.25, 0.25), 0.0, 0.5)}, "plaster": diffuse(0.45, 0.4, 0.36),
        "iron": {"pbrMetallicRoughness": surface((0.5, 0.5, 0.5), 1.0, 0.4)}, "lamp": emitter(420, 330, 190),
        **{name: emitter(*color) for name, color in glows.items()}}


def hall():
    """A hall with a polished floor under a thousand lamps of 8 cm in three colours, with shelves in between."""
    numbers = random.Random(3)
    lamps, shelves = [[], [], []], []
    for row in range(20):
        for column in range(50):
            x, y = -9.5 + row + numbers.uniform(-0.2, 0.2), 1.0 + column + numbers.uniform(-0.2, 0.2)
            lamps[numbers.choice((0, 0, 0, 1, 2))].append(quad((x, y, 4.9), (x, y + 0.08, 4.9), (x + 0.08, y + 0.08, 4.9), (x + 0.08, y, 4.9)))
    for k in range(8):
        x = (-7.5, 4.5)[k % 2]
        shelves.append(box((x, 6.0 + 11.0 * (k // 2), 0), (x + 3.0, 6.5 + 11.0 * (k // 2), 3.6)))
    room = [("floor", quad((-10, 0, 0), (10, 0, 0), (10, 52, 0), (-10, 52, 0)), "floor"),
            ("ceiling", quad((-10, 0, 5), (-10, 52, 5), (10, 52, 5), (10, 0, 5)), "plaster"),
            ("walls", merged([quad((-10, 0, 0), (-10, 52, 0), (-10, 52, 5), (-10, 0, 5)), quad((10, 0, 0), (10, 0, 5), (10, 52, 5), (10, 52, 0)),
                              quad((-10, 52, 0), (10, 52, 0), (10, 52, 5), (-10, 52, 5)), quad((10, 0, 0), (-10, 0, 0), (-10, 0, 5), (10, 0, 5))]), "plaster"),
            ("shelves", merged(shelves), "wood")]
    glows = {"warm": (60, 48, 30), "cold": (30, 42, 60), "red": (160, 20, 12)}
    return room + [(name, merged(quads), name) for name, quads in zip(glows, lamps)], {
        "floor": {"pbrMetallicRoughness": surface((0.12, 0.1, 0.09), 0.0, 0.15)}, "plaster": diffuse(0.6, 0.58, 0.55), "wood": diffuse(0.35, 0.24, 0.15),
        **{name: emitter(*color) for name, color in glows.items()}}


def facing(side, x, low, high):
    """A rectangle in the plane of `x` that faces the middle of the street."""
    (a, b), (c, d) = low, high
    corners = ((x, a, b), (x, c, b), (x, c, d), (x, a, d))
    return quad(*(corners if side < 0 else corners[::-1]))


SCENES = {"cornell-box": cornell_box, "modified-cornell": modified_cornell, "glass-caustic": glass_caustic, "ajar-door": ajar_door,
          "door-2cm": door_2cm, "caustic-pool": caustic_pool, "mirror-caustic": mirror_caustic,
          "landscape": landscape, "textured-box": textured_box, "veach-mis": lit_plates, "many-lights": many_lights, "street": street,
          "hall": hall, "foggy-box": foggy_box, "wax": wax, "volumetric-caustic": volumetric_caustic, "cloud": cloud,
          "sphere-lamp": sphere_lamp, "sphere-cap": sphere_cap}

# --- environments: rows of colours from the zenith down ----------------------------------------------------------------

SUN, SUN_RADIUS, SUN_IRRADIANCE = normalized((-0.55, 0.45, 0.62)), math.radians(1.2), 3.0


def sky(width, height):
    """A blue sky over brown ground, brighter toward +X, with a sun whose edge is hard."""
    edge = math.cos(SUN_RADIUS)
    sun = [c * SUN_IRRADIANCE / (2 * math.pi * (1 - edge)) for c in (1.0, 0.9, 0.75)]
    azimuths = [(0.5 - (i + 0.5) / width) * 2 * math.pi for i in range(width)]
    around = [(math.cos(phi), math.sin(phi)) for phi in azimuths]
    for j in range(height):
        theta = (j + 0.5) / height * math.pi
        sine, z = math.sin(theta), math.cos(theta)
        low, high = (0.25, 0.45, 0.9), (0.1, 0.25, 0.8)
        base = [a * (1 - z) + b * z for a, b in zip(low, high)] if z > 0 else [0.12, 0.1, 0.08]
        row = []
        for x, y in around:
            glow = 1 + 0.5 * x * max(0.0, 1 - abs(z))
            in_sun = sine * x * SUN[0] + sine * y * SUN[1] + z * SUN[2] > edge
            row.append(sun if in_sun else [c * glow for c in base])
        yield row


def exr(width, height, rows):
    """An OpenEXR file of R, G and B in 32-bit floats, not compressed."""
    def attribute(name, kind, value):
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value

    float32, window = 2, struct.pack("<4i", 0, 0, width - 1, height - 1)
    channels = b"".join(c + b"\0" + struct.pack("<iB3xii", float32, 0, 1, 1) for c in (b"B", b"G", b"R")) + b"\0"
    header = struct.pack("<2i", 20000630, 2) + b"".join([
        attribute("channels", "chlist", channels), attribute("compression", "compression", b"\0"),
        attribute("dataWindow", "box2i", window), attribute("displayWindow", "box2i", window),
        attribute("lineOrder", "lineOrder", b"\0"), attribute("pixelAspectRatio", "float", struct.pack("<f", 1.0)),
        attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0.0, 0.0)),
        attribute("screenWindowWidth", "float", struct.pack("<f", 1.0))]) + b"\0"
    size = 12 * width
    first = len(header) + 8 * height
    out = [header, struct.pack(f"<{height}Q", *(first + y * (8 + size) for y in range(height)))]
    for y, row in enumerate(rows):
        lanes = (color[lane] for lane in (2, 1, 0) for color in row)
        out.append(struct.pack(f"<2i{3 * width}f", y, size, *lanes))
    return b"".join(out)


ENVIRONMENTS = {"landscape": (1024, 512, sky), "cloud": (1024, 512, sky)}

# --- volumes: densities in cells, x first, then up, then toward the camera -------------------------------------------------

LATTICE = 32
CLOUD_LOW, CLOUD_HIGH = (-1.5, 1.0, -2.4), (1.5, 2.6, 0.2)
PUFFS = [((0.5, 0.42, 0.5), 0.3), ((0.28, 0.36, 0.55), 0.22), ((0.74, 0.35, 0.48), 0.24), ((0.58, 0.6, 0.46), 0.17),
         ((0.17, 0.3, 0.42), 0.14), ((0.86, 0.28, 0.58), 0.13), ((0.42, 0.38, 0.72), 0.17)]


def value_noise(table, x, y, z):
    """Smooth noise from 0 to 1 with one random value for each point of a periodic lattice."""
    i, j, k = int(x), int(y), int(z)
    u, v, w = (t * t * (3.0 - 2.0 * t) for t in (x - i, y - j, z - k))
    i0, j0, k0, i1, j1, k1 = (n % LATTICE for n in (i, j, k, i + 1, j + 1, k + 1))

    def row(j, k):
        start = (k * LATTICE + j) * LATTICE
        return table[start + i0] * (1.0 - u) + table[start + i1] * u

    near, far = row(j0, k0) * (1.0 - v) + row(j1, k0) * v, row(j0, k1) * (1.0 - v) + row(j1, k1) * v
    return near * (1.0 - w) + far * w


def puffs(width, height, depth):
    """Densities from 0 to 1: puffs whose surface is eaten away by noise of four octaves."""
    numbers = random.Random(12)
    table = [numbers.random() for _ in range(LATTICE ** 3)]
    for k, j, i in itertools.product(range(depth), range(height), range(width)):
        p = ((i + 0.5) / width, (j + 0.5) / height, (k + 0.5) / depth)
        inside = max(1.0 - math.dist((q[0], 0.55 * q[1], q[2]), (p[0], 0.55 * p[1], p[2])) / radius for q, radius in PUFFS)
        if inside < -0.3:
            yield 0.0
            continue
        noise = sum(0.5 ** (o + 1) * value_noise(table, *(c * 7 * 2 ** o + 5 * o for c in p)) for o in range(4))
        yield min(1.0, max(0.0, 2.5 * (inside + 1.3 * (noise - 0.5))))


def vol(cells, low, high, densities):
    """A volume in Mitsuba's format: 32-bit floats, one channel."""
    count = cells[0] * cells[1] * cells[2]
    return b"VOL\x03" + struct.pack("<5i", 1, *cells, 1) + struct.pack("<6f", *low, *high) + struct.pack(f"<{count}f", *densities)


VOLUMES = {"cloud": ("cloud.vol", (96, 52, 84), CLOUD_LOW, CLOUD_HIGH, puffs)}

# --- glTF --------------------------------------------------------------------------------------------------------------

FLOAT, UNSIGNED_SHORT, UNSIGNED_INT = 5126, 5123, 5125
ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER = 34962, 34963


# --- textures: rows of pixels, 8 bits for red, green and blue -------------------------------------------------------------


def tiles(pixel):
    """The picture of 512 squared pixels in 8 x 8 tiles; `pixel` is told the tile and a number from 0 to 255 that varies within."""
    return [[pixel((x // 64 * 5 + y // 64 * 3) % 8, (x * 37 ^ y * 91) & 255) for x in range(512)] for y in range(512)]


TEXTURES = {
    "color.png": lambda: tiles(lambda tile, grain: (160 + 8 * tile, 200 - 12 * tile + grain // 16, 140 + grain // 4)),
    # Red is not looked at, green is the roughness, blue the metalness.
    "rough.png": lambda: tiles(lambda tile, grain: (0, 70 + 16 * tile + grain // 8, 255 * (tile % 2))),
}
# By scene; their order is that of the indices in materials. Texture coordinates are an affine function of the position.
TEXTURED = {"textured-box": ["color.png", "rough.png"]}


def png(rows):
    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    packed = b"".join(b"\0" + bytes(c for pixel in row for c in pixel) for row in rows)
    header = struct.pack(">2I5B", len(rows[0]), len(rows), 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(packed, 9)) + chunk(b"IEND", b"")


def to_gltf(v):
    return (v[0], v[2], -v[1] + 0.0)  # + 0.0: no negative zeros


class Buffer:
    """The binary chunk with its views and accessors: one of each per array."""

    def __init__(self):
        self.data, self.views, self.accessors = bytearray(), [], []

    def add(self, packed, target, **accessor):
        self.views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(packed), "target": target})
        self.data += packed + bytes(-len(packed) % 4)
        self.accessors.append({"bufferView": len(self.views) - 1, **accessor})
        return len(self.accessors) - 1

    def vectors(self, vectors, bounds=False):
        flat = struct.pack(f"<{3 * len(vectors)}f", *(x for v in vectors for x in to_gltf(v)))
        extra = {}
        if bounds:  # of the float32 values, as the specification wants them
            stored = list(struct.iter_unpack("<3f", flat))
            extra = {"min": [min(axis) for axis in zip(*stored)], "max": [max(axis) for axis in zip(*stored)]}
        return self.add(flat, ARRAY_BUFFER, componentType=FLOAT, count=len(vectors), type="VEC3", **extra)

    def coordinates(self, positions):
        flat = struct.pack(f"<{2 * len(positions)}f", *(c for x, y, z in positions for c in (x + 0.5 * y, z + 0.5 * y)))
        return self.add(flat, ARRAY_BUFFER, componentType=FLOAT, count=len(positions), type="VEC2")

    def indices(self, triangles):
        flat = [i for t in triangles for i in t]
        # 65535 restarts a primitive.
        code, component = ("H", UNSIGNED_SHORT) if max(flat) < 65535 else ("I", UNSIGNED_INT)
        packed = struct.pack(f"<{len(flat)}{code}", *flat)
        return self.add(packed, ELEMENT_ARRAY_BUFFER, componentType=component, count=len(flat), type="SCALAR")

    def primitive(self, mesh, material, textured):
        positions, triangles, normals = mesh
        attributes = {"POSITION": self.vectors(positions, bounds=True)}
        if textured:
            attributes["TEXCOORD_0"] = self.coordinates(positions)
        if normals:
            attributes["NORMAL"] = self.vectors(normals)
        return {"attributes": attributes, "indices": self.indices(triangles), "material": material}


def document(name, objects, materials):
    """The glTF document as JSON data, and its binary chunk."""
    buffer, order = Buffer(), list(materials)
    images = TEXTURED.get(name, [])
    meshes = [{"name": n, "primitives": [buffer.primitive(mesh, order.index(material), images)]} for n, mesh, material in objects]
    textures = {"images": [{"uri": uri} for uri in images], "textures": [{"source": i} for i in range(len(images))]}
    nodes = [{"name": n, "mesh": i} for i, (n, _, _) in enumerate(objects)]
    origin, pitch, fov, *right = CAMERAS.get(name, CAMERA)
    (sp, cp), (sr, cr) = ((math.sin(angle / 2), math.cos(angle / 2)) for angle in (pitch, right[0] if right else 0.0))
    # up, then to the right about the vertical
    turn = {"rotation": [cr * sp, -sr * cp, sr * sp, cr * cp] if right else [sp, 0.0, 0.0, cp]} if pitch else {}
    nodes.append({"name": "camera", "camera": 0, "translation": list(to_gltf(origin)), **turn})
    extensions = {}
    if name in LAMPS:
        position, intensity = LAMPS[name]
        lamp = {"name": "lamp", "type": "point", "intensity": intensity}
        extensions = {"extensions": {"KHR_lights_punctual": {"lights": [lamp]}}}
        nodes.append({"name": "lamp", "translation": list(to_gltf(position)), "extensions": {"KHR_lights_punctual": {"light": 0}}})
    used = {e for m in materials.values() for e in m.get("extensions", {})} | set(extensions.get("extensions", {}))
    lens = {"yfov": math.radians(fov), "aspectRatio": 1.0, "znear": 0.001}
    return {
        "asset": {"version": "2.0", "generator": "etendue scenes/make.py"},
        "extensionsUsed": sorted(used),
        **extensions,
        "scene": 0,
        "scenes": [{"name": name, "nodes": list(range(len(nodes)))}],
        "nodes": nodes,
        "cameras": [{"name": "camera", "type": "perspective", "perspective": lens}],
        "materials": [{"name": n, **m} for n, m in materials.items()],
        **(textures if images else {}),
        "meshes": meshes,
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
        "buffers": [{"uri": "scene.bin", "byteLength": len(buffer.data)}],
    }, bytes(buffer.data)


def main(names):
    unknown = sorted(set(names) - set(SCENES))
    if unknown:
        sys.exit(f"make.py: no scene is called {', '.join(unknown)}; there are {', '.join(SCENES)}")
    for name in names or SCENES:
        objects, materials = SCENES[name]()
        gltf, binary = document(name, objects, materials)
        folder = HERE / name
        folder.mkdir(exist_ok=True)
        (folder / "scene.bin").write_bytes(binary)
        (folder / "scene.gltf").write_text(json.dumps(gltf, indent=2) + "\n", encoding="utf-8")
        if name in ENVIRONMENTS:
            width, height, picture = ENVIRONMENTS[name]
            (folder / "env.exr").write_bytes(exr(width, height, picture(width, height)))
        if name in VOLUMES:
            file, cells, low, high, densities = VOLUMES[name]
            (folder / file).write_bytes(vol(cells, low, high, densities(*cells)))
        for uri in TEXTURED.get(name, []):
            (folder / uri).write_bytes(png(TEXTURES[uri]()))
        triangles = sum(len(mesh[1]) for _, mesh, _ in objects)
        print(f"{folder / 'scene.gltf'}: {triangles} triangles, {len(binary)} bytes")


if __name__ == "__main__":
    main(sys.argv[1:])
