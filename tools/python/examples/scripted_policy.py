"""Solves the task Reach with a policy of one line, and prints each episode.

Usage: scripted_policy.py [EPISODES]
"""

import sys

import numpy as np

import hpdm.gym

env = hpdm.gym.make("Reach")
successes = 0
episodes = int(sys.argv[1]) if len(sys.argv) > 1 else 5
for episode in range(episodes):
    state, info = env.reset(seed=episode, options={"pose": 0.005, "delay": (0, 2)})
    total, ended = 0.0, False
    while not ended:
        tip, target = state[:3], state[-3:]
        action = np.zeros(4, np.float32)
        action[:3] = np.clip((target - tip) / 0.02, -1, 1)   # full speed from 20 mm on
        state, reward, terminated, truncated, step = env.step(action)
        total += reward
        ended = terminated or truncated
    successes += step["successful_task"]
    print(f"episode {episode}: delay {info['draws']['delay']} steps, reward {total:6.2f}, "
          f"{'reached' if step['successful_task'] else 'not reached'} after {env.task.steps} steps")
assert successes == episodes
