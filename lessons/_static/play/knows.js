// What two models say, and what they were shown: the forest and the line of this page. In m and m/s.
play.add('knows', {
  title: 'Speed over distance: what the forest and the line say, and the data they learned from',
  legend: 'Blue: the forest. Red: the line. Grey: the driver, who was seen only in the shaded part.',
  size: [640, 280],
  start: { distance: 0.35 },
  controls: {
    distance: { label: 'Distance ahead', min: 0, max: 12, step: 0.05, show: (d) => `${d.toFixed(2)} m` },
  },
  presets: {
    'in the data': { distance: 0.6 }, 'at the wall': { distance: 0.2 }, 'open floor': { distance: 12 },
  },

  compute({ distance }) {
    const { step, forest, slope, intercept } = window.playData.models;
    const driver = distance < 0.3 ? 0 : Math.min(0.5, Math.sqrt(1.8 * (distance - 0.3)));
    return {
      forest: forest[Math.min(Math.round(distance / step), forest.length - 1)],
      line: slope * distance + intercept,
      driver,
      away: Math.max(0.3 - distance, distance - 1, 0),
    };
  },

  draw(shape, { distance }, { forest, line, driver }) {
    const [left, right] = [70, 620];
    const end = distance > 2 ? 12 : 2;
    const top = end > 2 ? 3.4 : 1.2;
    const x = (d) => left + (d / end) * (right - left);
    const y = (v) => 240 - (v / top) * 215;
    shape('rect', { x: x(0.3), y: 20, width: x(1) - x(0.3), height: 220, class: 'fill-soft' });
    shape('text', { x: x(0.65), y: 14, 'text-anchor': 'middle' }, 'its data');
    shape('line', { x1: left, x2: right, y1: y(0), y2: y(0), class: 'line-muted' });
    shape('line', { x1: left, x2: right, y1: y(0.5), y2: y(0.5), class: 'line-muted', 'stroke-dasharray': '4 4' });
    shape('text', { x: left - 6, y: y(0.5) + 4, 'text-anchor': 'end' }, '0.5 m/s');
    const curve = (law, name) => {
      const points = Array.from({ length: 201 }, (_, i) => (i / 200) * end)
        .map((d) => `${x(d)},${y(law(this.compute({ distance: d })))}`);
      shape('polyline', { points: points.join(' '), class: name, 'stroke-width': 2.5 });
    };
    curve((said) => said.driver, 'line-muted');
    curve((said) => said.line, 'line-bad');
    curve((said) => said.forest, 'line-accent');
    shape('line', { x1: x(distance), x2: x(distance), y1: 20, y2: 240, class: 'line-muted' });
    for (const [value, name] of [[driver, 'fill-muted'], [line, 'fill-bad'], [forest, 'fill-accent']]) shape('circle', { cx: x(distance), cy: y(value), r: 6, class: name });
    shape('text', { x: right, y: 272, 'text-anchor': 'end' }, `distance, up to ${end} m`);
  },

  verdict(_, { forest, line, driver, away }) {
    const said = `The forest says ${forest.toFixed(2)} m/s, the line ${line.toFixed(2)} m/s; the driver would take ${driver.toFixed(2)} m/s.`;
    return away > 0 ? { text: `${said} Neither says that its nearest example is ${away.toFixed(2)} m away.`, good: false }
      : { text: `${said} Here both have seen examples.`, good: true };
  },

  table: () => ({ head: ['distance', 'forest', 'line', 'driver'],
    rows: [0, 0.2, 0.3, 0.35, 0.6, 1, 2, 12].map((distance) => {
      const { forest, line, driver } = play.compute('knows', { distance });
      return [`${distance.toFixed(2)} m`, ...[forest, line, driver].map((v) => `${v.toFixed(2)} m/s`)];
    }) }),
});
