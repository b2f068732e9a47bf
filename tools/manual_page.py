#!/usr/bin/env python3
"""A program's manual page, made only from its --help, so that the two never differ.

    tools/manual_page.py --name sinew --what 'runs robots' --version 0.1.0 --into sinew.1.gz -- build/release/bin/sinew

The words behind -- start the program (an emulator may be the first). Each command of a program gets a part, also
commands of commands. Reads the help texts of CLI11 and the plain ones of our small programs ("usage: ...").
FILE is compressed when its name ends in .gz; the same text gives the same bytes.
Exit: 0 written; 1 a help text is missing or not readable (says which); 2 wrong call.
"""
import argparse
import gzip
import pathlib
import re
import subprocess
import sys

COLUMN = 30  # column in which CLI11 begins the meaning of a row


class Wrong(Exception):
    """An error that one line of text explains."""


def help_of(words):
    try:
        done = subprocess.run([*words, "--help"], capture_output=True, text=True, timeout=120)
    except (OSError, subprocess.TimeoutExpired) as error:
        raise Wrong(f"{' '.join(words)}: {error}") from error
    if done.returncode != 0 or not done.stdout.strip():
        raise Wrong(f"{' '.join(words)} --help: exit code {done.returncode}, and it says: {done.stdout}{done.stderr}")
    return done.stdout


class Help:
    """One help text, taken apart: usage, said (lines of prose), parts ({title: [(name, meaning)]})."""

    def __init__(self, text):
        self.usage, self.said, self.parts = "", [], {}
        rows = None
        lines = text.splitlines()
        for line, after in zip(lines, [*lines[1:], ""]):
            if found := re.match(r"usage: (.*)$", line, re.I):
                self.usage = found[1]
            elif found := re.fullmatch(r"(Positionals|Options|Subcommands):", line):
                rows = self.parts.setdefault(found[1], [])
            elif line.startswith("  "):
                if rows is None:  # a small program has no titles
                    rows = self.parts.setdefault("Options", [])
                self.row(rows, line, after)
            elif line.strip():
                self.said.append(line.strip())
        if not self.usage:
            raise Wrong(f"no line 'usage:' in: {text}")

    @staticmethod
    def row(rows, line, after):
        if line.startswith(" " * COLUMN) and rows:  # the name took a line of its own
            name, meaning = rows[-1]
            rows[-1] = (name, f"{meaning} {line.strip()}".strip())
            return
        # Two spaces separate name and meaning; only one if the name ends before the column and no meaning follows.
        name, _, meaning = line.strip().partition("  ")
        if not meaning and line[COLUMN - 1:COLUMN] == " " and not after.startswith(" " * COLUMN):
            name, meaning = line[2:COLUMN].strip(), line[COLUMN:]
        rows.append((name, meaning.strip()))


def roff(text):
    """Text in which troff takes its special characters for ordinary ones."""
    text = text.replace("\\", "\\e").replace("-", "\\-").replace("'", "\\(aq").replace("^", "\\(ha").replace("~", "\\(ti")
    return "\\&" + text if text.startswith(".") else text


def rows_of(rows):
    lines = []
    for name, meaning in rows:
        lines += [".TP", f".B {roff(name)}", roff(meaning) if meaning else "\\&"]
    return lines


def commands(words, path, text):
    """(name of a command, its Help), subcommands behind their command; path: the words by which people call it."""
    for name, _ in text.parts.get("Subcommands", []):
        inner = Help(help_of([*words, name]))
        yield f"{path} {name}", inner
        yield from commands([*words, name], f"{path} {name}", inner)


def page(name, what, version, words):
    text = Help(help_of(words))
    lines = [f'.TH {name.upper()} 1 "" "Sinew {version}" "Sinew"', ".SH NAME", f"{name} \\- {roff(what)}", ".SH SYNOPSIS",
             f".B {roff(text.usage)}", ".SH DESCRIPTION"]
    for line in text.said:
        lines += [roff(line), ".br"]
    lines += rows_of(text.parts.get("Positionals", []))
    if text.parts.get("Options"):
        lines += [".SH OPTIONS", *rows_of(text.parts["Options"])]
    if text.parts.get("Subcommands"):
        lines += [".SH COMMANDS"]
        for path, inner in commands(words, name, text):
            lines += [f".SS {roff(path.split(' ', 1)[1])}", f".B {roff(inner.usage)}", ".PP"]
            for line in inner.said:
                if line not in text.said:  # all commands have the same exit codes
                    lines += [roff(line), ".br"]
            for part in ("Positionals", "Options"):
                lines += rows_of([row for row in inner.parts.get(part, []) if not row[0].startswith("-h,")])
    return "\n".join(lines) + "\n"


def main(words):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--name", required=True)
    parser.add_argument("--what", required=True)
    parser.add_argument("--version", required=True)
    parser.add_argument("--into", required=True, type=pathlib.Path, metavar="FILE")
    parser.add_argument("program", nargs="+")
    args = parser.parse_args(words)
    try:
        text = page(args.name, args.what, args.version, args.program).encode()
    except Wrong as error:
        print(f"manual_page: {error}", file=sys.stderr)
        return 1
    args.into.parent.mkdir(parents=True, exist_ok=True)
    args.into.write_bytes(gzip.compress(text, 9, mtime=0) if args.into.suffix == ".gz" else text)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
