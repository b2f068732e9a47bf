"""sinew-net on two hosts (network namespaces): no network at first, an address that changes, peers that cannot match.

usage: net_program_test.py SINEW_NET
"""
import json
import os
import socket
import struct
import subprocess
import sys
import tempfile
import time
import unittest

NET = sys.argv[1]
FOLDER = tempfile.TemporaryDirectory(prefix="sinew_net_")
os.environ["SINEW_RUN_DIR"] = FOLDER.name
A, B = f"sneta{os.getpid()}", f"snetb{os.getpid()}"
LIMIT_S = 30


def ip(*arguments):
    return subprocess.run(["ip", *arguments], capture_output=True).returncode == 0


def permitted():
    try:
        return ip("netns", "add", A) and ip("netns", "add", B)
    except FileNotFoundError:
        return False


def packet(kind, payload=b""):
    return struct.pack("<BBHIIq", 1, kind, 0, 0, 0, 0) + payload


def connect(robot):
    end = time.monotonic() + LIMIT_S
    while True:
        line = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        line.settimeout(0.1)
        try:
            line.connect(f"{FOLDER.name}/{robot}.net")
            return line
        except OSError:
            line.close()
            if time.monotonic() > end:
                raise
            time.sleep(0.02)


def status(robot):
    with connect(robot) as line:
        line.settimeout(5)
        line.send(packet(5))
        return json.loads(line.recv(70000)[20:])


class NetProgram(unittest.TestCase):
    def setUp(self):
        self.programs = []

    def tearDown(self):
        for program in self.programs:
            program.terminate()
            self.assertEqual(program.wait(10), 0)
        ip("-n", A, "link", "del", "veth0")

    def start(self, host, robot, more="", domain=7):
        path = f"{FOLDER.name}/{robot}.toml"
        with open(path, "w", encoding="ascii") as file:
            file.write(f'[robot]\nname = "{robot}"\nboard = "none"\n[net]\ninterfaces = ["veth0"]\ndomain = {domain}\n{more}\n'
                       '[device.radio]\ndriver = "dds"\n')
        self.programs.append(subprocess.Popen(["ip", "netns", "exec", host, NET, path], stderr=subprocess.DEVNULL))

    def cable(self):
        self.assertTrue(ip("link", "add", "veth0", "netns", A, "type", "veth", "peer", "name", "veth0", "netns", B))
        for host, address in (A, "10.9.0.1/24"), (B, "10.9.0.2/24"):
            self.assertTrue(ip("-n", host, "addr", "add", address, "dev", "veth0"))
            self.assertTrue(ip("-n", host, "link", "set", "veth0", "up"))

    def assert_flows(self, there, here):
        """What `there` says arrives at `here`, from some time on, whichever of them begins anew meanwhile."""
        end = time.monotonic() + LIMIT_S
        while time.monotonic() < end:
            try:
                with connect(there) as speaker, connect(here) as listener:
                    listener.send(packet(1))
                    for _ in range(20):
                        speaker.send(packet(2, b"hello"))
                        try:
                            got = listener.recv(4096)
                        except TimeoutError:
                            continue
                        if len(got) < 20:
                            break
                        if got[1] == 3 and got[20:] == b"hello":
                            return
            except OSError:
                pass
            time.sleep(0.05)
        self.fail(f"nothing of {there} arrives at {here}")

    def assert_becomes(self, robot, test):
        end = time.monotonic() + LIMIT_S
        seen = None
        while time.monotonic() < end:
            try:
                seen = status(robot)
                if test(seen):
                    return
            except OSError:
                pass
            time.sleep(0.05)
        self.fail(json.dumps(seen))

    def test_it_begins_without_a_network_and_follows_a_changed_address(self):
        self.start(A, "a")
        self.assert_becomes("a", lambda s: not s["open"] and "no address on 'veth0'" in s["trouble"])
        self.cable()
        self.start(B, "b")
        self.assert_flows("a", "b")
        self.assertTrue(ip("-n", A, "addr", "del", "10.9.0.1/24", "dev", "veth0"))
        self.assertTrue(ip("-n", A, "addr", "add", "10.9.0.5/24", "dev", "veth0"))
        self.assert_becomes("a", lambda s: s["addresses"] == ["veth0 10.9.0.5"] and s["open"])
        self.assert_flows("a", "b")
        self.assert_flows("b", "a")

    def test_peers_find_each_other_without_multicast(self):
        self.cable()
        self.start(A, "a", 'multicast = false\npeers = ["10.9.0.2"]')
        self.start(B, "b", 'multicast = false\npeers = ["10.9.0.1"]')
        self.assert_flows("a", "b")
        self.assert_flows("b", "a")

    def test_a_robot_that_is_heard_and_does_not_hear_is_named(self):
        self.cable()
        # What A sends to B's address goes to a station that is not there; A's announcements by multicast arrive.
        self.assertTrue(ip("-n", A, "neigh", "replace", "10.9.0.2", "lladdr", "02:00:00:00:00:99", "dev", "veth0",
                           "nud", "permanent"))
        self.assertTrue(ip("-n", B, "neigh", "replace", "10.9.0.1", "lladdr", "02:00:00:00:00:98", "dev", "veth0",
                           "nud", "permanent"))
        self.start(A, "a")
        self.start(B, "b")
        self.assert_becomes("b", lambda s: s["trouble"] == "DDS of the robot a is heard and does not hear us")

    def test_a_configuration_that_cyclone_refuses_is_said_and_tried_again(self):
        self.cable()
        self.start(A, "a", "extra = '<General><MaxMessageSize>much</MaxMessageSize></General>'")
        self.assert_becomes("a", lambda s: "much" in s["trouble"])
        self.assert_becomes("a", lambda s: s["failed_before"] >= 2)

    def test_a_participant_of_another_domain_is_heard_with_its_domain(self):
        self.cable()
        self.start(A, "a")
        self.start(B, "b", domain=9)
        self.assert_becomes("a", lambda s: any(h["domain"] == 9 and h["address"] == "10.9.0.2" and
                                               h["vendor"] == "Cyclone DDS" for h in s["other_domains"]))

    def test_a_domain_of_the_environment_that_is_none_is_refused(self):
        path = f"{FOLDER.name}/c.toml"
        with open(path, "w", encoding="ascii") as file:
            file.write('[robot]\nname = "c"\nboard = "none"\n[ros2]\ndistro = "humble"\n')
        for domain in ("abc", "7x", "-1", "233", "99999999999"):
            ended = subprocess.run([NET, path], env={**os.environ, "ROS_DOMAIN_ID": domain}, capture_output=True,
                                   text=True, timeout=LIMIT_S)
            self.assertEqual(ended.returncode, 2)
            self.assertIn(f"ROS_DOMAIN_ID is '{domain}', and not a number from 0 to 232", ended.stderr)


if not permitted():
    print("skipped: network namespaces need root and the program ip")
    sys.exit(77)
try:
    unittest.main(argv=sys.argv[:1])
finally:
    ip("netns", "del", A)
    ip("netns", "del", B)
