#!/usr/bin/env python3
"""Checks every #include of the house against the table of rooms, ROOT/cmake/rooms.txt.

usage: include_direction.py [ROOT]     prints file:line: what is wrong; exit 1 when anything is

The build already refuses most of this (cmake/room.cmake); this also sees headers behind a library, files not built
here, system headers, and clocks.
"""
import pathlib
import re
import sys

# These may include every room, and each other as listed.
TOPS = {"examples": [], "bench": [], "tests": ["examples", "bench"]}

# Headers that only some rooms may use: (what it is, pattern of the header, rooms); programs (apps, TOPS) always may.
CORE = ["math", "msg", "wire", "rt", "control", "vision"]
SYSTEM_ONLY_IN = [
    ("a POSIX or Linux header",
     r"(sys|linux|arpa|netinet|net|asm)/.*|(unistd|pthread|fcntl|poll|sched|semaphore|signal|dirent|dlfcn|termios|spawn"
     r"|netdb|mqueue|aio|syslog|pwd|grp|ucontext|execinfo)\.h|csignal",
     ["hal/linux", "monitor", "net", "grab"]),
    ("a header of Windows", r"(windows|win\w+|ws2\w+|mswsock|process|synchapi|processthreadsapi|tlhelp32|psapi)\.h", []),
    ("EGL, OpenGL or MuJoCo", r"(EGL|GL|GLES\d?|KHR|mujoco)/.*", ["sim_hil/plant", "sim_hil/mujoco", "sim_hil/pitch", "robots"]),
    ("OpenCV", r"opencv2?/.*", ["vision/opencv"]),
    ("Eigen", r"Eigen/.*|unsupported/Eigen/.*", ["vision", "control"]),
    ("TOML, the command line or JSON", r"toml\+\+/.*|toml\.hpp|CLI/.*|nlohmann/.*", ["tap", "monitor", "client", "net"]),
    ("compression", r"lz4\w*\.h|zstd\w*\.h", ["record"]),
    ("an image format", r"png\.h|jpeglib\.h|turbojpeg\.h|tiffio\.hp*", ["hal/linux", "dataset", "images"]),
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
    # Calls that Windows CE lacks come with the system's headers, and with the standard headers that use them.
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
MOST_SOURCES = 60  # in one folder: as many as a newcomer can look through
# Compiled by others, against what is installed: in no room.
OTHERS = {"client/mex"}
SUFFIXES = {".hpp", ".cpp", ".h", ".c", ".cc", ".ipp"}


def read_rooms(table):
    """{room: rooms that it sees} of cmake/rooms.txt; wrong lines end the program."""
    rooms = {}
    for number, line in enumerate(table.read_text(encoding="utf-8").splitlines(), 1):
        if not line or line.startswith("#"):
            continue
        found = re.fullmatch(r"([a-z0-9_/*]+):([a-z0-9_/* ]*)\| (.+)", line)
        sees = found[2].split() if found else []
        if not found or found[1] in rooms:
            sys.exit(f"{table}:{number}: a line is 'room: rooms that it sees | what it holds', each room once")
        rooms[found[1]] = sees
    for room, sees in rooms.items():
        unknown = [other for other in sees if other not in rooms and pattern_of(other) not in rooms]  # or one of robots/*
        if unknown or room in sees:
            sys.exit(f"{table}: {room} sees {', '.join(unknown) or 'itself'}: name other rooms of the table")
    return rooms


def circle(rooms):
    """Rooms that see each other in a circle, or nothing."""
    done = []
    while len(done) < len(rooms):
        free = [room for room in rooms if room not in done and
                all(other in done or pattern_of(other) in done for other in rooms[room])]
        if not free:
            return [room for room in rooms if room not in done]
        done += free
    return []


def pattern_of(folder):
    """robots/* of robots/quad: the room's line when it has none of its own."""
    parts = folder.split("/")
    return "/".join([parts[0], "*", *parts[2:]]) if len(parts) > 1 else folder


def sees_of(room, rooms):
    """The rooms that a room sees, also when its line has a *."""
    if room in rooms:
        return rooms[room]
    return [other.replace("*", room.split("/")[1]) for other in rooms[pattern_of(room)]]


def room_of(path, rooms):
    """The room that a file like hal/linux/os.cpp stands in: a room of the table is one folder, the other tops with what is
    below. None: it stands in no room."""
    folder = path.rpartition("/")[0]
    if folder in rooms or pattern_of(folder) in rooms:
        return folder
    if path.startswith("hal/linux/libcamera/plugin/"):
        return "hal/linux/libcamera"
    top = path.split("/")[0]
    return top if top in TOPS else None


def is_program(room):
    return room in TOPS or room.split("/")[0] == "apps"


def within(path, places):
    """Whether a file is in or below one of these folders."""
    return any(path.startswith(place + "/") for place in places)


def without_comments_and_strings(text):
    """The same text with comments and string contents blanked, line numbers kept; include lines stay whole."""
    def blank(match):
        s = match.group(0)
        return s if s.startswith(("#", "\n")) else re.sub(r"[^\n]", " ", s)
    return re.sub(r'(?m)^[ \t]*#[ \t]*include[^\n]*|//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'',
                  lambda m: m.group(0).split("//")[0] if m.group(0).lstrip().startswith("#") else blank(m),
                  text, flags=re.S)


def may_include(room, target, rooms):
    """Whether a file of one room may name headers of another."""
    if room in TOPS:
        return target not in TOPS or target in TOPS[room]
    return target in sees_of(room, rooms)


def check_include(root, path, room, rooms, kind, header):
    """Yields what is wrong with one include."""
    if kind == '"':
        target = room_of(header, rooms)
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
        elif target != room and not may_include(room, target, rooms):
            allowed = "every room" if room in TOPS else ", ".join(sees_of(room, rooms))
            yield f"{room} may not include {target} (allowed: {allowed or 'nothing'})"
        return
    if room_of(header, rooms) not in [None, *TOPS] and (root / header).is_file():
        yield f'<{header}> is ours: write "{header}"'
    for what, pattern, places in SYSTEM_ONLY_IN:
        if re.fullmatch(pattern, header) and not is_program(room) and not within(path, places):
            yield f"<{header}>: {what} is allowed {'only in ' + ', '.join(places) if places else 'in no room'}"
    for what, pattern, places in FORBIDDEN_IN:
        if re.fullmatch(pattern, header) and within(path, places):
            yield f"<{header}>: {what} is not allowed in {room}"


def check(root):
    """Every problem under root as (file, line, text), in order of the files; and how many files were read."""
    table = root / "cmake/rooms.txt"
    rooms = read_rooms(table)
    problems, files, included = [], 0, {room: set() for room in rooms}
    turning = circle(rooms)
    if turning:
        problems.append(("cmake/rooms.txt", 1, "these see each other in a circle: " + ", ".join(turning)))
    for top in sorted({room.split("/")[0] for room in [*rooms, *TOPS]}):
        for file in sorted(p for p in (root / top).rglob("*") if p.suffix in SUFFIXES and p.is_file()):
            path = file.relative_to(root).as_posix()
            if path.rpartition("/")[0] in OTHERS:
                continue
            files += 1
            room = room_of(path, rooms)
            if room is None:
                problems.append((path, 1, "its folder is no room: it has no line in cmake/rooms.txt"))
                continue
            text = without_comments_and_strings(file.read_text(encoding="utf-8"))
            for number, line in enumerate(text.splitlines(), 1):
                include = INCLUDE.match(line)
                if include:
                    if room in rooms:
                        included[room].add(room_of(include[2], rooms))
                    for problem in check_include(root, path, room, rooms, *include.groups()):
                        problems.append((path, number, problem))
                    continue
                for what, pattern, places in WORDS:
                    word = re.search(pattern, line)
                    if word and not within(path, ["hal/linux"]) and within(path, places):
                        problems.append((path, number, f"{word.group(0)}: {what} is not allowed in {room}"))
    for room, sees in rooms.items():
        unused = [other for other in sees if other not in included[room] and "*" not in room]  # a robot may leave some unused
        if unused:
            problems.append(("cmake/rooms.txt", 1, f"{room} includes nothing of {', '.join(unused)}: take it out"))
    for room in rooms:
        sources = [p for p in (root / room).glob("*.?pp")]
        if len(sources) > MOST_SOURCES:
            problems.append((room, 1, f"{len(sources)} sources in one folder, at most {MOST_SOURCES}: divide it"))
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
