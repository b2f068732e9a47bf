#!/usr/bin/env python3
"""A robot without a simulator hears RoboCup's game controller, which is this program, and answers it.

usage: game_controller_test.py SINEW
"""
import json
import os
import pathlib
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import unittest

SINEW = sys.argv[1]
PORT = 20000 + 2 * (os.getpid() % 10000)  # tests run beside each other
ANSWERS = PORT + 1
ROBOT = f"""
robot = {{ name = "hearer", board = "linux" }}
[[thread]]
name = "game"
priority = 0
period_us = 20000
order = ["referee"]
[module.referee]
type = "drivers::RefereeSource"
[device.referee]
driver = "gamecontroller"
team = 12
player = 3
port = {PORT}
answer_port = {ANSWERS}
"""


def packet(number, state=3, teams=(34, 12), penalty=0):
    """Version 19, with a penalty of the second team's player 3."""
    head = b"RGme" + bytes([19, number, 4, 0, 0, 0, state, 0, 1, 34]) + struct.pack("<hh", 333, 0)
    for i, team in enumerate(teams):
        players = bytearray(80)
        if i == 1:
            players[8:10] = bytes([penalty, 17])
        head += bytes([team, i, i, 1, 5 + i, 0]) + struct.pack("<HH", 0, 0) + players
    return head


class Table(threading.Thread):
    """The program at the field: five packets a second, and those of another field."""

    def __init__(self):
        super().__init__()
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", ANSWERS))
        self.socket.settimeout(0.2)
        self.done, self.answers = threading.Event(), []
        self.start()

    def run(self):
        number = 0
        while not self.done.is_set():
            for data in (packet(number, penalty=9), packet(number, teams=(1, 2)), b"RGme", b"\0"):
                self.socket.sendto(data, ("127.0.0.1", PORT))
            number = (number + 1) % 256
            try:
                self.answers.append(self.socket.recv(100))
                self.done.wait(0.2)
            except TimeoutError:
                pass

    def end(self):
        self.done.set()
        self.join()
        self.socket.close()


class GameController(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="sinew-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.robot = self.folder / "hearer.toml"
        self.robot.write_text(ROBOT)

    def sinew(self, *arguments):
        env = dict(os.environ, SINEW_RUN_DIR=str(self.folder))
        env.pop("SINEW_RECORD", None)
        return subprocess.run([SINEW, *map(str, arguments)], capture_output=True, text=True, env=env, cwd=self.folder,
                              timeout=120)

    def test_a_robot_hears_its_game_answers_and_its_run_is_executed_again(self):
        table = Table()
        try:
            done = self.sinew("run", self.robot, "--duration", "3", "--runs", self.folder / "runs")
        finally:
            table.end()
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertTrue(table.answers, done.stdout + done.stderr)
        self.assertEqual({a[:8] for a in table.answers}, {b"RGrt" + bytes([4, 3, 12, 0])})
        self.assertEqual({len(a) for a in table.answers}, {32})
        record = self.folder / "runs/latest/run.mcap"
        said = self.sinew("bag", "cat", record, "--topic", "referee.raw")
        self.assertEqual(said.returncode, 0, said.stderr)
        heard = [json.loads(line)["message"] for line in said.stdout.splitlines()]
        self.assertTrue(heard, done.stderr)
        for message in heard:
            got = {key: message[key] for key in ("half", "own_goals", "other_goals", "left_s", "penalty_left_s", "team",
                                                 "attacks_right")}
            self.assertEqual(got, {"half": 1, "own_goals": 6, "other_goals": 5, "left_s": 333, "penalty_left_s": 17,
                                   "team": 1, "attacks_right": 0})
            self.assertIn(message["penalty"], (4, "pushing"))
        again = self.sinew("replay", record)
        self.assertEqual(again.returncode, 0, again.stdout + again.stderr)
        self.assertRegex(again.stdout, "^identical")

    def test_silence_is_said(self):
        done = self.sinew("run", self.robot, "--duration", "5", "--no-record")
        self.assertIn(f"referee: hears no game controller on UDP port {PORT}", done.stdout + done.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[2:])
