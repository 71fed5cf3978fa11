#!/usr/bin/env python3
"""Start-up time: a 64 × 64 image at 4 samples per pixel, from the start of the process to its end.

    bench/startup.py target/release/etendue scenes/cornell-box/scene.gltf
"""
import statistics
import subprocess
import sys
import tempfile
import time

RUNS = 21


def seconds(command):
    start = time.perf_counter()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return time.perf_counter() - start


def main(binary, scene):
    with tempfile.TemporaryDirectory() as folder:
        command = [binary, "render", scene, "--size", "64x64", "--spp", "4", "--quiet", "-o", f"{folder}/startup.exr"]
        seconds(command)  # the first run reads the binary and Embree from disk
        runs = sorted(seconds(command) for _ in range(RUNS))
    print(f"start-up: {statistics.median(runs):.3f} s in all, median of {RUNS} ({runs[0]:.3f} to {runs[-1]:.3f}); 64x64, 4 spp")


main(*sys.argv[1:])
