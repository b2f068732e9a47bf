"""A whole flight in virtual time beside hostile programs: every topic has the same bytes as in a flight without them.

usage: hostile_flight_test.py SINEW TAP_HOSTILE ROBOT
"""
import os
import re
import subprocess
import sys
import tempfile
import threading
import time
import unittest

os.environ.setdefault("SINEW_RECORD", "off")  # a flight is 100 MB; recordings have tests of their own

SINEW, HOSTILE, ROBOT = sys.argv[1:4]
RUN_DIR = tempfile.TemporaryDirectory()  # robots of other tests cannot meet this program's
os.environ["SINEW_RUN_DIR"] = RUN_DIR.name
SOCKET = os.path.join(RUN_DIR.name, "quad.sock")
COMMAND = [SINEW, "run", ROBOT, "--virtual", "--seed", "3", "--verbose"]
# The attacks of the hostile program and their amounts: each takes a good part of a second, a flight a few seconds.
VISITS = {"write": "0", "spin": "0.3", "wake": "0.3", "garbage": "20", "half": "0.2", "flood": "0.3", "killed": "30"}
AHEAD = 5  # visits: a kind that has more of them than the rarest one waits, and leaves the robot's few places to that one
MOST_FLIGHTS = 10


def hashes(text):
    return re.findall(r"^hash (\S+)\s+([0-9a-f]{16})$", text, re.M)


NO_VISIT = ("no memory came", "no reply", "the directory is refused",  # the others have taken all places
            "0 whole messages, 0 overtaken")  # the flight has not begun: nothing is published yet


class Visitor(threading.Thread):
    """Sends one kind of hostile program again and again while the flight lasts."""

    def __init__(self, kind, flight):
        super().__init__()
        self.kind, self.flight = kind, flight
        self.visits, self.said, self.others = 0, "", []

    def run(self):
        while self.flight.poll() is None:
            if self.visits > AHEAD + min(other.visits for other in self.others):
                time.sleep(0.01)
                continue
            with subprocess.Popen([HOSTILE, self.kind, SOCKET, VISITS[self.kind]], stdout=subprocess.PIPE,
                                  stderr=subprocess.STDOUT, text=True) as visit:
                while visit.poll() is None and self.flight.poll() is None:
                    time.sleep(0.01)
                if self.flight.poll() is not None:  # an attack on a robot that ends proves nothing
                    visit.kill()
                    return
                said = visit.stdout.read()
                if visit.returncode == 0:
                    self.visits += 1
                elif not any(reason in said for reason in NO_VISIT):
                    self.said = said


class HostileFlight(unittest.TestCase):
    def fly_among_them(self):
        with subprocess.Popen(COMMAND, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as flight:
            while not os.path.exists(SOCKET) and flight.poll() is None:
                pass
            visitors = [Visitor(kind, flight) for kind in VISITS]
            for v in visitors:
                v.others = visitors
                v.start()
            out, err = flight.communicate(timeout=300)
            for v in visitors:
                v.join()
        self.assertEqual(flight.returncode, 0, out + err)
        for v in visitors:
            self.assertEqual(v.said, "", v.kind)
        return hashes(out), {v.kind: v.visits for v in visitors}

    def test_changes_no_byte(self):
        done = subprocess.run(COMMAND, capture_output=True, text=True, timeout=300)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        in_peace = hashes(done.stdout)
        self.assertGreaterEqual(len(in_peace), 13)
        visits = dict.fromkeys(VISITS, 0)
        for _ in range(MOST_FLIGHTS):
            among_them, came = self.fly_among_them()
            self.assertEqual(among_them, in_peace)
            visits = {kind: visits[kind] + came[kind] for kind in visits}
            if all(visits.values()):
                break
        print(visits)
        self.assertTrue(all(visits.values()), f"who never finished during a flight: {visits}")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
