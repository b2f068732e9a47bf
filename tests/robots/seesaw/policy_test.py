"""A policy that was trained elsewhere keeps the seesaw level: flown in virtual time, recorded, executed again, and refused where
it does not fit.

argv: SINEW SOURCE
"""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

SINEW, SOURCE = sys.argv[1:3]
SEESAW = pathlib.Path(SOURCE) / "robots/seesaw"
RUN_DIR = tempfile.TemporaryDirectory()  # this program's robots meet nobody else's
os.environ["SINEW_RUN_DIR"] = RUN_DIR.name


def run(*command):
    environment = {k: v for k, v in os.environ.items() if k != "SINEW_RECORD"}
    done = subprocess.run(command, capture_output=True, text=True, timeout=50, check=False, env=environment)
    return done.returncode, done.stdout, done.stderr


class Policy(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.here = pathlib.Path(holder.name)
        for name in ("seesaw.toml", "seesaw_policy.toml", "balance.onnx"):
            shutil.copy(SEESAW / name, self.here)
        self.robot = self.here / "seesaw_policy.toml"

    def change(self, old, new):
        text = self.robot.read_text(encoding="utf-8")
        self.assertIn(old, text)
        self.robot.write_text(text.replace(old, new), encoding="utf-8")

    def fly(self, *more):
        code, out, err = run(SINEW, "run", str(self.robot), "--virtual", "--duration", "8", "--json", *more)
        self.assertIn(code, (0, 1), err)
        return code, json.loads(out)

    def check(self):
        code, out, err = run(SINEW, "check", str(self.robot))
        return code, out + err

    def test_it_keeps_the_level_from_ten_seeds(self):
        for seed in range(1, 11):
            code, said = self.fly("--seed", str(seed), "--no-record")
            self.assertEqual((code, said["result"]), (0, "kept the level, valid run"), (seed, said))

    def test_a_step_of_delay_on_purpose_is_flown_too(self):
        self.change("exec_us = 20", "exec_us = 20\ndelay = 1")
        code, said = self.fly("--no-record")
        self.assertEqual((code, said["result"]), (0, "kept the level, valid run"), said)

    def test_limits_and_guardian_stand_behind_it(self):
        self.change("clip = [-1, 1]", "scale = 50")
        _, said = self.fly("--no-record")
        self.assertEqual(said["result"].split(",")[0], "never got level", said)

    def test_a_record_has_its_network_and_is_executed_again(self):
        code, _ = self.fly("--runs", str(self.here / "runs"), "--set", "balance.publish_vectors=true")
        self.assertEqual(code, 0)
        record = next((self.here / "runs").glob("seesaw_policy-*/run.mcap"))
        code, out, err = run(SINEW, "replay", str(record))
        self.assertEqual(code, 0, out + err)
        self.assertIn("identical", out)
        code, out, err = run(SINEW, "bag", "info", str(record), "--json")
        self.assertIn("sinew.policies", out)
        # The network that acted is in the record: another file beside the robot file changes nothing.
        (self.here / "balance.onnx").write_bytes(b"nothing")
        code, out, err = run(SINEW, "replay", str(record))
        self.assertEqual(code, 0, out + err)
        self.assertIn("identical", out)
        # What it remembers (the history) is saved with the record: it can be executed from its middle.
        part = self.here / "part.mcap"
        code, out, err = run(SINEW, "bag", "cut", str(record), str(part), "--from", "3")
        self.assertEqual(code, 0, out + err)
        code, out, err = run(SINEW, "replay", str(part))
        self.assertEqual(code, 0, out + err)
        self.assertIn("identical", out)

    def test_a_record_whose_network_is_another_is_refused(self):
        code, _ = self.fly("--runs", str(self.here / "runs"))
        self.assertEqual(code, 0)
        record = next((self.here / "runs").glob("seesaw_policy-*/run.mcap"))
        written = record.read_bytes()
        (hash_of_it,) = set(re.findall(rb"([0-9a-f]{16}) [^\0-\x1f]*balance\.onnx", written))
        other = self.here / "other.mcap"
        other.write_bytes(written.replace(hash_of_it, b"0123456789abcdef"))
        code, out, err = run(SINEW, "replay", str(other))
        self.assertEqual(code, 2, out + err)
        self.assertIn(f"balance.onnx is not the network that acted: its hash is {hash_of_it.decode()}", err)

    def test_ages_of_the_observation_are_in_the_record(self):
        code, _ = self.fly("--runs", str(self.here / "runs"))
        self.assertEqual(code, 0)
        record = next((self.here / "runs").glob("seesaw_policy-*/run.mcap"))
        code, out, err = run(SINEW, "topic", "echo", "balance.state", "--file", str(record))
        self.assertEqual(code, 0, err)
        # Five samples of the IMU come in the 5 ms of a step; the one that goes in is as old as the sensor's latency.
        self.assertIn('"arrived":5,"repeated":0,', out)
        self.assertIn('"reordered":0', out)

    def test_check_says_what_it_is(self):
        code, said = self.check()
        self.assertEqual(code, 0, said)
        self.assertIn("balance: observes 8 numbers from 1 topic, commands 1 field; balance.onnx (", said)

    def test_check_names_what_does_not_fit_with_its_line(self):
        self.change('"accel_mps2.x", "gyro_radps.y"', '"accel_mps2.x", "gyro_radps.w"')
        code, said = self.check()
        self.assertNotEqual(code, 0)
        self.assertRegex(said, r'seesaw_policy\.toml:\d+: module\.balance\.observe\.0\.fields: "gyro_radps\.w": a number of ImuSample: ')
        self.change("gyro_radps.w", "gyro_radps.y")
        self.change("history = 4", "history = 3")
        _, said = self.check()
        self.assertRegex(said, r"seesaw_policy\.toml:\d+: module\.balance\.observe: 6 numbers: as many as input 'obs' \[1, 8\] takes: 8")
        self.change("history = 3", "history = 4")
        self.change('topic = "imu.raw"', 'topic = "imu.row"')
        _, said = self.check()
        self.assertRegex(said, r'seesaw_policy\.toml:\d+: module\.balance\.in\.in_imu_row: "imu\.row": a topic')

    def test_a_damaged_network_is_refused_where_it_is_named(self):
        network = self.here / "balance.onnx"
        whole = network.read_bytes()
        network.write_bytes(whole[:300])
        code, said = self.check()
        self.assertNotEqual(code, 0)
        self.assertRegex(said, r'seesaw_policy\.toml:\d+: module\.balance\.file: "balance\.onnx": no ONNX file, or a damaged one')
        network.write_bytes(whole.replace(b"\x22\x04Tanh", b"\x22\x04Einn"))
        _, said = self.check()
        self.assertIn("node '/hidden/Tanh' (Einn): operator Einn is not supported; supported are Abs Add", said)
        network.unlink()
        _, said = self.check()
        self.assertRegex(said, r'seesaw_policy\.toml:\d+: module\.balance\.file: "balance\.onnx": an ONNX file: .*no such file')


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)
