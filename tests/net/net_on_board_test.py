"""sinew-net of a board, in qemu-user: two robots by DDS with each other, with DDS Security, and with a robot of this machine.

usage: net_on_board_test.py SINEW_NET NATIVE_SINEW_NET EMULATOR...

What qemu-user lacks is named in docs/boards.md: no multicast, so each names its peer; and a program cannot start another one of
the board, so these are started as sinew-net's own second process (--worker).
"""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import net_client

NET, NATIVE, *EMULATOR = sys.argv[1:]
HERE = pathlib.Path(__file__).resolve().parent
FOLDER = tempfile.TemporaryDirectory(prefix="sinew_net_")
os.environ["SINEW_RUN_DIR"] = FOLDER.name
TABLE = """[robot]
name = "{name}"
board = "none"
[net]
domain = 61
interfaces = ["127.0.0.1"]
multicast = false
peers = ["127.0.0.1"]
extra = "<Discovery><Tag>sinew-{tag}</Tag></Discovery>"
{more}
[device.radio]
driver = "dds"
"""


def security(member):
    return "[net.security]\n" + "".join(f'{key} = "keys/{file}"\n' for key, file in (
        ("identity_ca", "ca.pem"), ("certificate", f"{member}.pem"), ("private_key", f"{member}.key"),
        ("permissions_ca", "ca.pem"), ("governance", "governance.p7s"), ("permissions", f"{member}.p7s")))


class NetOnBoard(net_client.Checks, unittest.TestCase):
    def start(self, command, robot, more=""):
        path = pathlib.Path(FOLDER.name, f"{robot}.toml")
        path.write_text(TABLE.format(name=robot, tag=f"{os.getpid()}-{self.id()}", more=more), encoding="ascii")
        program = subprocess.Popen([*command, "--worker", str(path)])
        self.addCleanup(lambda: (program.terminate(), self.assertEqual(program.wait(20), 0)))

    def assert_talk(self, one, other):
        self.assert_flows(one, other)
        self.assert_flows(other, one)

    def test_two_robots_of_a_board_hear_each_other_and_are_in_a_ros_2_graph(self):
        self.start([*EMULATOR, NET], "a", '[ros2]\ndistro = "humble"')
        self.start([*EMULATOR, NET], "b", '[ros2]\ndistro = "humble"')
        self.assert_talk("a", "b")
        seen = self.assert_becomes("a", lambda s: [p["robot"] for p in s["participants"]] == ["b"])
        self.assertEqual((seen["trouble"], seen["unmatched"]), ("", []))
        self.assertEqual(seen["ros2"]["node"], "/a")

    @unittest.skipUnless(shutil.which("openssl"), "openssl is missing")
    def test_two_robots_of_a_board_hear_each_other_with_dds_security(self):
        keys = pathlib.Path(FOLDER.name, "keys")
        keys.mkdir()
        subprocess.run(["sh", str(HERE / "dds/make_security.sh"), str(keys)], check=True, capture_output=True)
        self.start([*EMULATOR, NET], "a", security("one"))
        self.start([*EMULATOR, NET], "b", security("two"))
        self.start([*EMULATOR, NET], "c")  # without: it hears nobody
        self.assert_talk("a", "b")
        self.assertTrue(net_client.status("a")["secure"])
        heard = net_client.status("c")
        self.assertEqual((heard["radio"]["readers"], heard["radio"]["writers"], heard["radio"]["heard"]), (0, 0, 0))

    @unittest.skipUnless(os.path.exists(NATIVE), "no sinew-net was built for this machine")
    def test_a_robot_of_a_board_and_one_of_this_machine_hear_each_other(self):
        self.start([*EMULATOR, NET], "a")
        self.start([NATIVE], "b")
        self.assert_talk("a", "b")


unittest.main(argv=sys.argv[:1], verbosity=2)
