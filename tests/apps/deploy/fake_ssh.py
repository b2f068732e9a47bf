#!/usr/bin/env python3
"""An ssh whose board is a folder on this machine: it runs the board's commands here.

FAKE_BOARD  folder with bin/ (programs that go before the real ones), etc/ and log
FAKE_BOARDS folder that has such a folder for each host, instead
FAKE_FAULT  the fault to play: unreachable, refused, denied, breaks:BYTES (the input ends there), noise (the login talks)
"""
import os
import subprocess
import sys

board, fault = os.environ["FAKE_BOARD"], os.environ.get("FAKE_FAULT", "")
words = sys.argv[1:]
while words and words[0].startswith("-"):
    words = words[2:]
host, command = words[0], words[1]
if "FAKE_BOARDS" in os.environ:
    board = f"{os.environ['FAKE_BOARDS']}/{host}"
    only, _, what = fault.rpartition("=")  # HOST=FAULT
    fault = what if only in ("", host) else ""
with open(f"{board}/log", "a", encoding="utf-8") as log:
    log.write(f"ssh {host}\n")
said = {"unreachable": f"ssh: connect to host {host} port 22: No route to host",
        "refused": f"ssh: connect to host {host} port 22: Connection refused",
        "denied": f"{host}: Permission denied (publickey).",
        "unknown": f"ssh: Could not resolve hostname {host}: Name or service not known"}
if fault in said:
    print(said[fault], file=sys.stderr)
    sys.exit(255)
if fault == "noise":
    print("Welcome to the board!\nsinew = 7")
    sys.stdout.flush()
environment = dict(os.environ, FAKE_BOARD=board, PATH=f"{board}/bin:{os.environ['PATH']}", HOME=board)
if fault.startswith("breaks:") and "tar -xf" in command:
    part = sys.stdin.buffer.read(int(fault[7:]))
    subprocess.run(["sh", "-c", command], input=part, env=environment, check=False)
    print("client_loop: send disconnect: Broken pipe", file=sys.stderr)
    sys.exit(255)
if fault.startswith("breaks:") and "::sinew end" in command:
    done = subprocess.run(["sh", "-c", command], stdout=subprocess.PIPE, env=environment, check=False)
    sys.stdout.buffer.write(done.stdout[:int(fault[7:])])
    sys.stdout.flush()
    print("client_loop: send disconnect: Broken pipe", file=sys.stderr)
    sys.exit(255)
os.execvpe("sh", ["sh", "-c", command], environment)
