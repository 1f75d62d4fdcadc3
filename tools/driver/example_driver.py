"""A driver in Python for `hpdm run SCENE --device lcm`: a hand on a spring that moves in and out.

Debian has no LCM module for Python, so this speaks LCM's UDP protocol itself. haptics/device/README.md
says how to generate the module hpdm.
"""

import math
import socket
import struct
import time

import hpdm

GROUP = ("239.255.76.67", 7667)  # LCM's default
SHORT_MESSAGE = 0x4C433032  # "LC02"

link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
link.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
link.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)  # stays on this machine
member = socket.inet_aton(GROUP[0]) + socket.inet_aton("0.0.0.0")
link.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, member)
link.bind(GROUP)
link.setblocking(False)


def received(channel):
    """Yields the messages of a channel that have arrived."""
    while True:
        try:
            packet = link.recv(65536)
        except BlockingIOError:
            return
        name, _, message = packet[8:].partition(b"\0")
        if packet[:4] == struct.pack(">I", SHORT_MESSAGE) and name == channel:
            yield message


effort, effort_time = 0.0, -1.0  # N along the insertion axis, and when it arrived (s)
reading = hpdm.device_t()
reading.valid = True
start = time.monotonic()
while True:
    reading.sequence += 1
    time.sleep(max(0, start + 1e-3 * reading.sequence - time.monotonic()))
    now = time.monotonic() - start
    for message in received(b"HPDM_FORCE"):
        effort, effort_time = hpdm.force_t.decode(message).tools[0].effort[2], now
    if now - effort_time > 0.05:
        effort = 0.0  # the session is silent: no force
    insertion = 0.14 + 0.035 * math.sin(3 * now) + effort / 300  # a real driver reads its encoders
    reading.time_ns = time.monotonic_ns()
    reading.joints = [0, 0, insertion, 0, 1]  # pitch, yaw, insertion, roll, jaw
    header = struct.pack(">II", SHORT_MESSAGE, reading.sequence % 2**32) + b"HPDM_DEVICE\0"
    link.sendto(header + reading.encode(), GROUP)
