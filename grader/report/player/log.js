// What the node logged, scrolled to the time of the replay.

const LOG_LEVELS = { debug: 'debug', info: 'info', warn: 'warn', warning: 'warn', error: 'error',
  fatal: 'fatal', stdout: 'print', stderr: 'stderr' };

class LogPane {
  constructor(onseek) {
    this.onseek = onseek;
    this.list = el('ol', { class: 'log-list', tabindex: '0', 'aria-label': 'Log lines of the node' });
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
  }

  row(line, t) {
    const level = LOG_LEVELS[line.level] || 'info';
    return el('li', { class: `log-line log-${level}`, onclick: () => this.onseek(t) },
      el('span', { class: 'log-time' }, fixed(t, 2)),
      el('span', { class: 'log-level' }, level),
      el('span', { class: 'log-text', dir: 'auto' }, line.text));
  }

  update(time) {
    const now = indexAt(this.times, time);
    if (now === this.current) return;
    if (this.rows[this.current]) this.rows[this.current].classList.remove('is-now');
    this.current = now;
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
