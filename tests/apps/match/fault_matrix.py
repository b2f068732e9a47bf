#!/usr/bin/env python3
"""A device of one player fails in a match of 2 on 2; does its team go on? The table of docs/match.md.

usage: fault_matrix.py SINEW [--minutes M] [--seed N] [--only NAME,...]
Exit code 1: a match was not played to its end, or the mate of the player that failed did nothing after it.
"""
import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile

SOURCE = pathlib.Path(__file__).resolve().parents[3]
TEAMS = [str(SOURCE / "robots/kid" / name) for name in ("kid_team.toml", "kid_alone.toml")]
AT = 16  # s: play has begun
FAULTS = {"none": None, "camera": "camera:off", "camera_stuck": "camera:stuck", "radio": "radio:off", "imu": "imu:off",
          "leg": "left_leg:off", "arm": "left_arm:off", "head": "head:off", "soles": "soles:off", "referee": "referee:off",
          "joint": "left_leg:wrong(0.3)", "joints": "joints:stuck", "dead": "link:closed", "liar": "report:wrong(3)@16+10"}


def play(sinew, fault, minutes, seed):
    words = ["--set", "sim.referee_ready_s=10", "--set", "sim.referee_set_s=3", "--minutes", str(minutes), "--seed", str(seed)]
    if fault:
        words += ["--fault", f"blue1/{fault}" if "@" in fault else f"blue1/{fault}@{AT}"]
    with tempfile.TemporaryDirectory(prefix="sinew_faults_") as folder:
        done = subprocess.run([sinew, "match", *TEAMS, *words, "--no-record", "--json"], capture_output=True, text=True, cwd=folder,
                              timeout=3600, env=dict(os.environ, SINEW_RUN_DIR=folder), check=False)
    if not done.stdout:
        raise RuntimeError(done.stderr)
    return done.returncode, json.loads(done.stdout.splitlines()[-1])


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("sinew")
    parser.add_argument("--minutes", type=float, default=1)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default=",".join(FAULTS))
    o = parser.parse_args()
    bad = 0
    for name in o.only.split(","):
        code, result = play(os.path.abspath(o.sinew), FAULTS[name], o.minutes, o.seed)
        print(json.dumps({"fault": name, "code": code, "result": result}), flush=True)
        bad += code != 0
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
