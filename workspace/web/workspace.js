// The workspace of an exercise's page: an editor, the robot, and the grader's checks, all of them in
// this browser. Python runs in worker.js; this file never waits for it.

import { el } from './element.js';
import { Machine, PATIENCE, Stopped } from './machine.js';
import { Shelf, showChanges } from './shelf.js';

const HERE = new URL('.', import.meta.url);
const FOLDER = '/home/reader'; // where the worker puts the node
const JUDGE_EVERY = 2; // [s] while a check drives on: each time costs about half a second
const CACHE = 'course-workspace'; // also in worker.js
const LONGEST = 8000; // [characters] of a link: longer ones are cut where they are passed on
const NOTHING_KEPT = 'This browser keeps nothing for this site: download your file before you leave the page.';
const NO_MEMORY = 'The browser had no memory left. Close other tabs, then try again; what you typed is not lost.';
const BROKEN = 'The link to this page holds no code that can be read: it was cut on its way. Ask for the file instead.';
const OUTCOMES = {
  pass: '✓ passed', fail: '✗ failed', skip: '– not judged', error: '! the grader failed', inconclusive: '? undecided',
  unavailable: '– not available',
};

/** Say in a sentence why this page can't run an exercise; '' if it can. */
function whyNot({ threads }) {
  if (!globalThis.WebAssembly) return 'The workspace needs WebAssembly, which is switched off in this browser.';
  if (!globalThis.Worker || !globalThis.DecompressionStream) {
    return 'The workspace needs a newer browser: Chrome or Edge 80, Firefox 113, Safari 16.4, or later.';
  }
  if (threads && !('Suspending' in WebAssembly)) {
    return 'This exercise needs threads, which only some browsers have in a page: take Chrome or Edge 137 or later, or install the course.';
  }
  return '';
}

// --- code in a link ---------------------------------------------------------------------------------

const through = async (bytes, stream) => new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(stream)).arrayBuffer());

/** Return a text as it stands in a link. */
async function packed(text) {
  const bytes = await through(new TextEncoder().encode(text), new CompressionStream('deflate'));
  return btoa(String.fromCharCode(...bytes)).replaceAll('+', '-').replaceAll('/', '_').replaceAll('=', '');
}

/** Return the text of a link; it throws if anything is amiss. */
async function unpacked(code) {
  const bytes = Uint8Array.from(atob(code.replaceAll('-', '+').replaceAll('_', '/')), (c) => c.charCodeAt(0));
  return new TextDecoder('utf-8', { fatal: true }).decode(await through(bytes, new DecompressionStream('deflate')));
}

// --- without a network ------------------------------------------------------------------------------

/** Keep what this page is made of; worker.js keeps its own. Where the browser keeps nothing, it works without. */
async function keepForLater() {
  const root = new URL('../../', HERE); // of the site
  await navigator.serviceWorker.register(new URL('offline.js', root));
  const store = await caches.open(CACHE);
  const hashes = Object.values(manifest).map(({ sha256 }) => `?${sha256}`);
  const isOld = ({ url }) => /\?[0-9a-f]{64}$/.test(url) && !hashes.some((hash) => url.endsWith(hash));
  await Promise.all((await store.keys()).filter(isOld).map((request) => store.delete(request)));
  const loaded = performance.getEntriesByType('resource').map(({ name }) => name).filter((name) => name.startsWith(root));
  const worker = new URL(`worker.js?${manifest['worker.js'].sha256}`, HERE).href;
  const hints = new URL('hints.html', location.href).href;
  await Promise.all([...new Set([hints, worker, ...loaded])].map((name) => store.add(name).catch(() => {})));
  await store.add(location.pathname);
}

// --- hints ------------------------------------------------------------------------------------------

/** Read the exercise's page of hints: by task, the elements in their order. */
async function readHints(url) {
  const page = new DOMParser().parseFromString(await (await fetch(url)).text(), 'text/html');
  const tasks = {};
  for (const section of page.querySelectorAll('article section section')) {
    const task = /(\d+)/.exec(section.querySelector('h2')?.textContent || '');
    if (task) tasks[task[1]] = [...section.querySelectorAll('details')];
  }
  return tasks;
}

// --- the workspace ----------------------------------------------------------------------------------

class Workspace {
  constructor(plan, demos, place) {
    this.plan = plan;
    this.demos = demos;
    this.place = place; // its block in the page
    [this.file] = plan.files;
    this.skeleton = plan.skeleton[this.file];
    this.shelf = new Shelf(plan.slug);
    this.machine = new Machine(manifest, { onnews: (hand, news) => this.hear(hand, news), onsilence: (hand) => this.ask(hand) });
    this.recordings = {}; // of the last check, by their files
    this.busy = false;
    this.rows = {};
    this.build();
  }

  build() {
    const { plan } = this;
    this.status = el('p', { class: 'ws-status', role: 'status' });
    this.question = el('div', { class: 'ws-question', hidden: true, role: 'alert' });
    this.scenario = el('select', { id: 'ws-scenario', 'aria-label': 'Scenario' },
      el('optgroup', { label: 'Scenarios of the checks' }, options(plan.scenarios)),
      el('optgroup', { label: 'To try things' }, options(this.demos)));
    this.seed = el('input', { id: 'ws-seed', type: 'number', min: 0, max: 1000000, placeholder: 'its own' });
    const button = (text, act, more = {}) => el('button', { type: 'button', onclick: act, ...more }, text);
    this.driveButton = button('Drive', () => this.drive(), { title: 'Ctrl-Enter', class: 'ws-main' });
    this.checkButton = button('Check', () => this.check(), { title: 'Ctrl-Shift-Enter', class: 'ws-main' });
    this.stopButton = button('Stop', () => this.machine.stop(), { hidden: true });
    this.versions = el('select', { 'aria-label': 'Earlier versions', onchange: () => this.restore() });
    this.changesButton = button('Changes', () => this.changes(), { title: 'Since the last version that passed all checks' });
    this.code = el('div', { class: 'ws-code', 'data-pane': 'code', onkeydown: (event) => this.leave(event) });
    this.replay = el('div', { class: 'ws-replay', 'data-pane': 'replay' },
      el('p', { class: 'ws-empty' }, 'Drive the node, or check it: its run is shown here.'));
    this.score = el('div', { class: 'ws-score' }, `Practice: ${plan.points} points can be won here. `
      + 'Your instructor’s grade comes from the real rclpy on Linux.');
    this.list = el('ol', { class: 'ws-list' }, plan.checks.map((check) => this.row(check)));
    this.log = el('pre', { class: 'ws-log', hidden: true, tabindex: 0, 'aria-label': 'What Python said' });
    const checks = el('div', { class: 'ws-checks', 'data-pane': 'checks' }, this.score, this.list, this.log);
    this.tabs = ['code', 'replay', 'checks'].map((name) => button(name[0].toUpperCase() + name.slice(1),
      () => this.show(name), { 'aria-pressed': name === 'code', 'data-name': name }));
    this.dialog = el('dialog', { class: 'workspace', 'aria-label': `Workspace: exercise ${plan.number}, ${plan.title}`,
      onclose: () => stand(''), 'data-show': 'code' },
      el('div', { class: 'ws-bar' },
        el('h2', {}, `${plan.number}. ${plan.title}`),
        el('div', { class: 'ws-tools' },
          this.driveButton,
          el('label', { for: 'ws-scenario' }, 'in'), this.scenario,
          el('label', { for: 'ws-seed', class: 'ws-seed' }, 'seed', this.seed),
          this.checkButton),
        el('div', { class: 'ws-tools ws-file' },
          this.versions, this.changesButton,
          button('Reset', () => this.reset(), { title: 'Begin with the skeleton again' }),
          button('Link', () => this.share(), { title: 'A link that carries your code' }),
          button('Download', () => this.download(), { title: this.file })),
        button('Close', () => this.dialog.close(), { class: 'ws-close' })),
      el('div', { class: 'ws-news' }, this.status, this.stopButton, this.question),
      el('nav', { class: 'ws-tabs', 'aria-label': 'Show' }, this.tabs),
      el('div', { class: 'ws-panes' }, this.code, this.replay, checks));
    document.body.append(this.dialog);
    this.listVersions();
    this.driveButton.disabled = this.checkButton.disabled = Boolean(whyNot(this.plan));
    addEventListener('beforeunload', (event) => { if (!this.shelf.works && this.changed) event.preventDefault(); });
  }

  /** Show the workspace; `code` is what a link brought along. */
  async open(code = null) {
    if (!this.dialog.open) this.dialog.showModal();
    stand('#workspace'); // a reload comes back here, and does not bring the link's code again
    if (!this.editor) await this.makeEditor();
    const said = code === null ? [] : [await this.take(code)];
    if (!this.shelf.works) said.push(NOTHING_KEPT);
    if (whyNot(this.plan)) this.say([whyNot(this.plan), ...said].join(' '));
    else {
      this.work(() => this.machine.ready(), ['Ready.', ...said].join(' '));
      this.machine.first.warm.then(keepForLater).catch(() => {}); // not by http, not in a private window
    }
  }

  /** Put a link's code into the editor; say what came of it. */
  async take(code) {
    try {
      this.replace(await unpacked(code));
    } catch {
      return BROKEN;
    }
    return 'This is the code of the link; what was here before is among the versions.';
  }

  async makeEditor() {
    const text = this.shelf.text ?? this.skeleton;
    const label = `Your node, ${this.file}. Tab leaves the editor.`;
    const onChange = () => { this.changed = true; this.shelf.text = this.editor.text; };
    const keys = { 'Ctrl-Enter': () => this.drive(), 'Ctrl-Shift-Enter': () => this.check() };
    try {
      const { makeEditor } = await import(new URL('editor.js', HERE));
      this.editor = makeEditor({ parent: this.code, text, label, onChange, keys, words: this.plan.words });
    } catch {
      this.editor = plainEditor(this.code, text, label, onChange);
    }
  }

  // --- what is shown

  say(text) { this.status.textContent = text; }

  show(name) {
    this.dialog.dataset.show = name;
    this.tabs.forEach((tab) => tab.setAttribute('aria-pressed', tab.dataset.name === name));
  }

  hear(hand, { kind, text, seconds }) {
    if (kind === 'progress' && hand === this.machine.first) this.say(text);
    if (kind === 'out') {
      this.log.hidden = false;
      this.log.textContent = `${this.log.textContent}${text}\n`.slice(-20000);
    }
    if (kind === 'reached') {
      this.question.hidden = true;
      this.say(`${hand.doing}: ${seconds.toFixed(1)} s driven`);
    }
  }

  /** Python says nothing: whether to wait is the reader's choice. */
  ask(hand) {
    this.question.replaceChildren(
      el('span', {}, `Time has stood still for ${PATIENCE} s (at ${hand.reached.toFixed(1)} s of ${hand.where}): `
        + 'the node computes, or a loop never ends. '),
      el('button', { type: 'button', onclick: () => { this.question.hidden = true; hand.watch(); } }, 'Wait'),
      el('button', { type: 'button', onclick: () => this.machine.stop() }, 'Stop it'));
    this.question.hidden = false;
  }

  // --- what is done

  /** Do what takes the worker's time, once at a time; say how it ended. */
  async work(task, done) {
    if (this.busy) return;
    this.busy = true;
    this.dialog.setAttribute('aria-busy', 'true');
    this.driveButton.disabled = this.checkButton.disabled = true;
    this.stopButton.hidden = false;
    try {
      const said = await task();
      this.say(done || said);
    } catch (error) {
      this.machine.stop(); // what others are at is of no use any more
      const text = String(error.message || error);
      if (error instanceof Stopped) this.say('Stopped.');
      else if (/out of memory|allocat|MemoryError/i.test(text)) this.say(NO_MEMORY);
      else this.say(`This went wrong in the page, not in your node: ${text.trim().split('\n').at(-1)}`);
      if (!(error instanceof Stopped)) this.hear(null, { kind: 'out', text });
    }
    this.busy = false;
    this.dialog.setAttribute('aria-busy', 'false');
    this.driveButton.disabled = this.checkButton.disabled = Boolean(whyNot(this.plan));
    this.stopButton.hidden = this.question.hidden = true;
  }

  /** Run the node in a scenario; return how it ended, and its recording. */
  async run(hand, scenario, more = {}) {
    const order = { file: `${FOLDER}/${this.file}`, others: this.plan.files, scenario, ...more };
    const files = { [this.file]: this.editor.text };
    const [ended, recordings] = await hand.call('trial', order, { files });
    return ended.lead ? this.run(hand, scenario, { ...more, lead: ended.lead }) : [ended, recordings];
  }

  drive() {
    const scenario = this.scenario.value;
    const seed = this.seed.value === '' ? {} : { seed: Number(this.seed.value) };
    this.editor.mark(0);
    return this.work(async () => {
      const hand = await this.machine.ready();
      hand.doing = `Driving in ${scenario}`;
      this.say(`${hand.doing} …`);
      const [ended, recordings] = await this.run(hand, scenario, seed);
      await this.play([scenario], [], recordings);
      this.show('replay');
      if (ended.kind === 'completed') return `Driven to the end of ${scenario}.`;
      this.mark({ where: ended.where, message: ended.text });
      return `${scenario} ended early: ${ended.text}`;
    });
  }

  check() {
    if (this.busy) return null;
    this.editor.mark(0);
    Object.values(this.rows).forEach(({ fill }) => fill(null));
    this.score.replaceChildren();
    return this.work(async () => {
      const text = this.editor.text;
      await this.driveAll();
      this.say('Judging …');
      const grading = await this.judge(await this.machine.ready());
      this.fill(grading, this.plan.checks.map(({ id }) => id));
      this.shelf.add(text, `${grading.score} of ${grading.max_score}`, grading.checks.every(({ outcome }) => outcome === 'pass'));
      this.listVersions();
      await this.tell(grading);
      return `${grading.score} of ${grading.max_score} points.`;
    });
  }

  /** Drive in all scenarios of the checks; on a slow machine judge what can be judged meanwhile. */
  async driveAll() {
    const { checks } = this.plan;
    const wanted = [...new Set(checks.flatMap((check) => check.scenarios))];
    const left = [...wanted];
    let [shown, last] = [0, performance.now()];
    this.recordings = {};
    await this.machine.together(async (hand) => {
      const scenario = left.shift();
      if (!scenario) return false;
      const number = wanted.length - left.length;
      hand.doing = `Run ${number} of ${wanted.length}, ${scenario}`;
      this.say(`${hand.doing} …`);
      const [, recordings] = await this.run(hand, scenario, { interrupt: number === 1 });
      Object.assign(this.recordings, recordings);
      const open = checks.findIndex((check) => !check.scenarios.every((name) => `${name}.pickle` in this.recordings));
      if (performance.now() - last > JUDGE_EVERY * 1000 && open > shown) {
        const only = checks.slice(shown, open).map(({ id }) => id);
        [shown, last] = [open, performance.now()];
        this.fill(await this.judge(hand, only), only);
      }
      return true;
    });
  }

  async judge(hand, only = []) {
    const order = { exercise: this.plan.slug, file: this.file, scenarios: this.driven, only };
    return (await hand.call('judge', order, { recordings: this.recordings }))[0];
  }

  /** The scenarios of which there are recordings, in the order of the checks. */
  get driven() { return Object.keys(this.plan.scenarios).filter((name) => `${name}.pickle` in this.recordings); }

  /** Show a grading as a whole, and the first failure where it happens; all runs if nothing failed. */
  async tell(grading) {
    const { cause } = grading;
    this.score.replaceChildren(
      el('strong', {}, `${grading.score} of ${grading.max_score} points. `),
      grading.cap ? `${grading.cap} ` : '', el('span', { class: 'ws-note' }, grading.notes.join(' ')),
      cause ? el('p', { class: 'ws-cause' }, el('strong', {}, 'Cause: '), cause.text,
        cause.where ? el('pre', {}, cause.where) : null) : '');
    const first = grading.checks.find((check) => check.outcome === 'fail');
    if (!first) await this.play(this.driven, grading.checks, this.recordings);
    else if (first.scenario) await this.play([first.scenario], [first], this.recordings);
    if (first) this.mark(first);
    this.show('checks');
  }

  async play(scenarios, checks, recordings) {
    const [html] = await this.machine.call('replay', { scenarios, checks, title: this.plan.title }, { recordings });
    const frame = el('iframe', { title: 'Replay', sandbox: 'allow-scripts' });
    frame.addEventListener('load', () => this.shade(frame));
    frame.srcdoc = html;
    this.replay.replaceChildren(frame);
  }

  /** Tell a replay whether the site is light or dark. */
  shade(frame) { frame.contentWindow?.postMessage({ theme: document.body.dataset.theme }, '*'); }

  /** Mark the line that was being run when a check failed, or the one that led to the last message before. */
  mark({ where, line, message }) {
    const died = /line (\d+)/.exec(where || '');
    if (died) this.editor.mark(Number(died[1]), message);
    else this.editor.mark(line || 0, `${message}. The last message before that came from this line.`);
  }

  // --- the checks

  row(check) {
    const state = el('span', { class: 'ws-state' });
    const detail = el('div', { class: 'ws-detail' });
    const row = el('li', { 'data-check': check.id },
      el('div', { class: 'ws-row' }, state, el('span', { class: 'ws-title' }, check.title),
        el('span', { class: 'ws-points' }, `${check.points}`)), detail);
    const fill = (result) => {
      row.dataset.outcome = result ? result.outcome : '';
      state.textContent = result ? OUTCOMES[result.outcome] : '○ open';
      detail.replaceChildren(...(result && result.outcome !== 'pass' ? this.details(result) : []));
    };
    fill(null);
    this.rows[check.id] = { fill };
    return row;
  }

  fill(grading, ids) {
    for (const result of grading.checks) if (ids.includes(result.id)) this.rows[result.id].fill(result);
  }

  details(result) {
    const line = (name, text) => (text ? el('p', {}, el('b', {}, `${name} `), text) : null);
    const told = el('div', { class: 'ws-hints' });
    const seen = result.scenario && result.outcome === 'fail';
    return [
      result.message ? el('p', {}, result.message) : null,
      line('Expected:', result.expected), line('Got:', result.actual), line('', result.help),
      result.where ? el('pre', {}, result.where) : null,
      result.log ? el('pre', {}, result.log) : null,
      el('div', { class: 'ws-tools' },
        seen ? el('button', { type: 'button', onclick: () => this.look(result) },
          result.time === null ? 'Show' : `Show ${result.time.toFixed(2)} s`) : null,
        result.outcome === 'fail' && result.task ? el('button', { type: 'button',
          onclick: (event) => this.hint(result, told, event.currentTarget) }, 'A hint') : null),
      told,
    ].filter(Boolean);
  }

  look(result) {
    this.mark(result);
    this.work(async () => {
      await this.play([result.scenario], [result], this.recordings);
      this.show('replay');
      return result.message;
    });
  }

  /** Show the next hint of a check's task, beginning with the one for the check. */
  async hint(result, told, button) {
    try {
      this.hints ??= await readHints(new URL('hints.html', location.href));
    } catch {
      told.append(el('p', {}, 'The hints can’t be read here; they have a page of their own.'));
      return;
    }
    const [task, number] = (result.hint || `${result.task}.1`).split('.');
    const all = this.hints[task] || [];
    told.shown ??= Math.max(0, Number(number) - 1);
    if (all[told.shown]) {
      const shown = document.importNode(all[told.shown], true);
      shown.open = true;
      told.append(shown);
      told.shown += 1;
    }
    button.textContent = all[told.shown] ? 'One hint more' : 'No more hints';
    button.disabled = !all[told.shown];
  }

  // --- the file

  listVersions() {
    const { versions } = this.shelf;
    this.versions.replaceChildren(el('option', { value: '' }, 'Versions'),
      ...versions.map(({ at, points }, i) => el('option', { value: i }, `${new Date(at).toLocaleString()}: ${points}`)));
    this.versions.disabled = !versions.length;
    this.changesButton.disabled = !this.shelf.green;
  }

  /** Show above the checks what is different from the last version that passed them all. */
  changes() {
    const { text, at } = this.shelf.green;
    const since = `what passed all checks on ${new Date(at).toLocaleString()}`;
    const same = text === this.editor.text;
    this.score.replaceChildren(el('p', {}, same ? `This is ${since}.` : `Changed since ${since}:`),
      same ? '' : showChanges(text, this.editor.text));
    this.show('checks');
    this.score.scrollIntoView();
  }

  restore() {
    const version = this.shelf.versions[Number(this.versions.value)];
    if (this.versions.value !== '' && version) this.replace(version.text);
    this.versions.value = '';
  }

  reset() { this.replace(this.skeleton); }

  /** Put another text into the editor; what was there stays among the versions. */
  replace(text) {
    const before = this.editor.text;
    if (before !== this.skeleton && before !== text) this.shelf.add(before, 'put aside');
    this.editor.text = text;
    this.listVersions();
  }

  /** Copy a link that carries the code; it goes to no server: browsers keep what follows a #. */
  async share() {
    const link = `${location.href.split('#')[0]}#code=${await packed(this.editor.text)}`;
    if (link.length > LONGEST) {
      this.say('Your code is too long for a link. Download the file, and send that.');
      return;
    }
    try {
      await navigator.clipboard.writeText(link);
      this.say('Copied: a link that opens this page with your code.');
    } catch { // only pages of https have the clipboard
      history.replaceState(null, '', link);
      this.say('The link that opens this page with your code stands in the address bar now.');
    }
  }

  download() {
    const url = URL.createObjectURL(new Blob([this.editor.text], { type: 'text/x-python' }));
    el('a', { href: url, download: this.file }).click();
    setTimeout(() => URL.revokeObjectURL(url), 1000);
  }

  /** Escape in the editor leaves the editor, not the workspace. */
  leave(event) {
    if (event.key !== 'Escape' || event.defaultPrevented) return;
    event.preventDefault();
    this.scenario.focus();
  }
}

/** Have what follows the # in the address bar. */
function stand(hash) { history.replaceState(null, '', location.pathname + location.search + hash); }

function options(titles) {
  return Object.entries(titles).map(([name, title]) => el('option', { value: name }, `${name}: ${title}`));
}

/** A plain field, where the editor can't be had. */
function plainEditor(parent, text, label, onChange) {
  const area = el('textarea', { 'aria-label': label, spellcheck: 'false', autocapitalize: 'off', oninput: onChange });
  area.value = text;
  parent.append(area);
  return {
    get text() { return area.value; },
    set text(value) { area.value = value; onChange(); },
    mark() {},
    focus() { area.focus(); },
  };
}

// --- the block in the page --------------------------------------------------------------------------

const place = document.querySelector('.workspace-block');
const read = async (name) => (await fetch(new URL(name, HERE), { cache: 'no-cache' })).json();
const manifest = place ? await read('manifest.json') : {};
if (place) {
  const { exercises, demos } = await read('plan.json');
  const workspace = new Workspace(exercises[place.dataset.exercise], demos, place);
  place.querySelector('.workspace-words').textContent = 'Write the node here, drive it and have it checked, in this '
    + 'browser: nothing is installed, and nothing leaves this machine. The first visit fetches 12 MB.';
  place.querySelector('.workspace-open').replaceChildren(
    el('button', { type: 'button', class: 'ws-main', onclick: () => workspace.open() }, 'Open the workspace'));
  document.body.dataset.workspace = 'ready';
  const asked = () => {
    const code = /^#code=(.*)/.exec(location.hash);
    if (code || location.hash === '#workspace') workspace.open(code && code[1]);
  };
  addEventListener('hashchange', asked);
  asked();
  new MutationObserver(() => document.querySelectorAll('.ws-replay iframe').forEach((f) => workspace.shade(f)))
    .observe(document.body, { attributeFilter: ['data-theme'] });
}
