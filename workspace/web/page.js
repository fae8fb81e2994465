// What a page has of the workspace: an exercise's block, and a button below each `course drive`. Both open a dialog.

import { hasStacks, runsHere } from './able.js';
import { el } from './element.js';

const HERE = new URL('.', import.meta.url);
const read = async (name) => (await fetch(new URL(name, HERE), { cache: 'no-cache' })).json();
let loaded;

/** Return what the server has, and the machine of this page; read once. */
function load() {
  loaded ??= Promise.all([read('plan.json'), read('manifest.json'), import(new URL('machine.js', HERE))])
    .then(([plan, manifest, { Machine }]) => ({ plan, machine: new Machine(manifest) }));
  loaded.catch(() => { loaded = undefined; }); // the next time it may answer
  return loaded;
}

/** What stands behind the # of the address. */
const asked = () => new URLSearchParams(location.hash.slice(1));

/** Open what the address asks for, now and later. */
function follow(open) {
  addEventListener('hashchange', () => open(asked()));
  open(asked());
}

// --- an exercise ------------------------------------------------------------------------------------

async function beExercise(block) {
  const words = block.querySelector('.workspace-words');
  let all;
  try {
    all = await Promise.all([load(), import(new URL('exercise.js', HERE))]);
  } catch {
    words.textContent = 'The server did not send all of the workspace. Reload the page.';
    return;
  }
  const [{ plan, machine }, { Exercise }] = all;
  const exercise = plan.exercises[block.dataset.exercise];
  const fit = (all) => Object.fromEntries(Object.entries(all).filter(([name]) => hasStacks || !plan.drives.several.includes(name)));
  const workspace = new Exercise({ ...exercise, field: fit(exercise.field) }, { ...exercise.words, ...plan.methods }, fit(plan.demos), machine, plan.exercises);
  words.textContent = 'Write the node here, drive it, disturb it by hand and have it checked, in this browser: nothing is installed, and '
    + `nothing leaves this machine. The first visit fetches 12 MB. ${runsHere(exercise)}`;
  block.querySelector('.workspace-open').replaceChildren(
    el('button', { type: 'button', class: 'ws-main', onclick: () => workspace.open() }, 'Open the workspace'));
  follow((hash) => {
    if (hash.has('code') || hash.has('workspace')) workspace.open(hash.get('code'));
  });
}

// --- programs that the page shows -------------------------------------------------------------------

const programs = new Map(); // by the page and the file of their listing

async function programOf({ page, file, code, threads }) {
  const [{ plan, machine }, { Program }] = await Promise.all([load(), import(new URL('program.js', HERE))]);
  const key = `${page}/${file}`;
  const words = Object.assign({}, ...Object.values(plan.exercises).map((exercise) => exercise.words), plan.methods);
  if (!programs.has(key)) programs.set(key, new Program({ page, file, code, threads }, words, machine));
  return programs.get(key);
}

/** Open a place's program with the place's arguments or others; drive at once if that is wanted. */
async function open(place, { words = place.dataset.arguments, code = null, drives = false } = {}) {
  const shown = place.previousElementSibling;
  const output = words === place.dataset.arguments && shown?.matches('.highlight-output') ? shown.querySelector('pre').textContent : '';
  let program;
  try {
    program = await programOf(place.dataset);
  } catch {
    place.querySelector('[role=status]').textContent = ' The server does not answer; try again.';
    return;
  }
  place.querySelector('[role=status]').textContent = '';
  await program.openWith({ words, output }, code);
  if (drives) await program.drive();
}

function addButtons(places) {
  for (const place of places) {
    const { act, file, arguments: words, threads } = place.dataset;
    place.append(
      el('button', { type: 'button', 'aria-label': `${act}: ${file} ${words}`, onclick: () => open(place, { drives: true }) }, act),
      el('span', { role: 'status' }, threads === undefined || hasStacks ? '' : ' It needs JSPI, which this browser hasn’t.'));
  }
  for (const link of document.querySelectorAll('a.drives')) {
    link.addEventListener('click', (event) => {
      event.preventDefault();
      open(places[0], { drives: true });
    });
  }
  follow((hash) => {
    const here = places.filter(({ dataset }) => dataset.file === hash.get('drive'));
    const words = hash.get('with') ?? here[0]?.dataset.arguments;
    const place = here.find(({ dataset }) => dataset.arguments === words) || here[0];
    if (place) open(place, { words, code: hash.get('code') });
  });
}

// --- what runs here, said before anything is opened ---------------------------------------------------

for (const place of document.querySelectorAll('.runs-here')) {
  const { points, here, alone } = place.dataset;
  place.textContent = runsHere({ points: Number(points), here: Number(here), alone: Number(alone) });
}

const block = document.querySelector('.workspace-block');
const places = [...document.querySelectorAll('.drive-here')];
if (places.length) addButtons(places);
if (block) await beExercise(block);
document.body.dataset.workspace = 'ready';
