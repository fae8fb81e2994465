// Everything the map shows, one function each: (brush, replay, time). A brush is
// {ctx, camera, colours, calm}; lengths are metres, widths are pixels.

const WORLD_COLOURS = ['map', 'grid', 'grid-strong', 'wall', 'solid', 'solid-edge', 'cart',
  'cart-edge', 'accent', 'ink', 'muted', 'surface', 'fail', 'goal', 'ray',
  'speed-0', 'speed-1', 'speed-2', 'speed-3', 'speed-4'];
const SPEED_STEPS = 5;
const FLASH = 0.6; // [s] a contact is shown for

function tracePath(ctx, camera, points, close) {
  ctx.beginPath();
  points.forEach(([x, y], i) => {
    const [px, py] = camera.toScreen(x, y);
    if (i) ctx.lineTo(px, py);
    else ctx.moveTo(px, py);
  });
  if (close) ctx.closePath();
}

function drawGrid({ ctx, camera, colours }) {
  const step = [0.5, 1, 2, 5, 10, 20, 50].find((size) => size * camera.scale >= 34) || 100;
  const [x0, y1] = camera.toWorld(0, 0);
  const [x1, y0] = camera.toWorld(camera.width, camera.height);
  ctx.lineWidth = 1;
  const line = (ax, ay, bx, by, strong) => {
    ctx.strokeStyle = strong ? colours['grid-strong'] : colours.grid;
    ctx.beginPath();
    ctx.moveTo(Math.round(ax) + 0.5, Math.round(ay) + 0.5);
    ctx.lineTo(Math.round(bx) + 0.5, Math.round(by) + 0.5);
    ctx.stroke();
  };
  for (let i = Math.ceil(x0 / step); i * step <= x1; i += 1) {
    const [px] = camera.toScreen(i * step, 0);
    line(px, 0, px, camera.height, i === 0);
  }
  for (let i = Math.ceil(y0 / step); i * step <= y1; i += 1) {
    const [, py] = camera.toScreen(0, i * step);
    line(0, py, camera.width, py, i === 0);
  }
}

function drawScaleBar({ ctx, camera, colours }) {
  const length = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20].find((m) => m * camera.scale >= 44) || 50;
  const width = length * camera.scale;
  const [left, bottom] = [14.5, camera.height - 13.5];
  ctx.strokeStyle = colours.muted;
  ctx.lineWidth = 1.5;
  ctx.beginPath();
  ctx.moveTo(left, bottom - 5);
  ctx.lineTo(left, bottom);
  ctx.lineTo(left + width, bottom);
  ctx.lineTo(left + width, bottom - 5);
  ctx.stroke();
  ctx.fillStyle = colours.muted;
  ctx.font = '11px system-ui, sans-serif';
  ctx.textAlign = 'left';
  ctx.textBaseline = 'alphabetic';
  ctx.fillText(`${length} m`, left + 6, bottom - 5);
}

function drawWorld({ ctx, camera, colours }, replay) {
  ctx.lineJoin = 'round';
  ctx.lineCap = 'round';
  for (const polygon of replay.solids) {
    tracePath(ctx, camera, polygon, true);
    ctx.fillStyle = colours.solid;
    ctx.fill();
    ctx.strokeStyle = colours['solid-edge'];
    ctx.lineWidth = 1.5;
    ctx.stroke();
  }
  ctx.strokeStyle = colours.wall;
  ctx.lineWidth = clamp(0.05 * camera.scale, 2, 5);
  for (const wall of replay.walls) {
    tracePath(ctx, camera, wall, false);
    ctx.stroke();
  }
}

function drawCarts({ ctx, camera, colours }, replay, time) {
  for (const cart of replay.carts) {
    const pose = poseAt(cart.pose, time);
    if (!pose || cart.polygon.length < 3) continue;
    const [c, s] = [Math.cos(pose.yaw), Math.sin(pose.yaw)];
    const placed = cart.polygon.map(([x, y]) => [pose.x + c * x - s * y, pose.y + s * x + c * y]);
    tracePath(ctx, camera, placed, true);
    ctx.fillStyle = colours.cart;
    ctx.fill();
    ctx.strokeStyle = colours['cart-edge'];
    ctx.lineWidth = 2;
    ctx.stroke();
    tracePath(ctx, camera, [placed[0], placed[2 % placed.length]], false);
    ctx.lineWidth = 1;
    ctx.stroke();
  }
}

/** The way driven so far, darker where it was faster; the way to come as a hint. */
function drawTrail({ ctx, camera, colours }, replay, time) {
  const { truth, maxSpeed } = replay;
  const now = indexAt(truth.t, time);
  ctx.lineCap = 'round';
  ctx.lineJoin = 'round';
  const known = (i) => Number.isFinite(truth.x[i]) && Number.isFinite(truth.y[i]);
  const jumps = (i) => Math.hypot(truth.x[i + 1] - truth.x[i], truth.y[i + 1] - truth.y[i]) > 0.5;
  const strokeWhere = (from, to, chosen) => {
    ctx.beginPath();
    for (let i = from; i < to; i += 1) {
      if (!known(i) || !known(i + 1) || jumps(i) || !chosen(i)) continue;
      ctx.moveTo(...camera.toScreen(truth.x[i], truth.y[i]));
      ctx.lineTo(...camera.toScreen(truth.x[i + 1], truth.y[i + 1]));
    }
    ctx.stroke();
  };
  ctx.lineWidth = 1.5;
  ctx.strokeStyle = colours['grid-strong'];
  strokeWhere(Math.max(now, 0), truth.t.length - 1, () => true);
  ctx.lineWidth = 3.5;
  const bin = (v) => Math.min(SPEED_STEPS - 1, Math.floor((Math.abs(v) / maxSpeed) * SPEED_STEPS));
  for (let step = 0; step < SPEED_STEPS; step += 1) {
    ctx.strokeStyle = colours[`speed-${step}`];
    strokeWhere(0, now, (i) => bin(truth.v[i]) === step);
  }
  const pose = poseAt(truth, time);
  if (pose && now >= 0 && now < truth.t.length - 1 && known(now) && !jumps(now)) {
    ctx.strokeStyle = colours[`speed-${bin(truth.v[now]) || 0}`];
    tracePath(ctx, camera, [[truth.x[now], truth.y[now]], [pose.x, pose.y]], false);
    ctx.stroke();
  }
}

/** Crosses where the robot touched something, up to now. */
function drawContacts({ ctx, camera, colours }, replay, time) {
  for (const contact of replay.contacts) {
    const pose = contact.from <= time && poseAt(replay.truth, contact.from);
    if (!pose) continue;
    const [x, y] = camera.toScreen(pose.x, pose.y);
    ctx.strokeStyle = colours.fail;
    ctx.lineWidth = 2.5;
    ctx.beginPath();
    for (const [dx, dy] of [[5, 5], [5, -5]]) {
      ctx.moveTo(x - dx, y - dy);
      ctx.lineTo(x + dx, y + dy);
    }
    ctx.stroke();
  }
}

/** A diamond on the way where a check failed; the one shown now is filled. */
function drawMoments({ ctx, camera, colours }, replay, active) {
  for (const moment of replay.moments) {
    const pose = poseAt(replay.truth, moment.t);
    if (!pose) continue;
    const [x, y] = camera.toScreen(pose.x, pose.y);
    const size = moment === active ? 8 : 6;
    ctx.beginPath();
    ctx.moveTo(x, y - size);
    ctx.lineTo(x + size, y);
    ctx.lineTo(x, y + size);
    ctx.lineTo(x - size, y);
    ctx.closePath();
    ctx.fillStyle = moment === active ? colours.fail : colours.map;
    ctx.fill();
    ctx.strokeStyle = colours.fail;
    ctx.lineWidth = 2;
    ctx.stroke();
  }
}

/** The newest goal with the circle it is reached from; older ones small and faint. */
function drawGoals({ ctx, camera, colours }, replay, time) {
  const shown = replay.goals.filter((goal) => goal.t <= time
    && Number.isFinite(goal.x) && Number.isFinite(goal.y));
  shown.forEach((goal, i) => {
    const newest = i === shown.length - 1;
    const [x, y] = camera.toScreen(goal.x, goal.y);
    ctx.globalAlpha = newest ? 1 : 0.4;
    ctx.strokeStyle = colours.goal;
    ctx.fillStyle = colours.goal;
    ctx.lineWidth = 2;
    ctx.beginPath();
    ctx.arc(x, y, newest ? 4 : 3, 0, 2 * Math.PI);
    ctx.fill();
    if (newest) {
      ctx.setLineDash([5, 5]);
      ctx.beginPath();
      ctx.arc(x, y, GOAL_TOLERANCE * camera.scale, 0, 2 * Math.PI);
      ctx.stroke();
      ctx.globalAlpha = 0.07;
      ctx.fill();
      ctx.setLineDash([]);
    }
    ctx.globalAlpha = 1;
  });
}

/** Where the beams of the newest scan end on the map, seen from where it was taken; or null. */
function scanAt({ camera }, replay, time) {
  const { scans } = replay;
  const k = scans ? indexAt(scans.t, time) : -1;
  const pose = k < 0 ? null : poseAt(replay.truth, scans.stamp[k]);
  if (!pose) return null;
  const [c, s] = [Math.cos(pose.yaw), Math.sin(pose.yaw)];
  const ends = scans.directions.map(([dx, dy], i) => {
    const mm = scans.mm[k * scans.beams + i];
    const hit = mm > 0 && mm < MM_NAN;
    const free = mm === MM_PLUS_INF || mm === 0;
    if (!hit && !free) return mm === MM_MINUS_INF ? { near: true } : null;
    const range = hit ? mm / 1000 : scans.rangeMax;
    const x = pose.x + range * (c * dx - s * dy);
    const y = pose.y + range * (s * dx + c * dy);
    return { hit, at: camera.toScreen(x, y) };
  });
  return { centre: camera.toScreen(pose.x, pose.y), ends, allAround: scans.allAround };
}

/** A fan to each return; a fainter one where nothing came back. */
function drawFan({ ctx, colours }, scan) {
  fillFan(ctx, scan, (end) => end.hit, colours.accent, 0.12);
  fillFan(ctx, scan, (end) => end.at && !end.hit, colours.ray, 0.08);
}

/** Dots at the hits; a dotted ring where something is closer than the lidar can measure. */
function drawHits({ ctx, camera, colours }, scan, radius) {
  ctx.fillStyle = colours.accent;
  for (const end of scan.ends) {
    if (end && end.hit) ctx.fillRect(end.at[0] - 1.5, end.at[1] - 1.5, 3, 3);
  }
  if (scan.ends.some((end) => end && end.near)) {
    ring(ctx, scan.centre, (radius + 0.06) * camera.scale, colours.accent, 2, [2, 3]);
  }
}

function fillFan(ctx, { centre, ends, allAround }, chosen, colour, alpha) {
  ctx.beginPath();
  for (let i = 0; i < ends.length; i += 1) {
    const a = ends[i];
    const b = ends[(i + 1) % ends.length];
    if (i === ends.length - 1 && !allAround) continue;
    if (!a || !b || !chosen(a) || !chosen(b)) continue;
    ctx.moveTo(...centre);
    ctx.lineTo(...a.at);
    ctx.lineTo(...b.at);
    ctx.closePath();
  }
  ctx.globalAlpha = alpha;
  ctx.fillStyle = colour;
  ctx.fill();
  ctx.globalAlpha = 1;
}

function ring(ctx, [x, y], radius, colour, width, dash = []) {
  ctx.strokeStyle = colour;
  ctx.lineWidth = width;
  ctx.setLineDash(dash);
  ctx.beginPath();
  ctx.arc(x, y, radius, 0, 2 * Math.PI);
  ctx.stroke();
  ctx.setLineDash([]);
}

function drawRobot({ ctx, camera, colours, calm }, replay, time) {
  const pose = poseAt(replay.truth, time);
  if (!pose) return;
  const centre = camera.toScreen(pose.x, pose.y);
  const radius = Math.max(replay.radius * camera.scale, 6);
  const contact = replay.contacts.find(({ from, to }) => time >= from && time <= to + FLASH);
  ctx.beginPath();
  ctx.arc(...centre, radius, 0, 2 * Math.PI);
  ctx.fillStyle = contact ? colours.fail : colours.accent;
  ctx.fill();
  ctx.strokeStyle = colours.surface;
  ctx.lineWidth = 2;
  ctx.stroke();
  drawHeading(ctx, centre, pose.yaw, radius, colours.surface);
  if (contact) {
    const age = clamp((time - contact.to) / FLASH, 0, 1);
    ctx.globalAlpha = calm ? 1 : 1 - 0.8 * age;
    ring(ctx, centre, radius + 5 + (calm ? 0 : 14 * age), colours.fail, 3);
    ctx.globalAlpha = 1;
  }
}

const DASHES = [[], [5, 4], [2, 3], [9, 3, 2, 3]]; // of the first ghost, the second, …

/** Robots of other runs: outlines, a little wider than the robot, so that none hides it. */
function drawGhosts({ ctx, camera, colours }, replay, time) {
  replay.ghosts.forEach(({ pose: series }, i) => {
    const pose = poseAt(series, time);
    if (!pose) return;
    const centre = camera.toScreen(pose.x, pose.y);
    const radius = Math.max(replay.radius * camera.scale, 6) + 3;
    ring(ctx, centre, radius, colours.ink, 1.5, DASHES[i]);
    ctx.beginPath(); // where it looks
    for (const length of [0.5, 1.35]) ctx.lineTo(centre[0] + length * radius * Math.cos(pose.yaw), centre[1] - length * radius * Math.sin(pose.yaw));
    ctx.stroke();
  });
}

function drawHeading(ctx, [x, y], yaw, radius, colour) {
  const tip = (angle, length) => [x + length * Math.cos(yaw + angle), y - length * Math.sin(yaw + angle)];
  ctx.beginPath();
  ctx.moveTo(...tip(0, 0.72 * radius));
  ctx.lineTo(...tip(2.45, 0.55 * radius));
  ctx.lineTo(...tip(Math.PI, 0.22 * radius));
  ctx.lineTo(...tip(-2.45, 0.55 * radius));
  ctx.closePath();
  ctx.fillStyle = colour;
  ctx.fill();
}
