// Charts over time (uPlot) in the project's colours.
import uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';

const dark = matchMedia('(prefers-color-scheme: dark)');

/// Returns the present value of a colour of page.css: colour('text').
export const colour = (name) =>
    getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
/// Colour and dash pattern of hand 0 or 1.
export const toolColour = (tool) => colour(`hand-${tool % 2}`);
export const toolDash = (tool) => (tool % 2 === 1 ? [7, 3] : []);
/// Calls `redraw` when the page's colours change.
export const onColourChange = (redraw) => dark.addEventListener('change', redraw);

/// A chart of several series over one axis of seconds, in `element`, as wide as it is.
/// series: [{label, colour, dash, width}], colour as a string or a function that gives one; data as
/// uPlot takes it: [xs, ys, ...]. The y axis' label is `unit`. `options` are further ones of uPlot's.
export function timeChart(element, {title, unit, series, height = 180, options = {}}, data) {
  const axis = {
    stroke: () => colour('text'),
    grid: {stroke: () => colour('line'), width: 1},
    ticks: {stroke: () => colour('line'), width: 1},
    font: '12px system-ui, sans-serif',
    labelFont: '12px system-ui, sans-serif',
    labelSize: 18,
  };
  const chart = new uPlot(
      {
        title,
        width: Math.max(element.clientWidth, 100),
        height,
        scales: {x: {time: false}},
        axes: [
          {...axis, label: 's', size: 32, labelGap: -2},
          {...axis, ...(unit ? {label: unit} : {}), size: unit ? 46 : 40},
        ],
        series: [
          {label: 's'},
          ...series.map(({label, colour: stroke, dash, width = 1.5}) =>
                            ({label, stroke, dash, width, points: {show: false}})),
        ],
        ...options,
      },
      data, element);
  new ResizeObserver(() => {
    const width = Math.max(element.clientWidth, 100);
    if (width !== chart.width) chart.setSize({width, height});
  }).observe(element);
  onColourChange(() => chart.redraw(false));
  return chart;
}
