#!/usr/bin/env python3
"""Mutations per second and core, and the share of their time that ray queries take, for each kernel of the Metropolis methods.

For each kernel a render in which it is tried three times for each bidirectional mutation (mlt), or alone. What is not chains is measured by
a render of the light that they are not for and taken out; what the bidirectional mutation takes is taken out by the counts in the report. The share is that
of the processor's samples in libembree4 and in what étendue asks it by (perf, cpu-clock), chains and all. One thread; an idle machine.

    bench/mutations.py SCENE… [--etendue target/release/etendue] [--size 256x256] [--spp 16]
"""
import argparse
import json
import os
import subprocess
import tempfile

KERNELS = {
    "mlt": ["bidirectional", "lens", "caustic", "multi-chain", "lens-subpath"],
    "mmlt": ["large-step", "small-step"],
    "pssmlt": ["large-step", "small-step"],
}


def render(args, scene, method, options, folder):
    report = os.path.join(folder, "report.json")
    command = [args.etendue, "render", scene, "-m", method, "--filter", "box", "--depth", "64", "--size", args.size, "--spp", str(args.spp),
               "--limit", "0", "--chains", "8", "--threads", "1", "--quiet", "-o", os.path.join(folder, "image.exr"), "--report", report]
    perf = ["perf", "record", "-q", "-e", "cpu-clock", "-F", "997", "-o", os.path.join(folder, "perf.data")]
    subprocess.run(perf + command + options, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    with open(report) as file:
        report = json.load(file)
    return report["chains"], report["render"]["cpu_seconds"], embree_share(folder)


def embree_share(folder):
    """The part of all samples that fell into Embree."""
    text = subprocess.run(["perf", "report", "-i", os.path.join(folder, "perf.data"), "--sort", "dso", "--stdio", "-q"],
                          check=True, capture_output=True, text=True).stdout
    rows = (line.split() for line in text.splitlines() if line.strip())
    return sum(float(row[0].rstrip("%")) for row in rows if "embree" in row[1]) / 100


def others(args, scene, folder):
    """Seconds of a render but for its chains: the path tracer's two shortest lengths."""
    report = os.path.join(folder, "report.json")
    command = [args.etendue, "render", scene, "-m", "path", "--filter", "box", "--depth", "1", "--size", args.size, "--spp", str(args.spp),
               "--replicates", "16", "--threads", "1", "--quiet", "-o", os.path.join(folder, "image.exr"), "--report", report]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    with open(report) as file:
        return json.load(file)["render"]["cpu_seconds"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--etendue", default="target/release/etendue")
    parser.add_argument("--size", default="256x256")
    parser.add_argument("--spp", type=int, default=16)
    args = parser.parse_args()
    print(f"{'scene':<20}{'method':<8}{'kernel':<15}{'per second':>11}{'accepted':>10}{'in Embree':>11}")
    for scene in args.scenes:
        name = os.path.basename(os.path.dirname(scene))
        with tempfile.TemporaryDirectory() as folder:
            rest = others(args, scene, folder)
            for method, kernels in KERNELS.items():
                base = None
                for kernel in kernels:
                    if method == "mlt":
                        mix = "bidirectional=1" if kernel == "bidirectional" else f"bidirectional=1,{kernel}=3"
                        options = ["--mutations", mix]
                    else:
                        options = ["--large-step", "1" if kernel == "large-step" else "0.02"]
                    chains, seconds, share = render(args, scene, method, options, folder)
                    counts = chains["kernels"]
                    seconds -= rest
                    taken = counts[kernel]["taken"]
                    first = kernels[0]
                    if kernel == first:
                        base = seconds / taken
                    else:
                        seconds -= base * counts[first]["taken"]
                    accepted = counts[kernel]["accepted"] / max(taken, 1)
                    rate = taken / seconds if seconds > 0 else float("nan")
                    print(f"{name:<20}{method:<8}{kernel:<15}{rate:>11.0f}{accepted:>10.3f}{share:>11.3f}", flush=True)


main()
