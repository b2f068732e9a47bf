#!/usr/bin/env python3
"""Viewers of others see a robot through the monitor: the npm client of the Foxglove protocol, and one written from the
specification of its newer name.

usage: others_viewer_test.py MONITOR SINEW ROBOT TEST.mjs [node's arguments]      exit 77: skipped, with the reason

The npm packages are pinned in others/package-lock.json; tools/setup.sh installs them.
"""
import json
import os
import pathlib
import re
import shutil
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


def main():
    monitor, sinew, robot, test, *more = sys.argv[1:]
    reason = reason_to_skip()
    if reason:
        print("skipped:", reason)
        return SKIPPED
    with tempfile.TemporaryDirectory() as folder:
        env = {**os.environ, "SINEW_RUN_DIR": folder}
        started = []

        def start(*command):
            process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=env)
            started.append(process)
            return process

        try:
            start(robot, "counterbot", "--virtual").stdout.readline()
            shown = start(monitor, "--port", "0")
            url = shown.stdout.readline().strip().replace("http:", "ws:")
            token = re.match(r"token for commands: (\S+)", shown.stdout.readline())[1]
            env.update(URL=url, TOKEN=token, ROBOT="counterbot",
                       ECHO=json.dumps([sinew, "topic", "echo", "--robot", "counterbot"]))
            return subprocess.run(["node", "--test", *more, HERE / "others" / test], env=env).returncode
        finally:
            for process in reversed(started):
                process.terminate()
                process.wait()


if __name__ == "__main__":
    sys.exit(main())
