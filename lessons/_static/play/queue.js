// How old a scan is when a slow callback is done with it: stale.py, with any lidar and queue. In ms.
play.add('queue', {
  title: 'Scans, the callback that works on them, and how old each is when it is done',
  legend: 'Each number is a scan. A dot says how old it is when the callback is done with it.',
  size: [640, 250],
  start: { period: 100, takes: 200, depth: 10 },
  controls: {
    period: { label: 'A scan every', min: 25, max: 200, step: 25, show: play.ms },
    takes: { label: 'The callback takes', min: 20, max: 800, step: 10, show: play.ms },
    depth: { label: 'Queue', min: 1, max: 10, step: 1, show: (n) => `${n} scan${n > 1 ? 's' : ''}` },
  },
  presets: {
    'queue of 10': { period: 100, takes: 200, depth: 10 },
    qos_profile_sensor_data: { period: 100, takes: 200, depth: 5 },
    'only the newest': { period: 100, takes: 200, depth: 1 },
    'a quick callback': { period: 100, takes: 40, depth: 10 },
  },

  /** The first `count` scans that are dealt with: when taken, when done, how old then. */
  compute({ period, takes, depth, count = 40 }) {
    const done = [];
    const queue = [];
    let lost = 0;
    let next = 0; // scan that arrives next, at next * period
    let now = 0;
    const arrive = (until) => {
      for (; next * period <= until; next += 1) {
        queue.push(next);
        if (queue.length > depth) { queue.shift(); lost += 1; }
      }
    };
    while (done.length < count) {
      arrive(now);
      if (!queue.length) { now = next * period; arrive(now); }
      const scan = queue.shift();
      const from = now;
      now += takes;
      done.push({ scan, from, to: now, age: now - scan * period });
    }
    const late = done.slice(count / 2).map(({ age }) => age);
    return { done, lost, least: Math.min(...late), most: Math.max(...late) };
  },

  draw(shape, { period, takes }, { done }) {
    const [left, right] = [84, 632];
    const end = Math.max(2400, 9 * Math.max(period, takes));
    const x = (t) => left + (Math.min(t, end) / end) * (right - left);
    const top = 1.15 * Math.max(700, ...done.filter(({ to }) => to <= end).map(({ age }) => age));
    const y = (age) => 222 - (age / top) * 128;
    for (const [at, label] of [[24, 'scans'], [58, 'callback'], [100, 'age']]) shape('text', { x: 0, y: at + 4 }, label);
    for (let t = 0; t <= end; t += period) shape('line', { x1: x(t), x2: x(t), y1: 16, y2: 32, class: 'line-muted', 'stroke-width': 2 });
    for (const { scan, from, to } of done) {
      if (from >= end) break;
      const width = x(to) - x(from);
      shape('rect', { x: x(from) + 0.5, y: 44, width: Math.max(width - 1, 1), height: 28, rx: 3, class: 'fill-accent', opacity: 0.85 });
      if (width > 18) shape('text', { x: x(from) + width / 2, y: 63, 'text-anchor': 'middle', style: 'fill:var(--on-accent)' }, scan + 1);
    }
    shape('line', { x1: left, x2: right, y1: y(0), y2: y(0), class: 'line' });
    shape('line', { x1: left, x2: right, y1: y(600), y2: y(600), class: 'line-bad', 'stroke-dasharray': '5 4' });
    shape('text', { x: right, y: y(600) - 5, 'text-anchor': 'end' }, 'too old for exercise 5');
    const points = done.filter(({ to }) => to <= end).map(({ to, age }) => [x(to), y(age), age]);
    shape('polyline', { points: points.map(([a, b]) => `${a},${b}`).join(' '), class: 'line-accent', 'stroke-width': 1.5 });
    for (const [cx, cy, age] of points) shape('circle', { cx, cy, r: 3.5, class: age > 600 ? 'fill-bad' : 'fill-accent' });
    shape('text', { x: left, y: 246 }, '0 s');
    shape('text', { x: right, y: 246, 'text-anchor': 'end' }, play.seconds(end));
  },

  verdict({ period, takes, depth }, { least, most }) {
    const ages = least === most ? play.seconds(most) : `${play.seconds(least)} to ${play.seconds(most)}`;
    const why = takes <= period ? 'The callback keeps up, so the queue stays empty, however long it may be.'
      : `The callback is slower than the lidar, so the queue is full: ${depth > 1 ? `${depth - 1} to ${depth} periods of waiting` : 'up to one period of waiting'}, and the callback's own time.`;
    return { text: `Once it has settled, scans are ${ages} old. ${why}`, good: most <= 600 };
  },

  table(_, { done }) {
    return { head: ['scan', 'taken at', 'done at', 'age then'],
      rows: done.slice(0, 20).map(({ scan, from, to, age }) => [scan + 1, ...[from, to, age].map(play.seconds)]) };
  },
});
