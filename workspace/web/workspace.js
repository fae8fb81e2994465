// A workspace: an editor, the robot and its replay, all of them in this browser. What a check or a drive says
// stands in a third pane: exercise.js and program.js have it. Python runs in worker.js; no file here waits for it.

import { hasStacks, missing } from './able.js';
import { el } from './element.js';
import { Hand } from './hand.js';
import { keepForLater } from './keep.js';
import { packed, stand, unpacked } from './links.js';
import { Look } from './look.js';
import { PATIENCE, Stopped } from './machine.js';
import { Shelf, joined, split } from './shelf.js';

const HERE = new URL('.', import.meta.url);
export const FOLDER = '/home/reader'; // where the worker puts the node
const LONGEST = 8000; // [characters] of a link: longer ones are cut where they are passed on
const NOTHING_KEPT = 'This browser keeps nothing for this site: download your file before you leave the page.';
const NO_MEMORY = 'The browser had no memory left: your node may keep or print too much. What you typed is not lost.';
const BROKEN_PYTHON = 'Your node broke Python itself, with os.abort() or something that is nested too deeply. It starts anew.';
const WHY_WRONG = 'If your node changes numpy, builtins or sys.modules, that is why; if not, reload the page.';
const SLOW = 5; // [s] of a drive that say nothing of the node yet
const SLOWLY = ', more slowly than a robot drives: the machine is busy, or a callback computes too long';
const ELSEWHERE = 'This is open in another tab, too: what you type here is kept once that one is closed.';
const FREE = 'The other tab is closed: what you type here is kept again. Its text is among the versions.';
const KEYS = 'Ctrl-] and Ctrl-[ indent, an arrow key chooses a word, Tab leaves the editor, F6 goes to the next pane.';
const PLACES = { code: '.ws-text:not([hidden]) :is(.cm-content, textarea)', replay: 'iframe, .ws-task', result: '.ws-result, .ws-below[open] summary' };
const BROKEN = 'The link to this page holds no code that can be read: it was cut on its way, or is longer than any node. '
  + 'Ask for the file instead.';

/** Return a button. */
export const button = (text, act, more = {}) => el('button', { type: 'button', onclick: act, ...more }, text);

/** Tell a replay whether the site is light or dark, and more: whether to play, or from when on [s], and whether to tell of itself. */
function tell(frame, more = {}) { frame.contentWindow?.postMessage({ theme: document.body.dataset.theme, ...more }, '*'); }

/** Put the focus on the first of these that is shown; return it. */
function focusFirst(places) {
  const place = [...places].find((each) => each?.isConnected && each !== document.body && each.getClientRects().length);
  if (place && place !== document.activeElement) place.focus();
  return place;
}

/** Say in a sentence why this page can't run a node; '' if it can. */
function whyNot(what, threads) {
  if (missing.length) return `The workspace needs ${missing.join(' and ')}, which this browser hasn’t, or has switched off.`;
  if (threads && !hasStacks) {
    return `This ${what} needs threads, for which a page wants JSPI (WebAssembly.Suspending): this browser has none. `
      + 'What needs no threads runs here; the installed course runs all.';
  }
  return '';
}

let bundle; // of the editor, compressed when the page was built: plain servers compress nothing

async function editorBundle() {
  const { body } = await fetch(new URL('editor.js.pack', HERE));
  const code = await new Response(body.pipeThrough(new DecompressionStream('gzip'))).arrayBuffer();
  return import(URL.createObjectURL(new Blob([code], { type: 'text/javascript' })));
}

export class Workspace {
  /**
   * Make one: its `what` ("exercise"), the `skeletons` that *Reset* brings back, by their files, and their `origin`, the
   * `shelf` that keeps what is typed, `words` that the editor offers, and whether `threads` are needed.
   */
  constructor({ what, skeletons, origin, shelf, words, threads }, machine) {
    Object.assign(this, { skeletons, origin, words, machine });
    this.names = Object.keys(skeletons);
    [this.file] = this.names; // that is shown
    this.editors = {};
    this.shelf = new Shelf(shelf);
    this.whyNot = whyNot(what, threads);
    this.busy = false;
    this.playing = []; // scenarios of the replay
    this.runs = {}; // by scenario: how each was made
  }

  /** What stands in the address bar while it is open. */
  get hash() { throw new Error('of each kind'); }

  /** Build the dialog: `tools` in its bar, `fileTools` and `more` of its kind, `panes` by their names: the third is its own. */
  build({ label, title, tools, fileTools = [], more = '', result, names, empty }) {
    this.status = el('p', { class: 'ws-status', role: 'status' });
    this.warning = el('p', { class: 'ws-question', hidden: true });
    this.question = el('div', { class: 'ws-question', hidden: true, role: 'alert' });
    this.stopButton = button('Stop', () => this.machine.stop(), { hidden: true });
    this.versions = el('select', { 'aria-label': 'Earlier versions', onchange: () => this.restore(),
      onkeydown: (event) => { // or each arrow would take a version at once
        if (!/^Arrow/.test(event.key) || !this.versions.showPicker) return;
        event.preventDefault();
        this.versions.showPicker();
      } });
    this.code = el('div', { class: 'ws-code', 'data-pane': 'code' },
      el('p', { class: 'ws-keys' }, KEYS));
    this.fileTabs = this.names.map((name) => button(name, () => this.showFile(name), { 'aria-pressed': 'false' }));
    if (this.names.length > 1) this.code.append(el('nav', { class: 'ws-files', 'aria-label': 'Files' }, this.fileTabs));
    this.replay = el('div', { class: 'ws-replay', 'data-pane': 'replay' }, el('p', { class: 'ws-empty' }, empty));
    const seek = (moment) => tell(this.replay.querySelector('iframe'), { from: moment, stays: true });
    this.hand = new Hand({
      act: (from) => this.drive(from),
      seek,
      save: (name, content) => this.keepScenario(name, content),
      say: (text) => this.say(text),
      commandOf: (file) => this.commandOf(file),
    });
    this.look = new Look({ seek, run: (...what) => this.lookInto(...what), mark: (...what) => this.markPlace(...what) });
    this.log = el('pre', { class: 'ws-log', hidden: true, tabindex: 0, 'aria-label': 'What Python said' });
    this.stale = el('p', { class: 'ws-stale', hidden: true }, 'Said before your last change:');
    this.tabs = ['code', 'replay', 'result'].map((name, i) => button(names[i],
      () => this.show(name), { 'aria-pressed': String(name === 'code'), 'data-name': name }));
    this.dialog = el('dialog', {
      class: 'workspace', 'aria-label': label, 'data-show': 'code', onclose: () => stand(''),
      onkeydown: (event) => event.stopPropagation(), // the site's own shortcuts: "/" goes to its search
    },
      el('div', { class: 'ws-bar' },
        el('h2', {}, title),
        el('div', { class: 'ws-tools' }, tools),
        el('div', { class: 'ws-tools ws-file' },
          this.versions, fileTools,
          button('Reset', () => this.reset(), { title: `Begin with ${this.origin} again${this.names[1] ? ', in this file' : ''}` }),
          button('Link', () => this.share(), { title: 'A link that carries your code' }),
          button('Download', () => this.download(), { title: this.names[1] ? 'The file that is shown' : this.file })),
        more, button('Close', () => this.dialog.close(), { class: 'ws-close' })),
      el('div', { class: 'ws-news' }, this.status, this.stopButton, this.question, this.warning),
      el('nav', { class: 'ws-tabs', 'aria-label': 'Show' }, this.tabs),
      el('div', { class: 'ws-panes' }, this.code, this.replay, this.hand.element, this.look.element,
        el('div', { class: 'ws-result', 'data-pane': 'result', role: 'region', tabindex: 0, 'aria-label': names[2] }, this.stale, result, this.log)));
    addEventListener('keydown', (event) => { // before the editor
      if (!this.press(event)) return;
      event.preventDefault();
      event.stopPropagation();
    }, true);
    addEventListener('message', ({ data, source }) => {
      if (source !== this.replay.querySelector('iframe')?.contentWindow) return;
      this.press(data?.pressed ?? {}); // in the replay
      this.hand.hear(data ?? {});
      this.look.hear(data ?? {});
    });
    document.body.append(this.dialog);
    this.mains = [...this.dialog.querySelectorAll('.ws-main')];
    this.listVersions();
    this.enable();
    new MutationObserver(() => this.replay.querySelectorAll('iframe').forEach((frame) => tell(frame)))
      .observe(document.body, { attributeFilter: ['data-theme'] });
    addEventListener('beforeunload', (event) => { if (!this.shelf.works && this.changed) event.preventDefault(); });
  }

  /** Show the workspace; `code` is what a link brought along. Return when it is ready. */
  async open(code = null) {
    if (!this.dialog.open) this.dialog.showModal();
    stand(this.hash); // a reload comes back here, and does not bring the link's code again
    this.machine.serve(this);
    if (!this.editor) {
      if (!await this.shelf.isAlone()) this.shelf.whenAlone().then(() => this.keepAgain());
      this.listVersions();
      await this.makeEditor();
    }
    if (matchMedia('(pointer: fine)').matches) this.editor.focus();
    const said = code === null ? [] : [await this.take(code)];
    if (!this.shelf.works) this.warn(this.shelf.isElsewhere ? ELSEWHERE : NOTHING_KEPT);
    this.say(said.join(' '));
    if (this.whyNot) this.say([this.whyNot, ...said].join(' '));
    else {
      const ready = this.work(() => this.machine.ready(), ['Ready.', ...said].join(' '));
      this.machine.first.warm.then(() => keepForLater(this.machine.manifest, this.pages)).catch(() => {}); // not by http, not in a private window
      await ready;
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
    const files = split(this.shelf.text ?? this.skeleton, this.skeletons);
    const onChange = () => {
      this.changed = true;
      this.stale.hidden = this.judged === undefined || this.judged === this.text;
      this.compare();
      this.shelf.text = this.isChanged ? this.text : null;
    };
    bundle ??= await editorBundle().catch(() => null);
    const make = bundle?.makeEditor || plainEditor;
    for (const [name, text] of Object.entries(files)) {
      const parent = el('div', { class: 'ws-text', 'data-file': name, onkeydown: stay });
      this.code.append(parent);
      const label = `Your node, ${name}. Tab leaves the editor.`;
      this.editors[name] = make({ parent, text, label, onChange, words: this.words });
    }
    this.showFile(this.file);
  }

  /** The editor of the file that is shown. */
  get editor() { return this.editors[this.file]; }

  /** What stands in the editors, as one text. */
  get text() { return joined(Object.fromEntries(this.names.map((name) => [name, this.editors[name].text]))); }

  get skeleton() { return joined(this.skeletons); }

  get isChanged() { return this.text !== this.skeleton; }

  /** Do what a shortcut says, wherever the focus is: on nothing, too, or in the replay. Return whether it says anything. */
  press({ ctrlKey, key, shiftKey }) {
    const act = this.dialog.open && (key === 'F6' ? this.step : ctrlKey && key === 'Enter' && (shiftKey ? this.check : this.drive));
    if (act) act.call(this, key === 'F6' ? (shiftKey ? -1 : 1) : undefined);
    return Boolean(act);
  }

  /** Go to the next pane, or to the one before. */
  step(by) {
    const names = Object.keys(PLACES);
    const at = document.activeElement;
    const now = at.closest('.ws-below') ? 2 : names.indexOf(at.closest('[data-pane]')?.dataset.pane);
    for (const on of [1, 2, 3]) {
      const name = names.at((now + by * on) % 3);
      this.show(name);
      if (focusFirst(this.dialog.querySelectorAll(PLACES[name]))) return;
    }
  }

  get pages() { return []; } // to be kept for a visit without a network, besides its own

  // --- what is shown

  /** Say what goes on being true, above what is under way. */
  warn(text) {
    this.warning.textContent = text;
    this.warning.hidden = !text;
  }

  /** The other tab is closed. */
  keepAgain() {
    this.warn('');
    this.shelf.text = this.isChanged ? this.text : null;
    this.listVersions();
    this.say(FREE);
  }

  say(text) { this.status.textContent = text; }

  /** Note of which text the third pane speaks. */
  speakOf(text) {
    this.judged = text;
    this.stale.hidden = text === this.text;
    [this.stale.parentElement.scrollTop, this.isNew] = [0, true];
  }

  /** Say below the replay if another text made it. */
  compare() {
    const isOther = (name) => this.runs[name] && this.runs[name][2] !== this.text;
    this.dialog.classList.toggle('is-changed', this.playing.some(isOther));
  }

  showFile(name) {
    const at = this.code.contains(document.activeElement); // and would be on nothing
    this.file = name;
    this.code.querySelectorAll('.ws-text').forEach((part) => { part.hidden = part.dataset.file !== name; });
    this.fileTabs.forEach((tab) => tab.setAttribute('aria-pressed', String(tab.textContent === name)));
    if (at) this.editor.focus();
  }

  show(name) {
    const at = document.activeElement;
    this.dialog.dataset.show = name;
    this.tabs.forEach((tab) => tab.setAttribute('aria-pressed', tab.dataset.name === name));
    if (name === 'result' && this.isNew) [this.stale.parentElement.scrollTop, this.isNew] = [0, false];
    if (this.dialog.contains(at)) focusFirst([at, ...this.tabs.filter((tab) => tab.dataset.name === name)]); // in a narrow window it went
  }

  hear(hand, { kind, text, seconds }) {
    if (kind === 'progress' && hand === this.machine.first) this.say(text);
    if (kind === 'out' && !this.again) {
      this.log.hidden = false;
      this.log.textContent = `${this.log.textContent}${text}\n`.slice(-20000);
    }
    if (kind === 'reached') {
      this.question.hidden = true;
      const took = (performance.now() - hand.began) / 1000; // [s]
      this.say(`${hand.doing}: ${seconds.toFixed(1)} s driven${took > Math.max(SLOW, seconds) ? SLOWLY : ''}`);
    }
  }

  /** Python says nothing: whether to wait is the reader's choice. */
  ask(hand) {
    this.question.replaceChildren(
      el('span', {}, `Time has stood still for ${PATIENCE} s (${hand.where}, after ${hand.reached.toFixed(1)} s): `
        + 'the node computes, or a loop never ends. '),
      button('Wait', () => { this.question.hidden = true; hand.watch(); }),
      button('Stop it', () => this.machine.stop()));
    this.question.hidden = false;
  }

  enable() { this.mains.forEach((main) => { main.setAttribute('aria-disabled', this.busy || Boolean(this.whyNot)); }); } // and keep the focus

  // --- what is done

  /** Say that a file is empty, if one is; return whether all can be run. */
  isThere() {
    const empty = this.names.find((name) => !this.editors[name].text.trim());
    if (!empty) return true;
    this.showFile(empty);
    this.say(`${empty} is empty: Reset begins with ${this.origin} again.`);
    return false;
  }

  /** Do what takes the worker's time, unless something is under way; return when that has ended. */
  work(task, done) {
    if (!this.busy) this.current = this.begin(task, done);
    return this.current;
  }

  /** Do it; say how it ended. */
  async begin(task, done) {
    const at = document.activeElement;
    this.busy = true;
    this.dialog.setAttribute('aria-busy', 'true');
    this.enable();
    this.stopButton.hidden = false;
    try {
      const said = await task();
      this.say(done || said);
    } catch (error) {
      if (this.machine.user === this) { // what others are at is of no use any more
        if (error instanceof Stopped) this.machine.stop();
        else this.machine.renew();
      }
      const text = String(error.message || error);
      if (error instanceof Stopped) this.say('Stopped.');
      else if (/out of memory|allocat|MemoryError/i.test(text)) this.say(NO_MEMORY);
      else if (/call stack|out of bounds|unreachable|Aborted|fatal/i.test(text)) this.say(BROKEN_PYTHON);
      else this.say(`Python went wrong, outside your node: ${text.trim().split('\n').at(-1)}. ${WHY_WRONG}`);
      if (!(error instanceof Stopped)) this.hear(null, { kind: 'out', text });
    }
    this.busy = false;
    this.dialog.setAttribute('aria-busy', 'false');
    this.enable();
    this.stopButton.hidden = this.question.hidden = true;
    focusFirst([document.activeElement, at, ...this.dialog.querySelectorAll('.ws-replay iframe'), this.mains[0]]);
  }

  /** Run a text's `file`, by a `call` of workspace.runtime.Runtime; a scenario of one's `own` lies beside it. Return what it says, and its recording. */
  async run(hand, call, order, text, kept = {}) {
    const { file = this.names[0], own, ...orders } = order;
    const files = { ...own, ...split(text, this.skeletons) };
    const [ended, recordings] = await hand.call(call, { ...orders, file: `${FOLDER}/${file}` }, { files, recordings: kept });
    if ('lead' in ended) return this.run(hand, call, { ...order, lead: ended.lead }, text, recordings);
    if (!order.look) this.runs[ended.scenario] = [call, order, text, kept];
    return [ended, recordings];
  }

  /** Make a run of the replay again, to look into moments [s] of it, perhaps of one `callback`; return what is told of them. */
  async lookInto(number, at, callback) {
    const made = this.runs[this.playing[number]];
    if (this.busy || !made) return undefined;
    const [call, order, text, kept] = made;
    let tables;
    await this.work(async () => {
      this.again = true; // what it prints is known
      try {
        const hand = await this.machine.ready();
        hand.doing = 'Once more, to look into it';
        [{ tables }] = await this.run(hand, call, { ...order, look: at, callback }, text, kept);
      } finally {
        this.again = false;
      }
      return `What ran by ${at.map((moment) => `${moment.toFixed(2)} s`).join(' and ')} stands below the replay.`;
    });
    return this.text === text ? tables : tables?.map((table) => ({ ...table, place: '' }));
  }

  /** Mark a place, "node.py, line 12", if it is in the editors. */
  markPlace(place, message) {
    const [, file, line] = /^(.*), line (\d+)$/.exec(place) || [];
    this.unmark('info');
    if (!(file in this.editors)) return;
    this.markLine(Number(line), message, file, 'info');
  }

  /** Show the replay of a drive; return in a sentence how it ended. */
  async showDrive(ended, scenario, recordings, title, from) {
    await this.play([scenario], [], recordings, title, { play: ended.kind === 'completed', from, stays: true });
    this.hand.show(ended, recordings);
    const answer = from === undefined ? '' : this.hand.answer; // of a deed, and not said again
    if (ended.kind === 'completed') return [`${answer}Driven to the end of ${scenario}.`, ...ended.ended.map((said) => `${said}.`)].join(' ');
    this.mark({ where: ended.where, message: ended.text });
    return `${answer}${scenario} ended early: ${ended.text}`;
  }

  /** Show replays; `how` is what their frame is told, `ghosts` drive along. */
  async play(scenarios, checks, recordings, title, how = {}, ghosts = {}) {
    const [html] = await this.machine.call('replay', { scenarios, checks, title, ghosts }, { recordings });
    const frame = el('iframe', { title: 'Replay', sandbox: 'allow-scripts' });
    frame.addEventListener('load', () => tell(frame, { hands: true, ...how }));
    frame.srcdoc = html;
    this.replay.replaceChildren(frame);
    this.hand.element.hidden = true;
    this.playing = scenarios;
    this.compare();
    if (how.from === undefined) this.hand.element.open = this.look.element.open = false; // what is said of the run stands there
    this.look.begin();
  }

  /** Mark the line that was being run when a check failed, or the one that led to the last message before. */
  mark({ where, file, line, message }) {
    this.unmark();
    const died = [...(where || '').matchAll(/line (\d+)(?: of ([^\s,]+))?/g)].find(([, , of = this.file]) => of in this.editors);
    if (died) this.markLine(Number(died[1]), message, died[2]);
    else if (line) this.markLine(line, `${message}. The last message before that came from this line.`, file);
  }

  markLine(line, message, file = this.file, severity = 'error') {
    this.showFile(file);
    this.editor.mark(line, message, severity, this.stale.hidden); // a cursor in other text stays
  }

  unmark(severity) { Object.values(this.editors).forEach((editor) => editor.mark(0, '', severity)); }

  // --- the file

  listVersions() {
    const { versions } = this.shelf;
    this.versions.replaceChildren(el('option', { value: '' }, 'Versions'),
      ...versions.map(({ at, points }, i) => el('option', { value: i }, `${new Date(at).toLocaleString()}: ${points}`)));
    this.versions.disabled = !versions.length;
  }

  restore() {
    const version = this.shelf.versions[Number(this.versions.value)];
    if (this.versions.value !== '' && version) this.replace(version.text);
    this.versions.value = '';
  }

  reset() { this.replace(joined({ ...split(this.text, this.skeletons), [this.file]: this.skeletons[this.file] })); }

  /** Put another text into the editors; what was there stays among the versions. */
  replace(text) {
    const before = this.text;
    const isKept = before === this.skeleton || this.shelf.versions.some((version) => version.text === before);
    if (!isKept) this.shelf.add(before, 'put aside');
    for (const [name, part] of Object.entries(split(text, this.skeletons))) this.editors[name].text = part;
    this.listVersions();
    if (before !== this.skeleton && before !== text) this.say('What was here before is among the versions.');
  }

  /** Copy a link that carries the code. */
  async share() {
    const hash = `${this.hash}&code=${await packed(this.text)}`;
    const link = location.href.split('#')[0] + hash;
    if (link.length > LONGEST) {
      this.say('Your code is too long for a link. Download the file, and send that.');
      return;
    }
    try {
      await navigator.clipboard.writeText(link);
      this.say('Copied: a link that opens this page with your code.');
    } catch { // only pages of https have the clipboard
      stand(hash);
      this.say('The link that opens this page with your code stands in the address bar now.');
    }
  }

  download() { this.save(this.file, this.editor.text, 'text/x-python'); }

  /** Save a scenario of one's own; return under which name. */
  keepScenario(name, content) {
    this.save(name, content, 'text/plain');
    this.say(`Saved: ${name}.`);
    return name;
  }

  save(name, content, type) {
    const url = URL.createObjectURL(new Blob([content], { type }));
    el('a', { href: url, download: name }).click();
    setTimeout(() => URL.revokeObjectURL(url), 1000);
  }
}

/** Escape closes what lies over the editor, never the workspace around it. */
function stay(event) { if (event.key === 'Escape') event.preventDefault(); }

/** A plain field, where the editor can't be had. */
function plainEditor({ parent, text, label, onChange }) {
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
