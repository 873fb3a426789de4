#!/usr/bin/python3
"""page_clients PORT COUNT: COUNT clients at the WebSocket of `hystcan page`, and one that never reads.

Each asks for every row (`view`) and for the settings each second. Prints "all connected" when each has its first rows. At
SIGTERM it prints as JSON what each received: messages with rows, rows, rows lost, texts, and whether it was cut off.
"""
import base64
import json
import os
import selectors
import signal
import socket
import struct
import sys
import time


def message(**keys):
    """A text frame of a client: masked."""
    payload = json.dumps(keys).encode()
    mask = os.urandom(4)
    head = struct.pack("!BB", 0x81, 0x80 | len(payload)) if len(payload) < 126 else \
        struct.pack("!BBH", 0x81, 0x80 | 126, len(payload))
    return head + mask + bytes(byte ^ mask[i % 4] for i, byte in enumerate(payload))


class Client:
    def __init__(self, port, receive_buffer=None):
        self.socket = socket.socket()
        if receive_buffer:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
        self.socket.connect(("127.0.0.1", port))
        key = base64.b64encode(os.urandom(16)).decode()
        self.socket.sendall((f"GET /socket HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\n"
                             f"Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {key}\r\n\r\n").encode())
        self.received = bytearray()
        self.upgraded = False
        self.count = {"blocks": 0, "rows": 0, "lost": 0, "texts": 0, "cut_off": False}

    def send(self, number, what, **keys):
        self.socket.send(message(id=number, do=what, **keys))

    def read(self):
        """Takes what has come; False at the end of the connection."""
        try:
            part = self.socket.recv(1 << 16)
        except ConnectionError:
            part = b""
        if not part:
            self.count["cut_off"] = True
            return False
        self.received += part
        if not self.upgraded:
            end = self.received.find(b"\r\n\r\n")
            if end < 0:
                return True
            if not self.received.startswith(b"HTTP/1.1 101 "):
                sys.exit(f"page_clients: refused: {bytes(self.received)!r}")
            del self.received[:end + 4]
            self.upgraded = True
        while self.take_frame():
            pass
        return True

    def take_frame(self):
        data = self.received
        if len(data) < 2:
            return False
        kind, length, start = data[0] & 0x0F, data[1] & 0x7F, 2
        if length >= 126:
            form = "!H" if length == 126 else "!Q"
            start += struct.calcsize(form)
            if len(data) < start:
                return False
            length = struct.unpack_from(form, data, 2)[0]
        if len(data) < start + length:
            return False
        if kind == 2:
            _, rows, lost, _ = struct.unpack_from("<4I", data, start)
            self.count["blocks"] += 1
            self.count["rows"] += rows
            self.count["lost"] += lost
        elif kind == 1:
            self.count["texts"] += 1
        del data[:start + length]
        return True


def main(port, number):
    stopped = []
    signal.signal(signal.SIGTERM, lambda *_: stopped.append(True))
    silent = Client(port, receive_buffer=4096)
    clients = [Client(port) for _ in range(number)]
    selector = selectors.DefaultSelector()
    for client in clients:
        selector.register(client.socket, selectors.EVENT_READ, client)
    asked, next_request, said = False, time.monotonic(), False
    while not stopped:
        for key, _ in selector.select(0.1):
            if not key.data.read():
                selector.unregister(key.fileobj)
        if time.monotonic() >= next_request and all(client.upgraded for client in clients):
            for client in clients:
                if not client.count["cut_off"]:
                    client.send(1, "settings") if asked else client.send(1, "view", rate_Hz=1000)
            if not asked:
                silent.send(1, "view", rate_Hz=1000)
            asked, next_request = True, next_request + 1.0
        if not said and all(client.count["rows"] > 0 for client in clients):
            print("all connected", file=sys.stderr, flush=True)
            said = True
    print(json.dumps([client.count for client in clients]))


main(int(sys.argv[1]), int(sys.argv[2]))
