#!/usr/bin/env python3
"""robots/quad/quad_pilot.toml: the simulated quadrotor in real time, with the pilot's receiver on a serial line (CRSF on a
pseudo terminal), by `--board-of rc=linux`: the real driver, its switches and failsafes.

usage: pilot_quad_test.py SINEW ROBOT.toml

In real time on a machine that may be busy: one of three runs must land.
"""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import threading
import time
import tty
import unittest

SINEW, ROBOT = sys.argv[1:3]
LOW, MIDDLE, HIGH = 172, 992, 1811  # CRSF: -1, 0, 1


def crsf_channels(channels):
    """One RC_CHANNELS_PACKED frame: 16 channels of 11 bits, little endian, CRC-8 with polynomial D5h."""
    packed = sum(value << (11 * i) for i, value in enumerate(channels)).to_bytes(22, "little")
    crc = 0
    for byte in b"\x16" + packed:
        crc ^= byte
        for _ in range(8):
            crc = (crc << 1 ^ 0xD5 if crc & 0x80 else crc << 1) & 0xFF
    return b"\xC8\x18\x16" + packed + bytes([crc])


class Pilot:
    """A transmitter's receiver, 100 frames a second on a pseudo terminal."""

    def __init__(self):
        self.ours, theirs = os.openpty()
        tty.setraw(theirs)
        os.set_blocking(self.ours, False)
        self.path, self.theirs = os.ttyname(theirs), theirs
        self.channels = [MIDDLE] * 4 + [LOW] * 12
        self.talks, self.on = True, True
        self.thread = threading.Thread(target=self._send)
        self.thread.start()

    def _send(self):
        while self.on:
            if self.talks:
                try:
                    os.write(self.ours, crsf_channels(self.channels))
                except BlockingIOError:
                    pass  # nobody reads yet
            time.sleep(0.01)

    def end(self):
        self.on = False
        self.thread.join()
        os.close(self.ours)
        os.close(self.theirs)


class Quad(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="sinew-")
        self.addCleanup(folder.cleanup)
        self.env = dict(os.environ, SINEW_RUN_DIR=folder.name, SINEW_RECORD="off")
        self.folder = folder.name

    def sinew(self, *arguments):
        return subprocess.run([SINEW, *arguments], capture_output=True, text=True, env=self.env, timeout=60)

    def fly(self, in_flight):
        """Arms as soon as it runs, and calls `in_flight` with the pilot once it is up. Returns the run's output at its end."""
        pilot = Pilot()
        self.addCleanup(pilot.end)
        run = subprocess.Popen(
            [SINEW, "run", ROBOT, "--board", "sim", "--board-of", "rc=linux", "--set", f"device.rc.path={pilot.path}",
             "--duration", "90", "--json", "--no-record"],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=self.env, cwd=self.folder)
        try:
            self.until(run, lambda: self.sinew("arm").returncode == 0)
            self.until(run, self.is_up)
            in_flight(pilot)
            out, err = run.communicate(timeout=150)
        finally:
            if run.poll() is None:
                run.terminate()
                run.communicate(timeout=60)
        self.assertIn(run.returncode, (0, 1), err)
        return json.loads(out), err

    def is_up(self):
        done = self.sinew("topic", "echo", "filter.state", "-n", "1", "--timeout", "5", "--json")
        return done.returncode == 0 and json.loads(done.stdout.splitlines()[0])["message"]["p_world_m"]["z"] > 0.8

    def until(self, run, what):
        end = time.monotonic() + 60
        while not what():
            if run.poll() is not None:
                self.fail(f"it ended: {run.communicate()}")
            self.assertLess(time.monotonic(), end)
            time.sleep(0.05)

    def test_passes_the_check(self):
        done = self.sinew("check", ROBOT)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("no problems", done.stdout)

    def test_lands_on_its_pad_while_the_pilot_watches(self):
        told = []
        for _ in range(3):
            summary, err = self.fly(lambda pilot: None)
            told.append(f"{summary['result']}; {err}")
            if "landed" in summary["result"]:
                return
        self.fail("\n".join(told))

    def test_the_kill_switch_on_the_wire_stops_the_motors(self):
        def kill(pilot):
            pilot.channels[5] = HIGH
        summary, err = self.fly(kill)
        self.assertIn("killed", json.dumps(summary) + err)
        self.assertNotIn("landed on the pad", summary["result"])

    def test_a_receiver_that_falls_silent_lands_it(self):
        def silence(pilot):
            pilot.talks = False
        summary, err = self.fly(silence)
        self.assertIn("pilot_lost", json.dumps(summary) + err)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:], verbosity=2)
