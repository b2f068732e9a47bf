#!/usr/bin/env python3
"""A program's memory on this machine, measured as tests/boards/init does on a board, for tools/sizes.py --memory.

    tests/boards/memory_here.py OUT PROGRAM [WORD...]      the program's output and exit code are this script's

OUT gets rss_kb and locked_kb, the most of the whole run (in kB of 1024 bytes): every 20 ms the kernel counts the pages
(smaps_rollup; VmRSS of `status` is late by up to 64 pages a thread), and the locked memory (VmLck). And start_ms: the
time that `sinew-control` prints for its start.
Exit: the program's; 2 wrong call; 3 it could not be started, or was gone before it was looked at.
"""
import pathlib
import re
import subprocess
import sys
import tempfile
import time


def numbers(path, names):
    """kB by name, as such a file of /proc has them now; nothing when the process has ended."""
    try:
        text = pathlib.Path(path).read_text(encoding="ascii")
    except OSError:
        return {}
    return {name: int(found[1]) for name in names if (found := re.search(rf"^{name}:\s+(\d+) kB$", text, re.M))}


def main(words):
    if len(words) < 2:
        print(__doc__, file=sys.stderr)
        return 2
    try:
        out = pathlib.Path(words[0]).open("w", encoding="ascii")
    except OSError as error:
        print(f"memory_here: {words[0]}: {error.strerror}", file=sys.stderr)
        return 2
    with out:
        code, lines = measure(words[1:])
        out.write("".join(f"{line}\n" for line in lines))
    if not lines:  # nor those of an earlier run
        pathlib.Path(words[0]).unlink()
    return code


def measure(words):
    """The program's exit code, or 3; the measured values, one number a line."""
    most = {"Rss": 0, "VmLck": 0}
    with tempfile.TemporaryFile("w+") as output:  # a pipe that nobody empties would stop the program
        try:
            program = subprocess.Popen(words, stdout=output)
        except OSError as error:
            print(f"memory_here: {words[0]}: {error.strerror}", file=sys.stderr)
            return 3, []
        while program.poll() is None:
            for name, size in {**numbers(f"/proc/{program.pid}/smaps_rollup", ["Rss"]),
                               **numbers(f"/proc/{program.pid}/status", ["VmLck"])}.items():
                most[name] = max(most[name], size)
            time.sleep(0.02)
        output.seek(0)
        said = output.read()
    print(said, end="")
    if not most["Rss"]:
        print(f"memory_here: {words[0]}: ended before it was looked at", file=sys.stderr)
        return 3, []
    lines = [f"rss_kb={most['Rss']}", f"locked_kb={most['VmLck']}"]
    if found := re.search(r"^ready (\d+\.\d+) s after the start$", said, re.M):
        lines.append(f"start_ms={round(float(found[1]) * 1000)}")
    return program.returncode, lines


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
