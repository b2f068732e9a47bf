"""Every kind of fault on every device, in flight: the process lives, no motor turns on an old command, and the flight
ends landed or safe.

usage: fault_matrix.py SINEW SINEW_SIM ROBOT [--device NAME]... [--kind NAME]... [--seeds N] [--first-seed S] [--jobs N]
                       [--camera WxH] [--folder FOLDER]
       fault_matrix.py SINEW SINEW_SIM ROBOT --check-table DEVICE...

The first form flies by `sinew sweep`, prints one line a flight and exits 0 when each ended as CELLS says. The sweep's
results stay in FOLDER, where the same command goes on after it was stopped; without --folder nothing stays. The second
form checks without flying that CELLS and DEVICE... hold all devices and kinds that the plant knows.
"""
import argparse
import json
import os
import shlex
import signal
import subprocess
import sys
import tempfile

RUN_DIR = tempfile.TemporaryDirectory()  # this program's robots meet nobody else's
os.environ["SINEW_RUN_DIR"] = RUN_DIR.name

LIMIT_S = 300  # of real time for one flight on a busy machine
DURATION_S = 75  # of plant time: a search without result, and a slow descent

# device -> kind -> (the fault that is played, how the flight must end).
#   landed: at rest with stopped motors, having touched down with less than 1 m/s and on its feet, wherever
#   safe:   that, or at rest with stopped motors: a failsafe, the guardian or the end of a lease has stopped them, and a
#           vehicle that was in the air has fallen
# All begin after 5 s: in the air, 1 to 2.3 m up, on the way to the pad. They last. The plant refuses a kind that a device
# cannot have, with the reason (sinew-sim --list-faults); every other pair must be in this table.
SENSOR_KINDS = ("off", "stuck", "garbage", "wrong", "slow", "delayed", "intermittent", "duplicated")


def sensor(device, **other):
    """All kinds of one sensor: they must end landed, except those in `other`."""
    return {kind: other.get(kind, (f"{device}:{kind}@5", "landed")) for kind in SENSOR_KINDS}


CELLS = {
    "imu": sensor("imu",  # no flight goes on without one
                  off=("imu:off@5", "safe"), stuck=("imu:stuck@5", "safe"), garbage=("imu:garbage@5", "safe"),
                  wrong=("imu:wrong@5", "safe"), delayed=("imu:delayed(5ms)@5", "landed"),
                  intermittent=("imu:intermittent(5ms)@5", "landed")),
    "range": sensor("range", wrong=("range:wrong@5", "safe")),  # half a metre too much: the ground comes unseen
    "baro": sensor("baro"),
    "battery": sensor("battery", wrong=("battery:wrong(-4)@5", "landed")),
    "camera": sensor("camera",  # aborts, and comes down on any ground
                     off=("camera:off@5", "safe"), stuck=("camera:stuck@5", "safe"),
                     garbage=("camera:garbage@5", "safe")),
    "motors": {
        "off": ("motors:off@5", "safe"),
        "stuck": ("motors:stuck@5", "safe"),
        "garbage": ("motors:garbage@5", "safe"),
        "wrong": ("motors:wrong@5", "landed"),
        "slow": ("motors:slow@5", "landed"),
        "delayed": ("motors:delayed@5", "landed"),
        "intermittent": ("motors:intermittent@5", "safe"),
    },
    "link": {
        "off": ("link:off@5", "safe"),
        "delayed": ("link:delayed(5ms)@5", "landed"),
        "intermittent": ("link:intermittent@5", "safe"),
        "closed": ("link:closed@5", "safe"),
    },
}


# Robots that fly alone read no radio: tests/apps/team/team_test.py flies these.
OF_TEAMS = ("radio",)


def known_cells(sinew_sim):
    """(device, kind, reason why the device cannot have it, or '') of every pair that the plant knows."""
    done = subprocess.run([sinew_sim, "--list-faults"], capture_output=True, text=True, check=True, timeout=60)
    for line in done.stdout.splitlines():
        pair, _, reason = line.partition(" - ")
        device, kind = pair.split()
        if device not in OF_TEAMS:
            yield device, kind, reason


def missing(cells, devices):
    """Missing and superfluous entries of the table or the list of devices, in words."""
    for device, kind, reason in cells:
        here = kind in CELLS.get(device, {})
        if not here and not reason:
            yield f"{device} {kind}: missing: neither flown nor refused with a reason"
        if here and reason:
            yield f"{device} {kind}: flown here, but refused: {reason}"
    known = {device for device, _, _ in cells}
    for device in sorted(known - set(devices)):
        yield f"{device}: no test flies this device"
    for device in sorted((set(devices) | set(CELLS)) - known):
        yield f"{device}: the plant does not know it"


def sweep(args, faults, folder):
    """The results of the sweep of these faults over all seeds, by fault and seed."""
    argv = [args.sinew, "sweep", os.path.abspath(args.robot), "--camera", args.camera, "--duration", str(DURATION_S),
            "--seeds", f"{args.first_seed}..{args.first_seed + args.seeds - 1}", "--jobs", str(args.jobs),
            "--patience", str(LIMIT_S), "--json"]
    for fault in faults:
        argv += ["--fault", fault]
    done = subprocess.run(argv, cwd=folder, stdout=subprocess.PIPE, text=True)
    if done.returncode not in (0, 1):
        sys.exit(f"sinew sweep: exit code {done.returncode}")
    told = json.loads(done.stdout)
    if told["runs"] < told["cases"]:
        sys.exit(f"{told['runs']} of {told['cases']} flights")
    results = {}
    with open(os.path.join(folder, told["results"]), encoding="utf-8") as file:
        next(file)  # what the sweep is
        for text in file:
            result = json.loads(text)
            words = shlex.split(result["run"])
            results[words[words.index("--fault") + 1], int(words[words.index("--seed") + 1])] = result
    return results


def judge(result, wanted):
    """How a flight ended, and what is wrong with that."""
    r = result.get("report")
    if result["code"] not in (0, 1) or r is None:
        return "broken", [f"exit code {result['code']}: {result['outcome']}"]
    wrong = []
    if r["stale_actuations"]:
        wrong.append(f"{r['stale_actuations']} plant steps on a command past its lease")
    if sum(f["affected"] for f in r["faults"]) == 0:
        wrong.append("the fault never struck")
    still = r["at_rest"] and r["motors_stopped"]
    soft = r["touched_down"] and not r["crashed"] and r["touchdown_speed_mps"] < 1.0
    ended = "unsafe" if not still else "landed" if soft else "stopped"
    if not still:
        wrong.append("motors turn" if r["at_rest"] else "is not at rest")
    elif wanted == "landed" and ended != "landed":
        wrong.append("must land")
    return ended, wrong


def line(device, kind, seed, ended, wrong, r):
    text = f"{device:8} {kind:13} {seed:4}  {ended:8}"
    if r:
        text += f" {r['plant_s']:6.1f} s {r.get('touchdown_speed_mps', 0):6.2f} m/s {r['pad_distance_m']:6.2f} m off"
        text += f" {r['setpoint_age_max_ns'] * 1e-6:6.1f} ms"
    return text + ("  WRONG: " + "; ".join(wrong) if wrong else "")


def fly_all(args, cells, folder):
    flown = [(device, kind) for device, kind, reason in cells if not reason]
    results = sweep(args, [CELLS[device][kind][0] for device, kind in flown], folder)
    print("device   kind          seed  ended     after    touched down   from the pad  oldest measurement acted on")
    bad = 0
    for device, kind in flown:
        fault, wanted = CELLS[device][kind]
        for seed in range(args.first_seed, args.first_seed + args.seeds):
            result = results[fault, seed]
            ended, wrong = judge(result, wanted)
            print(line(device, kind, seed, ended, wrong, result.get("report")))
            bad += bool(wrong)
    for device, kind, reason in cells:
        if reason:
            print(f"{device:8} {kind:13} none: {reason}")
    print(f"{len(results)} flights, {bad} wrong")
    return bad


def main():
    p = argparse.ArgumentParser()
    p.add_argument("sinew")
    p.add_argument("sinew_sim")
    p.add_argument("robot")
    p.add_argument("--device", action="append")
    p.add_argument("--kind", action="append")
    p.add_argument("--seeds", type=int, default=1)
    p.add_argument("--first-seed", type=int, default=3)
    p.add_argument("--jobs", type=int, default=1)
    p.add_argument("--camera", default="160x120")
    p.add_argument("--folder")
    p.add_argument("--check-table", nargs="+", metavar="DEVICE")
    args = p.parse_args()
    cells = list(known_cells(args.sinew_sim))
    problems = list(missing(cells, args.check_table or CELLS))
    for problem in problems:
        print(problem)
    if problems or args.check_table:
        sys.exit(1 if problems else 0)
    chosen = [c for c in cells if (not args.device or c[0] in args.device) and (not args.kind or c[1] in args.kind)]
    if not chosen:
        sys.exit(f"no device {args.device} with a fault {args.kind}")
    signal.signal(signal.SIGINT, lambda *_: None)  # Ctrl-C ends the sweep, and that ends us
    with tempfile.TemporaryDirectory() as folder:
        sys.exit(1 if fly_all(args, chosen, args.folder or folder) else 0)


if __name__ == "__main__":
    main()
