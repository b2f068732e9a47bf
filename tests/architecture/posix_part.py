#!/usr/bin/env python3
"""Checks that the sources that hal/linux/posix.txt lists use POSIX and nothing of Linux.

usage: posix_part.py ROOT COMPILER     prints file: what is wrong; exit 1 when anything is

Each system header that they include, also by the rooms' own headers, is one of POSIX' or in ALSO; no path of Linux' own file
systems is in them; and each compiles where only POSIX' names are visible (posix_only.hpp). Every source of the room is named
in docs/bsd.md, which says what becomes of it in a port.
"""
import concurrent.futures
import fnmatch
import pathlib
import re
import subprocess
import sys

# Source: POSIX.1-2008, "Headers": those that the room uses.
POSIX = """arpa/inet.h dirent.h dlfcn.h fcntl.h grp.h net/if.h netdb.h netinet/in.h netinet/tcp.h poll.h pthread.h pwd.h sched.h
signal.h stdlib.h sys/mman.h sys/resource.h sys/socket.h sys/stat.h sys/statvfs.h sys/time.h sys/types.h sys/uio.h sys/un.h
sys/utsname.h sys/wait.h termios.h time.h unistd.h""".split()
# What POSIX does not have and every BSD has: ioctl() of terminals, flock().
ALSO = ["sys/ioctl.h", "sys/file.h"]

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.MULTILINE)
LINUX_PATH = re.compile(r'"/(?:proc|sys|dev/shm)\b[^"]*"')


def listed(root):
    lines = (root / "hal/linux/posix.txt").read_text(encoding="utf-8").splitlines()
    return ["hal/linux/" + line.split()[0] for line in lines if line.strip() and not line.startswith("#")]


def closure(root, source):
    """The source and every project header that it includes, with the file that includes it."""
    seen, open_ = {source: None}, [source]
    while open_:
        path = open_.pop()
        for kind, name in INCLUDE.findall((root / path).read_text(encoding="utf-8")):
            if kind == '"' and name not in seen:
                seen[name] = path
                open_.append(name)
    return seen


def problems_of(root, compiler, source):
    if not (root / source).is_file():
        yield f"{source}: is listed in hal/linux/posix.txt, and there is no such file"
        return
    for path in closure(root, source):
        text = (root / path).read_text(encoding="utf-8")
        for kind, name in INCLUDE.findall(text):
            if kind == "<" and name.endswith(".h") and name not in POSIX + ALSO:
                yield f"{source}: {'includes' if path == source else path + ' includes'} <{name}>, which is not POSIX'"
    for path in LINUX_PATH.findall((root / source).read_text(encoding="utf-8")):
        yield f"{source}: {path} is a path of Linux' own"
    here = pathlib.Path(__file__).parent
    command = [compiler, "-std=c++20", "-fsyntax-only", "-U_GNU_SOURCE", "-D_XOPEN_SOURCE=700", f"-I{root}", "-include",
               here / "posix_only.hpp", root / source]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        wrong = [line for line in done.stderr.splitlines() if "error" in line]
        yield f"{source}: does not compile with POSIX alone: " + "; ".join(wrong[:5])


def unnamed(root):
    """Sources of the room that the page for ports does not name, as `name.cpp`, `name` or `na*`."""
    named = re.findall(r"`([a-z0-9_*]+)(?:\.[ch]pp)?`", (root / "docs/bsd.md").read_text(encoding="utf-8"))
    for path in sorted((root / "hal/linux").rglob("*.cpp")):
        if "libcamera" not in path.parts and not any(fnmatch.fnmatch(path.stem, name) for name in named):
            yield f"{path.relative_to(root)}: docs/bsd.md does not say what becomes of it in a port"


def main():
    root, compiler = pathlib.Path(sys.argv[1]), sys.argv[2]
    sources = listed(root)
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        found = [p for some in pool.map(lambda s: list(problems_of(root, compiler, s)), sources) for p in some]
    found += unnamed(root)
    for problem in found:
        print(problem)
    print(f"posix_part: {len(sources)} sources, {len(found)} problems")
    return 1 if found or not sources else 0


if __name__ == "__main__":
    sys.exit(main())
