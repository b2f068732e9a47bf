#!/usr/bin/env python3
"""The desk head on its real drivers: CAN servos over CANopen in UDP, the IMU by IIO files, the camera by V4L2 requests,
against the simulated world; once with the pictures by the simulator's protocol, once without any of it.

usage: wire_head_test.py SINEW SINEW_SIM ROBOT.toml

In real time on a machine that may be busy, so every run must only do what does not depend on time: the drives
come up, the joints follow, the pictures are looked at. One of three runs must follow the ball.
"""
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from can_robot import children

SINEW, SINEW_SIM, ROBOT = sys.argv[1:4]


def run_once(folder, bus, alone, plant_options=(), seconds=9):
    """One run. `alone`: the world has no connection to the runtime but its devices."""
    wire, listen = folder / "wire", f"unix:{folder}/head.sock"
    report = folder / "report.json"
    env = dict(os.environ, SINEW_RUN_DIR=str(folder), SINEW_RECORD="off")
    by_protocol = ["--board-of", "camera=sim", "--plant", listen]
    plant = subprocess.Popen([SINEW_SIM, "--world", "desk_head", "--can", f"udp:{bus}", "--servo", "cia402:1", "--servo",
                              "cia402:2", "--iio", str(wire), "--report", str(report),
                              *(["--alone", "--v4l2", str(wire)] if alone else ["--listen", listen]), *plant_options],
                             stdout=subprocess.PIPE, text=True, env=env)
    try:
        plant.stdout.readline()  # it is there; the rest is little enough to stay in the pipe
        run = subprocess.run(
            [SINEW, "run", ROBOT, "--board", "linux", *([] if alone else by_protocol),
             "--real-actuators", "--duration", str(seconds), "--json", "--no-record",
             "--set", "bus.can0.driver=udp", "--set", f"bus.can0.address={bus}", "--set", f"device.imu.root={wire}",
             "--set", f"device.camera.root={wire}"],
            capture_output=True, text=True, env=env, timeout=90)
        if alone:
            plant.terminate()
        plant.wait(20)
    finally:
        plant.kill()
        plant.communicate()
    return run, json.loads(report.read_text())


class DeskHeadAtTheWire(unittest.TestCase):
    def follows(self, alone, *plant_options):
        told = []
        for attempt in range(3):
            with tempfile.TemporaryDirectory(prefix="sinew-") as name:
                run, report = run_once(pathlib.Path(name), 100 + attempt + os.getpid() % 100, alone, plant_options)
            self.assertNotEqual(run.returncode, 2, run.stderr)
            summary = json.loads(run.stdout)
            told.append(f"{summary['result']}: in view {report['in_view_share']}; {run.stderr}")
            if report["acquired"] and report["in_view_share"] > 0.8 and "failsafe" not in summary["result"]:
                return summary
        self.fail("\n".join(told))

    def test_follows_its_ball_with_pictures_by_the_simulators_protocol(self):
        self.follows(alone=False)

    def test_follows_its_ball_with_nothing_but_real_drivers_also_after_the_camera_was_unplugged(self):
        # Shorter than camera_lost (0.5 s) would take for an end; the driver opens it again 0.1 s after it is back.
        summary = self.follows(True, "--unplug-camera", "5+0.15")
        camera = next(m for m in summary["modules"] if m["name"] == "camera")
        self.assertGreater(camera["ok"], 60, "pictures came by V4L2")

    def test_a_camera_that_stays_unplugged_is_noticed(self):
        with tempfile.TemporaryDirectory(prefix="sinew-") as name:
            run, _ = run_once(pathlib.Path(name), 100 + os.getpid() % 100, True, ["--unplug-camera", "5+60"], seconds=8)
        self.assertEqual(run.returncode, 1, run.stderr)
        self.assertIn("camera_lost", run.stdout)

    def test_killed_runtime_is_followed_by_a_stop_of_plant_and_drives(self):
        for driver in ("udp", "socketcand"):
            with self.subTest(driver), tempfile.TemporaryDirectory(prefix="sinew-") as name:
                said = self.kill_one(pathlib.Path(name), driver)
                self.assertIn("the runtime died: signal 9", said)
                self.assertRegex(said, r"stop of the actuators \(plant\): sent")
                self.assertRegex(said, r"stop of the actuators \(CAN\): sent [0-9.]+ ms later; "
                                       r"2 of 2 joints are without torque")

    def kill_one(self, folder, driver):
        number = 100 + os.getpid() % 100 if driver == "udp" else 20000 + os.getpid() % 10000
        far = f"udp:{number}" if driver == "udp" else f"socketcand-server:{number}"
        near = str(number) if driver == "udp" else f"127.0.0.1:{number}/can0"
        iio, listen = folder / "iio", f"unix:{folder}/head.sock"
        env = dict(os.environ, SINEW_RUN_DIR=str(folder), SINEW_RECORD="off")
        plant = subprocess.Popen([SINEW_SIM, "--world", "desk_head", "--listen", listen, "--can", far,
                                  "--servo", "cia402:1", "--servo", "cia402:2", "--iio", str(iio)],
                                 stdout=subprocess.PIPE, text=True, env=env)
        run = None
        try:
            self.assertIn("listening", plant.stdout.readline())
            run = subprocess.Popen(
                [SINEW, "run", ROBOT, "--board", "linux", "--board-of", "camera=sim", "--plant", listen,
                 "--real-actuators", "--plain", "--no-record", "--set", f"bus.can0.driver={driver}",
                 "--set", f"bus.can0.address={near}", "--set", f"device.imu.root={iio}"],
                cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=env)
            said = run.stdout.readline()  # it says something every two seconds once it runs
            runtime = children(run.pid)
            self.assertEqual(len(runtime), 1, said)
            os.kill(runtime[0], signal.SIGKILL)
            _, err = run.communicate(timeout=60)
            self.assertEqual(run.returncode, 1, err)
            return err
        finally:
            for process in (plant, run):
                if process and process.poll() is None:
                    process.kill()
                if process:
                    process.communicate()

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
    unittest.main(argv=sys.argv[:1] + sys.argv[4:], verbosity=2)
