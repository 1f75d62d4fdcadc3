// The dashboard: shows the updates of `hpdm spy --web` (tools/spy/dashboard/dashboard_state.cc).
import './page.css';
import './dashboard.css';
import {Charts} from './dashboard_charts.js';
import {
  showChannels, showEvents, showExercise, showHands, showHealth, showNotices, showState,
} from './dashboard_panels.js';
import {makePalette} from './dashboard_palette.js';
import {OrganScene} from './dashboard_scene.js';
import {makePlayer} from './dashboard_player.js';

const lostAfterMs = 3500;  // the server sends something every second

// The displayed state. Members of an update replace those of the same name; lists are extended.
const session = {
  connected: false,
  everConnected: false,
  status: null,
  instruments: [],
  tools: null,
  rows: [],       // [interval, then force (N), depth (m), guard flags of each hand]
  health: null,
  exercise: null,
  channels: [],
  events: [],
  organNames: new Map(),
  organsWithoutFit: new Set(),
  meshErrors: [],
  noWebGl: '',
  updates: 0,
};
const maxRows = 1800, maxEvents = 100;

const charts = new Charts(document.getElementById('force'), document.getElementById('depth'));
const scene = new OrganScene(document.getElementById('scene'), session);
const showPlayer = makePlayer();
makePalette();

function take(update) {
  ++session.updates;
  session.status = update.status;
  if (update.reset) {
    Object.assign(session, {tools: null, rows: [], health: null, exercise: null, events: []});
    scene.keepOnly(update.reset.organs);
  }
  if (update.sinking) scene.setSinking(update.sinking);
  if (update.mesh_errors) {
    session.meshErrors =
        update.mesh_errors.map(([organ, why]) => `Organ ${organ} is not shown: ${why}.`);
  }
  for (const name of ['instruments', 'tools', 'health', 'exercise', 'channels']) {
    if (update[name] !== undefined) session[name] = update[name];
  }
  if (update.rows) session.rows = session.rows.concat(update.rows).slice(-maxRows);
  if (update.events) session.events = session.events.concat(update.events).slice(-maxEvents);
  for (const mesh of update.meshes ?? []) scene.load(mesh);
  for (const shape of update.organs ?? []) scene.deform(shape);
  showSoon();
}

// Draws at most once per frame of the screen, and never while the page is hidden.
let asked = false;
function showSoon() {
  if (asked) return;
  asked = true;
  requestAnimationFrame(() => {
    asked = false;
    showState(session);
    showNotices(session);
    showPlayer(session.status?.player);
    showExercise(session);
    showHands(session);
    showHealth(session);
    showChannels(session);
    showEvents(session);
    charts.show(session);
    scene.show();
  });
}

let stream = null, heardAt = 0;
function connect() {
  stream?.close();
  heardAt = performance.now();
  stream = new EventSource('events');
  stream.onmessage = ({data}) => {
    heardAt = performance.now();
    session.connected = session.everConnected = true;
    take(JSON.parse(data));
  };
  stream.onerror = () => {
    session.connected = false;
    showSoon();
  };
}
connect();
setInterval(() => {
  // The browser reconnects by itself, except after a refusal or silence.
  const silent = performance.now() - heardAt > lostAfterMs;
  if (silent || stream.readyState === EventSource.CLOSED) {
    session.connected = false;
    showSoon();
    connect();
  }
}, 1000);
scene.onLoaded = showSoon;

// For tests and the browser's console.
window.hpdm = {session, scene, charts};
