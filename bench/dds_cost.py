#!/usr/bin/env python3
"""What a team's radio by DDS costs: latency and processor time of a message of 200 B at 10 Hz between two processes, beside
bare Cyclone DDS (ddsperf) and a bare UDP socket in the same run; then memory and processor time of many participants.

usage: bench/dds_cost.py [--rounds 5] [--seconds 10] [--robots 2 10 40] [--build build/release]

Ours goes from a socket of packets into one sinew-net, by DDS into another, and out of its socket: the way of a robot's frame.
ddsperf's round trip is halved. All on the loopback interface, without multicast. Builds nothing: target sinew-net; needs
ddsperf (Debian: cyclonedds-tools).
"""
import argparse
import contextlib
import json
import os
import pathlib
import re
import shutil
import socket
import statistics
import struct
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
DOMAIN = 140 + os.getpid() % 60
TICK_HZ = os.sysconf("SC_CLK_TCK")
URI = ("<CycloneDDS><Domain><General><Interfaces><NetworkInterface name='lo'/></Interfaces><AllowMulticast>false"
       "</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex><Peers><Peer Address='127.0.0.1'/></Peers>"
       "</Discovery></Domain></CycloneDDS>")


def robot_file(folder, name, most):
    path = folder / f"{name}.toml"
    path.write_text(f"""robot = {{ name = "{name}", board = "linux" }}
[device.radio]
driver = "dds"
[net]
domain = {DOMAIN}
interfaces = ["lo"]
multicast = false
peers = ["127.0.0.1"]
most_on_a_machine = {max(most + 2, 8)}
""")
    return path


def packet(kind, payload=b""):  # docs/net.md
    return struct.pack("<BBHIIq", 1, kind, 0, 0, 0, 0) + payload


def connect(folder, name):
    end = time.monotonic() + 20
    while True:
        line = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        try:
            line.connect(str(folder / f"{name}.net"))
            return line
        except OSError:
            line.close()
            if time.monotonic() > end:
                raise
            time.sleep(0.05)


def status(folder, name):
    with connect(folder, name) as line:
        line.settimeout(10)
        line.send(packet(5))
        while (answer := line.recv(70000))[1] != 6:
            pass
        return json.loads(answer[20:])


def cpu_s(pids):
    total = 0
    for pid in pids:
        fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
        total += int(fields[11]) + int(fields[12])
    return total / TICK_HZ


def pss_kb(pid):
    text = pathlib.Path(f"/proc/{pid}/smaps_rollup").read_text()
    return int(re.search(r"^Pss: +(\d+)", text, re.M)[1])


def tree(pid):
    """A process and those that it started."""
    all_pids = [pid]
    for task in pathlib.Path(f"/proc/{pid}/task").iterdir():
        with contextlib.suppress(OSError):
            for child in (task / "children").read_text().split():
                all_pids += tree(int(child))
    return all_pids


def quantile(values, share):
    return sorted(values)[min(len(values) - 1, int(share * len(values)))]


class Programs:
    """sinew-net for each of some robots, until all see each other."""

    def __init__(self, build, folder, count):
        env = dict(os.environ, SINEW_RUN_DIR=str(folder))
        self.names = [f"r{i}" for i in range(1, count + 1)]
        self.folder = folder
        self.all = [subprocess.Popen([str(build / "bin/sinew-net"), str(robot_file(folder, n, count))], env=env,
                                     stderr=subprocess.DEVNULL, start_new_session=True)
                    for n in self.names]
        end = time.monotonic() + 60
        while any(len(status(folder, n).get("participants", [])) < count - 1 for n in self.names):
            if time.monotonic() > end:
                sys.exit(f"{count} programs do not find each other")
            time.sleep(0.2)

    def pids(self):
        return [pid for p in self.all for pid in tree(p.pid)]

    def end(self):
        for p in self.all:
            p.terminate()
        for p in self.all:
            p.wait(20)


def ours(build, seconds):
    """Latencies in us, and processor time of both programs per second."""
    with tempfile.TemporaryDirectory(prefix="sinew_dds_") as name:
        folder = pathlib.Path(name)
        programs = Programs(build, folder, 2)
        say, hear = connect(folder, "r1"), connect(folder, "r2")
        hear.send(packet(1))
        hear.settimeout(2)
        before, latency = cpu_s(programs.pids()), []
        for number in range(int(10 * seconds)):
            sent = time.monotonic_ns()
            say.send(packet(2, struct.pack("<q", number).ljust(200, b"\x07")))
            while True:
                got = hear.recv(2000)
                if got[1] == 3 and struct.unpack_from("<q", got, 20)[0] == number:
                    break
            latency.append((time.monotonic_ns() - sent) / 1e3)
            time.sleep(max(0, 0.1 - (time.monotonic_ns() - sent) / 1e9))
        used = (cpu_s(programs.pids()) - before) / seconds
        programs.end()
        return latency, used


def bare_udp(seconds):
    a, b = socket.socket(socket.AF_INET, socket.SOCK_DGRAM), socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    b.bind(("127.0.0.1", 0))
    a.connect(b.getsockname())
    latency = []
    for _ in range(int(10 * seconds)):
        sent = time.monotonic_ns()
        a.send(bytes(200))
        b.recv(2000)
        latency.append((time.monotonic_ns() - sent) / 1e3)
        time.sleep(0.1)
    return latency


def bare_dds(seconds):
    """Half of ddsperf's round trips, p50 and p99 in us, and processor time of both processes per second."""
    env = dict(os.environ, CYCLONEDDS_URI=URI)
    pong = subprocess.Popen(["ddsperf", "-i", str(DOMAIN + 1), "-Qrss:10000%", "-D", str(seconds + 4), "pong"], env=env,
                            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    ping = subprocess.Popen(["ddsperf", "-i", str(DOMAIN + 1), "-D", str(seconds + 2), "ping", "10Hz", "size", "200"], env=env,
                            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    time.sleep(2)
    before = cpu_s([ping.pid, pong.pid])
    time.sleep(seconds - 1)
    used = (cpu_s([ping.pid, pong.pid]) - before) / (seconds - 1)
    out = ping.communicate(timeout=seconds + 30)[0]
    pong.terminate()
    pong.wait()
    lines = re.findall(r"50% ([0-9.]+)us .*?99% ([0-9.]+)us", out)
    if not lines:
        sys.exit(f"ddsperf said no round trips:\n{out}")
    return [float(p50) / 2 for p50, _ in lines], [float(p99) / 2 for _, p99 in lines], used


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("--rounds", type=int, default=5)
    arguments.add_argument("--seconds", type=float, default=10)
    arguments.add_argument("--robots", type=int, nargs="*", default=[2, 10, 40])
    arguments.add_argument("--build", type=pathlib.Path, default=ROOT / "build/release")
    o = arguments.parse_args()
    if not shutil.which("ddsperf"):
        sys.exit("ddsperf is missing (Debian: cyclonedds-tools)")
    p50, p99, cpu, dds50, dds99, dds_cpu, udp50, udp99 = ([] for _ in range(8))
    for _ in range(o.rounds):
        latency, used = ours(o.build, o.seconds)
        p50.append(quantile(latency, 0.5)), p99.append(quantile(latency, 0.99)), cpu.append(used)
        half50, half99, used = bare_dds(o.seconds)
        dds50.append(statistics.median(half50)), dds99.append(max(half99)), dds_cpu.append(used)
        latency = bare_udp(o.seconds)
        udp50.append(quantile(latency, 0.5)), udp99.append(quantile(latency, 0.99))

    def row(name, a, b, c):
        print(f"{name:34} p50 {statistics.median(a):7.0f} us ({min(a):.0f} to {max(a):.0f})  p99 {statistics.median(b):7.0f} us"
              + (f"  processor {1e3 * statistics.median(c):.1f} ms/s" if c else ""))

    print(f"200 B at 10 Hz between two processes, {o.rounds} rounds of {o.seconds:g} s")
    row("robot to robot by two sinew-net", p50, p99, cpu)
    row("ddsperf, half a round trip", dds50, dds99, dds_cpu)
    row("a UDP socket to itself", udp50, udp99, [])
    for count in o.robots:
        with tempfile.TemporaryDirectory(prefix="sinew_dds_") as name:
            programs = Programs(o.build, pathlib.Path(name), count)
            time.sleep(3)
            before = cpu_s(programs.pids())
            time.sleep(o.seconds)
            pids = programs.pids()
            used = (cpu_s(pids) - before) / o.seconds
            memory = sum(pss_kb(pid) for pid in pids) / 1024
            print(f"{count:3} programs: {memory:.0f} MB in all (Pss), {memory / count:.1f} MB each; "
                  f"{1e3 * used:.0f} ms of a processor per second in all, {1e3 * used / count:.2f} each")
            programs.end()


if __name__ == "__main__":
    main()
