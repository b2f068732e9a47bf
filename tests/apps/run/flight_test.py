"""Flies whole robots through the `sinew` program: the same seed gives the same bytes, and no step makes a trapped call."""
import json
import os
import re
import resource
import subprocess
import sys
import tempfile
import unittest

os.environ.setdefault("SINEW_RECORD", "off")  # a flight is 100 MB; recordings have tests of their own

SINEW, TRAPPED, ROBOTS = sys.argv[1:4]
LIMIT_S = 300
SMALL = ("--camera", "64x48")  # where nothing depends on the picture
RUN_DIR = tempfile.TemporaryDirectory()  # robots of other tests cannot meet this program's
os.environ["SINEW_RUN_DIR"] = RUN_DIR.name


def run(program, *arguments):
    done = subprocess.run([program, *arguments], capture_output=True, text=True, timeout=LIMIT_S)
    return done.returncode, done.stdout, done.stderr


def hashes(text):
    return re.findall(r"^hash (\S+)\s+([0-9a-f]{16})$", text, re.M)


class Flight(unittest.TestCase):
    def fly(self, program, *arguments):
        code, out, err = run(program, "run", f"{ROBOTS}/quad/quad.toml", "--virtual", "--verbose", *arguments)
        self.assertEqual(code, 0, out + err)
        return out

    def test_lands_on_the_pad_and_the_same_seed_gives_the_same_bytes_on_every_topic(self):
        # The program with the trap: a call that a step must not make would end it.
        told = self.fly(TRAPPED, "--seed", "3")
        self.assertIn("mission   landed on the pad: landing error ", told)
        self.assertGreaterEqual(len(hashes(told)), 13)
        summary = json.loads(self.fly(SINEW, "--seed", "3", "--json"))  # the whole summary is one JSON object
        self.assertEqual(summary["hashes"], dict(hashes(told)))
        self.assertEqual(summary["result"], "landed on the pad, valid run")
        self.assertEqual(summary["exit_code"], 0)
        self.assertEqual(summary["invalid_because"], [])
        self.assertLess(summary["landing_error_m"], 0.15)
        self.assertGreater(summary["run_s"], 10)
        self.assertEqual({t["name"] for t in summary["threads"]} & {"guardian", "stabilise"}, {"guardian", "stabilise"})
        self.assertEqual(set(summary["hashes"]), {t["name"] for t in summary["topics"]})
        self.assertTrue(all(c["missed"] >= 0 and c["age_ns"]["count"] > 0 for c in summary["chains"]))

    def test_the_time_line_of_the_last_second_is_a_trace(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "trace.json")
            run(SINEW, "run", f"{ROBOTS}/quad/quad.toml", "--virtual", *SMALL, "--duration", "2", "--trace", path)
            with open(path) as file:
                events = json.load(file)["traceEvents"]
            slices = [e for e in events if e["ph"] == "X"]
            self.assertGreater(min(e["ts"] for e in slices), 0.9e6)
            self.assertLess(max(e["ts"] + e["dur"] for e in slices), 2.0e6 + 1)
            names = {e["name"] for e in slices}
            self.assertLessEqual({"cycle", "imu", "pad", "guardian", "preempted", "segment"}, names)
            code, _, err = run(SINEW, "run", f"{ROBOTS}/quad/quad.toml", "--virtual", "--duration", "0.1", "--trace", folder)
            self.assertEqual(code, 2, "said before the flight")
            self.assertIn("Is a directory", err)

    def test_a_chain_that_misses_its_age_budget_fails_the_run(self):
        with open(f"{ROBOTS}/quad/quad.toml") as file:
            text = file.read()
        self.assertIn("budget_ms = 120", text)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "late.toml")
            with open(path, "w") as file:
                file.write(text.replace("budget_ms = 120", "budget_ms = 20"))
            code, out, err = run(SINEW, "run", path, "--virtual", "--verbose", *SMALL)
        self.assertEqual(code, 1, out + err)
        self.assertIn("mission   landed on the pad, but a chain missed its age budget: ", out)
        self.assertRegex(out, r"chain imu_to_motors .* pass\n")
        self.assertRegex(out, r"chain camera_to_motors .* FAIL\n")
        self.assertRegex(out, r"age budget +chain camera_to_motors: \d+ of \d+ messages older than 20 ms, 0 allowed")

    def test_another_seed_is_another_flight(self):
        one, two = (run(SINEW, "run", f"{ROBOTS}/quad/quad.toml", "--virtual", *SMALL, "--seed", seed, "--duration", "2",
                        "--verbose")[1] for seed in "12")
        self.assertNotEqual(dict(hashes(one))["imu.raw"], dict(hashes(two))["imu.raw"])

    def test_a_fault_strikes_and_is_named_and_the_same_fault_gives_the_same_bytes(self):
        arguments = [*SMALL, "--seed", "3", "--duration", "4", "--verbose", "--fault", "imu:garbage@2+0.01", "--fault", "link:off@3"]
        first = run(SINEW, "run", f"{ROBOTS}/quad/quad.toml", "--virtual", *arguments)[1]
        self.assertIn("fault               imu:garbage@2..2.01: struck 10 times", first)
        self.assertRegex(first, r"fault +link:off@3: struck \d\d\d\d+ times")
        self.assertEqual(hashes(first), hashes(run(SINEW, "run", f"{ROBOTS}/quad/quad.toml", "--virtual", *arguments)[1]))

    def test_a_run_that_does_not_land_fails(self):
        code, out, _ = run(SINEW, "run", f"{ROBOTS}/quad/quad.toml", "--virtual", *SMALL, "--duration", "3")
        self.assertEqual(code, 1)
        self.assertIn("did not land", out)

    def test_the_runtime_flies_in_real_time(self):
        # Where the host takes its processors away the flight may be invalid or end elsewhere; that the program runs,
        # stops and reports is what a shared machine can promise.
        code, out, err = run(SINEW, "run", f"{ROBOTS}/quad/quad.toml", *SMALL, "--duration", "3", "--plain", "--verbose")
        self.assertEqual(code, 1, out + err)
        self.assertRegex(out, r"stabilise +\d\d+ cycles", err)
        self.assertIn("mission   did not land\ntiming    ", out)
        self.assertIn("longest IMU gap", out)

    def test_the_longest_imu_gap_of_a_slower_flight_is_in_the_time_that_its_bound_is_in(self):
        code, out, err = run(SINEW, "run", f"{ROBOTS}/quad/quad.toml", *SMALL, "--rate", "0.25", "--duration", "0.4",
                             "--json")
        self.assertEqual(code, 1, out + err)
        summary = json.loads(out)
        judged = [v["value"] for v in summary["validity"] if v["bound"] == "plant_gap_ms"]
        self.assertEqual(judged, [1e3 * summary["imu_gap_max_s"]])
        self.assertGreater(judged[0], 0)


    def test_a_timing_that_is_no_measurement_fails_a_strict_run_only(self):
        with tempfile.TemporaryDirectory() as folder:
            looker = os.path.join(folder, "looker.toml")  # it has no mission to fail
            with open(looker, "w") as file:
                file.write('robot = { name = "looker", board = "sim" }\n'
                           'sim = { world = "quad", bounds = { plant_gap_ms = 0.001 } }\n'
                           'module = { imu = { type = "drivers::ImuSource" } }\n'
                           'thread = [{ name = "loop", priority = 0, period_us = 1000, order = ["imu"] }]\n')
            command = ("run", looker, "--duration", "0.2", "--camera", "64x48", "--json")
            code, out, err = run(SINEW, *command)
            summary = json.loads(out)
            self.assertEqual((code, summary["exit_code"], summary["timing"]["valid"]), (0, 0, False), err)
            code, out, err = run(SINEW, *command, "--strict")
        if code == 2:  # most machines, which have no PREEMPT_RT
            self.assertIn("--strict: not started", err)
        else:
            self.assertEqual((code, json.loads(out)["exit_code"]), (1, 1), err)


class Told(unittest.TestCase):
    """What a run prints at its end, in virtual time: the same flight, the same text."""

    def end_of(self, *arguments, code):
        got, out, err = run(SINEW, "run", f"{ROBOTS}/quad/quad.toml", "--virtual", *SMALL, *arguments)
        self.assertEqual(got, code, out + err)
        self.assertEqual(err, "")
        # How long the machine took is its own business.
        lines = re.sub(r" in [0-9.]+ s$", " in T s", out, flags=re.M).splitlines()
        self.assertLessEqual(len(lines), 15, out)
        return lines

    def test_a_good_flight_is_its_result_its_phases_and_what_to_do_next(self):
        lines = self.end_of("--seed", "3", code=0)
        self.assertRegex(lines[0], r"^mission   landed on the pad: landing error 0\.\d+ m \(at most 0\.15\), touchdown speed "
                                   r"0\.\d+ m/s \(at most 0\.5\), flight time 1\d\.\d s$")
        self.assertRegex(lines[1], r"^timing    valid as a measurement; virtual time, 1\d\.\d{3} s in T s$")
        self.assertEqual([re.sub(r"^ +[0-9.]+ s  ", "", line) for line in lines[2:-1]],
                         ["waiting", "arming", "climbing", "searching the pad", "approaching the pad",
                          "holding above the pad", "descending", "touching down", "done"])
        times = [float(line.split()[0]) for line in lines[2:-1]]
        self.assertEqual(times, sorted(times))
        self.assertEqual(lines[-1], "next      --verbose prints threads, modules, topics and hashes, too")

    def test_a_flight_that_missed_says_by_how_much_and_why(self):
        lines = self.end_of("--seed", "2", "--plant-arg=--gust=8", code=1)
        self.assertRegex(lines[0], r"^mission   landed off the pad: landing error 0\.\d+ m \(at most 0\.15\), ")
        why = [line for line in lines if line.startswith("why ")]
        self.assertEqual(len(why), 1, lines)
        self.assertRegex(why[0], r"^why       landing error 0\.\d+ m \(at most 0\.15\); strongest wind [\d.]+ m/s \(at most 2\)$")

    def test_a_failsafe_is_told_with_its_time_its_cause_and_its_action(self):
        lines = self.end_of("--seed", "3", "--fault", "camera:off@6", code=1)
        self.assertIn("    6.5 s  camera_lost: camera.raw silent for 500 ms -> land", lines)
        self.assertTrue(any(re.match(r"^    6\.0 s  fault camera:off@6: struck \d+ times$", line) for line in lines), lines)
        self.assertIn("    6.5 s  aborted", lines)
        self.assertTrue(any(line.startswith("why ") and line.endswith("failsafe camera_lost acted") for line in lines), lines)

    def test_quiet_is_one_line_and_verbose_has_the_tables(self):
        short = ("--seed", "3", "--duration", "2")
        self.assertEqual(self.end_of("--quiet", *short, code=1), ["mission   did not land"])
        code, out, _ = run(SINEW, "run", f"{ROBOTS}/quad/quad.toml", "--virtual", *SMALL, "--verbose", *short)
        self.assertEqual(code, 1)
        self.assertIn("why       the run ended after 2.0 s while waiting; all conditions were within their limits: strongest "
                      "wind ", out)
        self.assertRegex(out, r"\nthreads\n  guardian +\d+ cycles")
        self.assertGreaterEqual(len(hashes(out)), 13)

    def test_json_has_both_verdicts_and_the_story(self):
        code, out, _ = run(SINEW, "run", f"{ROBOTS}/quad/quad.toml", "--virtual", *SMALL, "--json", "--duration", "2")
        said = json.loads(out)
        self.assertEqual((code, said["exit_code"], said["result"]), (1, 1, "did not land, valid run"))
        self.assertEqual((said["mission"]["outcome"], said["mission"]["good"]), ("did not land", False))
        self.assertEqual(said["timing"], {"valid": True, "worst": "", "what_to_do": ""})
        self.assertEqual(said["story"][0]["text"], "waiting")
        self.assertLess(said["story"][0]["at_s"], 1)


class TwoRobots(unittest.TestCase):
    def test_a_second_robot_of_the_same_name_is_refused_and_told_who_holds_it(self):
        command = [SINEW, "run", f"{ROBOTS}/quad/quad.toml", *SMALL, "--name", "twin", "--duration", "60", "--plain"]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT) as first:
            while not os.path.exists(f"{RUN_DIR.name}/twin.sock"):
                self.assertIsNone(first.poll())
            code, _, err = run(*command)
            first.terminate()
            first.communicate()
        self.assertEqual(code, 2)
        self.assertRegex(err, r'robot "twin" runs already, as process \d+')


class Unprivileged(unittest.TestCase):
    """Without the right to fixed priorities and to much locked memory, for any user."""

    def run_without(self, *arguments):
        drop = [] if os.geteuid() != 0 else ["setpriv", "--bounding-set=-all", "--inh-caps=-all"]

        def limit():
            resource.setrlimit(resource.RLIMIT_RTPRIO, (0, 0))
            resource.setrlimit(resource.RLIMIT_MEMLOCK, (65536, 65536))

        done = subprocess.run([*drop, SINEW, *arguments], capture_output=True, text=True, timeout=LIMIT_S,
                              preexec_fn=limit)
        return done.returncode, done.stdout, done.stderr

    def test_everything_runs_and_what_is_missing_is_said(self):
        # Without fixed priorities a busy machine may keep the guardian waiting until a parent would call it dead.
        code, out, err = self.run_without("run", f"{ROBOTS}/quad/quad.toml", *SMALL, "--duration", "2", "--plain", "--verbose",
                                         "--unsupervised")
        self.assertEqual(code, 1, out + err)  # it flew, but two seconds are no landing
        self.assertRegex(out, r"stabilise +\d\d+ cycles", err)
        self.assertIn("problem: sched_fifo: this process may not use fixed priorities", err)
        self.assertIn("problem: memory_lock: ", err)
        self.assertIn("sinew doctor says what to do", err)
        self.assertRegex(err, r"(?m)^warning: thread stabilise: SCHED_FIFO refused")
        if "ASAN_OPTIONS" not in os.environ:  # under the address sanitizer locking does nothing, but reports success
            self.assertRegex(err, r"(?m)^warning: memory is not locked")

    def test_strict_refuses_to_start(self):
        code, out, err = self.run_without("run", f"{ROBOTS}/quad/quad.toml", "--duration", "2", "--plain", "--strict")
        self.assertEqual(code, 2, out + err)
        self.assertIn("--strict: not started", err)
        self.assertNotIn("cycles", out)

    def test_virtual_time_needs_no_privilege(self):
        code, out, err = self.run_without("run", f"{ROBOTS}/quad/quad.toml", "--virtual", *SMALL, "--duration", "1", "--strict")
        self.assertEqual(code, 1, out + err)
        self.assertEqual(err, "")

    def test_doctor_names_the_problem_and_what_to_do(self):
        code, out, _ = self.run_without("doctor", f"{ROBOTS}/quad/quad.toml")
        self.assertEqual(code, 1)
        self.assertRegex(out, r"problem +sched_fifo")
        self.assertIn("setcap cap_sys_nice", out)


class RecordedFlight(unittest.TestCase):
    def setUp(self):
        self.folder = os.environ.get("SINEW_DATA", "")
        if not os.path.isfile(os.path.join(self.folder, "groundtruth.csv")):
            self.skipTest("SINEW_DATA names no folder with imu0.csv and groundtruth.csv: the recorded flight was not run")

    def tilt(self, *arguments):
        code, out, err = run(SINEW, "run", f"{ROBOTS}/mav_dataset/mav_dataset.toml", "--data", self.folder, "--virtual", "--verbose", *arguments)
        self.assertEqual(code, 0, out + err)
        return float(re.search(r"tilt error +([0-9.]+) deg RMS", out).group(1)), out

    def test_tilt_stays_below_two_degrees_also_from_mid_flight(self):
        for start in ("0", "10", "20", "30"):
            self.assertLess(self.tilt("--from", start)[0], 2.0, start)

    def test_a_standing_vehicle_shows_no_motion(self):
        self.assertRegex(self.tilt()[1], r"motion field +\d+ fields, 0 report motion")

    def test_the_same_record_gives_the_same_bytes(self):
        self.assertEqual(hashes(self.tilt()[1]), hashes(self.tilt()[1]))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]], verbosity=2)
