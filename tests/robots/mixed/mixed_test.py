"""A humanoid finds an object that robots with wheels cannot see; one of those brings it to the goal.

usage: mixed_test.py SINEW [unittest arguments]
"""
import os
import subprocess
import sys
import tempfile
import unittest

from study import FILES, play

SINEW = os.path.abspath(sys.argv[1])
os.environ.pop("SINEW_RECORD", None)  # one test executes its records again


class Mixed(unittest.TestCase):
    def test_what_only_the_humanoid_sees_is_brought_to_the_goal_with_a_third_of_all_frames_lost(self):
        got = play(SINEW, 1)
        self.assertEqual((got["good"], got["outcome"]), (True, "the object is at the goal"), got)
        self.assertEqual(got["codes"], {"finder": 0, "fetcher": 0, "reserve": 0}, "all of them know that it is done")
        # A run that is done gives the servos no torque.
        self.assertTrue(got["fell_s"] is None or got["fell_s"] > got["brought_s"], got)


class Failures(unittest.TestCase):
    def test_a_fetcher_that_dies_is_replaced(self):
        got = play(SINEW, 2, kind="dies")
        self.assertEqual((got["good"], got["by"]), (True, "reserve"), got)
        self.assertNotEqual(got["codes"]["fetcher"], 0)
        self.assertEqual((got["codes"]["finder"], got["codes"]["reserve"]), (0, 0))

    def test_a_fetcher_that_falls_silent_stands_and_is_replaced(self):
        got = play(SINEW, 2, kind="silent")
        self.assertEqual((got["good"], got["by"]), (True, "reserve"), got)

    def test_without_the_humanoids_word_nobody_finds_the_object(self):
        got = play(SINEW, 1, kind="nobody_finds", seconds=60)
        self.assertEqual((got["good"], got["outcome"]), (False, "nobody has held the object"), got)

    def test_what_each_of_them_has_done_can_be_executed_again(self):
        with tempfile.TemporaryDirectory(prefix="sinew_mixed_") as folder:
            play(SINEW, 1, seconds=20, record=folder)
            runs = sorted(p for p in os.listdir(folder) if p.startswith(("finder-", "fetcher-", "reserve-")))
            self.assertEqual(len(runs), len(FILES), runs)
            for run in runs:
                done = subprocess.run([SINEW, "replay", f"{folder}/{run}/run.mcap"], capture_output=True, text=True,
                                      timeout=300, check=False)
                self.assertEqual(done.returncode, 0, run + done.stdout + done.stderr)
                self.assertRegex(done.stdout, "^identical")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]], verbosity=2)
