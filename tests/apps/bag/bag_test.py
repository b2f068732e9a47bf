"""sinew bag on the recording of a flight: what it prints, and the files that it makes.

usage: bag_test.py SINEW ROBOT_FILE [unittest arguments]

With SINEW_KEEP_FILES the files stay in that folder alone, for foreign readers (tests/record/others_flight_test.py).
"""
import csv
import functools
import glob
import hashlib
import io
import json
import os
import re
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import zlib

SINEW, QUAD = sys.argv[1:3]
FOLDER = tempfile.TemporaryDirectory(prefix="sinew_bag_")
RUN_DIR = tempfile.TemporaryDirectory(prefix="sinew_run_")  # other tests run robots of the same names
os.environ["SINEW_RUN_DIR"] = RUN_DIR.name
os.environ.pop("SINEW_RECORD", None)


def run(*arguments, **options):
    done = subprocess.run([SINEW, *arguments], capture_output=True, text=True, timeout=300, **options)
    return done.returncode, done.stdout, done.stderr


def path(name):
    return f"{FOLDER.name}/{name}"


def bag(*arguments):
    return run("bag", *arguments)


def fly(name, seconds, *more, camera="64x48"):
    code, out, err = run("run", QUAD, "--virtual", "--duration", seconds, "--camera", camera, "--runs", path(name),
                         *more)
    # So few seconds are no landing; the recording is what counts.
    runs = [run for run in os.listdir(path(name)) if run != "latest"] if os.path.isdir(path(name)) else []
    if len(runs) != 1:
        raise RuntimeError(f"{code} {out} {err}")
    shutil.copy(path(f"{name}/{runs[0]}/run.mcap"), path(f"{name}.mcap"))
    return path(f"{name}.mcap")


def setUpModule():
    global FLIGHT, LONG, GUSTY
    FLIGHT = fly("flight", "2")
    # It begins to search, every topic has messages (the motion field sees nothing in smaller pictures), and a part of it
    # has saved states of every module.
    LONG = fly("long", "7", camera="128x96")
    GUSTY = fly("gusty", "5", "--seed", "2", "--set", "sim.gust_mps=2.5", "--plant-arg=--wind=1", "--fault",
                "baro:off@4")


def tearDownModule():
    keep = os.environ.get("SINEW_KEEP_FILES")
    if keep:
        shutil.rmtree(keep, ignore_errors=True)
        os.makedirs(keep)
        for name in os.listdir(FOLDER.name):
            if name.endswith(".mcap") and not name.startswith("damaged") and not os.path.islink(path(name)):
                shutil.move(path(name), f"{keep}/bag-{name}")
    FOLDER.cleanup()
    RUN_DIR.cleanup()


def cat(file, *arguments):
    code, out, err = bag("cat", file, *arguments)
    if code != 0:
        raise AssertionError(err)
    return [json.loads(line) for line in out.splitlines()]


@functools.cache
def whole_flight():
    """Every message of FLIGHT, for all tests; nobody changes it."""
    return cat(FLIGHT)


def digest(file):
    with open(file, "rb") as f:
        return hashlib.sha256(f.read()).digest()


def cut_off(name, part):
    with open(FLIGHT, "rb") as whole, open(path(name), "wb") as head:
        head.write(whole.read()[:int(os.path.getsize(FLIGHT) * part)])
    return path(name)


class Bag(unittest.TestCase):
    def make(self, *arguments):
        """A file made by a command, which must be whole."""
        code, out, err = bag(*arguments, "--json")
        self.assertEqual((code, [line for line in err.splitlines() if ": note: " not in line]), (0, []))
        made = json.loads(out)
        self.assertEqual(made["problems"], [])
        self.assertTrue(json.loads(bag("info", made["file"], "--json")[1])["whole"])
        self.assertEqual(bag("check", made["file"])[0], 0)
        return made

    def test_info_says_what_is_there_and_what_ran(self):
        code, out, _ = bag("info", FLIGHT)
        self.assertEqual(code, 0)
        self.assertRegex(out, r"(?m)^imu.raw +sinew_msgs/msg/ImuSample +1999 +1000$")
        self.assertRegex(out, r"(?m)^  robot +quad$")
        info = json.loads(bag("info", FLIGHT, "--json")[1])
        self.assertTrue(info["whole"])
        self.assertEqual(info["bytes"], os.path.getsize(FLIGHT))
        self.assertEqual((info["run"]["robot"], info["run"]["board"], info["run"]["seed"]), ("quad", "sim", "1"))
        self.assertIn("sinew ", info["run"]["build"])
        self.assertEqual(info["attachments"][0]["bytes"], os.path.getsize(QUAD))
        self.assertEqual(info["messages"], sum(t["messages"] for t in info["topics"]))
        self.assertEqual(set(info["compression"]), {"lz4", "none"})
        self.assertEqual(set(info["verdict"].values()), {"replayable"})
        self.assertEqual((info["losses"], info["problems"]), ({}, []))
        self.assertAlmostEqual(info["duration_s"], 2, delta=0.01)

    def test_info_says_what_was_asked_of_the_world_and_how_it_went(self):
        info = json.loads(bag("info", GUSTY, "--json")[1])
        self.assertEqual(info["options"], ["--seed 2", "--duration 5", "--set sim.gust_mps=2.5",
                                           "--plant-arg --wind=1", "--fault baro:off@4", "--camera 64x48"])
        world = info["world"]
        self.assertEqual((world["world"], world["seed"], world["gust_mps"], world["wind_mps"], world["camera"]),
                         ("quad", "2", "2.5", "1", "64x48"))
        self.assertEqual((info["plant_arguments"], info["faults"]), (["--wind=1"], ["baro:off@4"]))
        result = info["result"]
        self.assertEqual((result["end"], result["exit_code"], result["outcome"]), ("over", "1", "did not land"))
        self.assertIn("the run ended after 5.0 s while climbing", result["why"])
        self.assertAlmostEqual(float(result["ended_s"]), 5, delta=0.01)
        self.assertNotIn("no_result", info)
        self.assertEqual(info["report"]["faults"][0]["device"], "baro")
        self.assertGreater(info["report"]["faults"][0]["affected"], 10)
        text = bag("info", GUSTY)[1]
        for line in (r"  --set sim.gust_mps=2.5", r"  gust_mps +2.5", r"  baro:off@4", r"  outcome +did not land",
                     r"  fault +baro:off@4: struck \d+ times, first after 4.\d+ s"):
            self.assertRegex(text, f"(?m)^{line}$")
        self.assertEqual(json.loads(bag("info", FLIGHT, "--json")[1])["faults"], [])

    def test_the_simulators_truth_is_recorded_at_its_own_rate(self):
        truth = cat(GUSTY, "--topic", "ground_truth")
        self.assertAlmostEqual(len(truth), 500, delta=2)
        self.assertEqual({t["message"]["stamp"] % 10_000_000 for t in truth}, {0})
        self.assertGreater(truth[-1]["message"]["p_world_m"]["z"], 0.3, "it has climbed")
        self.assertEqual(truth[-1]["message"]["position_valid"], 1)

    def test_a_run_that_was_interrupted_says_so(self):
        # In real time, since a flight in virtual time may be over before this busy machine has sent the signal.
        process = subprocess.Popen([SINEW, "run", QUAD, "--camera", "64x48", "--runs", path("stopped")],
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        for _ in range(600):
            if any(os.path.getsize(file) > 300_000 for file in glob.glob(path("stopped/*/run.mcap"))):
                break
            time.sleep(0.05)
        process.send_signal(signal.SIGINT)
        process.wait(60)
        result = json.loads(bag("info", glob.glob(path("stopped/*/run.mcap"))[0], "--json")[1])["result"]
        self.assertEqual(result["end"], "interrupted")
        self.assertRegex(result["why"], "^interrupted while [a-z ]+$")

    def test_two_flights_are_compared_from_a_common_event_on(self):
        code, out, err = bag("compare", LONG, GUSTY, "--json", "--plot", path("two.svg"))
        self.assertEqual((code, err), (0, ""))
        two = json.loads(out)
        self.assertEqual((two["from_event"], two["a"]["file"], two["b"]["file"]), ("climbing", LONG, GUSTY))
        events = {e["text"]: e for e in two["events"]}
        self.assertEqual((events["climbing"]["a_s"], events["climbing"]["b_s"]), (0, 0))
        self.assertIsNone(events["searching the pad"]["b_s"], "only the long flight came so far")
        self.assertIsNone(events["fault baro:off@4"]["a_s"])
        self.assertGreater(events["fault baro:off@4"]["b_s"], 0)
        fields = {f["name"]: f for f in two["fields"]}
        for name in ("filter.state.p_world_m.z", "ground_truth.p_world_m.z", "ground_truth.q_world_base.tilt"):
            self.assertGreater(fields[name]["rms"], 0, name)
            self.assertGreaterEqual(fields[name]["max"], fields[name]["rms"], name)
        self.assertLess(fields["ground_truth.p_world_m.z"]["max"], 1, "both climb alike")
        with open(path("two.svg")) as f:
            drawn = f.read()
        self.assertIn("filter.state.p_world_m.z: B is", drawn)
        for mark in ("A climbing", "B climbing", "B fault baro"):
            self.assertEqual(drawn.count(f">{mark}"), 1, "in the first of the plots")
        self.assertEqual(bag("compare", LONG, GUSTY, "--plot", path("two.svg"))[0], 2, "nothing is overwritten")
        text = bag("compare", LONG, GUSTY, "--field", "range_m")[1]
        self.assertRegex(text, r"(?m)^event, in s from climbing +A +B +B - A$")
        self.assertRegex(text, r"(?m)^climbing +0.000 +0.000 +\+0.000$")

    def test_a_flight_differs_in_nothing_from_itself(self):
        code, out, _ = bag("compare", GUSTY, GUSTY, "--json", "--from-event", "start", "--field", "filter.state",
                           "--field", "mission.mission.phase")
        two = json.loads(out)
        self.assertEqual((code, two["from_event"]), (0, "start"))
        self.assertEqual({f["max"] for f in two["fields"]}, {0})
        self.assertGreater(len(two["fields"]), 20)
        self.assertTrue(all(e["a_s"] == e["b_s"] for e in two["events"]))

    def test_compare_takes_types_that_only_the_files_define(self):
        code, out, err = bag("compare", LONG, GUSTY, "--json", "--field", "camera.raw/head.width")
        self.assertEqual((code, err), (0, ""))
        field, = json.loads(out)["fields"]
        self.assertEqual((field["name"], field["max"]), ("camera.raw/head.width", 128 - 64), "of their cameras")
        self.assertGreater(field["messages"], 60)

    def test_what_two_flights_do_not_share_is_refused_with_what_they_do(self):
        for arguments, words in ((("--from-event", "climbin"), ["an event of both flights: start", "did you mean climbing?"]),
                                 (("--field", "filter.state.p_wrld_m.z"), ["no field", "filter.state.p_world_m.z?"]),
                                 (("--plot", path("two.pdf")), ["two.pdf: FILE.svg or FILE.png"])):
            code, out, err = bag("compare", LONG, GUSTY, *arguments)
            self.assertEqual((code, out), (2, ""))
            for word in words:
                self.assertIn(word, err)

    def test_info_of_several_files_is_about_each_of_them_once(self):
        os.symlink(FLIGHT, path("again.mcap"))
        code, out, err = bag("info", FLIGHT, LONG, path("again.mcap"), "--json")
        self.assertEqual((code, err), (0, ""))
        self.assertEqual([json.loads(line)["file"] for line in out.splitlines()], [FLIGHT, LONG])
        code, out, err = bag("info", FLIGHT, path("not-there.mcap"))
        self.assertEqual(code, 2, "the worst of them")
        self.assertTrue(out.startswith(f"{FLIGHT}: "))
        self.assertIn("not-there.mcap: no such file", err)

    def test_replay_executes_each_of_several_files(self):
        code, out, err = run("replay", FLIGHT, FLIGHT, LONG, "--until", "1", "--modules", "mixer")
        self.assertEqual((code, err), (0, ""))
        self.assertRegex(out, rf"^{FLIGHT}\nidentical: .*\n{LONG}\nidentical: .*\n$")
        code, out, err = run("replay", FLIGHT, LONG, "--compare", "--plot", path("two.svg"))
        self.assertEqual(code, 2)
        self.assertIn(f"--plot draws one recording, and 2 are named: name one, such as {LONG}", err)

    def test_a_command_that_reads_one_file_says_so(self):
        for command in (("bag", "check"), ("bag", "cat"), ("topic", "hz", "imu.raw", "--file")):
            code, out, err = run(*command, FLIGHT, LONG)
            self.assertEqual((code, out), (2, ""))
            self.assertIn(f"{LONG}: sinew {' '.join(command[:2])} takes one recording; name one, such as "
                          "runs/latest/run.mcap", err)

    def plot(self, file, *fields, out="plot.svg", options=()):
        """What was drawn, and the picture."""
        code, drawn, err = bag("plot", file, *fields, "-o", path(out), "--json", *options)
        self.assertEqual((code, err), (0, ""))
        with open(path(out), "rb") as picture:
            return json.loads(drawn), picture.read()

    def test_plot_draws_fields_and_marks_what_happened(self):
        drawn, picture = self.plot(LONG, "filter.state.p_world_m", "filter.state.v_world_mps.z")
        names = [s["name"] for s in drawn["series"]]
        self.assertEqual(names, [f"filter.state.p_world_m.{c}" for c in "xyz"] + ["filter.state.v_world_mps.z"])
        rows = list(csv.DictReader(io.StringIO(bag("csv", LONG, "--topic", "filter.state")[1])))
        height = [float(row["p_world_m.z"]) for row in rows]
        z = drawn["series"][2]
        self.assertEqual((z["unit"], z["points"], z["min"], z["max"]), ("m", len(rows), min(height), max(height)))
        self.assertEqual([m["text"] for m in drawn["marks"]][:2], ["arm", "climb"])
        text = picture.decode()
        for shown in (f"quad, {LONG}", "time (s)", ">m/s<", ">climb<", *names):
            self.assertIn(shown, text)

    def test_plot_takes_differences_angles_and_lengths(self):
        drawn, _ = self.plot(LONG, "filter.state.p_world_m - filter.state.p_world_m", "norm(filter.state.v_world_mps)",
                             "angle(filter.state.q_world_base, position.attitude.q_world_base)",
                             "norm(filter.state.p_world_m - mission.setpoint.p_world_m)", "mixer.motors.value[0]")
        by_name = {s["name"]: s for s in drawn["series"]}
        self.assertEqual({(s["min"], s["max"]) for name, s in by_name.items() if name.startswith("filter.state.p_")},
                         {(0, 0)})
        self.assertGreater(by_name["norm(filter.state.v_world_mps)"]["max"], 0.3, "it climbs")
        tilt = by_name["angle(filter.state.q_world_base, position.attitude.q_world_base)"]
        self.assertEqual(tilt["unit"], "deg")
        self.assertTrue(0 <= tilt["min"] <= tilt["max"] < 45, tilt)
        drawn, _ = self.plot(LONG, "angle(filter.state.q_world_base, ground_truth.q_world_base)", out="off.svg")
        off = drawn["series"][0]
        self.assertGreater(off["min"], 0.3 * off["max"], "the heading, which the filter cannot know; no angle to nothing")

    def test_plot_holds_the_older_value_of_the_rarer_topic_only_between_its_messages(self):
        drawn, _ = self.plot(LONG, "filter.state.height_m - range.raw.range_m")
        alone, _ = self.plot(LONG, "range.raw.range_m", "filter.state.height_m")
        self.assertLess(drawn["series"][0]["points"], alone["series"][1]["points"], "none outside of both")
        self.assertLess(drawn["series"][0]["max"], 0.5)

    def test_plot_writes_png(self):
        _, picture = self.plot(FLIGHT, "imu.raw.accel_mps2", out="plot.png")
        self.assertEqual(picture[:8], b"\x89PNG\r\n\x1a\n")
        width, height = struct.unpack(">II", picture[16:24])
        self.assertEqual(width, 1800)
        self.assertTrue(700 < height < 1000, height)

    def test_plot_shows_a_part_and_the_names_of_values(self):
        drawn, picture = self.plot(LONG, "mission.mission.phase", options=("--from", "2", "--until", "4", "--no-marks",
                                                                           "--mark", "filter.state.at_rest"))
        self.assertEqual({m["text"] for m in drawn["marks"]}, {"filter.state.at_rest 0"})
        self.assertTrue(all(2 <= m["time_s"] <= 4 for m in drawn["marks"]))
        self.assertIn(">climb<", picture.decode())

    def test_plot_refuses_what_cannot_be_drawn_and_says_what_can(self):
        for field, why in (("filter.stat.p_world_m", "no such topic; there are"),
                           ("filter.stat.p_world_m", "did you mean filter.state?"),
                           ("filter.state.p_wrld_m", "did you mean p_world_m?"),
                           ("filter.state.height_m.z", "height_m is one number"),
                           ("mixer.motors.value[8]", "an index from 0 to 7"),
                           ("filter.state", "more than 16 numbers"),
                           ("range.raw", "do not go on one axis"),
                           ("filter.state.p_world_m - filter.state.v_world_mps", "[m] less [m/s]"),
                           ("filter.state.p_world_m - filter.state.height_m", "3 numbers less 1"),
                           ("angle(filter.state.p_world_m, filter.state.q_world_base)", "not an attitude"),
                           ("sqrt(imu.raw)", "'angle(FIELD, FIELD)' or 'norm(FIELD)' is known")):
            code, out, err = bag("plot", FLIGHT, field, "-o", path("never.svg"))
            self.assertEqual((code, out), (2, ""), field)
            self.assertIn(why, err)
        self.assertIn("never.jpg: FILE.svg or FILE.png", bag("plot", FLIGHT, "imu.raw.stamp", "-o", path("never.jpg"))[2])
        self.assertFalse(os.path.exists(path("never.svg")))

    def test_names_stand_for_numbers_where_they_are_asked_for(self):
        modes = {m["message"]["mode"] for m in cat(FLIGHT, "--topic", "guardian.state")}
        self.assertIn(0, modes, "numbers for programs")
        self.assertEqual({m["message"]["mode"] for m in cat(FLIGHT, "--topic", "guardian.state", "--names")}, {"standby"})
        text = run("topic", "echo", "mission.mission", "--file", FLIGHT, "-n", "1")[1]
        self.assertIn("phase: wait\n", text)
        self.assertEqual(run("topic", "echo", "mission.mission", "--file", FLIGHT, "-n", "1", "--field", "phase")[1],
                         "wait\n")
        as_json = run("topic", "echo", "mission.mission", "--file", FLIGHT, "-n", "1", "--json")[1]
        self.assertEqual(json.loads(as_json)["message"]["phase"], 0)
        table = bag("csv", FLIGHT, "--topic", "mission.mission", "--names")[1]
        row = next(csv.DictReader(io.StringIO(table)))
        self.assertEqual((row["phase"], row["phase_name"]), ("0", "wait"))
        self.assertNotIn("phase_name", bag("csv", FLIGHT, "--topic", "mission.mission")[1])

    def test_older_recordings_show_the_names_that_they_have(self):
        older = path("damaged-older.mcap")
        definition = "uint32 phase  # [enum] wait arm climb\nuint32 faults  # [1] bits: lease, limit\nuint32 mode  # [enum] " \
                     "0 standby, 1 armed; the worst\n"
        write_mcap(older, "flight", "other_msgs/msg/Old", definition, [struct.pack("<IIII", 0x100, 2, 3, 7)])
        self.assertEqual(run("topic", "echo", "flight", "--file", older)[1], "phase: climb\nfaults: 3\nmode: 7\n---\n")

    def test_check_agrees_with_what_the_file_says_of_itself(self):
        code, out, err = bag("check", FLIGHT)
        self.assertEqual((code, err), (0, ""))
        self.assertIn("no problems", out)
        self.assertRegex(out, r"(?m)^  attitude +replayable$")
        checked = json.loads(bag("check", FLIGHT, "--json")[1])
        self.assertEqual((checked["ok"], checked["ended"], checked["problems"]), (True, True, []))
        self.assertEqual(checked["lost_messages"], {})

    def test_check_finds_a_flipped_bit(self):
        damaged = path("damaged.mcap")
        with open(FLIGHT, "rb") as f:
            content = bytearray(f.read())
        chunks, at = [], 8  # begin and length; a bit of an index would cost no message
        while at < len(content) - 8:
            (length,) = struct.unpack_from("<Q", content, at + 1)
            if content[at] == 6:
                chunks.append((at, length))
            at += 9 + length
        begin, length = chunks[len(chunks) // 2]
        content[begin + length // 2] ^= 4
        with open(damaged, "wb") as f:
            f.write(content)
        code, out, err = bag("check", damaged)
        self.assertEqual(code, 1)
        self.assertIn("bad checksum", err)
        self.assertIn('the file says "replayable"', err)
        self.assertFalse(json.loads(bag("check", damaged, "--json")[1])["ok"])

    def test_a_file_that_was_cut_off_says_so_and_is_made_whole(self):
        damaged = cut_off("damaged-cut.mcap", 0.6)
        code, out, err = bag("info", damaged)
        self.assertEqual(code, 0)
        self.assertIn("cut off", err)
        self.assertIn(f"bag recover {damaged} OUT", err)
        self.assertIn("imu.raw", out)
        self.assertIn("result\n  none: the file has no end: its process was killed, or lost its power\n", out)
        self.assertIsNone(json.loads(bag("info", damaged, "--json")[1])["result"])
        self.assertEqual(bag("check", damaged)[0], 1)
        code, out, err = bag("recover", damaged, path("recovered.mcap"), "--json")
        self.assertEqual(code, 0)
        self.assertIn("cut off", err)
        recovered = json.loads(out)
        self.assertGreater(recovered["messages"], 3000)
        code, out, err = bag("check", path("recovered.mcap"))
        self.assertEqual((code, err), (0, ""))
        self.assertIn("no verdict of its own", out)
        whole = cat(FLIGHT, "--topic", "imu.raw")
        again = cat(path("recovered.mcap"), "--topic", "imu.raw")
        self.assertEqual(again, whole[:len(again)])

    def test_cat_shows_every_message_of_every_topic(self):
        info = json.loads(bag("info", FLIGHT, "--json")[1])
        lines = whole_flight()
        self.assertEqual([l["log_time_ns"] for l in lines], sorted(l["log_time_ns"] for l in lines))
        for topic in info["topics"]:
            mine = [l for l in lines if l["topic"] == topic["name"]]
            self.assertEqual(len(mine), topic["messages"], topic["name"])
            if topic["name"].startswith("sinew/"):
                continue
            self.assertEqual([l["sequence"] for l in mine],
                             list(range(mine[0]["sequence"], mine[0]["sequence"] + len(mine))) if mine else [])
        imu = next(l for l in lines if l["topic"] == "imu.raw")
        self.assertEqual(imu["message"]["stamp"], imu["stamp_ns"])
        self.assertEqual(set(imu["message"]["gyro_radps"]), {"x", "y", "z"})
        steps = [s for l in lines if l["topic"] == "sinew/steps" for s in l["message"]["steps"]]
        self.assertGreater(len(steps), 10000)
        image = next(l for l in lines if l["topic"] == "camera.raw")["message"]
        head = next(l for l in lines if l["topic"] == "camera.raw/head")["message"]
        self.assertEqual(int(image["data"]["hash"], 16), head["pixel_hash"])

    def test_cat_takes_topics_and_times(self):
        start = json.loads(bag("info", FLIGHT, "--json")[1])["start_ns"]
        lines = cat(FLIGHT, "--topic", "imu.raw", "--topic", "range.raw", "--from", "0.5", "--until", "1")
        self.assertEqual({l["topic"] for l in lines}, {"imu.raw", "range.raw"})
        every = [l for l in whole_flight() if l["topic"] in ("imu.raw", "range.raw")]
        self.assertEqual(lines, [l for l in every if 5e8 <= l["log_time_ns"] - start <= 1e9])

    def test_csv_has_a_column_for_each_number(self):
        code, out, err = bag("csv", FLIGHT, "--topic", "guardian.state")
        self.assertEqual((code, err), (0, ""))
        rows = list(csv.DictReader(io.StringIO(out)))
        lines = cat(FLIGHT, "--topic", "guardian.state")
        self.assertEqual(len(rows), len(lines))
        for row, line in zip(rows, lines):
            self.assertEqual(int(row["log_time_ns"]), line["log_time_ns"])
            self.assertEqual(int(row["sequence"]), line["sequence"])
            for i, value in enumerate(line["message"]["measured"]):
                self.assertEqual(row[f"measured.{i}"] if isinstance(value, str) else float(row[f"measured.{i}"]), value)
        code, out, _ = bag("csv", FLIGHT, path("state.csv"), "--topic", "filter.state", "--json")
        self.assertEqual(code, 0)
        with open(path("state.csv")) as f:
            rows = list(csv.DictReader(f))
        self.assertEqual(json.loads(out)["rows"], len(rows))
        self.assertIn("q_world_base.w", rows[0])

    def test_csv_of_lists_of_different_lengths_has_the_longest_in_its_head(self):
        lists = path("damaged-lists.mcap")
        bodies = [struct.pack("<IqI", 0x100, 5, len(values)) + (b"\0\0\0\0" if values else b"") +
                  struct.pack(f"<{len(values)}d", *values) for values in ([1.5], [], [2.5, 3.5, 4.5], [5.5, 6.5])]
        for i, body in enumerate(bodies):  # what follows the list
            bodies[i] = body + b"\0" * (-(len(body) - 4) % 4) + struct.pack("<i", i)
        write_mcap(lists, "x", "a_msgs/msg/B", "int64 stamp\nfloat64[] value\nint32 last\n", bodies)
        code, out, err = bag("csv", lists, "--topic", "x")
        self.assertEqual((code, err), (0, ""))
        self.assertEqual(out.splitlines(), ["log_time_ns,sequence,stamp,value.0,value.1,value.2,last",
                                            "0,0,5,1.5,,,0", "1,1,5,,,,1", "2,2,5,2.5,3.5,4.5,2", "3,3,5,5.5,6.5,,3"])
        code, out, err = bag("csv", FLIGHT, "--topic", "sinew/steps")
        self.assertEqual((code, err), (0, ""))
        self.assertEqual(len({len(row) for row in csv.reader(io.StringIO(out))}), 1, "all rows have all columns")

    def test_cut_keeps_a_part_of_the_time_and_all_that_was_said(self):
        start = json.loads(bag("info", FLIGHT, "--json")[1])["start_ns"]
        made = self.make("cut", FLIGHT, path("cut.mcap"), "--from", "0.5", "--until", "1.5")
        every = [(l, l["log_time_ns"] - start) for l in whole_flight()]
        expected = [l for l, at in every if 5e8 <= at <= 15e8 or (at <= 15e8 and l["topic"] == "sinew/requests")]
        self.assertEqual(made["messages"], len(expected))
        by = lambda l: (l["log_time_ns"], l["topic"], l["sequence"], json.dumps(l["message"]))
        self.assertEqual(sorted(cat(path("cut.mcap")), key=by), sorted(expected, key=by))
        info = json.loads(bag("info", path("cut.mcap"), "--json")[1])
        self.assertEqual([a["name"] for a in info["attachments"]], ["robot.toml", "report.json"])
        self.assertIn("sinew.edited", info["metadata"])
        self.assertEqual(info["run"]["robot"], "quad")

    def test_a_part_that_was_cut_out_is_executed_from_its_first_states(self):
        part = path("executed.mcap")
        self.assertEqual(bag("cut", LONG, part, "--from", "1", "--until", "6")[::2], (0, ""), "and needs no note")
        code, out, err = run("replay", part)
        self.assertEqual(code, 0, out + err)
        self.assertRegex(out, r"the file begins in the middle of its run: each module begins at its first saved state there, "
                              r"[0-4].[0-9]{3} to [0-5].[0-9]{3} s of the file\n")
        self.assertNotIn("nothing could be executed", out)
        code, out, err = run("replay", part, "--json")
        self.assertEqual(len(out.splitlines()), 1, "one object")
        replay = json.loads(out)
        self.assertTrue(replay["identical"] and replay["midway"])
        whole = json.loads(run("replay", LONG, "--json")[1])
        for name, module in replay["modules"].items():
            if whole["modules"][name]["steps"] == 0:
                continue
            self.assertNotIn("stopped", module, name)
            self.assertGreater(module["steps"], 0, name)
            self.assertGreater(module["from_s"], replay["start_s"], name)
        code, out, err = bag("cut", part, path("short.mcap"), "--from", "0.01", "--until", "0.5")
        self.assertEqual(code, 0)
        self.assertRegex(err, rf"^{path('short.mcap')}: note: replay cannot execute \d+ of {len(replay['modules'])} modules of "
                              r"this part, which has no saved state of theirs \(one each every 5 s; take more than that, from "
                              r"an earlier --from\): .*\bmixer\b.*\n$")
        code, out, err = bag("cut", part, path("none.mcap"), "--from", "0.01", "--until", "0.02")
        self.assertEqual(code, 0)
        code, out, err = run("replay", path("none.mcap"))
        self.assertEqual(code, 1)
        self.assertIn("has no saved state (there is one of each module every 5 s): take a longer part", out)

    def test_times_that_the_file_does_not_have_are_refused_with_those_that_it_has(self):
        length = json.loads(bag("info", FLIGHT, "--json")[1])["duration_s"]
        allowed = f"the file has 0.0 to {length:.3f} s"
        for command in (["bag", "cut", FLIGHT, path("x")], ["bag", "cat", FLIGHT], ["bag", "csv", FLIGHT, "--topic", "imu.raw"],
                        ["bag", "images", FLIGHT, path("x"), "--topic", "camera.raw"], ["bag", "play", FLIGHT],
                        ["replay", FLIGHT], ["tune", FLIGHT, "--error", "filter.state", "--against", "recorded", "--param",
                                             "attitude.kp=1"]):
            for times, words in ((["--from", "3"], f"--from 3: {allowed}"), (["--until", "3"], f"--until 3: {allowed}"),
                                 (["--from", "1", "--until", "0.5"], f"--until 0.5: at least --from 1; {allowed}")):
                code, out, err = run(*command, *times)
                self.assertEqual((code, out), (2, ""), (command, times, err))
                self.assertIn(words, err, (command, times))
        self.assertFalse(os.path.exists(path("x")))

    def test_rates_are_those_of_a_topics_own_time(self):
        write_mcap(path("damaged-late.mcap"), "late", "a_msgs/msg/B", "uint64 x", [struct.pack("<IQ", 0x100, 5)] * 3,
                   times=[10 * 10**9, 10 * 10**9 + 10**8, 10 * 10**9 + 2 * 10**8])
        write_mcap(path("damaged-long.mcap"), "long", "a_msgs/msg/B", "uint64 x", [struct.pack("<IQ", 0x100, 5)] * 2,
                   times=[0, 20 * 10**9])
        self.assertEqual(bag("merge", path("rates.mcap"), path("damaged-late.mcap"), path("damaged-long.mcap"))[0], 0)
        for out in (bag("info", path("rates.mcap"), "--json")[1], run("topic", "list", "--file", path("rates.mcap"), "--json")[1]):
            self.assertEqual({t["name"]: round(t["rate_hz"], 6) for t in json.loads(out)["topics"]}, {"late": 10, "long": 0.05})
        self.assertRegex(run("topic", "list", "--file", path("rates.mcap"))[1], r"(?m)^late .* 10 Hz$")

    def test_filter_keeps_some_topics(self):
        self.make("filter", FLIGHT, path("filtered.mcap"), "--topic", "imu.raw", "--topic", "camera.raw")
        info = json.loads(bag("info", path("filtered.mcap"), "--json")[1])
        self.assertEqual([t["name"] for t in info["topics"]], ["camera.raw", "camera.raw/head", "imu.raw"])
        self.assertEqual(set(info["compression"]), {"lz4", "none"}, "images stay as they are")
        kept = ("imu.raw", "camera.raw", "camera.raw/head")  # what an image is without its pixels goes with it
        by = lambda l: (l["log_time_ns"], l["topic"], l["sequence"])
        self.assertEqual(sorted(cat(path("filtered.mcap")), key=by),
                         sorted((l for l in whole_flight() if l["topic"] in kept), key=by))

    def test_merge_puts_parts_together_again(self):
        self.make("cut", FLIGHT, path("first.mcap"), "--until", "0.9")
        self.make("cut", FLIGHT, path("second.mcap"), "--from", "0.9000000005")
        made = self.make("merge", path("merged.mcap"), path("second.mcap"), path("first.mcap"))
        self.assertEqual(made["attachments"], 2, "the same in both")
        by = lambda l: (l["log_time_ns"], l["topic"], l["sequence"], json.dumps(l["message"]))
        self.assertEqual(sorted(cat(path("merged.mcap")), key=by), sorted(whole_flight(), key=by))

    def test_merge_refuses_a_topic_with_two_types(self):
        small = path("damaged-small.mcap")
        self.assertEqual(bag("filter", FLIGHT, small, "--topic", "range.raw")[0], 0)
        renamed = path("damaged-renamed.mcap")
        write_mcap(renamed, "range.raw", "sinew_msgs/msg/RangeSample", "int64 stamp\nfloat64 range_cm\n",
                   [struct.pack("<Iqd", 0x100, 5, 1.5)])
        code, _, err = bag("merge", path("damaged-merged.mcap"), small, renamed)
        self.assertEqual(code, 1)
        self.assertIn("topic range.raw: sinew_msgs/msg/RangeSample with different fields", err)
        self.assertFalse(os.path.exists(path("damaged-merged.mcap")))
        code, out, err = bag("cat", renamed)
        self.assertEqual(code, 0)
        self.assertEqual(json.loads(out)["message"], {"stamp": 5, "range_cm": 1.5})
        self.assertIn("another version than this program's; shown as recorded", err)

    def test_convert_makes_what_ros_2_has_its_types(self):
        made = self.make("convert", "--ros2", FLIGHT, path("converted.mcap"))
        info, before = (json.loads(bag("info", f, "--json")[1]) for f in (path("converted.mcap"), FLIGHT))
        self.assertEqual(info["profile"], "ros2")
        self.assertEqual(made["messages"], before["messages"])
        types = {t["name"]: t["type"] for t in info["topics"]}
        become = {"imu.raw": "sensor_msgs/msg/Imu", "range.raw": "sensor_msgs/msg/Range",
                  "baro.raw": "sensor_msgs/msg/FluidPressure", "battery.raw": "sensor_msgs/msg/BatteryState",
                  "filter.state": "nav_msgs/msg/Odometry", "ground_truth": "nav_msgs/msg/Odometry", "camera.raw": "sensor_msgs/msg/Image"}
        self.assertEqual(types, {**{t["name"]: t["type"] for t in before["topics"]}, **become})
        ours, theirs = ([l for l in lines if l["topic"] in become] for lines in (whole_flight(), cat(path("converted.mcap"))))
        by = lambda l: (l["topic"], l["log_time_ns"], l["sequence"])
        for a, b in zip(sorted(ours, key=by), sorted(theirs, key=by), strict=True):
            self.assertEqual(by(a), by(b))
            m, r, topic = a["message"], b["message"], a["topic"]
            self.assertEqual(r["header"]["stamp"]["sec"] * 10**9 + r["header"]["stamp"]["nanosec"], a["stamp_ns"])
            if topic == "camera.raw":
                self.assertEqual(m, r)
            elif topic == "imu.raw":
                self.assertEqual((r["angular_velocity"], r["linear_acceleration"]), (m["gyro_radps"], m["accel_mps2"]))
                self.assertEqual(r["orientation_covariance"][0], -1)
            elif topic == "range.raw":
                near = m["range_m"] != "NaN"
                self.assertTrue(abs(r["range"] - m["range_m"]) < 1e-6 if near else r["range"] == "Infinity", (m, r))
            elif topic == "baro.raw":
                self.assertEqual(r["fluid_pressure"], m["pressure_pa"])
            elif topic == "battery.raw":
                self.assertAlmostEqual(r["voltage"], m["voltage_v"], places=4)
                self.assertAlmostEqual(r["current"], -m["current_a"], places=4)
                self.assertAlmostEqual(r["percentage"], m["charge"], places=4)
            else:
                self.assertEqual((r["header"]["frame_id"], r["child_frame_id"]), ("odom", "base_link"))
                self.assertEqual(r["pose"]["pose"]["position"], m["p_world_m"])
                self.assertEqual(r["pose"]["pose"]["orientation"], m["q_world_base"])
                self.assertEqual(r["twist"]["twist"]["angular"], m["gyro_radps"])
                turned = rotated(m["q_world_base"], r["twist"]["twist"]["linear"])
                for axis, value in m["v_world_mps"].items():
                    self.assertAlmostEqual(turned[axis], value, places=6)

    def test_what_is_not_known_is_said_and_not_shown(self):
        unknown = path("damaged-unknown.mcap")
        write_mcap(unknown, "x", "some.Thing", "syntax = \"proto3\"", [b"abc"], encoding="protobuf")
        code, out, err = bag("cat", unknown)
        self.assertEqual((code, out), (1, ""))
        self.assertIn('x: not shown: messages in "cdr" by a schema in "protobuf"', err)
        write_mcap(path("damaged-short.mcap"), "x", "a_msgs/msg/B", "uint64 x", [struct.pack("<II", 0x100, 5)])
        code, out, err = bag("cat", path("damaged-short.mcap"))
        self.assertEqual((code, out), (1, ""))
        self.assertIn("x: not shown: its bytes do not fit their schema", err)

    def test_images_are_png_files_in_the_order_of_time(self):
        code, out, err = bag("images", FLIGHT, path("images"), "--topic", "camera.raw", "--json")
        self.assertEqual((code, err), (0, ""))
        names = sorted(os.listdir(path("images")))
        lines = cat(FLIGHT, "--topic", "camera.raw")
        self.assertEqual(json.loads(out)["images"], len(lines))
        self.assertEqual([int(n[:-4]) for n in names], [l["stamp_ns"] for l in lines])
        for name in names:
            with open(path(f"images/{name}"), "rb") as f:
                content = f.read()
            self.assertEqual(content[:8], b"\x89PNG\r\n\x1a\n")
            self.assertEqual(struct.unpack(">II", content[16:24]), (64, 48))
        code, _, err = bag("images", FLIGHT, path("more"), "--topic", "imu.raw")
        self.assertEqual(code, 2)
        self.assertIn("no images", err)

    def test_topic_commands_work_on_a_file_as_on_a_robot(self):
        def topic(*arguments):
            code, out, err = run("topic", *arguments)
            self.assertEqual((code, err), (0, ""), (arguments, out))
            return out

        topics = {t["name"]: t for t in json.loads(topic("list", "--file", FLIGHT, "--json"))["topics"]}
        self.assertEqual(len(topics), 17, "and nothing that is not a topic of the robot")
        self.assertEqual((topics["imu.raw"]["writer"], topics["imu.raw"]["thread"]), ("imu", "stabilise"))
        self.assertRegex(topic("list", "--file", FLIGHT), r"(?m)^mixer.motors +sinew_msgs/msg/ActuatorCommand +mixer +stabilise ")
        self.assertIn("float64 height_m", topic("info", "--file", FLIGHT, "filter.state"))
        self.assertEqual(json.loads(topic("info", "--file", FLIGHT, "range.raw", "--json"))["messages"],
                         topics["range.raw"]["messages"])
        recorded = cat(FLIGHT, "--topic", "mixer.motors")
        lines = [json.loads(line) for line in topic("echo", "--file", FLIGHT, "mixer.motors", "--json").splitlines()]
        self.assertEqual([(m["sequence"], m["message"]) for m in lines], [(m["sequence"], m["message"]) for m in recorded])
        out = topic("echo", "--file", FLIGHT, "mixer.motors", "--field", "value.0", "-n", "3")
        self.assertEqual([float(v) for v in out.split()], [m["message"]["value"][0] for m in recorded[:3]])
        hz = json.loads(topic("hz", "--file", FLIGHT, "imu.raw", "--json"))
        self.assertEqual((hz["messages"], hz["lost"]), (topics["imu.raw"]["messages"], 0))
        self.assertAlmostEqual(hz["rate_hz"], 1000, delta=1)
        for arguments, words in ((["hz", "--file", FLIGHT, "imu"], "no topic imu; it has attitude.wrench"),
                                 (["list", "--file", path("no such")], "no such file"),
                                 (["echo", "--file", FLIGHT, "imu.raw", "--field", "x"], "no \"x\"; one of stamp"),
                                 (["list", "--file", FLIGHT, "--robot", "quad"], "--robot excludes --file")):
            code, out, err = run("topic", *arguments)
            self.assertEqual((code, out), (2, ""), (arguments, err))
            self.assertIn(words, err)

    def test_a_played_file_is_a_robot_that_says_again_what_was_recorded(self):
        recorded = cat(FLIGHT, "--topic", "mission.setpoint")
        play = subprocess.Popen([SINEW, "bag", "play", FLIGHT, "--name", "again", "--rate", "0.4", "--json"], stdout=subprocess.PIPE,
                                text=True)
        code, out, err = run("topic", "echo", "mission.setpoint", "--robot", "again", "--wait", "60", "-n", "50", "--json")
        self.assertEqual(code, 0, err)
        heard = [json.loads(line)["message"] for line in out.splitlines()]
        stamps = [m["stamp"] for m in heard]
        self.assertEqual(stamps, sorted(set(stamps)))
        self.assertEqual(heard, [m["message"] for m in recorded if m["message"]["stamp"] in set(stamps)])
        code, out, err = run("topic", "list", "--robot", "again")
        self.assertRegex(out, r"(?m)^camera.raw +Image +camera ", err)
        told = json.loads(play.communicate(timeout=300)[0])
        self.assertEqual(play.returncode, 0)
        topics = [t for t in json.loads(bag("info", FLIGHT, "--json")[1])["topics"] if not re.search("^sinew/|/head$", t["name"])]
        self.assertEqual((told["topics"], told["messages"]), (len(topics), sum(t["messages"] for t in topics)))
        self.assertEqual((told["without_pixels"], told["not_played"]), (0, 0))
        code, out, err = bag("play", FLIGHT, "--from", "1", "--until", "1.1", "--topic", "imu.raw", "--rate", "4", "--json")
        self.assertEqual((code, json.loads(out)["messages"]), (0, 102), err)  # with the one that stood there before
        write_mcap(path("foreign"), "/chatter", "std_msgs/msg/String", "string data", [b"\0\1\0\0\1\0\0\0\0"])
        code, _, err = bag("play", path("foreign"))
        self.assertEqual(code, 2)
        self.assertIn("no topic in it that this program can show", err)

    def test_what_cannot_be_begun_ends_with_2_and_touches_nothing(self):
        with open(path("text"), "w") as f:
            f.write("no recording")
        before = digest(FLIGHT)
        for arguments, words in (
                (["info", path("no such")], "no such file"),
                (["check", path("text")], "not an MCAP file"),
                (["cat", path("text")], "not an MCAP file"),
                (["cat", FLIGHT, "--topic", "nothing"], "no topic nothing in the file; it has"),
                (["cut", FLIGHT, FLIGHT, "--from", "1"], "exists; nothing is overwritten"),
                (["cut", FLIGHT, path("x")], "--from, --until or both"),
                (["cut", FLIGHT, path("no/x"), "--from", "1"], "no such folder"),
                (["csv", FLIGHT, FLIGHT, "--topic", "imu.raw"], "exists; nothing is overwritten"),
                (["merge", path("x"), FLIGHT], "files"),
                (["filter", FLIGHT, path("x")], "--topic is required"),
                ([], "A subcommand is required")):
            code, out, err = bag(*arguments)
            self.assertEqual((code, out), (2, ""), (arguments, out, err))
            self.assertIn(words, err)
        self.assertFalse(os.path.exists(path("x")))
        self.assertEqual(digest(FLIGHT), before)

    def test_completion_looks_into_the_file_that_is_named(self):
        def offered(*words):
            return run("complete", *words)[1].splitlines()
        self.assertEqual(offered("bag", "csv", FLIGHT, "--topic", "imu"), ["imu.raw"])
        self.assertEqual(offered("topic", "echo", "--file", FLIGHT, "range"), ["range.raw"])
        self.assertEqual(offered("topic", "echo", "--file", FLIGHT, "imu.raw", "--field", "gyro"),
                         ["gyro_radps", "gyro_radps.x", "gyro_radps.y", "gyro_radps.z"])
        self.assertEqual(offered("replay", FLIGHT, "--modules", "att"), ["attitude"])
        self.assertEqual(offered("replay", FLIGHT, "--modules", "mixer,att"), ["mixer,attitude"])
        self.assertIn("filter.state.p_world_m.x", offered("replay", FLIGHT, "--compare", "--fields", "filter.state.p"))
        self.assertEqual(offered("bag", "csv", path("no such"), "--topic", ""), [])

    def test_completion_offers_files(self):
        self.assertEqual(run("complete", "bag", "info", "")[1], ":file\n")
        self.assertEqual(run("complete", "bag", "images", "x", "")[1], ":folder\n")
        self.assertIn("recover", run("complete", "bag", "rec")[1])


def rotated(q, v):
    """A vector of the body in world coordinates, by the rotation matrix."""
    w, x, y, z = (q[k] for k in "wxyz")
    rows = ((1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
            (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
            (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)))
    return {axis: sum(a * v[k] for a, k in zip(row, "xyz")) for axis, row in zip("xyz", rows)}


def write_mcap(name, topic, type_name, schema, messages, encoding="ros2msg", times=None):
    """A foreign file, without chunks or summary: our reader has to look at everything."""
    def text(s):
        return struct.pack("<I", len(s.encode())) + s.encode()

    def record(op, content):
        return struct.pack("<BQ", op, len(content)) + content

    inner = record(3, struct.pack("<H", 1) + text(type_name) + text(encoding) + text(schema))
    inner += record(4, struct.pack("<HH", 1, 1) + text(topic) + text("cdr") + struct.pack("<I", 0))
    times = times or list(range(len(messages)))
    for i, data in enumerate(messages):
        inner += record(5, struct.pack("<HIQQ", 1, i, times[i], times[i]) + data)
    chunk = record(6, struct.pack("<QQQI", times[0], times[-1], len(inner), zlib.crc32(inner)) + text("") +
                   struct.pack("<Q", len(inner)) + inner)
    magic = b"\x89MCAP0\r\n"
    with open(name, "wb") as f:
        f.write(magic + record(1, text("") + text("test")) + chunk + record(15, struct.pack("<I", 0)) +
                record(2, struct.pack("<QQI", 0, 0, 0)) + magic)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)
