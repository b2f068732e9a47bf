"""Which Debian package has a file, its version and its licence, by dpkg's database: the machine's or a sysroot's."""
import os
import re
import subprocess
import sys

# External header libraries: they are in our programs, although no program names them.
HEADER_LIBRARIES = {"libtomlplusplus-dev", "nlohmann-json3-dev", "libcli11-dev", "libeigen3-dev"}
# Debian's short names, and SPDX's: https://spdx.org/licenses/
SPDX_NAMES = {"expat": "MIT", "mit": "MIT", "zlib": "Zlib", "bsd-2-clause": "BSD-2-Clause", "bsd-3-clause": "BSD-3-Clause",
              "apache-2.0": "Apache-2.0", "bsl-1.0": "BSL-1.0", "gpl-2+": "GPL-2.0-or-later", "gpl-2": "GPL-2.0-only",
              "gpl-3+": "GPL-3.0-or-later", "lgpl-2.1+": "LGPL-2.1-or-later", "lgpl-2+": "LGPL-2.0-or-later",
              "mpl-2.0": "MPL-2.0", "isc": "ISC"}
NONE = "NOASSERTION"


def run(*command):
    done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, "LC_ALL": "C"})
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}: {done.stderr.strip()}")
    return done.stdout


class Debian:
    """Which package has a file, by dpkg's database."""

    def __init__(self, sysroot):
        self.root = os.path.realpath(sysroot) if sysroot else ""
        self.admindir = f"{self.root}/var/lib/dpkg"
        if not os.path.isfile(f"{self.admindir}/status"):
            sys.exit(f"no package database in {self.root}; toolchains/sysroot.sh makes a sysroot with one")
        self.owners = {}

    def owner(self, path):
        """The package of a file; the path is without the sysroot."""
        if path not in self.owners:
            real = os.path.realpath(self.root + path)[len(self.root):]
            names = []
            for p in (path, real):  # with and without the merger of /lib and /usr/lib
                names += [p, p[len("/usr"):] if p.startswith("/usr/lib") else "/usr" + p]
            done = subprocess.run(["dpkg-query", f"--admindir={self.admindir}", "-S", *names], capture_output=True,
                                  text=True)
            lines = [line for line in done.stdout.splitlines() if not line.startswith("diversion")]
            self.owners[path] = lines[0].split(": ")[0].split(",")[0] if lines else None
        return self.owners[path]

    def headers(self):
        """{path: package} for the installed libraries that are, or can be used as, headers only."""
        found = {}
        for package in (*HEADER_LIBRARIES, "libfmt-dev"):
            done = subprocess.run(["dpkg-query", f"--admindir={self.admindir}", "-L", package], capture_output=True, text=True)
            found.update({path: package for path in done.stdout.splitlines() if path.startswith("/usr/include/")})
        return found

    def library(self, soname):
        for folder in sorted(self.library_folders()):
            if os.path.exists(f"{self.root}{folder}/{soname}"):
                owner = self.owner(f"{folder}/{soname}")
                if owner:
                    return owner
        sys.exit(f"{soname}: no Debian package has it{' in ' + self.root if self.root else ''}")

    def library_folders(self):
        parent = "/usr/lib"
        yield parent
        for name in os.listdir(self.root + parent):
            if "-linux-gnu" in name:
                yield f"{parent}/{name}"

    def version(self, package):
        return run("dpkg-query", f"--admindir={self.admindir}", "-W", "-f=${Version}\\n", package).split()[0]

    def licence(self, package):
        """(SPDX expression, comment)."""
        for root in (self.root, ""):
            path = f"{root}/usr/share/doc/{package.split(':')[0]}/copyright"
            if os.path.isfile(path):
                with open(path, errors="replace") as f:
                    return licence_of(f.read())
        return NONE, "no copyright file of Debian's was at hand"


def licence_of(copyright_file):
    """The licence in a machine-readable copyright file, without Debian's own work.
    Source: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/"""
    if "copyright-format/1.0" not in copyright_file.split("\n\n")[0]:
        return NONE, "Debian's copyright file is prose"
    names = set()
    for stanza in copyright_file.split("\n\n"):
        files = re.search(r"^Files:\s*(.*(?:\n\s+.*)*)", stanza, re.M)
        licence = re.search(r"^License:\s*(.*)$", stanza, re.M)
        if files and licence and not all(f.startswith("debian/") for f in files.group(1).split()):
            names.add(licence.group(1).strip())
    if len(names) == 1 and next(iter(names)).lower() in SPDX_NAMES:
        return SPDX_NAMES[next(iter(names)).lower()], "from Debian's copyright file"
    return NONE, "Debian's copyright file names: " + "; ".join(sorted(names))
