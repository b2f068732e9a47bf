"""Every kind of fault on every device, in flight: the process lives, no motor turns on an old command, and the flight
ends landed or safe.

usage: fault_matrix.py SINEW SINEW_SIM ROBOT [--seeds N] [--first-seed S] [--device NAME] [--jobs N]
Exit code 0: all cells as EXPECTED says, and none is missing.
"""
import argparse
import concurrent.futures
import json
import os
import subprocess
import sys
import tempfile

FROM_S = 5  # of plant time: searching or approaching, 1 to 2.3 m up
LIMIT_S = 300  # of real time for one flight on a busy machine
DURATION_S = 75  # of plant time: a search without result, and a slow descent

# device -> kind -> what is played. A kind that makes no sense for a device is refused by sinew-sim with its reason,
# which `sinew-sim --list-faults` prints; every other one needs a line here.
PLAYED = {
    "imu": {
        "off": "imu:off@5",
        "stuck": "imu:stuck@5",
        "garbage": "imu:garbage@5",
        "wrong": "imu:wrong@5",
        "slow": "imu:slow@5",
        "delayed": "imu:delayed(5ms)@5",
        "intermittent": "imu:intermittent(5ms)@5",
        "duplicated": "imu:duplicated@5",
    },
    **{device: {kind: f"{device}:{kind}@5" for kind in
                ("off", "stuck", "garbage", "wrong", "slow", "delayed", "intermittent", "duplicated")}
       for device in ("range", "baro", "battery", "camera")},
    "motors": {kind: f"motors:{kind}@5" for kind in
               ("off", "stuck", "garbage", "wrong", "slow", "delayed", "intermittent")},
    "link": {kind: f"link:{kind}@5" for kind in ("off", "delayed", "intermittent", "closed")},
}


def cells(sinew_sim):
    """(device, kind, reason why it is none or '') of every cell there is."""
    done = subprocess.run([sinew_sim, "--list-faults"], capture_output=True, text=True, check=True, timeout=60)
    for line in done.stdout.splitlines():
        pair, _, reason = line.partition(" - ")
        device, kind = pair.split()
        yield device, kind, reason


def fly(args, fault, seed):
    with tempfile.TemporaryDirectory() as folder:
        report = os.path.join(folder, "report.json")
        done = subprocess.run(
            [args.sinew, "run", args.robot, "--virtual", "--quiet", "--seed", str(seed), "--camera", "160x120",
             "--duration", str(DURATION_S), "--fault", fault, "--plant-arg", "--report", "--plant-arg", report],
            capture_output=True, text=True, timeout=LIMIT_S)
        with open(report) as f:
            return done, json.load(f)


def outcome(done, r):
    """What became of a flight, and what is wrong with it (empty: nothing)."""
    wrong = []
    if done.returncode not in (0, 1):
        wrong.append(f"exit code {done.returncode}: {done.stderr.strip()[-300:]}")
    if r["stale_actuations"]:
        wrong.append(f"{r['stale_actuations']} plant steps on a command past its lease")
    if r["faults"][0]["affected"] == 0:
        wrong.append("the fault never struck")
    still = r["at_rest"] and r["motors_stopped"]
    soft = r["touched_down"] and not r["crashed"] and r["touchdown_speed_mps"] < 1.0
    if still and soft:
        return "landed", wrong
    if still:
        return "stopped", wrong
    return "unsafe", wrong


def main():
    p = argparse.ArgumentParser()
    p.add_argument("sinew")
    p.add_argument("sinew_sim")
    p.add_argument("robot")
    p.add_argument("--seeds", type=int, default=1)
    p.add_argument("--first-seed", type=int, default=3)
    p.add_argument("--device")
    p.add_argument("--jobs", type=int, default=1)
    args = p.parse_args()
    bad = 0
    with concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
        for device, kind, reason in cells(args.sinew_sim):
            if args.device and device != args.device:
                continue
            played = PLAYED.get(device, {}).get(kind)
            if bool(reason) == bool(played):
                print(f"{device:8} {kind:13} MISSING: neither played nor refused with a reason, or both")
                bad += 1
                continue
            if reason:
                print(f"{device:8} {kind:13} -  {reason}")
                continue
            for seed, (done, r) in zip(range(args.first_seed, args.first_seed + args.seeds),
                                       pool.map(lambda s: fly(args, played, s),
                                                range(args.first_seed, args.first_seed + args.seeds))):
                what, wrong = outcome(done, r)
                last = [l for l in done.stdout.splitlines() if l.startswith("result")]
                print(f"{device:8} {kind:13} seed {seed}: {what:8} {r['plant_s']:6.2f} s, down {r.get('touchdown_s', 0):5.1f} s "
                      f"{r.get('touchdown_speed_mps', 0):5.2f} m/s, {r['pad_distance_m']:6.2f} m off, z {r['height_m']:.2f} max {r['max_height_m']:.2f} age {r['setpoint_age_max_ns']/1e6:.1f}ms {last} {' ; '.join(wrong)}", flush=True)
                bad += bool(wrong)
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
