// The run in words: what happened when, for those who can't see the map and for everybody else.

const STANDING = 0.01; // [m/s] and below is standing still
const TURNING = 0.05; // [rad/s]
const SHORTEST_STOP = 0.3; // [s]
const MOST_STOPS = 8; // then they are summed up

const place = (pose) => `(${fixed(pose.x)}, ${fixed(pose.y)})`;

/** Events {t, kind, text} of a replay in order of time. */
function accountOf(replay) {
  const events = [
    ...startEvents(replay), ...commandEvents(replay), ...stopEvents(replay), ...closestEvent(replay),
    ...contactEvents(replay), ...goalEvents(replay), ...deedEvents(replay), ...momentEvents(replay),
  ].sort((a, b) => a.t - b.t);
  return [...events, endEvent(replay), ...computeEvents(replay)];
}

/** What computing cost: of the whole run, so it comes last. */
function computeEvents({ compute, duration }) {
  return compute.map((text) => ({ t: duration, kind: 'compute', text: `${text}.` }));
}

function startEvents(replay) {
  const pose = poseAt(replay.truth, 0);
  const where = pose ? `The robot starts at ${place(pose)}, heading ${degrees(pose.yaw)}`
    : 'The run starts; the position of the robot is not known';
  const names = replay.ghosts.map(({ name }) => name).join(', ');
  const beside = names ? ` Outlines show other runs beside it: ${names}.` : '';
  return [{ t: 0, kind: 'start', text: `${where}.${beside}` }];
}

function commandEvents({ commands, duration }) {
  if (!commands.t.length) {
    return [{ t: duration, kind: 'stop', text: 'The node never sent a command on /cmd_vel.' }];
  }
  const first = `First command: ${withUnit(commands.v[0], 'm/s')}, turning ${withUnit(commands.w[0], 'rad/s')}`;
  return [{ t: commands.t[0], kind: 'command',
    text: `${first}; ${plural(commands.t.length, 'command')} in all.` }];
}

/** Times when the robot came to rest after it had moved. */
function stopEvents({ truth }) {
  const stops = [];
  let moved = false;
  let since = null;
  truth.t.forEach((t, i) => {
    const still = Math.abs(truth.v[i]) <= STANDING && !(Math.abs(truth.w[i]) > TURNING);
    if (!still) {
      if (since !== null && t - since < SHORTEST_STOP) stops.pop();
      [moved, since] = [true, null];
    } else if (moved && since === null) {
      since = t;
      const pose = poseAt(truth, t);
      const where = pose ? ` at ${place(pose)}` : '';
      stops.push({ t, kind: 'stop', text: `The robot comes to rest${where}${gapText(truth.clearance[i])}.` });
    }
  });
  if (stops.length <= MOST_STOPS) return stops;
  const more = stops.length - MOST_STOPS;
  const rest = { t: stops[MOST_STOPS].t, kind: 'stop', text: `It comes to rest ${plural(more, 'more time')} from here on.` };
  return [...stops.slice(0, MOST_STOPS), rest];
}

const gapText = (clearance) => (Number.isFinite(clearance) && clearance < 10
  ? `, ${fixed(clearance)} m from the nearest thing` : '');

function closestEvent({ truth }) {
  let closest = -1;
  truth.clearance.forEach((d, i) => {
    if (Number.isFinite(d) && (closest < 0 || d < truth.clearance[closest])) closest = i;
  });
  if (closest < 0 || truth.clearance[closest] >= 10) return [];
  const gap = truth.clearance[closest];
  if (gap <= 0) return [];
  return [{ t: truth.t[closest], kind: 'closest', text: `Closest approach: ${fixed(gap)} m from the nearest thing.` }];
}

function contactEvents({ contacts, truth }) {
  return contacts.slice(0, 20).map(({ from, to }) => {
    const pose = poseAt(truth, from);
    const where = pose ? ` at ${place(pose)}` : '';
    const until = to - from > 0.1 ? `, until ${seconds(to)}` : '';
    return { t: from, kind: 'contact', text: `Contact: the robot touches something${where}${until}.` };
  });
}

function goalEvents({ goals, truth, duration }) {
  return goals.flatMap((goal, i) => {
    const until = i + 1 < goals.length ? goals[i + 1].t : duration;
    const known = Number.isFinite(goal.x) && Number.isFinite(goal.y);
    const given = { t: goal.t, kind: 'goal',
      text: known ? `New goal ${place(goal)}.` : 'New goal with a position that is not a number.' };
    const reached = known ? truth.t.findIndex((t, k) => t >= goal.t && t <= until
      && Math.hypot(truth.x[k] - goal.x, truth.y[k] - goal.y) <= GOAL_TOLERANCE) : -1;
    if (reached < 0) return [given];
    return [given, { t: truth.t[reached], kind: 'goal',
      text: `The robot is within ${fixed(GOAL_TOLERANCE, 1)} m of the goal ${place(goal)}.` }];
  });
}

/** What somebody did to the node, and what it answered. */
function deedEvents({ deeds }) {
  return deeds.map(({ t, text: done }) => ({ t, kind: 'deed', text: `By hand: ${done}.` }));
}

function momentEvents({ moments }) {
  return moments.map((moment) => {
    const told = moment.expected || moment.actual
      ? ` Expected: ${moment.expected || 'not stated'}. Actual: ${moment.actual || 'not stated'}.` : '';
    return { t: moment.t, kind: 'fail', moment, text: `Check failed: ${moment.title}${told}` };
  });
}

function endEvent(replay) {
  const { outcome, duration, truth } = replay;
  const at = Number.isFinite(outcome.at) ? clamp(outcome.at, 0, duration) : duration;
  const pose = poseAt(truth, duration);
  const how = outcome.text || (outcome.kind === 'completed' || !outcome.kind
    ? 'The scenario ran to its end.' : `The run ended: ${outcome.kind.replaceAll('_', ' ')}.`);
  return { t: at, kind: 'end', text: how + (pose ? ` The robot stands at ${place(pose)}.` : '') };
}

/** The account as a list; each time is a button that goes there. */
function renderAccount(list, replay, onseek) {
  replaceChildren(list, accountOf(replay).map((event) => el('li', { class: `event event-${event.kind}` },
    el('button', { type: 'button', class: 'time-button', 'aria-label': `Go to ${seconds(event.t)}`,
      onclick: () => onseek(event) }, seconds(event.t)),
    el('span', { class: 'event-text', dir: 'auto' }, unbroken(event.text)))));
}
