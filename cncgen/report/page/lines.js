// Time by line, by limit, by tool: what the rows of a plan say of its program.

/** Key of a line in one of several files. */
export function lineKey(source, line) {
  return source * 2 ** 32 + line;
}

/**
 * Join the runs of line and source: each stretch of rows on one line, in order.
 *
 * Returns { keys, starts, visits }: key and first row of each stretch (the last entry of `starts` is the number of rows), and
 * the stretches of each key, as a Map from key to a list.
 */
export function stretches(line, source, rows) {
  const keys = [], starts = [];
  let s = 0;
  for (let k = 0; k < line.values.length; k++) {
    let start = line.starts[k];
    const stop = line.starts[k + 1];
    while (start < stop) {
      if (source) while (source.starts[s + 1] <= start) s++;
      const key = lineKey(source ? source.values[s] : 0, line.values[k]);
      if (keys.length === 0 || keys[keys.length - 1] !== key) {
        keys.push(key);
        starts.push(start);
      }
      start = source ? Math.min(stop, source.starts[s + 1]) : stop;
    }
  }
  starts.push(rows);
  const visits = new Map();
  keys.forEach((key, k) => {
    const list = visits.get(key);
    if (list) list.push(k);
    else visits.set(key, [k]);
  });
  return { keys, starts, visits };
}

/** Return how many periods each line takes, a Map from key to rows; the last row ends the motion and takes none. */
export function rowsByLine(found) {
  const totals = new Map();
  const last = found.starts[found.starts.length - 1] - 1;
  for (let k = 0; k < found.keys.length; k++) {
    const stop = Math.min(found.starts[k + 1], last);
    const took = Math.max(0, stop - found.starts[k]);
    totals.set(found.keys[k], (totals.get(found.keys[k]) || 0) + took);
  }
  return totals;
}

/** Return how many rows each value of a signal of runs has, a Map. */
export function rowsByValue(signal, rows) {
  const totals = new Map();
  for (let k = 0; k < signal.values.length; k++) {
    const took = Math.min(signal.starts[k + 1], rows - 1) - signal.starts[k];
    if (took > 0) totals.set(signal.values[k], (totals.get(signal.values[k]) || 0) + took);
  }
  return totals;
}

/** Return the name of a tool: T5 by number, or the name that the program gives. */
export function toolName(tool) {
  if (!tool) return "no tool";
  return typeof tool === "number" ? `T${tool}` : String(tool);
}

/** Return tools as runs over the rows: [{ tool, start, stop }], from the events of tool changes. */
export function toolRuns(events, period, rows) {
  const found = [{ tool: 0, start: 0, stop: rows }];
  for (const event of events) {
    if (event.event !== "tool") continue;
    const row = Math.min(rows, Math.max(0, Math.round(event.t_s / period)));
    const last = found[found.length - 1];
    if (last.start === row) last.tool = event.tool ?? 0;
    else {
      last.stop = row;
      found.push({ tool: event.tool ?? 0, start: row, stop: rows });
    }
  }
  return found;
}

/** Return how far along a stretch of rows a row is, 0 to 1 by length of path. */
export function along(position, start, stop, row) {
  let before = 0, whole = 0;
  for (let k = start; k < Math.min(stop, position[0].length - 1); k++) {
    let square = 0;
    for (const axis of position) square += (axis[k + 1] - axis[k]) ** 2;
    whole += Math.sqrt(square);
    if (k < row) before = whole;
  }
  return whole > 0 ? before / whole : 0;
}
