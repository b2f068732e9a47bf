"""The symbols that hal/wince_stub needs from elsewhere: calls that coredll.hpp declares, and from the compiler's own libraries
only symbols that use no call that Windows CE lacks. Headers of the C library that come in with the C++ library declare more.

    wince_symbols_test.py LIBRARY COREDLL.HPP     environment: CXX the compiler, NM its tool (set by CMakeLists.txt)
"""
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

LIBRARY, HEADER = sys.argv[1], pathlib.Path(sys.argv[2])
NM, CXX = os.environ["NM"], os.environ["CXX"]
# Memory and text, exceptions, objects that end with the program, 64-bit numbers divided in 32 bits.
RUNTIME = re.compile(r"mem(chr|cmp|cpy|move|set)|str(chr|len)|atexit|__cxa_\w+|__gxx_personality_\w+|_Unwind_\w+|___?chkstk(_ms)?|__u?(div|mod|divmod)di[34]"
                     r"|operator (new|delete)(\[\])?\(.*|(vtable|typeinfo)( name)? for .*|sinew::.*")
LIBRARY_OF_CPP = re.compile(r"std::.*")
LACKING = re.compile(r"std::(\w+::)*(thread|this_thread|jthread|\w*mutex|condition_variable\w*|future\w*|chrono|filesystem|"
                     r"basic_\w*(fstream|filebuf)|random_device|locale)\b")


def foreign(library):
    """The forbidden symbols that it needs, by name."""
    calls = set(re.findall(r"SINEW_CE_STD (\w+)\(", HEADER.read_text(encoding="utf-8")))
    said = subprocess.run([NM, "-C", "-u", library], capture_output=True, text=True, check=True).stdout
    own = subprocess.run([NM, "-C", "--defined-only", library], capture_output=True, text=True, check=True).stdout
    own = {line.split(None, 2)[2] for line in own.splitlines() if len(line.split(None, 2)) == 3}
    taken = {line.split(None, 1)[1] for line in said.splitlines() if line.strip().startswith(("U ", "w "))} - own
    found = []
    for name in sorted(taken):
        imported = re.fullmatch(r"_?_imp__?(\w+?)(@\d+)?", name)  # in 32 bits with the bytes of its arguments
        if imported:
            if imported[1] not in calls:
                found.append(imported[1])
        elif not RUNTIME.fullmatch(name) and (not LIBRARY_OF_CPP.match(name) or LACKING.match(name)):
            found.append(name)
    return len(taken), found


class Symbols(unittest.TestCase):
    def test_the_room_takes_what_the_header_declares_and_nothing_else(self):
        count, found = foreign(LIBRARY)
        self.assertGreater(count, 40)  # the list is not empty by mistake
        self.assertEqual(found, [])

    def test_what_windows_ce_lacks_is_seen(self):
        source = """#include <chrono>
#include <pthread.h>
#include <time.h>
extern "C" __declspec(dllimport) int __stdcall VirtualLock(void*, unsigned long);
extern "C" __declspec(dllimport) void __stdcall Sleep(unsigned);
long f() { Sleep(1); return VirtualLock(nullptr, 1) + pthread_mutex_lock(nullptr) + clock() +
                            std::chrono::steady_clock::now().time_since_epoch().count(); }
"""
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, "a.cpp")
            path.write_text(source, encoding="ascii")
            subprocess.run([CXX, "-std=c++20", "-w", "-c", path, "-o", f"{folder}/a.o"], check=True)
            _, found = foreign(f"{folder}/a.o")
        text = " ".join(found)
        for name in ("VirtualLock", "pthread_mutex_lock", "clock", "steady_clock::now"):
            self.assertIn(name, text)
        self.assertNotIn("Sleep", text)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0]], verbosity=2)
