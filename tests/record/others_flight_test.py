#!/usr/bin/env python3
"""Foreign readers and decoders find the same as ours in recorded flights, and in the files that `sinew bag` makes of them.

usage: others_flight_test.py SINEW DUMP RUN_FILES BAG_FILES BAG_TEST ROBOT_FILE     exit 77: skipped, with the reason

RUN_FILES: what others_files.py has made of the recorder's tests. BAG_FILES: what BAG_TEST (Apps.Bag) has kept. Where that
did not run among these tests (ctest in one folder only), it runs here.
"""
import json
import os
import pathlib
import subprocess
import sys
import tempfile

from others_reader_test import HERE, SKIPPED, compare, reason_to_skip

# Decoded are the flight with every topic and one file of each command of `sinew bag`. The others have messages of the
# same types, and are only read.
DECODED = ("long", "converted", "cut", "filtered", "merged", "recovered")


def cat(sinew, path, folder):
    """A file with the lines of `sinew bag cat`."""
    name = f"{folder}/{pathlib.Path(path).name}.json"
    with open(name, "w") as lines:
        subprocess.run([sinew, "bag", "cat", path], stdout=lines, check=True)
    return name


def look(sinew, dump, run_files, bag_files, folder):
    flights = sorted(str(p) for p in bag_files.glob("*.mcap"))
    long = str(bag_files / "bag-long.mcap")
    info = json.loads(subprocess.run([sinew, "bag", "info", long, "--json"], capture_output=True, text=True).stdout)
    silent = [topic["name"] for topic in info["topics"] if topic["messages"] == 0]
    if silent != ["filter.report", "sinew/requests"]:  # the filter has nothing to report in a room
        print("without messages:", silent)
        return 1
    decoded = [str(bag_files / f"bag-{name}.mcap") for name in DECODED]
    if not set(decoded) <= set(flights):
        print("kept were only", flights)
        return 1
    failed = compare(dump, flights)
    decoded += sorted(str(p) for p in run_files.glob("*.mcap"))  # with requests, and split files
    arguments = [word for path in decoded for word in (path, cat(sinew, path, folder))]
    node = subprocess.run(["node", HERE / "others/decode_all.mjs", *arguments], capture_output=True, text=True)
    print(node.stdout, node.stderr)
    return 1 if failed or node.returncode != 0 else 0


def main():
    sinew, dump, run_files, bag_files, bag_test, robot = sys.argv[1:]
    run_files, bag_files = pathlib.Path(run_files), pathlib.Path(bag_files)
    reason = reason_to_skip("@mcap/core", "@foxglove/rosmsg2-serialization")
    if reason:
        print("skipped:", reason)
        return SKIPPED
    with tempfile.TemporaryDirectory() as folder:
        kept = bag_files / "bag-long.mcap"
        if not kept.exists() or kept.stat().st_mtime < os.stat(sinew).st_mtime:
            bag_files = pathlib.Path(folder, "bag")
            tested = subprocess.run([sys.executable, "-B", bag_test, sinew, robot], capture_output=True, text=True,
                                    env=dict(os.environ, SINEW_KEEP_FILES=str(bag_files)))
            if tested.returncode != 0:
                print(tested.stderr)
                return 1
        return look(sinew, dump, run_files, bag_files, folder)


if __name__ == "__main__":
    sys.exit(main())
