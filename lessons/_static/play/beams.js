// Which beams look ahead? A scan of the store, and a slice of its list.
play.add('beams', {
  title: 'A scan as a fan of beams, those of the slice in colour',
  legend: 'Ahead is up, ±45° dashed. Blue: the beams of the slice. Dots: what they hit.',
  size: [640, 400],
  start: { lidar: 0, from: 135, to: 225 },
  controls: {
    lidar: { label: 'Lidar', options: window.playData.lidars.map(({ name }) => name) },
    from: { label: 'Slice from', min: 0, max: (it) => window.playData.lidars[it.lidar].ranges.length - 1, step: 1, show: (i) => `ranges[${i}]` },
    to: { label: 'to', min: 0, max: (it) => window.playData.lidars[it.lidar].ranges.length - 1, step: 1, show: (i) => `ranges[${i}]` },
  },
  presets: {
    'ranges[135:226]': { lidar: 0, from: 135, to: 225 },
    'the same on an LDS-01': { lidar: 1, from: 135, to: 225 },
    'the same on the wide one': { lidar: 2, from: 135, to: 225 },
    'the same, mounted turned': { lidar: 3, from: 135, to: 225 },
  },

  /** What the slice covers [°, of the robot] and sees [m]; what is really nearest within ±45°. */
  compute({ lidar, from, to }) {
    const it = window.playData.lidars[lidar];
    const wrap = (angle) => Math.atan2(Math.sin(angle), Math.cos(angle));
    const beams = it.ranges.map((range, i) => {
      const angle = wrap(it.angle_min + i * it.angle_increment + it.mounted);
      return { i, angle, range, usable: range !== null && range >= it.range_min };
    });
    const nearest = (some) => Math.min(...some.filter(({ usable }) => usable).map(({ range }) => range));
    const slice = beams.filter(({ i }) => i >= from && i <= to);
    const ahead = beams.filter(({ angle }) => Math.abs(angle) <= Math.PI / 4 + 1e-9);
    const degrees = (beam) => (beam ? (beam.angle * 180) / Math.PI : NaN);
    const zeros = slice.filter(({ range }) => range === 0).length;
    return { beams, slice, zeros, first: degrees(slice[0]), last: degrees(slice.at(-1)),
      seen: nearest(slice), truth: nearest(ahead), raw: Math.min(...slice.map(({ range }) => range ?? Infinity)) };
  },

  draw(shape, _, { beams, slice }) {
    const [cx, cy, scale] = [320, 200, 46];
    const chosen = new Set(slice.map(({ i }) => i));
    const end = ({ angle, range }, far = 4.2) => { // ahead is up
      const r = Math.min(range ?? far, far) * scale;
      return [cx - r * Math.sin(angle), cy - r * Math.cos(angle)];
    };
    for (const sign of [-1, 1]) {
      const [x2, y2] = end({ angle: (sign * Math.PI) / 4, range: null });
      shape('line', { x1: cx, y1: cy, x2, y2, class: 'line-muted', 'stroke-dasharray': '5 4' });
    }
    shape('text', { x: cx, y: 12, 'text-anchor': 'middle' }, 'ahead');
    for (const beam of beams) {
      const [x2, y2] = end(beam);
      const inside = chosen.has(beam.i);
      shape('line', { x1: cx, y1: cy, x2, y2, class: inside ? 'line-accent' : 'line', opacity: inside ? 0.55 : 0.9, 'stroke-width': 1 });
      if (beam.usable && beam.range < 4.2) shape('circle', { cx: x2, cy: y2, r: 1.6, class: inside ? 'fill-accent' : 'fill-muted' });
    }
    shape('circle', { cx, cy, r: 0.17 * scale + 3, class: 'fill-accent' });
    shape('path', { d: `M${cx} ${cy - 7} l5 12 l-5 -3 l-5 3z`, style: 'fill:var(--on-accent)' });
  },

  verdict(_, { slice, first, last, seen, truth, zeros }) {
    if (!slice.length) return { text: 'The slice is empty: this lidar has no such beams. min() of it raises.', good: false };
    const number = (m) => (Number.isFinite(m) ? `${m.toFixed(2)} m` : 'nothing');
    const lost = zeros ? ` ${zeros} of its readings are 0.0, which here means: nothing came back.` : '';
    return { text: `The slice looks from ${first.toFixed(0)}° to ${last.toFixed(0)}° and sees ${number(seen)}. Ahead, within ±45°, the nearest thing is at ${number(truth)}.${lost}`,
      good: Math.abs(seen - truth) < 0.005 };
  },

  table: (settings) => ({ head: ['lidar', 'this slice looks from', 'to', 'sees', 'ahead is'],
    rows: window.playData.lidars.map(({ name }, lidar) => {
      const { first, last, seen, truth } = play.compute('beams', { ...settings, lidar });
      return [name, `${first.toFixed(0)}°`, `${last.toFixed(0)}°`, `${seen.toFixed(2)} m`, `${truth.toFixed(2)} m`];
    }) }),
});
