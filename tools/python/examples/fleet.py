"""Runs episodes of a task on many workers and keeps their results in one SQLite table.

A unit is one episode: task and seed. Finished units stay in the table, so a run that was stopped, or
that lost a worker, continues with the others. With Dask (Debian: python3-distributed):

    fleet.py --episodes 1000 --out fleet.sqlite --workers 4

Under Slurm each job of an array takes its share, into a file of its own (see --share):

    sbatch --array=0-9 --wrap 'fleet.py --episodes 1000 --share $SLURM_ARRAY_TASK_ID/10 \\
        --out fleet_$SLURM_ARRAY_TASK_ID.sqlite'
    fleet.py --merge fleet_*.sqlite --out fleet.sqlite
"""

import argparse
import sqlite3

import numpy as np

COLUMNS = "task TEXT, seed INTEGER, reward REAL, steps INTEGER, success INTEGER, peak_force REAL"
environments = {}  # of this worker, by task


def run_episode(task, seed):
    """Plays one episode with random actions. Returns a row of the table."""
    import hpdm.gym
    env = environments.setdefault(task, None) or hpdm.gym.make(task)
    environments[task] = env
    _, _ = env.reset(seed=seed)
    random = np.random.default_rng(seed)
    total, peak, ended = 0.0, 0.0, False
    while not ended:
        action = random.uniform(-1, 1, env.action_space.shape).astype(np.float32)
        _, reward, terminated, truncated, info = env.step(action)
        total, peak = total + reward, max(peak, info["force"])
        ended = terminated or truncated
    return task, seed, total, env.task.steps, int(info["successful_task"]), peak


def open_table(path):
    """Opens the table, made if needed."""
    table = sqlite3.connect(path)
    table.execute(f"CREATE TABLE IF NOT EXISTS episodes ({COLUMNS}, PRIMARY KEY (task, seed))")
    return table


def keep(table, row):
    """Adds a finished unit; one that is there already is the same."""
    table.execute("INSERT OR REPLACE INTO episodes VALUES (?, ?, ?, ?, ?, ?)", row)
    table.commit()


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--task", default="Reach")
    parser.add_argument("--episodes", type=int, default=20)
    parser.add_argument("--share", default="0/1", help="part K/N of the episodes")
    parser.add_argument("--workers", type=int, default=0, help="Dask workers; 0: this process")
    parser.add_argument("--out", default="fleet.sqlite")
    parser.add_argument("--merge", nargs="*", default=[], help="tables to add to --out")
    options = parser.parse_args()
    table = open_table(options.out)
    for path in options.merge:
        for row in open_table(path).execute("SELECT * FROM episodes").fetchall():
            keep(table, row)
    if options.merge:
        return
    part, parts = (int(number) for number in options.share.split("/"))
    done = {seed for (seed,) in table.execute(
        "SELECT seed FROM episodes WHERE task = ?", (options.task,))}
    seeds = [s for s in range(options.episodes) if s % parts == part and s not in done]
    if options.workers == 0:
        for seed in seeds:
            keep(table, run_episode(options.task, seed))
    else:
        from dask.distributed import Client, LocalCluster, as_completed
        # Processes, not threads: each worker has an environment of its own. A unit of a killed
        # worker starts again on another one, up to three times.
        with LocalCluster(n_workers=options.workers, threads_per_worker=1, processes=True,
                          dashboard_address=None) as cluster, Client(cluster) as client:
            futures = [client.submit(run_episode, options.task, seed, retries=3, pure=False)
                       for seed in seeds]
            for _, row in as_completed(futures, with_results=True):
                keep(table, row)
    count, successes = table.execute("SELECT count(*), sum(success) FROM episodes").fetchone()
    print(f"{count} episodes, {successes or 0} successes in {options.out}")


if __name__ == "__main__":
    main()
