#!/usr/bin/env python3
"""Two quadrotors in one room: both land, one after the other, whatever their radio does.

usage: team_test.py SINEW ROBOTS CLASS
"""
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

SINEW, ROBOTS = sys.argv[1:3]
TEAM = [f"{ROBOTS}/team/scout.toml", f"{ROBOTS}/team/follower.toml"]
SMALL = ["--camera", "160x120"]
BAD_AIR = ["--set", "sim.air_loss=0.3", "--set", "sim.air_delay_ms=200"]


class InOwnFolder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="sinew-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.env = dict(os.environ, SINEW_RUN_DIR=folder.name, TMPDIR=folder.name)
        self.env.pop("SINEW_RECORD", None)

    def done(self, *arguments, before=()):
        done = subprocess.run([*before, SINEW, "team", *arguments], capture_output=True, text=True, env=self.env,
                              cwd=self.folder, timeout=250)
        return done.returncode, done.stdout, done.stderr

    def fly(self, *arguments, before=(), team=TEAM):
        """The exit code and what --json says."""
        code, out, err = self.done(*team, "--virtual", "--json", "--no-record", *SMALL, *arguments, before=before)
        self.assertIn(code, (0, 1), out + err)
        return code, json.loads(out)


class Flight(InOwnFolder):
    def test_both_land_with_loss_and_delay_and_the_same_bytes_on_one_processor(self):
        code, two = self.fly("--seed", "4", *BAD_AIR)
        self.assertEqual(code, 0, two)
        for name in ("scout", "follower"):
            plant = two["plant"]["robots"][name]
            self.assertEqual(plant["verdict"]["outcome"], "landed on the pad")
            self.assertEqual(plant["stale_actuations"], 0)
            self.assertGreater(plant["radio"]["heard"], 50)
            self.assertGreater(plant["radio"]["rx_lost"], 20)
        scout, follower = (two["plant"]["robots"][name] for name in ("scout", "follower"))
        self.assertGreater(follower["touchdown_s"], scout["touchdown_s"] + 5, "one after the other")
        cpu = min(os.sched_getaffinity(0))
        _, one = self.fly("--seed", "4", *BAD_AIR, before=["taskset", "-c", str(cpu)])
        for name in ("scout", "follower"):
            topics = two["robots"][name]["summary"]["hashes"]
            self.assertGreater(len(topics), 10)
            self.assertEqual(topics, one["robots"][name]["summary"]["hashes"])
            self.assertEqual(two["plant"]["robots"][name]["verdict"], one["plant"]["robots"][name]["verdict"])


class Loss(InOwnFolder):
    def test_a_robot_that_dies_in_flight_is_not_waited_for(self):
        code, out, err = self.done(*TEAM, "--virtual", "--no-record", *SMALL, "--seed", "4", "--fault", "scout/link:closed@7")
        self.assertEqual(code, 1, out + err)
        self.assertIn("team: 1 of 2 robots did well", out)
        self.assertRegex(out, r"(?m)^scout +\| mission +did not land: the simulator closed the connection at 7\.0 s")
        self.assertRegex(out, r"(?m)^follower \| mission +landed on the pad: ")
        armed = float(re.search(r"(?m)^follower \| +([0-9.]+) s  arming", out)[1])
        # Heard until 7 s, valid for 1.5 s more, and waited for 3 s more; then it has to be still for a while.
        self.assertGreater(armed, 7 + 3)
        self.assertLess(armed, 7 + 1.5 + 3 + 1)


class Refused(InOwnFolder):
    def test_what_does_not_fit_is_said_before_anything_flies(self):
        other = self.folder / "other.toml"
        cases = (('[robot]\nname = "follower"', "two robots are named follower"),
                 ('[robot]\nname = "x"\n[team]\nrobot = 2', "follower and x both have the number 2"),
                 ('[robot]\nname = "x"\n[team]\nrobot = 3\n[sim]\ngust_mps = 1', "sim.gust_mps is left out in one and 1"))
        for text, words in cases:
            other.write_text(f'extends = "{TEAM[0]}"\n{text}\n')
            code, out, err = self.done(TEAM[1], str(other), "--virtual")
            self.assertEqual(code, 2, out + err)
            self.assertIn(words, err)
        for option, words in ((["--set", "cow/mission.hold_s=1"], "no robot cow; there are scout, follower"),
                              (["--fault", "cow/radio:off@1"], "no robot cow; there are scout, follower"),
                              (["--set", "scout/mission.nothing=1"], "nothing"),
                              (["--fault", "scout/radio:bent@1"], "kind 'bent'")):
            code, out, err = self.done(*TEAM, "--virtual", *option)
            self.assertEqual(code, 2, out + err)
            self.assertIn(words, err)
        self.assertEqual([p.name for p in self.folder.glob("sinew-plant-*")], [], "nothing is left behind")


class Drawn(InOwnFolder):
    def test_what_comes_from_mates_is_drawn_apart(self):
        graph = [subprocess.run([SINEW, "graph", TEAM[1], *how], capture_output=True, text=True, check=True).stdout
                 for how in ([], ["--dot"])]
        self.assertRegex(graph[0], r"<~ ahead +scout/mission\.mission \(at most 1\.5 s old\)")
        self.assertIn('"mates" -> "mission" [label="scout/mission.mission", style=dashed];', graph[1])
        self.assertIn('"filter" -> "mission" [label="filter.state"];', graph[1])


class RealTime(InOwnFolder):
    def test_the_same_robots_run_in_real_time(self):
        # What a shared machine can promise: both run, hear each other, and end.
        code, out, err = self.done(*TEAM, "--json", "--no-record", *SMALL, "--duration", "4")
        self.assertIn(code, (0, 1), out + err)
        told = json.loads(out)
        for name in ("scout", "follower"):
            self.assertGreater(told["plant"]["robots"][name]["radio"]["heard"], 5, out)


class RadioFaults(InOwnFolder):
    """Each kind that the radio of the scout may have; the other one lands in any case."""

    def test_every_kind(self):
        for kind in ("off", "stuck", "garbage", "wrong", "slow", "delayed", "intermittent", "duplicated"):
            with self.subTest(kind):
                code, told = self.fly("--seed", "4", "--fault", f"scout/radio:{kind}@5", "--fault", f"follower/radio:{kind}@5")
                self.assertEqual(code, 0, told["plant"])
                for name in ("scout", "follower"):
                    self.assertGreater(told["plant"]["robots"][name]["faults"][0]["affected"], 0)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
