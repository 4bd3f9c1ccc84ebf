"""Make the release: wheels for all platforms from this machine, and the source distribution.

Usage: python tools/wheels.py [FOLDER]

Needs the dependency group ``release``, whose compiler makes the solver's library for every platform. Prints
what lies in the folder (``dist`` unless given) in the end, each file checked: its name and tags, that all of
the source is in it and nothing else, and that its library is of this source and for its platform.
"""

from __future__ import annotations

import os
import re
import shlex
import sys
import zipfile
from concurrent.futures import ProcessPoolExecutor
from itertools import repeat
from pathlib import Path
from typing import Final, NamedTuple

sys.path.insert(0, str(Path(__file__).parent))

import backend
from compiling import CORE, LIBRARY, SCRIPT
from translate import digest, sources

ROOT: Final = Path(__file__).parents[1]


class Platform(NamedTuple):
    """What the compiler calls a platform, and how a library for it begins."""

    target: str
    magic: bytes


# By the tag of their wheels. The oldest macOS is that of the libraries that vibro needs.
PLATFORMS: Final = {
    "manylinux_2_17_x86_64": Platform("x86_64-linux-gnu.2.17", rb"\x7fELF.{14}\x3e\0"),
    "manylinux_2_17_aarch64": Platform("aarch64-linux-gnu.2.17", rb"\x7fELF.{14}\xb7\0"),
    "macosx_12_0_x86_64": Platform("x86_64-macos.12.0", rb"\xcf\xfa\xed\xfe\x07\0\0\x01"),
    "macosx_12_0_arm64": Platform("aarch64-macos.12.0", rb"\xcf\xfa\xed\xfe\x0c\0\0\x01"),
    "win_amd64": Platform("x86_64-windows-gnu", rb"MZ.{1,500}PE\0\0\x64\x86"),
}


def build(tag: str, folder: Path) -> Path:
    """Build the wheel of a platform."""
    compiler = [sys.executable, "-m", "ziglang", "cc", "-target", PLATFORMS[tag].target]
    os.environ |= {"CC": shlex.join(compiler), "VIBRO_PLATFORM": tag}
    return folder / backend.build_wheel(str(folder))


def faults(wheel: Path, tag: str) -> list[str]:
    """List what is wrong with a wheel."""
    found = []
    stem = wheel.name.removesuffix(f"-py3-none-{tag}.whl")
    if stem == wheel.name:
        found.append(f"the name does not end with py3-none-{tag}: was the solver compiled?")
    with zipfile.ZipFile(wheel) as packed:
        files = {name: packed.read(name) for name in packed.namelist()}
    head = files.get(f"{stem}.dist-info/WHEEL", b"").decode().splitlines()
    if not {f"Tag: py3-none-{tag}", "Root-Is-Purelib: false"} <= {*head}:
        found.append(f"WHEEL has other tags: {head}")
    source = ROOT / "src"
    wanted = {
        path.relative_to(source).as_posix()
        for path in source.rglob("*")
        if path.is_file() and path.parent.name != "__pycache__" and not path.name.startswith(LIBRARY)
    } | {f"vibro/core/{name}" for name in (LIBRARY, SCRIPT)}
    if odd := wanted ^ {name for name in files if ".dist-info/" not in name}:
        found.append(f"lacks, or has beside the source: {', '.join(sorted(odd))}")
    library = files.get(f"vibro/core/{LIBRARY}", b"")
    if not re.match(PLATFORMS[tag].magic, library, re.DOTALL):
        found.append(f"the library is for another platform: it begins with {library[:20]!r}")
    if digest(sources(ROOT / CORE)).encode() not in library:
        found.append("the library is of another source")
    if newer := {version for version in re.findall(rb"GLIBC_2\.(\d+)", library) if int(version) > 17}:
        found.append(f"the library needs glibc 2.{max(map(int, newer))}")
    return found


def main(folder: Path) -> int:
    """Make everything; return 1 if anything is wrong with it."""
    os.chdir(ROOT)
    folder.mkdir(parents=True, exist_ok=True)
    source = folder / backend.build_sdist(str(folder))
    print(f"{source.stat().st_size / 1e6:6.2f} MB  {source.name}")
    failed = False
    with ProcessPoolExecutor() as pool:
        for tag, wheel in zip(PLATFORMS, pool.map(build, PLATFORMS, repeat(folder)), strict=True):
            print(f"{wheel.stat().st_size / 1e6:6.2f} MB  {wheel.name}", flush=True)
            for fault in faults(wheel, tag):
                print(f"           {fault}")
                failed = True
    return int(failed)


if __name__ == "__main__":
    sys.exit(main(Path(*(sys.argv[1:] or ["dist"])).absolute()))
