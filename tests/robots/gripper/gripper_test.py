"""The wheeled robot with a gripper fetches a ball on the simulated field, in virtual time.

usage: gripper_test.py SINEW SOURCE [unittest arguments]
"""
import json
import os
import subprocess
import sys
import tempfile
import unittest

SINEW, SOURCE = map(os.path.abspath, sys.argv[1:3])
GRIPPER = f"{SOURCE}/robots/gripper/gripper.toml"


class Gripper(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="sinew_gripper_")
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def run_it(self, *arguments, record=False):
        env = dict(os.environ, SINEW_RECORD="on" if record else "off", SINEW_RUN_DIR=self.folder, TMPDIR=self.folder)
        done = subprocess.run([SINEW, "run", GRIPPER, "--virtual", "--json", "--runs", f"{self.folder}/runs",
                               *arguments], capture_output=True, text=True, env=env, cwd=self.folder, timeout=200)
        if not done.stdout:
            raise AssertionError(done.stderr)
        return done.returncode, json.loads(done.stdout.splitlines()[-1])

    def test_fetches_the_ball_from_wherever_it_lies(self):
        for seed in ("1", "2", "3"):
            with self.subTest(seed=seed):
                code, summary = self.run_it("--seed", seed)
                plant = summary["report"]
                self.assertEqual((code, plant["verdict"]["outcome"]), (0, "fetched the ball"), plant)
                self.assertGreater(plant["carried_m"], 1)
                self.assertLess(plant["ball_from_start_m"], 0.5)
                self.assertFalse(plant["holds_ball"])
                self.assertEqual(plant["physics_warnings"], 0)

    def test_a_ball_behind_it_is_found_and_each_step_can_be_executed_again(self):
        code, summary = self.run_it("--set", "sim.ball_toward_deg=180", record=True)
        self.assertEqual((code, summary["report"]["verdict"]["outcome"]), (0, "fetched the ball"), summary)
        done = subprocess.run([SINEW, "replay", f"{self.folder}/runs/latest/run.mcap"], capture_output=True, text=True,
                              timeout=200)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertRegex(done.stdout, "^identical")

    def test_the_same_seed_gives_the_same_bytes_and_another_one_others(self):
        hashes = [self.run_it("--duration", "8", "--seed", seed)[1]["hashes"] for seed in ("5", "5", "6")]
        self.assertEqual(hashes[0], hashes[1])
        self.assertNotEqual(hashes[0], hashes[2])

    def test_a_gripper_that_does_not_close_carries_nothing_and_the_verdict_says_so(self):
        code, summary = self.run_it("--fault", "gripper:wrong(1)@0", "--duration", "40")
        self.assertEqual((code, summary["report"]["verdict"]["outcome"]), (1, "never held the ball"), summary)

    def test_without_the_bus_of_its_gripper_all_motors_stop(self):
        code, summary = self.run_it("--fault", "gripper:off@12", "--duration", "20")
        plant = summary["report"]
        self.assertEqual(code, 1)
        self.assertEqual((plant["at_rest"], plant["motors_stopped"]), (True, True), plant)

    def test_without_its_camera_it_stands_and_gives_up(self):
        code, summary = self.run_it("--fault", "camera:off@1", "--duration", "20")
        plant = summary["report"]
        self.assertEqual(code, 1)
        self.assertEqual(plant["grips"], 0)
        self.assertTrue(plant["at_rest"], plant)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
