#!/usr/bin/env python3
"""Processor time of the monitor's movies over HTTP, for each picture, beside ustreamer's of the same pictures.

usage: bench/movie_cost.py [--pairs 9] [--seconds 4] [--scene discs|squares] [--build build/release]

Both get pictures of 640x480 yuyv at 30 Hz (bench/camera_scene.hpp), ustreamer by bench/v4l2_stand_in.cpp, and make
JPEGs of quality 80. The turns are alternated; ustreamer goes on without viewers during ours. Needs Debian's ustreamer; builds nothing:
targets
sinew-monitor, monitor_robot, v4l2_stand_in, jpeg_floor. Exit code 1: a goal is clearly missed; 77: skipped, with the reason.
"""
import argparse
import os
import pathlib
import shutil
import statistics
import subprocess
import sys
import time

from monitor_rig import Movie, ROOT, Site, memory_kb, processor_ns, report, report_figure

PORT = 18181


def sampling(movie):
    """4:2:0, 4:2:2, ... of the first picture that came."""
    at = movie.first.find(b"\xff\xc0")
    h, v = movie.first[at + 11] >> 4, movie.first[at + 11] & 15
    return {(2, 2): "4:2:0", (2, 1): "4:2:2", (1, 1): "4:4:4"}.get((h, v), f"{h}x{v}")


def turn(pid, port, path, viewers, seconds):
    """Microseconds of the process for each picture of the camera, pictures a second and viewer, bytes a picture."""
    movies = [Movie(port, path) for _ in range(viewers)]
    time.sleep(0.5)
    begin = time.monotonic()
    before, pictures, size = processor_ns(pid), [m.pictures for m in movies], movies[0].bytes
    time.sleep(seconds)
    used = processor_ns(pid) - before
    got = [m.pictures - p for m, p in zip(movies, pictures)]
    rate = statistics.mean(got) / (time.monotonic() - begin)
    size = (movies[0].bytes - size) / max(got[0], 1)
    for m in movies:
        m.stop()
    return {"us": used / 1e3 / max(statistics.mean(got), 1), "rate": rate, "bytes": size,
            "share": used / 1e7 / seconds, "sampling": sampling(movies[0])}


def floor_us(build, seconds, options):
    """Of libjpeg-turbo alone."""
    said = subprocess.run([build / "bench/jpeg_floor", str(max(1, round(seconds))), *options], stdout=subprocess.PIPE, text=True,
                          check=True).stdout
    return float(said.split()[0])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pairs", type=int, default=9)
    parser.add_argument("--seconds", type=float, default=4)
    parser.add_argument("--scene", choices=["discs", "squares"], default="discs", help="squares: much noise")
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build/release")
    o = parser.parse_args()
    if not shutil.which("ustreamer"):
        print("movie_cost: skipped, ustreamer is not installed")
        return 77
    robot = [o.build / "tests/monitor/monitor_robot", "movie", "--camera", "640", "480", "30"]
    if o.scene == "discs":
        robot.append("--discs")
        os.environ["SINEW_DISCS"] = "1"
    turns = {name: [] for name in ("ustreamer", "420", "422", "four")}
    floors = []
    squares = ["--squares"] if o.scene == "squares" else []
    with Site(o.build, robot, "movie") as site:
        env = {**os.environ, "LD_PRELOAD": str(o.build / "bench/libv4l2_stand_in.so")}
        streamer = subprocess.Popen(
            ["ustreamer", "--device", "/dev/video0", "--format", "YUYV", "--encoder", "CPU", "--workers", "1", "--quality", "80",
             "--resolution", "640x480", "--desired-fps", "30", "--host", "127.0.0.1", "--port", str(PORT)],
            env=env, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            time.sleep(3)
            if streamer.poll() is not None:
                print("movie_cost: skipped, ustreamer does not run here")
                return 77

            def theirs():
                turns["ustreamer"].append(turn(streamer.pid, PORT, "/stream", 1, o.seconds))

            def ours(name, viewers, query):
                path = f"/movie/images/camera.raw.mjpg?quality=80&{query}"
                turns[name].append(turn(site.monitor.pid, site.port, path, viewers, o.seconds))

            for pair in range(o.pairs):
                steps = [theirs, lambda: ours("420", 1, "chroma=420"), lambda: ours("four", 4, "chroma=420"),
                         lambda: ours("422", 1, "chroma=422"),
                         lambda: floors.append(floor_us(o.build, o.seconds, squares))]
                for step in steps if pair % 2 == 0 else reversed(steps):
                    step()
            memory = memory_kb(site.monitor.pid)
        finally:
            streamer.terminate()
            streamer.wait()
    for name, all_turns in turns.items():
        middle = {key: statistics.median(t[key] for t in all_turns) for key in ("us", "rate", "bytes", "share")}
        print(f"  {name:<10} {middle['us']:7.0f} us a picture, {middle['rate']:.1f} pictures/s, {middle['bytes'] / 1e3:.1f} kB,"
              f" {middle['share']:.2f} % of a core, {all_turns[0]['sampling']}")

    def ratios(a, b):
        return [x["us"] / y["us"] for x, y in zip(turns[a], turns[b])]
    print(f"  {'floor':<10} {statistics.median(floors):7.0f} us a picture: libjpeg-turbo alone, 4:2:0, at 30 Hz")
    floor = [f / t["us"] for f, t in zip(floors, turns["ustreamer"])]
    report("libjpeg-turbo alone / ustreamer", floor, 0)
    report("movie 4:2:0 / libjpeg-turbo alone", [t["us"] / f for t, f in zip(turns["420"], floors)], 0)
    good = report("movie 4:2:0 / ustreamer", ratios("420", "ustreamer"), 0.30)
    report("movie 4:2:2 / ustreamer", ratios("422", "ustreamer"), 0)
    good &= report("four viewers / one", ratios("four", "420"), 1.2)
    good &= report_figure("movie of 30 pictures/s", statistics.median(t["share"] for t in turns["420"]), 5, "% of a core")
    own = memory["RssAnon"] + memory["RssShmem"]
    good &= report_figure("memory of the monitor", own / 1e3, 10, "MB of its own and the robot's")
    print("  resident: " + ", ".join(f"{name} {kb / 1e3:.1f} MB" for name, kb in memory.items()))
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
