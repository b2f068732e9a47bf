#!/usr/bin/env python3
"""Which Debian packages programs need, by dpkg-shlibdeps; for another machine by the package database of its sysroot.

    tools/deb_depends.py [--sysroot DIR --arch arm64 --triplet aarch64-linux-gnu] --depends FILE... [--recommends FILE...]

Prints "Depends: ..." and "Recommends: ...", as a package's fields. A package that is needed is not recommended as well.
Exit: 0 done; 1 a library has no package, or the tool is missing (says which); 2 wrong call.
"""
import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile


def database_of(sysroot, target):
    """A copy of the sysroot's database with the paths that the files have on this machine."""
    source = os.path.join(sysroot, "var/lib/dpkg")
    if not os.path.isfile(f"{source}/status"):
        sys.exit(f"deb_depends: no package database in {sysroot}; toolchains/sysroot.sh makes a sysroot with one")
    os.makedirs(f"{target}/info")
    os.makedirs(f"{target}/updates")
    shutil.copy(f"{source}/status", target)
    for name in os.listdir(f"{source}/info"):
        path = f"{source}/info/{name}"
        if not name.endswith(".list"):
            shutil.copy(path, f"{target}/info")
            continue
        paths = set()
        with open(path) as f:
            for line in f.read().splitlines():
                # The sysroot has lib/ within usr/, as a running system has.
                paths.add(sysroot + line)
                if re.match(r"/lib(32|64|x32)?/", line):
                    paths.add(f"{sysroot}/usr{line}")
        with open(f"{target}/info/{name}", "w") as f:
            f.write("\n".join(sorted(paths)) + "\n")
    return target


def shlibdeps(args, folder):
    os.makedirs(f"{folder}/debian")
    with open(f"{folder}/debian/control", "w") as f:
        f.write("Source: sinew\nMaintainer: nobody <nobody@example.org>\n\nPackage: sinew\nArchitecture: any\n")
    command = ["dpkg-shlibdeps", "-O"]
    env = {**os.environ, "LC_ALL": "C"}
    if args.sysroot:
        sysroot = os.path.realpath(args.sysroot)
        command.append("--admindir=" + database_of(sysroot, f"{folder}/dpkg"))
        command.append(f"-l{sysroot}/usr/lib/{args.triplet}")
        env.update({"DEB_HOST_ARCH": args.arch, "DEB_HOST_MULTIARCH": args.triplet})
    for field, files in (("Depends", args.depends), ("Recommends", args.recommends)):
        command += [f"-d{field}"] + [f"-e{os.path.abspath(f)}" for f in files]
    done = subprocess.run(command, cwd=folder, env=env, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"deb_depends: dpkg-shlibdeps: {done.stderr.strip()}")
    return dict(re.findall(r"^shlibs:(\w+)=(.*)$", done.stdout, re.M))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sysroot")
    parser.add_argument("--arch")
    parser.add_argument("--triplet")
    parser.add_argument("--depends", nargs="+", required=True)
    parser.add_argument("--recommends", nargs="*", default=[])
    args = parser.parse_args()
    if args.sysroot and not (args.arch and args.triplet):
        parser.error("--sysroot needs --arch and --triplet")
    if not shutil.which("dpkg-shlibdeps"):
        sys.exit("deb_depends: dpkg-shlibdeps is missing (Debian: dpkg-dev)")
    for path in args.depends + args.recommends:
        try:
            with open(path, "rb") as f:
                if f.read(4) != b"\x7fELF":
                    sys.exit(f"deb_depends: {path}: neither a program nor a library")
        except OSError as error:
            sys.exit(f"deb_depends: {path}: {error.strerror}")
    with tempfile.TemporaryDirectory() as folder:
        found = shlibdeps(args, folder)
    needed = found.get("Depends", "")
    names = {entry.split()[0] for entry in needed.split(", ") if entry}
    extra = [e for e in found.get("Recommends", "").split(", ") if e and e.split()[0] not in names]
    print(f"Depends: {needed}")
    print(f"Recommends: {', '.join(extra)}")


if __name__ == "__main__":
    main()
