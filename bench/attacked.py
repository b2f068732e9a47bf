#!/usr/bin/env python3
"""How late a flying robot's control thread is while programs attack its monitor, beside as many that only look.

usage: bench/attacked.py [--pairs 15] [--seconds 1] [--connections 48] [--build build/release]

The quadrotor flies in real time with its loop of 1 kHz; lateness is that of the loop's releases, from the robot's time line.
Both loads have as many connections and make as many calls a second. Those who attack do what tests/monitor/attack_test.cpp
does: connections that say nothing, requests that never end, heads and bodies that are too long, movies that nobody reads,
wrong tokens, garbage. One ratio of p50 and of p99 a pair, in alternating order; goal 1.2 for both. Builds nothing: targets sinew,
sinew-sim, sinew-monitor. Exit code 1: a goal is clearly missed.
"""
import argparse
import itertools
import pathlib
import select
import socket
import statistics
import subprocess
import sys
import time

from monitor_rig import ROOT, Site, lateness_us, processor_ns, quantile, report_lateness

GOAL = 1.2


def calls(kind, host):
    """What the connections say, in turn."""
    def get(path, more=""):
        return f"GET {path} HTTP/1.1\r\nHost: {host}\r\n{more}\r\n".encode()
    if kind == "looks":
        return [get("/api/robots"), get("/api/robots/quad/status"), get("/"), get("/quad/images/camera.raw.jpg")]
    return [b"", b"GET /api/robots HTTP/1.1\r\nX-A: b\r\n", get("/", "X-Long: " + "x" * 16000 + "\r\n"),
            f"POST /api/robots/quad/stop HTTP/1.1\r\nHost: {host}\r\nContent-Length: 1048576\r\n\r\n".encode() + b"x" * 65536,
            get("/quad/images/camera.raw.mjpg"), get("/quad?token=wrong", "Upgrade: websocket\r\nConnection: Upgrade\r\n"
                                                     "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n"),
            b"\x00\xff" * 2000, get("/%2e%2e/%2e%2e/etc/passwd"), f"BREW / HTTP/9.9\r\nHost: {host}\r\n\r\n".encode()]


def be_load(kind, port, connections, rate=400):
    """`rate` calls a second over so many connections, until it is killed. Those who look read; the others do not."""
    said = itertools.cycle(calls(kind, f"127.0.0.1:{port}"))
    links = []
    begin, done = time.monotonic(), 0
    while True:
        if len(links) >= connections:
            links.pop(0).close()
        link = socket.socket()
        link.bind(("127.0.0.2", 0))
        link.setblocking(False)
        link.connect_ex(("127.0.0.1", port))
        links.append(link)
        select.select([], [link], [], 0.1)
        try:
            link.send(next(said))
        except OSError:
            pass
        if kind == "looks":
            for ready in select.select(links, [], [], 0)[0]:
                try:
                    ready.recv(1 << 16)
                except OSError:
                    pass
        done += 1
        time.sleep(max(0, begin + done / rate - time.monotonic()))


class Flights:
    """A robot that flies: the next one, where the present one has landed."""

    def __init__(self, build):
        self.build, self.site = build, None

    def flying(self, seconds):
        if self.site and time.monotonic() + seconds > self.until:
            self.end()
        if not self.site:
            self.site = Site(self.build, [self.build / "bin/sinew", "run", ROOT / "robots/quad/quad.toml", "--no-record", "--plain"],
                             "quad", ready="socket")
            time.sleep(1)
            self.until = time.monotonic() + FLIGHT_S
        return self.site

    def end(self):
        if self.site:
            self.site.__exit__()
        self.site = None


FLIGHT_S = 9  # a flight of the quadrotor takes longer


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pairs", type=int, default=15)
    parser.add_argument("--seconds", type=float, default=1)
    parser.add_argument("--connections", type=int, default=48)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build/release")
    parser.add_argument("--load", nargs=2, help=argparse.SUPPRESS)
    o = parser.parse_args()
    if o.load:
        be_load(o.load[0], int(o.load[1]), o.connections)
    flights, found = Flights(o.build), {"looks": [], "attacks": []}
    shares = {"looks": [], "attacks": []}
    try:
        for pair in range(o.pairs):
            site = flights.flying(2 * (o.seconds + 0.7))
            for kind in ("looks", "attacks") if pair % 2 == 0 else ("attacks", "looks"):
                load = subprocess.Popen([sys.executable, __file__, "--connections", str(o.connections), "--load", kind, str(site.port)],
                                        stderr=subprocess.DEVNULL)
                time.sleep(0.5)
                before = processor_ns(site.monitor.pid)
                time.sleep(o.seconds)
                late = lateness_us(site.folder.name, "quad", o.seconds)
                shares[kind].append((processor_ns(site.monitor.pid) - before) / 1e7 / o.seconds)
                load.kill()
                load.wait()
                found[kind].append((quantile(late, 0.5), quantile(late, 0.99), len(late)))
                time.sleep(0.2)
    finally:
        flights.end()
    takes = {kind: f"; the monitor takes {statistics.median(all_turns):.1f} % of a core" for kind, all_turns in shares.items()}
    return 0 if report_lateness("attacked_{}_beside_lookers", found, "attacks", "looks", GOAL, takes) else 1


if __name__ == "__main__":
    sys.exit(main())
