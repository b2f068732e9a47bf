#!/usr/bin/env python3
"""Checks which shared libraries programs ask for by name (NEEDED entries, that is our own link lines).

usage: linked_libraries.py [--opencv PART,PART] [--only LIB,LIB...] PROGRAM... [--if-built PROGRAM...]

--opencv  parts of OpenCV that may be named; any other part fails. Libraries that Debian's libopencv_core needs (BLAS,
          TBB, ...) are not our choice and are not looked at.
--only    every NEEDED entry must be one of these (without .so and version): for the core, which must run on a board
          that has nothing but the C++ library.
"""
import argparse
import os
import re
import subprocess
import sys

# What the compiler adds by itself, also in the sanitizers' builds.
TOOLCHAIN = {"libstdc++", "libm", "libgcc_s", "libc", "libpthread", "librt", "libdl", "libatomic", "libasan", "libubsan",
             "libtsan", "libgcov"}


def needed(program):
    out = subprocess.run(["readelf", "-d", "-W", program], capture_output=True, text=True, check=True).stdout
    return re.findall(r"\(NEEDED\).*\[(.+)\]", out)


def stem(library):
    return library.split(".so")[0]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--opencv")
    parser.add_argument("--only")
    parser.add_argument("programs", nargs="+")
    parser.add_argument("--if-built", nargs="*", default=[])
    arguments = parser.parse_args()
    programs = arguments.programs + [program for program in arguments.if_built if os.path.exists(program)]
    problems, entries = 0, 0
    for program in programs:
        for library in needed(program):
            entries += 1
            name = stem(library)
            part = re.fullmatch(r"libopencv_(\w+)", name)
            wrong = None
            if arguments.opencv is not None and part and part.group(1) not in arguments.opencv.split(","):
                wrong = f"OpenCV's {part.group(1)}; allowed: {arguments.opencv or 'none'}"
            elif arguments.only is not None and name not in TOOLCHAIN | set(arguments.only.split(",")) \
                    and not name.startswith("ld-linux"):
                wrong = f"allowed: the compiler's own{' and ' + arguments.only if arguments.only else ''}"
            if wrong:
                problems += 1
                print(f"{program}: links {library}: {wrong}")
    print(f"{len(programs)} programs, {entries} NEEDED entries, {problems} problems")
    return 1 if problems or entries == 0 else 0  # a program without any would be a wrong file, or static


if __name__ == "__main__":
    sys.exit(main())
