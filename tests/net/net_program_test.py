"""sinew-net on two hosts (network namespaces): no network at first, interfaces and addresses that go and come, peers that
cannot match, DDS Security, a process that hangs.

usage: net_program_test.py SINEW_NET SINEW DDS_PEER
"""
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import net_client
from net_client import LIMIT_S, status

NET, SINEW, PEER = sys.argv[1:4]
HERE = pathlib.Path(__file__).resolve().parent
FOLDER = tempfile.TemporaryDirectory(prefix="sinew_net_")
os.environ["SINEW_RUN_DIR"] = FOLDER.name
A, B = f"sneta{os.getpid()}", f"snetb{os.getpid()}"
RADIO = "sinew_team_0,sinew::TeamDatagram"


def ip(*arguments):
    return subprocess.run(["ip", *arguments], capture_output=True).returncode == 0


def permitted():
    """With a loopback interface: Cyclone ends its threads by datagrams to its own address."""
    try:
        return all(ip("netns", "add", host) and ip("-n", host, "link", "set", "lo", "up") for host in (A, B))
    except FileNotFoundError:
        return False


class NetProgram(net_client.Checks, unittest.TestCase):
    def setUp(self):
        self.programs, self.peers = [], []

    def tearDown(self):
        for peer in self.peers:
            with peer:  # closes its input
                pass
            self.assertEqual(peer.returncode, 0)
        for program in self.programs:
            program.terminate()
            self.assertEqual(program.wait(10), 0)
        ip("-n", A, "link", "del", "veth0")

    def start(self, host, robot, more="", domain=7, options=()):
        """Its words go to NAME.log."""
        path = f"{FOLDER.name}/{robot}.toml"
        with open(path, "w", encoding="ascii") as file:
            file.write(f'[robot]\nname = "{robot}"\nboard = "none"\n[net]\ninterfaces = ["veth0"]\ndomain = {domain}\n{more}\n'
                       '[device.radio]\ndriver = "dds"\n')
        with open(f"{FOLDER.name}/{robot}.log", "w", encoding="ascii") as log:
            self.programs.append(subprocess.Popen(["ip", "netns", "exec", host, NET, *options, path], stderr=log))

    def peer(self, host, *endpoints, domain=7):
        """A participant that is not ours; it ends when its input does."""
        program = subprocess.Popen(["ip", "netns", "exec", host, PEER, str(domain), "veth0", *endpoints], stdin=subprocess.PIPE,
                                   stdout=subprocess.PIPE, text=True)
        self.peers.append(program)
        return program

    def lines_until(self, peer, words):
        """What it prints up to a line with these words; the test's time limit ends this."""
        text = ""
        for line in peer.stdout:
            text += line
            if words in line:
                return text
        self.fail(f"{words} is not heard: {text}")

    def cable(self):
        self.assertTrue(ip("link", "add", "veth0", "netns", A, "type", "veth", "peer", "name", "veth0", "netns", B))
        for host, address in (A, "10.9.0.1/24"), (B, "10.9.0.2/24"):
            self.assertTrue(ip("-n", host, "addr", "add", address, "dev", "veth0"))
            self.assertTrue(ip("-n", host, "link", "set", "veth0", "up"))

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

    def test_an_interface_that_goes_and_comes_back_with_its_address_is_used_again(self):
        self.cable()
        self.start(A, "a")
        self.start(B, "b")
        self.assert_flows("a", "b")
        self.assertTrue(ip("-n", A, "link", "set", "veth0", "down"))
        self.assert_becomes("a", lambda s: not s["open"] and "no address on 'veth0'" in s["trouble"])
        self.assertTrue(ip("-n", A, "link", "set", "veth0", "up"))
        self.assert_becomes("a", lambda s: s["addresses"] == ["veth0 10.9.0.1"] and s["open"])
        self.assert_flows("a", "b")
        self.assert_flows("b", "a")

    def test_an_interface_that_is_made_again_with_its_address_is_used_again(self):
        # As when an adapter is pulled and put back, faster than any look: multicast of the old one's sockets goes nowhere.
        self.cable()
        self.start(A, "a")
        self.assert_becomes("a", lambda s: s["open"])
        self.assertTrue(ip("-n", A, "link", "del", "veth0"))
        self.cable()
        self.start(B, "b")  # only multicast can tell them of each other
        self.assert_flows("a", "b")
        self.assert_flows("b", "a")

    def test_a_worker_that_hangs_is_killed_and_another_one_takes_its_place(self):
        self.cable()
        self.start(A, "a", options=("--patience", "3"))
        self.start(B, "b")
        self.assert_flows("a", "b")
        hung = status("a")["pid"]
        os.kill(hung, signal.SIGSTOP)
        self.assert_becomes("a", lambda s: s["pid"] != hung and s["open"])
        self.assert_flows("a", "b")
        self.assert_flows("b", "a")
        said = pathlib.Path(f"{FOLDER.name}/a.log").read_text(encoding="utf-8")
        self.assertIn(f"sinew-net: DDS hangs: nothing of process {hung} for 3 s, so it is killed\n", said)
        self.assertIn("sinew-net: signal 9 (Killed); started again in 200 ms\n", said)

    def test_endpoints_of_others_that_cannot_match_are_named_with_their_reasons(self):
        self.cable()
        self.start(A, "a")
        peer = self.peer(B, f"read,{RADIO}", f"write,{RADIO}", "read,sinew_team_0,std_msgs::msg::dds_::String_",
                         f"read,{RADIO},reliable", f"read,{RADIO},transient_local", f"read,{RADIO},deadline_ms=100",
                         f"write,{RADIO},partition=lab", "write,sinew_team_1,another::Type")
        reasons = {("reader", "type: ours is sinew::TeamDatagram, its is std_msgs::msg::dds_::String_"),
                   ("reader", "reliability: its reader asks for reliable, our writer offers best effort"),
                   ("reader", "durability: its reader asks for transient local, our writer offers volatile"),
                   ("reader", "deadline: its reader asks for 100 ms, our writer offers none"),
                   ("writer", "partition: ours none, its 'lab'")}
        seen = self.assert_becomes("a", lambda s: len(s["unmatched"]) >= len(reasons) and s["radio"]["readers"] > 0 and
                                   s["radio"]["writers"] > 0)
        self.assertEqual({(u["is"], u["why"]) for u in seen["unmatched"]}, reasons)
        self.assertEqual((seen["radio"]["readers"], seen["radio"]["writers"]), (1, 1), "those that match")
        text = subprocess.run([SINEW, "net", "status", "a"], capture_output=True, text=True, check=True).stdout
        for is_a, why in reasons:
            self.assertRegex(text, rf"(?m)^no match: sinew_team_0: {is_a} [0-9a-f.]+: {why}$")
        peer.stdin.close()
        self.assert_becomes("a", lambda s: s["unmatched"] == [] and s["radio"]["readers"] == 0)

    @unittest.skipUnless(shutil.which("openssl"), "openssl is missing")
    def test_with_dds_security_the_bridge_to_ros_2_is_heard_by_members_only(self):
        self.cable()
        keys = f"{FOLDER.name}/keys"
        os.mkdir(keys)
        subprocess.run(["sh", str(HERE / "dds/make_security.sh"), keys], check=True, capture_output=True)
        bridge = '[ros2]\ndistro = "humble"\n'
        self.start(A, "hidden", '[net.security]\nidentity_ca = "keys/ca.pem"\ncertificate = "keys/one.pem"\n'
                   'private_key = "keys/one.key"\npermissions_ca = "keys/ca.pem"\ngovernance = "keys/governance.p7s"\n'
                   f'permissions = "keys/one.p7s"\n{bridge}')
        self.start(A, "plain", bridge)
        discovery = "read,ros_discovery_info,rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_,reliable,transient_local"
        team = f"read,{RADIO}"
        member = self.peer(B, f"security={keys},two", discovery, team)
        stranger = self.peer(B, discovery, team)
        # Each hears the node of its own kind, and with that all that there was for it to hear.
        self.assertIn("hidden", member.stdout.readline())
        self.assertIn("plain", stranger.stdout.readline())
        seen = self.assert_becomes("hidden", lambda s: s["open"] and s["radio"]["readers"] == 1)
        self.assertTrue(seen["secure"])
        self.assertEqual(seen["unmatched"], [])
        self.assert_becomes("plain", lambda s: s["radio"]["readers"] == 1)  # the stranger
        with net_client.connect("hidden") as hidden, net_client.connect("plain") as plain:
            hidden.send(net_client.packet(net_client.SAY, b"secret"))
            self.lines_until(member, "secret")
            plain.send(net_client.packet(net_client.SAY, b"open"))
            heard = self.lines_until(stranger, "open")
        self.assertNotIn("secret", heard)
        self.assertNotIn("hidden", heard)

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
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
finally:
    ip("netns", "del", A)
    ip("netns", "del", B)
