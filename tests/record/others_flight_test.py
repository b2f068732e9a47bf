#!/usr/bin/env python3
"""Foreign readers and decoders find the same as ours in recorded flights, and in the files that `sinew bag` makes of them.

usage: others_flight_test.py SINEW BAG_TEST ROBOT_FILE DUMP RECORDER_TEST      exit 77: skipped, with the reason
"""
import json
import os
import pathlib
import subprocess
import sys
import tempfile

from others_reader_test import HERE, SKIPPED, compare, reason_to_skip


def main():
    sinew, bag_test, robot, dump, recorder_test = sys.argv[1:]
    reason = reason_to_skip("@mcap/core", "@foxglove/rosmsg2-serialization")
    if reason:
        print("skipped:", reason)
        return SKIPPED
    with tempfile.TemporaryDirectory() as folder:
        tested = subprocess.run([sys.executable, "-B", bag_test, sinew, robot], capture_output=True, text=True,
                                env=dict(os.environ, SINEW_KEEP_FILES=folder))
        if tested.returncode != 0:
            print(tested.stderr)
            return 1
        # Requests and split files.
        subprocess.run([recorder_test, "--gtest_brief=1"], check=True, env=dict(os.environ, SINEW_KEEP_FILES=folder),
                       stdout=subprocess.DEVNULL)
        os.environ["SINEW_RUN_DIR"] = f"{folder}/sockets"  # its robot meets nobody else's
        # Long enough for every topic to have messages, and for steps of every kind.
        flown = subprocess.run([sinew, "run", robot, "--virtual", "--duration", "6", "--camera", "160x120", "--runs",
                                f"{folder}/runs"], capture_output=True, text=True,
                               env={k: v for k, v in os.environ.items() if k != "SINEW_RECORD"})
        for run in pathlib.Path(folder).glob("runs/quad-*/run.mcap"):
            run.rename(f"{folder}/long.mcap")
        info = json.loads(subprocess.run([sinew, "bag", "info", f"{folder}/long.mcap", "--json"], capture_output=True,
                                         text=True).stdout)
        silent = [topic["name"] for topic in info["topics"] if topic["messages"] == 0]
        if silent != ["sinew/requests"]:
            print("without messages:", silent)
            return 1
        paths = sorted(str(p) for p in pathlib.Path(folder).glob("*.mcap"))
        if len(paths) < 7:
            print("written were only", paths, flown.stderr)
            return 1
        failed = compare(dump, paths, folder)
        arguments = []
        for path in paths:
            with open(f"{path}.json", "w") as lines:
                failed |= subprocess.run([sinew, "bag", "cat", path], stdout=lines).returncode != 0
            arguments += [path, f"{path}.json"]
        decoded = subprocess.run(["node", HERE / "others/decode_all.mjs", *arguments], capture_output=True, text=True)
        print(decoded.stdout, decoded.stderr)
        return 1 if failed or decoded.returncode != 0 else 0


if __name__ == "__main__":
    sys.exit(main())
