// Progress as one file: what was written in each exercise, its versions, own scenarios. `course progress` takes and makes
// the same (grader/cli/progress.py). A file may come from anywhere: all of it is read strictly before anything is kept.

import { el } from './element.js';
import { alsoKeep } from './keep.js';
import { KEPT, OWN, freeName, isBetter, joined, keptOf, keyOf, marks, split } from './shelf.js';
import { button } from './workspace.js';

const NAME = 'course-progress.json';
const FORMAT = 'course-progress';
const MOST = 2 ** 24; // [bytes]
const [TEXT, SCENARIO] = [2 ** 20, 2 ** 16]; // [characters]
const DATE = /^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d(\.\d{1,9})?(Z|[+-]\d\d:\d\d)$/;
const FULL = 'the browser has no room for it. What was here is as it was.';

/** Why nothing was loaded. */
class Wrong extends Error {
  constructor(why) { super(`nothing was loaded: ${why}`); }
}

function must(holds, where, expected) {
  if (!holds) throw new Wrong(`${where}: expected ${expected}.`);
}

/** Return the entries of an object with no other keys than these; with none given, at most so many of any. */
function entries(value, where, keys, most = 100) {
  must(value !== null && typeof value === 'object' && !Array.isArray(value), where, 'an object');
  const all = Object.entries(value);
  must(all.length <= most, where, `at most ${most} entries`);
  for (const [key] of all) must(keys ? keys.includes(key) : key.length <= 100, where, keys ? `only ${keys.join(', ')}` : 'shorter names');
  return all;
}

function string(value, where, most) {
  must(typeof value === 'string' && value.length <= most, where, `a text of at most ${most} characters`);
  return value;
}

function date(value, where) {
  must(typeof value === 'string' && DATE.test(value) && !Number.isNaN(Date.parse(value)), where, 'a date such as 2026-11-28T09:30:00Z');
  return new Date(value).toISOString();
}

/** Return the one text of an exercise's files; `odd` gets the names of others. */
function textOf(value, where, skeleton, odd) {
  const files = entries(value, where, null, 20).map(([name, text]) => [name, string(text, `${where}, ${name}`, TEXT).replace(/\r\n?/g, '\n')]);
  files.filter(([name]) => !Object.hasOwn(skeleton, name)).forEach(([name]) => odd.add(`${where.split(',')[0]}, ${name}`));
  return joined({ ...skeleton, ...Object.fromEntries(files.filter(([name]) => Object.hasOwn(skeleton, name))) });
}

function versionOf(value, where, skeleton, odd) {
  const { files, points, at } = Object.fromEntries(entries(value, where, ['files', 'points', 'at']));
  return { text: textOf(files, where, skeleton, odd), points: string(points, where, 100), at: date(at, where) };
}

/** Return the best laps of a race, by their worlds (race.js). */
function raceOf(value, where) {
  const worlds = entries(value, where, null, 10);
  for (const [world, best] of worlds) {
    const { lap, track } = Object.fromEntries(entries(best, `${where}, ${world}`, ['lap', 'track']));
    for (const [, each] of entries(lap, `${where}, lap`, null, 20)) {
      must(each === null || Number.isFinite(each) || (typeof each === 'string' && each.length <= 200), `${where}, lap`, 'numbers and short texts');
    }
    for (const [, each] of entries(track, `${where}, track`, ['t', 'x', 'y', 'yaw'])) {
      must(Array.isArray(each) && each.length <= 2000 && each.every(Number.isFinite), `${where}, track`, 'at most 2000 numbers');
    }
  }
  return Object.fromEntries(worlds.filter(([world]) => /^[a-z]\w*$/i.test(world)));
}

/** Return what a file's text holds: its date, the work in each exercise, and what is `odd`: no exercise's. */
function read(content, exercises) {
  let all;
  try { all = JSON.parse(content); } catch { /* said below */ }
  if (all?.format !== FORMAT) {
    const start = content.trim().slice(0, 30);
    throw new Wrong(`expected ${NAME}, as Save to a file makes it; ${content.includes(`"${FORMAT}"`)
      ? 'this file was changed or cut on its way. Save it again where it was made.'
      : `this file ${start ? `begins with “${start}”` : 'is empty'}. Choose another.`}`);
  }
  const { version, at, exercises: found } = Object.fromEntries(entries(all, 'the file', ['format', 'version', 'at', 'exercises']));
  must(version === 1, 'version', '1; a newer course may have saved it, so load it there');
  const [works, odd] = [new Map(), new Set()];
  for (const [slug, value] of entries(found, 'exercises', null)) {
    const work = Object.fromEntries(entries(value, slug, ['files', 'versions', 'green', 'scenarios', 'race']));
    if (!Object.hasOwn(exercises, slug)) {
      odd.add(slug);
      continue;
    }
    const { skeleton } = exercises[slug];
    const versions = work.versions ?? [];
    must(Array.isArray(versions) && versions.length <= KEPT, `${slug}, versions`, `a list of at most ${KEPT}`);
    const scenarios = entries(work.scenarios ?? {}, `${slug}, scenarios`, null, OWN);
    for (const [name, text] of scenarios) {
      must(/^[A-Za-z0-9][A-Za-z0-9_]{0,79}\.toml$/.test(name), `${slug}, scenarios`, 'names such as my_wall.toml');
      string(text, `${slug}, ${name}`, SCENARIO);
    }
    works.set(slug, {
      text: work.files ? textOf(work.files, slug, skeleton, odd) : null,
      versions: versions.map((each, i) => versionOf(each, `${slug}, version ${i + 1}`, skeleton, odd)),
      green: work.green ? versionOf(work.green, `${slug}, green`, skeleton, odd) : null,
      scenarios: Object.fromEntries(scenarios),
      race: raceOf(work.race ?? {}, `${slug}, race`),
    });
  }
  return { at: date(at, 'at'), works, odd: [...odd] };
}

/** Return what is kept of an exercise, with what came. Of more versions than are kept the oldest go: how many, is in `gone`. */
function merged(mine, came, { skeleton, unit }, from) {
  const isNew = came.text !== null && came.text !== joined(skeleton);
  const text = mine.text ?? (isNew ? came.text : null);
  const all = [...mine.versions, ...came.versions].sort(newest);
  if (isNew && came.text !== text && !all.some((each) => each.text === came.text)) all.unshift({ text: came.text, points: `imported, from ${from}`, at: new Date().toISOString() });
  const versions = new Map(); // by their texts
  for (const each of all) {
    const other = versions.get(each.text);
    versions.set(each.text, other ? { ...other, points: marks(other.points, each.points) } : each);
  }
  const [green] = [mine.green, came.green].filter(Boolean).sort(newest);
  const scenarios = { ...mine.scenarios };
  const others = Object.entries(came.scenarios).filter(([, content]) => !Object.values(scenarios).includes(content));
  for (const [name, content] of others) scenarios[freeName(scenarios, name)] = content;
  const shown = Object.entries(scenarios).slice(0, OWN);
  const own = mine.rest.race ?? {};
  const isSlower = ([world, { lap }]) => Object.hasOwn(own, world) && !isBetter(lap.figure, own[world]?.lap?.figure, unit);
  const better = Object.entries(came.race).filter((each) => !isSlower(each));
  return {
    work: { ...mine.rest, race: { ...own, ...Object.fromEntries(better) }, text, versions: [...versions.values()].slice(0, KEPT), green, scenarios: Object.fromEntries(shown) },
    isKept: isNew && came.text !== text,
    isPut: isNew && mine.text === null,
    gone: Math.max(0, versions.size - KEPT),
    left: Object.keys(scenarios).length - shown.length,
  };
}

const newest = (a, b) => Date.parse(b.at) - Date.parse(a.at);

/** Do it while no other tab has one of these keys; it gets those that another has. */
function alone(keys, act, busy = []) {
  if (!keys.length || !navigator.locks) return act(busy);
  const [key, ...more] = keys;
  return navigator.locks.request(key, { ifAvailable: true }, (lock) => alone(more, act, lock ? busy : [...busy, key]));
}

/** Keep texts by their keys: all of them, or none. */
function keepAll(texts) {
  const before = texts.map(([key]) => [key, localStorage.getItem(key)]);
  try {
    texts.forEach(([key, text]) => localStorage.setItem(key, text));
  } catch {
    before.sort(([, a], [, b]) => (a ?? '').length - (b ?? '').length) // what makes room first
      .forEach(([key, text]) => (text === null ? localStorage.removeItem(key) : localStorage.setItem(key, text)));
    throw new Wrong(FULL);
  }
}

/** Return the file's text, and how many texts are too long for one. */
function written(exercises) {
  const [works, now] = [{}, new Date().toISOString()];
  let long = 0;
  const fits = (text) => text.length <= TEXT || !(long += 1);
  for (const [slug, { skeleton }] of Object.entries(exercises)) {
    const { text, versions, green, scenarios, rest: { race } } = keptOf(slug);
    const told = ({ text: each, points, at }) => ({ files: split(each, skeleton), points, at });
    const work = { files: text !== null && fits(text) ? split(text, skeleton) : null,
      versions: versions.filter((each) => fits(each.text)).map(told), green: green && fits(green.text) ? told(green) : null, scenarios, race };
    if (work.files || work.versions.length || Object.keys({ ...scenarios, ...race }).length) works[slug] = work;
  }
  return [JSON.stringify({ format: FORMAT, version: 1, at: now, exercises: works }, null, 1), long];
}

/** Bring what a file's text holds into this browser; `own` is the key that this tab has. Return what came of it, in lines. */
function bring(content, exercises, own) {
  const { at, works, odd } = read(content, exercises);
  const from = new Date(at).toLocaleDateString();
  const keys = [...works.keys()].map(keyOf).filter((key) => key !== own);
  return alone(keys, (busy) => {
    if (busy.length) throw new Wrong(`another tab has ${busy.map((key) => key.split(':')[1]).join(', ')} open. Close it, and load again.`);
    const made = [...works].map(([slug, came]) => [slug, merged(keptOf(slug), came, exercises[slug], from)]);
    keepAll(made.map(([slug, { work }]) => [keyOf(slug), JSON.stringify(work)]));
    return [
      `Loaded what was saved on ${new Date(at).toLocaleString()}: ${works.size === 1 ? 'one exercise' : `${works.size} exercises`}.`,
      ...made.flatMap(([slug, { isPut, isKept, gone, left }]) => [
        isPut && `${slug}: its text is in the editor now.`,
        isKept && `${slug}: your text stays; the other is among the versions.`,
        gone && `${slug}: ${KEPT} versions are kept, so the ${gone === 1 ? 'oldest' : `${gone} oldest`} went.`,
        left && `${slug}: ${OWN} scenarios of your own are kept; ${left} did not come along.`]).filter(Boolean),
      ...odd.map((name) => `Left out, for this course has no such exercise or file: ${name}`),
    ];
  });
}

/** Keep a scenario's file among the reader's own of this exercise, and choose it; return what came of it, in a line. */
function bringScenario(name, content, workspace) {
  string(content, name, SCENARIO);
  const plain = name.replace(/\.toml$/i, '').replace(/[^A-Za-z0-9]+/g, '_').replace(/^_|_$/g, '');
  const file = workspace.shelf.addScenario(`${plain || 'scenario'}.toml`, content);
  workspace.listVersions();
  workspace.scenario.value = file;
  return [`Loaded: ${file}. It is chosen now, and below “Your own” in the list of scenarios: Drive reads it.`];
}

/** Return the dialog that saves and loads a workspace's progress, and that of all other exercises. */
export function progressDialog(workspace, exercises) {
  const said = el('div', { role: 'status' });
  const tell = (...lines) => said.replaceChildren(...lines.map((line) => el('p', {}, line)));
  const save = () => {
    const [content, long] = written(exercises);
    workspace.save(NAME, content, 'application/json');
    tell(`Saved: ${NAME}.`, ...(long ? [`Left out: ${long} texts of more than ${TEXT} characters.`] : []));
  };
  const load = async ({ target }) => {
    const [file] = target.files;
    if (!file) return;
    try {
      must(file.size <= MOST, 'the file', `at most ${MOST / 2 ** 20} MB; it has ${(file.size / 2 ** 20).toFixed(1)} MB and is perhaps another`);
      const content = new TextDecoder('utf-8', { fatal: true }).decode(await file.arrayBuffer());
      must(workspace.shelf.works, 'this browser', 'one that keeps something for this site');
      if (/\.toml$/i.test(file.name)) tell(...bringScenario(file.name, content, workspace));
      else {
        tell(...await bring(content, exercises, workspace.shelf.key));
        workspace.takeKept();
      }
    } catch (error) {
      tell(`${file.name}: ${error instanceof Wrong ? error.message : `nothing was loaded: expected ${NAME}, and this file is no text. Choose another.`}`);
    }
    target.value = ''; // the same file can be chosen again
  };
  const dialog = el('dialog', { class: 'ws-progress', 'aria-label': 'Progress', onclose: () => said.replaceChildren() },
    el('p', {}, 'All exercises in one file: what you wrote, its versions and results, your best laps, your own scenarios. Load it in another browser, ',
      'or in the installed course: ', el('code', {}, `course progress ${NAME}`)),
    el('p', {}, 'Loading adds to what is here: what you wrote stays, the file’s text is among the versions then. A scenario’s file, such as demo_wall_by_hand.toml, joins your own.'),
    el('div', { class: 'ws-tools' },
      button('Save to a file', save), el('label', { class: 'ws-load' }, 'Load a file', el('input', { type: 'file', accept: '.json,.toml', onchange: load })),
      button('Close', () => dialog.close())),
    said);
  workspace.dialog.append(dialog);
  alsoKeep(import.meta.url);
  return dialog;
}
