#!/usr/bin/env python3
"""The sizes of the programs on each machine, compared with a budget in the repository.

    tools/sizes.py                                         amd64, arm64, armhf, mipsel: all four programs
    tools/sizes.py mipsel --only sinew-control-static      one, as built in build/mipsel/bin
    tools/sizes.py mipsel=DIR                              as built in DIR
    tools/sizes.py mipsel --only P --memory build/boards/mipsel/out/memory      also its memory on a board
    tools/sizes.py ... --accept 'why it is as large now'   writes sizes that do not fit into the budget, with that note

own text: code and constants from our own objects, by the linker's map (only of programs that write one); text: all code
and constants; data: variables stored in the file; bss: variables that begin as zero. Memory: the most that was resident
and locked in a run. The budget, tests/boards/size_budget.tsv, is in bytes. A size fails if it is 5 % and a page (memory
comes in pages) larger; a size that is 10 % smaller prints a note, so that the budget can follow. A number above its
column `at_most` cannot be accepted.
Exit: 0 all within; 1 not, each with advice; 2 wrong call.
"""
import argparse
import pathlib
import re
import struct
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
FOLDERS = {"amd64": "release", "arm64": "arm64", "armhf": "armhf", "mipsel": "mipsel"}
PROGRAMS = ["sinew-control-static", "sinew-control", "sinew-fly", "sinew"]
COLUMNS = ["own text", "text", "data", "bss", "resident", "locked"]
MOST_MORE, MUCH_LESS, PAGE = 0.05, 0.10, 4096
FIRST_LINE = "target\tprogram\twhat\tbytes\tat_most\tnote"
WRITE, ALLOC, NO_BITS = 1, 2, 8  # ELF: SHF_WRITE, SHF_ALLOC, SHT_NOBITS


class Wrong(Exception):
    """An error that one line of text explains."""


def sections(path):
    """(name, size, kind) of the sections that an ELF file loads into memory; kind: text, data, bss, as in size(1)."""
    file = path.read_bytes()
    if file[:4] != b"\x7fELF" or len(file) < 64 or file[5] != 1:
        raise Wrong(f"{path}: no little-endian ELF file")
    wide = file[4] == 2
    at, = struct.unpack_from("<Q" if wide else "<I", file, 40 if wide else 32)
    entry, count, names = struct.unpack_from("<HHH", file, 58 if wide else 46)
    table = []
    for i in range(count):
        if wide:
            name, kind, flags, _, offset, size = struct.unpack_from("<IIQQQQ", file, at + i * entry)
        else:
            name, kind, flags, _, offset, size = struct.unpack_from("<IIIIII", file, at + i * entry)
        table.append((name, kind, flags, offset, size))
    if not table:
        raise Wrong(f"{path}: an ELF file without sections")
    text = table[names][3]
    found = []
    for name, kind, flags, _, size in table:
        if flags & ALLOC:
            label = file[text + name:file.index(b"\0", text + name)].decode()
            found.append((label, size, "bss" if kind == NO_BITS else "data" if flags & WRITE else "text"))
    return found


def own_text(map_path, text_sections):
    """Bytes of our objects in these sections of the program, by the map that GNU ld has written."""
    total, section, began = 0, None, False
    entry = re.compile(r"^(?: \S+)?\s+0x[0-9a-f]+\s+0x([0-9a-f]+) (\S.*)$")
    with open(map_path, encoding="utf-8", errors="replace") as lines:
        for line in lines:
            began = began or line.startswith("Linker script and memory map")
            if not began:
                continue
            if line[0] == ".":
                section = line.split()[0]
            elif line[0] == "/":
                section = None
            elif section in text_sections and (found := entry.match(line)):
                # Archives and objects of the build, by the names that cmake gives them.
                if re.search(r"(^|/)libsinew_\w+\.a\(|CMakeFiles/.*\.dir/", found[2]):
                    total += int(found[1], 16)
    if total == 0:
        raise Wrong(f"{map_path}: no bytes of our objects in it; is it the map of that program?")
    return total


def measure(program):
    """The sizes of one program, by column."""
    found = sections(program)
    sizes = {kind: sum(size for _, size, of in found if of == kind) for kind in ("text", "data", "bss")}
    link_map = program.with_name(program.name + ".map")
    if link_map.exists():
        if link_map.stat().st_mtime < program.stat().st_mtime - 60:
            raise Wrong(f"{link_map}: older than the program; build it anew")
        sizes["own text"] = own_text(link_map, {name for name, _, of in found if of == "text"})
    return sizes


def read_memory(path):
    """Resident and locked bytes from the file that tests/boards/init writes."""
    words = dict(re.findall(r"^(\w+)=(\d+)$", path.read_text(encoding="utf-8"), re.M))
    if "rss_kb" not in words or "locked_kb" not in words:
        raise Wrong(f"{path}: no rss_kb and locked_kb in it")
    memory = {"resident": int(words["rss_kb"]) * 1024, "locked": int(words["locked_kb"]) * 1024}
    if not memory["locked"]:
        raise Wrong(f"{path}: nothing was locked, so what it was measured on says nothing")
    return memory


def read_budget(path):
    """{(target, program, what): (bytes, at_most or None, note)}"""
    lines = path.read_text(encoding="utf-8").splitlines()
    if not lines or lines[0] != FIRST_LINE:
        raise Wrong(f"{path}:1: the first line must be: {FIRST_LINE}")
    budget = {}
    for number, line in enumerate(lines[1:], 2):
        words = line.split("\t")
        if len(words) != 6 or words[2] not in COLUMNS or not words[3].isdigit() or not re.fullmatch(r"\d*", words[4]):
            raise Wrong(f"{path}:{number}: six columns, the third one of {', '.join(COLUMNS)}, then two numbers of bytes "
                        "(the second may be empty), and a note")
        if not words[5].strip():
            raise Wrong(f"{path}:{number}: without a note")
        key = tuple(words[:3])
        if key in budget:
            raise Wrong(f"{path}:{number}: {' '.join(key)} for the second time")
        budget[key] = (int(words[3]), int(words[4]) if words[4] else None, words[5])
    return budget


def write_budget(path, budget):
    order = {name: i for i, name in enumerate([*FOLDERS, *PROGRAMS, *COLUMNS])}
    rows = sorted(budget.items(), key=lambda row: [(order.get(word, len(order)), word) for word in row[0]])
    lines = ["\t".join([*key, str(size), "" if most is None else str(most), note]) for key, (size, most, note) in rows]
    path.write_text("\n".join([FIRST_LINE, *lines]) + "\n", encoding="utf-8")


def judge(key, size, budget):
    """(problem or None, remark or None) of one number."""
    name = f"{key[0]}: {key[1]}: {key[2]}"
    known = budget.get(key)
    if known is None:
        return (f"{name}: {size} bytes, and no row in the budget. Measured rightly? Then: --accept 'what it is'", None)
    allowed, most, note = known
    if most is not None and size > most:
        return (f"{name}: {size} bytes, and it must never be more than {most} ({note}). Make it smaller", None)
    share = (size - allowed) / allowed if allowed else (1 if size else 0)
    if abs(size - allowed) <= PAGE:
        return (None, None)
    if share > MOST_MORE:
        return (f"{name}: {size} bytes, {share:+.1%} beyond the budget of {allowed} ({note}). Make it smaller, or say "
                "what it is good for: --accept 'why'", None)
    if share < -MUCH_LESS:
        return (None, f"{name}: {size} bytes, {share:+.1%}: the budget of {allowed} may follow: --accept 'why'")
    return (None, None)


def accept(measured, budget, why):
    """The budget, with new rows and this note for sizes that do not fit; the others keep their rows."""
    for key, size in measured.items():
        problem, remark = judge(key, size, budget)
        most = budget[key][1] if key in budget else None
        if most is not None and size > most:
            continue
        if problem or remark:
            budget[key] = (size, most, why)
    return budget


def table(measured):
    def cell(row, what):
        size = measured.get((*row, what))
        return "-" if size is None else f"{size / 1000:.0f}"

    rows = list(dict.fromkeys(key[:2] for key in measured))
    lines = [["kB", "", *COLUMNS]] + [[*row, *(cell(row, what) for what in COLUMNS)] for row in rows]
    width = [max(len(line[i]) for line in lines) for i in range(len(lines[0]))]
    return ["  ".join(word.ljust(w) if i < 2 else word.rjust(w) for i, (word, w) in enumerate(zip(line, width)))
            for line in lines]


def parse(words):
    parser = argparse.ArgumentParser(formatter_class=argparse.RawDescriptionHelpFormatter, description=__doc__)
    parser.add_argument("targets", nargs="*", default=list(FOLDERS), metavar="TARGET[=FOLDER]")
    parser.add_argument("--only", default=",".join(PROGRAMS), metavar="PROGRAM,...")
    parser.add_argument("--memory", type=pathlib.Path, metavar="FILE", help="out/memory of tests/boards/boot.sh")
    parser.add_argument("--budget", type=pathlib.Path, default=ROOT / "tests/boards/size_budget.tsv", metavar="FILE")
    parser.add_argument("--accept", metavar="WHY")
    args = parser.parse_args(words)
    args.programs = args.only.split(",")
    if unknown := [p for p in args.programs if p not in PROGRAMS]:
        parser.error(f"{unknown[0]}: programs are {', '.join(PROGRAMS)}")
    args.folders = {}
    for word in args.targets:
        target, _, folder = word.partition("=")
        if target not in FOLDERS:
            parser.error(f"{target}: targets are {', '.join(FOLDERS)}")
        args.folders[target] = pathlib.Path(folder) if folder else ROOT / "build" / FOLDERS[target] / "bin"
    if args.memory and len(args.folders) * len(args.programs) != 1:
        parser.error("--memory is of one program on one target")
    if args.accept is not None and (not args.accept.strip() or re.search(r"[\t\n]", args.accept)):
        parser.error("--accept: a note in one line, without tabulators")
    return args


def main(words):
    args = parse(words)
    measured, problems, remarks = {}, [], []
    try:
        budget = read_budget(args.budget)
        for target, folder in args.folders.items():
            for name in args.programs:
                program = folder / name
                if not program.is_file():
                    problems.append(f"{target}: {name}: not in {folder}; build it: cmake --build build/{FOLDERS[target]} "
                                    f"--target {name}")
                    continue
                for what, size in measure(program).items():
                    measured[target, name, what] = size
                if args.memory:
                    for what, size in read_memory(args.memory).items():
                        measured[target, name, what] = size
                if (gone := [k for k in budget if k[:2] == (target, name) and k[2] == "own text" and k not in measured]):
                    problems.append(f"{target}: {name}: has a budget for {gone[0][2]}, but {name}.map is not beside it")
    except (Wrong, OSError) as error:
        print(f"sizes: {error}", file=sys.stderr)
        return 1
    if args.accept is not None:
        write_budget(args.budget, accept(measured, budget, args.accept.strip()))
    for key, size in measured.items():
        problem, remark = judge(key, size, budget)
        problems += [problem] if problem else []
        remarks += [remark] if remark else []
    if measured:
        print("\n".join(table(measured)))
    for line in remarks:
        print(f"note: {line}")
    for line in problems:
        print(f"sizes: {line}", file=sys.stderr)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
