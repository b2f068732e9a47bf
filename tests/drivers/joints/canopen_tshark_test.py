#!/usr/bin/env python3
"""CANopen traffic of our driver and our simulated drive, read by a foreign decoder: tshark's CANopen dissector.

usage: canopen_tshark_test.py CANOPEN_TRACE     exit 0: every frame means the same to both; 77: there is no tshark here
"""
import collections
import pathlib
import shutil
import subprocess
import sys
import tempfile

FIELDS = ["canopen.cob_id", "canopen.node_id", "canopen.sdo.main_idx", "canopen.sdo.sub_idx", "canopen.sdo.data.bytes",
          "canopen.sdo.abort_code", "canopen.nmt_ctrl.cd", "canopen.nmt_ctrl.node_id", "canopen.nmt_guard.state",
          "canopen.em.err_code", "canopen.em.err_reg", "canopen.pdo.data.bytes", "canopen.sdo.n", "_ws.malformed"]
SEEN = ["nmt", "sync", "emcy", "pdo", "sdo_request", "sdo_reply", "heartbeat"]  # each has to occur


def number(text):
    return int(text, 0) if text else None


def of_tshark(columns):
    """tshark's reading of a frame, in the words of canopen_trace; None where it has none."""
    f = dict(zip(FIELDS, columns))
    out = {"cob_id": number(f["canopen.cob_id"]), "node": number(f["canopen.node_id"]),
           "malformed": f["_ws.malformed"] != ""}
    for name, field in [("index", "canopen.sdo.main_idx"), ("sub", "canopen.sdo.sub_idx"),
                        ("abort", "canopen.sdo.abort_code"), ("command", "canopen.nmt_ctrl.cd"),
                        ("target", "canopen.nmt_ctrl.node_id"), ("state", "canopen.nmt_guard.state"),
                        ("code", "canopen.em.err_code"), ("register", "canopen.em.err_reg")]:
        out[name] = number(f[field])
    # For an SDO it shows four bytes, and how many of them are no data.
    sdo, unused = f["canopen.sdo.data.bytes"], number(f["canopen.sdo.n"]) or 0
    out["data"] = sdo[:len(sdo) - 2 * unused] if sdo else f["canopen.pdo.data.bytes"]
    return out


def of_ours(line):
    """The kind of a frame and the reading that tshark must give."""
    cob_id, kind, node, *rest = line.split()
    out = {"cob_id": int(cob_id, 16), "node": int(node), "malformed": False}
    if kind == "nmt":
        out.update(node=0, command=int(node), target=int(rest[0]))
    elif kind == "heartbeat":
        out.update(state=int(rest[0]))
    elif kind == "emcy":
        out.update(code=int(rest[0], 16), register=int(rest[1], 16))
    elif kind == "pdo":
        out.update(data=rest[0])
    elif kind.startswith("sdo") and rest[0] != "segment":
        out.update(index=int(rest[0], 16), sub=int(rest[1], 16))
        if len(rest) > 3:
            out.update({"abort": {"abort": int(rest[3], 16)}, "data": {"data": rest[3]}}[rest[2]])
    return kind, out


def main():
    tshark = shutil.which("tshark")
    if not tshark:
        print("no tshark here (tools/packages.txt has it in the group ci): nothing was compared")
        return 77
    with tempfile.TemporaryDirectory() as folder:
        trace = pathlib.Path(folder, "trace.pcap")
        ours = subprocess.run([sys.argv[1], str(trace)], check=True, text=True, stdout=subprocess.PIPE).stdout.splitlines()
        command = [tshark, "-n", "-r", str(trace), "-d", "can.subdissector,canopen", "-T", "fields"]
        for field in FIELDS:
            command += ["-e", field]
        theirs = subprocess.run(command, check=True, text=True, stdout=subprocess.PIPE).stdout.splitlines()
    if len(ours) != len(theirs) or not ours:
        print(f"{len(ours)} frames were written, tshark read {len(theirs)}")
        return 1
    seen, wrong = collections.Counter(), 0
    for index, (line, other) in enumerate(zip(ours, theirs), 1):
        kind, expected = of_ours(line)
        found = of_tshark(other.split("\t"))
        seen[kind] += 1
        differences = [f"{k}: ours {v}, tshark {found[k]}" for k, v in expected.items() if found[k] != v]
        if differences:
            wrong += 1
            if wrong <= 20:
                print(f"frame {index}: {line}: " + "; ".join(differences))
    missing = [kind for kind in SEEN if not seen[kind]]
    print(f"{len(ours)} frames, {wrong} differences: " + ", ".join(f"{n} {kind}" for kind, n in sorted(seen.items())))
    if missing:
        print("the trace has no " + ", ".join(missing))
    return 1 if wrong or missing else 0


if __name__ == "__main__":
    sys.exit(main())
