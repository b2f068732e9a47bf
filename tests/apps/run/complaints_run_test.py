#!/usr/bin/env python3
"""Complaints of devices reach the user: during the run, in `sinew status`, and in the report at its end.

usage: complaints_run_test.py SINEW

A bus over UDP without any other node: both joints are absent.
"""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time
import unittest

SINEW = sys.argv[1]
ROBOT = """
robot = { name = "lonely", board = "linux" }
[[thread]]
name = "steer"
priority = 0
period_us = 10000
order = ["joints"]
[module.joints]
type = "drivers::JointSource"
params = { device = "head" }
[bus.can0]
driver = "udp"
address = "BUS"
tick_hz = 100
PRIORITY
[device.head]
driver = "can_servos"
[[device.head.joint]]
name = "pan"
driver = "cia402"
bus = "can0"
id = 1
counts_per_turn = 65536
max_effort_nm = 1.5
rated_effort_nm = 1.5
[[device.head.joint]]
name = "tilt"
driver = "mit"
bus = "can0"
id = 2
motor = "ak80_9"
kp = 40.0
kd = 2.0
"""
PAN, TILT = "head.pan (cia402 1 on can0): absent", "head.tilt (mit 2 on can0): absent"


class Complaints(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="sinew-")
        self.addCleanup(folder.cleanup)
        self.env = dict(os.environ, SINEW_RUN_DIR=folder.name, SINEW_RECORD="off")
        self.robot = pathlib.Path(folder.name, "lonely.toml")

    def begin(self, *options, priority=""):
        self.robot.write_text(ROBOT.replace("BUS", str(100 + os.getpid() % 100)).replace("PRIORITY", priority))
        return subprocess.Popen([SINEW, "run", self.robot, *options], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                text=True, env=self.env)

    def status(self, *options):
        return subprocess.run([SINEW, "status", "--robot", "lonely", "--wait", "20", *options], capture_output=True,
                              text=True, env=self.env, timeout=60)

    def test_absent_joints_are_in_the_view_the_status_and_the_summary(self):
        run = self.begin("--plain")
        try:
            deadline, complaints = time.monotonic() + 30, []
            while len(complaints) < 2 and time.monotonic() < deadline:
                complaints = json.loads(self.status("--json").stdout)["devices"]["complaints"]
            self.assertEqual(complaints, [PAN, TILT])
            self.assertIn(f"devices   complain:\n          {PAN}\n          {TILT}\n", self.status().stdout)
            time.sleep(1)  # the view looks five times a second
        finally:
            run.terminate()
            out, err = run.communicate(timeout=60)
        self.assertRegex(out, r"s  device  " + PAN.replace("(", r"\(").replace(")", r"\)"))
        end = out[out.index("threads\n"):]
        for joint in PAN, TILT:
            self.assertIn(f"device              {joint} (", end, out + err)

    def test_the_object_at_the_end_has_them_too(self):
        run = self.begin("--json", "--duration", "4")
        out, err = run.communicate(timeout=60)
        devices = json.loads(out)["devices"]
        self.assertEqual([d[:d.index(" (", d.index("absent"))] for d in devices], [PAN, TILT], err)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
