#!/usr/bin/env python3
"""Checks every #include of the house against the rooms of docs/design.md.

usage: include_direction.py [ROOT]     prints file:line: what is wrong; exit 1 when anything is

The build already refuses most of this (cmake/room.cmake); this also sees what a library drags in, what is not built
here, system headers, and clocks.
"""
import pathlib
import re
import sys

# Which rooms the headers of a room may come from, besides its own. A room is the longest path below that matches.
ROOMS = {
    "math": [],
    "msg": [],
    "wire": ["msg"],
    "hal": ["msg"],
    "hal/linux": ["hal", "wire", "msg"],
    "rt": ["hal", "math", "msg"],
    "tap": ["hal", "hal/linux", "rt", "msg"],
    "vision": ["rt", "math", "msg"],
    "control": ["rt", "math", "msg"],
    "drivers": ["hal", "rt", "wire", "msg"],
    "sim_hil": ["hal", "wire", "msg"],
    "sim_hil/wire": ["hal", "wire", "msg"],
    "sim_hil/plant": ["sim_hil", "sim_hil/wire", "hal", "wire", "math", "msg"],
    "record": ["hal", "msg"],
    "record/run": ["record", "rt", "hal", "math", "msg"],
    "net": ["tap", "rt", "msg"],
    "monitor": ["tap", "rt", "record", "msg"],
}
# These may include every room, and each other as listed.
TOPS = {"apps": [], "examples": ["apps"], "bench": ["apps"], "tests": ["apps", "examples", "bench"]}
# Where a program outside the tops is put together, it opens the real sockets: these files may see hal/linux.
PROGRAMS = ["sim_hil/plant/main.cpp", "sim_hil/plant/wire_open.cpp"]

# Headers that only some rooms may use: (what it is, pattern of the header, rooms; TOPS always may unless listed).
CORE = ["math", "msg", "wire", "rt", "control", "vision"]
SYSTEM_ONLY_IN = [
    ("a POSIX or Linux header",
     r"(sys|linux|arpa|netinet|net|asm)/.*|(unistd|pthread|fcntl|poll|sched|semaphore|signal|dirent|dlfcn|termios|spawn"
     r"|netdb|mqueue|aio|syslog|pwd|grp|ucontext|execinfo)\.h|csignal",
     ["hal/linux", "sim_hil/plant"]),
    ("a header of Windows", r"(windows|win\w+|ws2\w+|mswsock|process|synchapi|processthreadsapi|tlhelp32|psapi)\.h", []),
    ("EGL, OpenGL or MuJoCo", r"(EGL|GL|GLES\d?|KHR|mujoco)/.*", ["sim_hil/plant"]),
    ("OpenCV", r"opencv2?/.*", ["vision/opencv"]),
    ("Eigen", r"Eigen/.*|unsupported/Eigen/.*", ["vision", "control", "sim_hil"]),
    ("TOML, the command line or JSON", r"toml\+\+/.*|toml\.hpp|CLI/.*|nlohmann/.*", ["sim_hil/plant", "tap"]),
    ("compression", r"lz4\w*\.h|zstd\w*\.h", ["record"]),
    ("an image format", r"png\.h|jpeglib\.h|turbojpeg\.h|tiffio\.hp*", ["hal/linux", "drivers", "sim_hil"]),
]
FORBIDDEN_IN = [
    ("the C library's mathematics (use math/)", r"cmath|math\.h|complex|complex\.h|tgmath\.h|ctgmath|numbers",
     ["rt", "control", "vision"]),
    ("the standard library's distributions", r"random", CORE),
    ("a clock", r"ctime|time\.h", CORE),
    ("threads or locks", r"thread|mutex|shared_mutex|condition_variable|future|semaphore|latch|barrier|stop_token", CORE),
    ("files or streams", r"fstream|filesystem|iostream|sstream|ostream|istream", ["rt", "control", "vision"]),
    ("the C library's files", r"cstdio|stdio\.h", ["control", "vision"]),  # rt has a last word before it aborts
    ("a text library", r"fmt/.*|format", CORE),
    # What Windows CE lacks comes with the system's headers, and with what of the standard library rests on them.
    ("a C header (coredll.hpp declares what Windows CE has)", r".*\.h", ["hal/wince_stub"]),
    ("what rests on calls that Windows CE lacks",
     r"thread|mutex|shared_mutex|condition_variable|future|semaphore|latch|barrier|stop_token|fstream|filesystem|chrono|ctime",
     ["hal/wince_stub"]),
]
# Words of the text itself, comments and strings taken out.
WORDS = [
    ("a clock", r"\b(steady_clock|system_clock|high_resolution_clock|clock_gettime|gettimeofday)\b", CORE + ["hal", "drivers"]),
    ("a thread", r"\bstd::(this_thread|jthread|thread|async)\b", CORE + ["hal", "drivers"]),
]

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')
SUFFIXES = {".hpp", ".cpp", ".h", ".c", ".cc", ".ipp"}


def room_of(path):
    """The room a path like hal/linux/os.cpp belongs to, or None."""
    parts = path.split("/")
    for length in (2, 1):  # the longer name first: hal/linux is not hal
        name = "/".join(parts[:length])
        if len(parts) > length and (name in ROOMS or name in TOPS):
            return name
    return None


def within(path, places):
    """Whether a file is in one of these rooms, folders, or (vision/opencv) among the files of that name."""
    return any(path.startswith(place + "/") or ("/" in place and path.startswith(place)) for place in places)


def without_comments_and_strings(text):
    """The same text with comments and string contents blanked, line numbers kept; include lines stay whole."""
    def blank(match):
        s = match.group(0)
        return s if s.startswith(("#", "\n")) else re.sub(r"[^\n]", " ", s)
    return re.sub(r'(?m)^[ \t]*#[ \t]*include[^\n]*|//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'',
                  lambda m: m.group(0).split("//")[0] if m.group(0).lstrip().startswith("#") else blank(m),
                  text, flags=re.S)


def allowed_in(path, room):
    """The rooms whose headers this file may name, besides its own."""
    if room in TOPS:
        return [*ROOMS, *TOPS[room]]
    return ROOMS[room] + (["hal/linux"] if path in PROGRAMS else [])


def check_include(root, path, room, kind, header):
    """Yields what is wrong with one include."""
    if kind == '"':
        target = room_of(header)
        if room in TOPS and (root / "tests/include" / header).is_file():
            return  # helpers shared by the tests
        if room in TOPS and "/" not in header and (root / path).with_name(header).is_file():
            return  # a test's helper beside it
        if room == "tests" and header.startswith("../") and (root / path).parent.joinpath(header).is_file():
            return  # or the fixture of another room's tests
        if header.startswith(".") or "/../" in header or "/" not in header:
            yield f'write "{header}" with its room: "room/file.hpp"'
        elif target is None:
            yield f'"{header}" is in no room'
        elif not (root / header).is_file():
            yield f'"{header}" does not exist'
        elif target != room and target not in allowed_in(path, room):
            allowed = ", ".join(ROOMS[room]) if room in ROOMS else "every room"
            yield f"{room} may not include {target} (allowed: {allowed or 'nothing'})"
        return
    if room_of(header) in ROOMS and (root / header).is_file():
        yield f'<{header}> is ours: write "{header}"'
    for what, pattern, places in SYSTEM_ONLY_IN:
        if re.fullmatch(pattern, header) and room not in TOPS and not within(path, places):
            yield f"<{header}>: {what} is allowed {'only in ' + ', '.join(places) if places else 'in no room'}"
    for what, pattern, places in FORBIDDEN_IN:
        if re.fullmatch(pattern, header) and within(path, places):
            yield f"<{header}>: {what} is not allowed in {room}"


def check(root):
    """Every problem under root as (file, line, text), in order of the files; and how many files were read."""
    problems, files = [], 0
    for top in sorted({room.split("/")[0] for room in [*ROOMS, *TOPS]}):
        for file in sorted(p for p in (root / top).rglob("*") if p.suffix in SUFFIXES and p.is_file()):
            files += 1
            path = file.relative_to(root).as_posix()
            room = room_of(path)
            text = without_comments_and_strings(file.read_text(encoding="utf-8"))
            for number, line in enumerate(text.splitlines(), 1):
                include = INCLUDE.match(line)
                if include:
                    for problem in check_include(root, path, room, *include.groups()):
                        problems.append((path, number, problem))
                    continue
                for what, pattern, places in WORDS:
                    word = re.search(pattern, line)
                    if word and room != "hal/linux" and within(path, places):
                        problems.append((path, number, f"{word.group(0)}: {what} is not allowed in {room}"))
    return problems, files


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".").resolve()
    problems, files = check(root)
    for path, number, text in problems:
        print(f"{path}:{number}: {text}")
    print(f"{files} files, {len(problems)} problems")
    return 1 if problems or files == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
