#!/usr/bin/env python3
"""Options of sinew-sim: it refuses senseless ones in words, and a fault of the joints acts on drives at the wire.

usage: sim_options_test.py SINEW_SIM
"""
import json
import os
import pathlib
import socket
import subprocess
import sys
import tempfile
import time
import unittest

SINEW_SIM = sys.argv[1]
PATIENCE_S = 30
BODY = pathlib.Path(__file__).resolve().parents[3] / "robots/kid/op3.toml"
HEAD = ["--world", "desk_head"]
TWO = ["--can", "udp:7", "--servo", "cia402:1", "--servo", "cia402:2"]


class Refusals(unittest.TestCase):
    def refused(self, *arguments):
        done = subprocess.run([SINEW_SIM, *arguments], capture_output=True, text=True, timeout=PATIENCE_S)
        self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
        self.assertEqual(done.stdout, "")
        return done.stderr

    def test_each_drive_has_an_id_of_its_own(self):
        said = self.refused(*HEAD, "--can", "udp:7", "--servo", "cia402:1", "--servo", "mit:1:ak80_9")
        self.assertIn("--servo: 'mit:1:ak80_9' has the id 1 of 'cia402:1'", said)

    def test_there_are_as_many_drives_as_joints(self):
        for number, servos in (("3", ["cia402:1", "cia402:2", "cia402:3"]), ("1", ["cia402:1"]), ("0", [])):
            said = self.refused(*HEAD, "--can", "udp:7", *[part for s in servos for part in ("--servo", s)])
            self.assertIn(f"--servo: {number} given, but the world desk_head has 2 joints", said)
        self.assertIn("--can: there is no drive on it",
                      self.refused(*HEAD, "--can", "udp:7", "--servo", "none", "--servo", "none"))

    def test_drives_want_a_bus_and_a_world_with_joints(self):
        self.assertIn("--servo: needs --can, which names its bus", self.refused(*HEAD, "--servo", "cia402:1"))
        self.assertIn("--servo: needs --can, which names its bus",
                      self.refused(*HEAD, "--serial", "x", "--servo", "xm430_w350:1", "--servo", "cia402:1"))
        self.assertIn("--can: the world quad has no joints", self.refused("--can", "udp:7", "--servo", "cia402:1"))
        self.assertIn("'walrus:1' is none of cia402:ID", self.refused(*HEAD, "--can", "udp:7", "--servo", "walrus:1"))

    def test_servos_on_serial_lines_want_a_line_of_their_own(self):
        two = ["--servo", "xm430_w350:1", "--servo"]
        self.assertIn("--servo: 'sts3215:1:2' is on line 2, and there is 1: each --serial makes one",
                      self.refused(*HEAD, "--serial", "x", *two, "sts3215:1:2"))
        self.assertIn("--servo: 'xm430_w350:1' has the id 1 of 'xm430_w350:1'",
                      self.refused(*HEAD, "--serial", "x", *two, "xm430_w350:1"))
        self.assertIn("--serial: there is no servo on y",
                      self.refused(*HEAD, "--serial", "x", "--serial", "y", *two, "xm430_w350:2"))
        self.assertIn("--serial: 'x,echo': another line has this path",
                      self.refused(*HEAD, "--serial", "x", "--serial", "x,echo", *two, "none"))
        self.assertIn("--serial: no servo on x has the id 7 of its reboot=, off=, overload= or hot=",
                      self.refused(*HEAD, "--serial", "x,reboot=7@3", *two, "none"))
        for wrong in ("x,walrus", "x,lost=0.9", "x,reboot=1", "x,gone=3", ",echo", "x,bit_rate=1e9"):
            self.assertIn(f"--serial: '{wrong}' is not PATH and then", self.refused(*HEAD, "--serial", wrong, *two, "none"))
        self.assertIn("--serial x: File exists", self.refused_here("x", *HEAD, "--alone", "--serial", "x", *two, "none"))
        self.assertIn("the world quad has no joints", self.refused("--serial", "x", "--servo", "xm430_w350:1"))

    def refused_here(self, name, *arguments):
        """In a folder with a file of this name."""
        with tempfile.TemporaryDirectory(prefix="sinew-") as folder:
            pathlib.Path(folder, name).touch()
            done = subprocess.run([SINEW_SIM, *arguments], capture_output=True, text=True, timeout=PATIENCE_S, cwd=folder)
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        return done.stderr

    def test_devices_at_the_wire_are_in_real_time_only(self):
        self.assertIn("--can: in real time only, not with --lockstep", self.refused(*HEAD, "--lockstep", *TWO))
        self.assertIn("--serial: in real time only",
                      self.refused(*HEAD, "--lockstep", "--serial", "x", "--servo", "xm430_w350:1", "--servo", "none"))
        self.assertIn("--iio: in real time only", self.refused("--lockstep", "--iio", "/nonexistent"))
        self.assertIn("--v4l2: in real time only", self.refused("--lockstep", "--v4l2", "/nonexistent"))

    def test_a_game_controller_has_a_referee_and_two_teams(self):
        to = ["--gamecontroller", "127.0.0.1:3838"]
        field = ["--world", "soccer", "--body", str(BODY)]
        self.assertIn("--gamecontroller: the world quad has no referee", self.refused(*to))
        self.assertIn("the world soccer has no referee; --referee 1 gives it one", self.refused(*field, *to))
        game = [*field, "--referee", "1"]
        for wrong in ("robot:3838", "127.0.0.1", "239.72.1.1:3838", "127.0.0.1:0"):
            self.assertIn(f"--gamecontroller: '{wrong}': an address and a port, 127.0.0.1:3838",
                          self.refused(*game, "--gamecontroller", wrong))
        for wrong in ("1", "1,1", "0,2", "1,255", "1,2,3", "blue,red"):
            self.assertIn(f"--gamecontroller-teams: '{wrong}': two different numbers from 1 to 254",
                          self.refused(*game, *to, "--gamecontroller-teams", wrong))
        self.assertIn("--gamecontroller-teams: only with --gamecontroller", self.refused("--gamecontroller-teams", "1,2"))
        self.assertIn("--gamecontroller-version", self.refused(*game, *to, "--gamecontroller-version", "15"))
        self.assertIn("--gamecontroller-answers", self.refused(*game, *to, "--gamecontroller-answers", "65536"))

    def test_a_world_alone_waits_for_nobody_and_has_something_to_show(self):
        for option in (["--listen", "unix:x.sock"], ["--wait", "3"], ["--relink", "3"], ["--free"], ["--lockstep"]):
            self.assertIn(f"{option[0]}: ", self.refused(*HEAD, "--alone", *TWO, *option))
        self.assertIn("--alone: nobody reaches a world", self.refused(*HEAD, "--alone"))

    def test_options_of_another_world_say_nothing_to_this_one(self):
        self.assertIn("--gust: only of the world air_robot, quad, terrain", self.refused(*HEAD, "--gust", "2"))
        self.assertIn("--rock: only of the world desk_head", self.refused("--rock", "2"))

    def test_an_option_of_the_world_is_refused_with_its_range(self):
        self.assertEqual(self.refused("--gust", "99"), "sinew-sim: --gust: 99: a number from 0 to 15 m/s\n")
        self.assertEqual(self.refused("--start-x=nan"), "sinew-sim: --start-x: nan: a number from -1.2 to 1.2 m\n")
        self.assertEqual(self.refused("--sensor-errors", "0.5"),
                         "sinew-sim: --sensor-errors: 0.5: an integer from 0 to 1\n")

    def test_an_unknown_option_is_told_with_the_one_that_it_resembles(self):
        self.assertEqual(self.refused("--gusts", "3"),
                         "sinew-sim: --gusts: no such option; sinew-sim --help lists them; did you mean --gust?\n")

    def test_a_seed_is_not_below_0(self):
        self.assertEqual(self.refused("--seed", "-1"),
                         "sinew-sim: --seed: -1 is not an integer from 0 to 18446744073709551615\n")

    def test_a_fault_that_would_reach_nobody_is_refused(self):
        self.assertIn("'joints:slow@1': drives at the wire (--servo) play off, stuck and garbage",
                      self.refused(*HEAD, *TWO, "--fault", "joints:slow@1"))
        self.assertIn("'head:off@1' strikes what goes over the protocol, but --servo",
                      self.refused(*HEAD, *TWO, "--fault", "head:off@1"))
        self.assertIn("but --iio puts this device at the wire",
                      self.refused("--iio", "/nonexistent", "--fault", "imu:off@1"))
        self.assertIn("--unplug-camera", self.refused("--v4l2", "/nonexistent", "--fault", "camera:off@1"))
        self.assertIn("with --alone none connects", self.refused(*HEAD, "--alone", *TWO, "--fault", "imu:off@1"))

    def test_what_the_command_line_itself_refuses_has_the_same_exit_code(self):
        self.assertIn("--walrus", self.refused("--walrus"))
        self.assertIn("is not WIDTHxHEIGHT", self.refused("--camera", "3x"))
        self.assertIn("'walrus'", self.refused("--fault", "walrus:off@1"))


class Drives:
    """Asks CANopen nodes through the simulator's socketcand server."""

    def __init__(self, port):
        end = time.monotonic() + PATIENCE_S
        while True:
            try:
                self.socket = socket.create_connection(("127.0.0.1", port), timeout=PATIENCE_S)
                break
            except ConnectionRefusedError:
                if time.monotonic() > end:
                    raise
                time.sleep(0.05)
        self.text = ""
        for say, answer in ((None, "< hi >"), ("< open can0 >", "< ok >"), ("< rawmode >", "< ok >")):
            if say:
                self.socket.sendall(say.encode())
            assert self.next(PATIENCE_S) == answer

    def next(self, patience_s):
        """The next `< ... >`; nothing when none comes in time."""
        end = time.monotonic() + patience_s
        while ">" not in self.text:
            self.socket.settimeout(max(0.001, end - time.monotonic()))
            try:
                more = self.socket.recv(65536)
            except TimeoutError:
                return None
            assert more, "the simulator hung up"
            self.text += more.decode()
        message, _, self.text = self.text.partition(">")
        return message.strip() + " >"

    def answers(self, node):
        """Whether it answers to the question for its device type (1000h), within half a second."""
        self.socket.sendall(f"< send {0x600 + node:x} 8 40 00 10 00 00 00 00 00 >".encode())
        end = time.monotonic() + 0.5
        while time.monotonic() < end:
            said = self.next(max(0.001, end - time.monotonic()))
            if said and said.startswith(f"< frame {0x580 + node:X} ".replace("  ", " ")):
                return True
        return False


class FaultsAtTheWire(unittest.TestCase):
    def test_drives_that_are_off_answer_nobody_until_they_are_on_again(self):
        port = 30000 + os.getpid() % 10000
        with tempfile.TemporaryDirectory(prefix="sinew-") as name:
            report = pathlib.Path(name) / "report.json"
            plant = subprocess.Popen(
                [SINEW_SIM, *HEAD, "--alone", "--can", f"socketcand-server:{port}", "--servo", "cia402:1", "--servo",
                 "cia402:2", "--fault", "joints:off@3..8", "--report", str(report)], stdout=subprocess.DEVNULL)
            try:
                drives = Drives(port)
                for expected in (True, False, True):
                    for node in (1, 2):
                        self.until(drives, node, expected)
                plant.terminate()
                plant.wait(PATIENCE_S)
            finally:
                plant.kill()
                plant.wait()
                drives.socket.close()
            faults = json.loads(report.read_text())["faults"]
        self.assertEqual([(f["fault"], f["affected"]) for f in faults], [("joints:off@3..8", 2)])

    def until(self, drives, node, expected):
        end = time.monotonic() + PATIENCE_S
        while drives.answers(node) != expected:
            self.assertLess(time.monotonic(), end, f"node {node} never {'answers' if expected else 'falls silent'}")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[2:], verbosity=2)
