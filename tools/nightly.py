#!/usr/bin/env python3
"""Makes the figures of docs/how-sure.md again, by `sinew sweep`, and writes them as a page.

usage: tools/nightly.py [--seeds N] [--fault-seeds N] [--build FOLDER] [--out FILE]

--seeds N        seeds 1..N of each sweep (default 1000)
--fault-seeds N  seeds 1..N of each cell of the fault matrix (default 20)
--build FOLDER   build/FOLDER/bin/sinew flies (default release)
--out FILE       the page (default build/nightly/figures.md)

The results stay in build/nightly/: after Ctrl-C or kill -9 the same command goes on. Results of another program or of
other seeds are replaced. Exit code 0 when all was flown, whatever came of it: the page says that.
"""
import argparse
import datetime
import json
import os
import pathlib
import resource
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
HERE = ROOT / "build/nightly"
QUAD, HEAD, SEESAW = "robots/quad/quad.toml", "robots/desk_head/desk_head.toml", "robots/seesaw/seesaw.toml"

# name, in words, options, the measures that the page shows
SWEEPS = (
    ("calm", "quadrotor, calm air", [QUAD, "--camera", "64x48", "--set", "sim.gust_mps=0"], ("landing_error_m", "touchdown_speed_mps")),
    ("gusts3", "quadrotor, gusts of 3 m/s", [QUAD, "--camera", "64x48", "--set", "sim.gust_mps=3"],
     ("landing_error_m", "touchdown_speed_mps")),
    ("gusts6", "quadrotor, gusts of 6 m/s", [QUAD, "--camera", "64x48", "--set", "sim.gust_mps=6"],
     ("landing_error_m", "touchdown_speed_mps")),
    ("head", "desk head, 30 s", [HEAD, "--camera", "96x72", "--duration", "30"], ("angle_rms_deg", "in_view_share")),
)
PAIRS = (("gusts3", "calm"), ("gusts6", "gusts3"))
# For the table of costs: what the camera takes.
COSTS = (("quad320", "quadrotor, camera 320x240", [QUAD]),
         ("seesaw", "seesaw, 30 s, without a camera", [SEESAW, "--duration", "30"]))
COST_SEEDS = 10
MILLION = 1_000_000
# Without its camera from 6 s on it misses the pad: these runs are recorded.
RECORDED = [QUAD, "--fault", "camera:off@6", "--seeds", "1..4"]


def processor_s():
    """Of all processes that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def written():
    """Bytes for the disk, of all processes that have ended. Source: Linux, Documentation/filesystems/proc.rst, /proc/PID/io."""
    words = pathlib.Path("/proc/self/io").read_text(encoding="ascii").split()
    return int(words[words.index("write_bytes:") + 1])


class Flown:
    """A sweep with its results, and what they took: a file beside them keeps that for a night that goes on."""

    def __init__(self, sinew, name, options, more=()):
        self.command = "sinew sweep " + " ".join(options)
        self.file, cost_file = HERE / f"{name}.jsonl", HERE / f"{name}.cost.json"
        before = self.lines()
        argv = [sinew, "sweep", *options, "--results", str(self.file), "--json", *more]
        used, on_disk = processor_s(), written()
        done = subprocess.run(argv, cwd=ROOT, stdout=subprocess.PIPE, text=True)
        if done.returncode == 2 and before:  # of another sweep: the page is about this one
            self.file.unlink()
            cost_file.unlink(missing_ok=True)
            before = 0
            done = subprocess.run(argv, cwd=ROOT, stdout=subprocess.PIPE, text=True)
        if done.returncode not in (0, 1):
            sys.exit(f"{self.command}: exit code {done.returncode}")
        now = {"runs": self.lines() - before, "processor_s": processor_s() - used, "written": written() - on_disk}
        earlier = json.loads(cost_file.read_text(encoding="utf-8")) if cost_file.exists() else {}
        self.cost = earlier if now["runs"] == 0 else {key: value + earlier.get(key, 0) for key, value in now.items()}
        cost_file.write_text(json.dumps(self.cost), encoding="utf-8")
        self.told = json.loads(done.stdout)
        if self.told["runs"] < self.told["cases"]:
            sys.exit(f"{self.command}: {self.told['runs']} of {self.told['cases']} runs; the same command goes on")

    def lines(self):
        return max(0, self.file.read_bytes().count(b"\n") - 1) if self.file.exists() else 0

    def measure(self, name):
        return next((m for m in self.told["measures"] if m["name"] == name), None)


def share(part):
    return f"{part['runs']} | {100 * part['share']:.1f} % | {100 * part['low']:.1f} to {100 * part['high']:.1f} %"


def rows_of_sweeps(flown):
    yield "| what | runs | good | share | 95 % interval |"
    yield "|---|---|---|---|---|"
    for sweep, (_, words, _, _) in zip(flown, SWEEPS):
        yield f"| {words} | {sweep.told['runs']} | {share(sweep.told['good'])} |"
    yield ""
    yield "| what | measure | median | 95 % are better than | worst | limit |"
    yield "|---|---|---|---|---|---|"
    for sweep, (_, words, _, measures) in zip(flown, SWEEPS):
        for m in filter(None, map(sweep.measure, measures)):
            limit = f"at most {m['at_most']:g}" if "at_most" in m else f"at least {m['at_least']:g}" if "at_least" in m else ""
            yield f"| {words} | `{m['name']}` | {m['median']:.3g} | {m['p95']:.3g} | {m['worst']:.3g} | {limit} |"
    yield ""
    bad = [f"- {words}: {outcome['outcome']}, {outcome['runs']}" for sweep, (_, words, _, _) in zip(flown, SWEEPS)
           for outcome in sweep.told["outcomes"] if not outcome["good"]]
    yield "Runs that were not good:" if bad else "All runs were good."
    yield ""
    yield from bad


def rows_of_pairs(flown):
    words = {name: text for name, text, _, _ in SWEEPS}
    by_name = {name: sweep for (name, _, _, _), sweep in zip(SWEEPS, flown)}
    for now, before in PAIRS:
        against = by_name[now].told["against"]
        yield (f"- {words[now]} against {words[before]}: {against['pairs']} pairs by seed, {against['better']} better, "
               f"{against['worse']} worse, p = {against['mcnemar_p']:.2g}")


def rows_of_costs(costs):
    yield ("| what | processor, s a run | runs an hour of one core | results, bytes a run | written to the disk, bytes a run "
           "| a million runs on 1000 cores | their results |")
    yield "|---|---|---|---|---|---|---|"
    for words, sweep in costs:
        cost = sweep.cost
        each, size = cost["processor_s"] / cost["runs"], sweep.file.stat().st_size / sweep.told["runs"]
        yield (f"| {words} | {each:.2f} | {3600 / each:.0f} | {size:.0f} | {cost['written'] / cost['runs']:.0f} "
               f"| {each * MILLION / 1000 / 60:.0f} min | {size * MILLION * 1e-9:.1f} GB |")


def recording_mb(sinew):
    """Of a failed run, by `--record failures`."""
    sweep = Flown(sinew, "recorded", RECORDED, ("--record", "failures"))
    sizes = [file.stat().st_size for file in (HERE / "recorded-failures").glob("case-*/*/*.mcap")
             if not file.parent.is_symlink()]  # "latest"
    return sweep.command, 1e-6 * sum(sizes) / sweep.told["runs"]


def matrix(bin_folder, seeds):
    """The last line of the fault matrix, and a row for each cell."""
    folder = HERE / "faults"
    folder.mkdir(exist_ok=True)
    argv = [sys.executable, "-B", ROOT / "tests/apps/run/fault_matrix.py", bin_folder / "sinew", bin_folder / "sinew-sim",
            ROOT / QUAD, "--seeds", str(seeds), "--first-seed", "1", "--jobs", str(len(os.sched_getaffinity(0))), "--camera", "64x48",
            "--folder", folder]
    said = subprocess.run(argv, stdout=subprocess.PIPE, text=True).stdout.splitlines()
    if not said or "flights" not in said[-1]:
        sys.exit("the fault matrix was not flown")
    devices = {}
    for line in said[1:-1]:
        device, kind, seed, *rest = line.split()
        if seed == "none:":
            continue
        ends = devices.setdefault(device, {"landed": 0, "stopped": 0, "other": 0, "wrong": 0})
        ends[rest[0] if rest[0] in ends else "other"] += 1
        ends["wrong"] += "WRONG" in line
    yield f"Every kind of fault on every device of the quadrotor, from 5 s on, seeds 1 to {seeds}: {said[-1]}."
    yield ""
    yield "| faults of | landed | stopped by a failsafe or the guardian | neither | not as they must |"
    yield "|---|---|---|---|---|"
    for device, ends in devices.items():
        yield f"| {device} | {ends['landed']} | {ends['stopped']} | {ends['other']} | {ends['wrong']} |"


def main():
    p = argparse.ArgumentParser()
    p.add_argument("--seeds", type=int, default=1000)
    p.add_argument("--fault-seeds", type=int, default=20)
    p.add_argument("--build", default="release")
    p.add_argument("--out", default=str(HERE / "figures.md"))
    args = p.parse_args()
    HERE.mkdir(parents=True, exist_ok=True)
    bin_folder = ROOT / "build" / args.build / "bin"
    sinew = str(bin_folder / "sinew")
    before = dict(PAIRS)
    flown, costs = [], []
    for name, words, options, _ in SWEEPS:
        more = ("--against", str(HERE / f"{before[name]}.jsonl")) if name in before else ()
        flown.append(Flown(sinew, name, [*options, "--seeds", f"1..{args.seeds}"], more))
        costs.append((f"{words}, camera {options[options.index('--camera') + 1]}", flown[-1]))
    for name, words, options in COSTS:
        costs.append((words, Flown(sinew, name, [*options, "--seeds", f"1..{min(args.seeds, COST_SEEDS)}"])))
    record, mb = recording_mb(sinew)
    commit = subprocess.run(["git", "describe", "--always", "--dirty"], cwd=ROOT, capture_output=True, text=True).stdout.strip()
    page = [
        "# How sure we are: the figures", "",
        f"Written by `tools/nightly.py --seeds {args.seeds} --fault-seeds {args.fault_seeds}` on {datetime.date.today()}, commit "
        f"{commit or 'unknown'}, {len(os.sched_getaffinity(0))} processors. [How sure we are](how-sure.md) says what they mean.", "",
        *("    " + sweep.command for sweep in flown), "",
        *rows_of_sweeps(flown), "", "## Against each other", "", *rows_of_pairs(flown), "",
        "## Faults", "", *matrix(bin_folder, args.fault_seeds), "", "## Cost", "", *rows_of_costs(costs), "",
        f"A failed run that is recorded (`{record} --record failures`) takes {mb:.0f} MB: of a million runs each per cent that fails "
        f"{mb * MILLION * 0.01 * 1e-6:.1f} TB.", ""]
    pathlib.Path(args.out).write_text("\n".join(page), encoding="utf-8")
    print(f"{args.out}: {sum(s.told['runs'] for s in flown)} runs")


if __name__ == "__main__":
    main()
