// The workspace of a program that a page shows: it drives as the command below it says, and its summary stands beside
// what the page prints.

import { el } from './element.js';
import { stand } from './links.js';
import { Workspace, button } from './workspace.js';

const MEASURED = /^ {2}Compute: .*(\n\S.*)*/m; // differs each time, and where its lines break

export class Program extends Workspace {
  constructor({ page, file, code, threads }, words, machine) {
    super({
      what: 'program', skeletons: { [file]: code }, origin: 'the listing', shelf: `${page}/${file}`, words,
      threads: threads !== undefined,
    }, machine);
    this.before = null; // lines of the last drive
    this.line = el('input', {
      spellcheck: 'false', autocapitalize: 'off', autocomplete: 'off', 'aria-label': 'Arguments of course drive',
      onkeydown: (event) => { if (event.key === 'Enter') this.drive(); },
    });
    this.note = el('p', { class: 'ws-note' }, 'What the drive was like is told here, as course drive tells it.');
    this.printed = el('pre', { class: 'ws-printed', tabindex: 0, 'aria-label': 'What course drive prints', hidden: true });
    this.expected = el('div', {});
    this.build({
      label: `Workspace: ${file}`,
      title: file,
      tools: [
        button('Drive', () => this.drive(), { title: 'Ctrl-Enter', class: 'ws-main' }),
        el('label', { class: 'ws-arguments' }, 'with', this.line),
      ],
      result: [this.note, this.printed, this.expected],
      names: ['Code', 'Replay', 'Output'],
      empty: 'Drive the program: its run is shown here.',
    });
  }

  get hash() { return `#${new URLSearchParams({ drive: this.file, with: this.line.value })}`; }

  /** Show it with the arguments of a command of the page, and what the page says that it prints. */
  openWith({ words, output }, code) {
    this.given = words;
    this.line.value = words;
    this.expected.replaceChildren(...(output ? [
      el('p', { class: 'ws-note' }, 'The page, for ', el('code', {}, words), ':'),
      el('pre', { class: 'ws-printed', tabindex: 0, 'aria-label': 'What the page prints' }, output)] : []));
    return this.open(code);
  }

  reset() {
    super.reset();
    this.line.value = this.given;
  }

  commandOf(file) { return `course drive ${this.file} ${this.line.value.replace(/--scenario[ =]\S+/, `--scenario ${file}`)}`; }

  /** Drive; show it from its start on, or from a moment. */
  drive(from) {
    if (this.busy || this.whyNot || !this.isThere()) return null;
    this.unmark();
    stand(this.hash);
    this.hand.begin(this.line.value);
    return this.work(async () => {
      const hand = await this.machine.ready();
      hand.doing = `Driving ${this.file}`;
      this.say(`${hand.doing} …`);
      const [text, changed] = [this.text, this.isChanged];
      const [ended, recordings] = await this.run(hand, 'drive', { arguments: this.line.value, ...this.hand.order }, text);
      this.speakOf(text);
      this.tell(ended.printed, changed);
      if (!ended.scenario) {
        this.show('result');
        return ended.printed.startsWith('Usage') ? 'Nothing was driven.' : `Nothing was driven: ${ended.printed}`;
      }
      this.show('replay');
      return this.showDrive(ended, ended.scenario, recordings, this.file, from);
    });
  }

  /** Show what the command prints; mark what is different from the drive before. */
  tell(printed, changed) {
    const lines = printed.trimEnd().split('\n').map((line) => line.trimEnd());
    const measured = (MEASURED.exec(lines.join('\n')) || [''])[0].split('\n');
    const isNew = (line) => this.before && line && !measured.includes(line) && !this.before.includes(line);
    this.note.replaceChildren(changed ? 'With your changes; ' : 'As the page has it; ',
      el('span', {}, changed ? 'Reset brings the listing back.' : 'change it, and drive again.'),
      lines.some(isNew) ? ' Marked: what is different from the drive before.' : '');
    this.printed.replaceChildren(...lines.map((line) => el(isNew(line) ? 'mark' : 'span', {}, `${line}\n`)));
    this.printed.hidden = false;
    this.before = lines;
  }
}
