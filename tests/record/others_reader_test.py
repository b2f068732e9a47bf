#!/usr/bin/env python3
"""Foreign readers find the same as our own reader in every file that our tests write.

usage: others_reader_test.py DUMP FOLDER...     exit 77: skipped, with the reason

The folders hold what others_files.py has made. The readers are npm packages, pinned in others/package-lock.json;
tools/setup.sh installs them.
"""
import pathlib
import shutil
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
SKIPPED = 77


def reason_to_skip(*packages):
    if not shutil.which("node"):
        return "node is not installed"
    if not all((HERE / "others/node_modules" / package).is_dir() for package in packages):
        return "the packages of tests/record/others are not installed (npm ci there, or tools/setup.sh test)"
    return None


def by_file(text):
    """{path: sorted lines} of a reader's output."""
    files, lines = {}, []
    for line in text.splitlines():
        if line.startswith("file "):
            lines = files.setdefault(line[5:], [])
        else:
            lines.append(line)
    return {path: sorted(lines) for path, lines in files.items()}


def compare(dump, paths):
    """True when theirs and ours differ; prints the differences."""
    theirs = subprocess.run(["node", HERE / "others/read_all.mjs", *paths], capture_output=True, text=True)
    ours = subprocess.run([dump, *paths], capture_output=True, text=True)
    failed = theirs.returncode != 0 or ours.returncode != 0
    if failed:
        refused = [line for line in (theirs.stdout + ours.stdout).splitlines() if line.startswith(tuple(paths))]
        print("\n".join(refused), theirs.stderr, ours.stderr)
    theirs, ours = by_file(theirs.stdout), by_file(ours.stdout)
    messages = 0
    for path in paths:
        messages += sum(line.startswith("message ") for line in ours.get(path, []))
        for line in sorted(set(theirs.get(path, [])) ^ set(ours.get(path, [])))[:10]:
            print(path, "theirs:" if line in theirs.get(path, []) else "ours:", line)
            failed = True
        failed = failed or theirs.get(path) != ours.get(path)
    print(len(paths), "files,", messages, "messages")
    return failed


def main():
    dump, folders = sys.argv[1], sys.argv[2:]
    reason = reason_to_skip("@mcap/core")
    if reason:
        print("skipped:", reason)
        return SKIPPED
    paths = []
    for folder in folders:
        written = sorted(str(p) for p in pathlib.Path(folder).glob("*.mcap"))
        if len(written) < 50:
            print(folder, "has", len(written), "files; expected are 50 and more")
            return 1
        paths += written
    return 1 if compare(dump, paths) else 0


if __name__ == "__main__":
    sys.exit(main())
