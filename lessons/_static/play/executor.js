// A model and a command every 50 ms in one node: beat.py, with any model. In ms.
play.add('executor', {
  title: 'What each thread of the executor does over time',
  legend: 'Blue: the model. Green: a command. Red: a gap of more than 75 ms.',
  size: [640, 190],
  start: { takes: 200, threads: 1, groups: 1 },
  controls: {
    takes: { label: 'The model takes', min: 10, max: 400, step: 10, show: play.ms },
    threads: { label: 'Threads', min: 1, max: 2, step: 1 },
    groups: { label: 'Callback groups', min: 1, max: 2, step: 1 },
  },
  presets: {
    'as it comes': { threads: 1, groups: 1 },
    'two threads': { threads: 2, groups: 1 },
    'two groups': { threads: 1, groups: 2 },
    both: { threads: 2, groups: 2 },
  },

  phase: 13, // of the scans against the timer, as in the course's simulation

  /** What ran, where, from when to when; a scan every 100 ms, a command due every 50 ms. */
  compute({ takes, threads, groups, end = 4000 }) {
    const apart = threads > 1 && groups > 1;
    const thoughts = [];
    const commands = [];
    let now = 0;
    let scan = -1; // the last one that was taken
    let due = 50; // when the timer is due next
    const command = (at) => {
      commands.push(at);
      due = (Math.floor(at / 50) + 1) * 50;
    };
    const newest = (at) => Math.floor((at - this.phase) / 100);
    while (now < end) {
      const next = newest(now) > scan ? now : (scan + 1) * 100 + this.phase;
      if (apart) {
        while (due <= next + takes) command(due);
      } else {
        while (due <= next) command(Math.max(due, now)); // a timer goes first
      }
      scan = newest(next);
      thoughts.push({ scan, from: next, to: next + takes });
      now = next + takes;
      if (!apart && due <= now) command(now);
    }
    const gaps = commands.slice(1).map((at, i) => at - commands[i]);
    return { thoughts, commands, longest: Math.max(...gaps) };
  },

  draw(shape, { threads, groups }, { thoughts, commands }) {
    const [left, right, end] = [96, 632, 1000];
    const x = (t) => left + (t / end) * (right - left);
    const lane = threads > 1 ? [30, 78] : [30, 30];
    for (let i = 0; i < threads; i += 1) {
      shape('rect', { x: left, y: lane[i], width: right - left, height: 36, rx: 5, class: 'fill-line', opacity: 0.5 });
      shape('text', { x: 0, y: lane[i] + 22 }, `thread ${i + 1}`);
    }
    shape('text', { x: 0, y: 150 }, 'commands');
    for (const { from, to } of thoughts) {
      if (from >= end) break;
      shape('rect', { x: x(from), y: lane[0] + 4, width: x(Math.min(to, end)) - x(from) - 1, height: 28, rx: 4, class: 'fill-accent', opacity: 0.85 });
    }
    const own = threads > 1 && groups > 1 ? lane[1] : lane[0];
    commands.filter((at) => at <= end).forEach((at, i, shown) => {
      shape('rect', { x: x(at) - 1.5, y: own + 2, width: 3, height: 32, class: 'fill-good' });
      shape('circle', { cx: x(at), cy: 146, r: 4, class: 'fill-good' });
      const before = i ? shown[i - 1] : at;
      if (at - before > 75) shape('line', { x1: x(before) + 6, x2: x(at) - 6, y1: 146, y2: 146, class: 'line-bad', 'stroke-width': 3 });
    });
    shape('text', { x: left, y: 184 }, '0 s');
    shape('text', { x: right, y: 184, 'text-anchor': 'end' }, '1 s');
  },

  verdict({ threads, groups, takes }, { longest }) {
    const why = threads > 1 && groups > 1 ? 'The groups allow two callbacks at once, the threads do it.'
      : threads > 1 ? 'Both callbacks are in one group, so the second thread may only watch.'
        : groups > 1 ? 'Two callbacks may run at once, but there is one thread to run them.'
          : takes > 50 ? 'While the model thinks, the timer waits.' : 'The model is so quick that nobody notices.';
    return { text: `Longest gap between two commands: ${longest} ms. ${why}`, good: longest <= 75 };
  },

  table: (settings) => ({ head: ['threads', 'groups', 'longest gap'],
    rows: [[1, 1], [2, 1], [1, 2], [2, 2]].map(([threads, groups]) => [threads, groups,
      play.ms(play.compute('executor', { ...settings, threads, groups }).longest)]) }),
});
