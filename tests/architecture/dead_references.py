#!/usr/bin/env python3
"""Looks for dead links and paths in the documentation.

usage: dead_references.py ROOT     prints file:line: what is not there; exit 1 when anything is not
"""
import pathlib
import re
import sys

LINK = re.compile(r"\]\(([^)#\s]+)")
PATH = re.compile(r"`((?:[a-z0-9_]+/)+[A-Za-z0-9_.-]+\.(?:[ch]pp|md|py|sh|toml|txt|xml))`")


def dead_in(root, page):
    """(line, reference) of each that leads nowhere. Capital letters stand for something: robots/NAME/robot.cpp."""
    for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), 1):
        for link in LINK.findall(line):
            if not re.match(r"[a-z]+:", link) and not (page.parent / link).exists():
                yield number, link
        for path in PATH.findall(line):
            top = path.split("/")[0]
            if (root / top).is_dir() and not re.search(r"[A-Z]{3}", path) and not (root / path).exists():
                yield number, path


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    pages = sorted([*root.glob("*.md"), *(root / "docs").rglob("*.md"), *root.glob("[a-z]*/README.md")])
    dead = [(page.relative_to(root), *where) for page in pages for where in dead_in(root, page)]
    for page, number, reference in dead:
        print(f"{page}:{number}: {reference}: is not there")
    print(f"{len(pages)} pages, {len(dead)} dead references")
    return 1 if dead or not pages else 0


if __name__ == "__main__":
    sys.exit(main())
