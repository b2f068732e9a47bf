"""`sinew sweep` and `sinew merge`, with short runs of two robots: what is told, what is kept over kills, and what is refused.

usage: sweep_test.py SINEW SINEW_SIM ROBOTS [CLASS]
"""
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

SINEW, SINEW_SIM, ROBOTS = map(os.path.abspath, sys.argv[1:4])
RUN_DIR = tempfile.TemporaryDirectory(prefix="sinew_run_")  # other tests run robots of the same names
os.environ["SINEW_RUN_DIR"] = RUN_DIR.name
TEMPORARY = tempfile.TemporaryDirectory(prefix="sinew_sweep_")  # a sweep that is killed leaves its files there
os.environ["TMPDIR"] = tempfile.tempdir = TEMPORARY.name
SEESAW, QUAD = f"{ROBOTS}/seesaw/seesaw.toml", f"{ROBOTS}/quad/quad.toml"
SHORT = (SEESAW, "--duration", "1")
# The camera of the quadrotor is gone: it lands off the pad.
MISSES = (QUAD, "--camera", "64x48", "--fault", "camera:off@6")


class InItsFolder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def path(self, name):
        return os.path.join(self.folder, name)

    def run_sinew(self, *arguments, program=SINEW, env=None):
        done = subprocess.run([program, *arguments], capture_output=True, text=True, timeout=500, cwd=self.folder,
                              env={**os.environ, **(env or {})})
        return done.returncode, done.stdout, done.stderr

    def sweep(self, *arguments, code=0, **options):
        done, out, err = self.run_sinew("sweep", *arguments, **options)
        self.assertEqual(done, code, out + err)
        return out, err

    def refusal(self, *arguments):
        done, out, err = self.run_sinew("sweep", *arguments)
        self.assertEqual((done, out), (2, ""), err)
        self.assertFalse(os.path.exists(self.path("runs")), "a refused sweep leaves nothing")
        return err

    def lines(self, name):
        with open(self.path(name), encoding="utf-8") as file:
            return [json.loads(line) for line in file]

    def bytes(self, name):
        with open(self.path(name), "rb") as file:
            return file.read()

    def program_that(self, script):
        """A folder with sinew and, in place of sinew-sim, this shell script."""
        place = self.path("bin")
        os.makedirs(place)
        os.link(SINEW, f"{place}/sinew") if os.stat(SINEW).st_dev == os.stat(place).st_dev else shutil.copy(SINEW, place)
        with open(f"{place}/sinew-sim", "w", encoding="utf-8") as file:
            file.write(f"#!/bin/sh\n{script}\n")
        os.chmod(f"{place}/sinew-sim", 0o755)
        return f"{place}/sinew"


class Told(InItsFolder):
    def test_a_table_of_outcomes_and_a_line_for_each_run(self):
        out, _ = self.sweep(*SHORT, "--seeds", "1..4", "--set", "balance.stiffness=6,8", "--results", "r.jsonl")
        self.assertRegex(out, r"good +8 +100\.0 % +67\.6 \.\. 100\.0 %")
        self.assertRegex(out, r"--set balance\.stiffness=6 +4 +4 ")
        self.assertIn("results  r.jsonl, 8 runs in ", out)
        header, *results = self.lines("r.jsonl")
        self.assertEqual(header["cases"], 8)
        self.assertEqual([r["case"] for r in results], list(range(8)))
        self.assertEqual(results[3]["run"], f"{SEESAW} --set balance.stiffness=8 --duration 1 --seed 2")

    def test_robot_files_and_files_of_parameters_are_combined(self):
        shutil.copy(SEESAW, self.path("seesaw.toml"))
        for name, text in (("mine.toml", 'extends = "seesaw.toml"\n[robot]\nname = "mine"\nseed = 7\n'),
                           ("soft.toml", "[balance]\nstiffness = 9\n")):
            with open(self.path(name), "w", encoding="utf-8") as file:
                file.write(text)
        out, _ = self.sweep("seesaw.toml", "mine.toml", "--params", "none,soft.toml", "--duration", "1", "--results", "r.jsonl")
        results = self.lines("r.jsonl")[1:]
        self.assertEqual([r["run"] for r in results],
                         [f"{robot}{params} --duration 1" for robot in ("seesaw.toml", "mine.toml")
                          for params in ("", " --params soft.toml")])
        self.assertRegex(out, r"mine\.toml --params soft\.toml +1 +1 ")
        self.assertEqual(len({r["hash"] for r in results}), 4, "each is another run")
        self.sweep("seesaw.toml", "--set", "balance.stiffness=9", "--duration", "1", "--results", "set.jsonl")
        self.assertEqual(self.lines("set.jsonl")[1]["hash"], results[1]["hash"], "the file's values are those of --set")

    def test_a_line_alone_repeats_its_run_with_the_same_hash(self):
        self.sweep(*SHORT, "--seeds", "3,5", "--results", "a.jsonl")
        self.sweep(*SHORT, "--seeds", "5", "--results", "b.jsonl")
        a, b = self.lines("a.jsonl")[2], self.lines("b.jsonl")[1]
        self.assertEqual({**a, "case": 0}, b)
        code, out, _ = self.run_sinew("run", *a["run"].split(), "--virtual", "--no-record", "--json")
        said = json.loads(out)
        self.assertEqual((code, said["mission"]["outcome"]), (a["code"], a["outcome"]))
        del said["report"]["verdict"]  # which the line has as outcome and measures
        self.assertEqual(a["report"], said["report"])
        self.assertEqual((a["report"]["world"], a["report"]["seed"]), ("seesaw", 5))

    def test_json_csv_and_plots(self):
        out, _ = self.sweep(*MISSES, "--fault", "none", "--seeds", "1..2", "--json", "--csv", "r.csv",
                            "--plot", "landing_error_m:seed", "-o", "p.svg", "--results", "r.jsonl", code=1)
        told = json.loads(out)
        self.assertEqual((told["runs"], told["good"]["runs"]), (4, 2))
        self.assertEqual([m["name"] for m in told["measures"]][0], "landing_error_m")
        self.assertEqual(told["measures"][0]["at_most"], 0.15)
        self.assertEqual(len(told["failures"]), 2)
        with open(self.path("r.csv"), encoding="utf-8") as file:
            rows = file.read().splitlines()
        self.assertRegex(rows[0], "^case,run,seed,good,code,outcome,why,landing_error_m")
        self.assertEqual(len(rows), 5)
        self.assertIn(b"</svg>", self.bytes("p.svg"))
        out, _ = self.sweep(*MISSES, "--fault", "none", "--seeds", "1..2", "--plot", "flight_s", "-o", "h.png",
                            "--results", "r.jsonl", code=1)
        self.assertTrue(self.bytes("h.png").startswith(b"\x89PNG"))
        self.assertIn("results  r.jsonl\n", out, "nothing was flown again")
        _, err = self.sweep(*MISSES, "--fault", "none", "--seeds", "1..2", "--plot", "flight", "-o", "h.png",
                            "--results", "r.jsonl", code=2)
        self.assertIn("--plot flight: no measure flight; there are: landing_error_m, touchdown_speed_mps, flight_s; did you mean flight_s?", err)

    def test_the_same_command_finds_its_own_file_and_another_one_its_own(self):
        folder = f"{self.folder}/runs/sweeps"
        self.sweep(*SHORT, "--seeds", "1..2")
        _, err = self.sweep(*SHORT, "--seeds", "1..2")
        self.assertRegex(err, r"runs/sweeps/seesaw-[0-9a-f]{8}\.jsonl has 2 of 2 runs")
        self.assertEqual(len(os.listdir(folder)), 1)
        self.sweep(*SHORT, "--seeds", "1..3")
        self.assertEqual(len(os.listdir(folder)), 2)

    def test_until_the_interval_is_narrow_a_prefix_of_the_cases_is_flown(self):
        self.sweep(*SHORT, "--seeds", "1..1000", "--until-width", "0.4", "--results", "r.jsonl", "--jobs", "3")
        cases = [r["case"] for r in self.lines("r.jsonl")[1:]]
        self.assertEqual(cases, list(range(6)))  # Wilson: 6 of 6 are 61 to 100 %, 5 of 5 are 57 to 100 %
        self.sweep(*SHORT, "--seeds", "1..1000", "--until-width", "0.3", "--results", "r.jsonl")
        self.assertGreater(len(self.lines("r.jsonl")), 9, "a narrower one goes on")

    def test_failures_are_recorded_and_compared_with_a_better_sweep(self):
        out, _ = self.sweep(*MISSES, "--seeds", "1..2", "--results", "bad.jsonl", "--record", "failures", code=1)
        self.assertRegex(out, r"failures\n  .*: .*\n    sinew run .*quad.toml --fault camera:off@6 --camera 64x48 --seed 1 --virtual\n")
        self.assertIn("recorded\n  bad-failures/case-0  ", out)
        self.assertNotIn("NOT THE SAME", out)
        for case in (0, 1):
            latest = self.path(f"bad-failures/case-{case}/latest/run.mcap")
            self.assertTrue(os.path.exists(latest), latest)
        out, _ = self.sweep(QUAD, "--camera", "64x48", "--seeds", "1..2", "--against", "bad.jsonl")
        self.assertIn("against bad.jsonl: 2 pairs by seed", out)
        self.assertIn("better 2, worse 0", out)
        self.assertRegex(out, r"landing_error_m +[0-9.]+ +[0-9.]+ +-[0-9.]+ +2 +0")

    def test_a_list_gives_the_options_of_each_run(self):
        with open(self.path("list"), "w", encoding="utf-8") as file:
            file.write("# runs\n--set balance.stiffness=6\n\n--seed 4 --set balance.stiffness=8 --set 'balance.damping=1.4'\n")
        self.sweep(*SHORT, "--list", "list", "--results", "r.jsonl")
        self.assertEqual([r["run"] for r in self.lines("r.jsonl")[1:]],
                         [f"{SEESAW} --duration 1 --set balance.stiffness=6",
                          f"{SEESAW} --duration 1 --seed 4 --set balance.stiffness=8 --set balance.damping=1.4"])

    def test_a_bad_run_says_the_sweep_that_repeats_it(self):
        code, out, _ = self.run_sinew("run", QUAD, "--virtual", "--no-record", "--camera", "64x48", "--fault", "camera:off@6",
                                      "--seed", "2")
        self.assertEqual(code, 1)
        self.assertLessEqual(out.count("\n"), 15, out)
        again = re.search(r"(?m)^again +sinew sweep (.*)$", out)
        self.assertTrue(again, out)
        swept, _ = self.sweep(*again[1].split(), code=1)
        self.assertIn(re.search(r"^mission +([^:]*):", out)[1], swept)


class Kept(InItsFolder):
    """What is left of a sweep that did not come to its end."""
    MANY = (SEESAW, "--duration", "3", "--seeds", "1..24", "--jobs", "2")

    def started(self, *arguments):
        sweep = subprocess.Popen([SINEW, "sweep", *arguments], cwd=self.folder, stdout=subprocess.PIPE,
                                 stderr=subprocess.PIPE, text=True, start_new_session=True)
        self.addCleanup(sweep.communicate)
        self.addCleanup(sweep.kill)
        return sweep

    def wait_for_lines(self, name, count):
        end = time.monotonic() + 200
        while time.monotonic() < end:
            if os.path.exists(self.path(name)) and self.bytes(name).count(b"\n") > count:
                return
            time.sleep(0.01)
        self.fail(f"{name} does not get {count} results")

    def test_after_kill_9_the_same_command_goes_on_to_the_same_bytes(self):
        def left():
            return [name for name in os.listdir(TEMPORARY.name) if name.startswith("sinew-pool-")]

        self.sweep(*self.MANY, "--results", "whole.jsonl")
        sweep = self.started(*self.MANY, "--results", "killed.jsonl")
        self.wait_for_lines("killed.jsonl", 3)
        sweep.kill()
        sweep.wait()
        self.assertTrue(left())
        there = self.bytes("killed.jsonl").count(b"\n") - 1
        with open(self.path("killed.jsonl"), "ab") as file:
            file.write(b'{"case":23,"run":"half a li')  # as a loss of power may leave it
        out, err = self.sweep(*self.MANY, "--results", "killed.jsonl")
        self.assertIn(f"killed.jsonl has {there} of 24 runs", err)
        self.assertIn(f", {24 - there} runs in ", out)
        self.assertEqual(self.bytes("killed.jsonl"), self.bytes("whole.jsonl"))
        self.assertEqual(left(), [], "the next sweep removes what the killed one left")

    def test_ctrl_c_tells_what_there_is_and_leaves_no_process(self):
        sweep = self.started(*self.MANY, "--results", "r.jsonl")
        self.wait_for_lines("r.jsonl", 3)
        os.killpg(sweep.pid, signal.SIGINT)  # as a terminal does
        out, err = sweep.communicate(timeout=60)
        self.assertEqual(sweep.returncode, 1, out + err)
        self.assertRegex(err, r"interrupted after \d+ of 24 runs; the same command goes on")
        self.assertRegex(out, r"\(\d+ of 24 runs\)")
        self.assertFalse(any('"interrupted' in str(r) for r in self.lines("r.jsonl")))
        with self.assertRaises(ProcessLookupError):
            os.killpg(sweep.pid, 0)

    def test_two_programs_do_not_write_one_file(self):
        sweep = self.started(*self.MANY, "--results", "r.jsonl")
        self.wait_for_lines("r.jsonl", 1)
        _, err = self.sweep(*self.MANY, "--results", "r.jsonl", code=2)
        self.assertIn("r.jsonl: another program writes it now", err)
        sweep.kill()

    def test_a_file_of_another_sweep_is_refused_with_what_differs(self):
        self.sweep(*SHORT, "--seeds", "1..2", "--results", "r.jsonl")
        before = self.bytes("r.jsonl")
        _, err = self.sweep(*SHORT, "--seeds", "1..3", "--results", "r.jsonl", code=2)
        self.assertIn("r.jsonl: results of another sweep: cases: 2 there, 3 here; seeds: 1..2 there, 1..3 here", err)
        robot = self.path("seesaw.toml")
        shutil.copy(SEESAW, robot)
        self.sweep("seesaw.toml", "--duration", "1", "--results", "own.jsonl")
        with open(robot, "a", encoding="utf-8") as file:
            file.write("# changed\n")
        _, err = self.sweep("seesaw.toml", "--duration", "1", "--results", "own.jsonl", code=2)
        self.assertRegex(err, r"results of another sweep: contents\.seesaw\.toml: [0-9a-f]{16} there, [0-9a-f]{16} here")
        self.assertEqual(self.bytes("r.jsonl"), before)

    def test_shards_in_any_order_and_repeated_are_the_undivided_sweep(self):
        seeds = (*SHORT, "--seeds", "1..7")
        self.sweep(*seeds, "--results", "whole.jsonl")
        for i in (2, 1, 3, 2):
            self.sweep(*seeds, "--shard", f"{i}/3", "--results", f"{i}.jsonl")
        for order in (["1.jsonl", "2.jsonl", "3.jsonl"], ["3.jsonl", "1.jsonl", "2.jsonl", "3.jsonl"]):
            code, out, err = self.run_sinew("merge", *order, "--into", "merged.jsonl")
            self.assertEqual(code, 0, err)
            self.assertRegex(out, r"good +7 ")
            self.assertEqual(self.bytes("merged.jsonl"), self.bytes("whole.jsonl"))
            os.remove(self.path("merged.jsonl"))
        code, out, err = self.run_sinew("merge", "1.jsonl", "3.jsonl", "--into", "part.jsonl")
        self.assertEqual(code, 1)
        self.assertIn("2 of 7 runs are missing, such as case 1, 4; ", err)
        out, _ = self.sweep(*seeds, "--results", "part.jsonl")
        self.assertEqual(self.bytes("part.jsonl"), self.bytes("whole.jsonl"))


class Refused(InItsFolder):
    def test_a_crash_and_a_hang_of_a_run_are_results(self):
        # The simulator kills the run that started it, or keeps it waiting.
        for script, patience, outcome in (("kill -11 $PPID", "60", "crashed: signal 11 (Segmentation fault)"),
                                          ("exec sleep 1000", "1", "hung: no end within 1 s")):
            with self.subTest(outcome):
                program = self.program_that(script)
                out, _ = self.sweep(*SHORT, "--seeds", "1..2", "--patience", patience, "--results", "r.jsonl", code=1,
                                    program=program)
                self.assertRegex(out, re.escape(f"BAD: {outcome}") + r" +2 ")
                self.assertEqual([r["outcome"] for r in self.lines("r.jsonl")[1:]], [outcome, outcome])
                shutil.rmtree(self.path("bin"))
                os.remove(self.path("r.jsonl"))

    def test_a_run_that_cannot_begin_is_no_result(self):
        program = self.program_that("echo no display >&2; exit 2")
        _, err = self.sweep(*SHORT, "--seeds", "1..2", "--results", "r.jsonl", code=2, program=program)
        self.assertRegex(err, r"sinew: sinew run .*seesaw\.toml --duration 1 --seed \d --virtual: (.|\n)*no display")
        self.assertEqual(len(self.lines("r.jsonl")), 1)

    def test_bad_input_is_refused_before_anything_flies(self):
        for arguments, words in (
                (["--seeds", "1..x"], "--seeds 1..x: whole numbers, as 1..1000, 3,5,7 or 1..10,20"),
                (["--seeds", "5..1"], "--seeds 5..1: whole numbers"),
                (["--seeds", "1..5,3"], "--seeds 1..5,3: seed 3 is named twice"),
                (["--seeds", "-1"], "--seeds"),
                (["--set", "balance.stiffness=1,-5"], "--set balance.stiffness=-5"),
                (["--set", "balance.stifness=1,2"], "balance.stifness"),
                (["--set", "balanse.kp=1"], "no module balanse; there are:"),
                (["--set", "balance.stiffness"], "--set balance.stiffness: MODULE.PARAM=FROM:TO:COUNT, the same with :log, or MODULE.PARAM=A,B,C"),
                (["--set", "balance.stiffness=1:2:0"], "\"0\": a count from 1 to 100000"),
                (["--set", "balance.stiffness=1", "--set", "balance.stiffness=2"], "balance.stiffness is set twice"),
                (["--fault", "imu:wobbly@5"], "--fault imu:wobbly@5: "),
                (["--fault", "none", "--fault", "none"], "--fault none: named twice"),
                (["--params", "nowhere.toml"], "nowhere.toml"),
                (["--list", "nowhere"], "nowhere: No such file"),
                (["--shard", "3/2"], "--shard 3/2: NUMBER/COUNT, as 2/5"),
                (["--shard", "1/2", "--until-width", "0.1"], "--shard excludes --until-width"),
                (["--until-width", "0"], "--until-width"),
                (["--record", "all"], "failures"),
                (["--jobs", "-1"], "-1 is not an integer from 0 to 4096"),
                (["--plot", "x"], "--output"),
                (["--plot", "x", "-o", "x.gif"], "x.gif"),
                (["--camera", "1x1"], "--camera 1x1: WIDTHxHEIGHT"),
                ([SEESAW], "named twice"),
                (["nowhere.toml"], "nowhere.toml"),
                (["--seedz", "1"], "did you mean --seeds?")):
            self.assertIn(words, self.refusal(*SHORT, *arguments), arguments)
        for line, words in (("--fly 1", "list:1: --fly: options of one run: --seed, --set, --fault, --params, --camera, --duration"),
                            ("--set", "list:1: --set: without a value"),
                            ("--set 'a", "list:1: a quote has no end"),
                            ("--duration 2", "list:1: --duration: is given for all runs already"),
                            ("--set balance.stiffness=-5", "list:1: --set balance.stiffness=-5: refused, see above"),
                            ("# nothing", "list: it names no run")):
            with open(self.path("list"), "w", encoding="utf-8") as file:
                file.write(line + "\n")
            self.assertIn(words, self.refusal(*SHORT, "--list", "list"), line)
        with open(self.path("list"), "w", encoding="utf-8") as file:
            file.write("--seed 1\n")
        self.assertIn("list:1: --seed: the seeds come from --seeds", self.refusal(*SHORT, "--seeds", "1..2", "--list", "list"))

    def test_merge_refuses_what_does_not_fit(self):
        self.sweep(*SHORT, "--seeds", "1..2", "--results", "a.jsonl")
        self.sweep(*SHORT, "--seeds", "1..3", "--results", "b.jsonl")
        code, _, err = self.run_sinew("merge", "a.jsonl", "b.jsonl", "--into", "c.jsonl")
        self.assertEqual(code, 2)
        self.assertIn("a.jsonl and b.jsonl are of different sweeps: cases: 2 there, 3 here", err)
        with open(self.path("a.jsonl"), encoding="utf-8") as file:
            changed = file.read().replace('"good":true', '"good":false', 1)
        with open(self.path("d.jsonl"), "w", encoding="utf-8") as file:
            file.write(changed)
        code, _, err = self.run_sinew("merge", "a.jsonl", "d.jsonl", "--into", "c.jsonl")
        self.assertEqual(code, 2)
        self.assertIn("case 0 has two results, in a.jsonl and in d.jsonl: the runs do not repeat", err)
        self.assertFalse(os.path.exists(self.path("c.jsonl")))

    def test_merge_replaces_no_file_of_others_and_keeps_the_cases_that_are_there(self):
        for i in (1, 2, 3):
            self.sweep(*SHORT, "--seeds", "1..3", "--shard", f"{i}/3", "--results", f"{i}.jsonl")
        with open(self.path("notes.txt"), "w", encoding="utf-8") as file:
            file.write("mine\n")
        code, _, err = self.run_sinew("merge", "1.jsonl", "--into", "notes.txt")
        self.assertEqual(code, 2)
        self.assertIn("notes.txt: not a file of results of a sweep", err)
        self.assertEqual(self.bytes("notes.txt"), b"mine\n")
        self.run_sinew("merge", "1.jsonl", "2.jsonl", "--into", "all.jsonl")
        code, out, err = self.run_sinew("merge", "3.jsonl", "--into", "all.jsonl")
        self.assertEqual(code, 0, err)
        self.assertRegex(out, r"good +3 ")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
