"""Prints the peak force of each instrument in a session's log: read_log.py SESSION.lcmlog"""

import math
import struct
import sys

import hpdm


def events(path):
    """Yields time (us), channel and message of each event of an LCM log."""
    with open(path, "rb") as log:
        while len(header := log.read(28)) == 28:
            sync, _, time_us, channel_size, message_size = struct.unpack(">IqqII", header)
            if sync != 0xEDA1DA01:
                sys.exit(f"{path}: damaged; hpdm log check --repair writes the intact events")
            yield time_us, log.read(channel_size).decode(), log.read(message_size)


peaks = {}
for _, channel, message in events(sys.argv[1]):
    if channel == "HPDM_FORCE":
        for instrument, tool in enumerate(hpdm.force_t.decode(message).tools):
            peaks[instrument] = max(peaks.get(instrument, 0), math.hypot(*tool.force))
for instrument, peak in peaks.items():
    print(f"instrument {instrument}: peak force {peak:.3f} N")
