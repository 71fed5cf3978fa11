#!/usr/bin/env python3
"""Writes seeds for the glTF target: whole files, their buffers and images put into one GLB each.

    fuzz/seed.py OUT FOLDER...

Takes every .gltf and .glb below the folders that is at most 48 KB that way, and makes one that uses all that étendue
reads. Needs Pillow.
"""
import base64
import io
import json
import struct
import sys
from pathlib import Path
from urllib.parse import unquote

from PIL import Image

LARGEST = 48_000


def contents(uri, beside):
    if uri.startswith("data:"):
        return base64.b64decode(uri.split(",", 1)[1], validate=False)
    return (beside / unquote(uri)).read_bytes()


def pack(path):
    """The file as a GLB, or as it is where it is broken in a way that keeps it from being packed."""
    raw = path.read_bytes()
    if path.suffix == ".glb":
        return raw
    try:
        root = json.loads(raw)
        binary = b""
        starts = []
        for buffer in root.get("buffers", []):
            starts.append(len(binary))
            binary += contents(buffer.pop("uri"), path.parent)
            binary += bytes(-len(binary) % 4)
        for view in root.get("bufferViews", []):
            view["byteOffset"] = view.get("byteOffset", 0) + starts[view["buffer"]]
            view["buffer"] = 0
        for image in root.get("images", []):
            if "uri" in image:
                data = contents(image.pop("uri"), path.parent)
                root.setdefault("bufferViews", []).append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
                binary += data + bytes(-len(data) % 4)
                image["bufferView"] = len(root["bufferViews"]) - 1
                image.setdefault("mimeType", "image/png")
        if binary:
            root["buffers"] = [{"byteLength": len(binary)}]
        text = json.dumps(root, separators=(",", ":")).encode()
    except Exception:
        return raw
    return glb(text, binary)


def glb(text, binary):
    text += b" " * (-len(text) % 4)
    binary += bytes(-len(binary) % 4)
    total = 12 + 8 + len(text) + 8 + len(binary)
    head = b"glTF" + struct.pack("<III", 2, total, len(text)) + b"JSON" + text
    return head + struct.pack("<I", len(binary)) + b"BIN\0" + binary


class Everything:
    """One small file with every feature that is read."""

    def __init__(self):
        self.binary, self.views, self.accessors = b"", [], []

    def view(self, data, **more):
        self.views.append({"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data), **more})
        self.binary += data + bytes(-len(data) % 4)
        return len(self.views) - 1

    def accessor(self, kind, shape, count, data, stride=None, **more):
        view = self.view(data, **({"byteStride": stride} if stride else {}))
        self.accessors.append({"bufferView": view, "componentType": kind, "type": shape, "count": count, **more})
        return len(self.accessors) - 1

    def image(self, mode, kind):
        picture = Image.new(mode, (3, 2))
        picture.putdata([n * 9000 if mode == "I;16" else n * 40 if mode == "L" else (n * 40, 255 - n * 40, 9) for n in range(6)])
        out = io.BytesIO()
        picture.save(out, kind)
        return {"bufferView": self.view(out.getvalue()), "mimeType": f"image/{kind.lower()}"}

    def attributes(self):
        f = lambda *numbers: struct.pack(f"<{len(numbers)}f", *numbers)
        position = self.accessor(5126, "VEC3", 4, f(0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0), min=[0, 0, 0], max=[1, 1, 0])
        sparse = {"count": 1, "indices": {"bufferView": self.view(b"\3"), "componentType": 5121},
                  "values": {"bufferView": self.view(f(1, 1, 0.5))}}
        self.accessors[position]["sparse"] = sparse
        return {
            "POSITION": position,
            "NORMAL": self.accessor(5120, "VEC3", 4, bytes([0, 0, 127, 0] * 4), 4, normalized=True),
            "TANGENT": self.accessor(5122, "VEC4", 4, struct.pack("<4h", 32767, 0, 0, -32767) * 4, normalized=True),
            "TEXCOORD_0": self.accessor(5123, "VEC2", 4, struct.pack("<8H", 0, 0, 65535, 0, 0, 65535, 65535, 65535), normalized=True),
            "TEXCOORD_1": self.accessor(5121, "VEC2", 4, bytes([0, 0, 0, 0, 255, 0, 0, 0, 0, 255, 0, 0, 255, 255, 0, 0]), 4, normalized=True),
            "COLOR_0": self.accessor(5121, "VEC4", 4, bytes([255, 200, 100, 128] * 4), normalized=True),
        }

    def material(self):
        t = lambda index, **more: {"index": index, **more}
        turned = {"extensions": {"KHR_texture_transform": {"offset": [0.1, 0.2], "rotation": 0.3, "scale": [2, 3], "texCoord": 1}}}
        extensions = {
            "KHR_materials_emissive_strength": {"emissiveStrength": 5}, "KHR_materials_ior": {"ior": 1.4},
            "KHR_materials_specular": {"specularFactor": 0.5, "specularTexture": t(0), "specularColorTexture": t(1)},
            "KHR_materials_transmission": {"transmissionFactor": 0.5, "transmissionTexture": t(2)},
            "KHR_materials_volume": {"thicknessFactor": 1, "attenuationDistance": 2, "attenuationColor": [0.5, 0.6, 0.7]},
        }
        return {"pbrMetallicRoughness": {"baseColorFactor": [1, 0.5, 0.25, 0.9], "baseColorTexture": t(0, **turned),
                                         "metallicFactor": 0.5, "roughnessFactor": 0.5, "metallicRoughnessTexture": t(1, texCoord=1)},
                "normalTexture": t(0, scale=0.5, **turned), "emissiveTexture": t(2), "emissiveFactor": [0.1, 0.2, 0.3],
                "alphaMode": "BLEND", "doubleSided": True, "extensions": extensions, "extras": {"metal_fresnel": "constant"}}

    def file(self):
        attributes = self.attributes()
        plain = {"POSITION": attributes["POSITION"], "TEXCOORD_0": attributes["TEXCOORD_0"]}
        indices = self.accessor(5121, "SCALAR", 4, bytes([0, 1, 2, 3]))
        moves = self.accessor(5126, "VEC3", 2, struct.pack("<6f", 0, 0, 1, 0, 0, 2))
        turns = self.accessor(5120, "VEC4", 2, struct.pack("<8b", 0, 0, 0, 127, 0, 127, 0, 0), normalized=True)
        instancing = {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": moves, "SCALE": moves, "ROTATION": turns}}}
        f = lambda *numbers: struct.pack(f"<{len(numbers)}f", *numbers)
        times = self.accessor(5126, "SCALAR", 2, f(0, 0.5), min=[0], max=[0.5])
        spline = self.accessor(5126, "VEC3", 6, f(0, 0, 0, 1, 2, 3, 1, 0, 0, 0, 1, 0, 3, 2, 1, 0, 0, 0))
        channel = lambda sampler, path: {"sampler": sampler, "target": {"node": 0, "path": path}}
        animations = [{"samplers": [{"input": times, "output": spline, "interpolation": "CUBICSPLINE"},
                                    {"input": times, "output": turns}, {"input": times, "output": moves, "interpolation": "STEP"}],
                       "channels": [channel(0, "translation"), channel(1, "rotation"), channel(2, "scale")]}]
        images = [self.image("RGB", "PNG"), self.image("I;16", "PNG"), self.image("L", "JPEG")]
        lights = [{"type": "point", "intensity": 3}, {"type": "directional", "color": [1, 0, 0]},
                  {"type": "spot", "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.4}}]
        lamp = lambda index: {"extensions": {"KHR_lights_punctual": {"light": index}}}
        return {
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "extensions": {"KHR_lights_punctual": {"lights": lights}},
            "nodes": [{"children": [1, 2, 3, 4, 5], "translation": [1, 2, 3], "rotation": [0, 0.6, 0, 0.8], "scale": [1, -2, 1]},
                      {"mesh": 0}, {"mesh": 0, "extensions": instancing}, {"camera": 0, **lamp(0)},
                      {"camera": 1, **lamp(1), "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 4, 5, 6, 1]}, lamp(2)],
            "meshes": [{"primitives": [{"attributes": attributes, "indices": indices, "mode": 5, "material": 0},
                                       {"attributes": plain, "indices": indices, "mode": 6, "material": 1},
                                       {"attributes": plain, "material": 2}]}],
            "materials": [self.material(), {"alphaMode": "MASK", "normalTexture": {"index": 2}},
                          {"extensions": {"KHR_materials_unlit": {}}, "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
            "textures": [{"source": 0, "sampler": 0}, {"source": 1, "sampler": 1}, {"source": 2}],
            "samplers": [{"magFilter": 9728, "minFilter": 9987, "wrapS": 33071, "wrapT": 33648}, {"minFilter": 9984, "wrapS": 10497}],
            "images": images, "cameras": [{"type": "perspective", "perspective": {"yfov": 0.7, "aspectRatio": 1.5, "znear": 0.1}},
                                          {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 2, "znear": 0, "zfar": 9}}],
            "animations": animations, "accessors": self.accessors, "bufferViews": self.views, "buffers": [{"byteLength": len(self.binary)}],
        }

    def write(self):
        root = self.file()
        return glb(json.dumps(root, separators=(",", ":")).encode(), self.binary)


def main():
    out = Path(sys.argv[1])
    out.mkdir(parents=True, exist_ok=True)
    (out / "everything").write_bytes(Everything().write())
    for folder in map(Path, sys.argv[2:]):
        for path in sorted(folder.rglob("*.gl[tb]*")):
            if path.suffix not in (".gltf", ".glb"):
                continue
            packed = pack(path)
            if len(packed) <= LARGEST:
                name = "-".join(path.relative_to(folder).with_suffix("").parts)
                (out / name).write_bytes(packed)


main()
