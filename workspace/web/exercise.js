// The workspace of an exercise's page: its scenarios, and the grader's checks.

import { isJudged, runsHere } from './able.js';
import { el } from './element.js';
import { showChanges, split } from './shelf.js';
import { FOLDER, Workspace, button } from './workspace.js';

const JUDGE_EVERY = 2; // [s] while a check drives on: each time costs about half a second
const LATER = ['progress.js', 'race.js', 'race.json']; // read once wanted
const GREEN = ['pass', 'unavailable'];
const WRONG = ['fail', 'error', 'inconclusive'];
const OUTCOMES = {
  pass: '✓ passed', fail: '✗ failed', skip: '– not judged', error: '! the grader failed', inconclusive: '? undecided',
  unavailable: '– not available',
};

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

function options(titles) {
  return Object.entries(titles).map(([name, title]) => el('option', { value: name }, `${name}\u2003${title}`));
}

/** Return a plan without what this browser doesn't judge. */
function judgedHere(plan) {
  const checks = plan.checks.map((check) => (isJudged(check) ? check : { ...check, scenarios: [] }));
  const driven = Object.entries(plan.scenarios).filter(([name]) => checks.some(({ scenarios }) => scenarios.includes(name)));
  return { ...plan, checks, scenarios: Object.fromEntries(driven) };
}

export class Exercise extends Workspace {
  constructor(whole, words, demos, machine, exercises) {
    const plan = judgedHere(whole);
    super({
      what: 'exercise', skeletons: plan.skeleton, origin: 'the skeleton', shelf: plan.slug, words, threads: !whole.alone,
    }, machine);
    Object.assign(this, { plan, exercises });
    this.recordings = {}; // of the last check, by their files
    this.rows = {};
    this.own = el('optgroup', { label: 'Your own' });
    this.scenario = el('select', { id: 'ws-scenario', 'aria-label': 'Scenario' },
      el('optgroup', { label: 'Scenarios of the checks' }, options(plan.scenarios)),
      Object.keys(plan.field).length ? el('optgroup', { label: 'Other sensors and networks' }, options(plan.field)) : '',
      el('optgroup', { label: 'To try things' }, options(demos)));
    this.scenario.value = plan.first;
    this.seed = el('input', {
      id: 'ws-seed', type: 'number', min: 0, max: 1000000, placeholder: 'seed', 'aria-label': 'seed', title: 'For other worlds: a number, such as 7',
    });
    this.score = el('div', { class: 'ws-score' }, `Practice. ${runsHere(plan)} `
      + 'Your instructor’s grade comes from the real rclpy on Linux.');
    this.changesButton = button('Changes', () => this.changes(), { title: 'Since the last version that passed all checks' });
    const raced = Object.keys(plan.race).length ? el('div', { class: 'ws-tools ws-racing' },
      button('Race', () => this.race(), { class: 'ws-main' }), 'in three worlds') : '';
    this.ways = el('div', {});
    this.build({
      label: `Workspace: exercise ${plan.number}, ${plan.title}`,
      title: `${plan.number}. ${plan.title}`,
      tools: [
        button('Drive', () => this.drive(), { title: 'Ctrl-Enter', class: 'ws-main' }),
        el('label', { for: 'ws-scenario' }, 'in'), this.scenario,
        this.seed,
        button('Check', () => this.check(), { title: 'Ctrl-Shift-Enter; with a seed, in other worlds', class: 'ws-main' }),
      ],
      fileTools: [button('Task', () => this.showTask(), { title: 'What is to be done' }), this.changesButton],
      more: button('Progress', () => this.openProgress(), { title: 'Save all exercises to a file, or load one' }),
      result: [this.score, el('div', { class: 'ws-more' }, raced, this.ways), el('ol', { class: 'ws-list' }, plan.checks.map((check) => this.row(check)))],
      names: ['Code', 'Replay', 'Checks'],
      empty: 'Drive the node, or check it: its run is shown here.',
    });
  }

  get hash() { return '#workspace'; }

  get pages() { return [this.hintsPage, ...LATER.map((name) => new URL(name, import.meta.url))].map(String); }

  get hintsPage() { return new URL('hints.html', location.href); }

  // --- what is done

  /** Run a node's text in a scenario; return how it ended, and its recording. */
  trial(hand, scenario, text, more) { return this.run(hand, 'trial', { others: this.plan.files, scenario, ...more }, text); }

  /** Return the seed that is asked for, if one is; null if nothing can be begun, and why is said. */
  begun() {
    if (this.busy || !this.isThere() || this.whyNot) return null;
    if (!this.seed.checkValidity()) {
      this.say('The seed is a whole number from 0 to 1000000.');
      return null;
    }
    this.unmark();
    return this.seed.value === '' ? {} : { seed: Number(this.seed.value) };
  }

  /** Drive; show it from its start on, or from a moment. */
  drive(from) {
    const seed = this.begun();
    if (!seed) return null;
    const scenario = this.scenario.value;
    const own = this.shelf.scenarios[scenario]; // its TOML
    const [, base = scenario] = /^extends = "(\w+)"/m.exec(own) ?? [];
    this.hand.begin(`${scenario} ${this.seed.value}`);
    return this.work(async () => {
      const hand = await this.machine.ready();
      const isOwn = !this.names[1] || base in this.plan.scenarios || base in this.plan.field; // and names its programs
      const file = isOwn ? this.names[0] : this.file;
      this.ran = file;
      hand.doing = isOwn ? `Driving in ${scenario}` : `Driving ${file} in ${scenario}`;
      this.say(`${hand.doing} …`);
      const { text } = this;
      const place = own ? { exercise: this.plan.slug, scenario: `${FOLDER}/${scenario}`, own: { [scenario]: own } } : {};
      const [ended, recordings] = await this.trial(hand, scenario, text, { file, tell: true, ...seed, ...this.hand.order, ...place });
      if (!ended.scenario) return ended.printed; // one's own, and none
      if (this.judged !== text) Object.values(this.rows).forEach(({ fill }) => fill(null)); // of another text
      this.speakOf(text);
      this.score.replaceChildren(el('pre', { class: 'ws-printed', tabindex: 0, 'aria-label': 'The drive' }, ended.printed));
      this.show('replay');
      return this.showDrive(ended, ended.scenario, recordings, this.plan.title, from);
    });
  }

  commandOf(file) { return `course drive ${this.ran} --scenario ${file}${this.seed.value && ` --seed ${this.seed.value}`}`; }

  /** Check; with a seed, in other worlds that are as hard. */
  check() {
    const seed = this.begun();
    if (!seed) return null;
    const where = 'seed' in seed ? ` in the worlds of seed ${seed.seed}` : '';
    Object.values(this.rows).forEach(({ fill }) => fill(null));
    this.score.replaceChildren();
    [this.judged, this.stale.hidden] = [undefined, true];
    return this.work(async () => {
      const { text } = this;
      await this.driveAll(text, seed);
      this.say('Judging …');
      const grading = await this.judge(await this.machine.ready());
      this.chosen = seed.seed;
      this.worlds = where && Object.fromEntries(grading.recordings.map((each) => [each.scenario, each.seed]));
      this.fill(grading, this.plan.checks.map(({ id }) => id));
      const passed = !where && grading.checks.every(({ outcome }) => GREEN.includes(outcome));
      const mark = `${grading.score} of ${grading.max_score}`;
      this.shelf.add(text, where ? `seed ${seed.seed}: ${mark}` : mark, passed);
      this.listVersions();
      this.speakOf(text);
      await this.tell(grading);
      if (where) this.score.append(el('p', { class: 'ws-note' }, this.whatSeedsChange()));
      else if (passed) this.score.append(el('p', {}, this.onward()));
      return `${grading.score} of ${grading.max_score} points${where}.`;
    });
  }

  /** Return what another seed is, and is not. */
  whatSeedsChange() {
    const names = Object.keys(this.plan.field).join(', ');
    return 'A seed moves the start, what stands around and single readings, and draws other noise. The lidar, the carts and the network stay: '
      + `a node that counts beams may pass with every seed.${names && ` Other sensors and networks are in the list of scenarios: ${names}.`} `
      + 'In Versions this mark stands beside the one without a seed.';
  }

  /** Return what there is after full marks. */
  onward() {
    const { number, ways, race, field } = this.plan;
    const next = Object.values(this.exercises).find((each) => each.number === number + 1);
    const here = [ways && 'Others’ ways', Object.keys(race).length && 'a Race', 'other worlds by a number in seed',
      Object.keys(field).length && 'other sensors in the list of scenarios'].filter(Boolean).join(', ');
    return [next ? el('a', { href: `../${next.slug}/README.html#workspace` }, `Next: ${next.number}. ${next.title}`) : 'This was the last exercise', `. Here, too: ${here}.`];
  }

  /** Drive in all scenarios of the checks; on a slow machine judge what can be judged meanwhile. */
  async driveAll(text, seed) {
    const { checks } = this.plan;
    const wanted = [...new Set(checks.flatMap((check) => check.scenarios))];
    const left = [...wanted];
    const [interrupted] = Object.keys(this.plan.scenarios); // as the grader does
    let [shown, last] = [0, performance.now()];
    this.recordings = {};
    await this.machine.together(async (hand) => {
      const scenario = left.shift();
      if (!scenario) return false;
      const number = wanted.length - left.length;
      hand.doing = `Run ${number} of ${wanted.length}, ${scenario}`;
      this.say(`${hand.doing} …`);
      const [, recordings] = await this.trial(hand, scenario, text, { interrupt: scenario === interrupted, ...seed });
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

  /** Race in three worlds. */
  race() {
    if (this.busy || !this.isThere() || this.whyNot) return null;
    this.unmark();
    return this.work(async () => {
      const race = await import(new URL('race.js', import.meta.url)).catch(() => null);
      return race ? race.race(this) : 'The server did not send what a race needs. Reload the page.';
    });
  }

  async judge(hand, only = []) {
    const order = { exercise: this.plan.slug, file: this.names[0], scenarios: this.driven, only };
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
    this.sort(grading.checks);
    const first = grading.checks.find((check) => check.outcome === 'fail');
    if (!first) await this.playChecked(this.driven, grading.checks);
    else if (first.scenario) await this.playChecked([first.scenario], [first]);
    if (first) this.mark(cause && /line \d/.test(cause.where) ? { where: cause.where, message: cause.text } : first);
    this.show('result');
  }

  playChecked(scenarios, checks) { return this.play(scenarios, checks, this.recordings, this.plan.title); }

  // --- its rows

  row(check) {
    const state = el('span', { class: 'ws-state' });
    const detail = el('div', { class: 'ws-detail' });
    const title = el('span', { class: 'ws-title' });
    const atFirst = check.scenarios.length ? '' : 'unavailable';
    const row = el('li', { 'data-check': check.id },
      el('div', { class: 'ws-row' }, state, title,
        el('span', { class: 'ws-points' }, `${check.points}`)), detail);
    const fill = (result) => {
      row.dataset.outcome = result ? result.outcome : atFirst;
      title.replaceChildren((result || check).title, ' ', el('code', {}, check.id)); // one that failed at its door is called by that
      state.textContent = OUTCOMES[result ? result.outcome : atFirst] ?? '○ open';
      detail.hidden = false;
      detail.replaceChildren(...(result && result.outcome !== 'pass' ? this.details(result) : []));
    };
    fill(null);
    this.rows[check.id] = { fill, row, detail };
    return row;
  }

  /** Have what failed first, then what was not judged, and each reason for that once. */
  sort(checks) {
    const rank = ({ outcome }) => (WRONG.includes(outcome) ? 0 : 1 + GREEN.includes(outcome));
    const said = new Set();
    for (const check of [...checks].sort((a, b) => rank(a) - rank(b))) {
      const { row, detail } = this.rows[check.id];
      row.parentElement.append(row);
      detail.hidden = check.outcome === 'skip' && said.has(check.message);
      said.add(check.message);
    }
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
        seen ? button(result.time === null ? 'Show' : `Show ${result.time.toFixed(2)} s`, () => this.look(result)) : null,
        seen && this.worlds ? button('Keep this world', () => this.keepWorld(result)) : null,
        result.outcome === 'fail' && result.task ? button('A hint', (event) => this.hint(result, told, event.currentTarget)) : null),
      told,
    ].filter(Boolean);
  }

  /** Save a world in which a check failed as a scenario of one's own. */
  keepWorld({ scenario, id }) {
    const title = JSON.stringify(`${this.plan.scenarios[scenario]}, where ${id} failed with seed ${this.chosen}`);
    this.keepScenario(`${scenario}_seed${this.chosen}_${id}.toml`,
      `title = ${title}\nextends = "${scenario}"\ntrial_seed = ${this.worlds[scenario]}\n`,
      `A drive there shows what happens; Check with the seed ${this.chosen} judges it.`);
  }

  keepScenario(name, content, judged = 'Drive says whether the exercise’s least is kept there; Check does not go there.') {
    const file = this.shelf.addScenario(name, content);
    this.listVersions();
    super.keepScenario(file, content);
    this.say(`Saved: ${file}, also below Your own in the list. ${judged}`);
    return file;
  }

  look(result) {
    this.mark(result);
    this.work(async () => {
      await this.playChecked([result.scenario], [result]);
      this.show('replay');
      return result.message;
    });
  }

  /** Show the next hint of a check's task, beginning with the one for the check. */
  async hint(result, told, more) {
    try {
      this.hints ??= await readHints(this.hintsPage);
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
    more.textContent = all[told.shown] ? 'One hint more' : 'No more hints';
    more.disabled = !all[told.shown];
  }

  /** Show the page's own text where the replay stands. */
  showTask() {
    const text = document.querySelector('article').cloneNode(true);
    text.querySelectorAll('.workspace-block, .headerlink').forEach((part) => part.remove());
    text.removeAttribute('role'); // there is one main
    text.querySelectorAll('[id]').forEach((part) => part.removeAttribute('id'));
    text.querySelectorAll('pre').forEach((part) => { part.tabIndex = 0; });
    text.querySelectorAll('a').forEach((link) => { link.target = '_blank'; });
    [this.hand, this.look].forEach(({ element }) => { element.hidden = true; });
    this.replay.replaceChildren(el('div', { class: 'ws-task', tabindex: 0, 'aria-label': 'The task' }, text));
    this.show('replay');
  }

  listVersions() {
    super.listVersions();
    this.changesButton.disabled = !this.shelf.green;
    if (this.plan.ways && this.shelf.green && !this.offered) this.offerWays();
    const { value } = this.scenario;
    this.own.replaceChildren(...Object.keys(this.shelf.scenarios).map((name) => el('option', { value: name }, name)));
    if (this.own.firstChild) this.scenario.append(this.own);
    else this.own.remove();
    this.scenario.value = value;
    if (!this.scenario.value) this.scenario.selectedIndex = 0; // it went
  }

  /** Offer others' ways, once this exercise has passed all checks here. */
  async offerWays() {
    this.offered = true;
    const ways = await import(new URL('ways.js', import.meta.url)).catch(() => null);
    if (ways) this.ways.replaceChildren(await ways.offer(this));
  }

  /** Save or load the progress in all exercises. */
  async openProgress() {
    this.progress ??= await import(new URL('progress.js', import.meta.url)).then(({ progressDialog }) => progressDialog(this, this.exercises)).catch(() => null);
    if (this.progress) this.progress.showModal();
    else this.say('The server did not send what saves your progress. Reload the page.');
  }

  /** Have what was loaded. */
  takeKept() {
    this.shelf.read();
    const { text } = this.shelf;
    if (text !== null && text !== this.text) for (const [name, part] of Object.entries(split(text, this.skeletons))) this.editors[name].text = part;
    this.listVersions();
  }

  /** Show above the checks what is different from the last version that passed them all. */
  changes() {
    const { text, at } = this.shelf.green;
    const since = `what passed all checks on ${new Date(at).toLocaleString()}`;
    const [before, after] = [text, this.text].map((each) => split(each, this.skeletons));
    const changed = this.names.filter((name) => before[name] !== after[name]);
    this.score.replaceChildren(el('p', {}, changed.length ? `Changed since ${since}:` : `This is ${since}.`),
      ...changed.flatMap((name) => [this.names[1] ? el('p', {}, name) : '', showChanges(name, before[name], after[name])]));
    this.show('result');
    this.score.scrollIntoView();
  }
}
