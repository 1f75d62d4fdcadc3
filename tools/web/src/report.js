// A session's report: the page's tables stand in its HTML; here are its curves and its 3-D path.
import './page.css';
import './report.css';

import {drawCurves, drawHistograms} from './report_curves.js';
import {drawPath} from './report_path.js';

const data = JSON.parse(document.getElementById('data').textContent);
const place = (id) => document.getElementById(id);

drawCurves(place('curves'), data);
drawPath(place('view'), data);
if (place('histograms')) drawHistograms(place('histograms'), data);
