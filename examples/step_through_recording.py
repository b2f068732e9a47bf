#!/usr/bin/env python3
"""Goes through a recorded flight from one message of a topic to the next, and prints where the robot was then.

usage: step_through_recording.py SINEW RECORDING [TOPIC [COUNT]]
"""
import json
import os
import socket
import struct
import subprocess
import sys
import tempfile

TOPIC = sys.argv[3] if len(sys.argv) > 3 else "camera.raw"
COUNT = int(sys.argv[4]) if len(sys.argv) > 4 else 5


def ask(robot, request, **arguments):
    text = json.dumps({"request": request, **arguments}).encode()
    robot.sendall(struct.pack("<I", len(text)) + text)
    head = robot.recv(4, socket.MSG_WAITALL)
    return json.loads(robot.recv(struct.unpack("<I", head)[0], socket.MSG_WAITALL))


def main(sinew, recording):
    film = subprocess.Popen([sinew, "bag", "play", recording, "--name", "film", "--paused", "--stay",
                             "--start-offset", "1"], stdout=subprocess.PIPE)
    try:
        film.stdout.readline()  # it is there
        robot = socket.socket(socket.AF_UNIX)
        robot.connect(os.environ["SINEW_RUN_DIR"] + "/film.sock")
        for _ in range(COUNT):
            playback = ask(robot, "playback.step", topic=TOPIC)
            if playback["state"] == "ended":
                break
            state = subprocess.run([sinew, "topic", "echo", "filter.state", "--robot", "film", "-n", "1", "--json"],
                                   check=True, capture_output=True).stdout
            p = json.loads(state)["message"]["p_world_m"]
            print(f"{playback['time_ns'] * 1e-9:9.4f} s  {TOPIC}: at {p['x']:.3f} {p['y']:.3f} {p['z']:.3f} m")
    finally:
        film.terminate()
        film.wait()


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        os.environ.setdefault("SINEW_RUN_DIR", folder)
        main(*sys.argv[1:3])
