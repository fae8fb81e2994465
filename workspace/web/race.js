// A race in three worlds: figures, one's own best and the reference beside them, and a file for the table of a class.
// Fetched once somebody races; the figures are those of grader/drive/race.py.

import { el } from './element.js';
import { alsoKeep } from './keep.js';
import { isBetter } from './shelf.js';
import { button } from './workspace.js';

const REFERENCES = new URL('race.json', import.meta.url).href;
const [SHORT, LONG] = [24, 2000]; // characters of a nickname; moments of a track
const COLUMNS = { nearest: 'nearest [m]', median: 'median [m]', acceleration: 'accel. [m/s²]', turning: 'turning [rad/s²]' };
const WHAT = {
  s: 'The time to the goal: less is better.',
  m: 'The way driven in the world’s time: more is better.',
};
const MORE = 'Nearest and median: the distance kept to whatever is within 10 m. Accel. and turning: how strongly it speeds up, brakes and turns '
  + '(root mean square). No marks hang on it.';

/** Return the references' laps and tracks of an exercise, by the world; none where the server does not answer. */
async function references(slug) {
  const answer = await fetch(REFERENCES).catch(() => null);
  if (!answer?.ok) return {};
  alsoKeep(import.meta.url, REFERENCES);
  return (await answer.json())[slug] ?? {};
}

/** Return what was kept of a world, if it is whole. */
function whole(kept) {
  const { lap, track } = kept ?? {};
  const columns = ['t', 'x', 'y', 'yaw'].map((name) => track?.[name]);
  const isTrack = columns.every((each) => Array.isArray(each) && each.length <= LONG && each.length > 1
    && each.length === columns[0].length && each.every(Number.isFinite));
  if (!isTrack || !Number.isFinite(lap?.figure)) return null;
  return { lap, track: { t: columns[0], x: columns[1], y: columns[2], yaw: columns[3] } };
}

/** Race with a workspace's text; return in a sentence how it ended. */
export async function race(workspace) {
  const { plan, machine, shelf, text } = workspace;
  const [worlds, recordings] = [Object.keys(plan.race), {}];
  const left = [...worlds];
  await machine.together(async (hand) => {
    const world = left.shift();
    if (!world) return false;
    hand.doing = `Racing in ${world}`;
    workspace.say(`${hand.doing} …`);
    Object.assign(recordings, (await workspace.trial(hand, world, text, { tell: true }))[1]);
    return true;
  });
  const reference = await references(plan.slug);
  const beside = worlds.map((world) => Object.fromEntries(Object.entries({ 'the reference': whole(reference[world]), 'your best': whole(shelf.bests[world]) })
    .filter(([, other]) => other)));
  const [driven] = await machine.call('race', { exercise: plan.slug, scenarios: worlds, beside }, { recordings });
  const rows = driven.map(([lap, , lost], i) => {
    const [theirs, best] = ['the reference', 'your best'].map((whose) => (beside[i][whose]?.lap.of === lap.of ? beside[i][whose] : null));
    return { lap, lost: lost.filter(Boolean), best, reference: theirs };
  });
  const ghosts = Object.fromEntries(rows.map((row) => [row.lap.world, [['reference', row.reference], ['your best', row.best]]
    .filter(([, ghost]) => ghost).map(([whose, { track }]) => [whose, track])]));
  for (const [i, { lap, best }] of rows.entries()) {
    if (isBetter(lap.figure, best?.lap.figure, plan.unit)) shelf.keepBest(lap.world, { lap, track: driven[i][1] });
  }
  if (workspace.judged !== text) Object.values(workspace.rows).forEach(({ fill }) => fill(null)); // of another text
  workspace.speakOf(text);
  const finished = rows.map(({ lap }) => lap.figure).filter((figure) => figure !== null);
  const sum = finished.reduce((all, figure) => all + figure, 0).toFixed(2);
  shelf.add(text, `race: ${finished.length} of ${rows.length}${finished.length ? `, ${sum} ${plan.unit}` : ''}`);
  workspace.listVersions();
  workspace.score.replaceChildren(table(rows, plan), el('p', { class: 'ws-note' }, `${WHAT[plan.unit]} ${plan.rules} ${MORE}`),
    finished.length ? form(workspace, rows, finished) : el('p', {}, 'No world was finished, so there is no result to save.'));
  await workspace.play(worlds, [], recordings, plan.title, { play: true }, ghosts);
  workspace.show('result');
  workspace.score.parentElement.scrollTop = 0;
  return `Race: ${finished.length} of ${rows.length} worlds finished.`;
}

function table(rows, { race: titles, unit }) {
  const heads = [unit === 's' ? 'time [s]' : 'way [m]', ...Object.values(COLUMNS)];
  const shown = (figure) => (Number.isFinite(figure) ? figure.toFixed(2) : '–');
  const row = (who, lap) => lap && el('tr', {}, el('th', { scope: 'row' }, who),
    lap.ended ? el('td', { colspan: heads.length, class: 'ws-ended' }, `not finished: ${lap.ended}`)
      : [lap.figure, ...Object.keys(COLUMNS).map((name) => lap[name])].map((figure) => el('td', {}, shown(figure))));
  return el('div', { class: 'ws-race', role: 'region', 'aria-label': 'The race', tabindex: 0 }, el('table', {},
    el('thead', {}, el('tr', {}, el('th', { scope: 'col' }, 'world'), heads.map((head) => el('th', { scope: 'col' }, head)))),
    rows.map(({ lap, lost, best, reference }) => el('tbody', {},
      el('tr', {}, el('th', { scope: 'rowgroup', colspan: heads.length + 1 }, titles[lap.world])),
      row('yours', lap), row('your best', best?.lap), row('reference', reference?.lap),
      lost.map((said) => el('tr', {}, el('td', { colspan: heads.length + 1 }, `${said[0].toUpperCase()}${said.slice(1)}.`)))))));
}

/** Save the result as a file, by a nickname: only if the reader wants to. */
function form(workspace, rows, finished) {
  const nickname = el('input', { id: 'ws-nickname', maxlength: SHORT, required: true, autocomplete: 'off', spellcheck: 'false' });
  const save = (event) => {
    event.preventDefault();
    const { slug, course } = workspace.plan;
    const result = { course, exercise: slug, nickname: nickname.value.trim(), laps: rows.map(({ lap }) => lap) };
    if (!result.nickname) return workspace.say('A nickname has something that can be seen.');
    const file = `${['race', slug, ...result.nickname.split(/[^\p{L}\p{N}]+/u).filter(Boolean)].join('_')}.json`;
    workspace.save(file, `${JSON.stringify(result, null, 1)}\n`, 'application/json');
    return workspace.say(`Saved: ${file}, with ${finished.length} of ${rows.length} worlds, by the nickname “${result.nickname}”.`);
  };
  return el('form', { class: 'ws-tools', onsubmit: save }, el('label', { for: 'ws-nickname' }, 'Nickname'), nickname,
    button('Save the result', () => {}, { type: 'submit' }),
    el('p', { class: 'ws-note' }, 'For the table of your class, if you like: these figures, no code.'));
}
