"""CANopen traffic of our driver and our simulated drive, read by tshark: usage: canopen_dissect_test.py CAPTURE_PROGRAM"""
import collections
import pathlib
import subprocess
import sys
import tempfile


def dissect(pcap):
    """Lines of (protocol column, information column) as tshark's CANopen dissector writes them."""
    out = subprocess.run(
        ["tshark", "-r", str(pcap), "-d", "can.subdissector,canopen", "-T", "fields", "-e", "_ws.col.Protocol",
         "-e", "_ws.col.Info", "-e", "_ws.malformed"], check=True, capture_output=True, text=True).stdout
    return [line.split("\t") for line in out.splitlines()]


def main():
    with tempfile.TemporaryDirectory() as folder:
        pcap = pathlib.Path(folder) / "bus.pcap"
        said = subprocess.run([sys.argv[1], str(pcap)], check=True, capture_output=True, text=True).stdout
        lines = dissect(pcap)
    frames = int(said.split()[0])
    counts = collections.Counter()
    problems = []
    for number, fields in enumerate(lines, 1):
        protocol, info = fields[0], fields[1]
        counts[next((word for word in WORDS if word in info), "other")] += 1
        if protocol != "CANopen" or (len(fields) > 2 and fields[2]) or "Malformed" in info:
            problems.append(f"frame {number}: {protocol}: {info}")
    print(f"{frames} frames: {dict(counts)}")
    if len(lines) != frames:
        problems.append(f"tshark read {len(lines)} of {frames} frames")
    for word in WORDS:
        if counts[word] == 0:
            problems.append(f"no {word} among what tshark understood")
    if counts["other"]:
        problems.append(f"{counts['other']} frames that are none of {', '.join(WORDS)}")
    for problem in problems[:20]:
        print(problem)
    return 1 if problems else 0


# As the dissector names them; all kinds that a drive's life has.
WORDS = ["NMT Error Control", "NMT", "SYNC", "EMCY", "SDO", "PDO"]

if __name__ == "__main__":
    sys.exit(main())
