#!/usr/bin/env python3
"""Finds calls into the C library's mathematics: glibc picks variants by the processor, so two machines differ.

usage: libm_symbols.py --libm FILE [--libm FILE...] ARCHIVE-OR-OBJECT...
    prints file(member): symbol; exit 1 when there is one

Every symbol that libm (or libmvec) exports counts, also the harmless ones such as floor: math/ has what is needed.
"""
import argparse
import subprocess
import sys


def nm(*arguments):
    return subprocess.run(["nm", *arguments], capture_output=True, text=True, check=True).stdout


def exported(library):
    """Names of the functions and tables a shared library defines, without their version."""
    names = set()
    for line in nm("-D", "--defined-only", "--format=posix", library).splitlines():
        name, kind = line.split()[:2]
        if kind in "TtWwViBDR" and not name.startswith("GLIBC_"):
            names.add(name.split("@")[0])
    return names


def undefined(file):
    """(member, symbol) of everything an archive or object needs from elsewhere."""
    member = ""
    for line in nm("--undefined-only", "--format=posix", file).splitlines():
        if line.endswith(":"):
            member = line[:-1].split("[")[-1].rstrip("]")
        elif line:
            yield member, line.split()[0].split("@")[0]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--libm", action="append", required=True)
    parser.add_argument("files", nargs="+")
    arguments = parser.parse_args()
    forbidden = set().union(*(exported(library) for library in arguments.libm))
    if "sin" not in forbidden:
        sys.exit(f"{arguments.libm[0]} does not export sin: this is not the C library's mathematics")
    found, read = 0, 0
    for file in arguments.files:
        for member, symbol in undefined(file):
            read += 1
            if symbol in forbidden:
                print(f"{file}({member}): {symbol}")
                found += 1
    print(f"{len(arguments.files)} files, {read} undefined symbols, {found} of them in libm")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
