// Others' ways: two more solutions with all points, what each costs and gains, and what is different from one's own.
// Fetched once somebody has all points; grader/authoring/ways.py makes them, of real runs.

import { el } from './element.js';
import { alsoKeep } from './keep.js';
import { showChanges, split } from './shelf.js';
import { button } from './workspace.js';

const lines = (text) => text.split('\n').filter((line) => /^\s*[^\s#]/.test(line)).length; // of code, as in ways.py

/** Return what offers the ways of a workspace's exercise. */
export async function offer(workspace) {
  const file = new URL(`../ways/${workspace.plan.slug}.json`, import.meta.url).href;
  const answer = await fetch(file).catch(() => null);
  if (!answer?.ok) return 'The server does not send others’ ways.';
  alsoKeep(import.meta.url, file);
  const ways = await answer.json();
  return el('div', { class: 'ws-tools' }, button('Others’ ways', () => show(workspace, ways)), 'with all points');
}

function show(workspace, ways) {
  const mine = split(workspace.text, workspace.skeletons);
  const changes = ({ files }) => Object.keys(mine).filter((name) => mine[name] !== files[name]);
  workspace.score.replaceChildren(
    el('p', {}, `Two others that differ much, with all points. Yours has ${Object.values(mine).reduce((sum, text) => sum + lines(text), 0)} lines of code. `,
      'Times were measured when this site was built.'),
    ...ways.map((way, i) => el('section', { class: 'ws-way' },
      el('h3', {}, `${i + 1}. ${way.about}`),
      el('ul', {}, way.said.map((said) => el('li', {}, said))),
      el('details', {}, el('summary', {}, 'Beside yours: − only in yours, + only there'),
        changes(way).flatMap((name) => [el('p', {}, el('code', {}, name)), showChanges(name, mine[name], way.files[name])])))));
  workspace.show('result');
  workspace.score.scrollIntoView();
}
