// What was typed, its versions, and what is different between two. Several files are one text, each behind its name.

import { el } from './element.js';

export const KEPT = 20; // versions; in grader/cli/progress.py, too
export const OWN = 50; // scenarios of one's own, as well
const RELOAD = 3000; // [ms] in which a tab that is loaded again is back
const AROUND = 2; // lines around a change

/** Return the text of several files, by their names; one file is its own text. */
export function joined(files) {
  const [first, ...more] = Object.entries(files);
  return more.length ? [first, ...more].map(([name, text]) => `\f# ${name}\n${text}`).join('\n') : first[1];
}

/** Return the files of a text; those that it does not have are the skeletons'. */
export function split(text, skeletons) {
  const names = Object.keys(skeletons);
  const [start, ...parts] = text.split(/(?:^|\n)\f# (.+)\n/);
  if (names.length === 1 || !parts.length) return { ...skeletons, [names[0]]: text };
  const found = { ...skeletons };
  for (let i = 0; i < parts.length; i += 2) if (names.includes(parts[i])) found[parts[i]] = parts[i + 1];
  return found;
}

export const keyOf = (slug) => `course-workspace:${slug}`;

const isVersion = (each) => typeof each?.text === 'string' && typeof each.points === 'string' && !Number.isNaN(Date.parse(each.at));

/** Return what this browser keeps of an exercise, and the `rest` that is nothing of this. */
export function keptOf(slug) {
  const { text, versions, green, scenarios, ...rest } = JSON.parse(localStorage.getItem(keyOf(slug))) || {};
  return {
    text: typeof text === 'string' ? text : null,
    versions: Array.isArray(versions) ? versions.filter(isVersion) : [],
    green: isVersion(green) ? green : null,
    scenarios: scenarios ?? {},
    rest,
  };
}

/** Return whether a figure of a race beats another, if there is one. */
export const isBetter = (figure, other, unit) => Number.isFinite(figure)
  && (!Number.isFinite(other) || (unit === 's' ? figure < other : figure > other));

/** What a version's mark is of. */
const KINDS = [/^\d+ of \d+$/, /seed \d+/, /^race: /];
const kindOf = (mark) => KINDS.findIndex((kind) => kind.test(mark));

/** Return the marks of a text, a check's first: of each kind the newer. */
export function marks(newer, older = '') {
  const all = [...newer.split('; '), ...older.split('; ')];
  const found = KINDS.map((_, i) => all.find((mark) => kindOf(mark) === i)).filter(Boolean);
  return found.length ? found.join('; ').slice(0, 100) : newer;
}

/** Return a scenario's file name that is none of these yet. */
export function freeName(scenarios, name) {
  const stem = name.replace(/\.toml$/, '').slice(0, 70);
  let number = 1;
  const next = () => (number === 1 ? `${stem}.toml` : `${stem}_${number}.toml`);
  while (next() in scenarios) number += 1;
  return next();
}

/** The reader's text and versions of it, kept by the browser; `works` is false where it keeps nothing. */
export class Shelf {
  constructor(slug) {
    this.key = keyOf(slug);
    this.works = true;
    try {
      this.read();
      this.save();
    } catch {
      this.works = false;
      this.kept = {};
    }
  }

  read() { this.kept = JSON.parse(localStorage.getItem(this.key)) || {}; }

  /** Return whether no other tab has this shelf, and keep nothing if one has; until this one is closed, none gets it. */
  isAlone() {
    if (!navigator.locks) return true; // without https
    return new Promise((resolve) => {
      navigator.locks.request(this.key, { ifAvailable: true }, (lock) => {
        this.isElsewhere = !lock;
        this.works &&= Boolean(lock);
        if (this.works) this.read(); // another may have had it meanwhile
        resolve(Boolean(lock));
        return lock && new Promise(() => {});
      }).catch(() => resolve(true));
    });
  }

  /** Wait until the other tab is closed: keep again, and its text as a version. */
  async whenAlone() {
    do {
      await navigator.locks.request(this.key, () => {}); // the other tab is closed, or is just being loaded again
      await new Promise((resolve) => { setTimeout(resolve, RELOAD); });
    } while (!await this.isAlone());
    this.read();
    this.works = true;
    if (this.text !== null) this.add(this.text, 'of the other tab');
  }

  get text() { return typeof this.kept.text === 'string' ? this.kept.text : null; }

  set text(text) {
    this.kept.text = text;
    this.save();
  }

  get versions() { return Array.isArray(this.kept.versions) ? this.kept.versions : []; }

  /** Keep a version; what a check, one with a seed and a race have said of the same text stands side by side. */
  add(text, points, green = false) {
    const before = this.versions.find((other) => other.text === text);
    const version = { text, points: marks(points, before?.points), at: new Date().toISOString() };
    const others = this.versions.filter((other) => other.text !== text);
    this.kept.versions = [version, ...others].slice(0, KEPT);
    if (green) this.kept.green = version; // the last one that passed all checks
    this.save();
  }

  /** The reader's best in each world of a race, by the world: its lap and its track. */
  get bests() { return this.kept.race && typeof this.kept.race === 'object' ? this.kept.race : {}; }

  keepBest(world, best) {
    this.kept.race = { ...this.bests, [world]: best };
    this.save();
  }

  /** Scenarios of one's own: their TOML, by their files. */
  get scenarios() { return this.kept.scenarios ?? {}; }

  /** Keep one; return under which name. */
  addScenario(name, content) {
    const found = Object.keys(this.scenarios).find((each) => this.scenarios[each] === content);
    const file = found ?? freeName(this.scenarios, name);
    this.kept.scenarios = Object.fromEntries(Object.entries({ ...this.scenarios, [file]: content }).slice(-OWN));
    this.save();
    return file;
  }

  get green() { return typeof this.kept.green?.text === 'string' ? this.kept.green : null; }

  save() {
    if (!this.works) return;
    try {
      localStorage.setItem(this.key, JSON.stringify(this.kept));
    } catch {
      this.works = false; // full, or switched off meanwhile
    }
  }
}

/** Return the lines of two texts as [sign, line]: '-' only in the first, '+' only in the second, ' ' in both. */
function compared(before, after) {
  const [a, b] = [before.split('\n'), after.split('\n')];
  const common = Array.from({ length: a.length + 1 }, () => new Uint16Array(b.length + 1)); // lines, from there to the ends
  for (let i = a.length - 1; i >= 0; i -= 1) {
    for (let j = b.length - 1; j >= 0; j -= 1) {
      common[i][j] = a[i] === b[j] ? common[i + 1][j + 1] + 1 : Math.max(common[i + 1][j], common[i][j + 1]);
    }
  }
  const lines = [];
  for (let [i, j] = [0, 0]; i < a.length || j < b.length;) {
    if (i < a.length && a[i] === b[j]) [lines[lines.length], i, j] = [[' ', a[i]], i + 1, j + 1];
    else if (j === b.length || (i < a.length && common[i + 1][j] >= common[i][j + 1])) [lines[lines.length], i] = [['-', a[i]], i + 1];
    else [lines[lines.length], j] = [['+', b[j]], j + 1];
  }
  return lines;
}

/** Show what has changed in a file, with a few lines around it. */
export function showChanges(name, before, after) {
  const lines = compared(before, after);
  const near = (i) => lines.slice(Math.max(0, i - AROUND), i + AROUND + 1).some(([sign]) => sign !== ' ');
  const shown = lines.map(([sign, line], i) => (near(i) ? el('span', { 'data-sign': sign }, `${sign} ${line}\n`) : null));
  return el('pre', { class: 'ws-changes', tabindex: 0, 'aria-label': `Changes in ${name}` },
    shown.filter((line, i) => line || shown[i - 1]).map((line) => line || el('span', {}, '⋯\n')));
}
