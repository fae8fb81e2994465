// What a person does in a drive: turns the node's own knobs, presses the e-stop, sends a goal, covers the lidar, puts a box down.
// The same node with the same deeds makes the same run. So a deed at a moment of the replay has the drive made again with it,
// and the replay goes on from there.

import { hasStacks } from './able.js';
import { el, Moment } from './element.js';

const FIRST = 0.5; // [s] by then programs have found each other
const COVERED = 1; // [s]
const GOAL = '/goal_pose';
const NEEDS = { e_stop: '/e_stop', covers: '/scan', box: '/scan', goal: GOAL }; // what a node has to hear
const NO_STACKS = 'To turn its knobs, a page needs JSPI (WebAssembly.Suspending), which this browser hasn’t.';

const WORDS = 'to ROS “nan” and “inf” are texts; as numbers they are written .nan and .inf';

const place = ([x, y]) => `(${x.toFixed(2)}, ${y.toFixed(2)})`;
const bare = (node) => node.replace(/^\//, '');

/** What was done, in words; those of `done` that Python tells are the same. */
function wordsOf({ sets, e_stop: stop, goal, covers, box }) {
  if (sets) return sets;
  if (stop !== undefined) return `e-stop ${stop ? 'pressed' : 'released'}`;
  if (goal) return `goal ${place(goal)}`;
  return box ? `a box at ${place(box)}, from the start` : `lidar covered for ${covers} s`;
}

/** The step of a slider over a span: a power of ten, and at least fifty of them. */
const fine = (span) => 10 ** Math.floor(Math.log10(span / 50));

export class Hand {
  /** `act` drives again, and shows it from a moment on; what it returns ends with that. `seek` moves the replay. */
  constructor({ act, seek, save, say, commandOf }) {
    Object.assign(this, { act, save, say, commandOf });
    this.deeds = this.settled = this.there = [];
    this.at = 0;
    [this.now, this.can] = [el('span', {}), el('span', { class: 'ws-can' })];
    this.moment = new Moment('of the replay', (at) => {
      this.update(at);
      seek(at);
    });
    this.body = el('div', { class: 'ws-hand-body' });
    this.element = el('details', { class: 'ws-below ws-hand', 'data-pane': 'replay', name: 'ws-below', hidden: true },
      el('summary', {}, 'By hand', this.now, this.can),
      el('p', { class: 'ws-since' }, 'Your code has changed since. What you do here drives the changed code.'),
      this.moment.element, this.body);
  }

  /** What was done belongs to a drive, called by its words: in another, nothing has been done yet. */
  begin(drive) {
    if (drive !== this.drive) [this.deeds, this.settled, this.last] = [[], [], null];
    this.drive = drive;
  }

  /** What a drive's order says of it. */
  get order() { return this.deeds.length ? { deeds: this.deeds, scenario: this.scenario } : {}; }

  /** Show what a drive had to turn, and what was done. */
  show({ scenario, hand }, recordings) {
    if (!this.deeds.length) this.scenario = scenario;
    this.saved = [`${scenario}.toml`, recordings[`${scenario}.toml`]];
    [this.done, this.settled] = [hand.done, this.deeds];
    const shown = JSON.stringify([hand.hears, hand.knobs.map(({ values, ...knob }) => knob)]);
    if (shown !== this.shown) this.build(hand);
    this.shown = shown;
    hand.knobs.forEach(({ values }, i) => { this.knobs[i].values = values; });
    this.list();
    this.element.hidden = false;
    this.update();
  }

  /** Where the replay stands, or where somebody clicked on its map. */
  hear({ at, duration, place: there }) {
    if (Number.isFinite(duration)) this.moment.end = duration;
    if (Number.isFinite(at)) this.update(this.moment.typed ?? at);
    if (Array.isArray(there) && there.length === 2 && there.every(Number.isFinite)) {
      this.there.forEach((field, i) => { field.value = there[i].toFixed(2); });
    }
  }

  /** The answer to what was done last. */
  get answer() {
    const said = this.last && this.saidTo(this.last);
    return this.last ? `${this.last.at.toFixed(2)} s: ${wordsOf(this.last)}${said ? `: ${said}` : ''}. ` : '';
  }

  // --- its parts

  build({ knobs, hears }) {
    const nodes = new Set(knobs.map(({ node }) => node));
    this.knobs = knobs.map((knob, i) => this.knob(knob, i, nodes.size > 1));
    const can = Object.fromEntries(Object.entries(NEEDS).map(([deed, topic]) => [deed, hears.includes(topic)]));
    const acts = [knobs.length && hasStacks && 'turn a parameter', can.e_stop && 'press the e-stop', can.goal && 'send a goal',
      can.covers && 'cover the lidar', can.box && 'put a box down'].filter(Boolean);
    this.can.textContent = acts.length ? `: ${acts.join(', ')}` : '';
    this.there = ['x', 'y'].map((axis) => el('input', { type: 'number', step: 'any', value: 0, 'aria-label': `${axis} [m]` }));
    this.stop = this.button('', () => this.do({ e_stop: !this.isStopped() }), { hidden: !can.e_stop });
    this.items = el('ol', { class: 'ws-done', 'aria-label': 'Done by hand' });
    this.saveButton = this.button('Save as a scenario', () => this.keep());
    this.command = el('p', {});
    this.body.replaceChildren(
      knobs.length ? '' : el('p', {}, 'The node has declared no parameters.'),
      knobs.length && !hasStacks ? el('p', {}, NO_STACKS) : '',
      ...(hasStacks ? this.knobs.map(({ row }) => row) : []),
      el('div', { class: 'ws-tools' }, this.stop,
        can.covers ? this.button(`Cover the lidar for ${COVERED} s`, () => this.do({ covers: COVERED })) : ''),
      can.box || can.goal ? el('div', { class: 'ws-tools ws-place' }, 'x, y [m], or click the map:', this.there,
        can.goal ? this.button('Send this goal', () => this.doThere('goal')) : '',
        can.box ? this.button('Put a box there', () => this.doThere('box')) : '') : '',
      this.items, el('div', { class: 'ws-tools' }, this.saveButton), this.command);
  }

  button(text, act, more = {}) { return el('button', { type: 'button', onclick: act, ...more }, text); }

  /** A parameter: a switch, or a field that takes anything, with a slider where it has a range. */
  knob(knob, i, named) {
    const { node, name, kind, about, limits, fixed } = knob;
    const id = `ws-knob-${i}`;
    const now = el('span', {});
    const [least, most, step] = limits.map(Number);
    const field = el('input', { id, type: kind === 'bool' ? 'checkbox' : 'text', spellcheck: 'false', autocapitalize: 'off', autocomplete: 'off',
      onkeydown: (event) => { if (event.key === 'Enter') set(); } });
    const slider = most > least ? el('input', { type: 'range', min: least, max: most, step: step || (kind === 'integer' ? 1 : fine(most - least)),
      'aria-label': `${name}, from ${least} to ${most}`,
      oninput: () => { field.value = kind === 'double' ? slider.value.replace(/^-?\d+$/, '$&.0') : slider.value; } }) : null;
    const set = () => this.set(knob, kind === 'bool' ? String(field.checked) : field.value.trim());
    const told = [about, limits.length ? `${limits[0]} to ${limits[1]}` : kind, fixed ? 'read only' : ''].filter(Boolean).join(', ');
    const row = el('div', { class: 'ws-knob' },
      el('label', { for: id }, named ? el('small', {}, `${bare(node)} `) : '', name), slider, field,
      this.button('Set', set, { 'aria-label': `Set ${name}` }), el('small', {}, `${told}; now `, now));
    return { knob, row, field, slider, now, values: [] };
  }

  /** Show what holds at a moment; what somebody is at in a field stays. */
  update(at = this.at) {
    this.at = at;
    this.now.textContent = `, at ${at.toFixed(2)} s`;
    this.moment.at = at;
    for (const each of this.knobs ?? []) {
      const { field, slider, now, values } = each;
      const value = values.findLast(([t]) => t <= at + 1e-6)?.[1] ?? '';
      if (now.textContent !== value) {
        if (!field.matches(':focus') && !slider?.matches(':focus')) {
          [field.value, field.checked] = [value, value === 'true'];
          if (slider) slider.value = value;
        }
        now.textContent = value;
      }
    }
    if (this.stop) this.stop.textContent = this.isStopped() ? 'Release the e-stop' : 'Press the e-stop';
  }

  isStopped() { return this.done.findLast(({ at, text }) => at <= this.at && text.startsWith('e-stop'))?.text === 'e-stop pressed'; }

  /** What was done, by whom, and what came of it. */
  list() {
    const own = this.deeds.map((deed) => ({ at: deed.at, deed, text: wordsOf(deed), said: this.saidTo(deed) }));
    const others = this.done.filter((each) => !this.deeds.some((deed) => this.isOf(each, deed)));
    const all = [...own, ...others].sort((a, b) => a.at - b.at);
    this.items.replaceChildren(...all.map(({ at, deed, text, said }) => el('li', { 'data-said': (said || '').split(/\W/)[0] },
      `${at.toFixed(2)} s `, el('code', {}, text), said ? `: ${said} ` : ' ',
      deed ? this.button('Undo', () => this.undo(deed), { 'aria-label': `Undo ${text} at ${at.toFixed(2)} s` }) : '(the scenario)')));
    this.items.hidden = !all.length;
    this.saveButton.hidden = !own.length;
    this.command.replaceChildren();
  }

  isOf({ at, text, node }, deed) { return at === deed.at && text === wordsOf(deed) && bare(node) === bare(deed.node || ''); }

  saidTo(deed) {
    const told = this.done.find((each) => this.isOf(each, deed));
    const isWord = /:=[+-]?(nan|inf)$/i.test(deed.sets) && / type/.test(told?.said);
    return told && (`${told.said}${isWord ? ` (${WORDS})` : ''}` || (deed.sets ? 'no answer' : ''));
  }

  // --- what is done

  set({ node, name }, value) {
    if (/\s|^$/.test(value)) this.say(`${name}: expected a value, without spaces.`);
    else this.do({ node, sets: `${name}:=${value}` });
  }

  doThere(what) {
    const there = this.there.map((field) => field.valueAsNumber);
    if (there.every(Number.isFinite)) this.do({ [what]: there });
    else this.say('x and y: expected two numbers, in metres.');
  }

  do(deed) {
    if (!deed.box && this.moment.end && this.at > this.moment.end - 0.005) return this.say('The run is over: go to a moment before its end.');
    const now = Number(Math.max(FIRST, this.at).toFixed(2));
    const made = { at: deed.box ? 0 : now, ...deed };
    return this.redo([...this.deeds, made], made);
  }

  undo(deed) { this.redo(this.deeds.filter((each) => each !== deed), null, deed.at); }

  redo(deeds, last, from = last.at) {
    [this.deeds, this.last] = [deeds, last];
    Promise.resolve(this.act(from)).then(() => { // something else was under way, or it was stopped
      if (this.deeds !== this.settled) [this.deeds, this.last] = [this.settled, null];
    });
  }

  /** Save the file that a drive was made with. */
  keep() {
    const [name, content] = this.saved;
    const file = this.save(name, new TextDecoder().decode(content));
    this.command.replaceChildren('Drive it again: ', el('code', {}, this.commandOf(file)));
  }
}
