"""sinew-learn: one policy, a study that is killed and goes on, its table and plots.
usage: learn_command_test.py SINEW_LEARN"""
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

LEARN = sys.argv[1]


def run(*words, good=(0,)):
    said = subprocess.run([LEARN, *words], capture_output=True, text=True, timeout=300)
    assert said.returncode in good, (words, said.returncode, said.stdout, said.stderr)
    return said.stdout + said.stderr


def the_same_seed_is_the_same_file(folder):
    for name in ("a.toml", "b.toml"):
        run("policy", str(folder / name), "--trials", "2", "--seed", "4")
    a = (folder / "a.toml").read_bytes()
    assert a == (folder / "b.toml").read_bytes()
    assert b"[landing]" in a and b"seed 4, 2 trials" in a


STUDY = ("--seeds", "2", "--trials", "3", "--every", "2", "--goal-trials", "3", "--starts", "2", "--curve-starts", "1",
         "--jobs", "1")


def a_killed_study_goes_on_to_the_same_bytes(folder):
    whole, killed = str(folder / "whole.jsonl"), folder / "killed.jsonl"
    table = run("study", *STUDY, "--results", whole)
    assert "continuous" in table and "online" in table and "batch" in table, table
    study = subprocess.Popen([LEARN, "study", *STUDY, "--results", str(killed)], stdout=subprocess.DEVNULL,
                             stderr=subprocess.DEVNULL, start_new_session=True)
    until = time.time() + 200
    while time.time() < until and (not killed.exists() or killed.read_bytes().count(b"\n") < 3):
        time.sleep(0.02)
    os.killpg(study.pid, signal.SIGKILL)
    study.wait()
    lines = killed.read_bytes().count(b"\n")
    assert lines >= 3, lines
    run("study", *STUDY, "--results", str(killed))
    assert killed.read_bytes() == (folder / "whole.jsonl").read_bytes()
    plots = folder / "plots"
    run("report", "--results", whole, "--plots", str(plots))
    assert sorted(p.name for p in plots.iterdir()) == ["learning-curves.svg", "learning-paths.svg"]
    other = run("study", *STUDY[:1], "3", *STUDY[2:], "--results", whole, good=(2,))
    assert "seeds" in other, other


def wrong_words_are_refused(folder):
    assert "variant" in run("policy", "x.toml", "--variant", "onlin", good=(2,))
    assert "did you mean online" in run("policy", "x.toml", "--variant", "onlin", good=(2,))
    assert "trials" in run("policy", "x.toml", "--trials", "0", good=(2,))
    run("report", "--results", str(folder / "none.jsonl"), good=(2,))
    run("policy", str(folder / "no" / "such" / "x.toml"), "--trials", "1", good=(2,))


with tempfile.TemporaryDirectory() as name:
    place = pathlib.Path(name)
    wrong_words_are_refused(place)
    the_same_seed_is_the_same_file(place)
    a_killed_study_goes_on_to_the_same_bytes(place)
