"""The desk head's joints are identified from a run in virtual time: the real programs in a folder of their own.

usage: identify_test.py SINEW ROBOTS [unittest arguments]
"""
import glob
import json
import os
import subprocess
import sys
import tempfile
import unittest

LIMIT_S = 300
RUN_DIR = tempfile.TemporaryDirectory(prefix="sinew_run_")  # robots of other tests cannot meet this program's
os.environ["SINEW_RUN_DIR"] = RUN_DIR.name
os.environ.pop("SINEW_RECORD", None)


def sinew(folder, *arguments):
    done = subprocess.run([SINEW, *arguments], capture_output=True, text=True, timeout=LIMIT_S, cwd=folder)
    return done.returncode, done.stdout, done.stderr


class Identify(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="sinew_identify_")
        cls.addClassCleanup(cls.folder.cleanup)
        robot = os.path.join(ROBOTS, "desk_head", "desk_head_identify.toml")
        code, out, err = sinew(cls.folder.name, "run", robot, "--virtual", "--duration", "36", "--json", "--plain",
                               "--set", "excite.rounds=5")
        if code not in (0, 1):  # it looks for no ball
            raise RuntimeError(out + err)
        cls.summary = json.loads(out)
        cls.record = sorted(glob.glob(os.path.join(cls.folder.name, "runs", "*", "*.mcap")))[0]

    def test_finds_the_drive_and_the_friction_of_the_simulated_pan(self):
        code, out, err = sinew(self.folder.name, "identify", self.record, "--joint", "pan", "--json")
        self.assertEqual(code, 0, out + err)
        pan = json.loads(out)["joints"]["pan"]
        value = {name: p["value"] for name, p in pan["parameters"].items()}
        # sim_hil/worlds/joint_servo.hpp: 0.3 N m s/rad on 25/s, within 5.5 rad/s: as a motor 1.65 N m and 5.5 rad/s.
        # Its drive is a cascade with a torque limit of 1.5 N m, which the model has not.
        self.assertAlmostEqual(value["stall"], 1.65, delta=0.12)
        self.assertLess(value["play"], 1e-4)  # rad; it has none
        self.assertAlmostEqual(value["no_load"], 5.5, delta=0.3)
        self.assertAlmostEqual(value["coulomb"], 0.03, delta=0.008)
        self.assertLess(value["delay"], 0.005)
        self.assertLess(pan["held_out_rms"]["position_rad"], 0.004)
        self.assertGreater(pan["moved_rms"]["position_rad"], 0.1)

    def test_says_in_words_what_it_found_and_what_the_record_does_not_show(self):
        code, out, err = sinew(self.folder.name, "identify", self.record, "--parts", "3")
        self.assertEqual(code, 0, out + err)
        self.assertIn("alone in motion", out)
        self.assertRegex(out, r"coulomb +\S+ \+- \S+ +N m")
        self.assertRegex(out, "tilt: nowhere moves alone for 5 s")  # the run ended before

    def test_names_a_joint_a_group_and_a_body_that_are_not_there(self):
        code, _, err = sinew(self.folder.name, "identify", self.record, "--joint", "nose")
        self.assertEqual(code, 2)
        self.assertIn("there is no joint 'nose'; it has: pan, tilt", err)
        code, _, err = sinew(self.folder.name, "identify", self.record, "--group", "legs")
        self.assertEqual(code, 2)
        self.assertIn("--group legs: there is none; it has: head", err)
        code, _, err = sinew(self.folder.name, "identify", self.record, "--body", "nobody.toml")
        self.assertEqual(code, 2)
        self.assertIn("nobody.toml", err)


if __name__ == "__main__":
    SINEW, ROBOTS = sys.argv[1:3]
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
