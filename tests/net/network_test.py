"""Robots across a network that delays and loses packets: sinew on one host, sinew-sim on another, lossy_link between.

usage: network_test.py LOSSY_LINK SINEW SINEW_SIM ROBOTS [unittest arguments]
"""
import json
import os
import re
import subprocess
import sys
import tempfile
import unittest

LINK, SINEW, SIM, ROBOTS = sys.argv[1:5]
RUN_DIR = tempfile.TemporaryDirectory(prefix="sinew_run_")  # other tests run robots of the same names
os.environ["SINEW_RUN_DIR"] = RUN_DIR.name
QUAD = f"{ROBOTS}/quad/quad.toml"
PLANT = "tcp:10.77.0.1:4560"
LIMIT_S = 150
# The runtime expects its plant to listen; sinew-sim takes its time to come up. Both have one output, in which the words of
# the plant may stand in the middle of a line of the runtime: this has a file of its own.
WAIT = """
import os, socket, sys, time

os.environ.setdefault("SINEW_RECORD", "off")  # a flight is 100 MB; recordings have tests of their own
while True:
    try:
        socket.create_connection(("10.77.0.1", 4560), 1).close()
        break
    except OSError:
        time.sleep(0.1)
os.dup2(os.open(sys.argv[1], os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600), 1)
os.execv(sys.argv[2], sys.argv[2:])
"""


def hashes(text):
    return dict(re.findall(r"^hash (\S+)\s+([0-9a-f]{16})$", text, re.M))


def run(*command):
    done = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT_S)
    return done.returncode, done.stdout, done.stderr


class Network(unittest.TestCase):
    def across(self, link, plant, runtime):
        own = f"{RUN_DIR.name}/runtime.txt"
        code, out, err = run(LINK, *link, "--", SIM, "--listen", "tcp:10.77.0.1:4560", *plant, "---", sys.executable,
                             "-c", WAIT, own, SINEW, "run", QUAD, "--plant", PLANT, "--name", f"network-{os.getpid()}",
                             *runtime)
        if code == 77:
            self.skipTest(err.strip())
        with open(own, encoding="utf-8") as f:
            return code, f.read(), out + err

    def free_running(self, link, plant, runtime):
        code, out, err = self.across(link, ["--free", *plant], [*runtime, "--json"])
        self.assertIn(code, (0, 1), err)
        return json.loads(out), out + err

    def test_lockstep_gives_the_same_bytes_as_on_one_machine_whatever_the_network_does(self):
        fly = ["--virtual", "--seed", "4", "--duration", "0.7", "--verbose"]
        _, here, _ = run(SINEW, "run", QUAD, *fly)
        self.assertGreaterEqual(len(hashes(here)), 10, here)
        _, there, err = self.across(["--delay-ms", "1", "--jitter-ms", "1", "--loss", "0.005"],
                                    ["--lockstep", "--wait", "60"], fly)
        self.assertEqual(hashes(there), hashes(here), there + err)

    def test_it_flies_in_real_time_and_knows_the_clock_of_the_plant_within_its_bound(self):
        # Both hosts share one clock here, so the true offset is known: zero.
        summary, text = self.free_running(["--delay-ms", "2", "--jitter-ms", "2", "--loss", "0.001"], [],
                                          ["--rate", "0.5", "--duration", "7"])
        self.assertLessEqual(abs(summary["clock_offset_s"]), summary["clock_bound_s"] + 1e-6, text)
        self.assertGreater(summary["clock_bound_s"], 1e-3, "half of 2 ms each way, at half the rate")
        self.assertGreater(summary["clock_exchanges"], 16, text)
        cycles = {t["name"]: t["cycles"] for t in summary["threads"]}
        self.assertGreater(cycles["stabilise"], 3000)
        bounds = {v["bound"] for v in summary["validity"]}
        self.assertGreaterEqual(bounds, {"plant_gap_ms", "arrival_gap_ms", "late_percent", "missed_percent", "clock_ms",
                                         "drift_ppm", "commands_dropped"})
        self.assertNotIn("link_down_ms", bounds, text)

    def test_a_network_that_was_gone_is_an_outage_and_the_run_goes_on(self):
        summary, text = self.free_running(["--delay-ms", "1", "--cut-after", "9", "--cut-for", "7"], ["--relink", "30"],
                                          ["--rate", "0.5", "--duration", "12"])
        down = [v for v in summary["validity"] if v["bound"] == "link_down_ms"]
        self.assertEqual(len(down), 1, text)
        self.assertFalse(down[0]["holds"])
        self.assertTrue(any("without a plant for" in reason for reason in summary["invalid_because"]), text)
        self.assertIn("invalid run", summary["result"])


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[5:]], verbosity=2)
