"""Runs the desk head through the `sinew` program: it follows its ball, the same seed gives the same bytes, and a device
that breaks is noticed and said."""
import json
import os
import re
import subprocess
import sys
import tempfile
import unittest

os.environ.setdefault("SINEW_RECORD", "off")  # a run is 100 MB; recordings have tests of their own

SINEW, TRAPPED, SINEW_SIM, ROBOT = sys.argv[1:5]
LIMIT_S = 300
RUN_DIR = tempfile.TemporaryDirectory()  # robots of other tests cannot meet this program's
os.environ["SINEW_RUN_DIR"] = RUN_DIR.name


def run(*arguments, program=SINEW):
    """With a small picture, in which the ball is seen as well."""
    done = subprocess.run([program, "run", ROBOT, "--camera", "96x72", *arguments], capture_output=True, text=True,
                          timeout=LIMIT_S)
    return done.returncode, done.stdout, done.stderr


def hashes(text):
    return re.findall(r"^hash (\S+)\s+([0-9a-f]{16})$", text, re.M)


class Following(unittest.TestCase):
    def test_follows_its_ball_for_thirty_seconds_whatever_the_seed(self):
        for seed in range(11, 16):
            code, out, err = run("--virtual", "--duration", "30", "--seed", str(seed), "--json")
            self.assertEqual(code, 0, f"seed {seed}: {out}{err}")
            summary = json.loads(out)
            self.assertEqual(summary["result"], "followed the ball, valid run")
            self.assertGreaterEqual(summary["in_view_share"], 0.95)
            self.assertLess(summary["angle_rms_deg"], 3)
            self.assertLess(summary["level_rms_deg"], 3)
            self.assertGreater(summary["base_tilt_rms_deg"], 3, "there was something to level")
            self.assertEqual([c["missed"] for c in summary["chains"]], [0, 0])

    def test_the_same_seed_gives_the_same_bytes_on_every_topic(self):
        first = run("--virtual", "--duration", "4", "--seed", "3", "--verbose")[1]
        # The second run uses the program with the trap: a call that a step must not make would end it.
        second = run("--virtual", "--duration", "4", "--seed", "3", "--verbose", program=TRAPPED)[1]
        self.assertGreaterEqual(len(hashes(first)), 9)
        self.assertEqual(hashes(first), hashes(second))
        other = run("--virtual", "--duration", "4", "--seed", "4", "--verbose")[1]
        self.assertNotEqual(dict(hashes(first))["joints.raw"], dict(hashes(other))["joints.raw"])

    def test_runs_in_real_time(self):
        # Where the host takes its processors away the run may be invalid; that it runs, stops and reports is what a
        # shared machine can promise.
        code, out, err = run("--duration", "3", "--plain", "--verbose")
        self.assertIn(code, (0, 1), out + err)
        self.assertRegex(out, r"steer +\d\d+ cycles")
        self.assertRegex(out, r"result +(followed the ball|never found the ball|did not keep the ball in view)")

    def test_a_head_that_cannot_turn_to_the_ball_fails(self):
        code, out, _ = run("--virtual", "--duration", "10", "--quiet", "--plant-arg=--ball-speed", "--plant-arg=0",
                           "--set", "follower.pan_most_rad=-1.2", "--set", "follower.pan_least_rad=-1.3")
        self.assertEqual(code, 1)
        self.assertIn("never found the ball", out)


class Broken(unittest.TestCase):
    def strike(self, *faults, duration="5"):
        options = [word for fault in faults for word in ("--fault", fault)]
        code, out, err = run("--virtual", "--duration", duration, "--seed", "3", "--verbose", *options)
        self.assertIn(code, (0, 1), out + err)
        self.assertRegex(out, r"fault +\S+: struck \d+ times")
        return code, out

    def test_joints_that_fall_silent_stop_the_head(self):
        code, out = self.strike("joints:off@2")
        self.assertEqual(code, 1)
        self.assertIn("joints_lost acted", out)
        self.assertNotIn("mission   followed the ball:", out)

    def test_joints_that_repeat_themselves_stop_the_head(self):
        self.assertIn("joints_stuck acted", self.strike("joints:stuck@2")[1])

    def test_joints_that_talk_nonsense_stop_the_head(self):
        self.assertIn("nonsense acted", self.strike("joints:garbage@2")[1])

    def test_without_pictures_it_looks_straight_ahead(self):
        code, out = self.strike("camera:off@2")
        self.assertEqual(code, 1)
        self.assertIn("camera_lost acted", out)

    def test_single_lost_samples_do_no_harm(self):
        # One after another in one run, two seconds each.
        kinds = ("joints:slow", "joints:duplicated", "joints:delayed(3ms)", "head:delayed", "head:slow",
                 "imu:intermittent(3ms)", "camera:slow(2)")
        faults = [f"{kind}@{2 + 2 * i}+2" for i, kind in enumerate(kinds)]
        code, out = self.strike(*faults, duration="17")
        self.assertEqual(code, 0, out)
        self.assertEqual(len(re.findall(r"(?m)^fault +\S+: struck [1-9]\d* times", out)), len(kinds), out)

    def test_commands_that_are_not_heard_run_out_with_their_lease(self):
        out = run("--virtual", "--duration", "5", "--seed", "3", "--json", "--fault", "head:off@2")[1]
        report = json.loads(out)["report"]
        self.assertEqual(report["world"], "desk_head")
        self.assertEqual(report["stale_actuations"], 0)
        self.assertTrue(report["motors_stopped"])

    def test_every_pair_of_device_and_kind_is_played_or_refused_with_its_reason(self):
        listed = subprocess.run([SINEW_SIM, "--world", "desk_head", "--list-faults"], capture_output=True, text=True,
                                check=True).stdout.splitlines()
        self.assertEqual({line.split()[0] for line in listed}, {"imu", "camera", "joints", "head", "link"})
        self.assertEqual(len(listed), 5 * 9)
        pairs = [line.partition(" - ")[0].split() for line in listed if " - " not in line]
        for device in ("joints", "head"):  # its kinds one after another in one run, where starting takes longest
            faults = [f"{device}:{kind}@{1 + 0.1 * i:.1f}+0.1" for i, kind in enumerate(k for d, k in pairs if d == device)]
            self.assertGreater(len(faults), 4)
            _, out = self.strike(*faults, duration="2")
            self.assertEqual(len(re.findall(r"(?m)^fault +\S+: struck [1-9]\d* times", out)), len(faults), out)

    def test_a_device_that_this_world_lacks_is_named(self):
        code, _, err = run("--virtual", "--fault", "range:off@1")
        self.assertEqual(code, 2)
        self.assertIn("the world desk_head has no device 'range'", err)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[5:]], verbosity=2)
