// Makes scripts smaller: a second pass after the bundler's, and a library of plots without what the page does not use.
import { readFile } from "node:fs/promises";
import { minify } from "terser";

/** Texts that are used once go to their place, which the bundler does not do: 7 % of the script of the page, as it is sent. */
export async function smaller(code) {
  return (await minify(code, { module: true, ecma: 2020, compress: { passes: 3, keep_fargs: false, unsafe_arrows: true } })).code;
}

/**
 * Other curves than straight and stepped ones, logarithmic scales, scales without a range of their own, the legend,
 * formats of dates, points of cursor and series, plots that move together, changes of series.
 */
const neverCalled = [
  ...["bars", "monotoneCubic", "autoPadSide", "nullExpand", "_rangeNum"],
  ...["rangeLog", "rangeAsinh", "logAxisSplits", "asinhAxisSplits", "log10AxisValsFilt", "log2AxisValsFilt"],
  ...["initLegendRow", "setLegend", "syncLegend", "legendStroke", "legendFill"],
  ...["fmtDate", "tzDate", "timeAxisVals", "timeAxisVal", "timeAxisStamps", "timeSeriesVal"],
  ...["points", "initCursorPt", "cursorPointShow", "cursorPointFill", "cursorPointStroke", "cursorPointSize"],
  ...["pub", "pubSync", "dblClick", "numSeriesVal", "seriesPointsShow"],
  ...["addSeries", "delSeries", "setSeries", "setFocus", "addBand", "setBand", "delBand"],
];

/**
 * What is the same in all plots of the page: series that share their times, linear scales, time to the right, no legend,
 * no focus, no other plot (`src`).
 */
const fixed = [
  [/const mode = (u|self)\.mode;/g, "const mode = 1;"],
  [/const showLegend = legend\.show;/, "const showLegend = false;"],
  [/const cursorFocus = focus\.prox >= 0;/, "const cursorFocus = false;"],
  [/const xScaleDistr = scaleX\.distr;/, "const xScaleDistr = 1;"],
  [/\b\w+\.distr +(==|>=) +(2|3|4|100)\b/g, "false"],
  [/\bscaleX\.ori == 0\b/g, "true"],
  [/\bscaleX\.ori == 1\b/g, "false"],
  [/\bsrc != null\b/g, "false"],
  [/\bsrc == null\b/g, "true"],
  [/\be != null\b/g, "true"],
  [/\bpubSync\(mouse.*\);/g, ""],
  [/\bsyncKey != null\b/g, "false"],
  [/\bshouldSetLegend \|\| cursorOnePt\b/g, "false"],
  [/\bcursorOnePt\b(?! =)/g, "false"],
  [/const sync = _sync\(syncKey\);|sync\.(un)?sub\(self\);|uPlot\.sync = _sync;/g, ""],
  [/const _timeAxisStamps = \[[^]*?\n\t\];/, "const _timeAxisStamps = [];"],
];

/** The source of uPlot without what the page does not use. It is one function that no bundler can shake. */
export function plotsOfThisPage(source) {
  const settled = fixed.reduce((text, [what, value]) => {
    if (!text.match(what)) throw new Error(`uPlot has no ${what}`);
    return text.replace(what, value);
  }, source);
  return neverCalled.reduce((text, name) => {
    const whole = new RegExp(`^(\\t?)function ${name}\\(.*\\{\\n(?:(?:\\1(?:\\t|//).*|//.*|\\s*)\\n)*\\1\\}$`, "m");
    if (!whole.test(text)) throw new Error(`uPlot has no function ${name}`);
    return text.replace(whole, `$1function ${name}() {}`);
  }, settled);
}

export const plotsTrimmed = {
  name: "plots of this page",
  setup: (build) =>
    build.onLoad({ filter: /uPlot\.esm\.js$/ }, async ({ path }) => ({
      contents: plotsOfThisPage(await readFile(path, "utf8")),
      loader: "js",
    })),
};
