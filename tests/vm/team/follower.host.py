#!/usr/bin/env python3
"""The host's part of follower.sh: the world, the robot `scout`, and the verdict on what both robots recorded.

usage: follower.host.py BUILD SHARED GUEST_PORT    started by boot.sh before the guest
       SHARED: folder that the guest sees, too; GUEST_PORT: UDP port of this host that qemu passes on to the guest
"""
import json
import os
import pathlib
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time

BUILD, SHARED = (pathlib.Path(a) for a in sys.argv[1:3])
GUEST_PORT = int(sys.argv[3])
HERE = pathlib.Path(__file__).resolve().parent
SINEW = BUILD / "bin/sinew"
RATE = 0.4   # of life's pace: an emulated processor has to keep up with 1000 samples in a second of the robots
MOST_S = 60  # of the robots' time; both have landed after 27
PLACES = ["--start-x=scout=0.9", "--start-y=scout=0.3", "--start-yaw=scout=0", "--land-y=scout=-0.5",  # robots/team
          "--start-x=follower=-1.1", "--start-y=follower=-0.9", "--start-yaw=follower=0", "--land-y=follower=0.5"]
DRIFT = 100e-6  # no two clocks of the test drift apart faster


def wait_for(found, seconds, what):
    until = time.monotonic() + seconds
    while not (value := found()):
        if time.monotonic() > until:
            raise TimeoutError(f"{what}: not within {seconds} s")
        time.sleep(0.05)
    return value


def give(name, text):
    """A file that the guest sees only as a whole."""
    (SHARED / f"{name}.new").write_text(text)
    (SHARED / f"{name}.new").rename(SHARED / name)


def free_udp_port():
    with socket.socket(type=socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def echo(topic, file):
    done = subprocess.run([SINEW, "topic", "echo", topic, "--file", file, "--json"], capture_output=True, text=True,
                          check=True)
    return [json.loads(line) for line in done.stdout.splitlines()]


class Flight:
    """The world and the scout, from the guest's call to their end."""

    def __init__(self, folder):
        self.folder, self.started = folder, {}
        self.env = dict(os.environ, SINEW_RUN_DIR=str(folder), TMPDIR=str(folder), LP_NUM_THREADS="1")
        self.env.pop("SINEW_RECORD", None)

    def start(self, name, *command):
        with open(self.folder / f"{name}.txt", "w") as log:
            self.started[name] = subprocess.Popen(command, stdout=log, stderr=subprocess.STDOUT, env=self.env,
                                                  cwd=self.folder)

    def log(self, name):
        return (self.folder / f"{name}.txt").read_text()

    def port(self):
        if self.started["world"].poll() is not None:
            raise RuntimeError("the world ended before it began")
        return re.search(r"tcp:127\.0\.0\.1:(\d+)", self.log("world"))

    def fly(self):
        self.start("world", BUILD / "bin/sinew-sim", "--listen", "tcp:127.0.0.1:0", "--free", "--robot", "scout",
                   "--robot", "follower", *PLACES, "--seed", "4", "--camera", "160x120", "--report", "world.json",
                   "--wait", "60")
        port = wait_for(self.port, 30, "the world's port")[1]
        scout_port = free_udp_port()
        both = ["--rate", str(RATE), "--duration", str(MOST_S)]
        self.start("scout", SINEW, "run", HERE / "scout.toml", "--plant", f"tcp:127.0.0.1:{port}", "--board-of",
                   "radio=linux", "--set", f"device.radio.port={scout_port}",
                   "--set", f"device.radio.peers=127.0.0.1:{GUEST_PORT}", *both, "--runs", "runs", "--json")
        give("world", f"plant_port={port} scout_port={scout_port} arguments=({' '.join(both)})\n")
        for name, process in self.started.items():
            wait_for(lambda p=process: p.poll() is not None, MOST_S / RATE + 20, f"the end of the {name}")
        wait_for((SHARED / "follower.json").exists, 30, "the follower's report")

    def end(self):
        for process in self.started.values():
            process.terminate()
        for process in self.started.values():
            try:
                process.wait(5)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


class Verdict:
    """What has to be so, with what was seen."""

    def __init__(self):
        self.lines, self.good = [], True

    def claim(self, ok, text):
        self.lines.append(f"{'ok' if ok else 'FAILED'}: {text}")
        self.good = self.good and bool(ok)

    def __str__(self):
        return "\n".join(self.lines + ["good" if self.good else "bad", ""])


class Evidence:
    """Of one robot: what it recorded, and the summary of its run."""

    def __init__(self, name, file, summary):
        self.name, self.file, self.summary = name, file, summary
        states = [m["message"] for m in echo("mates.state", file)]
        self.states = [s for s in states if s["mate"][0]["clock_bound_ns"] >= 0]  # with a clock
        if not self.states:
            raise RuntimeError(f"{name} never knew its mate's clock; of {len(states)} states the last is {states[-1:]}")
        self.last = self.states[-1]
        self.mate = self.last["mate"][0]


def judge_hearing(robots, verdict):
    for robot in robots:
        verdict.claim(robot.mate["frames"] > 100,
                      f"{robot.name} heard {robot.mate['frames']} frames of its mate; {robot.mate['lost']} did not come")
        verdict.claim(robot.last["garbage"] == robot.last["strangers"] == robot.mate["foreign"] == 0,
                      f"{robot.name} heard nobody else, and nothing of another build")
    messages = robots[1].mate["messages"]
    verdict.claim(messages > 50, f"the follower read {messages} messages of the scout")


def judge_clocks(scout, follower, verdict):
    """The truth is what each has found out about the time of the world, over another connection."""
    truth_ns = 1e9 * (follower.summary["world_offset_s"] - scout.summary["world_offset_s"])
    truth_bound_ns = 1e9 * (follower.summary["clock_bound_s"] + scout.summary["clock_bound_s"])
    verdict.claim(abs(truth_ns) > 5e9, f"their clocks are {abs(truth_ns) / 1e9:.3f} s apart, by the time of their world, "
                  f"which they know to {truth_bound_ns / 1e6:.3f} ms")
    drift_ns = DRIFT * (follower.last["stamp"] - follower.states[0]["stamp"])  # the truth is that of the end
    for robot, truth in ((scout, -truth_ns), (follower, truth_ns)):
        mates = [state["mate"][0] for state in robot.states]
        wrong_ns = [abs(mate["clock_offset_ns"] - truth) for mate in mates]
        outside = sum(wrong > mate["clock_bound_ns"] + truth_bound_ns + drift_ns for wrong, mate in zip(wrong_ns, mates))
        verdict.claim(outside == 0, f"{robot.name} was wrong about that by at most {max(wrong_ns) / 1e6:.3f} ms; {outside} of "
                      f"{len(mates)} times by more than its bound, in the end {robot.mate['clock_bound_ns'] / 1e6:.3f} ms")
    return truth_ns


def judge_pad(scout, follower, truth_ns, verdict):
    """The scout's pad, read by the follower as if it were its own: the same messages, on the follower's clock."""
    said = {m["message"]["stamp"]: m["message"]["p_m"] for m in echo("locator.pad", scout.file)}
    heard = echo("scout/locator.pad", follower.file)
    verdict.claim(len(heard) > 10, f"the follower's scout/locator.pad has {len(heard)} messages")
    others, beside_ns = 0, 0
    for message in (m["message"] for m in heard):
        there = message["stamp"] - truth_ns
        stamp = min(said, key=lambda one: abs(one - there))
        others += said[stamp] != message["p_m"]
        beside_ns = max(beside_ns, abs(stamp - there))
    verdict.claim(others == 0, "each is one of the scout's, with the same place")
    verdict.claim(beside_ns < 10e6, f"and its stamp is the scout's, at most {beside_ns / 1e6:.3f} ms off")
    ages_s = [(m["published_ns"] - m["message"]["stamp"]) / 1e9 for m in heard]
    verdict.claim(0 <= min(ages_s) and max(ages_s) < 1.5, f"they came {min(ages_s):.3f} to {max(ages_s):.3f} s old")


def judge_flights(robots, world, verdict):
    for robot in robots:
        report = world[robot.name]
        verdict.claim(report["verdict"]["good"], f"{robot.name}: {report['verdict']['outcome']} at "
                      f"{report.get('touchdown_s')} s, {report.get('landing_error_m', 0):.3f} m off")
        verdict.claim(report["radio"]["sent"] == 0, f"{robot.name} said nothing into the world's air")
    touchdowns = [world[robot.name]["touchdown_s"] for robot in robots]
    verdict.claim(touchdowns == sorted(touchdowns), "one after the other")


def judge(flight, guest_clock, verdict):
    ahead_days = (guest_clock - time.time()) / 86400
    verdict.claim(abs(ahead_days) > 365, f"the guest's calendar is {ahead_days:.0f} days ahead")
    (scout_file,) = flight.folder.glob("runs/scout-*/run.mcap")
    world = json.loads((flight.folder / "world.json").read_text())["robots"]
    scout = Evidence("scout", scout_file, json.loads(flight.log("scout").splitlines()[-1]))
    follower = Evidence("follower", SHARED / "follower.mcap", json.loads((SHARED / "follower.json").read_text()))
    judge_hearing((scout, follower), verdict)
    judge_pad(scout, follower, judge_clocks(scout, follower, verdict), verdict)
    judge_flights((scout, follower), world, verdict)
    replay = subprocess.run([SINEW, "replay", follower.file], capture_output=True, text=True)
    verdict.claim(replay.returncode == 0, f"the guest's run, executed again here: {replay.stdout.strip()}{replay.stderr}")


def main():
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # so that what runs here ends, too
    call = SHARED / "guest_clock"
    while not call.exists():  # boot.sh ends this part when the guest ends
        time.sleep(0.05)
    with tempfile.TemporaryDirectory(prefix="sinew-") as folder:
        flight, verdict = Flight(pathlib.Path(folder)), Verdict()
        try:
            flight.fly()
            judge(flight, int(call.read_text()), verdict)
        except Exception as e:  # whatever it is, the guest has to hear of it
            verdict.claim(False, repr(e))
        finally:
            flight.end()
            for name in flight.started:
                print(f"---- {name}\n{flight.log(name)}")
            give("verdict", str(verdict))


main()
