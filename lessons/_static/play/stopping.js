// Does the robot stop in time? v·t + v²/2a against the room that it has. In m and s.
play.add('stopping', {
  title: 'A robot, the way that it drives before it stands, and a wall',
  legend: 'Dashed: where it should stop. Red: until the command comes. Blue: braking. Grey: to stay free.',
  size: [640, 170],
  start: { speed: 0.5, late: 0.1, brake: 0.9, stop: 0.5 },
  controls: {
    speed: { label: 'Speed', min: 0.1, max: 1, step: 0.05, show: (v) => `${v.toFixed(2)} m/s` },
    late: { label: 'The command is late by', min: 0, max: 0.5, step: 0.05, show: (v) => `${v.toFixed(2)} s` },
    brake: { label: 'Brakes with', min: 0.3, max: 2, step: 0.1, show: (v) => `${v.toFixed(1)} m/s²` },
    stop: { label: 'Stops for what is nearer than', min: 0.3, max: 1, step: 0.05, show: (v) => `${v.toFixed(2)} m` },
  },
  presets: {
    'exercise 1, at full speed': { speed: 0.5, late: 0, brake: 0.9, stop: 0.5 },
    'slowed down first': { speed: 0.15, late: 0.1, brake: 0.9, stop: 0.5 },
    'a slow model': { speed: 0.5, late: 0.3, brake: 0.9, stop: 0.5 },
    'a heavier robot': { speed: 0.5, late: 0.1, brake: 0.4, stop: 0.8 },
  },
  radius: 0.17, // of the course's robot

  compute({ speed, late, brake, stop }) {
    const rolling = speed * late;
    const braking = speed ** 2 / (2 * brake);
    return { rolling, braking, way: rolling + braking, left: stop - this.radius - rolling - braking };
  },

  draw(shape, { stop }, { rolling, braking, left }) {
    const [wall, scale, y] = [600, 330, 92];
    const at = (distance) => wall - distance * scale; // distance of the robot's centre from the wall
    const radius = this.radius * scale;
    const rest = Math.max(stop - rolling - braking, this.radius);
    shape('rect', { x: wall, y: 26, width: 20, height: 132, class: 'fill-muted' });
    shape('rect', { x: wall - 0.2 * scale, y: 26, width: 0.2 * scale, height: 132, class: 'fill-line', opacity: 0.55 });
    shape('circle', { cx: at(stop), cy: y, r: radius, class: 'line-muted', 'stroke-dasharray': '3 3' });
    shape('circle', { cx: at(rest), cy: y, r: radius, class: left < 0 ? 'fill-bad' : 'fill-accent', opacity: 0.9 });
    shape('path', { d: `M${at(rest) + radius * 0.7} ${y} l${-radius * 1.15} ${-radius * 0.5} l${radius * 0.3} ${radius * 0.5} l${-radius * 0.3} ${radius * 0.5}z`, style: 'fill:var(--on-accent)' });
    const part = (from, to, name) => shape('line', { x1: at(stop - from), x2: at(stop - to), y1: 30, y2: 30, class: name, 'stroke-width': 7 });
    part(0, rolling, 'line-bad');
    part(rolling, rolling + braking, 'line-accent');
  },

  verdict(_, { rolling, braking, left }) {
    const way = `${rolling.toFixed(2)} m until the command comes, and ${braking.toFixed(2)} m of braking`;
    return left < 0 ? { text: `Contact: ${way}, ${(-left).toFixed(2)} m more than there are.`, good: false }
      : { text: `${left.toFixed(2)} m stay free after ${way}.${left < 0.2 ? ' Exercise 1 asks for 0.20 m.' : ''}`, good: left >= 0.2 - 1e-9 };
  },

  table(settings) {
    const rows = [0.1, 0.2, 0.3, 0.4, 0.5, 0.75, 1].map((speed) => {
      const { way, left } = play.compute('stopping', { ...settings, speed });
      return [`${speed.toFixed(2)} m/s`, `${way.toFixed(2)} m`, left < 0 ? 'contact' : `${left.toFixed(2)} m`];
    });
    return { head: ['speed', 'stopping distance', 'stays free'], rows };
  },
});
