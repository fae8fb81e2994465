// Two lanes over time: commanded against actual speed, and clearance. The cursor is the replay's.

const PLOT_COLOURS = ['surface', 'grid', 'grid-strong', 'ink', 'muted', 'accent', 'fail', 'command',
  'clearance', 'cursor'];
const GUTTER = 44; // [pixels] for the numbers at the left; the timeline has the same (--gutter)
const RIGHT = 12;
const LANE_TOP = 24; // [pixels] for a lane's title
const LANE_GAP = 14;
const LOW = 120; // [pixels] of a plot with room for the speeds only
const AXIS = 20;

class Plot {
  constructor(canvas, onseek) {
    this.canvas = canvas;
    this.still = document.createElement('canvas'); // everything but the cursor
    this.angular = false;
    const seek = (event) => onseek(this.timeAt(event.offsetX));
    canvas.addEventListener('pointerdown', (event) => {
      canvas.setPointerCapture(event.pointerId);
      seek(event);
    });
    canvas.addEventListener('pointermove', (event) => {
      if (canvas.hasPointerCapture(event.pointerId)) seek(event);
    });
  }

  setReplay(replay) {
    this.replay = replay;
    this.resize();
  }

  setAngular(angular) {
    this.angular = angular;
    this.drawStill();
  }

  readTheme() {
    this.colours = readColours(this.canvas.parentElement, PLOT_COLOURS);
    this.drawStill();
  }

  resize() {
    Object.assign(this, sizeCanvas(this.canvas));
    this.drawStill();
  }

  get span() {
    return Math.max(this.replay.duration, 1e-3);
  }

  xOf(t) {
    return GUTTER + (t / this.span) * (this.width - GUTTER - RIGHT);
  }

  timeAt(px) {
    return ((px - GUTTER) / Math.max(1, this.width - GUTTER - RIGHT)) * this.span;
  }

  // --- drawing ------------------------------------------------------------------------------

  draw(time) {
    if (!this.replay || !this.colours) return;
    const ctx = this.canvas.getContext('2d');
    ctx.save();
    ctx.setTransform(1, 0, 0, 1, 0, 0);
    ctx.drawImage(this.still, 0, 0);
    ctx.restore();
    const x = this.xOf(time);
    ctx.strokeStyle = this.colours.cursor;
    ctx.lineWidth = 1.5;
    ctx.beginPath();
    ctx.moveTo(x, 4);
    ctx.lineTo(x, this.height - AXIS + 4);
    ctx.stroke();
  }

  drawStill() {
    if (!this.replay || !this.colours || !(this.width > GUTTER + RIGHT + 20)) return;
    const { canvas, still, colours, replay } = this;
    still.width = canvas.width;
    still.height = canvas.height;
    const ctx = still.getContext('2d');
    const ratio = canvas.width / this.width;
    ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
    ctx.fillStyle = colours.surface;
    ctx.fillRect(0, 0, this.width, this.height);
    const room = this.height - AXIS - LANE_GAP - 2 * LANE_TOP;
    const isLow = this.height < LOW;
    const upper = { top: LANE_TOP, height: isLow ? this.height - AXIS - LANE_TOP : 0.6 * room };
    const lower = { top: 2 * LANE_TOP + LANE_GAP + upper.height, height: 0.4 * room };
    this.drawTimeAxis(ctx);
    this.shadeContacts(ctx);
    this.drawSpeeds(ctx, upper);
    if (!isLow) this.drawClearance(ctx, lower);
    for (const moment of replay.moments) this.drawMoment(ctx, moment);
  }

  drawSpeeds(ctx, lane) {
    const { truth, commands } = this.replay;
    const [actual, commanded, unit] = this.angular
      ? [truth.w, commands.w, 'rad/s'] : [truth.v, commands.v, 'm/s'];
    const axis = axisOf([...actual, ...commanded], 0.1);
    this.drawLane(ctx, lane, axis, [
      { name: 'actual', colour: this.colours.accent },
      { name: 'commanded', colour: this.colours.command, width: 5, alpha: 0.45 },
    ], this.angular ? `turning, ${unit}` : `speed, ${unit}`);
    // A broad pale line under a thin one: both show where they agree.
    this.line(ctx, lane, axis, commands.t, commanded,
      { colour: this.colours.command, width: 5, alpha: 0.45, steps: true });
    this.line(ctx, lane, axis, truth.t, actual, { colour: this.colours.accent, width: 1.75 });
  }

  drawClearance(ctx, lane) {
    const { truth } = this.replay;
    const axis = axisOf(truth.clearance.map((d) => Math.min(d, 3)), 0.5);
    this.drawLane(ctx, lane, axis, [], 'clearance, m');
    this.line(ctx, lane, axis, truth.t, truth.clearance, { colour: this.colours.clearance, width: 2, area: true });
  }

  drawLane(ctx, { top, height }, axis, keys, title) {
    const { colours } = this;
    ctx.font = '11px system-ui, sans-serif';
    ctx.textBaseline = 'middle';
    ctx.textAlign = 'right';
    ctx.lineWidth = 1;
    for (const value of axis.ticks) {
      const y = Math.round(yOf({ top, height }, axis, value)) + 0.5;
      ctx.strokeStyle = value === 0 ? colours['grid-strong'] : colours.grid;
      ctx.beginPath();
      ctx.moveTo(GUTTER, y);
      ctx.lineTo(this.width - RIGHT, y);
      ctx.stroke();
      ctx.fillStyle = colours.muted;
      ctx.fillText(fixed(value, axis.digits), GUTTER - 8, y);
    }
    ctx.textAlign = 'left';
    ctx.fillStyle = colours.ink;
    ctx.font = '600 11px system-ui, sans-serif';
    ctx.fillText(title, GUTTER, top - 13);
    this.drawKeys(ctx, top - 13, GUTTER + ctx.measureText(title).width + 20, keys);
  }

  drawKeys(ctx, y, left, keys) {
    ctx.font = '11px system-ui, sans-serif';
    let x = left;
    for (const { name, colour, width = 2, alpha = 1 } of keys) {
      ctx.strokeStyle = colour;
      ctx.lineWidth = width;
      ctx.globalAlpha = alpha;
      ctx.beginPath();
      ctx.moveTo(x, y);
      ctx.lineTo(x + 18, y);
      ctx.stroke();
      ctx.globalAlpha = 1;
      ctx.fillStyle = this.colours.muted;
      ctx.fillText(name, x + 24, y);
      x += 24 + ctx.measureText(name).width + 16;
    }
  }

  line(ctx, lane, axis, times, values, { colour, width, alpha = 1, steps = false, area = false }) {
    ctx.save();
    ctx.beginPath();
    ctx.rect(GUTTER, lane.top - 2, this.width - GUTTER - RIGHT, lane.height + 4);
    ctx.clip();
    ctx.strokeStyle = colour;
    ctx.lineWidth = width;
    ctx.lineJoin = 'round';
    for (const run of runsOf(times, values)) {
      const points = run.map(([t, v]) => [this.xOf(t), yOf(lane, axis, v)]);
      const last = run[run.length - 1][0];
      const next = steps ? times.find((t) => t > last) ?? this.span : last; // a NaN ends a step
      const end = this.xOf(next);
      ctx.globalAlpha = alpha;
      tracePlot(ctx, points, steps, end);
      ctx.stroke();
      if (!area) continue;
      ctx.lineTo(end, lane.top + lane.height);
      ctx.lineTo(points[0][0], lane.top + lane.height);
      ctx.globalAlpha = 0.12;
      ctx.fillStyle = colour;
      ctx.fill();
      ctx.globalAlpha = 1;
    }
    ctx.restore();
  }

  drawTimeAxis(ctx) {
    const { colours } = this;
    const step = niceStep(this.span / Math.max(2, (this.width - GUTTER) / 90));
    const digits = step < 0.1 ? 2 : step < 1 ? 1 : 0;
    ctx.font = '11px system-ui, sans-serif';
    ctx.textBaseline = 'alphabetic';
    for (let i = 0; i * step <= this.span + 1e-9; i += 1) {
      const x = Math.round(this.xOf(i * step)) + 0.5;
      ctx.strokeStyle = colours.grid;
      ctx.beginPath();
      ctx.moveTo(x, LANE_TOP);
      ctx.lineTo(x, this.height - AXIS + 4);
      ctx.stroke();
      ctx.fillStyle = colours.muted;
      ctx.textAlign = this.width - x < 24 ? 'right' : 'center';
      ctx.fillText(`${fixed(i * step, digits)}\u00a0s`, x, this.height - 3);
    }
  }

  shadeContacts(ctx) {
    ctx.fillStyle = this.colours.fail;
    ctx.globalAlpha = 0.14;
    for (const { from, to } of this.replay.contacts) {
      const x = this.xOf(from);
      ctx.fillRect(x, LANE_TOP, Math.max(2, this.xOf(to) - x), this.height - AXIS - LANE_TOP);
    }
    ctx.globalAlpha = 1;
  }

  drawMoment(ctx, moment) {
    const x = Math.round(this.xOf(moment.t)) + 0.5;
    ctx.strokeStyle = this.colours.fail;
    ctx.lineWidth = 1;
    ctx.setLineDash([2, 3]);
    ctx.beginPath();
    ctx.moveTo(x, LANE_TOP);
    ctx.lineTo(x, this.height - AXIS);
    ctx.stroke();
    ctx.setLineDash([]);
  }
}

function yOf({ top, height }, axis, value) {
  return top + height * (1 - (value - axis.low) / (axis.high - axis.low));
}

/** Stretches of [t, value] without a NaN in them. */
function runsOf(times, values) {
  const runs = [];
  let run = null;
  times.forEach((t, i) => {
    if (!Number.isFinite(values[i])) {
      run = null;
      return;
    }
    if (!run) runs.push((run = []));
    run.push([t, values[i]]);
  });
  return runs;
}

function tracePlot(ctx, points, steps, end) {
  ctx.beginPath();
  points.forEach(([x, y], i) => {
    if (!i) ctx.moveTo(x, y);
    else if (steps) ctx.lineTo(x, points[i - 1][1]);
    if (i) ctx.lineTo(x, y);
  });
  if (steps) ctx.lineTo(end, points[points.length - 1][1]);
}

function niceStep(rough) {
  const power = 10 ** Math.floor(Math.log10(Math.max(rough, 1e-6)));
  return [1, 2, 5, 10].map((n) => n * power).find((step) => step >= rough - 1e-12);
}

/** A vertical axis around 0 with two to five ticks. */
function axisOf(values, least) {
  let [low, high] = [0, least];
  for (const value of values) {
    if (!Number.isFinite(value)) continue;
    low = Math.min(low, value);
    high = Math.max(high, value);
  }
  const step = niceStep((high - low) / 3);
  low = Math.floor(low / step + 1e-9) * step;
  high = Math.ceil(high / step - 1e-9) * step;
  const ticks = [];
  for (let i = 0; i <= Math.round((high - low) / step); i += 1) ticks.push(low + i * step);
  const tidy = ticks.map((tick) => (Math.abs(tick) < step / 1000 ? 0 : tick));
  return { low, high, ticks: tidy, digits: step >= 1 ? 0 : step >= 0.1 ? 1 : 2 };
}
