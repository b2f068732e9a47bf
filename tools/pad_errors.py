#!/usr/bin/env python3
"""How the pad detector errs: its sightings in recorded flights against the true pose of the camera.

usage: pad_errors.py SINEW RUN.mcap...
Prints, by distance of the camera from the pad, the errors of centre (px, each axis) and radius (share), and how many
pictures showed the pad; what sinew-learn flies with instead of pictures (apps/learn/pad_camera.hpp) is from here."""
import bisect
import csv
import io
import math
import subprocess
import sys

RADIUS_M, CAMERA_M, HEIGHT_PX, WIDTH_PX = 0.30, (0.0, 0.0, -0.04), 240, 320
FOCAL_PX = 0.875 * HEIGHT_PX
OPTICAL = (0.0, 0.70710678118654752, -0.70710678118654752, 0.0)  # q_base_optical


def rows(sinew, run, topic):
    said = subprocess.run([sinew, "bag", "csv", run, "--topic", topic], check=True, capture_output=True, text=True)
    return list(csv.DictReader(io.StringIO(said.stdout)))


def turned(q, v, back=False):
    w, x, y, z = q if not back else (q[0], -q[1], -q[2], -q[3])
    t = [2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])]
    return [v[0] + w * t[0] + y * t[2] - z * t[1], v[1] + w * t[1] + z * t[0] - x * t[2],
            v[2] + w * t[2] + x * t[1] - y * t[0]]


def numbers(row, name, parts):
    return [float(row[f"{name}.{p}"]) for p in parts]


def spread(values):
    mean = sum(values) / len(values)
    return mean, math.sqrt(sum((v - mean) ** 2 for v in values) / len(values))


def main(sinew, runs):
    bins = {}
    for run in runs:
        truth = rows(sinew, run, "ground_truth")
        stamps = [int(t["stamp"]) for t in truth]
        for s in rows(sinew, run, "pad.sighting"):
            at = int(s["stamp"])
            i = bisect.bisect(stamps, at)
            if i == 0 or i == len(stamps):
                continue
            share = (at - stamps[i - 1]) / (stamps[i] - stamps[i - 1])
            mix = [[a + share * (b - a) for a, b in zip(numbers(truth[i - 1], n, p), numbers(truth[i], n, p))]
                   for n, p in (("p_world_m", "xyz"), ("q_world_base", "wxyz"))]
            camera = [a + b for a, b in zip(mix[0], turned(mix[1], CAMERA_M))]
            base = turned(mix[1], [-c for c in camera], back=True)
            p = turned(OPTICAL, base, back=True)
            if p[2] < 0.05 or camera[2] < 0.12:
                continue
            key = min(2.25, math.floor(p[2] / 0.25) * 0.25)
            entry = bins.setdefault(key, {"all": 0, "u": [], "v": [], "size": [], "radius": []})
            entry["all"] += 1
            if s["found"] != "1":
                continue
            u = p[0] / p[2] * FOCAL_PX + 0.5 * (WIDTH_PX - 1)
            v = p[1] / p[2] * FOCAL_PX + 0.5 * (HEIGHT_PX - 1)
            distance = math.sqrt(sum(c * c for c in p))
            entry["u"].append(float(s["u_px"]) - u)
            entry["v"].append(float(s["v_px"]) - v)
            entry["size"].append(distance / float(s["range_m"]) - 1)
            entry["radius"].append(FOCAL_PX * RADIUS_M / p[2])
    print("distance   pictures found  radius px   centre px: mean u, v; sigma u, v      size: mean, sigma")
    for key, e in sorted(bins.items()):
        if not e["u"]:
            print(f"{key:4.2f} m     {e['all']:6}   0 %")
            continue
        (mu, su), (mv, sv), (ms, ss) = spread(e["u"]), spread(e["v"]), spread(e["size"])
        print(f"{key:4.2f} m     {e['all']:6} {100 * len(e['u']) / e['all']:4.0f} %  {spread(e['radius'])[0]:8.1f}   "
              f"{mu:7.2f} {mv:7.2f}  {su:7.2f} {sv:7.2f}        {ms:8.4f} {ss:8.4f}")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
