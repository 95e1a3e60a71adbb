"""A named tube section: twice as wide as high."""

from pathlib import Path

import inverse

# Steps (n, a, length) around: exactly one sign flips from step to step, at n a fold, at a an elbow.
inverse.section("rectangle", [(1, 1, 2), (1, -1, 1), (-1, -1, 2), (-1, 1, 1)])

if __name__ == "__main__":
    result = inverse.solve(inverse.load(Path(__file__).with_name("pipe.yaml"), ["pattern.section=rectangle"]))
    print(f"{result.status}: rms {result.report['fit']['rms_relative']:.4%} of the diagonal")
    assert result.certified
    assert result.converged
