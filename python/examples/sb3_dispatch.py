"""Trains a dispatcher with MaskablePPO of sb3-contrib, and plays a game with it.

    python sb3_dispatch.py [STEPS]

Needs sb3-contrib (which needs torch) and cxlab[learn]. Without STEPS it takes 20,000.
"""

import sys

import gymnasium
from sb3_contrib import MaskablePPO

import cxlab.learn  # noqa: F401  registers the environments

env = gymnasium.make("cxlab/RCLLDispatch-v0", journal="decisions")
model = MaskablePPO("MlpPolicy", env, n_steps=512, batch_size=256, gamma=0.999, seed=1, verbose=1)
model.learn(int(sys.argv[1]) if len(sys.argv) > 1 else 20_000)

seen, info = env.reset(seed=30001)
over, forbidden = False, 0
while not over:
    action, _ = model.predict(seen, action_masks=info["action_mask"], deterministic=True)
    seen, _, terminated, truncated, info = env.step(action)
    forbidden += "invalid" in info
    over = terminated or truncated
print(f"seed 30001: {info['points']} points, {forbidden} choices forbidden")
env.close()
