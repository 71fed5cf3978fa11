#!/usr/bin/env python3
"""Takes .film files apart into what the film target reads: the header, a NUL, and the body unpacked. Needs zstd(1).

    fuzz/seed_film.py OUT FILM...
"""
import struct
import subprocess
import sys
from pathlib import Path

PREFIX, HASH = 16, 32

out = Path(sys.argv[1])
out.mkdir(parents=True, exist_ok=True)
for number, path in enumerate(map(Path, sys.argv[2:])):
    film = path.read_bytes()
    body = PREFIX + struct.unpack_from("<I", film, 12)[0]
    unpacked = subprocess.run(["zstd", "-dc"], input=film[body:-HASH], stdout=subprocess.PIPE, check=True).stdout
    (out / f"film-{number}").write_bytes(film[PREFIX:body] + b"\0" + unpacked)
    (out / f"whole-{number}").write_bytes(film)
