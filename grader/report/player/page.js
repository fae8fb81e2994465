// The page around the player: score, badge, checks. Without a grading only the replay.

const OUTCOMES = {
  pass: 'Passed', fail: 'Failed', skip: 'Skipped', error: 'Grader error', inconclusive: 'Inconclusive',
  unavailable: 'Not installed',
};
const outcomeOf = (check) => (Object.hasOwn(OUTCOMES, text(check.outcome)) ? check.outcome : 'error');
const isPoints = (value) => (Number.isFinite(value) ? String(Math.round(value * 100) / 100) : '0');
const WIDE = 930; // [pixels] of a page on which log and account stand side by side
const isCore = (check) => check.kind !== 'field';

function buildTop(payload) {
  const grading = payload.grading || {};
  const facts = [grading.file, grading.tier !== undefined && grading.tier !== null ? `Tier ${grading.tier}` : '']
    .map(text).filter(Boolean);
  const name = text(payload.title) || text(grading.exercise) || 'Replay';
  return el('header', { class: 'top' },
    el('div', { class: 'top-words' },
      el('p', { class: 'eyebrow' }, payload.grading ? 'Grading report' : 'Replay'),
      el('h1', { dir: 'auto' }, name),
      facts.length ? el('p', { class: 'top-facts' }, facts.map((fact) => el('span', { dir: 'auto' }, fact))) : null),
    iconButton('theme', 'Switch between light and dark', toggleTheme));
}

function toggleTheme() {
  const root = document.documentElement;
  const dark = root.dataset.theme ? root.dataset.theme === 'dark'
    : matchMedia('(prefers-color-scheme: dark)').matches;
  root.dataset.theme = dark ? 'light' : 'dark';
  document.dispatchEvent(new CustomEvent('themechange'));
}

// --- in a frame ------------------------------------------------------------------------------

/** The run in words would stand below the log, out of view. */
function foldAccount(page) {
  page.querySelectorAll('.account-part').forEach((part) => { part.open = false; });
}

/** Once the frame has its width: it has none where it is folded away. */
function foldIfNarrow(page) {
  new ResizeObserver((_, observer) => {
    if (!page.clientWidth) return;
    observer.disconnect();
    if (page.clientWidth < WIDE) foldAccount(page);
  }).observe(page);
}

/** Follow what the page around the frame says: light or dark, whether to play, from when on, whether the frame is to fit,
    and whether it wants to hear where the replay stands and where the map was clicked. */
function followFrame({ data }) {
  const { theme, fit, play, from, stays, hands } = data || {};
  const root = document.documentElement;
  if (theme === 'light' || theme === 'dark') root.dataset.theme = theme;
  else delete root.dataset.theme;
  document.dispatchEvent(new CustomEvent('themechange'));
  const say = (news) => parent.postMessage({ ...news, duration: window.replayPlayer.duration, run: window.replayPlayer.run }, '*');
  if (hands) root.dataset.heard = 'true';
  if (hands) window.replayPlayer?.tell((at) => say({ at }), (place) => say({ place }));
  if (Number.isFinite(from)) goOn(from, stays);
  else if (play) playSmall(new Set(['play']));
  const page = document.getElementById('page');
  if (!fit || page.classList.contains('is-fitted')) return;
  page.classList.add('is-fitted');
  foldAccount(page);
  new ResizeObserver(() => parent.postMessage({ height: page.offsetHeight }, '*')).observe(page);
}

// --- the score -------------------------------------------------------------------------------

function buildScore(grading, checks) {
  const score = Number(grading.score) || 0;
  const most = Number(grading.max_score) || 0;
  const counts = Object.keys(OUTCOMES)
    .map((outcome) => [outcome, checks.filter((check) => outcomeOf(check) === outcome).length])
    .filter(([, n]) => n);
  return el('section', { class: 'score', 'aria-label': 'Score' },
    el('p', { class: 'score-figure' }, el('strong', {}, isPoints(score)),
      el('span', {}, `/${isPoints(most)}`), el('span', { class: 'score-unit' }, 'points')),
    el('div', { class: 'score-middle' },
      buildBar(checks.filter(isCore), score, most),
      el('ul', { class: 'counts' }, counts.map(([outcome, n]) => el('li', { class: `is-${outcome}` },
        sign(outcome), `${n} ${OUTCOMES[outcome].toLowerCase()}`)))),
    buildBadge(grading, checks.filter((check) => !isCore(check))),
    ...[grading.cap, questions(checks), ...(grading.notes || [])].filter(Boolean).map((note) => el('p', { class: 'score-note', dir: 'auto' }, text(note))));
}

/** Points by what the checks ask: "Asked: wiring 5/5, decision 40/45". */
function questions(checks) {
  const sums = new Map();
  for (const check of checks.filter((each) => isCore(each) && text(each.asks))) {
    if (['error', 'inconclusive', 'unavailable'].includes(outcomeOf(check))) continue;
    const [won, most] = sums.get(text(check.asks)) || [0, 0];
    sums.set(text(check.asks), [won + (Number(check.points) || 0), most + (Number(check.max_points) || 0)]);
  }
  const said = [...sums].map(([asks, [won, most]]) => `${asks} ${isPoints(won)}/${isPoints(most)}`);
  return said.length ? `Asked: ${said.join(', ')}` : '';
}

/** The bar has one segment a core check, as wide as its points, filled as far as it earned them. */
function buildBar(core, score, most) {
  const bar = el('div', { class: 'bar', role: 'img', 'aria-label': `${isPoints(score)} of ${isPoints(most)} points` });
  for (const check of core) {
    const share = Number(check.max_points) || 0;
    if (share <= 0) continue;
    const fill = el('i', {});
    fill.style.width = `${clamp((Number(check.points) || 0) / share, 0, 1) * 100}%`;
    const segment = el('span', { class: `bar-part is-${outcomeOf(check)}`, title: `${text(check.title).slice(0, 200)}\n${
      OUTCOMES[outcomeOf(check)]}, ${isPoints(check.points)} of ${isPoints(share)} points` }, fill);
    segment.style.flexGrow = String(share);
    bar.append(segment);
  }
  return bar;
}

function buildBadge(grading, field) {
  const passed = field.filter((check) => outcomeOf(check) === 'pass').length;
  const ready = grading.field_ready;
  const missing = ready === null || ready === undefined;
  const word = ready ? 'Field-ready' : missing ? 'Field checks not run' : 'Not field-ready yet';
  const fact = ready ? 'Works on other sensors and networks too' : missing ? 'They carry no points'
    : `${passed} of ${field.length} field checks passed`;
  return el('div', { class: `badge ${ready ? 'is-earned' : ''}` }, icon(ready ? 'badge' : 'badgeEmpty'),
    el('p', {}, el('strong', {}, word), el('span', {}, fact)));
}

const sign = (outcome) => el('span', { class: `sign is-${outcome}` }, icon(outcome));

// --- the cause ---------------------------------------------------------------------------------

/** The most probable cause of what failed, with the hint that fits. */
function buildCause(cause) {
  const said = cause && text(cause.text);
  if (!said) return null;
  const where = text(cause.where);
  const hint = cause.hint || {};
  return el('section', { class: 'cause', 'aria-label': 'Most probable cause' },
    el('p', { class: 'message', dir: 'auto' }, el('strong', {}, 'Cause '), unbroken(said)),
    where ? el('p', { class: 'message value', dir: 'auto' }, where) : null,
    text(hint.title) ? el('details', {}, el('summary', {}, `Hint: ${text(hint.title)} (${text(hint.anchor)})`),
      el('p', { class: 'message', dir: 'auto' }, text(hint.text))) : null);
}

// --- the checks ------------------------------------------------------------------------------

function buildGroup(name, fact, checks, links) {
  if (!checks.length) return null;
  return el('section', { class: 'group', 'aria-label': `${name} checks` },
    el('div', { class: 'group-head' }, el('h2', {}, name), el('p', {}, fact)),
    el('ol', { class: 'checks' }, checks.map((check) => buildCheck(check, links))));
}

function buildCheck(check, links) {
  const outcome = outcomeOf(check);
  const head = [
    sign(outcome),
    el('span', { class: 'check-title' }, el('bdi', {}, text(check.title) || text(check.id)),
      text(check.title) && text(check.id) ? [' ', el('code', { class: 'check-id', dir: 'ltr' }, text(check.id)),
        Number(check.task) ? ` task ${Number(check.task)}` : null] : null),
    el('span', { class: 'check-points' }, pointsOf(check)),
    el('span', { class: `check-word is-${outcome}` }, OUTCOMES[outcome]),
  ];
  const body = buildCheckBody(check, links);
  if (!body.length) return el('li', { class: `check is-${outcome}` }, el('div', { class: 'check-head' }, head));
  return el('li', { class: `check is-${outcome}` },
    el('details', { open: outcome !== 'pass' },
      el('summary', { class: 'check-head' }, head), el('div', { class: 'check-body' }, body)));
}

/** What the grader or the machine could not judge counts neither for nor against. */
function pointsOf(check) {
  if (!isCore(check) || !(Number(check.max_points) > 0)) return '';
  if (['error', 'inconclusive', 'unavailable'].includes(outcomeOf(check))) return 'not counted';
  return `${isPoints(Number(check.points))}/${isPoints(Number(check.max_points))}`;
}

function buildCheckBody(check, links) {
  const long = (value, name) => (value.length > 600
    ? { class: `${name} is-long`, dir: 'auto', tabindex: '0' } : { class: name, dir: 'auto' });
  const message = text(check.message);
  const facts = [['Expected', check.expected], ['Actual', check.actual], ['Code', check.where], ['Log', check.log]].map(([name, value]) => [name, text(value)])
    .filter(([, value]) => value);
  return [
    message && el('p', long(message, 'message'), unbroken(message)),
    facts.length > 0 && el('dl', { class: 'facts' }, facts.map(([name, value]) => el('div', { class: `fact is-${name.toLowerCase()}` },
      el('dt', {}, name), el('dd', long(value, 'value'), unbroken(value))))),
    text(check.help) && el('p', { class: 'next' }, el('strong', {}, 'Look at next '),
      el('span', { dir: 'auto' }, unbroken(check.help))),
    ...buildLinks(check, links),
  ].filter(Boolean);
}

/** Buttons to the failing moments of a check, or to its run; else words for when and where. */
function buildLinks(check, { runs, show }) {
  if (outcomeOf(check) !== 'fail') return [];
  const jump = (label, run, k) => el('button', { type: 'button', class: 'jump', onclick: () => show(run, k) },
    icon('play'), label, el('span', { class: 'jump-run', dir: 'auto' }, runs[run].name));
  const buttons = runs.flatMap(({ moments }, run) => moments.map((moment, k) => [moment, k])
    .filter(([moment]) => moment.check === text(check.id))
    .map(([moment, k]) => jump(`Show ${seconds(moment.t)}`, run, k)));
  const run = runs.findIndex(({ scenario }) => scenario && scenario === text(check.scenario));
  if (!buttons.length && run >= 0) buttons.push(jump('Open the run', run, -1));
  if (buttons.length) return [el('div', { class: 'jumps' }, buttons)];
  const when = Number.isFinite(check.time) ? `at ${seconds(check.time)}` : '';
  const where = text(check.scenario) ? `in the run ${text(check.scenario)}` : '';
  return when || where ? [el('p', { class: 'quiet' }, `Happened ${when} ${where}`.trim())] : [];
}

/** What the checks need to know of a raw replay to link to it. */
function toRun(replay) {
  const { scenario, title, moments } = replay || {};
  return { scenario: text(scenario), name: (text(title) || text(scenario)).slice(0, 80),
    moments: toMoments(moments, Infinity) };
}

// --- the whole -------------------------------------------------------------------------------

function buildFooter(payload) {
  const versions = Object.entries((payload.grading && payload.grading.versions) || {})
    .map(([name, version]) => `${name} ${text(version)}`);
  const parts = [text(payload.generated_by) && `Made by ${text(payload.generated_by)}`, ...versions].filter(Boolean);
  return el('footer', { class: 'foot' }, parts.map((part) => el('span', { dir: 'auto' }, part)));
}

function buildChecks(grading, checks, links) {
  const core = checks.filter(isCore);
  const field = checks.filter((check) => !isCore(check));
  const passed = field.filter((check) => outcomeOf(check) === 'pass').length;
  return el('main', { class: 'grading' },
    buildGroup('Core', `${isPoints(Number(grading.raw_score ?? grading.score))} of ${isPoints(Number(grading.max_score))} points`, core, links),
    buildGroup('Field', `${passed} of ${field.length} passed, no points`, field, links),
    checks.length ? null : el('p', { class: 'quiet' }, 'No check was run.'));
}

function buildPage(page, payload) {
  const grading = payload.grading;
  const replays = toArray(payload.replays);
  const titled = replays.length === 1 && text(replays[0] && replays[0].title) === text(payload.title);
  const root = el('div', { class: `player-root ${titled ? 'is-titled' : ''}` });
  const show = (run, moment) => {
    if (!window.replayPlayer) return;
    if (moment < 0) window.replayPlayer.selectRun(run);
    else window.replayPlayer.jumpTo(run, moment);
    const from = document.activeElement;
    window.replayPlayer.focus();
    bringIntoView(root);
    root.onkeydown = (event) => { // back to the check
      if (event.key === 'Escape' && !event.target.closest('dialog')) from.focus();
    };
  };
  const checks = grading ? toArray(grading.checks).filter(Boolean) : [];
  page.className = grading && replays.length ? 'page has-grading' : 'page'; // has-grading: two columns
  if (payload.embedded) page.classList.add('is-embedded'); // in a notebook, which says the rest
  if (payload.small) page.classList.add('is-small');
  const hidden = payload.framed === undefined ? 'hidden-text' : 'framed-title';
  const name = payload.embedded ? el('h1', { class: hidden, dir: 'auto' }, text(payload.title) || 'Replay') : null;
  replaceChildren(page, payload.embedded ? null : buildTop(payload), grading ? buildCause(grading.cause) : null,
    grading ? buildScore(grading, checks) : null,
    el('div', { class: 'columns' },
      grading ? buildChecks(grading, checks, { runs: replays.map(toRun), show }) : null,
      grading ? el('aside', { class: 'replay-column', 'aria-label': 'Replay' }, root)
        : el('main', { class: 'replay-column' }, name, root)),
    grading && !payload.embedded ? buildAsk(payload.ask, checks) : null,
    payload.embedded ? null : buildFooter(payload));
  window.replayPlayer = mountPlayer(root, payload);
  window.addEventListener('beforeprint', () => asPrinted(page));
  const judged = payload.framed || payload.judged || checks;
  if (window.replayPlayer) window.replayPlayer.open(judged, Boolean(payload.embedded), payload.opens_at);
  if (!payload.embedded) return;
  if (payload.small) playSmall(payload.small);
  foldIfNarrow(page);
  window.addEventListener('message', followFrame);
  window.addEventListener('keydown', (event) => { // the workspace's own
    const { ctrlKey, key, shiftKey } = event;
    if (key === 'F6' && document.documentElement.dataset.heard === 'true') event.preventDefault(); // the browser's own bars
    if (key === 'F6' || (ctrlKey && key === 'Enter')) parent.postMessage({ pressed: { ctrlKey, key, shiftKey } }, '*');
  });
}

/** Play from the start, and again with `loop`; those who want no motion see the middle of it. */
function playSmall(asked) {
  const player = window.replayPlayer;
  if (!player || !asked.has('play')) return;
  if (calmMotion()) player.seek(player.time || player.duration / 2);
  else player.playAgain(asked.has('loop'));
}

/** Play from a moment on, unless it `stays`; those who want no motion see that moment. */
function goOn(from, stays) {
  const player = window.replayPlayer;
  player?.pause();
  player?.seek(from);
  if (!stays && !calmMotion()) player?.play();
}

/** On paper nothing is folded away, and a map is not black. */
function asPrinted(page) {
  const root = document.documentElement;
  const folded = [...page.querySelectorAll('details:not([open])')].filter((part) => !part.closest('.is-pass'));
  const { theme } = root.dataset;
  const show = (open, look) => {
    folded.forEach((part) => { part.open = open; });
    if (look) root.dataset.theme = look;
    else delete root.dataset.theme;
    document.dispatchEvent(new CustomEvent('themechange'));
  };
  show(true, 'light');
  window.addEventListener('afterprint', () => show(false, theme), { once: true });
}

/** On a narrow page the player is below the check that was pressed. */
function bringIntoView(root) {
  const stage = root.querySelector('.stage') || root;
  const { top, bottom } = stage.getBoundingClientRect();
  if (top >= 0 && bottom <= window.innerHeight) return;
  root.scrollIntoView({ behavior: calmMotion() ? 'auto' : 'smooth', block: 'start' });
}

/** For a frame: with #check=ID only the replay, at the moment of that check; with #small its map. */
function framed(payload) {
  const asked = new URLSearchParams(location.hash.slice(1));
  const check = asked.get('check');
  if (asked.has('small')) return { ...payload, grading: null, embedded: true, small: asked };
  if (check === null) return payload;
  const checks = payload.grading ? toArray(payload.grading.checks).filter(Boolean) : [];
  return { ...payload, grading: null, embedded: true, framed: checks.filter(({ id }) => id === check) };
}

function start() {
  const source = document.getElementById('payload');
  const page = document.getElementById('page');
  if (!source || !page) return;
  const payload = JSON.parse(source.textContent);
  buildPage(page, framed(payload));
  window.addEventListener('hashchange', () => {
    if (location.hash.includes('check=')) buildPage(page, framed(payload));
  });
}

start();
