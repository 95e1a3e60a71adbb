"""How the fit to a dome improves with the number of facets, for a Miura pattern and an eggbox.

python -m studies.refinement
"""

from __future__ import annotations

import inverse

DOME = {"height": "sqrt(1 - x^2 - y^2)", "domain": [[-0.6, 0.6], [-0.6, 0.6]]}
FAMILIES = {"Miura": ("FL", "FL"), "eggbox": ("CFL", "FL")}
SIZES = (6, 8, 12, 16, 24)


def main() -> None:
    """Print a table."""
    print(f"{'facets':>9} " + " ".join(f"{family:>10}" for family in FAMILIES) + "   fit rms, % of the diagonal")
    for n in SIZES:
        cells = []
        for u_lines, v_lines in FAMILIES.values():
            pattern = {"size": [n, n], "u_lines": u_lines, "v_lines": v_lines}
            result = inverse.solve(inverse.load({"name": "study", "pattern": pattern, "target": DOME}))
            sound = result.certified and result.converged
            cells.append(f"{100 * result.report['fit']['rms_relative']:>10.4f}" if sound else f"{'failed':>10}")
        print(f"{n:>4} x {n:<2} " + " ".join(cells), flush=True)


if __name__ == "__main__":
    main()
