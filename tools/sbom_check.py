#!/usr/bin/env python3
"""Checks that a bill of materials is valid SPDX 2.3 JSON, in the parts that ours use, and true of its package.

    tools/sbom_check.py FILE.spdx.json [PACKAGE]

Prints each problem. With PACKAGE hashes every file in it; the document must list each file with this hash.
Exit: 0 no problem; 1 some; 2 wrong call.
Source: SPDX 2.3, https://spdx.github.io/spdx-spec/v2.3/ (sections in brackets) and its schemas/spdx-schema.json
"""
import hashlib
import json
import os
import re
import sys
import tempfile

RELATIONS = {"DESCRIBES", "CONTAINS", "DYNAMIC_LINK", "STATIC_LINK", "DEPENDS_ON"}  # [11.1], those that we use
PURPOSES = {"APPLICATION", "FRAMEWORK", "LIBRARY", "CONTAINER", "OPERATING-SYSTEM", "DEVICE", "FIRMWARE", "SOURCE",
            "ARCHIVE", "FILE", "INSTALL", "OTHER"}  # [7.24]
LENGTHS = {"SHA1": 40, "SHA256": 64}
ID = re.compile(r"SPDXRef-[A-Za-z0-9.-]+$")  # [3.2]
LICENCE = re.compile(r"(NOASSERTION|NONE|\(?[A-Za-z0-9.+-]+\)?( (AND|OR|WITH) \(?[A-Za-z0-9.+-]+\)?)*)$")  # [Annex D]
ORIGIN = re.compile(r"(NOASSERTION|(Organization|Person): .+)$")  # [7.5]


class Check:
    def __init__(self, document):
        self.document, self.problems, self.ids = document, [], {}

    def say(self, where, what):
        self.problems.append(f"{where}: {what}")

    def field(self, where, entry, name, form=None, kind=str):
        """The value when it is there and has that form, else None."""
        value = entry.get(name)
        if not isinstance(value, kind) or (kind is str and not value):
            self.say(where, f"{name} is missing or of a wrong type")
            return None
        if form and not re.match(form, value):
            self.say(where, f"{name}: '{value}' has not the form that it must have")
            return None
        return value

    def element(self, entry, where):
        identity = self.field(where, entry, "SPDXID", ID)
        if identity in self.ids:
            self.say(where, f"SPDXID {identity} is there twice")
        elif identity:
            self.ids[identity] = entry
        return identity or where

    def checksums(self, where, entry, needed):
        found = {}
        for checksum in entry.get("checksums", []):
            name, value = checksum.get("algorithm"), checksum.get("checksumValue", "")
            if name not in LENGTHS or not re.match(r"[0-9a-f]{%d}$" % LENGTHS[name], value):
                self.say(where, f"checksum {name} '{value}' is none")
            found[name] = value
        for name in needed:
            if name not in found:
                self.say(where, f"no {name}")
        return found

    def licences(self, where, entry, names):
        for name in names:
            value = entry.get(name)
            for one in value if isinstance(value, list) else [value]:
                if not isinstance(one, str) or not LICENCE.match(one):
                    self.say(where, f"{name}: '{one}' is no licence expression")

    def head(self):
        d, where = self.document, "document"
        self.field(where, d, "spdxVersion", r"SPDX-2\.3$")
        self.field(where, d, "dataLicense", r"CC0-1\.0$")
        self.field(where, d, "name")
        self.field(where, d, "documentNamespace", r"[a-z]+://[^#\s]+$")  # [6.5]: no fragment
        if self.element(d, where) != "SPDXRef-DOCUMENT":
            self.say(where, "SPDXID must be SPDXRef-DOCUMENT")
        creation = self.field(where, d, "creationInfo", kind=dict) or {}
        self.field(where, creation, "created", r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ$")
        creators = self.field(where, creation, "creators", kind=list) or []
        if not all(re.match(r"(Tool|Person|Organization): .+", c) for c in creators):
            self.say(where, "creators: Tool, Person or Organization")

    def packages(self):
        for entry in self.field("document", self.document, "packages", kind=list) or []:
            where = self.element(entry, entry.get("name", "package"))
            self.field(where, entry, "name")
            self.field(where, entry, "versionInfo")
            self.field(where, entry, "downloadLocation")
            self.field(where, entry, "supplier", ORIGIN)
            self.licences(where, entry, ["licenseConcluded", "licenseDeclared"])
            if entry.get("primaryPackagePurpose") not in PURPOSES:
                self.say(where, "primaryPackagePurpose is none of SPDX's")
            if not isinstance(entry.get("filesAnalyzed"), bool):
                self.say(where, "filesAnalyzed is missing")
            for key in ("packageVerificationCode", "licenseInfoFromFiles"):  # [7.9, 7.14]
                if (key in entry) != bool(entry.get("filesAnalyzed")):
                    self.say(where, f"{key} goes with filesAnalyzed")
            for ref in entry.get("externalRefs", []):
                if not re.match(r"pkg:[a-z]+/.+@.+", ref.get("referenceLocator", "")):
                    self.say(where, "externalRefs: a purl was expected")

    def files(self):
        sha1s = []
        for entry in self.field("document", self.document, "files", kind=list) or []:
            where = self.element(entry, entry.get("fileName", "file"))
            self.field(where, entry, "fileName", r"\./.+")  # [8.1]
            sha1s.append(self.checksums(where, entry, ["SHA1", "SHA256"]).get("SHA1", ""))
            self.licences(where, entry, ["licenseConcluded", "licenseInfoInFiles"])
            self.field(where, entry, "copyrightText")
        code = hashlib.sha1("".join(sorted(sha1s)).encode()).hexdigest()  # [7.9]
        for entry in self.document.get("packages", []):
            told = entry.get("packageVerificationCode", {}).get("packageVerificationCodeValue")
            if told and told != code:
                self.say(entry["SPDXID"], f"packageVerificationCode is {told}, the files give {code}")

    def relations(self):
        described, linked = [], set()
        for entry in self.field("document", self.document, "relationships", kind=list) or []:
            who, how, whom = (entry.get(k) for k in ("spdxElementId", "relationshipType", "relatedSpdxElement"))
            if how not in RELATIONS:
                self.say("relationships", f"{how}: not one of {', '.join(sorted(RELATIONS))}")
            for one in (who, whom):
                if one not in self.ids:
                    self.say("relationships", f"{one} is not in the document")
            if how == "DESCRIBES":
                described.append(whom)
            linked.add(whom)
        if len(described) != 1:
            self.say("relationships", f"one DESCRIBES was expected, there are {len(described)}")
        for one in self.ids:
            if one not in linked and one != "SPDXRef-DOCUMENT":
                self.say(one, "nothing is related to it")

    def truth(self, package):
        from sbom import unpack
        with open(package, "rb") as f:
            digest = hashlib.sha256(f.read()).hexdigest()
        main = [p for p in self.document["packages"] if p.get("filesAnalyzed")]
        if len(main) != 1 or self.checksums("package", main[0], ["SHA256"]).get("SHA256") != digest:
            self.say(os.path.basename(package), f"its SHA256 is {digest}, which is not what the document says")
        listed = {f["fileName"]: {c["algorithm"]: c["checksumValue"] for c in f["checksums"]} for f in self.document["files"]}
        with tempfile.TemporaryDirectory() as folder:
            for path in unpack(package, folder):
                with open(os.path.join(folder, path), "rb") as f:
                    data = f.read()
                told = listed.pop(f"./{path}", None)
                if told is None:
                    self.say(path, "is in the package, but not in the document")
                elif told != {"SHA1": hashlib.sha1(data).hexdigest(), "SHA256": hashlib.sha256(data).hexdigest()}:
                    self.say(path, "has other checksums in the package")
        for path in listed:
            self.say(path, "is in the document, but not in the package")


def problems_of(document, package=None):
    check = Check(document)
    check.head()
    check.packages()
    check.files()
    check.relations()
    if package:
        check.truth(package)
    return check.problems


def main():
    if len(sys.argv) not in (2, 3) or sys.argv[1].startswith("-"):
        print(__doc__, file=sys.stderr)
        sys.exit(2)
    try:
        with open(sys.argv[1], encoding="utf-8") as f:
            document = json.load(f)
        if not isinstance(document, dict):
            raise ValueError("it is no object")
    except OSError as error:
        sys.exit(f"sbom_check: {sys.argv[1]}: {error.strerror}")
    except ValueError as error:  # of JSON, too
        sys.exit(f"sbom_check: {sys.argv[1]}: no SPDX document: {error}")
    try:
        problems = problems_of(document, *sys.argv[2:])
    except OSError as error:
        sys.exit(f"sbom_check: {sys.argv[2]}: {error.strerror}")
    for problem in problems:
        print(problem)
    sys.exit(1 if problems else 0)


if __name__ == "__main__":
    main()
