#!/usr/bin/env python3
"""Viewers of others see a robot through the monitor: the npm client of the Foxglove protocol, and one written from the
specification of its newer name.

usage: others_viewer_test.py MONITOR SINEW ROBOT TEST.mjs [FLIGHT.toml]      exit 77: skipped, with the reason

A second of FLIGHT is recorded, and stands up as a robot.

The npm packages are pinned in others/package-lock.json; tools/setup.sh installs them.
"""
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
SKIPPED = 77


def reason_to_skip():
    if not shutil.which("node"):
        return "node is not installed"
    if not (HERE / "others/node_modules/@foxglove/ws-protocol").is_dir():
        return "the packages of tests/monitor/others are not installed (npm ci there, or tools/setup.sh test)"
    return None


def record(sinew, flight, folder):
    """The file of one second of this flight in virtual time."""
    env = {**os.environ, "SINEW_RUN_DIR": folder, "SINEW_RECORD": "on"}
    subprocess.run([sinew, "run", flight, "--virtual", "--duration", "1", "--quiet", "--runs", f"{folder}/runs"],
                   env=env, check=False)  # a mission that is cut off has failed
    return next(pathlib.Path(folder, "runs").glob("*/run.mcap"))


def main():
    monitor, sinew, robot, test, *flight = sys.argv[1:]
    reason = reason_to_skip()
    if reason:
        print("skipped:", reason)
        return SKIPPED
    with tempfile.TemporaryDirectory() as folder:
        env = {**os.environ, "SINEW_RUN_DIR": folder}
        started = []

        def start(*command):
            process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True, env=env,
                                       start_new_session=True)
            started.append(process)
            return process

        try:
            start(robot, "counterbot", "--virtual").stdout.readline()
            # A robot that comes back whenever it ends.
            start("sh", "-c", 'while true; do "$0" phoenix; done', robot).stdout.readline()
            if flight:
                recording = record(sinew, flight[0], folder)
                start(sinew, "bag", "play", recording, "--name", "recorded", "--paused", "--stay").stdout.readline()
                env.update(RECORDED="recorded")
            shown = start(monitor, "--port", "0")
            url = shown.stdout.readline().strip().replace("http:", "ws:")
            token = re.match(r"token for commands: (\S+)", shown.stdout.readline())[1]
            env.update(URL=url, TOKEN=token, ROBOT="counterbot",
                       ECHO=json.dumps([sinew, "topic", "echo", "--robot", "counterbot"]))
            return subprocess.run(["node", "--test", HERE / "others" / test], env=env).returncode
        finally:
            for process in reversed(started):
                os.killpg(process.pid, signal.SIGTERM)
                process.wait()


if __name__ == "__main__":
    sys.exit(main())
