"""A driver in Python for `hpdm run SCENE --device lcm`: a hand on a spring that moves in and out.

Debian has no LCM module for Python, so this speaks LCM's UDP protocol itself. haptics/device/README.md
says how to generate the module hpdm.
"""

import ipaddress
import math
import os
import socket
import struct
import sys
import time
from urllib.parse import parse_qs, urlsplit

LOCAL_URL = "udpm://239.255.76.67:7667?ttl=0"  # LCM's default, which stays on this machine
SHORT_MESSAGE = 0x4C433032  # "LC02"


def fail(message):
    """Ends the program with one line."""
    print(f"example_driver.py: {message}", file=sys.stderr)
    sys.exit(2)


try:
    import hpdm
except ImportError:
    fail("no module hpdm; run lcm-gen --python --ppath build/driver lcmtypes/*.lcm, set PYTHONPATH=build/driver")


def network():
    """Returns the group with its port, and the time to live, of LCM_DEFAULT_URL."""
    text = os.environ.get("LCM_DEFAULT_URL") or LOCAL_URL
    try:
        url = urlsplit(text)
        group = url.hostname or "239.255.76.67"
        ttl = int(parse_qs(url.query).get("ttl", ["0"])[0])
        usable = url.scheme == "udpm" and ipaddress.IPv4Address(group).is_multicast and 0 <= ttl <= 255
        if usable:
            return (group, url.port or 7667), ttl
    except ValueError:
        pass  # a port or a time to live that is no number
    fail(f"LCM_DEFAULT_URL={text}: not a multicast address; give one such as {LOCAL_URL}, or unset it")


def connected(group, ttl):
    """Returns a socket that sends to the group and hears it."""
    link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    link.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    link.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, ttl)
    member = socket.inet_aton(group[0]) + socket.inet_aton("0.0.0.0")
    link.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, member)
    link.bind(group)
    link.setblocking(False)
    return link


group, ttl = network()
try:
    link = connected(group, ttl)
except OSError as error:
    fail(
        f"{group[0]}:{group[1]} cannot be opened ({error.strerror}); give the machine a multicast route "
        f"(ip route add {group[0]} dev lo), or set LCM_DEFAULT_URL"
    )


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
    try:
        link.sendto(header + reading.encode(), group)
    except OSError as error:
        fail(f"a reading cannot be sent ({error.strerror}); check the interface and its multicast route")
