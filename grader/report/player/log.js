// What the node logged, scrolled to the time of the replay.

const LOG_LEVELS = { debug: 'debug', info: 'info', warn: 'warn', warning: 'warn', error: 'error',
  fatal: 'fatal', stdout: 'print', stderr: 'stderr' };

class LogPane {
  constructor(onseek) {
    this.onseek = onseek;
    this.list = el('ol', { class: 'log-list', 'aria-label': 'Log lines of the node', onkeydown: (event) => this.walk(event) });
    this.empty = el('p', { class: 'quiet' }, 'The node logged nothing.');
    this.element = el('div', { class: 'log' }, this.list, this.empty);
    this.current = -1;
  }

  setReplay(replay) {
    const lines = replay.log;
    this.times = Float64Array.from(lines, (line) => (Number.isFinite(line.t) ? line.t : 0));
    this.rows = lines.map((line, i) => this.row(line, this.times[i]));
    this.current = -1;
    replaceChildren(this.list, this.rows);
    this.list.hidden = !lines.length;
    this.empty.hidden = lines.length > 0;
    this.stop = null;
    this.stopAt(0);
  }

  row(line, t) {
    const level = LOG_LEVELS[line.level] || 'info';
    return el('li', { class: `log-line log-${level}`, onclick: () => this.onseek(t) },
      el('button', { type: 'button', class: 'log-time', tabindex: '-1', 'aria-label': `Go to ${seconds(t)}` }, fixed(t, 2)),
      el('span', { class: 'log-level' }, level),
      el('span', { class: 'log-text', dir: 'auto' }, unbroken(line.text)));
  }

  /** Of a thousand lines one is a stop of the Tab key; from there the arrows lead on. */
  stopAt(i) {
    if (this.stop) this.stop.tabIndex = -1;
    this.stop = this.rows[i] ? this.rows[i].firstChild : null;
    if (this.stop) this.stop.tabIndex = 0;
    return this.stop;
  }

  walk(event) {
    const step = { ArrowUp: -1, ArrowDown: 1 }[event.key];
    if (!step) return;
    event.preventDefault();
    const here = this.rows.indexOf(event.target.closest('li'));
    const stop = this.stopAt(clamp(here + step, 0, this.rows.length - 1));
    if (stop) stop.focus();
  }

  update(time) {
    const now = indexAt(this.times, time);
    if (now === this.current) return;
    if (this.rows[this.current]) this.rows[this.current].classList.remove('is-now');
    this.current = now;
    if (!this.list.contains(document.activeElement)) this.stopAt(Math.max(now, 0));
    if (now < 0) {
      this.list.scrollTop = 0;
      return;
    }
    const row = this.rows[now];
    row.classList.add('is-now');
    // Not scrollIntoView: that would move the page too.
    this.list.scrollTop = row.offsetTop - this.list.clientHeight / 2 + row.offsetHeight / 2;
  }
}
