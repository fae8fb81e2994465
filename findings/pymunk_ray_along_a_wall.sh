#!/usr/bin/env bash
# Guess: a ray that runs along a thin wall, through its whole length, hits it; and of a hit `point`
#        lies at the part `alpha` of the ray.
# Seen:  along a segment of radius 0 the ray hits nothing at all; a thousandth beside it, it does. With
#        a ray of some radius, `alpha` is where the ray's round head touches, `point` is on the wall:
#        a lidar that multiplies alpha by its range reads the radius too little.
# With:  pymunk 7.3.1, 2026-11-28
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" --quiet install pymunk==7.3.1
"$work/venv/bin/python" - > "$work/seen" <<'PY'
import pymunk

space, every = pymunk.Space(), pymunk.ShapeFilter()
space.add(pymunk.Segment(space.static_body, (10, 0), (10, 5), 0.0))
print("along:", space.segment_query_first((10, -1), (10, 6), 0.0, every))
across = space.segment_query_first((9.999, -1), (10.001, 6), 0.0, every)
print("almost along:", across is not None)
for radius in (0.0, 0.25):
    hit = space.segment_query_first((9, 2), (11, 2), radius, every)
    print(f"radius {radius}: alpha {hit.alpha}, point at {(hit.point.x - 9) / 2}")
PY
diff "$work/seen" - <<'SEEN' && echo "as it was"
along: None
almost along: True
radius 0.0: alpha 0.5, point at 0.5
radius 0.25: alpha 0.375, point at 0.5
SEEN
