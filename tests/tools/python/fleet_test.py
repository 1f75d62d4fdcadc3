"""The fleet example: an interrupted run continues, and shares make one table."""

import os
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
import unittest


FLEET = os.path.join(os.environ["HPDM_EXAMPLES"], "fleet.py")


def rows(path):
    with sqlite3.connect(path) as table:
        return table.execute("SELECT * FROM episodes ORDER BY seed").fetchall()


def finished(path):
    """Number of units in a table that is being written."""
    try:
        return len(rows(path))
    except sqlite3.OperationalError:
        return 0


def workers_of(parent):
    """Processes of a Dask cluster's workers."""
    found = []
    for process in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{process}/stat", encoding="utf-8") as stat:
                if int(stat.read().rpartition(")")[2].split()[1]) != parent:
                    continue
            with open(f"/proc/{process}/cmdline", encoding="utf-8") as command:
                if "spawn_main" in command.read():
                    found.append(int(process))
        except OSError:
            continue
    return found


class FleetTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def fleet(self, *arguments):
        done = subprocess.run([sys.executable, FLEET, *arguments], cwd=self.folder, check=True,
                              capture_output=True, text=True)
        return done.stdout

    def test_goes_on_and_merges_shares(self):
        self.fleet("--episodes", "2", "--out", "whole.sqlite")
        first = rows(os.path.join(self.folder, "whole.sqlite"))
        self.fleet("--episodes", "4", "--out", "whole.sqlite")
        whole = rows(os.path.join(self.folder, "whole.sqlite"))
        self.assertEqual(whole[:2], first)
        self.assertEqual([row[1] for row in whole], [0, 1, 2, 3])
        for share in range(2):
            self.fleet("--episodes", "4", "--share", f"{share}/2", "--out", f"{share}.sqlite")
        self.fleet("--merge", "0.sqlite", "1.sqlite", "--out", "merged.sqlite")
        self.assertEqual(rows(os.path.join(self.folder, "merged.sqlite")), whole)

    def test_dask_goes_on_after_a_killed_worker(self):
        try:
            import dask.distributed  # noqa: F401
        except ImportError:
            self.skipTest("python3-distributed is not installed")
        path = os.path.join(self.folder, "dask.sqlite")
        run = subprocess.Popen([sys.executable, FLEET, "--episodes", "8", "--workers", "2", "--out",
                                path], cwd=self.folder, stdout=subprocess.PIPE,
                               stderr=subprocess.DEVNULL, text=True)
        while run.poll() is None and not (os.path.exists(path) and finished(path)):
            time.sleep(0.05)
        os.kill(workers_of(run.pid)[0], signal.SIGKILL)
        self.assertIn("8 episodes", run.communicate(timeout=200)[0])
        self.assertEqual([row[1] for row in rows(path)], list(range(8)))


if __name__ == "__main__":
    unittest.main()
