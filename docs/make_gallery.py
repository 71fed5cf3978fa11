#!/usr/bin/env python3
"""Renders the pictures of the README to docs/images/gallery/, and prints a table row for each.

    docs/make_gallery.py ASSETS SAMPLES MAPS [--etendue target/release/etendue] [--only NAME ...]

ASSETS is a copy of Khronos's glTF-Sample-Assets/Models, SAMPLES a folder with Babylon.js's TeapotsGalore, MAPS a folder
with sunset.hdr and studio.hdr of pmndrs/assets. The other scenes are those of scenes/ (`make scenes`). Needs Pillow.
Rows state CPU seconds, since they do not depend on other work of the machine.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
OWN = "360x360"
MODEL = "480x360"
# Name, scene or (collection, model), method, samples per pixel, size, environment map, further options.
PICTURES = [
    ("candle-holder", ("assets", "GlassHurricaneCandleHolder"), "path", 128, MODEL, "sunset", []),
    ("shoe", ("assets", "MaterialsVariantsShoe"), "path", 256, MODEL, "studio", ["--exposure", "0.7"]),
    ("teapots", ("samples", "TeapotsGalore"), "path", 64, MODEL, "sunset", []),
    ("modified-cornell", "modified-cornell", "bdpt", 64, OWN, None, []),
    ("glass-caustic", "glass-caustic", "bdpt", 64, OWN, None, []),
    ("veach-mis", "veach-mis", "path", 256, OWN, None, []),
    ("ajar-door", "ajar-door", "mlt", 128, OWN, None, ["--exposure", "2"]),
    ("caustic-pool", "caustic-pool", "mlt", 64, OWN, None, []),
    ("mirror-caustic", "mirror-caustic", "mlt", 32, OWN, None, []),
]
# The first picture of the README.
FIRST = ("first", ("assets", "GlassHurricaneCandleHolder"), "path", 256, "800x450", "sunset", [])


def scene_of(arguments, source):
    if isinstance(source, str):
        return ROOT / "scenes" / source / "scene.gltf"
    collection, model = source
    folder = getattr(arguments, collection) / model
    files = sorted(folder.rglob("*.glb")) + sorted(folder.rglob("*.gltf"))
    return files[0] if files else sys.exit(f"make_gallery.py: no glTF file under {folder}")


def render(arguments, picture, folder):
    name, source, method, spp, size, environment, options = picture
    image, report = Path(folder) / "image.png", Path(folder) / "report.json"
    command = [
        arguments.etendue,
        "render",
        str(scene_of(arguments, source)),
        "--no-config",
        "-m",
        method,
        "--spp",
        str(spp),
        "--size",
        size,
        "--quiet",
        "-o",
        str(image),
        "--report",
        str(report),
        *options,
    ]
    if environment:
        command += ["--env", str(arguments.maps / f"{environment}.hdr")]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    told = json.loads(report.read_text())
    Image.open(image).convert("RGB").save(ROOT / f"docs/images/gallery/{name}.jpg", quality=90)
    error, cpu = told["error"], told["render"]["cpu_seconds"]
    reasons = ", ".join(reason["reason"] for reason in error["reasons"])
    print(
        f"| {name} | {method} | {told['render']['spp']} | {cpu:.0f} s | {error['relmse']['value']:.1e} | {reasons} |",
        flush=True,
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("assets", type=Path)
    parser.add_argument("samples", type=Path)
    parser.add_argument("maps", type=Path)
    parser.add_argument("--etendue", default="target/release/etendue")
    parser.add_argument("--only", nargs="+")
    arguments = parser.parse_args()
    (ROOT / "docs/images/gallery").mkdir(exist_ok=True)
    print("| name | method | spp | CPU time | relMSE | not trusted for |\n|---|---|---|---|---|---|", flush=True)
    for picture in [FIRST, *PICTURES]:
        if arguments.only is None or picture[0] in arguments.only:
            with tempfile.TemporaryDirectory() as folder:
                render(arguments, picture, folder)


main()
