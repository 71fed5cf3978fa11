#!/usr/bin/env python3
"""Renders the pictures of docs/guide/ to docs/images/guide/.

    docs/make_guide_pictures.py materials|error|dark [--etendue target/release/etendue] [--model FILE] [--map FILE.hdr]

`dark` needs --model (Khronos's WaterBottle) and --map (forest.hdr of pmndrs/assets). Needs Pillow; `error` needs numpy
and OpenEXR too. About two CPU minutes in all.
"""

import argparse
import base64
import json
import math
import struct
import subprocess
import tempfile
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

ROOT = Path(__file__).resolve().parent.parent
OUT = ROOT / "docs/images/guide"
CAPTION = 18


def run(arguments, *options):
    subprocess.run([arguments.etendue, *map(str, options)], check=True, stdout=subprocess.DEVNULL)


def sheet(pictures, columns, out):
    """Joins (caption, picture) in rows."""
    width, height = pictures[0][1].size
    rows = -(-len(pictures) // columns)
    image = Image.new("RGB", (columns * width, rows * (height + CAPTION)), "white")
    draw = ImageDraw.Draw(image)
    for i, (caption, picture) in enumerate(pictures):
        x, y = i % columns * width, i // columns * (height + CAPTION)
        image.paste(picture, (x, y))
        draw.text((x + 4, y + height + 2), caption, fill="black", font=ImageFont.load_default(12))
    image.save(out, **({"quality": 90} if out.suffix == ".jpg" else {}))


# --- spheres of all kinds of materials ----------------------------------------------------------------------------
def metal(roughness):
    return {
        "pbrMetallicRoughness": {
            "baseColorFactor": [1, 0.77, 0.34, 1],
            "metallicFactor": 1,
            "roughnessFactor": roughness,
        }
    }


def plastic(roughness, **more):
    base = {"baseColorFactor": [0.55, 0.06, 0.05, 1], "metallicFactor": 0, "roughnessFactor": roughness}
    return {"pbrMetallicRoughness": base, **more}


def clear(roughness=0.0, color=(1, 1, 1), **extensions):
    base = {"baseColorFactor": [*color, 1], "metallicFactor": 0, "roughnessFactor": roughness}
    return {
        "pbrMetallicRoughness": base,
        "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}, **extensions},
    }


def alpha(mode):
    base = {"baseColorFactor": [0.1, 0.4, 0.7, 0.5], "metallicFactor": 0, "roughnessFactor": 0.5}
    return {"pbrMetallicRoughness": base, "alphaMode": mode, "doubleSided": True}


SOLID = {"KHR_materials_volume": {"thicknessFactor": 1}}
TINTED = {
    "KHR_materials_volume": {"thicknessFactor": 1, "attenuationDistance": 0.6, "attenuationColor": [0.5, 0.9, 0.6]}
}
SPHERES = [
    ("non-metal, roughness 0", plastic(0)),
    ("0.2", plastic(0.2)),
    ("0.4", plastic(0.4)),
    ("0.7", plastic(0.7)),
    ("specularFactor 0", plastic(0.2, extensions={"KHR_materials_specular": {"specularFactor": 0}})),
    ("metal, roughness 0", metal(0)),
    ("0.2", metal(0.2)),
    ("0.4", metal(0.4)),
    ("0.7", metal(0.7)),
    ("1", metal(1)),
    ("transmission", clear()),
    ("rough 0.4", clear(0.4)),
    ("with volume", clear(**SOLID)),
    ("ior 1.05", clear(**SOLID, KHR_materials_ior={"ior": 1.05})),
    ("attenuation", clear(**TINTED)),
    ("alphaMode BLEND", alpha("BLEND")),
    ("unlit", {**plastic(1), "extensions": {"KHR_materials_unlit": {}}}),
    (
        "emissive",
        {
            "emissiveFactor": [1, 0.5, 0.2],
            "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 1.5}},
        },
    ),
    ("metallic 0.5", {"pbrMetallicRoughness": {**metal(0.3)["pbrMetallicRoughness"], "metallicFactor": 0.5}}),
    ("base colour 1", {"pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 1}}),
]


def sphere_scene(material, path):
    """A sphere of `material` on a striped floor between two lamps."""
    rings, segments = 64, 128
    points = []
    for i in range(rings + 1):
        for j in range(segments + 1):
            theta, phi = math.pi * i / rings, 2 * math.pi * j / segments
            points.append((math.sin(theta) * math.cos(phi), math.cos(theta), -math.sin(theta) * math.sin(phi)))
    triangles = []
    for i in range(rings):
        for j in range(segments):
            a, b = i * (segments + 1) + j, (i + 1) * (segments + 1) + j
            triangles += [a, b, a + 1, a + 1, b, b + 1]
    quad, two = [(-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)], [0, 1, 2, 0, 2, 3]
    # One buffer: the sphere's positions (also its normals) and indices, then the quad's.
    parts = [(points, "<3f"), ([(k,) for k in triangles], "<I"), (quad, "<3f"), ([(k,) for k in two], "<I")]
    data, views, accessors = b"", [], []
    for values, layout in parts:
        block = b"".join(struct.pack(layout, *value) for value in values)
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(block)})
        vector = layout == "<3f"
        accessor = {
            "bufferView": len(views) - 1,
            "componentType": 5126 if vector else 5125,
            "count": len(values),
            "type": "VEC3" if vector else "SCALAR",
        }
        if vector:
            accessor |= {
                "min": [min(v[k] for v in values) for k in range(3)],
                "max": [max(v[k] for v in values) for k in range(3)],
            }
        accessors.append(accessor)
        data += block
    grey = lambda value: {
        "pbrMetallicRoughness": {"baseColorFactor": [value] * 3 + [1], "metallicFactor": 0, "roughnessFactor": 1},
        "extensions": {"KHR_materials_specular": {"specularFactor": 0}},
    }
    lamp = {
        "emissiveFactor": [1, 1, 1],
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 9}},
        "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1]},
    }
    quads = [{"primitives": [{"attributes": {"POSITION": 2}, "indices": 3, "material": m}]} for m in (1, 2, 3)]
    ball = {"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 0}, "indices": 1, "material": 0}]}
    stripes = [
        {"mesh": 1 + i % 2, "translation": [0.8 * (i - 5), -1.001, 0], "scale": [0.4, 1, 8]} for i in range(11)
    ]
    lamps = [
        {"mesh": 3, "translation": t, "rotation": r, "scale": s}
        for t, r, s in (
            ([-3, 4, 2.5], [0.9, 0.0, 0.43, 0.0], [1, 1, 1]),
            ([4, 3, -1], [0.88, 0.0, -0.48, 0.0], [0.6, 1, 1.5]),
        )
    ]
    scene = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": list(range(4 + len(stripes)))}],
        "nodes": [
            {"mesh": 0},
            {"camera": 0, "translation": [0, 0.9, 5.2], "rotation": [-0.0785, 0, 0, 0.9969]},
            *lamps,
            *stripes,
        ],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.5, "aspectRatio": 1, "znear": 0.1}}],
        "meshes": [ball, *quads],
        "materials": [material, grey(0.7), grey(0.12), lamp],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [
            {
                "byteLength": len(data),
                "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode(),
            }
        ],
        "extensionsUsed": sorted(
            {"KHR_materials_specular", "KHR_materials_emissive_strength", *material.get("extensions", {})}
        ),
    }
    path.write_text(json.dumps(scene))


def materials(arguments):
    pictures = []
    with tempfile.TemporaryDirectory() as folder:
        for caption, material in SPHERES:
            scene, image = Path(folder) / "sphere.gltf", Path(folder) / "sphere.png"
            sphere_scene(material, scene)
            run(
                arguments,
                "render",
                scene,
                "-m",
                "bdpt",
                "--env",
                "0.25,0.28,0.32",
                "--size",
                "160x160",
                "--spp",
                "64",
                "--quiet",
                "-o",
                image,
            )
            pictures.append((caption, Image.open(image).convert("RGB")))
    sheet(pictures, 5, OUT / "materials.jpg")


# --- an image, its standard error and its true error --------------------------------------------------------------
def error(arguments):
    import numpy
    import OpenEXR

    def grey(values):
        values = numpy.clip(values, 0, 1) ** (1 / 2.2)
        return (
            Image.fromarray((255 * values + 0.5).astype(numpy.uint8)).convert("RGB").resize((288, 288), Image.NEAREST)
        )

    with tempfile.TemporaryDirectory() as folder:
        scene, image, png = ROOT / "scenes/cornell-box/scene.gltf", Path(folder) / "a.exr", Path(folder) / "a.png"
        run(arguments, "render", scene, "--size", "256x256", "--spp", "16", "--quiet", "-o", image, "--png")
        read = lambda path: {
            name: channel.pixels
            for name, channel in OpenEXR.File(str(path), separate_channels=True).channels().items()
        }
        mine, truth = read(image), read(scene.parent / "reference.exr")
        stated = sum(mine[f"stderr.{c}"] for c in "RGB") / 3
        true = sum(abs(mine[c] - truth[c]) for c in "RGB") / 3
        picture = Image.open(png).convert("RGB").resize((288, 288), Image.NEAREST)
        sheet(
            [
                ("16 samples per pixel", picture),
                ("stated standard error, times 5", grey(5 * stated)),
                ("distance from a reference, times 5", grey(5 * true)),
            ],
            3,
            OUT / "error.jpg",
        )


# --- a model that is dark -----------------------------------------------------------------------------------------
def dark(arguments):
    pictures = []
    with tempfile.TemporaryDirectory() as folder:
        for caption, options in (
            ("as downloaded", []),
            ("--env 1", ["--env", "1"]),
            ("--env forest.hdr", ["--env", arguments.map]),
        ):
            image = Path(folder) / "a.png"
            run(
                arguments,
                "render",
                arguments.model,
                "--size",
                "240x240",
                "--spp",
                "128",
                "--quiet",
                "-o",
                image,
                *options,
            )
            pictures.append((caption, Image.open(image).convert("RGB")))
    sheet(pictures, 3, OUT / "dark.jpg")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("picture", choices=["materials", "error", "dark"])
    parser.add_argument("--etendue", default="target/release/etendue")
    parser.add_argument("--model", type=Path)
    parser.add_argument("--map", type=Path)
    arguments = parser.parse_args()
    OUT.mkdir(exist_ok=True)
    {"materials": materials, "error": error, "dark": dark}[arguments.picture](arguments)


main()
