#!/usr/bin/env python3
"""What the monitor takes beside a robot that flies in real time: nobody looks, a page's subscriptions, a page in a browser.

usage: bench/monitor_cost.py [--seconds 5] [--rounds 3] [--build build/release]

The quadrotor flies with a camera of 640x480 (robots/quad/quad.toml, no recording); each round is a flight of its own. The
subscriptions are those of the page's first view: pictures, state, IMU, motors, status five times a second. With chromium
installed the page itself is opened as well. Medians over the rounds: processor time of the monitor and of the robot as a
share of one core, and the monitor's resident memory. Builds nothing: targets sinew, sinew-sim, sinew-monitor.
"""
import argparse
import pathlib
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

from monitor_rig import ROOT, Movie, Site, WebSocket, ask, memory_kb, processor_ns

TOPICS = {"/camera.raw/jpeg", "/pad.sighting", "/filter.state", "/imu.raw", "/mixer.motors", "/guardian.state", "/range.raw",
          "/sinew/status"}


class Browser:
    """Chromium with the page, without a window."""

    def __init__(self, port):
        self.folder = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)  # its children may still write
        self.process = subprocess.Popen(
            ["chromium", "--headless=new", "--no-sandbox", "--disable-gpu", "--remote-debugging-port=0", "--no-first-run",
             f"--user-data-dir={self.folder.name}", "--window-size=1600,1000", f"http://127.0.0.1:{port}/"],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        time.sleep(4)

    def stop(self):
        self.process.terminate()
        self.process.wait()
        self.folder.cleanup()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=5)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build/release")
    o = parser.parse_args()
    loads = {
        "nobody looks": lambda port: None,
        "a page's subscriptions": lambda port: WebSocket(port, "/quad", TOPICS),
        "two pages' subscriptions": lambda port: [WebSocket(port, "/quad", TOPICS), WebSocket(port, "/quad", TOPICS)],
        "every topic": lambda port: WebSocket(port, "/quad", None),
        "a movie over HTTP": lambda port: Movie(port, "/quad/images/camera.raw.mjpg"),
    }
    if shutil.which("chromium"):
        loads["the page in chromium"] = Browser
    robot = [o.build / "bin/sinew", "run", ROOT / "robots/quad/quad.toml", "--camera", "640x480", "--no-record", "--plain"]
    print(f"{'':<26} {'monitor':>9} {'robot':>9}   resident: all, own, of files, shared with the robot")
    for name, begin in loads.items():
        found = []
        for _ in range(o.rounds):
            with Site(o.build, robot, "quad", ready="socket") as site:
                time.sleep(1.5)
                load = begin(site.port)
                time.sleep(1)
                flies = ask(site.folder.name, "quad", "hello")["pid"]
                before = processor_ns(site.monitor.pid), processor_ns(flies), time.monotonic()
                time.sleep(o.seconds)
                after = processor_ns(site.monitor.pid), processor_ns(flies), time.monotonic()
                memory = memory_kb(site.monitor.pid)
                for one in load if isinstance(load, list) else [load] if load else []:
                    one.stop()
                if site.robot.poll() is not None:
                    print("the robot ended early")
                    return 1
            wall = (after[2] - before[2]) * 1e7
            found.append([(a - b) / wall for a, b in zip(after[:2], before[:2])] + [memory[k] / 1e3 for k in (
                "VmRSS", "RssAnon", "RssFile", "RssShmem")])
            if isinstance(load, WebSocket):
                counts = {topic: round(n / (o.seconds + 1)) for topic, n in sorted(load.counts.items())}
        middle = [statistics.median(column) for column in zip(*found)]
        print(f"{name:<26} {middle[0]:7.2f} % {middle[1]:7.2f} %   " + ", ".join(f"{mb:.1f} MB" for mb in middle[2:]), flush=True)
        if name == "a page's subscriptions":
            print("  messages/s: " + ", ".join(f"{topic} {n}" for topic, n in counts.items()))
    return 0


if __name__ == "__main__":
    sys.exit(main())
