#!/usr/bin/env python3
"""The parent's own line to CAN joints: a runtime that dies or hangs leaves no drive with torque, although these drives
have no time-out of their own: nothing else could have stopped them.

usage: can_stop_test.py SWAY_ROBOT CAN_DRIVES [TEST...]
"""
import os
import pathlib
import signal
import subprocess
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from can_robot import Bench, PATIENCE_S, bus_text, children, free_bus, joint_text

SWAY, DRIVES = sys.argv[1:3]
CIA402 = "counts_per_turn = 65536\nrated_effort_nm = 2.0\n"  # no device_timeout_ms


class CanStop(unittest.TestCase):
    def setUp(self):
        self.bench = Bench(self, SWAY, DRIVES)
        self.bus = free_bus()
        self.drives = self.bench.drives(f"udp:{self.bus}", "cia402:1", "cia402:2", "mit:3")
        joints = (joint_text("pan", "cia402", "can0", 1, CIA402) + joint_text("tilt", "cia402", "can0", 2, CIA402) +
                  joint_text("neck", "mit", "can0", 3, 'motor = "ak80_9"\nkp = 40.0\nkd = 2.0\n'))
        self.run_ = self.bench.run(bus_text("can0", "udp", self.bus), joints, 3, hang_ms=3000)
        self.wait_for({0, 1, 2}, "live")

    def wait_for(self, wanted, what):
        while wanted:
            wanted.discard(int(self.drives.wait_for(rf"^(\d) {what}$").group(1)))

    def strike(self, number):
        runtime = children(self.run_.pid)
        self.assertEqual(len(runtime), 1, "the runtime is the one child of its parent")
        os.kill(runtime[0], number)

    def end(self):
        _, said = self.run_.communicate(timeout=PATIENCE_S)
        self.assertEqual(self.run_.returncode, 1, said)
        self.assertNotIn("no stop line", said)
        return said

    def test_killed_runtime_leaves_no_torque(self):
        self.strike(signal.SIGKILL)
        said = self.end()
        self.assertIn("the runtime died: signal 9", said)
        self.assertRegex(said, r"stop of the actuators: sent [0-9.]+ ms later; 3 of 3 joints are without torque")
        self.wait_for({0, 1, 2}, "off")

    def test_hanging_runtime_leaves_no_torque(self):
        # Leases and buses hang with the runtime.
        self.strike(signal.SIGSTOP)
        said = self.end()
        self.assertIn("the runtime hangs: no commit of the guardian", said)
        self.assertIn("3 of 3 joints are without torque", said)
        self.wait_for({0, 1, 2}, "off")

    def test_joint_that_does_not_answer_is_named(self):
        self.drives.tell("1 silent")
        self.strike(signal.SIGKILL)
        said = self.end()
        self.assertIn("stop of the actuators: failed: not every joint has said that it is without torque; "
                      "2 of 3 joints are without torque; joint 'tilt' (can0) did not answer", said)
        self.wait_for({0, 1, 2}, "off")

    def test_orderly_end_says_nothing(self):
        self.run_.terminate()
        _, said = self.run_.communicate(timeout=PATIENCE_S)
        self.assertEqual(self.run_.returncode, 0, said)
        self.assertNotIn("stop of the actuators", said)
        self.wait_for({0, 1, 2}, "off")


class WithoutBus(unittest.TestCase):
    def test_bus_that_is_not_there_is_said_once(self):
        bench = Bench(self, SWAY, DRIVES)
        run = bench.run(bus_text("can0", "socketcand", "127.0.0.1:9/can0"), joint_text("pan", "cia402", "can0", 1, CIA402), 1)
        _, said = run.communicate(timeout=PATIENCE_S)
        self.assertEqual(run.returncode, 2, said)
        self.assertRegex(said, r"device 'body' \(driver can_servos\): bus 'can0': ")
        self.assertEqual(said.count("127.0.0.1:9/can0"), 1, said)  # the parent has no line either; nothing began


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:], verbosity=2)
