// Makes scripts smaller: a second pass after the bundler's, and a library of plots without what the page never calls.
import { readFile } from "node:fs/promises";
import { minify } from "terser";

/** Texts that are used once go to their place, which the bundler does not do: 7 % of the script of the page, as it is sent. */
export async function smaller(code) {
  return (await minify(code, { module: true, compress: { passes: 3 } })).code;
}

/** Other curves than straight and stepped ones, logarithmic scales, the legend, formats of dates, points of the cursor, changes of series. */
const neverCalled = [
  ...["bars", "monotoneCubic", "autoPadSide", "nullExpand"],
  ...["rangeLog", "rangeAsinh", "logAxisSplits", "asinhAxisSplits", "log10AxisValsFilt", "log2AxisValsFilt"],
  ...["initLegendRow", "setLegend", "syncLegend", "legendStroke", "legendFill"],
  ...["fmtDate", "tzDate", "timeAxisVals", "timeAxisVal", "timeAxisStamps", "timeSeriesVal"],
  ...["points", "initCursorPt", "cursorPointShow", "cursorPointFill", "cursorPointStroke", "cursorPointSize"],
  ...["addSeries", "delSeries", "setSeries", "setFocus", "addBand", "setBand", "delBand"],
];

/** The source of uPlot with the bodies of those functions left out. It is one function that no bundler can shake. */
export function withoutNeverCalled(source) {
  return neverCalled.reduce((text, name) => {
    const whole = new RegExp(`^(\\t?)function ${name}\\(.*\\{\\n(?:(?:\\1(?:\\t|//).*|//.*|\\s*)\\n)*\\1\\}$`, "m");
    if (!whole.test(text)) throw new Error(`uPlot has no function ${name}`);
    return text.replace(whole, `$1function ${name}() {}`);
  }, source);
}

export const plotsWithoutNeverCalled = {
  name: "plots without what is never called",
  setup: (build) =>
    build.onLoad({ filter: /uPlot\.esm\.js$/ }, async ({ path }) => ({
      contents: withoutNeverCalled(await readFile(path, "utf8")),
      loader: "js",
    })),
};
