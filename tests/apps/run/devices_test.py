#!/usr/bin/env python3
"""sinew devices: the devices that answer on the buses of a robot file, or of the command line.

usage: devices_test.py SINEW CAN_DRIVES
"""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from can_robot import ROBOT, Bench, bus_text, free_bus, joint_text

SINEW, DRIVES = sys.argv[1:3]


class Devices(unittest.TestCase):
    def setUp(self):
        self.bench = Bench(self, "", DRIVES)
        self.env = dict(os.environ, SINEW_RUN_DIR=self.bench.folder)

    def devices(self, *arguments):
        done = subprocess.run([SINEW, "devices", *arguments], capture_output=True, text=True, timeout=60, env=self.env)
        return done.returncode, done.stdout, done.stderr

    def serve(self, *servos):
        drives = self.bench.drives("socketcand-server:0", *servos)
        return f"127.0.0.1:{drives.all[0].rpartition(':')[2]}/can0"

    def robot(self, driver, address, *ids):
        joints = "".join(joint_text(f"j{i}", "cia402", "can0", i, "counts_per_turn = 65536\nrated_effort_nm = 2.0\n")
                         for i in ids)
        path = pathlib.Path(self.bench.folder, "robot.toml")
        path.write_text(ROBOT.format(buses=bus_text("can0", driver, address), joints=joints, channels=len(ids), hang_ms=3000,
                                     middle=0.0, more_order="", more_modules="").replace("test::Sway", "test::None"))
        return str(path)

    def test_every_family_is_found_on_a_bus_of_the_command_line(self):
        address = self.serve("cia402:1", "mit:2", "cybergear:3", "actuator:44:0")
        code, out, err = self.devices("--bus", f"socketcand:{address}")
        self.assertEqual(code, 0, out + err)
        for line in (r"canopen\s+1  type 0x00020192 \(CiA 402\), vendor 0x00000051, product 0x00000402\n",
                     r"mit\s+2  answers under 0x000\n", r"cybergear\s+3  serial 0000000000C0FFEE\n",
                     r"dronecan\s+44  health ok, operational\n"):
            self.assertRegex(out, line)
        self.assertIn(": 4 devices\n", out)

    def test_the_same_over_udp_in_json_and_only_what_is_asked_for(self):
        bus = free_bus()
        self.bench.drives(f"udp:{bus}", "cia402:1", "mit:2")
        code, out, err = self.devices("--bus", f"udp:{bus}", "--ask", "canopen", "--json")
        self.assertEqual(code, 0, out + err)
        found = json.loads(out)["buses"][0]["found"]
        self.assertEqual([(f["family"], f["id"], f["vendor"]) for f in found], [("canopen", 1, 0x51)])

    def test_the_scan_leaves_the_drives_as_they_were(self):
        drives = self.bench.drives("socketcand-server:0", "cia402:1", "mit:2", "cybergear:3")
        address = f"127.0.0.1:{drives.all[0].rpartition(':')[2]}/can0"
        self.assertEqual(self.devices("--bus", f"socketcand:{address}")[0], 0)
        drives.tell("0 at")
        drives.wait_for("^0 at ")
        self.assertFalse([line for line in drives.all if "live" in line])

    def test_joints_of_the_robot_file_have_their_names_and_who_is_missing_is_said(self):
        address = self.serve("cia402:1", "cia402:9")
        robot = self.robot("socketcand", address, 1, 2)
        code, out, err = self.devices(robot, "--ask", "canopen")
        if code == 2:
            self.fail(err)
        self.assertEqual(code, 1, out + err)
        self.assertRegex(out, r"device body\s+can_servos\n")
        self.assertRegex(out, r"canopen\s+1 .*; body\.j1\n")
        self.assertRegex(out, r"canopen\s+9 .*; not in the robot file\n")
        self.assertRegex(out, r"canopen\s+2  no answer; body\.j2\n")

    def test_what_cannot_be_begun_is_said(self):
        self.assertEqual(self.devices()[0], 2)
        code, _, err = self.devices("--bus", "somewhere")
        self.assertEqual(code, 2)
        self.assertIn("TRANSPORT:ADDRESS", err)
        code, _, err = self.devices("--bus", "socketcand:127.0.0.1:9/can0")
        self.assertEqual(code, 1)
        self.assertIn("127.0.0.1:9/can0: ", err)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:], verbosity=2)
