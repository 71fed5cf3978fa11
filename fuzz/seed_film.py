#!/usr/bin/env python3
"""Takes .film files apart into what the film target reads: the header, a NUL, and each block unpacked with its length before it.
Needs zstd(1).

    fuzz/seed_film.py OUT FILM...
"""
import struct
import subprocess
import sys
from pathlib import Path

PREFIX, HASH = 16, 32


def unpack(blocks):
    while blocks:
        end = 4 + struct.unpack_from("<I", blocks)[0]
        raw = subprocess.run(["zstd", "-dc"], input=blocks[4:end], stdout=subprocess.PIPE, check=True).stdout
        yield struct.pack("<I", len(raw)) + raw
        blocks = blocks[end:]


out = Path(sys.argv[1])
out.mkdir(parents=True, exist_ok=True)
for number, path in enumerate(map(Path, sys.argv[2:])):
    film = path.read_bytes()
    body = PREFIX + struct.unpack_from("<I", film, 12)[0]
    (out / f"film-{number}").write_bytes(film[PREFIX:body] + b"\0" + b"".join(unpack(film[body:-HASH])))
    (out / f"whole-{number}").write_bytes(film)
