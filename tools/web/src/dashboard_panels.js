// Texts and tables of the dashboard: everything except the charts and the organs.

const find = (id) => document.getElementById(id);

/// Makes an element with text or children.
function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

const count = (n) => Number(n).toLocaleString('en-US');
const plural = (n, one, many = `${one}s`) => `${count(n)} ${n === 1 ? one : many}`;

function bytes(n) {
  return n < 1e4 ? `${n.toFixed(0)} B` : n < 1e6 ? `${(n / 1e3).toFixed(0)} kB` : `${(n / 1e6).toFixed(1)} MB`;
}

/// Formats nanoseconds with three digits and a unit.
export function duration(ns) {
  const units = [[1e9, 's'], [1e6, 'ms'], [1e3, 'µs'], [1, 'ns']];
  const [size, unit] = units.find(([least]) => ns >= least) ?? [1, 'ns'];
  return ns === 0 ? '0' : `${Number((ns / size).toPrecision(3))} ${unit}`;
}

// Bits of GuardFlag and StepFlag of engine/snapshots.h.
const guardTexts = ['force not finite', 'at the force limit', 'force step limited', 'force fading in',
  'patch too old: force fading out', 'device lost: force fading out', 'forces off', 'passivity damping',
  'paused', 'friction in the trocar', 'energy tank'];
const stepTexts = ['relaxation out of time', 'NaN caught, organ reset to rest', 'contacts dropped',
  'contacts coincide'];
const words = (flags, texts) => texts.filter((_, bit) => flags >> bit & 1);

const lost = (session) => session.channels.reduce((sum, channel) => sum + channel.lost, 0);

export function showState(session) {
  const {status} = session;
  let text = 'connecting', tone = 'warn';
  if (!session.connected) {
    text = session.everConnected ? 'connection lost' : 'connecting';
    tone = session.everConnected ? 'bad' : 'warn';
  } else if (status.player) {
    text = status.player.ended ? 'end of the log' : status.player.paused ? 'log, paused' : 'log, playing';
    tone = 'good';
  } else if (session.events.at(-1)?.name === 'session.end') {
    text = 'session ended';
  } else if (status.messages === 0) {
    text = 'no messages yet';
  } else if (status.silent_s > 2) {
    text = `silent for ${status.silent_s.toFixed(0)} s`;
  } else {
    text = 'live';
    tone = 'good';
  }
  const badge = find('state');
  if (badge.textContent !== text) badge.textContent = text;
  badge.className = `badge ${tone}`;
  const source = find('source'), name = status?.source ?? '';
  if (source.textContent !== name) source.textContent = name;
}

/// Returns the notices for the reader, one line each: [tone, text].
export function notices(session) {
  const list = [];
  const {status, health} = session;
  if (!session.connected && session.everConnected) {
    list.push(['bad', 'No connection to hpdm spy: the page shows old data and is reconnecting.']);
  }
  if (session.connected && status.messages === 0 && !status.player) {
    list.push(['warn', 'No messages yet. Start a session with: hpdm run SCENE --live']);
  }
  if (session.connected && !status.player && status.silent_s > 2 && status.messages > 0 &&
      session.events.at(-1)?.name !== 'session.end') {
    list.push(['warn', 'No messages from the session: it was stopped, or the network failed.']);
  }
  if (status?.two_sessions) {
    list.push(['bad', 'Two sessions publish on the same network and their messages are mixed: ' +
        'give each its own LCM_DEFAULT_URL.']);
  }
  const lossy = session.channels.filter((channel) => channel.lost > 0);
  if (lossy.length > 0) {
    list.push(['warn', `${plural(lost(session), 'message was', 'messages were')} lost in transit: ` +
        lossy.map((channel) => `${count(channel.lost)} of ${channel.channel}`).join(', ') + '.']);
  }
  if (status?.dropped > 0) {
    list.push(['warn', `hpdm spy was too slow for ${plural(status.dropped, 'message')}.`]);
  }
  if (health?.log_dropped > 0) {
    list.push(['bad', `The session's log lost ${plural(health.log_dropped, 'event')}.`]);
  }
  for (const organ of session.organsWithoutFit) {
    list.push(['warn', `${session.organNames.get(organ)}: its displacements belong to another mesh.`]);
  }
  for (const text of session.meshErrors) list.push(['warn', text]);
  if (session.noWebGl) list.push(['warn', session.noWebGl]);
  return list;
}

export function showNotices(session) {
  const list = notices(session), element = find('notices');
  const key = JSON.stringify(list);
  if (element.dataset.key !== key) {
    element.dataset.key = key;
    element.replaceChildren(...list.map(([tone, text]) => make('li', {class: tone}, text)));
  }
  const nothing = session.noWebGl || session.organNames.size > 0 ? '' : session.status?.player ?
      'No mesh yet: organs appear after the last part of HPDM_MESH in the log.' :
      'No mesh yet: organs appear once all parts of HPDM_MESH have come. A live session repeats them every 3 s.';
  if (find('nothing').textContent !== nothing) find('nothing').textContent = nothing;
}

function handName(session, i) {
  const name = session.instruments[i];
  return name ? name : `hand ${i + 1}`;
}

// s for which an error stays, as in the window (render/overlay/exercise_text.cc).
const errorShown = 8;

/// Shows the exercise's present step, score and time, and what was wrong for a while.
export function showExercise({exercise}) {
  const panel = find('exercise');
  panel.hidden = !exercise;
  if (!exercise) return;
  const {step, steps, ended, passed} = exercise;
  const set = (name, text) => {
    const element = panel.querySelector(name);
    if (element.textContent !== text) element.textContent = text;
  };
  set('.name', exercise.name);
  set('.instruction', !ended ? `${step + 1}/${steps} ${exercise.instruction}` :
      passed ? 'Exercise done' : `Time is over: ${step} of ${steps} steps done`);
  panel.querySelector('progress').value = (ended ? step / Math.max(steps, 1) : exercise.progress) ?? 0;
  const recent = exercise.last_error && exercise.time - exercise.error_time < errorShown;
  // A value that is not finite is null in JSON.
  const fixed = (value, digits) => (value ?? 0).toFixed(digits);
  set('.error', recent || (ended && exercise.last_error) ?
      `${exercise.last_error} (at ${fixed(exercise.error_time, 1)} s)` : '');
  set('.score', fixed(exercise.score, 0));
  set('.time', `${fixed(exercise.time, 0)} s`);
  set('.left', `${fixed(exercise.time_left, 0)} s`);
  set('.errors', count(exercise.errors));
  set('.restarts', count(exercise.restarts));
}

const contactTexts = ['free', 'pressing', 'grasping'];

export function showHands(session) {
  const tools = session.tools?.tools ?? [], section = find('hands');
  while (section.children.length > Math.max(tools.length, 1)) section.lastChild.remove();
  while (section.children.length < tools.length || section.children.length === 0) {
    const i = section.children.length;
    const figure = (name) => make('div', {}, make('div', {class: 'muted'}, name),
        make('div', {class: `value ${name}`}, '–'), make('div', {class: `peak ${name}-peak`}));
    section.append(make('div', {class: 'panel hand', style: `--hand: var(--hand-${i % 2})`},
        make('h2', {}, make('span', {class: 'name'}), make('i', {class: 'sample'})),
        make('div', {class: 'figures'}, figure('force'), figure('depth')), make('p', {class: 'contact'})));
  }
  // Flags of a single tick are too short to read, so they are shown for a second.
  const recent = session.rows.slice(-30);
  [...section.children].forEach((card, i) => {
    const set = (name, text) => {
      const element = card.querySelector(name);
      if (element.textContent !== text) element.textContent = text;
    };
    set('.name', handName(session, i));
    const tool = tools[i];
    if (!tool) return;
    // Peaks since this dashboard began, or since the last seek.
    const begin = session.tools.begin, since = begin > 0.5 ? ` (from t = ${begin.toFixed(1)} s)` : '';
    set('.value.force', `${Math.hypot(...tool.force).toFixed(2)} N`);
    set('.value.depth', `${(1000 * tool.depth).toFixed(1)} mm`);
    set('.force-peak', `peak ${tool.peak_force.toFixed(2)} N${since}`);
    set('.depth-peak', `peak ${(1000 * tool.peak_depth).toFixed(1)} mm${since}`);
    const flags = recent.reduce((all, row) => all | (row[3 + 3 * i] ?? 0), tool.guard_flags);
    const organ = session.organNames.get(tool.organ);
    set('.contact', [`${contactTexts[tool.kind] ?? ''}${tool.kind > 0 && organ ? ` ${organ}` : ''}`,
      ...words(flags, guardTexts)].join(' · '));
  });
}

// A value that is not finite is null in JSON.
const rate = (hz) => hz === null ? '–' : hz.toFixed(hz >= 100 ? 0 : 1);

let shownHealth;
export function showHealth(session) {
  const flags = words(session.tools?.step_flags ?? 0, stepTexts);
  const text = session.tools?.step === undefined ? '' :
      `Step ${count(session.tools.step)}: ${flags.length ? flags.join(', ') : 'no flags'}`;
  if (find('flags').textContent !== text) find('flags').textContent = text;
  const {health} = session;
  if (health === shownHealth) return;
  shownHealth = health;
  if (!health) {
    find('loops').replaceChildren(make('p', {class: 'muted'}, 'Waiting for HPDM_STATS, which comes once per second.'));
    find('counts').textContent = '';
    find('latency').replaceChildren(make('p', {class: 'muted'}, 'Waiting for HPDM_STATS.'));
    return;
  }
  const loop = (name, {rate_hz: hz, missed}, unit) => make('tr', {}, make('td', {}, name),
      make('td', {class: 'number'}, rate(hz)),
      make('td', {class: `number${missed > 0 ? ' warn' : ''}`}, `${count(missed)} ${unit}`));
  find('loops').replaceChildren(make('table', {},
      make('tr', {}, make('th', {}, 'loop'), make('th', {class: 'number'}, 'per second'),
          make('th', {class: 'number'}, 'missed')),
      loop('haptic', health.haptic, 'ticks'), loop('deformation', health.deformation, 'steps'),
      loop('render', health.render, 'frames')));
  find('counts').textContent =
      `In ${health.counted_s.toFixed(0)} s. Ticks skipped: ${count(health.skipped_late_wake_up)} because of late wake-ups, ` +
      `${count(health.skipped_long_compute)} because of long computing, ${count(health.skipped_stalled)} because of CPU steal ` +
      `(${health.stolen_ms.toFixed(0)} ms in all). Since the session began: ` +
      `${plural(health.log_events, 'event')} in the log, ${count(health.log_dropped)} dropped; ` +
      `${plural(health.queue_overflows, 'full queue')}; ${count(health.live_errors)} not published.`;
  showLatencies(health.latencies);
}

const latencyNames = {
  'haptic.wake_up': 'haptic wake-up, late by', 'haptic.compute': 'haptic tick',
  'haptic.period': 'haptic period', 'haptic.patch_age': 'age of the patch used',
  'haptic.device_to_force': 'device to force', 'deformation.wake_up': 'step wake-up, late by',
  'deformation.compute': 'deformation step', 'deformation.period': 'step period',
  'render.compute': 'picture', 'render.period': 'picture period',
  'render.device_to_photon': 'device to picture', 'baseline.wake_up': 'empty loop, late by',
};
// Axis of the bars: 1 µs to 1 s.
const decades = [['1 µs', 3], ['', 4], ['', 5], ['1 ms', 6], ['', 7], ['', 8], ['1 s', 9]];
const across = (exponent) => 100 * (exponent - 3) / 6;

function svg(tag, attributes, ...children) {
  const element = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

function bars({bins}) {
  const most = Math.max(...bins.map(([, n]) => n));
  const step = across(3 + Math.log10(2) / 4);
  const lines = decades.map(([, e]) => svg('line', {x1: `${across(e)}%`, x2: `${across(e)}%`, y1: 0, y2: '100%'}));
  const boxes = bins.map(([power, n]) => {
    // A minimum height keeps a single late tick among many visible.
    const high = Math.max(100 * n / most, 6);
    const x = Math.min(Math.max(across(power / 4 * Math.log10(2)) - step, 0), 100 - step);
    return svg('rect', {x: `${x}%`, width: `${0.9 * step}%`, y: `${100 - high}%`, height: `${high}%`});
  });
  return svg('svg', {'aria-hidden': 'true'}, ...lines, ...boxes);
}

function showLatencies(all) {
  // The lockstep clock measures nothing and reports 0.
  const latencies = all.filter(({max}) => max > 0);
  const unmeasured = all.filter(({max}) => max === 0).map(({name}) => latencyNames[name] ?? name);
  const note = unmeasured.length === 0 ? [] :
      [make('p', {class: 'muted'}, `Not measured (0, as on the lockstep clock): ${unmeasured.join('; ')}.`)];
  const head = make('tr', {}, make('th', {}, ''), make('th', {class: 'number'}, 'median'),
      make('th', {class: 'number'}, 'p99'), make('th', {class: 'number wide'}, 'max'), make('th', {}, ''));
  const rows = latencies.map((latency) => make('tr', {'data-latency': latency.name},
      make('td', {}, latencyNames[latency.name] ?? latency.name),
      make('td', {class: 'number'}, duration(latency.p50)), make('td', {class: 'number'}, duration(latency.p99)),
      make('td', {class: 'number wide'}, duration(latency.max)), make('td', {class: 'bars'}, bars(latency))));
  const labels = decades.filter(([label]) => label).map(([label, e]) => svg('text', {
    x: `${across(e)}%`, y: 10,
    'text-anchor': e === 3 ? 'start' : e === 9 ? 'end' : 'middle',
  }, label));
  const axis = make('tr', {class: 'axis'}, make('td', {}), make('td', {}), make('td', {}), make('td', {class: 'wide'}),
      make('td', {class: 'bars'}, svg('svg', {}, ...labels)));
  find('latency').replaceChildren(...(rows.length > 0 ? [make('table', {}, head, ...rows, axis)] : []), ...note);
}

let shownChannels = null;
export function showChannels({channels}) {
  if (channels === shownChannels) return;
  shownChannels = channels;
  const number = (text, tone = '') => make('td', {class: `number ${tone}`}, text);
  const heads = [['channel'], ['type', 'wide'], ['per second', 'number'], ['volume', 'number wide'],
    ['messages', 'number'], ['lost', 'number'], ['unreadable', 'number wide']];
  find('channels').replaceChildren(make('table', {},
      make('tr', {}, ...heads.map(([text, style = '']) => make('th', {class: style}, text))),
      ...channels.map((c) => make('tr', {'data-channel': c.channel}, make('td', {}, c.channel),
          make('td', {class: 'wide'}, c.type), number(rate(c.rate_hz)), number(`${bytes(c.bytes_per_s)}/s`, 'wide'),
          number(count(c.messages)), number(count(c.lost), c.lost > 0 ? 'warn' : ''),
          number(count(c.unreadable), c.unreadable > 0 ? 'bad wide' : 'wide')))));
}

let shownEvents = null;
export function showEvents({events}) {
  if (events === shownEvents) return;
  shownEvents = events;
  const tones = [['', ''], ['warn', 'Warning'], ['bad', 'Error']];
  find('events').replaceChildren(...events.toReversed().map(({time, severity, name, text}) => {
    const [tone, word] = tones[severity] ?? ['', ''];
    return make('li', {'data-event': name}, make('span', {class: 'clock'}, `${time.toFixed(2)} s`),
        make('b', {class: tone}, word ? `${word}: ${name}` : name), text);
  }));
}
