#!/usr/bin/env python3
"""How old a picture is that a viewer sees through the monitor over a thin link, and the values of a plot beside it.

usage: bench/thin_link.py [--relay] [--rate-kbps 2000] [--loss 0.05] [--delay-ms 25] [--seconds 30] [--runs 3] [--build build/release]

The link is tests/net/lossy_link: two network namespaces, a rate, a delay and a loss for each direction. The robot is
tests/monitor/monitor_robot with a camera of 640x480 at 30 Hz. With --relay the viewer asks a monitor of its own machine,
which relays the one beyond the link. Needs the packages of tests/monitor/others. Prints a line of
JSON for each run; exit 77: skipped, with the reason.
"""
import argparse
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
OTHERS = ROOT / "tests/monitor/others"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--relay", action="store_true")
    parser.add_argument("--rate-kbps", type=float, default=2000)
    parser.add_argument("--loss", type=float, default=0.05)
    parser.add_argument("--delay-ms", type=float, default=25)
    parser.add_argument("--queue-ms", type=float, default=200)
    parser.add_argument("--seconds", type=int, default=30)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--camera", nargs=3, default=["640", "480", "30"])
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build/release")
    o = parser.parse_args()
    if not shutil.which("node") or not (OTHERS / "node_modules/ws").is_dir():
        print("skipped: node, or the packages of tests/monitor/others (tools/setup.sh test)")
        return 77
    for run in range(o.runs):
        with tempfile.TemporaryDirectory() as folder:
            env = {**os.environ, "SINEW_RUN_DIR": folder}
            robot = subprocess.Popen([o.build / "tests/monitor/monitor_robot", "thin", "--camera", *o.camera],
                                     stdout=subprocess.PIPE, text=True, env=env)
            robot.stdout.readline()
            wait = ("until node -e 'require(\"net\").connect(8080,\"10.77.0.1\").on(\"connect\",()=>process.exit(0))"
                    ".on(\"error\",()=>process.exit(1))' 2>/dev/null; do sleep 0.2; done; exec \"$@\"")
            own = []
            url = "ws://10.77.0.1:8080/thin"
            if o.relay:  # ends with the link's second machine
                own = ["sh", "-c", '"$0" --port 8081 --quiet --with 10.77.0.1:8080 & own=$!; "$@"; code=$?; '
                       "kill $own; exit $code", o.build / "bin/sinew-monitor"]
                url = "ws://127.0.0.1:8081/at/10.77.0.1:8080/thin"
            link = [o.build / "tests/net/lossy_link", "--rate-kbps", str(o.rate_kbps), "--loss", str(o.loss),
                    "--delay-ms", str(o.delay_ms), "--queue-ms", str(o.queue_ms), "--seed", str(run + 1), "--",
                    o.build / "bin/sinew-monitor", "--address", "10.77.0.1", "--quiet", "---", *own, "sh", "-c", wait,
                    "sh", "node", OTHERS / "thin_link.mjs", url, "/camera.raw/jpeg", "/counter.range",
                    str(o.seconds)]
            done = subprocess.run(list(map(str, link)), stdout=subprocess.PIPE, text=True, env=env)
            robot.terminate()
            robot.wait()
        if done.returncode != 0:
            return done.returncode
        print(done.stdout.strip(), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
