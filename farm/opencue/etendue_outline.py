#!/usr/bin/env python3
"""Renders a picture with OpenCue: a layer whose frames are the shards, and a layer that merges their films.

    etendue_outline.py SCENE SHARDS OUT.exr [option of `etendue render`]…
    etendue_outline.py --print SCENE SHARDS OUT.exr …     the job's XML instead of a submission

Needs pyoutline (opencue-pyoutline). Films go to OUT.films, which every host must see, as it must this folder. ETENDUE names the
binary, CUE_CORES and CUE_MEMORY what a shard gets (4, 4g), CUE_SHOW and CUE_SHOT where the job belongs.
Not tested against a cuebot: see farm/README.md.
"""
import getpass
import os
import shlex
import sys

import outline
import outline.cuerun
import outline.modules.shell
from outline.depend import DependType

NOT_FOR_SHARDS = ("-o", "--output", "--film", "--shard", "--passes", "--techniques", "--time", "--target-error", "--require-target")


def command(*words):
    """One shell command. #IFRAME# must stay as it is: OpenCue puts the frame's number there."""
    return " ".join(word if word == "#IFRAME#" else shlex.quote(str(word)) for word in words)


def job(scene, shards, out, options):
    """The outline of one picture."""
    for option in options:
        if option.startswith(NOT_FOR_SHARDS):
            raise SystemExit(f"etendue_outline.py: {option} is not for shards")
    scene, out = os.path.abspath(scene), os.path.abspath(out)
    films = os.path.splitext(out)[0] + ".films"
    claim(films, [scene, shards, *options])
    etendue = os.environ.get("ETENDUE", "etendue")
    here = os.path.dirname(os.path.abspath(__file__))

    name = "etendue_" + "".join(c if c.isalnum() else "_" for c in os.path.splitext(os.path.basename(out))[0])
    ol = outline.Outline(
        name, show=os.environ.get("CUE_SHOW", "testing"), shot=os.environ.get("CUE_SHOT", "default"), user=getpass.getuser()
    )
    render = outline.modules.shell.Shell(
        "shards",
        type="Render",
        command=["env", command(f"ETENDUE={etendue}", "bash", f"{here}/shard.sh", "#IFRAME#", shards, films, scene, *options)],
        range=f"0-{shards - 1}",
        chunk=1,
        cores=float(os.environ.get("CUE_CORES", 4)),
        threadable=True,
        memory=os.environ.get("CUE_MEMORY", "4g"),
    )
    parts = [f"{films}/{shard}-of-{shards}.film" for shard in range(shards)]
    merge = outline.modules.shell.Shell(
        "merge", type="Util", command=[command(etendue, "merge", *parts, "--output", out)], range="0", chunk=1, cores=1.0
    )
    merge.depend_on(render, DependType.LayerOnLayer)
    ol.add_layer(render)
    ol.add_layer(merge)
    return ol


def claim(films, picture):
    """A film goes on with the settings that it was begun with: another picture must not find it."""
    os.makedirs(films, exist_ok=True)
    path, text = os.path.join(films, "job"), shlex.join(map(str, picture)) + "\n"
    if os.path.exists(path):
        with open(path, encoding="utf-8") as file:
            held = file.read()
        if held != text:
            raise SystemExit(f"etendue_outline.py: {films} holds another picture: {held.strip()}: remove it, or choose another output")
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


def main(words):
    """Submits, or prints."""
    show = words[:1] == ["--print"]
    words = words[show:]
    if len(words) < 3 or not words[1].isdigit() or int(words[1]) < 1:
        raise SystemExit(__doc__)
    ol = job(words[0], int(words[1]), words[2], words[3:])
    if show:
        print(outline.cuerun.OutlineLauncher(ol).serialize(use_pycuerun=False))
    else:
        outline.cuerun.launch(ol, use_pycuerun=False)


if __name__ == "__main__":
    main(sys.argv[1:])
