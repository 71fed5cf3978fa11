#!/usr/bin/env python3
"""Renders scenes by several methods for the same time and joins the pictures, a row a scene, with what the images say of their error.

    docs/make_equal_time.py OUT.png SCENE… [--methods bdpt,mlt] [--time 30s] [--size 256x256] [--etendue target/release/etendue]

Needs Pillow. For an idle machine.
"""
import argparse
import json
import subprocess
import tempfile
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

LINE = 16


def render(args, scene, method, folder):
    image, report = Path(folder) / "image.png", Path(folder) / "report.json"
    subprocess.run([args.etendue, "render", scene, "--no-config", "-m", method, "--filter", "box", "--depth", "64", "--size", args.size,
                    "--time", args.time, "--seed", "5", "--quiet", "-o", image, "--report", report], check=True, stdout=subprocess.DEVNULL)
    told = json.loads(report.read_text())
    text = f"{method}: {told['render']['spp']} spp, relMSE {told['error']['relmse']['value']:.2g}"
    return Image.open(image).convert("RGB"), text


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out")
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--methods", default="bdpt,mlt")
    parser.add_argument("--time", default="30s")
    parser.add_argument("--size", default="256x256")
    parser.add_argument("--etendue", default="target/release/etendue")
    args = parser.parse_args()
    rows = []
    for scene in args.scenes:
        with tempfile.TemporaryDirectory() as folder:
            rows.append([render(args, scene, method, folder) for method in args.methods.split(",")])
    width, height = rows[0][0][0].size
    sheet = Image.new("RGB", (width * len(rows[0]), (height + LINE) * len(rows)), "white")
    draw = ImageDraw.Draw(sheet)
    for y, row in enumerate(rows):
        for x, (image, text) in enumerate(row):
            sheet.paste(image, (x * width, y * (height + LINE)))
            draw.text((x * width + 3, y * (height + LINE) + height + 2), text, fill="black", font=ImageFont.load_default(11))
            print(args.scenes[y], text)
    sheet.save(args.out)


main()
