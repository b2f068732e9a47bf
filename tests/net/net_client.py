"""A robot's end of its sinew-net: the packets of docs/net.md."""
import json
import os
import socket
import struct
import time

LIMIT_S = 30
HELLO, SAY, HEARD, ASK = 1, 2, 3, 5
HEAD_BYTES = 20


def packet(kind, payload=b""):
    return struct.pack("<BBHIIq", 1, kind, 0, 0, 0, 0) + payload


def connect(robot):
    """A socket to the robot's program, as soon as it is there."""
    end = time.monotonic() + LIMIT_S
    while True:
        line = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        line.settimeout(0.1)
        try:
            line.connect(f"{os.environ['SINEW_RUN_DIR']}/{robot}.net")
            return line
        except OSError:
            line.close()
            if time.monotonic() > end:
                raise
            time.sleep(0.02)


def status(robot):
    with connect(robot) as line:
        line.settimeout(5)
        line.send(packet(ASK))
        return json.loads(line.recv(70000)[HEAD_BYTES:])


class Checks:
    """For a unittest.TestCase."""

    def assert_flows(self, there, here):
        """What `there` says arrives at `here`, from some time on, whichever of them begins anew meanwhile."""
        end = time.monotonic() + LIMIT_S
        while time.monotonic() < end:
            try:
                with connect(there) as speaker, connect(here) as listener:
                    listener.send(packet(HELLO))
                    for _ in range(20):
                        speaker.send(packet(SAY, b"hello"))
                        try:
                            got = listener.recv(4096)
                        except TimeoutError:
                            continue
                        if len(got) < HEAD_BYTES:
                            break
                        if got[1] == HEARD and got[HEAD_BYTES:] == b"hello":
                            return
            except OSError:
                pass
            time.sleep(0.05)
        self.fail(f"nothing of {there} arrives at {here}")

    def assert_becomes(self, robot, test):
        """The status of the robot's program passes `test`; returns it."""
        end = time.monotonic() + LIMIT_S
        seen = None
        while time.monotonic() < end:
            try:
                seen = status(robot)
                if test(seen):
                    return seen
            except OSError:
                pass
            time.sleep(0.05)
        self.fail(json.dumps(seen, indent=1))
