#!/usr/bin/env python3
"""A robot file's CAN joints, by each transport that runs on any machine, and a foreign program on the same bus.

usage: can_transport_test.py SWAY_ROBOT CAN_DRIVES [TEST...]    exit 77: a foreign program is missing (ForeignPeer)
"""
import os
import pathlib
import shutil
import subprocess
import sys
import textwrap
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from can_robot import Bench, PATIENCE_S, bus_text, free_bus, joint_text

SWAY, DRIVES = sys.argv[1:3]
SERVOS = ["cia402:1", "mit:2", "cybergear:3"]
PYTHON = "/usr/bin/python3"  # the system's: it has the system's packages
# A foreign program sees our robot on the bus: the drive's position, by TPDO1 (statusword, counts, torque).
FOREIGN = textwrap.dedent("""
    import struct, sys, time
    import can
    bus = can.Bus(interface="socketcand", host="127.0.0.1", port=int(sys.argv[1]), channel=sys.argv[2])
    def ask(data, patience_s=10):
        bus.send(can.Message(arbitration_id=0x601, data=data, is_extended_id=False))
        end = time.monotonic() + patience_s
        while time.monotonic() < end:
            got = bus.recv(0.1)
            if got and got.arbitration_id == 0x581 and bytes(got.data[1:4]) == bytes(data[1:4]):
                return bytes(got.data)
        sys.exit("no answer to " + bytes(data).hex())
    def wait(what, patience_s=30):
        end = time.monotonic() + patience_s
        while time.monotonic() < end:
            got = bus.recv(0.1)
            if got and what(got):
                return got
        sys.exit("never came")
    """)


def foreign(script, *arguments):
    return subprocess.run([PYTHON, "-c", FOREIGN + textwrap.dedent(script), *arguments], capture_output=True, text=True,
                          timeout=PATIENCE_S)


def joints(bus):
    return (joint_text("pan", "cia402", bus, 1, "counts_per_turn = 65536\nrated_effort_nm = 2.0\n") +
            joint_text("tilt", "mit", bus, 2, 'motor = "ak80_9"\nkp = 40.0\nkd = 2.0\n') +
            joint_text("neck", "cybergear", bus, 3, "kp = 40.0\nkd = 2.0\n"))


class Transports(unittest.TestCase):
    def drive(self, far_end, driver, address):
        """Drives answer at the far end; our robot brings them up, moves them to 0.5 and leaves them off."""
        bench = Bench(self, SWAY, DRIVES)
        drives = bench.drives(far_end, *SERVOS)
        port = drives.all[0].rpartition(":")[2]
        run = bench.run(bus_text("can0", driver, address.replace("PORT", port)), joints("can0"), 3, middle=0.5)
        live = set()
        while len(live) < 3:
            live.add(drives.wait_for(r"^(\d) live$").group(1))
        for joint in range(3):
            self.arrives(drives, joint)
        run.terminate()
        self.assertEqual(run.wait(PATIENCE_S), 0, run.stderr.read())
        while live:
            live.discard(drives.wait_for(r"^(\d) off$").group(1))

    def arrives(self, drives, joint):
        end = time.monotonic() + PATIENCE_S
        while time.monotonic() < end:
            drives.tell(f"{joint} at")
            at = float(drives.wait_for(rf"^{joint} at (\S+)$").group(1))
            if 0.15 < at < 0.85:  # it sways by 0.3 about 0.5
                return
            time.sleep(0.05)
        self.fail(f"joint {joint} stands at {at}")

    def test_udp(self):
        bus = free_bus()
        self.drive(f"udp:{bus}", "udp", str(bus))

    def test_socketcand(self):
        self.drive("socketcand-server:0", "socketcand", "127.0.0.1:PORT/can0")


class Leftovers(unittest.TestCase):
    """A test that fails, or is killed, leaves no process of a robot behind."""

    def alive(self, folder):
        """Processes that were started for a robot file in this folder."""
        found = []
        for pid in filter(str.isdigit, os.listdir("/proc")):
            try:
                with open(f"/proc/{pid}/cmdline") as f:
                    if folder in f.read():
                        found.append(int(pid))
            except OSError:
                pass  # it ended meanwhile
        return found

    def start(self):
        bus = free_bus()
        bench = Bench(self, SWAY, DRIVES)
        drives = bench.drives(f"udp:{bus}", *SERVOS)
        run = bench.run(bus_text("can0", "udp", bus), joints("can0"), 3)
        drives.wait_for(r"^0 live$")
        self.assertEqual(len(self.alive(bench.folder)), 2, "the parent and the runtime")
        return bench, run

    def test_of_a_run_that_is_ended(self):
        bench, run = self.start()
        bench.end(run)
        self.gone(bench.folder)

    def test_of_a_run_whose_parent_was_killed(self):
        bench, run = self.start()
        run.kill()
        run.wait(PATIENCE_S)
        bench.end(run)
        self.gone(bench.folder)

    def test_of_a_test_that_is_killed(self):
        # A test in its own process, ended as a runner ends a test that takes too long.
        script = textwrap.dedent(f"""
            import sys, time, unittest
            sys.path.insert(0, {str(pathlib.Path(__file__).parent)!r})
            from can_robot import Bench
            bench = Bench(unittest.TestCase(), {SWAY!r}, {DRIVES!r})
            drives = bench.drives("udp:{free_bus()}", *{SERVOS!r})
            bench.run({bus_text("can0", "udp", free_bus())!r}, {joints("can0")!r}, 3)
            drives.wait_for("^0 live$")
            print(bench.folder, flush=True)
            time.sleep(600)
            """)
        test = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True)
        self.addCleanup(test.wait)
        self.addCleanup(test.kill)
        folder = test.stdout.readline().strip()
        test.stdout.close()
        self.assertTrue(self.alive(folder))
        test.kill()
        self.gone(folder)
        shutil.rmtree(folder, ignore_errors=True)

    def gone(self, folder):
        end = time.monotonic() + PATIENCE_S
        while left := self.alive(folder):
            self.assertLess(time.monotonic(), end, f"left behind: {left}")
            time.sleep(0.05)


class ForeignPeer(unittest.TestCase):
    def setUp(self):
        self.bench = Bench(self, SWAY, DRIVES)
        self.drives = self.bench.drives("socketcand-server:0", *SERVOS)
        self.port = self.drives.all[0].rpartition(":")[2]

    def expect(self, done, *said):
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        for text in said:
            self.assertIn(text, done.stdout, done.stderr)

    def test_python_can_reads_objects_of_a_drive_and_moves_its_states(self):
        self.expect(foreign("""
            print("vendor", ask([0x40, 0x18, 0x10, 1, 0, 0, 0, 0]).hex())           # 1018h:1
            print("nothing", ask([0x40, 0x00, 0x20, 0, 0, 0, 0, 0]).hex())          # 2000h: there is none
            print("heartbeat", ask([0x2B, 0x17, 0x10, 0, 50, 0, 0, 0]).hex())       # 1017h: each 50 ms
            print("pre", bytes(wait(lambda f: f.arbitration_id == 0x701 and f.data[0] == 0x7F).data).hex())
            bus.send(can.Message(arbitration_id=0, data=[1, 1], is_extended_id=False))  # NMT: start node 1
            print("operational", bytes(wait(lambda f: f.arbitration_id == 0x701 and f.data[0] == 5).data).hex())
            bus.send(can.Message(arbitration_id=0, data=[2, 1], is_extended_id=False))  # NMT: stop
            print("stopped", bytes(wait(lambda f: f.arbitration_id == 0x701 and f.data[0] == 4).data).hex())
            """, self.port, "can0"),
            "vendor 4318100151000000", "nothing 8000200000000206", "heartbeat 6017100000000000", "pre 7f",
            "operational 05", "stopped 04")

    def test_our_own_client_drives_the_servo_that_python_can_watches(self):
        run = self.bench.run(bus_text("can0", "socketcand", f"127.0.0.1:{self.port}/can0"), joints("can0"), 3, middle=0.5)
        self.drives.wait_for(r"^0 live$")
        self.expect(foreign("""
            def stands_there(frame):
                if frame.arbitration_id != 0x181 or len(frame.data) != 8:
                    return False
                status, counts, _ = struct.unpack("<Hih", frame.data)
                return status & 0x6F == 0x27 and 0.15 < counts / 65536 * 2 * 3.14159265 < 0.85
            wait(stands_there)                                                      # enabled, and where it is told
            setpoint = wait(lambda f: f.arbitration_id == 0x201 and len(f.data) >= 6)  # our RPDO1
            print("control", struct.unpack("<H", setpoint.data[:2])[0])
            print("vendor", ask([0x40, 0x18, 0x10, 1, 0, 0, 0, 0]).hex())           # while it is driven
            """, self.port, "can0"), "control 15", "vendor 4318100151000000")
        self.assertIsNone(run.poll(), "what it asked did not disturb ours")

    def test_extended_identifiers_go_through(self):
        # CyberGear 3: kind 0, host FDh: it answers with its processor's number.
        self.expect(foreign("""
            bus.send(can.Message(arbitration_id=0x0000FD03, data=bytes(8), is_extended_id=True))
            print("serial", bytes(wait(lambda f: f.arbitration_id & 0x1F0000FF == 0xFE).data).hex())
            """, self.port, "can0"), "serial eeffc00000000000")

    def test_buses_of_one_server_are_apart_and_others_do_not_exist(self):
        self.expect(foreign("""
            bus.send(can.Message(arbitration_id=0x601, data=[0x40, 0x18, 0x10, 1, 0, 0, 0, 0], is_extended_id=False))
            end = time.monotonic() + 1
            while time.monotonic() < end:
                if bus.recv(0.1):
                    sys.exit("somebody answers on can1")
            print("silence")
            """, self.port, "can1"), "silence")
        done = foreign("", self.port, "can7")
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("message expected", done.stderr)


if __name__ == "__main__":
    if "ForeignPeer" in sys.argv[3:]:
        if subprocess.run([PYTHON, "-c", "import can"], capture_output=True).returncode != 0:
            print("there is no python-can here (Debian: python3-can)")
            sys.exit(77)
    unittest.main(argv=sys.argv[:1] + sys.argv[3:], verbosity=2)
