"""Our own robot in our own door, by many seeds of the door: how many walk so long at 0.2 m/s without a fall, and how far.

usage: walk_seeds.py SINEW SINEW_SIM SOURCE_DIR [SEEDS [SECONDS]]      (20 seeds, 62 s: 2 s of them standing)"""

import concurrent.futures
import importlib.util
import os
import sys

spec = importlib.util.spec_from_file_location(
    "client_test", os.path.join(os.path.dirname(os.path.abspath(__file__)), "client_test.py"))
client_test = importlib.util.module_from_spec(spec)
spec.loader.exec_module(client_test)

SEEDS = int(sys.argv[4]) if len(sys.argv) > 4 else 20
SECONDS = float(sys.argv[5]) if len(sys.argv) > 5 else 62


def walk(seed):
    _, report = client_test.walk(seed, SECONDS)
    return seed, report["players"][0]


upright = 0
with concurrent.futures.ThreadPoolExecutor(2) as pool:
    for number, player in pool.map(walk, range(1, SEEDS + 1)):
        upright += player["falls"] == 0
        print(f"seed {number}: {player['walked_m']:.2f} m, {player['falls']} falls", flush=True)
print(f"{upright} of {SEEDS} without a fall in {SECONDS:g} s")
