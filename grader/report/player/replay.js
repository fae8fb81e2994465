// A replay from the payload, made safe: numbers are numbers (NaN for null), arrays are equally long.

const MM_PLUS_INF = 65535;
const MM_MINUS_INF = 65534;
const MM_NAN = 65533;
const GOAL_TOLERANCE = 0.5; // [m] a goal counts as reached from here on

const toNumber = (value) => (typeof value === 'number' ? value : NaN);
const toArray = (value) => (Array.isArray(value) ? value : []);
const toNumbers = (value) => Float64Array.from(toArray(value), toNumber);

/** Columns of equal length, without the rows whose time is not a number. */
function toSeries(raw, names) {
  const source = raw || {};
  const t = toNumbers(source.t);
  const columns = names.map((name) => toNumbers(source[name]));
  const rows = Array.from(t.keys()).filter((i) => Number.isFinite(t[i]));
  const series = { t: Float64Array.from(rows, (i) => t[i]) };
  names.forEach((name, k) => {
    series[name] = Float64Array.from(rows, (i) => (i < columns[k].length ? columns[k][i] : NaN));
  });
  return series;
}

function toPolygon(raw) {
  return toArray(raw)
    .map((point) => toArray(point).map(toNumber))
    .filter((point) => Number.isFinite(point[0]) && Number.isFinite(point[1]));
}

const toPolygons = (raw) => toArray(raw).map(toPolygon).filter((points) => points.length > 1);

function decodeMillimetres(base64) {
  try {
    const bytes = atob(text(base64));
    const mm = new Uint16Array(bytes.length >> 1);
    for (let i = 0; i < mm.length; i += 1) {
      mm[i] = bytes.charCodeAt(2 * i) | (bytes.charCodeAt(2 * i + 1) << 8);
    }
    return mm;
  } catch {
    return new Uint16Array(0);
  }
}

function toScans(raw) {
  const beams = raw && Math.floor(toNumber(raw.beams));
  if (!(beams > 0)) return null;
  const mm = decodeMillimetres(raw.mm);
  const t = toNumbers(raw.t);
  const count = Math.min(t.length, Math.floor(mm.length / beams));
  if (!count) return null;
  const stamps = toNumbers(raw.stamp);
  const stamp = t.map((time, i) => (Number.isFinite(stamps[i]) ? stamps[i] : time));
  const directions = Array.from({ length: beams }, (_, i) => {
    const angle = toNumber(raw.angle_min) + i * toNumber(raw.angle_increment);
    return [Math.cos(angle), Math.sin(angle)];
  });
  const increment = Math.abs(toNumber(raw.angle_increment));
  return {
    t: t.slice(0, count), stamp, beams, mm, directions,
    rangeMax: toNumber(raw.range_max) || 0,
    allAround: (beams + 1) * increment > 2 * Math.PI, // the last beam is the first one's neighbour
  };
}

function toMoment(raw) {
  return {
    t: toNumber(raw.t), check: text(raw.check), title: text(raw.title),
    outcome: text(raw.outcome) || 'fail', message: text(raw.message),
    expected: text(raw.expected), actual: text(raw.actual), help: text(raw.help),
  };
}

/** Failing moments in order of time, within the run. */
function toMoments(raw, duration) {
  return toArray(raw).map((moment) => toMoment(moment || {}))
    .filter((moment) => Number.isFinite(moment.t))
    .map((moment) => ({ ...moment, t: clamp(moment.t, 0, duration) }))
    .sort((a, b) => a.t - b.t);
}

function toCart(raw) {
  return { polygon: toPolygon(raw.polygon), pose: toSeries(raw, ['x', 'y', 'yaw']) };
}

/** Contacts as intervals {from, to}, from the samples of the truth. */
function contactsOf(truth) {
  const contacts = [];
  for (let i = 0; i < truth.t.length; i += 1) {
    if (!(truth.contact[i] > 0)) continue;
    const last = contacts[contacts.length - 1];
    if (last && truth.t[i] - last.to < 0.3) last.to = truth.t[i];
    else contacts.push({ from: truth.t[i], to: truth.t[i] });
  }
  return contacts;
}

function durationOf(raw, truth, commands) {
  const stated = toNumber(raw.duration);
  const last = Math.max(0, truth.t[truth.t.length - 1] || 0, commands.t[commands.t.length - 1] || 0);
  return Number.isFinite(stated) && stated > 0 ? stated : last;
}

function toReplay(source) {
  const raw = source || {};
  const truth = toSeries(raw.truth, ['x', 'y', 'yaw', 'v', 'w', 'clearance', 'contact']);
  const commands = toSeries(raw.commands, ['v', 'w']);
  const duration = durationOf(raw, truth, commands);
  const inTime = (item) => Number.isFinite(item.t);
  const outcome = raw.outcome || {};
  return {
    scenario: text(raw.scenario),
    title: text(raw.title) || text(raw.scenario) || 'Run',
    description: text(raw.description),
    bench: raw.bench === true,
    seed: raw.seed,
    duration, truth, commands,
    radius: toNumber(raw.robot && raw.robot.radius) || 0.17,
    walls: toPolygons(raw.world && raw.world.walls),
    solids: toPolygons(raw.world && raw.world.solids),
    carts: toArray(raw.carts).map((cart) => toCart(cart || {})),
    scans: toScans(raw.scans),
    goals: toArray(raw.goals).map((goal) => (
      { t: toNumber(goal.t), x: toNumber(goal.x), y: toNumber(goal.y) })).filter(inTime),
    deeds: toArray(raw.deeds).map((deed) => ({ t: toNumber(deed.t), text: text(deed.text) })).filter(inTime),
    ghosts: toArray(raw.ghosts).slice(0, 4).map((ghost) => (
      { name: text(ghost && ghost.name).slice(0, 40), pose: toSeries(ghost, ['x', 'y', 'yaw']) })),
    log: toArray(raw.log).map((line) => (
      { t: toNumber(line.t), level: text(line.level).toLowerCase(), text: text(line.text) })),
    compute: toArray(raw.compute).map(text),
    outcome: { kind: text(outcome.kind), text: text(outcome.text), at: toNumber(outcome.at),
      detail: text(outcome.detail) },
    moments: toMoments(raw.moments, duration),
    contacts: contactsOf(truth),
    maxSpeed: truth.v.reduce((most, v) => (Math.abs(v) > most ? Math.abs(v) : most), 0.1),
  };
}

/** Index of the last time <= t, or -1. */
function indexAt(times, t) {
  let low = 0;
  let high = times.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t + 1e-9) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

const wrapAngle = (angle) => Math.atan2(Math.sin(angle), Math.cos(angle));

/** Pose {x, y, yaw} between the samples, or null where the truth knows none. */
function poseAt(series, t) {
  const last = series.t.length - 1;
  if (last < 0) return null;
  const i = clamp(indexAt(series.t, t), 0, last);
  const j = Math.min(i + 1, last);
  const span = series.t[j] - series.t[i];
  const part = span > 0 ? clamp((t - series.t[i]) / span, 0, 1) : 0;
  const between = (column) => column[i] + (part > 0 ? part * (column[j] - column[i]) : 0);
  const turn = part > 0 ? part * wrapAngle(series.yaw[j] - series.yaw[i]) : 0;
  const pose = { x: between(series.x), y: between(series.y), yaw: series.yaw[i] + turn };
  if (!Number.isFinite(pose.x) || !Number.isFinite(pose.y)) return null;
  if (!Number.isFinite(pose.yaw)) pose.yaw = 0;
  return pose;
}

/** What the robot does at t: speeds, clearance, the command in force and whether it touches. */
function stateAt(replay, t) {
  const { truth, commands } = replay;
  const i = indexAt(truth.t, t);
  const c = indexAt(commands.t, t);
  return {
    pose: poseAt(truth, t),
    v: i < 0 ? NaN : truth.v[i],
    w: i < 0 ? NaN : truth.w[i],
    clearance: i < 0 ? NaN : truth.clearance[i],
    commandV: c < 0 ? NaN : commands.v[c],
    commandW: c < 0 ? NaN : commands.w[c],
    touching: i >= 0 && truth.contact[i] > 0,
  };
}

/** Times a step moves between: the scans, else the commands, else every 0.1 s. */
function stepTimes(replay) {
  if (replay.scans) return replay.scans.t;
  if (replay.commands.t.length) return replay.commands.t;
  return Float64Array.from({ length: Math.floor(replay.duration * 10) + 1 }, (_, i) => i / 10);
}
