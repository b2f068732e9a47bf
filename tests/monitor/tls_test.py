#!/usr/bin/env python3
"""The program with TLS: HTTPS and WSS work, commands are taken off loopback with it and not without it, and another
monitor shows what it shows.

usage: tls_test.py MONITOR ROBOT      exit 77: skipped, with the reason
"""
import base64
import hashlib
import http.client
import json
import os
import re
import shutil
import signal
import socket
import ssl
import subprocess
import sys
import tempfile
import time

SKIPPED = 77
KEY = base64.b64encode(b"sixteen bytes 16").decode()
ACCEPT = base64.b64encode(hashlib.sha1((KEY + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11").encode()).digest()).decode()


def expect(what, is_so):
    if not is_so:
        sys.exit(f"FAILED: {what}")
    print("ok:", what)


class Monitor:
    """A running sinew-monitor, with what it prints."""

    def __init__(self, start, program, *options):
        process = start(program, "--port", "0", *options)
        self.scheme, self.port = re.match(r"(https?)://[0-9.]+:(\d+)", process.stdout.readline()).groups()
        self.token = re.match(r"token for commands: (\S+)", process.stdout.readline())[1]

    def ask(self, method, path, context=None, token=None, body=None):
        """The status and the reply."""
        kind = http.client.HTTPSConnection if context else http.client.HTTPConnection
        options = {"context": context} if context else {}
        connection = kind("127.0.0.1", int(self.port), timeout=20, **options)
        headers = {"content-type": "application/json"}
        if token:
            headers["authorization"] = "Bearer " + token
        connection.request(method, path, body, headers)
        reply = connection.getresponse()
        text = reply.read()
        return reply.status, json.loads(text)

    def web_socket(self, path, context):
        """The head of the answer, and what comes first."""
        raw = socket.create_connection(("127.0.0.1", int(self.port)), timeout=20)
        with (context.wrap_socket(raw, server_hostname="127.0.0.1") if context else raw) as line:
            line.sendall((f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{self.port}\r\nUpgrade: websocket\r\n"
                          f"Connection: Upgrade\r\nSec-WebSocket-Key: {KEY}\r\nSec-WebSocket-Version: 13\r\n"
                          "Sec-WebSocket-Protocol: foxglove.websocket.v1\r\n\r\n").encode())
            got = b""
            while b"serverInfo" not in got:
                more = line.recv(65536)
                if not more:
                    break
                got += more
        head, _, first = got.partition(b"\r\n\r\n")
        return head.decode(), first


def check(monitor, robot, folder):
    certificate, key = f"{folder}/monitor.pem", f"{folder}/monitor.key"
    subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes",
                    "-days", "2", "-subj", "/CN=monitor", "-addext", "subjectAltName=IP:127.0.0.1",
                    "-keyout", key, "-out", certificate], check=True, stderr=subprocess.DEVNULL)
    env = {**os.environ, "SINEW_RUN_DIR": folder}
    started = []

    def start(*command):
        process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True, env=env,
                                   start_new_session=True)
        started.append(process)
        return process

    command, body = "/api/robots/counterbot/module.enable", json.dumps({"module": "follower", "enabled": False})
    try:
        start(robot, "counterbot").stdout.readline()
        trusting = ssl.create_default_context(cafile=certificate)
        secure = Monitor(start, monitor, "--address", "0.0.0.0", "--tls", certificate, key)
        expect("it says https", secure.scheme == "https")
        expect("HTTPS", secure.ask("GET", "/api/robots", trusting)[1]["robots"][0]["robot"] == "counterbot")
        expect("commands with TLS off loopback are announced", secure.ask("GET", "/api", trusting)[1]["commands"] is True)
        expect("a wrong token is refused", secure.ask("POST", command, trusting, "guess", body)[0] == 401)
        status, reply = secure.ask("POST", command, trusting, secure.token, body)
        expect(f"commands with TLS off loopback are taken: {reply}", status != 403 and status != 401)
        head, first = secure.web_socket("/counterbot?token=" + secure.token, trusting)
        expect("WSS opens", head.startswith("HTTP/1.1 101") and ACCEPT in head)
        expect("WSS speaks, and takes commands", b"serverInfo" in first and b"clientPublish" in first)
        try:
            secure.ask("GET", "/api")
            expect("no HTTP without TLS on its port", False)
        except (OSError, http.client.HTTPException):
            expect("no HTTP without TLS on its port", True)

        bare = Monitor(start, monitor, "--address", "0.0.0.0")
        expect("without TLS off loopback none are announced", bare.ask("GET", "/api")[1]["commands"] is False)
        status, reply = bare.ask("POST", command, None, bare.token, body)
        expect("without TLS off loopback none are taken", status == 403 and "--tls" in reply["error"]["why"])

        near = Monitor(start, monitor, "--with", f"https://127.0.0.1:{secure.port}", f"127.0.0.1:{bare.port}", "--trust",
                       certificate)
        known = {}
        until = time.monotonic() + 20
        while len(known) < 2 and time.monotonic() < until:
            known = {m["address"]: m for m in near.ask("GET", "/api/monitors")[1]["monitors"] if m["state"] == "reached"}
            time.sleep(0.1)
        expect("another monitor reaches both", len(known) == 2)
        expect("and says which takes commands", known[f"127.0.0.1:{secure.port}"]["commands"] is True
               and known[f"127.0.0.1:{bare.port}"]["commands"] is False)
        at = f"/at/127.0.0.1:{secure.port}"
        status, reply = near.ask("POST", at + command, None, secure.token, body)
        expect("commands go through it to the one with TLS", status != 403 and status != 401)
        status, reply = near.ask("POST", f"/at/127.0.0.1:{bare.port}{command}", None, bare.token, body)
        expect("the reason of the other one comes back", status == 403 and "--tls" in reply["error"]["why"])
        head, first = near.web_socket(at + "/counterbot", None)
        expect("a WebSocket goes through it", head.startswith("HTTP/1.1 101") and b"serverInfo" in first)
        wrong = subprocess.run([monitor, "--port", "0", "--trust", key], env=env, capture_output=True, text=True)
        expect("a file without a certificate is refused: " + wrong.stderr.strip(), wrong.returncode == 2)
        wrong = subprocess.run([monitor, "--port", "0", "--with", "nowhere"], env=env, capture_output=True, text=True)
        expect("an address that is none is refused: " + wrong.stderr.strip(), wrong.returncode == 2)
    finally:
        for process in reversed(started):
            os.killpg(process.pid, signal.SIGTERM)
            process.wait()


def main():
    if not shutil.which("openssl"):
        print("skipped: openssl is not installed")
        return SKIPPED
    with tempfile.TemporaryDirectory() as folder:
        check(sys.argv[1], sys.argv[2], folder)
    return 0


if __name__ == "__main__":
    sys.exit(main())
