#!/usr/bin/env python3
"""sinew-fly with options that it must refuse: exit code 2, and words.

usage: fly_options_test.py SINEW_FLY ROBOTS
"""
import pathlib
import socket
import subprocess
import sys
import tempfile
import unittest

FLY, ROBOTS = sys.argv[1:3]
QUAD = f"{ROBOTS}/quad/quad.toml"


class Refusals(unittest.TestCase):
    def refused(self, *arguments):
        done = subprocess.run([FLY, *arguments], capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
        self.assertEqual(done.stdout, "")
        return done.stderr

    def test_what_is_missing_on_the_command_line(self):
        for arguments in ([], [QUAD]):
            said = self.refused(*arguments)
            self.assertIn("a robot file and an endpoint are needed", said)
            self.assertIn("usage: sinew-fly ROBOT.toml ENDPOINT", said)
        self.assertIn("more: a third word", self.refused(QUAD, "tcp:127.0.0.1:1", "more"))
        self.assertIn("--fast: unknown; there are --seed, --duration", self.refused(QUAD, "tcp:127.0.0.1:1", "--fast"))

    def test_its_help_is_no_complaint(self):
        done = subprocess.run([FLY, "--help"], capture_output=True, text=True, timeout=60)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertTrue(done.stdout.startswith("usage: sinew-fly ROBOT.toml ENDPOINT"), done.stdout)

    def test_numbers_that_are_none(self):
        for option in ("--seed", "--duration"):
            for value in ("x", "-1", "3x", "", "1e999", "nan"):
                said = self.refused(QUAD, "tcp:127.0.0.1:1", option, value)
                self.assertIn(f"{option} {value}: a number, not below 0", said)
            self.assertIn(f"{option} : a number, not below 0", self.refused(QUAD, "tcp:127.0.0.1:1", option))
        self.assertIn("--seed 1.5: a number", self.refused(QUAD, "tcp:127.0.0.1:1", "--seed", "1.5"))
        self.assertIn("--duration inf: a number", self.refused(QUAD, "tcp:127.0.0.1:1", "--duration", "inf"))
        self.assertIn("--duration 1e300: at most a year", self.refused(QUAD, "tcp:127.0.0.1:1", "--duration", "1e300"))

    def test_a_robot_file_that_is_not_there_or_wrong(self):
        self.assertIn("/no/such.toml: file: ", self.refused("/no/such.toml", "tcp:127.0.0.1:1"))
        with tempfile.TemporaryDirectory() as folder:
            robot = pathlib.Path(folder, "wrong.toml")
            robot.write_text(pathlib.Path(QUAD).read_text().replace("priority = 80", "priority = 200"))
            self.assertIn("thread.stabilise.priority: 200", self.refused(str(robot), "tcp:127.0.0.1:1"))

    def test_a_robot_with_other_devices_than_a_simulators(self):
        with tempfile.TemporaryDirectory() as folder:
            robot = pathlib.Path(folder, "real.toml")
            text = pathlib.Path(QUAD).read_text()
            robot.write_text(text.replace('board = "sim"', 'board = "linux"'))
            self.assertIn('real.toml: robot.board: "linux": this program has the simulator\'s only',
                          self.refused(str(robot), "tcp:127.0.0.1:1"))
            robot.write_text(text.replace('board = "sim"', 'board = "sim", device_boards = { camera = "linux" }'))
            self.assertIn('real.toml: robot.device_boards.camera: "linux"', self.refused(str(robot), "tcp:127.0.0.1:1"))

    def test_an_endpoint_that_is_none_or_where_nobody_is(self):
        for endpoint in ("nowhere", "tcp:127.0.0.1", "tcp:127.0.0.1:x", "tcp:127.0.0.1:99999"):
            self.assertIn(f"sinew-fly: {endpoint}: ", self.refused(QUAD, endpoint))
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))  # nobody listens: refused
            endpoint = f"tcp:127.0.0.1:{free.getsockname()[1]}"
            self.assertIn(f"sinew-fly: {endpoint}: ", self.refused(QUAD, endpoint))

    def test_somebody_at_the_endpoint_who_is_no_simulator(self):
        with socket.socket() as other:
            other.bind(("127.0.0.1", 0))
            other.listen()
            fly = subprocess.Popen([FLY, QUAD, f"tcp:127.0.0.1:{other.getsockname()[1]}"], stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True)
            caller, _ = other.accept()
            with caller:
                caller.sendall(b"HTTP/1.1 400 Bad Request\r\n\r\n" + bytes(100))
                out, err = fly.communicate(timeout=60)
            self.assertEqual(fly.returncode, 2, out + err)
            self.assertRegex(err, r"^sinew-fly: .+")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:], verbosity=2)
