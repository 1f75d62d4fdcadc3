// Charts over time (uPlot) in the project's colours.
import uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';

export const toolColours = ['#d1495b', '#00798c'];

/// A chart of several series over one axis of seconds, in `element`, as wide as it is.
/// series: [{label, colour}]; data as uPlot takes it: [xs, ys, ...].
export function timeChart(element, {title, unit, series, height = 180}, data) {
  const chart = new uPlot(
      {
        title,
        width: element.clientWidth,
        height,
        scales: {x: {time: false}},
        axes: [{label: 's'}, {label: unit}],
        series: [
          {label: 's'},
          ...series.map(({label, colour}) => ({label, stroke: colour, width: 1.5})),
        ],
      },
      data, element);
  new ResizeObserver(() => chart.setSize({width: element.clientWidth, height})).observe(element);
  return chart;
}
