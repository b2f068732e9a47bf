#!/usr/bin/env python3
"""The desk head on its real drivers: CAN servos over CANopen in UDP, the IMU by IIO files, against the simulated world.

usage: wire_head_test.py SINEW SINEW_SIM ROBOT.toml

In real time on a machine that may be busy, so that only what does not depend on time is asked of one run: the drives
come up, the joints follow, the pictures are looked at. That the ball is followed is asked of one of three runs.
"""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

SINEW, SINEW_SIM, ROBOT = sys.argv[1:4]


def run_once(folder, bus):
    iio, listen = folder / "iio", f"unix:{folder}/head.sock"
    report = folder / "report.json"
    env = dict(os.environ, SINEW_RUN_DIR=str(folder), SINEW_RECORD="off")
    plant = subprocess.Popen([SINEW_SIM, "--world", "desk_head", "--listen", listen, "--can", f"udp:{bus}",
                              "--servo", "cia402:1", "--servo", "cia402:2", "--iio", str(iio), "--report", str(report)],
                             stdout=subprocess.PIPE, text=True, env=env)
    try:
        plant.stdout.readline()  # it listens; the rest is little enough to stay in the pipe
        run = subprocess.run(
            [SINEW, "run", ROBOT, "--board", "linux", "--board-of", "camera=sim", "--plant", listen,
             "--real-actuators", "--duration", "12", "--json", "--no-record",
             "--set", "bus.can0.driver=udp", "--set", f"bus.can0.address={bus}", "--set", f"device.imu.root={iio}"],
            capture_output=True, text=True, env=env, timeout=90)
        plant.wait(20)
    finally:
        plant.kill()
        plant.communicate()
    return run, json.loads(report.read_text())


class DeskHeadAtTheWire(unittest.TestCase):
    def test_follows_its_ball_through_the_real_drivers(self):
        told = []
        for attempt in range(3):
            with tempfile.TemporaryDirectory(prefix="sinew-") as name:
                run, report = run_once(pathlib.Path(name), 100 + attempt + os.getpid() % 100)
            self.assertNotEqual(run.returncode, 2, run.stderr)
            summary = json.loads(run.stdout)
            told.append(f"{summary['result']}: in view {report['in_view_share']}; {run.stderr}")
            if report["acquired"] and report["in_view_share"] > 0.8 and "failsafe" not in summary["result"]:
                return
        self.fail("\n".join(told))

    def test_without_its_bus_it_says_why_and_does_not_start(self):
        with tempfile.TemporaryDirectory() as name:
            env = dict(os.environ, SINEW_RUN_DIR=name, SINEW_RECORD="off")
            run = subprocess.run([SINEW, "run", ROBOT, "--board", "linux", "--duration", "1", "--no-record",
                                  "--set", f"device.imu.root={name}"], capture_output=True, text=True, env=env, timeout=60)
        self.assertEqual(run.returncode, 2)
        self.assertIn("device 'imu' (driver iio): ", run.stderr)
        self.assertIn("device 'head' (driver can_servos): bus 'can0': ", run.stderr)
        self.assertIn("device 'camera' (driver v4l2): /dev/video0: ", run.stderr)
        self.assertNotIn("not ready", run.stderr, "each cause once, in the device's own words")
        for device in "imu", "head", "joints", "camera":
            self.assertEqual(run.stderr.count(f"sinew: device '{device}' "), 1, run.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
