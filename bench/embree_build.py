#!/usr/bin/env python3
"""Building with Embree: étendue beside a C program that calls Embree directly, in turns, on a scene of one mesh.

    bench/embree_build.py target/release/etendue scenes/landscape/scene.gltf [THREADS]
"""
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile

RUNS = 15
HERE = pathlib.Path(__file__).parent


def view(document, accessor):
    accessor = document["accessors"][accessor]
    buffer_view = document["bufferViews"][accessor["bufferView"]]
    return buffer_view.get("byteOffset", 0) + accessor.get("byteOffset", 0), accessor["count"]


def main(binary, scene, threads="2"):
    document = json.loads(pathlib.Path(scene).read_text())
    primitive = document["meshes"][0]["primitives"][0]
    vertex_offset, vertices = view(document, primitive["attributes"]["POSITION"])
    index_offset, indices = view(document, primitive["indices"])
    buffer = pathlib.Path(scene).parent / document["buffers"][0]["uri"]
    with tempfile.TemporaryDirectory() as folder:
        direct = f"{folder}/embree_build"
        subprocess.run(["cc", "-O2", "-o", direct, HERE / "embree_build.c", "-lembree4"], check=True)
        numbers = map(str, [vertex_offset, vertices, index_offset, indices // 3, threads])
        commands = [direct, buffer, *numbers], [binary, "info", scene, "--threads", threads, "--json"]
        seconds = [], []
        for _ in range(RUNS):
            for command, times in zip(commands, seconds):
                text = subprocess.run(command, check=True, capture_output=True, text=True).stdout
                times.append(float(text) if command is commands[0] else json.loads(text)["accel_seconds"])
    ratios = sorted(ours / theirs for theirs, ours in zip(*seconds))
    medians = [statistics.median(times) for times in seconds]
    print(f"{indices // 3} triangles, {threads} threads: C {medians[0]:.3f} s, étendue {medians[1]:.3f} s; ", end="")
    print(f"ratio {statistics.median(ratios):.3f} ({ratios[0]:.3f} to {ratios[-1]:.3f}), {RUNS} runs in turns")


main(*sys.argv[1:])
