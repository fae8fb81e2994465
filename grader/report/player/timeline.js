// The slider under the map, with marks for contacts, goals and failing moments.

const MARK_WIDTH = 44; // [pixels] a finger needs as much: marks that are closer become one

class Timeline {
  constructor(onseek, onmoment) {
    this.onmoment = onmoment;
    this.width = 0; // [pixels]
    this.fill = el('div', { class: 'timeline-fill' });
    this.thumb = el('div', { class: 'timeline-thumb' });
    this.bands = el('div', { class: 'timeline-bands' });
    this.slider = el('div', { class: 'timeline-slider', role: 'slider', tabindex: '0',
      'aria-label': 'Time in the run', 'aria-valuemin': '0' },
    el('div', { class: 'timeline-track' }, this.fill, this.bands), this.thumb);
    this.marks = el('div', { class: 'timeline-marks' });
    this.element = el('div', { class: 'timeline' }, this.marks, this.slider);
    this.listen(onseek);
  }

  listen(onseek) {
    const seek = (event) => {
      const { left, width } = this.slider.getBoundingClientRect();
      onseek(clamp((event.clientX - left) / Math.max(1, width), 0, 1) * this.replay.duration);
    };
    this.slider.addEventListener('pointerdown', (event) => {
      this.slider.setPointerCapture(event.pointerId);
      seek(event);
    });
    this.slider.addEventListener('pointermove', (event) => {
      if (this.slider.hasPointerCapture(event.pointerId)) seek(event);
    });
  }

  setReplay(replay) {
    this.replay = replay;
    this.slider.setAttribute('aria-valuemax', replay.duration.toFixed(2));
    replaceChildren(this.bands, replay.contacts.map(({ from, to }) => this.band(from, to)));
    this.width = 0;
    this.resize();
  }

  resize() {
    const width = this.marks.clientWidth || 600;
    if (width === this.width) return;
    this.width = width;
    replaceChildren(this.marks, this.plainMarks(), this.momentMarks());
  }

  percent(t) {
    return `${(100 * clamp(t / Math.max(this.replay.duration, 1e-3), 0, 1)).toFixed(3)}%`;
  }

  band(from, to) {
    const band = el('div', { class: 'timeline-contact' });
    band.style.left = this.percent(from);
    band.style.width = `max(4px, ${this.percent(to - from)})`;
    return band;
  }

  plainMarks() {
    const { goals, deeds } = this.replay;
    const all = [...goals.map(({ t }) => ({ t, kind: 'goal', what: 'Goal' })),
      ...deeds.map(({ t, text: what }) => ({ t, kind: 'deed', what }))];
    return all.map(({ t, kind, what }) => {
      const mark = el('span', { class: `mark mark-${kind}`, title: `${what} at ${seconds(t)}` });
      mark.style.left = this.percent(t);
      return mark;
    });
  }

  momentMarks() {
    const groups = [];
    for (const moment of this.replay.moments) {
      const last = groups[groups.length - 1];
      if (last && (moment.t - last[0].t) * this.width < MARK_WIDTH * this.replay.duration) last.push(moment);
      else groups.push([moment]);
    }
    return groups.map((group) => {
      const name = group.map((m) => `Failed at ${seconds(m.t)}: ${m.title.slice(0, 200)}`).join('\n');
      const mark = el('button', { type: 'button', class: 'mark mark-moment',
        'aria-label': name, title: name, onclick: () => this.onmoment(group) },
      group.length > 1 ? el('span', {}, group.length) : null);
      mark.style.left = this.percent(group[0].t);
      return mark;
    });
  }

  /** Screen readers hear the value change only while nothing plays. */
  update(time, playing) {
    const at = this.percent(time);
    this.fill.style.width = at;
    this.thumb.style.left = at;
    if (playing) return;
    this.slider.setAttribute('aria-valuenow', time.toFixed(2));
    this.slider.setAttribute('aria-valuetext',
      `${seconds(time)} of ${seconds(this.replay.duration)}`.replaceAll('\u00a0', ' '));
  }
}
