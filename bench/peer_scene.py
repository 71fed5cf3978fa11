#!/usr/bin/env python3
"""Turns a scene of the comparison (scene.json and PLY meshes of shared/peers/scenes.py) into glTF.

    bench/peer_scene.py ~/.cache/etendue-peers/scenes/S5 S5.glb
    etendue render S5.glb --filter box --depth 64 --size 256x256 --spp 64 -o S5.exr

It needs numpy and writes one binary file. Conventions there and what becomes of them:

- Z up becomes Y up: (x, y, z) is (x, z, -y), a rotation, so windings stay.
- Emission is one-sided on a black absorber: black base colour, specularFactor 0, KHR_materials_emissive_strength.
- diffuse is Lambert and two-sided. mirror and ggx reflect their colour at every angle, by roughness √alpha. glass is
  solid.
- The camera is a pinhole with a horizontal field of view.
- glTF has no environment: the option of the command line that stands for it is printed.
- Fog is a box of index 1, a boundary that nothing sees.
"""
import json
import math
import struct
import sys
from pathlib import Path

import numpy as np

FLOAT, UNSIGNED_INT, ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER = 5126, 5125, 34962, 34963


def read_ply(path):
    """Positions, triangles, and normals or None of a binary little-endian PLY file of triangles."""
    with open(path, "rb") as file:
        header = []
        while (line := file.readline().decode().strip()) != "end_header":
            header.append(line)
        count = {words[1]: int(words[2]) for words in map(str.split, header) if words[0] == "element"}
        width = 6 if "property float nx" in header else 3
        vertices = np.fromfile(file, "<f4", count["vertex"] * width).reshape(-1, width)
        faces = np.fromfile(file, [("corners", "u1"), ("indices", "<u4", 3)], count["face"])["indices"]
    return vertices[:, :3], faces, vertices[:, 3:] if width == 6 else None


def y_up(vectors):
    x, y, z = np.moveaxis(np.asarray(vectors, dtype="<f4"), -1, 0)
    return np.stack([x, z, 0 - y], -1)  # 0 - y: no negative zeros


def surface(color, metallic, roughness, **more):
    base = {"baseColorFactor": [*color, 1.0], "metallicFactor": metallic, "roughnessFactor": roughness}
    return {"pbrMetallicRoughness": base, **more}


def emitter(radiance):
    strength = float(max(radiance))
    specular, emissive = {"specularFactor": 0.0}, {"emissiveStrength": strength}
    return surface((0, 0, 0), 0.0, 1.0, emissiveFactor=[x / strength for x in radiance],
                   extensions={"KHR_materials_specular": specular, "KHR_materials_emissive_strength": emissive})


def glass(ior):
    return surface((1, 1, 1), 0.0, 0.0, extensions={"KHR_materials_transmission": {"transmissionFactor": 1.0},
                                                    "KHR_materials_ior": {"ior": ior},
                                                    "KHR_materials_volume": {"thicknessFactor": 1.0}})


def material(source):
    kind = source["type"]
    if kind == "diffuse":
        extensions = {"KHR_materials_specular": {"specularFactor": 0.0}}
        return surface(source["rgb"], 0.0, 1.0, doubleSided=True, extensions=extensions)
    if kind in ("mirror", "ggx"):
        roughness = math.sqrt(source.get("alpha", 0.0))
        return surface(source["rgb"], 1.0, roughness, doubleSided=True, extras={"etendue": {"fresnel": "constant"}})
    if kind == "glass":
        return glass(source["ior"])
    sys.exit(f"peer_scene.py: there is no glTF material for '{kind}'")


def fog(source):
    """A grey medium inside an index-matched boundary."""
    volume = {"thicknessFactor": 1.0}
    if source["sigma_a"] > 0.0:
        volume |= {"attenuationDistance": 1.0 / source["sigma_a"], "attenuationColor": [math.exp(-1.0)] * 3}
    clear = glass(1.0)
    return {**clear, "extensions": {**clear["extensions"], "KHR_materials_volume": volume},
            "extras": {"etendue": {"scattering": source["sigma_s"], "phase": source["g"]}}}


def camera_node(camera):
    """Columns right, up, backward and position."""
    origin, target, up = (np.array(camera[key], dtype=float) for key in ("origin", "target", "up"))
    backward = (origin - target) / np.linalg.norm(origin - target)
    right = np.cross(up, backward)
    right /= np.linalg.norm(right)
    columns = [right, np.cross(backward, right), backward, origin]
    matrix = [x for column, last in zip(columns, (0, 0, 0, 1)) for x in (column[0], column[2], 0 - column[1], last)]
    return {"name": "camera", "camera": 0, "matrix": [float(x) for x in matrix]}


class Buffer:
    """The binary chunk, with a view and an accessor for each array."""

    def __init__(self):
        self.data, self.views, self.accessors = bytearray(), [], []

    def add(self, array, target, component, kind, **more):
        packed = np.ascontiguousarray(array).tobytes()
        self.views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(packed), "target": target})
        self.data += packed
        count = array.size if kind == "SCALAR" else len(array)
        view = len(self.views) - 1
        self.accessors.append({"bufferView": view, "componentType": component, "type": kind, "count": count, **more})
        return len(self.accessors) - 1

    def primitive(self, path, index):
        positions, triangles, normals = read_ply(path)
        positions = y_up(positions)
        bounds = {"min": positions.min(0).tolist(), "max": positions.max(0).tolist()}
        attributes = {"POSITION": self.add(positions, ARRAY_BUFFER, FLOAT, "VEC3", **bounds)}
        if normals is not None:
            attributes["NORMAL"] = self.add(y_up(normals), ARRAY_BUFFER, FLOAT, "VEC3")
        indices = self.add(triangles, ELEMENT_ARRAY_BUFFER, UNSIGNED_INT, "SCALAR")
        return {"attributes": attributes, "indices": indices, "material": index}


def document(scene):
    """The glTF document as JSON data, and its binary chunk."""
    materials = {name: material(source) for name, source in scene["materials"].items()}
    materials |= {f"{o['name']} (emitter)": emitter(o["emit"]) for o in scene["objects"] if o["emit"]}
    worn = [(o["name"], o["ply"], f"{o['name']} (emitter)" if o["emit"] else o["mat"]) for o in scene["objects"]]
    if scene["medium"]:
        materials["fog"] = fog(scene["medium"])
        worn.append(("fog", scene["medium"]["ply"], "fog"))
    order, buffer = list(materials), Buffer()
    primitives = [buffer.primitive(ply, order.index(name)) for _, ply, name in worn]
    meshes = [{"name": name, "primitives": [p]} for (name, _, _), p in zip(worn, primitives)]
    nodes = [{"name": mesh["name"], "mesh": i} for i, mesh in enumerate(meshes)] + [camera_node(scene["camera"])]
    aspect = scene["width"] / scene["height"]
    yfov = 2 * math.atan(math.tan(math.radians(scene["camera"]["fov"]) / 2) / aspect)
    lens = {"yfov": yfov, "aspectRatio": aspect, "znear": 0.001}
    return {
        "asset": {"version": "2.0", "generator": "etendue bench/peer_scene.py"},
        "extensionsUsed": sorted({e for m in materials.values() for e in m.get("extensions", {})}),
        "scene": 0,
        "scenes": [{"name": scene["name"], "nodes": list(range(len(nodes)))}],
        "nodes": nodes,
        "cameras": [{"name": "camera", "type": "perspective", "perspective": lens}],
        "materials": [{"name": name, **m} for name, m in materials.items()],
        "meshes": meshes,
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
        "buffers": [{"byteLength": len(buffer.data)}],
    }, bytes(buffer.data)


def chunk(kind, data, fill):
    data += fill * (-len(data) % 4)
    return struct.pack("<I4s", len(data), kind) + data


def main(folder, output):
    scene = json.loads((Path(folder).expanduser() / "scene.json").read_text())
    gltf, binary = document(scene)
    body = chunk(b"JSON", json.dumps(gltf).encode(), b" ") + chunk(b"BIN\0", binary, b"\0")
    Path(output).write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body)
    triangles = sum(o["tris"] for o in scene["objects"])
    print(f"{output}: {triangles} triangles")
    if scene["env"]:
        print(f"render it with --env {scene['env']}")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
