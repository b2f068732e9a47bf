#!/usr/bin/env python3
"""Datagrams come into a robot by its radio, are recorded, and the run is executed again without a network.

usage: radio_run_test.py SINEW MATES EXAMPLES    the program example_mates, and the folder of its robot files
"""
import glob
import json
import os
import pathlib
import re
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest

SINEW, MATES, EXAMPLES = sys.argv[1:4]
GROUP = (f"239.72.{os.getpid() >> 8 & 255}.{os.getpid() & 255}", 20000 + os.getpid() % 20000)
ROBOT = f"""
robot = {{ name = "hearer", board = "linux" }}
[[thread]]
name = "team"
priority = 0
period_us = 10000
order = ["radio"]
[module.radio]
type = "drivers::RadioSource"
[device.radio]
driver = "udp"
group = "{GROUP[0]}:{GROUP[1]}"
interface = "INTERFACE"
"""


class Talker(threading.Thread):
    """A mate without Sinew: numbers, 100 a second, and rubbish among them."""

    def __init__(self):
        super().__init__()
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton("127.0.0.1"))
        self.done = threading.Event()
        self.start()

    def run(self):
        number = 0
        while not self.done.wait(0.01):
            for data in (b"%d" % number, b"", bytes(1201), os.urandom(1200)):
                self.socket.sendto(data, GROUP)
            number += 1

    def end(self):
        self.done.set()
        self.join()
        self.socket.close()


class InOwnFolder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="sinew-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.env = dict(os.environ, SINEW_RUN_DIR=folder.name)
        self.env.pop("SINEW_RECORD", None)

    def done(self, *command):
        done = subprocess.run(command, capture_output=True, text=True, env=self.env, cwd=self.folder, timeout=120)
        return done.returncode, done.stdout, done.stderr


class Radio(InOwnFolder):
    def sinew(self, *arguments):
        return self.done(SINEW, *arguments)

    def robot(self, interface):
        path = self.folder / "hearer.toml"
        path.write_text(ROBOT.replace("INTERFACE", interface))
        return path

    def test_what_is_heard_is_recorded_and_executed_again_to_the_same_bytes(self):
        talker = Talker()
        self.addCleanup(talker.end)
        code, out, err = self.sinew("run", self.robot("lo"), "--duration", "3", "--json")
        self.assertEqual(code, 0, out + err)
        self.assertEqual(json.loads(out).get("devices", []), [], "no complaint")
        (file,) = glob.glob(f"{self.folder}/runs/hearer-*/run.mcap")
        code, out, err = self.sinew("topic", "echo", "radio.raw", "--file", file, "--json")
        heard = [json.loads(line) for line in out.splitlines()]
        heard = [m.get("message", m) for m in heard]
        texts = [bytes(m["data"][:m["size"]]) for m in heard if m["size"] < 10]
        numbers = [int(t) for t in texts]
        self.assertGreater(len(numbers), 50, out[:500] + err)
        self.assertEqual(numbers, list(range(numbers[0], numbers[0] + len(numbers))), "each once, in their order")
        self.assertEqual({m["size"] for m in heard if m["size"] >= 10}, {1200}, "none that is empty or too long")
        self.assertEqual({m["sender"] for m in heard}, {0x7F000001})
        self.assertEqual({m["lost"] for m in heard}, {0})
        talker.end()
        code, out, err = self.sinew("replay", file, "--json")
        self.assertEqual(code, 0, out + err)
        replay = json.loads(out)
        self.assertTrue(replay["identical"])
        self.assertGreater(replay["modules"]["radio"]["steps"], 200)

    def test_without_its_network_it_runs_and_says_so(self):
        code, out, err = self.sinew("run", self.robot("wlan77"), "--duration", "2", "--json", "--no-record")
        self.assertEqual(code, 0, out + err)
        self.assertIn(f"radio: group {GROUP[0]}:{GROUP[1]}: there is no interface 'wlan77' ('ip link' lists them)", out)

    def test_boards_without_a_radio_say_so_before_anything_starts(self):
        robot = self.robot("lo")
        robot.write_text(robot.read_text().replace('RadioSource"', 'RadioSource"\nexec_us = 20') + '[sim]\nworld = "seesaw"\n')
        code, out, err = self.sinew("check", robot, "--board", "sim")
        self.assertEqual(code, 1, out + err)
        self.assertIn('module.radio: "radio": the name of radio in the world seesaw: there is none', out + err)
        folder = self.folder / "recorded"
        folder.mkdir()
        (folder / "imu0.csv").write_text("#\n1000000000,0,0,0,0,0,9.8\n1005000000,0,0,0,0,0,9.8\n")
        code, out, err = self.sinew("run", robot, "--board", "dataset", "--data", folder, "--virtual")
        self.assertEqual(code, 2, out + err)
        self.assertIn("device 'radio': not found (a recorded folder has no radio)", err)


class Team(InOwnFolder):
    """Two robots of examples/mates.toml, each in a process of its own."""

    def setUp(self):
        super().setUp()
        for name in ("mates.toml", "mates_bee.toml"):
            text = pathlib.Path(EXAMPLES, name).read_text()
            (self.folder / name).write_text(
                text.replace('interface = "lo"', f'interface = "lo"\ngroup = "{GROUP[0]}:{GROUP[1]}"'))

    def mates(self, *arguments):
        return self.done(MATES, *arguments)

    def started(self, *arguments):
        robot = subprocess.Popen([MATES, "run", *arguments], env=self.env, cwd=self.folder, text=True,
                                 stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.addCleanup(robot.communicate)
        self.addCleanup(robot.kill)
        return robot

    def echo(self, topic, file):
        _, out, _ = self.mates("topic", "echo", topic, "--file", file, "--json")
        return [json.loads(line) for line in out.splitlines()]

    def test_each_hears_the_other_until_it_dies_and_the_run_is_executed_again_without_a_network(self):
        talker = Talker()  # junk on the same group, as anybody can send
        self.addCleanup(talker.end)
        ant = self.started("mates.toml", "--no-record")
        bee = self.started("mates_bee.toml", "--duration", "10", "--json")
        heard = re.compile(r"(?m)^mate      1: heard .* ago, \d+ frames, \d+ lost; its clock is known to ")
        until = time.monotonic() + 30
        while not heard.search(status := self.mates("status", "--robot", "bee")[1]):
            self.assertLess(time.monotonic(), until, status)
            time.sleep(0.1)
        # Other programs look at topics of mates as at own ones.
        code, out, err = self.done(SINEW, "topic", "echo", "mates/ball.height", "--robot", "bee", "-n", "3",
                                   "--timeout", "20", "--json")
        self.assertEqual(code, 0, out + err)
        self.assertIn('"range_m"', out)
        time.sleep(1)
        ant.kill()
        out, _ = bee.communicate(timeout=60)
        self.assertEqual(bee.returncode, 0, out)
        (file,) = glob.glob(f"{self.folder}/runs/bee-*/run.mcap")
        heard = [m["message"] for m in self.echo("mates/ball.height", file)]
        self.assertGreater(len(heard), 5)
        self.assertEqual({m["robot"] for m in heard}, {1})
        stamps = [m["stamp"] for m in heard]
        self.assertEqual(stamps, sorted(set(stamps)))
        # Both robots are on one machine with one clock: what the exchange of frames finds must be near to nothing.
        last = self.echo("mates.state", file)[-1]["message"]
        self.assertLessEqual(abs(last["mate"][0]["clock_offset_ns"]), last["mate"][0]["clock_bound_ns"])
        self.assertGreater(last["garbage"], 50)
        lost = sum(m["message"]["lost"] for m in self.echo("mates.raw", file))
        self.assertLessEqual(last["mate"][0]["lost"], lost, "what the radio had no room for, and no more")
        # An input with max_age_ms = 300 holds nothing older: without it, the last message would stay for seconds.
        of_other = self.echo("judge.of_other", file)
        self.assertGreater(len(of_other), 5)
        oldest = max(m["published_ns"] - m["message"]["stamp"] for m in of_other)
        self.assertLess(oldest, 2_000_000_000)
        self.assertGreater(last["stamp"] - stamps[-1], 2_500_000_000, "the dead mate was silent for longer than that")
        talker.end()
        code, out, err = self.mates("replay", file, "--json")
        self.assertEqual(code, 0, out + err)
        self.assertTrue(json.loads(out)["identical"])
        code, out, err = self.mates("bag", "check", file)
        self.assertEqual(code, 0, out + err)

    def test_inputs_of_all_mates_and_of_one_are_not_mixed_up(self):
        robot = self.folder / "mates.toml"
        good = robot.read_text()
        robot.write_text(good.replace("mates/ball.height", "bee/ball.height"))
        code, out, err = self.mates("check", "mates.toml")
        self.assertEqual(code, 1, out)
        self.assertIn("FromMate", err)
        robot.write_text(good.replace('topic = "bee/ball.height"', 'topic = "mates/ball.width"'))
        code, out, err = self.mates("check", "mates.toml")
        self.assertEqual(code, 1, out)
        self.assertRegex(err, r'mates\.toml:\d+: module\.judge\.in\.other: "mates/ball\.width" of RangeSample: an input '
                                      r'of FromMate<\.\.\.>, as messages of all mates carry their sender')

    def test_what_does_not_fit_the_budget_is_refused_with_its_costs(self):
        robot = self.folder / "mates.toml"
        robot.write_text(robot.read_text().replace("bytes_per_s = 5000", "bytes_per_s = 1000"))
        code, out, err = self.mates("check", "mates.toml")
        self.assertEqual(code, 1, out)
        self.assertRegex(err, r"mates\.toml:\d+: team\.bytes_per_s: 1000: at least 1770, or lower rates: "
                                      r"ball\.height 1000 B/s \(50 B at 20 Hz\); heads and echoes 770 B/s")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
