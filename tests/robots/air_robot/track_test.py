"""An AirRobot that keeps a target in view and flies over it, over the own protocol in virtual time: a whole flight, judged by
its world, and executed again.

argv: SINEW SOURCE
"""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

SINEW, SOURCE = sys.argv[1:3]
os.environ.pop("SINEW_RECORD", None)  # this one needs its recording


class Track(unittest.TestCase):
    def run_sinew(self, *arguments):
        return subprocess.run([SINEW, *arguments], capture_output=True, text=True, check=False, timeout=100)

    def test_it_keeps_the_target_in_view_reaches_it_and_is_executed_again(self):
        with tempfile.TemporaryDirectory() as folder:
            done = self.run_sinew("run", f"{SOURCE}/robots/air_robot/track.toml", "--virtual", "--seed", "3", "--duration", "40",
                                  "--json", "--runs", folder)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            self.assertIn("kept the target in view and reached it", json.dumps(json.loads(done.stdout)))
            run = next(pathlib.Path(folder).glob("*/run.mcap"))
            again = self.run_sinew("replay", str(run))
            self.assertEqual(again.returncode, 0, again.stdout + again.stderr)
            self.assertRegex(again.stdout, r"identical: \d{4,} steps")

    def test_a_robot_that_does_not_follow_the_target_is_not_good(self):
        done = self.run_sinew("run", f"{SOURCE}/robots/air_robot/track.toml", "--virtual", "--seed", "3", "--duration", "25",
                              "--json", "--no-record", "--set", "ball.hue_from_deg=200", "--set",
                              "ball.hue_to_deg=220")
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        self.assertRegex(done.stdout, "never saw the target|lost the target|did not reach")
        self.assertIn("while searching the target", json.loads(done.stdout)["mission"]["why"], "in its own words")

    def test_without_pictures_it_lands(self):
        done = self.run_sinew("run", f"{SOURCE}/robots/air_robot/track.toml", "--virtual", "--seed", "3", "--duration", "30",
                              "--json", "--no-record", "--fault", "camera:off@6")
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        self.assertIn("camera_lost", done.stdout + done.stderr)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)
