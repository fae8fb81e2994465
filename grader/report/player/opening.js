// Where a page opens: at what failed; if all is well at a drive, never at a robot on its bench.

/** What to show first: {run, moment} or {run, t}; null if the start of the first run is as good.
    Whoever made the page may have told when, in the first run [s]. */
function openingOf(checks, replays, told) {
  if (Number.isFinite(told) && replays.length) {
    return { run: 0, t: clamp(told, 0, replays[0].duration) };
  }
  const isWell = checks.length && checks.every(({ outcome }) => ['pass', 'skip', 'unavailable'].includes(outcome));
  return failureOf(checks, replays) || firstMoment(replays) || (isWell ? null : badEnd(replays)) // an end may be asked for
    || driveOf(replays, checks.length > 0);
}

/** The moment, or else the run, of the first check that failed. */
function failureOf(checks, replays) {
  for (const check of checks.filter(({ outcome }) => outcome === 'fail')) {
    for (const [run, { moments }] of replays.entries()) {
      const moment = moments.findIndex((m) => m.check === text(check.id));
      if (moment >= 0) return { run, moment };
    }
  }
  const scenarios = checks.filter(({ outcome }) => outcome === 'fail').map((check) => text(check.scenario));
  const run = replays.findIndex(({ scenario }) => scenario && scenarios.includes(scenario));
  return run < 0 ? null : { run, t: endOf(replays[run]) ?? halfWay(replays[run]) };
}

function firstMoment(replays) {
  const run = replays.findIndex(({ moments }) => moments.length);
  return run < 0 ? null : { run, moment: 0 };
}

/** Nobody judged: the end of a node that died or hung, else the first contact. */
function badEnd(replays) {
  const ended = replays.findIndex((replay) => endOf(replay) !== null);
  if (ended >= 0) return { run: ended, t: endOf(replays[ended]) };
  const touched = replays.findIndex(({ contacts }) => contacts.length);
  return touched < 0 ? null : { run: touched, t: replays[touched].contacts[0].from };
}

function endOf({ outcome, duration }) {
  if (!outcome.kind || outcome.kind === 'completed') return null;
  return Number.isFinite(outcome.at) ? clamp(outcome.at, 0, duration) : duration;
}

/** Half way through the longest drive; a single run that nobody judged opens at its start. */
function driveOf(replays, judged) {
  if (replays.length < 2 && !judged) return null;
  const ways = replays.map(({ truth, bench }) => (bench ? 0 : wayOf(truth).at(-1) || 0));
  const run = ways.indexOf(Math.max(...ways));
  return ways[run] > 0 ? { run, t: halfWay(replays[run]) } : null;
}

function halfWay({ truth }) {
  const way = wayOf(truth);
  return way.length ? truth.t[way.findIndex((s) => s >= way.at(-1) / 2)] : 0;
}

/** The way driven up to each sample [m]. */
function wayOf({ t, x, y }) {
  let way = 0;
  return Array.from(t, (_, i) => {
    const step = i ? Math.hypot(x[i] - x[i - 1], y[i] - y[i - 1]) : 0;
    way += Number.isFinite(step) ? step : 0;
    return way;
  });
}
