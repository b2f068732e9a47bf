#!/usr/bin/env python3
"""Is my team better than the old one? Plays matches of both and reads the answer.

usage: judge_a_team.py SINEW NEW.toml OLD.toml [MATCHES [MINUTES]]
"""
import json
import subprocess
import sys
import tempfile

SINEW, NEW, OLD = sys.argv[1:4]
MATCHES = sys.argv[4] if len(sys.argv) > 4 else "100"
MINUTES = sys.argv[5] if len(sys.argv) > 5 else "10"
OPTIONS = ["--robots", "2", "--minutes", MINUTES, "--no-record"]
if float(MINUTES) < 1:  # a trial: nobody has to walk to a place first
    OPTIONS += ["--set", "sim.referee_ready_s=1", "--set", "sim.referee_set_s=1"]


def main():
    with tempfile.TemporaryDirectory(prefix="sinew-judge-") as folder:  # a file that stays goes on after a break
        command = [SINEW, "match", NEW, OLD, "--count", MATCHES, *OPTIONS, "--results", f"{folder}/all.jsonl", "--json"]
        done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False)
        if done.returncode != 0:
            sys.exit(f"{' '.join(command)}: exit code {done.returncode}")
        answer = json.loads(done.stdout)
        with open(f"{folder}/all.jsonl", encoding="utf-8") as file:
            matches = [json.loads(line) for line in file][1:]  # the first line says what was played
    for match in matches:
        measures = match["measures"]
        print(f"{match['run'].split()[-1]:>4}  {measures['goals_a']:.0f} : {measures['goals_b']:.0f}  {match['outcome']}")
    share, goals = answer["points_share"], answer["goal_difference"]
    print(f"points share of the new one {share['mean']:.2f} (95 %: {share['low']:.2f} to {share['high']:.2f})")
    print(f"goals more than the old one a match {goals['mean']:+.2f} ({goals['low']:+.2f} to {goals['high']:+.2f})")
    better = share["low"] > 0.5 and answer["p"] < 0.05
    print("better" if better else "not shown to be better")


if __name__ == "__main__":
    main()
