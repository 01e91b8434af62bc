"""Gymnasium for agents in rules: Python trains them over the interfaces of CX (docs/how-to/train-over-cx-rl.md).

    >>> from cxlab.rl import CXEnv
    >>> env = CXEnv("docs/examples/rl/example.yaml", packages={"example": "docs/examples/rl"})
    >>> observation, info = env.reset(seed=1)
    >>> observation, reward, terminated, truncated, info = env.step(env.action_masks().nonzero()[0][0])

It needs Gymnasium and NumPy: `pip install cxlab[learn]`.
"""

from cxlab.rl.env import CXEnv

__all__ = ["CXEnv"]
