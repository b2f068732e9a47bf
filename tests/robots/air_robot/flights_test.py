"""Robots that speak text, flown by their robot files against simulated ones at the wire (real sockets, real time).

argv: SINEW SOURCE
"""
import contextlib
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import simulated

SINEW, SOURCE = sys.argv[1:3]
FOLDER = f"{SOURCE}/robots/air_robot"
RUN_DIR = tempfile.TemporaryDirectory()  # this program's robots meet nobody else's
os.environ["SINEW_RUN_DIR"] = RUN_DIR.name


def start(robot, *more, seconds=40):
    return subprocess.Popen([SINEW, "run", f"{FOLDER}/{robot}.toml", "--no-record", "--json", "--duration", str(seconds),
                             *more], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def finish(process, timeout=60):
    try:
        out, err = process.communicate(timeout=timeout)
    except subprocess.TimeoutExpired:
        process.kill()
        out, err = process.communicate()
        raise AssertionError("it did not end: " + err) from None
    return process.returncode, out, err


def until(true, seconds, what):
    end = time.monotonic() + seconds
    while not true():
        if time.monotonic() > end:
            raise AssertionError("never: " + what)
        time.sleep(0.05)


class Flights(unittest.TestCase):
    def ended(self, process, robot):
        code, out, err = finish(process)
        self.assertEqual(robot.errors, [], err)
        self.assertIn(code, (0, 1), err + out)
        return json.loads(out), err

    def flight(self, robot, name, *settings):
        """A whole one; the body's highest point, its way and its end."""
        with contextlib.closing(robot):
            process = start(name, *settings)
            said, err = self.ended(process, robot)
            time.sleep(0.3)
            return robot.body, said, err

    def test_the_air_robot_takes_off_flies_forward_and_lands(self):
        robot = simulated.UsarSim()
        body, said, err = self.flight(robot, "airrobot", "--set", f"device.drone.to=tcp:127.0.0.1:{robot.port}")
        self.assertGreater(body.highest, 1.0, err)
        self.assertLess(body.highest, 1.5)
        self.assertGreater(body.x, 0.8, "3 s of 0.5 m/s")
        self.assertLess(body.x, 2.2)
        self.assertLess(body.z, 0.16, "on the ground")
        drives = [c for c in robot.commands if c.startswith("DRIVE")]
        self.assertTrue(robot.commands[0].startswith("INIT {ClassName USARBot.AirRobot}"), robot.commands[0])
        self.assertRegex(drives[-1], r"^DRIVE \{AltitudeVelocity -?\d\.\d\d\} \{LinearVelocity -?\d\.\d\d\} "
                                     r"\{LateralVelocity -?\d\.\d\d\} \{RotationalVelocity -?\d\.\d\d\}$")
        self.assertEqual(robot.body.wanted[0], 0, "the last command ends what was under way")

    def test_the_p3at_drives_forward_and_stops(self):
        robot = simulated.UsarSim(wheels=True)
        body, said, err = self.flight(robot, "p3at", "--set", f"device.vehicle.to=tcp:127.0.0.1:{robot.port}")
        self.assertGreater(body.x, 0.7, err)
        self.assertLess(abs(body.y), 0.05)
        self.assertEqual(robot.body.wanted[0], 0)
        self.assertTrue(any("{Light 0} {Flip 0}" in c for c in robot.commands), robot.commands[-1])

    def test_tello_takes_off_although_its_first_takeoff_was_lost(self):
        state_port, port = simulated.free_udp_port(), simulated.free_udp_port()
        robot = simulated.Tello(state_port)
        body, said, err = self.flight(
            robot, "tello", "--set", f"device.drone.to=udp:127.0.0.1:{robot.port}", "--set", f"device.drone.port={port}",
            "--set", f"device.drone.state=udp:127.0.0.1:{robot.port}", "--set", f"device.drone.state_port={state_port}")
        self.assertGreater(body.highest, 0.85, err)
        self.assertGreater(body.x, 0.5)
        self.assertLess(body.z, 0.1)
        self.assertEqual(robot.commands[0], "command")
        self.assertGreaterEqual(robot.commands.count("takeoff"), 2)
        self.assertIn("land", robot.commands)

    def test_ardrone_takes_off_flies_forward_and_lands(self):
        port, state_port = simulated.free_udp_port(), simulated.free_udp_port()
        robot = simulated.ArDrone()
        body, said, err = self.flight(
            robot, "ardrone2", "--set", f"device.drone.to=udp:127.0.0.1:{robot.port}", "--set",
            f"device.drone.port={port}", "--set", f"device.drone.state=udp:127.0.0.1:{robot.nav_port}", "--set",
            f"device.drone.state_port={state_port}")
        self.assertGreater(body.highest, 0.85, err)
        self.assertGreater(body.x, 0.5)
        self.assertLess(body.z, 0.1)
        self.assertEqual(robot.old, 0, "sequence numbers rise")
        self.assertEqual(robot.flips, 1, "one take-off")
        self.assertTrue(any(c.startswith("AT*COMWDG=") for c in robot.commands))

    def test_a_drone_that_falls_silent_ends_the_flight_by_its_failsafe(self):
        port, state_port = simulated.free_udp_port(), simulated.free_udp_port()
        robot = simulated.ArDrone()
        with contextlib.closing(robot):
            process = start("ardrone2", "--set", f"device.drone.to=udp:127.0.0.1:{robot.port}", "--set",
                            f"device.drone.port={port}", "--set", f"device.drone.state=udp:127.0.0.1:{robot.nav_port}",
                            "--set", f"device.drone.state_port={state_port}", "--set", "hop.forward_s=60", seconds=15)
            until(lambda: robot.body.x > 0.3, 30, "it flies forward")
            with robot.lock:
                robot.silent = True
            until(lambda: not robot.flying, 10, "the drone was told to land")
            said, err = self.ended(process, robot)
            self.assertIn("link_lost", json.dumps(said) + err)

    def test_a_cut_connection_stops_the_robot_and_comes_back(self):
        robot = simulated.UsarSim()
        with contextlib.closing(robot):
            process = start("airrobot", "--set", f"device.drone.to=tcp:127.0.0.1:{robot.port}", "--set",
                            "hop.forward_s=60", seconds=20)
            until(lambda: robot.body.x > 0.3, 30, "it flies forward")
            robot.cut()
            until(lambda: robot.connections == 2 and robot.spawned, 10, "it connects again and greets")
            said, err = self.ended(process, robot)
            self.assertIn("drone", json.dumps(said) + err, "the trouble is named")
            # Its last command may still be on its way when the robot's process has ended.
            until(lambda: robot.body.wanted[0] == 0, 5, "it stands still at the end")

    def said_by_check(self, *changes):
        """Of the AirRobot's files with these texts changed; what check says, and the lines of both files."""
        with tempfile.TemporaryDirectory() as folder:
            lines = []
            for name in ("airrobot.toml", "airrobot.ini"):
                text = pathlib.Path(f"{FOLDER}/{name}").read_text(encoding="ascii")
                for old, new in changes:
                    text = text.replace(old, new)
                pathlib.Path(f"{folder}/{name}").write_text(text, encoding="ascii")
                lines.append(text.splitlines())
            done = subprocess.run([SINEW, "check", f"{folder}/airrobot.toml"], capture_output=True, text=True, check=False)
            self.assertNotEqual(done.returncode, 0, done.stdout)
            return done.stdout + done.stderr, *lines

    def test_check_names_the_lines_of_the_ini_file(self):
        said, _, _ = self.said_by_check(("Max=3.1", "Max=-3.1"), ("SimIP4=127.0.0.1", "SimIP4=127.0.0"))
        self.assertRegex(said, r"airrobot\.ini:\d+: command1\.Max: .*-3\.1.*not below Min")
        self.assertRegex(said, r"airrobot\.ini:\d+: connection\.SimIP4: ")

    def test_check_names_the_lines_of_both_forms(self):
        said, toml, ini = self.said_by_check(("{LateralVelocity %1.2f}", "{LateralVelocity %1.2n}"),
                                             ('key = "Orientation"', 'kye = "Orientation"'))
        bad = 1 + next(i for i, line in enumerate(ini) if "%1.2n" in line)
        self.assertRegex(said, rf"airrobot\.ini:{bad}: device\.drone\.drive\.LateralVelocity\.text: .*is no conversion")
        bad = 1 + next(i for i, line in enumerate(toml) if "kye" in line)
        self.assertRegex(said, rf"airrobot\.toml:{bad}: device\.drone\.message\.yaw\.kye: .*key")

    def test_check_refuses_limits_beyond_those_of_the_drives(self):
        said, toml, _ = self.said_by_check(("limit = [-5, 5]", "limit = [-5, 6]"))
        line = 1 + next(i for i, text in enumerate(toml) if "limit = [-5, 6]" in text)
        self.assertIn(f"airrobot.toml:{line}: actuator.drone.limit: [-5, 6]: within [-5, 5], the widest range of the drives of "
                      "[device.drone]: what is beyond is pulled in", said)

    def test_the_whole_robot_file_needs_no_ini_file(self):
        for name in ("airrobot", "p3at"):
            with self.subTest(name), tempfile.TemporaryDirectory() as folder:
                whole = subprocess.run([SINEW, "check", "--resolved", f"{FOLDER}/{name}.toml"], capture_output=True, text=True,
                                       check=True).stdout
                self.assertNotRegex(whole, r"(?m)^ini =")
                self.assertRegex(whole, rf"(?m)^\[\[device\.\w+\.drive\]\]  # .*{name}\.ini:\d+$")
                pathlib.Path(f"{folder}/whole.toml").write_text(whole, encoding="ascii")
                there = subprocess.run([SINEW, "check", f"{folder}/whole.toml"], capture_output=True, text=True, check=False)
                self.assertEqual(there.returncode, 0, there.stdout + there.stderr)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)
