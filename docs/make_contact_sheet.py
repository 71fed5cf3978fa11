#!/usr/bin/env python3
"""Renders ten of Khronos' sample models and joins the pictures, with their names, to docs/images/gltf-samples.png.

    docs/make_contact_sheet.py SAMPLES [--etendue target/release/etendue] [--spp 256]

SAMPLES is a folder with one folder a model (glTF-Sample-Models, or shared/scenes/gltf-samples). Needs Pillow. Models
stand in a uniform white environment. What one should see is in docs/gltf-samples.md.
"""
import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

MODELS = ["AlphaBlendModeTest", "Avocado", "MetalRoughSpheresNoTextures", "MultiUVTest", "OrientationTest",
          "SimpleSparseAccessor", "TextureSettingsTest", "TextureTransformTest", "UnlitTest", "WaterBottle"]
COLUMNS, SIDE, GAP, CAPTION = 5, 256, 8, 20
SHEET = Path(__file__).resolve().parent / "images" / "gltf-samples.png"


def scene_file(samples, model):
    for path in (samples / model / "glTF" / f"{model}.gltf", samples / model / f"{model}.gltf"):
        if path.is_file():
            return path
    sys.exit(f"make_contact_sheet.py: no {model}.gltf under {samples / model}")


def render(etendue, scene, spp, output):
    # Some have an emitter too weak to see them by, so all stand in a white environment.
    command = [etendue, "render", str(scene), "--env", "1", "--size", f"{SIDE}x{SIDE}", "--spp", str(spp), "--quiet", "-o", str(output)]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)


def sheet(pictures):
    rows = -(-len(pictures) // COLUMNS)
    size = (GAP + COLUMNS * (SIDE + GAP), GAP + rows * (SIDE + CAPTION + GAP))
    image = Image.new("RGB", size, (32, 32, 32))
    draw, font = ImageDraw.Draw(image), ImageFont.load_default()
    for i, (name, picture) in enumerate(pictures):
        x, y = GAP + i % COLUMNS * (SIDE + GAP), GAP + i // COLUMNS * (SIDE + CAPTION + GAP)
        image.paste(picture, (x, y))
        draw.text((x + 2, y + SIDE + 3), name, fill=(224, 224, 224), font=font)
    return image


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("samples", type=Path)
    arguments.add_argument("--etendue", default="target/release/etendue")
    arguments.add_argument("--spp", type=int, default=256)
    arguments = arguments.parse_args()
    pictures = []
    with tempfile.TemporaryDirectory() as folder:
        for model in MODELS:
            output = Path(folder) / f"{model}.png"
            render(arguments.etendue, scene_file(arguments.samples, model), arguments.spp, output)
            with Image.open(output) as picture:
                pictures.append((model, picture.convert("RGB")))
    SHEET.parent.mkdir(exist_ok=True)
    sheet(pictures).save(SHEET, optimize=True)
    print(f"image: {SHEET}")


main()
