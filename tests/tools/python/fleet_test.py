"""The fleet example: an interrupted run goes on, and shares make one table."""

import os
import runpy
import sqlite3
import subprocess
import sys
import tempfile
import unittest


FLEET = os.path.join(os.environ["HPDM_EXAMPLES"], "fleet.py")


def rows(path):
    with sqlite3.connect(path) as table:
        return table.execute("SELECT * FROM episodes ORDER BY seed").fetchall()


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
        fleet = runpy.run_path(FLEET)
        self.assertIn("run_episode", fleet)
        out = self.fleet("--episodes", "4", "--workers", "2", "--out", "dask.sqlite")
        self.assertIn("4 episodes", out)


if __name__ == "__main__":
    unittest.main()
