"""A specification with something of everything."""

TEXT = """\
name: vault
units: m
pattern:
  kind: grid
  size: [16, 24]
  u_lines: FL
  v_lines: FL
  sector_angle: 60
target: {height: "0.45 - 0.3*(x^2 + y^2)", domain: [[-1, 1], [-1, 1]]}
fit: {points: facets}
objectives: {fit: 1.0, fairness: 1.0e-4, footprint: 0}
constraints:
  fold_angle: [20, 160]
  anchors:
    - {side: u0, every: 2, to: {polyline: [[0, 0, 0], [1, 0, 0]]}}
    - {vertices: [0, 3], to: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}
  keep_out: [{below: 2.4}]
solver: {method: ipopt, tolerance: 1.0e-9}
"""
