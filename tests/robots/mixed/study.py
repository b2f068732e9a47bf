#!/usr/bin/env python3
"""A humanoid and robots with wheels fetch an object together, many times: docs/mixed.md.

usage: study.py SINEW [--seeds FIRST:LAST] [--loss SHARE] [--fail KIND] [--jobs N]

KIND: none; dies: the fetcher's computer dies; silent: its radio does; nobody_finds: the finder's radio does, at 0 s.
The time of a failure goes with the seed, 6 to 15 s.
"""
import argparse
import concurrent.futures
import json
import os
import pathlib
import subprocess
import sys
import tempfile

SOURCE = pathlib.Path(__file__).resolve().parents[3]
FILES = [str(SOURCE / "robots/mixed" / name) for name in ("finder.toml", "fetcher.toml", "reserve.toml")]
NAMES = ("finder", "fetcher", "reserve")


def faults(kind, seed):
    at = 6 + seed % 10
    return {"none": [], "dies": ["--fault", f"fetcher/link:closed@{at}"], "silent": ["--fault", f"fetcher/radio:off@{at}"],
            "nobody_finds": ["--fault", "finder/radio:off@0"]}[kind]


def play(sinew, seed, loss=0.3, kind="none", seconds=150, record=None):
    """One run; what the simulator says of it at the end, by robot, and the exit codes."""
    with tempfile.TemporaryDirectory(prefix="sinew_mixed_") as folder:
        keep = ["--runs", record] if record else ["--no-record"]
        done = subprocess.run([sinew, "team", *FILES, "--virtual", "--json", "--seed", str(seed), "--duration", str(seconds),
                               "--set", f"sim.air_loss={loss}", *keep, *faults(kind, seed)],
                              capture_output=True, text=True, cwd=folder, timeout=900,
                              env=dict(os.environ, SINEW_RUN_DIR=folder, TMPDIR=folder), check=False)
    if not done.stdout:
        raise RuntimeError(done.stderr)
    said = json.loads(done.stdout.splitlines()[-1])
    robots = said["plant"]["robots"]
    # The one that saw the world last: a robot that has gone has an older report.
    last = max(robots.values(), key=lambda r: r.get("plant_s", 0))
    return {"seed": seed, "outcome": last["verdict"]["outcome"], "good": last["verdict"]["good"],
            "by": NAMES[int(last["brought_by"])] if last["brought_by"] >= 0 else "-",
            "gripped_s": last["gripped_at_s"], "brought_s": last["brought_at_s"], "from_goal_m": last["object_from_goal_m"],
            "fell_s": robots["finder"].get("first_fall_s"), "codes": {n: r["exit_code"] for n, r in said["robots"].items()},
            "grips": {n: robots[n]["grips"] for n in NAMES[1:]}, "errors": done.stderr}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("sinew")
    parser.add_argument("--seeds", default="1:20")
    parser.add_argument("--loss", type=float, default=0.3)
    parser.add_argument("--fail", default="none", choices=("none", "dies", "silent", "nobody_finds"))
    parser.add_argument("--jobs", type=int, default=1)
    o = parser.parse_args()
    first, last = map(int, o.seeds.split(":"))
    seeds = range(first, last + 1)
    sinew = os.path.abspath(o.sinew)
    with concurrent.futures.ThreadPoolExecutor(o.jobs) as pool:
        good = 0
        print("seed  outcome                              by       held at s  brought at s  from the goal m")
        for r in pool.map(lambda seed: play(sinew, seed, o.loss, o.fail), seeds):
            good += r["good"]
            print(f"{r['seed']:4}  {r['outcome']:35}  {r['by']:7}  {r['gripped_s']:9.1f}  {r['brought_s']:12.1f}  "
                  f"{r['from_goal_m']:15.2f}", flush=True)
    print(f"{good} of {len(seeds)} brought to the goal; loss {o.loss:g}, failure: {o.fail}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
