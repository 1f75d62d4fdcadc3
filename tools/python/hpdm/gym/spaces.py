"""Spaces of actions and observations, with gymnasium's calls."""

import numpy as np


class Box:
    """Arrays of one shape and type between two bounds.

    Args:
        low, high: bounds, numbers or arrays of the shape.
    """

    def __init__(self, low, high, shape, dtype=np.float32, seed=None):
        self.shape = tuple(shape)
        self.dtype = np.dtype(dtype)
        self.low = np.broadcast_to(np.asarray(low, self.dtype), self.shape)
        self.high = np.broadcast_to(np.asarray(high, self.dtype), self.shape)
        self.seed(seed)

    def seed(self, seed=None):
        """Seeds sample()."""
        self._random = np.random.default_rng(seed)

    def sample(self):
        """Returns a random member; unbounded values are normally distributed."""
        if self.dtype.kind in "iu":
            return self._random.integers(self.low, self.high, endpoint=True, dtype=self.dtype)
        bounded = np.isfinite(self.low) & np.isfinite(self.high)
        low, high = np.where(bounded, self.low, 0), np.where(bounded, self.high, 0)
        values = np.where(bounded, self._random.uniform(low, high),
                          self._random.standard_normal(self.shape))
        return values.astype(self.dtype)

    def contains(self, value):
        """True for an array of this shape and type within the bounds, without NaN."""
        return (isinstance(value, np.ndarray) and value.shape == self.shape
                and value.dtype == self.dtype and bool(np.all(value >= self.low))
                and bool(np.all(value <= self.high)))

    def __contains__(self, value):
        return self.contains(value)

    def __repr__(self):
        return f"Box({self.low.min()}, {self.high.max()}, {self.shape}, {self.dtype})"


class Dict:
    """Several spaces by name."""

    def __init__(self, spaces):
        self.spaces = dict(spaces)

    def seed(self, seed=None):
        """Seeds all of them."""
        for space in self.spaces.values():
            space.seed(seed)

    def sample(self):
        """Returns a random member of each."""
        return {name: space.sample() for name, space in self.spaces.items()}

    def contains(self, value):
        """True for a dict of members with these names."""
        return (isinstance(value, dict) and value.keys() == self.spaces.keys()
                and all(space.contains(value[name]) for name, space in self.spaces.items()))

    def __contains__(self, value):
        return self.contains(value)

    def __getitem__(self, name):
        return self.spaces[name]

    def __repr__(self):
        return f"Dict({self.spaces})"
