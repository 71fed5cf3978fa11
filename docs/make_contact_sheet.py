#!/usr/bin/env python3
"""Renders Khronos' sample models and joins the pictures, with their names, to docs/images/gltf-samples.png.

    docs/make_contact_sheet.py SAMPLES [--env ENVIRONMENT ...] [--etendue target/release/etendue] [--spp 256]

SAMPLES is a folder with one folder a model (glTF-Sample-Models, or shared/scenes/gltf-samples). Needs Pillow. Each
ENVIRONMENT is what `etendue render --env` takes, uniform white (1) by default, and gives one sheet: the first
gltf-samples.png, the second gltf-samples-2.png and so on. What one should see is in docs/gltf-samples.md.
"""
import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

MODELS = ["AlphaBlendModeTest", "Avocado", "MetalRoughSpheresNoTextures", "MultiUVTest", "NormalTangentMirrorTest",
          "NormalTangentTest", "OrientationTest", "SimpleSparseAccessor", "TextureCoordinateTest", "TextureSettingsTest",
          "TextureTransformTest", "UnlitTest", "WaterBottle"]
COLUMNS, SIDE, GAP, CAPTION = 5, 256, 8, 20
IMAGES = Path(__file__).resolve().parent / "images"


def scene_file(samples, model):
    for path in (samples / model / "glTF" / f"{model}.gltf", samples / model / f"{model}.gltf"):
        if path.is_file():
            return path
    sys.exit(f"make_contact_sheet.py: no {model}.gltf under {samples / model}")


def render(etendue, scene, environment, spp, output):
    # Some have an emitter too weak to see them by, so all stand in an environment.
    command = [etendue, "render", str(scene), "--env", environment, "--size", f"{SIDE}x{SIDE}", "--spp", str(spp),
               "--quiet", "-o", str(output)]
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
    arguments.add_argument("--env", nargs="+", default=["1"], metavar="ENVIRONMENT")
    arguments.add_argument("--etendue", default="target/release/etendue")
    arguments.add_argument("--spp", type=int, default=256)
    arguments = arguments.parse_args()
    IMAGES.mkdir(exist_ok=True)
    for number, environment in enumerate(arguments.env, 1):
        write(arguments, environment, IMAGES / ("gltf-samples.png" if number == 1 else f"gltf-samples-{number}.png"))


def write(arguments, environment, path):
    pictures = []
    with tempfile.TemporaryDirectory() as folder:
        for model in MODELS:
            output = Path(folder) / f"{model}.png"
            render(arguments.etendue, scene_file(arguments.samples, model), environment, arguments.spp, output)
            with Image.open(output) as picture:
                pictures.append((model, picture.convert("RGB")))
    sheet(pictures).save(path, optimize=True)
    print(f"image: {path}")


main()
