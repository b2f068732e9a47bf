#!/usr/bin/env python3
"""quad_learned.toml: lands with pictures, is recorded and replayed exactly; policies from files; files that are none.
usage: learned_flight_test.py SINEW SINEW_LEARN ROBOTS"""
import json
import os
import pathlib
import subprocess
import sys
import tempfile

SINEW, LEARN, ROBOTS = sys.argv[1:4]
ROBOT = os.path.join(ROBOTS, "quad/quad_learned.toml")


def run(*words, good=0):
    said = subprocess.run(words, capture_output=True, text=True, timeout=280)
    assert said.returncode == good, (words, said.returncode, said.stdout[-2000:], said.stderr[-2000:])
    return said.stdout + said.stderr


def it_lands_and_is_replayed_exactly(folder):
    run(SINEW, "run", ROBOT, "--virtual", "--seed", "500001", "--runs", str(folder / "runs"))
    record = folder / "runs" / "latest" / "run.mcap"
    said = run(SINEW, "replay", str(record))
    assert "identical" in said, said


def a_policy_from_a_file_takes_the_place_of_the_robots_own(folder):
    policy = folder / "policy.toml"
    run(LEARN, "policy", str(policy), "--trials", "1", "--variant", "online")
    said = run(SINEW, "run", ROBOT, "--virtual", "--duration", "1", "--no-record", "--params", str(policy), "--json",
               good=1)  # nobody lands within a second
    assert json.loads(said.splitlines()[-1]) is not None


def a_wrong_policy_is_refused_with_its_place(folder):
    short = folder / "short.toml"
    short.write_text('[landing]\naside = "1 2 3"\n')
    said = run(SINEW, "run", ROBOT, "--virtual", "--no-record", "--params", str(short), good=2)
    assert "aside: 147 numbers are needed, here are 3" in said, said
    unknown = folder / "unknown.toml"
    unknown.write_text('[landing]\nasid = "1 2 3"\n')
    said = run(SINEW, "run", ROBOT, "--virtual", "--no-record", "--params", str(unknown), good=2)
    assert f"{unknown}:2" in said and "asid" in said, said


with tempfile.TemporaryDirectory() as name:
    place = pathlib.Path(name)
    os.environ["SINEW_RUN_DIR"] = name
    os.environ.pop("SINEW_RECORD", None)  # this flight is recorded, whatever the caller does with others
    a_wrong_policy_is_refused_with_its_place(place)
    a_policy_from_a_file_takes_the_place_of_the_robots_own(place)
    it_lands_and_is_replayed_exactly(place)
