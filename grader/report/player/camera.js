// Which part of the world the map shows: metres to pixels and back, fit, zoom, pan.

const MIN_SCALE = 4; // [pixels/m]
const MAX_SCALE = 800;
const EMPTY_VIEW = 2; // [m] shown around a robot in an empty world

class Camera {
  constructor() {
    this.x = 0; // [m] in the middle of the map
    this.y = 0;
    this.scale = 60; // [pixels/m]
    this.width = 1; // [pixels]
    this.height = 1;
  }

  toScreen(x, y) {
    return [this.width / 2 + (x - this.x) * this.scale, this.height / 2 - (y - this.y) * this.scale];
  }

  toWorld(px, py) {
    return [this.x + (px - this.width / 2) / this.scale, this.y - (py - this.height / 2) / this.scale];
  }

  fit(bounds, padding = 28) {
    const width = Math.max(bounds.x1 - bounds.x0, 0.5);
    const height = Math.max(bounds.y1 - bounds.y0, 0.5);
    const room = (size) => Math.max(size - 2 * padding, 20);
    this.scale = clamp(Math.min(room(this.width) / width, room(this.height) / height), MIN_SCALE, 220);
    this.x = (bounds.x0 + bounds.x1) / 2;
    this.y = (bounds.y0 + bounds.y1) / 2;
  }

  /** Zoom so that the point under (px, py) stays where it is. */
  zoom(factor, px = this.width / 2, py = this.height / 2) {
    const [x, y] = this.toWorld(px, py);
    this.scale = clamp(this.scale * factor, MIN_SCALE, MAX_SCALE);
    const [nx, ny] = this.toWorld(px, py);
    this.x += x - nx;
    this.y += y - ny;
  }

  pan(dx, dy) {
    this.x -= dx / this.scale;
    this.y += dy / this.scale;
  }
}

/** Everything worth seeing in a replay: world, carts, the robot's way, goals. */
function boundsOf(replay) {
  const box = { x0: Infinity, y0: Infinity, x1: -Infinity, y1: -Infinity };
  const add = (x, y, margin = 0) => {
    if (!Number.isFinite(x) || !Number.isFinite(y)) return;
    box.x0 = Math.min(box.x0, x - margin);
    box.y0 = Math.min(box.y0, y - margin);
    box.x1 = Math.max(box.x1, x + margin);
    box.y1 = Math.max(box.y1, y + margin);
  };
  for (const points of [...replay.walls, ...replay.solids]) points.forEach(([x, y]) => add(x, y));
  const bare = !Number.isFinite(box.x0);
  replay.truth.t.forEach((_, i) => {
    add(replay.truth.x[i], replay.truth.y[i], bare ? EMPTY_VIEW : 3 * replay.radius);
  });
  for (const { pose } of replay.carts) pose.t.forEach((_, i) => add(pose.x[i], pose.y[i], 0.5));
  for (const { pose } of replay.ghosts) pose.t.forEach((_, i) => add(pose.x[i], pose.y[i], 3 * replay.radius));
  for (const goal of replay.goals) add(goal.x, goal.y, GOAL_TOLERANCE);
  if (!Number.isFinite(box.x0)) add(0, 0, EMPTY_VIEW);
  return box;
}
