"""The packages of a build, unpacked into a scratch folder; shared by the tests of packages."""
import argparse
import glob
import json
import os
import subprocess
import sys
import tarfile
import tempfile
import unittest
import zipfile

parser = argparse.ArgumentParser()
parser.add_argument("--source", required=True)
parser.add_argument("--build", required=True)
parser.add_argument("--emulator", default="")
parser.add_argument("--toolchain", default="")
ARGS, CASES = parser.parse_known_args()
PACKAGES = f"{ARGS.build}/packages"
CROSS = bool(ARGS.emulator)
WORK = tempfile.TemporaryDirectory(prefix="sinew-packages-")
os.environ.update({"SINEW_RECORD": "off", "SINEW_RUN_DIR": f"{WORK.name}/run", "LC_ALL": "C"})
os.mkdir(f"{WORK.name}/run", 0o700)


def found(pattern):
    return sorted(glob.glob(f"{PACKAGES}/{pattern}"))


def unpacked():
    """The folder that stands for usr/ of the machine: all packages together."""
    folder = f"{WORK.name}/unpacked"
    if not os.path.isdir(folder):
        os.mkdir(folder)
        for deb in found("*.deb"):
            subprocess.run(["dpkg-deb", "-x", deb, folder], check=True)
        for archive in found("*.zip"):
            with zipfile.ZipFile(archive) as z:
                z.extractall(folder)
        for tarball in found("*.tar.gz"):
            with tarfile.open(tarball) as tar:
                # Debian 12's Python (3.11.2) has no filters yet; later versions require one.
                tar.extractall(folder, **({"filter": "tar"} if hasattr(tarfile, "tar_filter") else {}))
    inner = glob.glob(f"{folder}/sinew-*")
    return inner[0] if inner else f"{folder}/usr"


if not found("*.spdx.json"):
    print(f"no packages in {PACKAGES}; this makes them: cmake --build {ARGS.build} --target packages")
    sys.exit(77)  # ctest: skipped


def field(deb, name):
    return subprocess.run(["dpkg-deb", "-f", deb, name], check=True, capture_output=True, text=True).stdout.strip()


class Base(unittest.TestCase):
    def sh(self, command, cwd=None, code=0, **env):
        done = subprocess.run(command, cwd=cwd or WORK.name, shell=isinstance(command, str), capture_output=True,
                              text=True, timeout=900, env={**os.environ, **env})
        self.assertEqual(done.returncode, code, f"{command}\n{done.stdout}\n{done.stderr}")
        return done.stdout

    def expect_licences(self, package):
        """The package has the licence of every foreign part that its bill of materials lists."""
        with open(f"{package}.spdx.json") as f:
            bill = json.load(f)
        names = {p["SPDXID"]: p["name"] for p in bill["packages"]}
        held = {names[r["relatedSpdxElement"]] for r in bill["relationships"] if r["relationshipType"] == "STATIC_LINK"}
        licences = {os.path.basename(f["fileName"]) for f in bill["files"] if "/third-party/" in f["fileName"]}
        self.assertEqual({f"{n}.txt" for n in held if not n.startswith("sinew::")} - licences, set(), package)

    def program(self, name):
        """How a program of the packages is started here."""
        return ARGS.emulator.split() + [f"{unpacked()}/bin/{name}"]
