"""Prints the peak displayed force of each instrument in a log: read_log.py SESSION.lcmlog"""

import math
import struct
import sys

SYNC = 0xEDA1DA01  # before each event


def fail(message):
    """Ends the program with one line."""
    print(f"read_log.py: {message}", file=sys.stderr)
    sys.exit(2)


try:
    import hpdm
except ImportError:
    fail("no module hpdm; run lcm-gen --python --ppath build/driver lcmtypes/*.lcm, set PYTHONPATH=build/driver")


def events(path):
    """Yields time (us), channel and message of each event of an LCM log."""
    with open(path, "rb") as log:
        if log.read(4) != struct.pack(">I", SYNC):
            fail(f"{path}: not an LCM log; give a session.lcmlog")
        log.seek(0)
        while len(header := log.read(28)) == 28:
            sync, _, time_us, channel_size, message_size = struct.unpack(">IqqII", header)
            if sync != SYNC:
                fail(f"{path}: damaged; hpdm log check --repair writes the intact events")
            channel, message = log.read(channel_size), log.read(message_size)
            if len(message) == message_size:  # the last event may be cut off
                yield time_us, channel.decode(), message


def main():
    if len(sys.argv) != 2:
        fail("give one log: read_log.py SESSION.lcmlog")
    peaks = {}
    try:
        for _, channel, message in events(sys.argv[1]):
            if channel == "HPDM_FORCE":
                for instrument, tool in enumerate(hpdm.force_t.decode(message).tools):
                    peaks[instrument] = max(peaks.get(instrument, 0), math.hypot(*tool.force))
    except OSError as error:
        fail(f"{sys.argv[1]}: cannot be read ({error.strerror}); give a session.lcmlog")
    for instrument, peak in peaks.items():
        print(f"instrument {instrument}: peak force {peak:.3f} N")


if __name__ == "__main__":
    main()
