// Others' ways: two more solutions with all points, what each costs and gains, and what is different from one's own.
// Fetched once somebody has all points; grader/authoring/ways.py makes them, of real runs.

import { el } from './element.js';
import { alsoKeep } from './keep.js';
import { showChanges, split } from './shelf.js';
import { button } from './workspace.js';

// A docstring, with nothing else on its lines; another text; a comment
const TEXTS = /^[ \t]*("""|''')(?:(?!\1)[^])*\1[ \t]*(?=#|$)|("""|''')[^]*?\2|(["'])(?:\\.|(?!\3).)*\3|#.*/gm;
const isImport = (line) => /^(from|import) /.test(line);

/** Return the lines of code, imports first and in order: without docstrings, comments and blank lines, as ways.py counts. */
function code(text) {
  const bare = text.replace(TEXTS, (found, docstring) => (docstring || found[0] === '#' ? '' : found));
  const lines = bare.split('\n').map((line) => line.trimEnd()).filter(Boolean);
  return [...lines.filter(isImport).sort(), ...lines.filter((line) => !isImport(line))];
}

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
    el('p', {}, `Two others that differ much, with all points. Yours has ${Object.values(mine).reduce((sum, text) => sum + code(text).length, 0)} lines of code. `,
      'Times are the CPU’s, of the real rclpy, measured when this site was built; yours, from course drive, compare with them, and those of a browser don’t.'),
    ...ways.map((way, i) => el('section', { class: 'ws-way' },
      el('h3', {}, `${i + 1}. ${way.about}`),
      el('ul', {}, way.said.map((said) => el('li', {}, said))),
      el('details', {}, el('summary', {}, 'Beside yours, code alone: − only in yours, + only there'),
        changes(way).flatMap((name) => [el('p', {}, el('code', {}, name)), showChanges(name, ...[mine, way.files].map((files) => code(files[name] ?? '').join('\n')))])))));
  workspace.show('result');
  workspace.score.scrollIntoView();
}
