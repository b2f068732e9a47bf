"""The code that a program sets aside (cmake/set_aside.cmake), and that is not locked into memory, is that of commands and
of libraries that no loop calls. usage: set_aside.py PROGRAM"""
import re
import subprocess
import sys

LEAST_BYTES = 1_000_000  # or names have changed, and the script finds them no more
# Of rooms that loops run, only what is checked before the start.
ALLOWED = re.compile(r"CLI|nlohmann|toml|fmt|sinew(3app|3tap|5sweep|6record|7dataset)|sinew3hal\d\dcheck_|sinew7drivers\d\dcheck_")


def symbols(program):
    for line in subprocess.check_output(["nm", "-S", "--defined-only", program], text=True).splitlines():
        place, _, rest = line.partition(" ")
        yield int(place, 16), rest.split()[-2], rest.split()[-1]


def main(program):
    places = list(symbols(program))
    mark = {name: place for place, _, name in places if name.startswith("sinew_set_aside_")}
    begin, end = mark.get("sinew_set_aside_begin", 0), mark.get("sinew_set_aside_end", 0)
    # A local function ("t") is called only by the rest of its room.
    wrong = [name for place, kind, name in places
             if begin <= place < end and kind != "t" and name not in mark and not ALLOWED.search(name)]
    for name in wrong:
        print("a loop may call", name)
    if end - begin < LEAST_BYTES:
        print(f"only {end - begin} bytes are set aside; at least {LEAST_BYTES} are expected")
    return 1 if wrong or end - begin < LEAST_BYTES else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
