#!/usr/bin/env python3
"""What `sinew grab` costs the program whose pictures are taken, under Xvfb: figures of docs/grab.md.

usage: grab_bench.py BUILD ROOT [seconds a run [runs]]       BUILD: build/release, with sinew and grab_probe

The program is tests/grab/programs/bars_glx at 640x480, 60 frames a second; each run's processor time is the program's own.
Runs of one comparison alternate, since the machine changes from minute to minute.
"""
import os
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile

BUILD, ROOT = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
SECONDS = float(sys.argv[3]) if len(sys.argv) > 3 else 6
SINEW, PROBE = BUILD / "bin/sinew", BUILD / "tests/grab/grab_probe"
FPS, PAIRS = 60, int(sys.argv[4]) if len(sys.argv) > 4 else 5


def run(command, probe=None, read="direct", grabbed=True):
    """(processor seconds of the program and of its X and GL threads, seconds, peak memory in kB, frames) of one run."""
    time_file = WORK / "time"
    timed = ["/usr/bin/env", "python3", "-B", str(WORK / "timed.py"), str(time_file), *map(str, command)]
    if grabbed:
        timed = [str(SINEW), "grab", "--quiet", "--name", "bench", "--read", read, *timed]
    process = subprocess.Popen(timed, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    reader = None
    if probe:
        reader = subprocess.Popen(["sh", "-c", f"exec {PROBE} bench {probe}"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    said = process.communicate()[1]
    if reader:
        reader.terminate()  # a reader that has not enough waits for the program to come again
        reader.wait()
    cpu, memory = time_file.read_text().split()
    frames, seconds = re.search(r"frames (\d+) in ([\d.]+) s", said).groups()
    return float(cpu), float(seconds), int(memory), int(frames)


def percent(runs):
    return statistics.median(100 * cpu / seconds for cpu, seconds, _, _ in runs)


def main():
    global WORK
    WORK = pathlib.Path(tempfile.mkdtemp(prefix="sinew-grab-bench-"))
    os.environ["SINEW_RUN_DIR"] = str(WORK / "run")
    (WORK / "timed.py").write_text(
        "import resource, subprocess, sys\n"
        "code = subprocess.call(sys.argv[2:])\n"
        "u = resource.getrusage(resource.RUSAGE_CHILDREN)\n"
        "open(sys.argv[1], 'w').write(f'{u.ru_utime + u.ru_stime} {u.ru_maxrss}')\n"
        "sys.exit(code)\n")
    bars = WORK / "bars"
    subprocess.run(["gcc", "-O2", "-o", bars, ROOT / "tests/grab/programs/bars_glx.c", "-lGL", "-lX11"], check=True)
    read, write = os.pipe()
    display = subprocess.Popen(["Xvfb", "-displayfd", str(write), "-screen", "0", "1280x960x24"], pass_fds=[write],
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    os.close(write)
    os.environ["DISPLAY"] = ":" + os.fdopen(read).readline().strip()
    try:
        frames = int(FPS * SECONDS)
        paced = [bars, frames, FPS, 640, 480]
        asked = "100000 camera 30"
        ways = {"alone": {"grabbed": False},
                "bare glReadPixels, 30 Hz": {"grabbed": False, "extra": ["--read-every", 2]},
                "sinew grab, nobody asks": {},
                "sinew grab, camera 30 Hz, direct": {"probe": asked},
                "sinew grab, camera 30 Hz, buffered": {"probe": asked, "read": "buffered"}}
        runs = {name: [] for name in ways}
        for _ in range(PAIRS):
            for name, way in ways.items():
                way = dict(way)
                runs[name].append(run([*paced, *way.pop("extra", [])], **way))
        alone = percent(runs["alone"])
        print(f"640x480, {FPS} frames/s, {SECONDS:g} s a run, median of {PAIRS}: % of a core by the program, more than alone, peak memory")
        for name in ways:
            memory = statistics.median(r[2] for r in runs[name]) / 1000
            print(f"  {name:36} {percent(runs[name]):6.2f} %   {percent(runs[name]) - alone:+6.2f}   {memory:6.1f} MB")
        print("without a pause, every frame read; in turn: ms of the processor a frame, median (least), and frames a second")
        free = [bars, 600, 0, 640, 480]
        ways = {"alone": {"grabbed": False},
                "bare glReadPixels": {"grabbed": False, "extra": ["--read-every", 1]},
                "sinew grab, nobody asks": {},
                "sinew grab, camera 30 Hz": {"probe": "100000 camera 30"},
                "sinew grab, camera of all": {"probe": "100000 camera 0"}}
        runs = {name: [] for name in ways}
        for _ in range(PAIRS):
            for name, way in ways.items():
                way = dict(way)
                runs[name].append(run([*free, *way.pop("extra", [])], **way))
        for name, all_runs in runs.items():
            ms = [1000 * cpu / count for cpu, _, _, count in all_runs]
            rate = statistics.median(count / seconds for _, seconds, _, count in all_runs)
            print(f"  {name:36} {statistics.median(ms):7.3f} ({min(ms):.3f})   {rate:8.1f}")
    finally:
        display.terminate()
        display.wait()


if __name__ == "__main__":
    main()
