// A hundred latencies: the mean, the percentiles, and what a few slow calls do to each. In ms.
play.add('tail', {
  title: 'A hundred latencies, one bar each, with mean and percentiles',
  legend: 'A bar is a call, in order of time. Red: later than the budget of 100 ms.',
  size: [640, 220],
  start: { slow: 7, more: 120 },
  controls: {
    slow: { label: 'Slow calls', min: 0, max: 20, step: 1, show: (n) => `${n} of 100` },
    more: { label: 'Each takes longer by', min: 0, max: 300, step: 10, show: play.ms },
  },
  presets: {
    'seven in a hundred': { slow: 7, more: 120 }, 'one in a hundred': { slow: 1, more: 300 }, none: { slow: 0, more: 120 },
  },

  compute({ slow, more }) {
    const apart = slow > 1 ? Math.floor(99 / (slow - 1)) : 100; // seven: every 16th, as in the text
    const calls = window.playData.latencies.map((ms, i) => ms + (i % apart === 0 && i / apart < slow ? more : 0));
    const sorted = [...calls].sort((a, b) => a - b);
    const percentile = (share) => { // between the two nearest, as numpy does
      const place = (share / 100) * (sorted.length - 1);
      const low = Math.floor(place);
      return sorted[low] + (place - low) * ((sorted[low + 1] ?? sorted[low]) - sorted[low]);
    };
    return { calls, mean: calls.reduce((sum, ms) => sum + ms, 0) / calls.length, late: calls.filter((ms) => ms > 100).length,
      p50: percentile(50), p95: percentile(95), p99: percentile(99) };
  },

  draw(shape, _, { calls, mean, p50, p95, p99 }) {
    const top = Math.max(150, ...calls) * 1.08;
    const y = (ms) => 212 - (ms / top) * 200;
    calls.forEach((ms, i) => shape('rect', { x: 4 + i * 5.4, y: y(ms), width: 4, height: 212 - y(ms), class: ms > 100 ? 'fill-bad' : 'fill-accent' }));
    shape('line', { x1: 0, x2: 548, y1: y(100), y2: y(100), class: 'line-muted', 'stroke-dasharray': '4 4' });
    const marks = [['p50', p50], ['mean', mean], ['p95', p95], ['p99', p99]].sort((a, b) => a[1] - b[1]);
    let above = Infinity;
    for (const [name, ms] of marks) {
      const at = Math.min(y(ms), above - 20);
      above = at;
      shape('line', { x1: 0, x2: 548, y1: y(ms), y2: y(ms), class: 'line-muted', opacity: 0.5 });
      shape('text', { x: 554, y: at + 4 }, `${name} ${ms.toFixed(0)}`);
    }
  },

  verdict: (_, { mean, p50, p95, p99, late }) => ({ good: p99 <= 100,
    text: `Mean ${mean.toFixed(0)} ms, p50 ${p50.toFixed(0)}, p95 ${p95.toFixed(0)}, p99 ${p99.toFixed(0)}; ${late} of 100 later than 100 ms.` }),

  table: (settings) => ({ head: ['slow calls', 'mean', 'p50', 'p95', 'p99'],
    rows: [0, 1, 2, 5, 7, 10, 20].map((slow) => {
      const { mean, p50, p95, p99 } = play.compute('tail', { ...settings, slow });
      return [slow, ...[mean, p50, p95, p99].map((ms) => `${ms.toFixed(0)} ms`)];
    }) }),
});
