// What ran at a moment of the replay: the run is made again, the same, and Python says what its callback did.

import { el, Moment } from './element.js';

const MARKED = ['* changed by the callback.', '* different.'];

export class Look {
  /**
   * `run` makes a run again, by its number among those of the replay, and tells its tables; `mark` marks a place in the editor,
   * and `seek` has the replay stand at a moment.
   */
  constructor({ run, mark, seek }) {
    Object.assign(this, { run, mark, seek, at: 0, number: 0 });
    this.by = el('span', {});
    this.moment = new Moment('to look at', (at) => {
      this.at = at;
      this.update();
      seek(at);
    }, () => this.look([this.at]));
    this.button = el('button', { type: 'button', onclick: () => this.look([this.at]) });
    this.beside = el('button', { type: 'button', onclick: () => this.look([this.shown[0], this.at]) });
    this.tables = el('div', { class: 'ws-tables', tabindex: 0, role: 'region', 'aria-label': 'What ran' });
    this.element = el('details', { class: 'ws-below ws-look', 'data-pane': 'replay', name: 'ws-below', hidden: true,
      ontoggle: () => { if (this.element.open && !this.shown) this.look([this.at]); } },
      el('summary', {}, 'What ran here?', this.by),
      el('p', { class: 'ws-since' }, 'Of the code as it was driven, with its line numbers. It has changed since: drive again.'),
      el('div', { class: 'ws-tools' }, this.moment.element, this.button, this.beside), this.tables);
    this.update();
  }

  /** Begin with other runs: of these nothing has been seen. */
  begin() {
    [this.shown, this.callback, this.element.hidden] = [null, '', false];
    this.tables.replaceChildren();
    this.update();
  }

  /** Where the replay stands, and which it is. */
  hear({ at, run, duration }) {
    if (Number.isFinite(duration)) this.moment.end = duration;
    if (!Number.isFinite(at) || !Number.isInteger(run)) return;
    if (run !== this.number) [this.number, this.shown] = [run, null];
    this.at = this.moment.typed ?? at;
    this.update();
  }

  update() {
    this.by.textContent = `, by ${this.at.toFixed(2)} s`;
    this.button.textContent = `Look at ${this.at.toFixed(2)} s`;
    this.beside.hidden = !this.shown || Math.abs(this.shown[0] - this.at) < 0.005;
    this.moment.at = this.at;
    if (this.shown) this.beside.textContent = `Compare ${this.at.toFixed(2)} s with ${this.shown[0].toFixed(2)} s`;
  }

  async look(at) {
    this.seek(this.at); // and stay there
    const tables = await this.run(this.number, at, this.callback);
    if (!tables) return; // something else was under way, or it was stopped
    this.shown = at;
    this.update();
    this.tables.replaceChildren(...tables.flatMap((table) => this.table(table)));
    if (tables.length) this.mark(tables[0].place, `This began last by ${Math.min(...at).toFixed(2)} s`);
    else this.tables.append(el('p', {}, `Nothing of the node had run by ${Math.max(...at).toFixed(2)} s.`));
  }

  /** Choose among the functions that ran, where there are several. */
  choose(functions) {
    const select = el('select', { onchange: () => {
      this.callback = select.value;
      this.look(this.shown);
    } }, el('option', { value: '' }, 'that ran last'), [...functions].sort().map((name) => el('option', { value: name }, name)));
    if (functions.includes(this.callback)) select.value = this.callback;
    return functions[1] ? el('label', {}, 'Function ', select) : '';
  }

  table({ title, columns, functions, rows }) {
    const parts = [...new Set(rows.map(({ part }) => part))];
    return [
      this.choose(functions),
      el('p', { class: 'ws-note' }, `${MARKED[columns.length - 1]} Variables are gone once their function has returned.`),
      el('table', {}, el('caption', {}, title),
        el('thead', {}, el('tr', {}, el('td', {}), columns.map((text) => el('th', { scope: 'col' }, text)))),
        parts.map((part) => el('tbody', {},
          part ? el('tr', {}, el('th', { scope: 'rowgroup', colspan: columns.length + 1 }, part)) : '',
          rows.filter((row) => row.part === part).map(({ name, cells, marked }) => el('tr', { class: marked ? 'is-marked' : null },
            el('th', { scope: 'row' }, marked ? '* ' : '', name), cells.map((text) => el('td', {}, text || '–'))))))),
    ];
  }
}
