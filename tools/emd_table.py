#!/usr/bin/env python3
"""The table of docs/emd.md from the results of its sweep.

    sinew sweep robots/terrain/terrain{,_contrast,_raw,_range}.toml --seeds 1..20 --set sim.terrain=1,2,3 --duration 46 --csv emd.csv
    tools/emd_table.py emd.csv
"""
import csv
import pathlib
import statistics
import sys

DETECTORS = {"terrain": "gradient", "terrain_contrast": "normalised by contrast", "terrain_raw": "raw, as published",
             "terrain_range": "range finder"}
TERRAINS = {"1": "hills", "2": "steps", "3": "buildings"}


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    groups = {}
    with open(sys.argv[1], newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            robot = pathlib.Path(row["run"].split(".toml")[0].split()[-1]).name
            groups.setdefault((robot, row["sim.terrain"]), []).append(row)
    print("| height by | terrain | held its height | touched the ground | height off, worst second: median, worst "
          "| time within 25 %: median | least height |")
    print("|---|---|---|---|---|---|---|")
    for robot, name in DETECTORS.items():
        for terrain, place in TERRAINS.items():
            rows = groups.get((robot, terrain), [])
            if not rows:
                continue
            good = sum(row["good"] == "1" for row in rows)
            touched = sum(row["outcome"] == "touched the ground" for row in rows)

            def values(key, rows=rows):
                return [float(row[key]) for row in rows if row[key]] or [float("nan")]
            off, within, clear = values("height_off_percent"), values("within_percent"), values("clearance_m")
            print(f"| {name} | {place} | {good} of {len(rows)} | {touched} | {statistics.median(off):.0f} %, {max(off):.0f} % "
                  f"| {statistics.median(within):.0f} % | {min(clear):.2f} m |")


if __name__ == "__main__":
    main()
