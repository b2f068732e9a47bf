#!/usr/bin/env python3
"""Short soccer matches of walkers with eyes: the result, its recording and the replay; many matches.

usage: match_test.py SINEW ROBOTS CLASS
"""
import json
import os
import pathlib
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

SINEW, ROBOTS = sys.argv[1:3]
# The kid with eyes, which walks its figure while the game is on.
PLAYER = f"""extends = "{ROBOTS}/kid/kid_sight.toml"
[[thread]]
name = "figure"
order = ["battery", "referee", "figure"]
[module.referee]
type = "drivers::RefereeSource"
exec_us = 5
[module.figure]
in.referee = "referee.raw"
params = {{ heed_referee = true }}
"""
SHORT = ["--set", "sim.referee_ready_s=1", "--set", "sim.referee_set_s=1"]
# The ball rolls from the middle into red's goal, which is at the right in the first half.
GOAL = ["--set", "sim.ball_roll_mps=3.5", "--set", "sim.ball_roll_at_s=2.5"]
MB_A_SECOND = 200 / 700  # 200 MB for 2 on 2 in 10 min: two halves of 300 s, each with 50 s before it


class Match(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="sinew-")
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        cls.env = dict(os.environ, SINEW_RUN_DIR=folder.name, TMPDIR=folder.name)
        cls.env.pop("SINEW_RECORD", None)
        for name in ("ants", "bees"):
            (cls.folder / f"{name}.toml").write_text(PLAYER + f'[robot]\nname = "{name}"\n')

    @classmethod
    def sinew(cls, *arguments, before=(), timeout=500):
        done = subprocess.run([*before, SINEW, *arguments], capture_output=True, text=True, env=cls.env, cwd=cls.folder,
                              timeout=timeout)
        return done.returncode, done.stdout, done.stderr


class Played(Match):
    """One match of 2 on 2 and of 60 s, shared by all claims."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.words = ["match", "ants.toml", "bees.toml", "--minutes", "1", "--seed", "3", *SHORT, *GOAL]
        code, out, err = cls.sinew(*cls.words, "--out", "played", "--json")
        assert code == 0, out + err
        cls.result = json.loads(out)

    def test_has_a_score_goals_and_what_each_player_did(self):
        measures = self.result["measures"]
        self.assertEqual(self.result["outcome"], "A won", self.result)
        self.assertEqual((measures["goals_a"], measures["goals_b"]), (1, 0))
        goal, = self.result["report"]["goals"]
        self.assertEqual(goal["team"], "A")
        self.assertGreater(goal["at_s"], 2.5)
        self.assertEqual(set(self.result["report"]["players"]), {"blue1", "blue2", "red1", "red2"})
        for player in self.result["report"]["players"].values():
            self.assertGreater(player["walked_m"], 0.1, "it walks while the game is on")
        log = json.loads((self.folder / "played/result.json").read_text())["log"]
        self.assertEqual(sum("goal for team 0, 1:0" in line for line in log), 1, log)

    def test_is_the_same_again_on_one_processor_without_a_recording_while_a_game_controller_tells_it(self):
        receiver = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.addCleanup(receiver.close)
        receiver.bind(("127.0.0.1", 0))
        receiver.settimeout(1)
        receiver.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
        cpu = min(os.sched_getaffinity(0))
        code, out, err = self.sinew(*self.words, "--no-record", "--json", "--gamecontroller",
                                    f"127.0.0.1:{receiver.getsockname()[1]}", before=["taskset", "-c", str(cpu)])
        self.assertEqual(code, 0, err)
        again = json.loads(out)
        self.assertEqual(again["hash"], self.result["hash"])
        self.assertEqual(again, self.result)
        packets = [receiver.recv(1000) for _ in range(int(2 * self.result["report"]["plant_s"]) - 1)]
        halves = {}
        for p in packets:
            self.assertEqual((p[:5], len(p), p[6]), (b"RGme\x13", 198, 2), "two players a team")
            halves[p[12]] = {p[at]: p[at + 4] for at in (18, 108)}, p[18]
        self.assertEqual(halves[0][0], {1: 1, 2: 0}, "blue won 1:0")
        self.assertEqual((halves[1][1], halves[0][1]), (1, 2), "the teams change sides")

    def test_is_recorded_without_pixels_in_little_room(self):
        files = {f.name: f.stat().st_size for f in (self.folder / "played").glob("*.mcap")}
        self.assertEqual(set(files), {"blue1.mcap", "blue2.mcap", "red1.mcap", "red2.mcap", "scenes.mcap"})
        self.assertLess(sum(files.values()), 1e6 * MB_A_SECOND * self.result["report"]["plant_s"], files)
        for name in files:
            code, out, err = self.sinew("bag", "check", f"played/{name}")
            self.assertEqual(code, 0, out + err)

    def test_is_executed_again_with_all_pictures_drawn_again(self):
        code, out, err = self.sinew("match", "--replay", "played", "--json")
        self.assertEqual(code, 0, out + err)
        reports = [json.loads(line) for line in out.splitlines()]
        self.assertEqual(len(reports), 4)
        for report in reports:
            self.assertTrue(report["identical"])
            self.assertGreater(report["pictures"]["same"], 2 * 10 * 15)
            self.assertEqual((report["pictures"]["differing"], report["pictures"]["missing"]), (0, 0))
            for module in ("sight", "sight2"):
                self.assertGreater(report["modules"][module]["steps"], 100)
                self.assertNotIn("stopped", report["modules"][module])

    def test_pictures_of_another_world_are_found_out(self):
        shorter = [*self.words]
        shorter[shorter.index("--minutes") + 1] = "0.2"
        code, out, err = self.sinew(*shorter, "--set", "sim.ball_roll_deg=20", "--out", "other", "--json")
        self.assertEqual(code, 0, out + err)
        code, out, err = self.sinew("replay", "played/blue1.mcap", "--pictures", "other/scenes.mcap", "--json")
        self.assertEqual(code, 1, out + err)
        pictures = json.loads(out)["pictures"]
        self.assertGreater(pictures["differing"], 0)
        self.assertRegex(pictures["first_wrong"], r"camera2?\.raw, image \d+ at .* s: other pixels than were seen")

    def test_pixels_of_a_part_can_be_had_afterwards(self):
        done = subprocess.run([pathlib.Path(SINEW).parent / "sinew-sim", "--redraw", "played/scenes.mcap", "--of", "red2", "--window",
                               "3,4", "--mcap", "part.mcap"], capture_output=True, text=True, cwd=self.folder, env=self.env, timeout=100)
        self.assertEqual(done.returncode, 0, done.stderr)
        code, out, err = self.sinew("bag", "images", "part.mcap", "part", "--topic", "camera2")
        self.assertEqual(code, 0, out + err)
        self.assertEqual(len(list((self.folder / "part").glob("*.png"))), 11)

    def test_goals_are_drawn(self):
        goals = sorted((self.folder / "played/goals").glob("*.png"))
        self.assertEqual(len(goals), 3)
        for picture in goals:
            self.assertEqual(picture.read_bytes()[:8], b"\x89PNG\r\n\x1a\n")
            self.assertGreater(picture.stat().st_size, 5000)


class Many(Match):
    WORDS = ["match", "ants.toml", "bees.toml", "--robots", "1", "--minutes", "0.05", "--count", "4", "--no-record", *SHORT]

    def test_go_on_after_kill_9_and_come_to_the_same_file_in_parts(self):
        code, out, err = self.sinew(*self.WORDS, "--results", "whole.jsonl")
        self.assertEqual(code, 0, out + err)
        whole = (self.folder / "whole.jsonl").read_bytes()
        self.assertEqual(whole.count(b"\n"), 5)
        self.assertRegex(out, r"A won \d+ of 4 \(")
        self.assertIn("these matches do not show which team is better", out)

        killed = subprocess.Popen([SINEW, *self.WORDS, "--results", "again.jsonl", "--jobs", "1"], env=self.env,
                                  cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        file = self.folder / "again.jsonl"
        give_up = time.monotonic() + 400
        while time.monotonic() < give_up and (not file.exists() or file.read_bytes().count(b"\n") < 2):
            time.sleep(0.1)
        killed.send_signal(signal.SIGKILL)
        killed.wait()
        code, out, err = self.sinew(*self.WORDS, "--results", "again.jsonl")
        self.assertEqual(code, 0, out + err)
        self.assertRegex(err, r"again\.jsonl has [123] matches")
        self.assertEqual(file.read_bytes(), whole)

        for part in ("1/2", "2/2"):
            code, out, err = self.sinew(*self.WORDS, "--results", f"part{part[0]}.jsonl", "--shard", part)
            self.assertEqual(code, 0, out + err)
        code, out, err = self.sinew("merge", "part1.jsonl", "part2.jsonl", "--into", "merged.jsonl")
        self.assertEqual(code, 0, out + err)
        self.assertEqual((self.folder / "merged.jsonl").read_bytes(), whole)


class Refused(Match):
    def test_a_folder_keeps_what_is_not_of_a_match_and_a_match_its_folder(self):
        own = self.folder / "own"
        (own / "blue1-notes").mkdir(parents=True)
        (own / "blue1-notes/run.txt").write_text("mine")
        (own / "notes.txt").write_text("mine")
        (own / "scenes.mcap").write_text("of a match that was broken off")
        words = ["match", "ants.toml", "bees.toml", "--robots", "1", "--minutes", "0.05", *SHORT, "--out", "own"]
        code, out, err = self.sinew(*words)
        self.assertEqual(code, 0, out + err)
        self.assertEqual((own / "notes.txt").read_text() + (own / "blue1-notes/run.txt").read_text(), "minemine")
        code, out, err = self.sinew(*words)
        self.assertEqual(code, 2, out + err)
        self.assertIn("own: a match is recorded there already; --out names another folder", err)

    def test_what_cannot_be_played_is_said_before_anything_begins(self):
        (self.folder / "deaf.toml").write_text(f'extends = "{ROBOTS}/kid/kid.toml"\n')
        cases = ((["ants.toml"], "two robot files, one for each team; 1 given"),
                 (["ants.toml", f"{ROBOTS}/quad/quad.toml"], "its world is quad; a match is played in the world soccer"),
                 (["ants.toml", "deaf.toml"], "it does not hear the referee"),
                 (["ants.toml", "bees.toml", "--count", "2", "--gamecontroller", "127.0.0.1:3838"],
                  "--gamecontroller: of one match, not of many at a time"),
                 (["ants.toml", "none.toml"], "none.toml"),
                 (["ants.toml", "bees.toml", "--set", "c/figure.turns=1"], "no robot c"),
                 (["--replay", "nothing"], "nothing"),
                 (["ants.toml", "bees.toml", "--count", "3", "--shard", "4/3"], "--shard 4/3"))
        for words, said in cases:
            code, out, err = self.sinew("match", *words)
            self.assertEqual(code, 2, (words, out, err))
            self.assertIn(said, err)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)
