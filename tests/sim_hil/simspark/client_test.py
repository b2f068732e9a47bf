"""An agent written from the protocol alone against the process: lockstep by (syn), exactly repeatable; the port of monitors;
hostile clients beside it; real time. And our own robot as an agent in our own door.

usage: client_test.py SINEW SINEW_SIM SOURCE_DIR [unittest arguments]"""

import json
import os
import re
import socket
import struct
import subprocess
import sys
import tempfile
import unittest

SINEW, SIM, SOURCE = sys.argv[1:4]
BODY = os.path.join(SOURCE, "robots/spark/nao_spark.toml")


class Door:
    """sinew-sim --serve simspark on ports of the system's choice."""

    def __init__(self, *options, monitors=False):
        self.folder = tempfile.TemporaryDirectory()
        self.report_file = os.path.join(self.folder.name, "report.json")
        monitor = ["--monitor-listen", "tcp:127.0.0.1:0" if monitors else "none"]
        self.process = subprocess.Popen(
            [SIM, "--serve", "simspark:0", "--body", BODY, "--report", self.report_file, *monitor, *options],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.first = self.process.stdout.readline()
        ports = re.findall(r"tcp:127\.0\.0\.1:(\d+)", self.first)
        if not ports:
            raise AssertionError("the door did not open: " + self.first + self.process.stdout.read())
        self.port = int(ports[0])
        self.monitor_port = int(ports[1]) if monitors else None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.terminate()
        self.words = self.first + self.process.communicate(timeout=60)[0]
        with open(self.report_file) as file:
            self.report = json.load(file)
        self.folder.cleanup()


class Peer:
    def __init__(self, port):
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=60)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def say(self, text):
        data = text.encode()
        self.socket.sendall(struct.pack(">I", len(data)) + data)

    def __del__(self):
        self.socket.close()

    def take(self, size):
        data = b""
        while len(data) < size:
            more = self.socket.recv(size - len(data))
            if not more:
                raise ConnectionError("closed")
            data += more
        return data

    def hear(self):
        return self.take(struct.unpack(">I", self.take(4))[0]).decode()

    def is_closed(self):
        try:
            while self.socket.recv(65536):
                pass
            return True
        except ConnectionResetError:
            return True


class Agent(Peer):
    def __init__(self, port, team="RED", number=1):
        super().__init__(port)
        self.say("(scene rsg/agent/nao/nao_hetero.rsg 0)")
        self.hear()
        self.say(f"(init (unum {number})(teamname {team}))")
        self.percepts = self.hear()

    def cycle(self, text=""):
        self.say(text + "(syn)")
        self.percepts = self.hear()
        return self.percepts

    def joint(self, name):
        return float(re.search(r"\(HJ \(n %s\) \(ax ([-\d.]+)\)\)" % name, self.percepts).group(1))


class InLockstep(unittest.TestCase):
    def run_script(self):
        all_percepts = []
        with Door("--sync") as door:
            agent = Agent(door.port)
            agent.cycle("(beam -1.5 0.5 0)")
            for i in range(300):
                wanted = 40 if i // 50 % 2 == 0 else 0  # the left arm up and down, by a proportional controller
                speed = 0.1 * (wanted - agent.joint("laj1"))
                all_percepts.append(agent.cycle(f"(lae1 {speed:.4f})(rae1 {-speed:.4f})(he1 0.5)(say abc)"))
        return all_percepts, door

    def test_an_agent_beams_moves_and_gets_the_same_bytes_each_time(self):
        first, door = self.run_script()
        second, _ = self.run_script()
        self.assertEqual(first, second)
        self.assertEqual(door.report["unknown"], 0)
        self.assertEqual(door.report["closed"], 0)
        self.assertEqual(door.report["agents"], 1)
        self.assertEqual(door.report["cycles"], 302)
        self.assertIn("(See ", "".join(first))
        self.assertIn("RED 1 at 127.0.0.1 plays", door.words)

    def test_two_players_wait_for_each_other(self):
        with Door("--sync", "--agents", "2", "--players", "2") as door:
            one = Peer(door.port)
            one.say("(scene rsg/agent/nao/nao.rsg)")
            one.hear()
            one.say("(init (unum 1)(teamname RED))")
            two = Agent(door.port, "BLUE", 1)
            at = [one.hear(), two.percepts]
            for _ in range(20):
                one.say("(syn)")
                two.say("(lae1 1)(syn)")
                at = [one.hear(), two.hear()]
            times = [re.search(r"\(now ([\d.]+)\)", text).group(1) for text in at]
            self.assertEqual(times[0], times[1])
            self.assertEqual(times[0], "0.42")

    def test_one_that_says_nothing_is_let_go_and_the_others_go_on(self):
        with Door("--sync", "--patience", "1", "--players", "3") as door:
            good = Agent(door.port)
            silent = Peer(door.port)
            silent.say("(scene rsg/agent/nao/nao.rsg)")
            silent.hear()
            silent.say("(init (unum 2)(teamname RED))")
            for _ in range(20):
                good.cycle()
            self.assertTrue(silent.is_closed())
        self.assertIn("RED 2 at 127.0.0.1: did not say (syn) in time", door.words)
        self.assertEqual(door.report["closed"], 1)


class InRealTime(unittest.TestCase):
    def test_fifty_cycles_a_second_whatever_other_clients_do(self):
        with Door("--players", "2") as door:
            good = Agent(door.port)
            evil = [Peer(door.port) for _ in range(6)]
            evil[0].socket.sendall(b"\xff\xff\xff\xff" + b"(" * 100)
            evil[1].say("((((((((((((((((((((")
            evil[2].say("(scene x)")
            evil[2].say("(init (unum 77)(teamname RED))")
            evil[3].say(")")
            evil[4].socket.sendall(struct.pack(">I", 9) + b"(sc")
            evil[4].socket.close()
            closed = [evil[i].is_closed() for i in (0, 1, 2, 3)]
            before = float(re.search(r"\(now ([\d.]+)\)", good.hear()).group(1))
            steps = []
            for _ in range(100):
                now = float(re.search(r"\(now ([\d.]+)\)", good.hear()).group(1))
                steps.append(round(now - before, 3))
                before = now
            self.assertEqual(set(steps), {0.02})
            self.assertTrue(all(closed))
        self.assertEqual(door.report["closed"], 4)
        self.assertIn("a team has 11 players", door.words)

    def test_a_monitor_leads_the_game(self):
        with Door("--sync", monitors=True) as door:
            agent = Agent(door.port)
            monitor = Peer(door.monitor_port)
            monitor.say("(kickOff Left)(ball (pos 14.5 0 0.05)(vel 3 0 0))(playMode PlayOn)")
            for _ in range(400):
                if "Goal_Left" in agent.cycle():
                    break
            self.assertIn("(sl 1)", agent.percepts)
            text = monitor.hear()
            self.assertIn("(play_modes BeforeKickOff", text)
            monitor.say("(killsim)")
            self.assertTrue(agent.is_closed())
        self.assertEqual(door.report["score_left"], 1)

    def test_options_are_refused_with_a_reason(self):
        for options, word in ((["--serve", "simspark"], "which body"), (["--players", "3"], "only with --serve simspark"),
                              (["--serve", "simspark:x"], "is no protocol"),
                              (["--world", "simspark", "--body", BODY], "needs --simspark HOST:PORT"),
                              (["--serve", "simspark", "--body", os.path.join(SOURCE, "robots/kid/op3.toml")],
                               "SimSpark's joint")):
            done = subprocess.run([SIM, *options], capture_output=True, text=True, timeout=60)
            self.assertEqual(done.returncode, 2, options)
            self.assertIn(word, done.stderr)


def walk(seed, seconds):
    """Our own robot in our own door: the finished run, and the door's report."""
    with Door("--sync", "--seed", str(seed)) as door:
        done = subprocess.run(
            [SINEW, "run", os.path.join(SOURCE, "robots/kid/kid_simspark.toml"), "--virtual", "--plant",
             f"simspark:127.0.0.1:{door.port}/OURS", "--duration", str(seconds), "--no-record", "--json", "--plain"],
            capture_output=True, text=True, timeout=300, cwd=door.folder.name)
    return done, door.report


class OurOwnRobotInOurOwnDoor(unittest.TestCase):
    def test_it_walks_in_it_the_same_way_each_time(self):
        done, report = walk(1, 20)
        player = report["players"][0]
        self.assertEqual(player["falls"], 0, done.stdout + done.stderr)
        self.assertGreater(player["walked_m"], 3.0)
        self.assertEqual(report["unknown"], 0)
        self.assertEqual(walk(1, 20)[1], report)

    def test_without_a_server_it_says_so(self):
        done = subprocess.run(
            [SINEW, "run", os.path.join(SOURCE, "robots/kid/kid_simspark.toml"), "--virtual", "--plant",
             "simspark:127.0.0.1:1", "--duration", "1", "--no-record", "--plain"],
            capture_output=True, text=True, timeout=100)
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("the world could not be made", done.stdout + done.stderr)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0]] + sys.argv[4:], verbosity=2)
