"""Trains the robot of docs/examples/rl, an agent in rules, with a table of values: python blocks_q_learning.py FOLDER

The same as `cxlab env` with the node cx_rl_node, but Python chooses. FOLDER is docs/examples/rl of cxlab.
"""

import sys
from collections import defaultdict

import numpy as np

from cxlab.rl import CXEnv


def train(env, episodes=60, seed=1, learning_rate=0.5, gamma=0.95, exploration=0.3, decay=0.95):
    """Q-learning over the actions that the mask allows; how many steps each episode took."""
    chance = np.random.default_rng(seed)
    values = defaultdict(float)
    lengths = []
    observation, info = env.reset(seed=seed)
    for episode in range(episodes):
        steps, over = 0, False
        while not over:
            state, allowed = observation.tobytes(), info["action_mask"].nonzero()[0]
            if chance.random() < exploration * decay**episode:
                action = chance.choice(allowed)
            else:
                action = max(allowed, key=lambda a: values[state, a])
            observation, reward, terminated, truncated, info = env.step(action)
            next_allowed = info["action_mask"].nonzero()[0]
            best = max((values[observation.tobytes(), a] for a in next_allowed), default=0.0)
            values[state, action] += learning_rate * (reward + gamma * best - values[state, action])
            steps, over = steps + 1, terminated or truncated
        lengths.append(steps)
        observation, info = env.reset()
    return lengths


if __name__ == "__main__":
    folder = sys.argv[1]
    env = CXEnv(f"{folder}/example.yaml", packages={"example": folder})
    for number, steps in enumerate(train(env), start=1):
        print(f"episode {number}: {steps} steps")
    env.close()
