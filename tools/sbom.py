#!/usr/bin/env python3
"""The bill of materials of a package, as SPDX 2.3 JSON: each file, our rooms in it, and external code that it links.

    tools/sbom.py PACKAGE... --build FOLDER [--sysroot DIR] [--static FILE...] [--into FOLDER]

writes PACKAGE.spdx.json beside each, or into that folder. PACKAGE is a .deb, .tar.gz or .zip. The programs themselves
name the libraries that they load (NEEDED; DLL names), the build's ninja names the rooms and headers compiled in, and
dpkg's database (the machine's, or the sysroot's) their Debian packages. A licence is named only if Debian's copyright
file names one for everything but Debian's own work; else it is NOASSERTION, with the names in that file as a comment.
--static names libraries of the compiler that are linked in.
Exit: 0 done; 1 something cannot be found (says what); 2 wrong call.
Source: SPDX 2.3, https://spdx.github.io/spdx-spec/v2.3/
"""
import argparse
import datetime
import hashlib
import json
import os
import re
import sys
import tarfile
import tempfile
import zipfile

from debian_packages import HEADER_LIBRARIES, NONE, Debian, run


def unpack(package, folder):
    if package.endswith(".deb"):
        run("dpkg-deb", "-x", package, folder)
    elif package.endswith(".tar.gz"):
        with tarfile.open(package) as tar:
            # Debian 12's Python (3.11.2) has no filters yet, and later versions want one.
            tar.extractall(folder, **({"filter": "data"} if hasattr(tarfile, "data_filter") else {}))
    elif package.endswith(".zip"):
        with zipfile.ZipFile(package) as archive:
            archive.extractall(folder)
    else:
        sys.exit(f"sbom: {package}: neither .deb nor .tar.gz nor .zip")
    found = []
    for where, _, names in os.walk(folder):
        found += [os.path.relpath(os.path.join(where, n), folder) for n in names]
    return sorted(f for f in found if not os.path.islink(os.path.join(folder, f)))


def is_program(path):
    with open(path, "rb") as f:
        head = f.read(4)
    return "elf" if head == b"\x7fELF" else "pe" if head[:2] == b"MZ" else None


def loaded(path):
    """(kind, names) of the libraries that a program asks its system for."""
    kind = is_program(path)
    if kind == "elf":
        return kind, re.findall(r"\(NEEDED\).*\[(.+)\]", run("readelf", "-dW", path))
    if kind == "pe":
        return kind, re.findall(r"DLL Name: (\S+)", run("objdump", "-p", path))
    return None, []


class Build:
    """What ninja knows of our programs and libraries."""

    def __init__(self, folder, debian):
        self.folder, self.owners = folder, debian.headers()
        self.outputs = {}
        for line in run("ninja", "-C", folder, "-t", "targets", "all").splitlines():
            output = line.split(": ")[0]
            if ".dir/" not in output and output.endswith((".a", ".so", ".exe")) or output.startswith("bin/"):
                self.outputs.setdefault(os.path.basename(output), output)
        self.for_windows = any(o.endswith(".exe") for o in self.outputs)
        self.objects, current = {}, None
        for line in run("ninja", "-C", folder, "-t", "deps").splitlines():
            if line and not line.startswith(" "):
                current = self.objects.setdefault(line.split(": ")[0], [])
            elif line.strip():
                current.append(line.strip())

    def parts(self, name):
        """(rooms, Debian packages of header libraries) of an output."""
        if name not in self.outputs:
            return set(), set()
        inputs = run("ninja", "-C", self.folder, "-t", "inputs", self.outputs[name]).splitlines()
        rooms = {m.group(1) for i in inputs if (m := re.search(r"(?:^|/)libsinew_(\w+)\.a$", i))}
        return rooms, {p for i in inputs for h in self.objects.get(i, ()) if (p := self.owner(h))}

    def owner(self, header):
        # A program for Windows uses only the headers of this machine's libraries (apps/CMakeLists.txt), through a link
        # in the build or, if that is shorter, by their own paths.
        if self.for_windows:
            header = os.path.realpath(os.path.join(self.folder, header))
        at = header.find("/usr/include/")  # also below a sysroot
        owner = self.owners.get(header[at:]) if at >= 0 else None
        return owner if self.for_windows or owner in HEADER_LIBRARIES else None


class Document:
    def __init__(self, package, files, folder):
        self.packages, self.files, self.relations, self.ids = [], [], [], {}
        name, version, _ = name_of(package)
        with open(package, "rb") as f:
            digest = hashlib.sha256(f.read()).hexdigest()
        sha1s = []
        for path in files:
            with open(os.path.join(folder, path), "rb") as f:
                data = f.read()
            sha1s.append(hashlib.sha1(data).hexdigest())
            self.files.append({
                "SPDXID": self.new_id("File", path), "fileName": f"./{path}",
                "checksums": [{"algorithm": "SHA1", "checksumValue": sha1s[-1]},
                              {"algorithm": "SHA256", "checksumValue": hashlib.sha256(data).hexdigest()}],
                "licenseConcluded": NONE, "licenseInfoInFiles": [NONE], "copyrightText": NONE})
        # Source: SPDX 2.3, 7.9: the SHA-1 of all files' SHA-1, sorted.
        code = hashlib.sha1("".join(sorted(sha1s)).encode()).hexdigest()
        self.main = self.add(name, version, "BSD-3-Clause", "from LICENSE", ours=True, purpose="INSTALL")
        self.packages[0].update({
            "packageFileName": os.path.basename(package), "filesAnalyzed": True,
            "packageVerificationCode": {"packageVerificationCodeValue": code},
            "checksums": [{"algorithm": "SHA256", "checksumValue": digest}], "licenseInfoFromFiles": [NONE]})
        self.relate("SPDXRef-DOCUMENT", "DESCRIBES", self.main)
        for f in self.files:
            self.relate(self.main, "CONTAINS", f["SPDXID"])
        stamp = int(os.environ.get("SOURCE_DATE_EPOCH", os.path.getmtime(package)))
        self.head = {
            "spdxVersion": "SPDX-2.3", "dataLicense": "CC0-1.0", "SPDXID": "SPDXRef-DOCUMENT",
            "name": os.path.basename(package),
            "documentNamespace": f"https://example.org/sinew/spdx/{os.path.basename(package)}-{digest}",
            "creationInfo": {"created": datetime.datetime.fromtimestamp(stamp, datetime.timezone.utc)
                             .strftime("%Y-%m-%dT%H:%M:%SZ"), "creators": ["Tool: sinew-tools-sbom.py"]}}

    def new_id(self, kind, name):
        base = f"SPDXRef-{kind}-" + re.sub(r"[^A-Za-z0-9.-]+", "-", name)
        count = self.ids[base] = self.ids.get(base, 0) + 1
        return base if count == 1 else f"{base}-{count}"

    def add(self, name, version, licence, comment, ours=False, purpose="LIBRARY", purl=None):
        entry = {"SPDXID": self.new_id("Package", name), "name": name, "versionInfo": version,
                 "downloadLocation": NONE, "filesAnalyzed": False, "licenseConcluded": NONE, "licenseDeclared": licence,
                 "licenseComments": comment, "copyrightText": NONE, "primaryPackagePurpose": purpose,
                 "supplier": "Organization: The Sinew authors" if ours else "Organization: Debian"}
        if purl:
            entry["externalRefs"] = [{"referenceCategory": "PACKAGE-MANAGER", "referenceType": "purl",
                                      "referenceLocator": purl}]
        self.packages.append(entry)
        return entry["SPDXID"]

    def relate(self, who, how, whom):
        entry = {"spdxElementId": who, "relationshipType": how, "relatedSpdxElement": whom}
        if entry not in self.relations:
            self.relations.append(entry)

    def text(self):
        return json.dumps({**self.head, "packages": self.packages, "files": self.files,
                           "relationships": self.relations}, indent=1) + "\n"


def name_of(package):
    """(name, version, Debian's name of the machine or None)"""
    base = os.path.basename(package)
    if base.endswith(".deb"):
        return tuple(run("dpkg-deb", "-W", "--showformat=${Package} ${Version} ${Architecture}", package).split())
    match = re.match(r"([a-z-]+)-([0-9][0-9.]*)-([a-z0-9-]+)\.(tar\.gz|zip)$", base)
    if not match:
        sys.exit(f"sbom: {base}: a name of the form NAME-VERSION-MACHINE.tar.gz or .zip was expected")
    return match.groups()[:3]


def make(package, debian, build, statics):
    with tempfile.TemporaryDirectory() as folder:
        files = unpack(package, folder)
        document = Document(package, files, folder)
        _, version, machine = name_of(package)
        known = {}

        def of_debian(other):
            if other not in known:
                found, bare = debian.version(other), other.split(":")[0]
                known[other] = document.add(bare, found, *debian.licence(other),
                                            purl=f"pkg:deb/debian/{bare}@{found}?arch={machine}&distro=bookworm")
            return known[other]

        def of_ours(room):
            if room not in known:
                known[room] = document.add(f"sinew::{room}", version.split("-")[0], "BSD-3-Clause", "from LICENSE", ours=True)
                document.relate(document.main, "CONTAINS", known[room])
            return known[room]

        for entry, path in zip(document.files, files):
            who, base = entry["SPDXID"], os.path.basename(path)
            kind, names = loaded(os.path.join(folder, path))
            if kind == "pe":
                entry["comment"] = "of the system: " + ", ".join(sorted(names))
                for static in statics:
                    owner = debian.owner(os.path.realpath(static)) or sys.exit(f"sbom: {static}: of no package")
                    document.relate(who, "STATIC_LINK", of_debian(owner))
            for soname in sorted(names if kind == "elf" else ()):
                document.relate(who, "DYNAMIC_LINK", of_debian(debian.library(soname)))
            if kind or base.endswith(".a"):
                rooms, headers = build.parts(base)
                if not rooms and not headers and base not in build.outputs:
                    sys.exit(f"sbom: {path}: the build in {build.folder} makes no such file")
                if base.endswith(".a"):
                    rooms = {base[len("libsinew_"):-len(".a")]}
                for room in sorted(rooms):
                    document.relate(who, "STATIC_LINK" if kind else "CONTAINS", of_ours(room))
                for header_library in sorted(headers):
                    document.relate(who, "STATIC_LINK", of_debian(header_library))
        if package.endswith(".deb"):  # libraries that a program with our libraries has to link, too
            for other in re.findall(r"[a-z0-9.+-]+-dev\b", run("dpkg-deb", "-f", package, "Depends")):
                document.relate(document.main, "DEPENDS_ON", of_debian(other))
    return document.text()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("package", nargs="+")
    parser.add_argument("--build", required=True)
    parser.add_argument("--sysroot", default="")
    parser.add_argument("--static", nargs="*", default=[])
    parser.add_argument("--into")
    args = parser.parse_args()
    debian = Debian(args.sysroot)
    build = Build(args.build, debian)
    for package in args.package:
        text = make(package, debian, build, args.static)
        folder = args.into or os.path.dirname(package)
        with open(os.path.join(folder, f"{os.path.basename(package)}.spdx.json"), "w") as f:
            f.write(text)


if __name__ == "__main__":
    main()
