// The player's elements. Builds and names them; what they do is passed in as `actions`.

const KEYS = [
  ['Space', 'play or pause'],
  ['\u2190 \u2192', 'one scan back or on (with Shift: one second)'],
  ['Home End', 'to the start, to the end'],
  ['[ ]', 'slower, faster'],
  ['P N', 'previous, next failing moment'],
  ['F', 'follow the robot'],
  ['0 + \u2212', 'fit, zoom in, zoom out'],
  ['Esc', 'back to the check that led here'],
  ['?', 'this help'],
];

const CLEARANCE = 'From the robot\u2019s edge to the nearest thing on any side. A scan measures from the lidar, inside the robot, so it reads more.';

function toggleButton(name, label, pressed, onclick) {
  return iconButton(name, label, onclick, { 'aria-pressed': String(pressed) });
}

function buildHeader(actions, count) {
  const select = el('select', { class: 'run-select', 'aria-label': 'Run', onchange: actions.chooseRun });
  const title = el('h2', { class: 'run-title', dir: 'auto' });
  const outcome = el('span', { class: 'run-outcome', dir: 'auto' });
  const description = el('p', { class: 'run-description', dir: 'auto' });
  const position = el('span', { class: 'run-position' });
  const picker = count > 1
    ? el('label', { class: 'run-picker' }, el('span', {}, 'Run'), select, position) : null;
  const traceback = el('pre', { class: 'traceback', tabindex: '0', dir: 'ltr' });
  const detail = el('details', { class: 'run-detail' }, el('summary', {}, 'Traceback'), traceback);
  return { select, title, outcome, description, position, traceback, detail,
    element: el('header', { class: 'player-head' }, picker || title, outcome, description, detail) };
}

function buildStage(actions) {
  const canvas = el('canvas', { class: 'map', tabindex: '0', role: 'img' });
  const follow = toggleButton('follow', 'Follow the robot (F)', false, actions.toggleFollow);
  const lidar = toggleButton('lidar', 'Show the lidar', true, actions.toggleLidar);
  const tools = el('div', { class: 'map-tools', role: 'group', 'aria-label': 'Map' },
    iconButton('plus', 'Zoom in (+)', actions.zoomIn), iconButton('minus', 'Zoom out (\u2212)', actions.zoomOut),
    iconButton('fit', 'Fit everything (0)', actions.fit), follow, lidar);
  const hint = el('p', { class: 'map-hint', hidden: true }, 'Click the map, then scroll to zoom');
  const annotation = el('div', { class: 'annotation', role: 'group', 'aria-label': 'Failed check', hidden: true });
  const legend = el('div', { class: 'map-legend', 'aria-hidden': 'true' });
  return { canvas, follow, lidar, hint, annotation, legend,
    element: el('div', { class: 'stage' }, canvas, tools, legend, hint, annotation) };
}

function buildReadout() {
  const values = {};
  const stat = (name, label, title = null) => {
    values[name] = el('dd', {});
    return el('div', { class: 'stat', title }, el('dt', {}, label), values[name]);
  };
  const element = el('dl', { class: 'readout' }, stat('speed', 'Speed'), stat('turn', 'Turning'),
    stat('command', 'Commanded'), stat('clearance', 'Clearance', CLEARANCE));
  return { values, element };
}

function buildTransport(actions) {
  const play = el('button', { type: 'button', class: 'icon-button play-button', onclick: actions.toggle });
  const moments = [
    iconButton('momentBack', 'Previous failing moment (P)', actions.previousMoment),
    iconButton('momentForward', 'Next failing moment (N)', actions.nextMoment),
  ];
  const rate = el('select', { class: 'rate-select', 'aria-label': 'Playback speed', title: 'Playback speed ([ and ])',
    onchange: actions.chooseRate }, RATES.map((r) => el('option', { value: r }, `${r}\u00d7`)));
  const clock = el('span', { class: 'clock' });
  const element = el('div', { class: 'transport' }, play,
    el('div', { class: 'button-row' }, iconButton('stepBack', 'One scan back (\u2190)', actions.stepBack),
      iconButton('stepForward', 'One scan on (\u2192)', actions.stepForward)),
    el('div', { class: 'button-row moment-row' }, moments),
    clock, el('span', { class: 'spring' }), rate, iconButton('help', 'Keyboard help (?)', actions.help));
  return { play, moments, rate, clock, element };
}

function buildPlot(actions) {
  const canvas = el('canvas', { class: 'plot', role: 'img',
    'aria-label': 'Commanded and actual speed, and clearance, over time. The account below says it in words.' });
  const linear = el('button', { type: 'button', 'aria-pressed': 'true', onclick: actions.plotLinear }, el('span', {}, 'Linear'));
  const angular = el('button', { type: 'button', 'aria-pressed': 'false', onclick: actions.plotAngular }, el('span', {}, 'Angular'));
  return { canvas, linear, angular,
    element: el('div', { class: 'plot-box' }, canvas,
      el('div', { class: 'segmented', role: 'group', 'aria-label': 'Speed in the plot' }, linear, angular)) };
}

function buildHelp() {
  const dialog = el('dialog', { class: 'help', 'aria-label': 'Keyboard help' });
  append(dialog, [
    el('div', { class: 'help-head' }, el('h2', {}, 'Keyboard'),
      iconButton('close', 'Close', () => dialog.close())),
    el('dl', {}, KEYS.map(([keys, what]) => el('div', {},
      el('dt', {}, keys.split(' ').map((key) => el('kbd', {}, key))), el('dd', {}, what)))),
    el('p', { class: 'quiet' }, 'Drag the map to move it. Click it, then scroll to zoom; or hold Ctrl.'),
    el('p', { class: 'quiet' }, el('b', {}, 'Clearance: '), CLEARANCE),
  ]);
  dialog.addEventListener('click', (event) => {
    if (event.target === dialog) dialog.close();
  });
  return dialog;
}

/** Everything the player consists of, as {name: part}; `parts.element` is the whole. */
function buildPlayer(actions, count) {
  const head = buildHeader(actions, count);
  const stage = buildStage(actions);
  const readout = buildReadout();
  const timeline = new Timeline(actions.seek, actions.showNextOf);
  const transport = buildTransport(actions);
  const plot = buildPlot(actions);
  const log = new LogPane(actions.seek);
  const account = el('ol', { class: 'account-list' });
  const status = el('p', { class: 'hidden-text', role: 'status', 'aria-live': 'polite' });
  const help = buildHelp();
  const side = el('div', { class: 'player-side' },
    el('section', { class: 'side-part log-part' }, el('h2', {}, 'Log of the node'), log.element),
    el('details', { class: 'side-part account-part', open: count === 1 },
      el('summary', {}, 'The run in words'), account));
  const element = el('section', { class: 'player', 'aria-label': 'Replay' }, head.element,
    el('div', { class: 'player-main' }, stage.element, readout.element, transport.element,
      timeline.element, plot.element),
    side, status, help);
  return { element, head, side, stage, readout, timeline, transport, plot, log, account, status, help };
}
