#!/usr/bin/env python3
"""How late a flying robot's control thread is while its radio is flooded, beside the same flood at a port that nobody has.

usage: bench/radio_flood.py [--pairs 15] [--seconds 2] [--build build/release]

The quadrotor flies in real time with its loop of 1 kHz, a [team] and a radio on the loopback interface; lateness is that of
the loop's releases, from the robot's time line. The flood is datagrams of 200 bytes as fast as one thread sends them: junk,
frames of another team, frames of strangers, and frames that a mate could have sent. One ratio of p50 and of p99 a pair, in
alternating order; goal 1.2 for both. Builds nothing: targets sinew, sinew-sim. Exit code 1: a goal is clearly missed.
"""
import argparse
import os
import pathlib
import socket
import statistics
import struct
import subprocess
import sys
import tempfile
import time

from monitor_rig import ROOT, lateness_us, quantile, report_lateness

GOAL = 1.2
FLIGHT_S = 12  # a flight of the quadrotor takes longer
GROUPS = {"owned": f"239.72.9.{os.getpid() % 250 + 1}:45811", "unowned": f"239.72.9.{os.getpid() % 250 + 1}:45812"}
ROBOT = f"""
extends = "{ROOT}/robots/quad/quad.toml"
[robot]
name = "flooded"
device_boards = {{ radio = "linux" }}
[[thread]]
name = "team"
priority = 20
period_us = 20000
order = ["mates"]
[team]
robot = 1
team = 7
members = {{ mate = 2 }}
say."filter.state" = {{ rate_hz = 10 }}
exec_us = 50
[device.radio]
driver = "udp"
interface = "lo"
group = "{GROUPS['owned']}"
"""


def flood(group):
    """Until it is killed. Prints how many datagrams it has sent, after each thousand."""
    address, _, port = group.partition(":")
    to = (address, int(port))
    link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    link.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton("127.0.0.1"))

    def frame(team, robot, sequence):  # docs/team-protocol.md
        topic, content = b"filter.state", b"\x00\x01\x00\x00".ljust(200 - 32 - 19 - 12, b"\x07")
        return (struct.pack("<IBBBBHHIIIq", 0x54574E53, 1, 0, 1, 0, robot, 0, team, 1, sequence, time.monotonic_ns()) +
                struct.pack("<BHIIq", len(topic), len(content), 99, sequence, 5) + topic + content)
    sequence = 0
    while True:
        for _ in range(1000):
            kind = sequence % 4
            link.sendto(os.urandom(200) if kind == 0 else frame(8 if kind == 1 else 7, 9 if kind == 2 else 2, sequence), to)
            sequence += 1
        print(sequence, flush=True)


class Flight:
    """A robot that flies: the next one, where the present one lands."""

    def __init__(self, build):
        self.build, self.robot = build, None
        self.folder = tempfile.TemporaryDirectory()
        self.file = pathlib.Path(self.folder.name) / "flooded.toml"
        self.file.write_text(ROBOT)

    def flying(self, seconds):
        if self.robot and time.monotonic() + seconds > self.until:
            self.end()
        if not self.robot:
            env = {**os.environ, "SINEW_RUN_DIR": self.folder.name}
            self.robot = subprocess.Popen([self.build / "bin/sinew", "run", self.file, "--no-record", "--plain"], env=env,
                                          stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, stdin=subprocess.DEVNULL)
            while not (pathlib.Path(self.folder.name) / "flooded.sock").exists():
                if self.robot.poll() is not None:
                    raise SystemExit(f"the robot ended with {self.robot.returncode}: sinew run {self.file}")
                time.sleep(0.1)
            time.sleep(1)
            self.until = time.monotonic() + FLIGHT_S

    def end(self):
        if self.robot:
            self.robot.terminate()
            self.robot.wait()
        self.robot = None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pairs", type=int, default=15)
    parser.add_argument("--seconds", type=float, default=2)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build/release")
    parser.add_argument("--flood", help=argparse.SUPPRESS)
    o = parser.parse_args()
    if o.flood:
        flood(o.flood)
    flight, found, sent = Flight(o.build), {"owned": [], "unowned": []}, []
    try:
        for pair in range(o.pairs):
            flight.flying(2 * (o.seconds + 0.7))
            for kind in ("owned", "unowned") if pair % 2 == 0 else ("unowned", "owned"):
                load = subprocess.Popen([sys.executable, __file__, "--flood", GROUPS[kind]], stdout=subprocess.PIPE, text=True)
                time.sleep(0.5 + o.seconds)
                late = lateness_us(flight.folder.name, "flooded", o.seconds)
                load.kill()
                told = load.stdout.read().split()
                sent.append(int(told[-1]) / (o.seconds + 0.5) if told else 0)
                load.wait()
                found[kind].append((quantile(late, 0.5), quantile(late, 0.99), len(late)))
                time.sleep(0.2)
    finally:
        flight.end()
    print(f"  {statistics.median(sent):.0f} datagrams a second")
    return 0 if report_lateness("radio_flood_{}", found, "owned", "unowned", GOAL) else 1


if __name__ == "__main__":
    sys.exit(main())
