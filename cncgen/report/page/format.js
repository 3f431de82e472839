// Numbers as text: digits of a step, times, shares.

/** Return how many decimals a step has: 0.001 has three, 10 has none. */
export function decimals(step) {
  return Math.max(0, Math.round(-Math.log10(step)));
}

/** Return a whole number of steps as text, to the digit of the step. */
export function stepped(count, step) {
  const digits = decimals(step);
  const text = digits ? (count / 10 ** digits).toFixed(digits) : String(count * Math.round(step));
  return /^-0(\.0*)?$/.test(text) ? text.slice(1) : text;
}

/** Return seconds as text: "4.102 s", "2:52.755 min", "1:02:03.4 h". */
export function duration(seconds) {
  if (!(seconds >= 60)) return `${seconds.toFixed(3)} s`;
  const minutes = Math.floor(seconds / 60);
  const rest = seconds - 60 * minutes;
  if (minutes < 60) return `${minutes}:${rest.toFixed(3).padStart(6, "0")} min`;
  return `${Math.floor(minutes / 60)}:${String(minutes % 60).padStart(2, "0")}:${rest.toFixed(1).padStart(4, "0")} h`;
}

/** Return a short time: milliseconds below a second. */
export function brief(seconds) {
  const size = Math.abs(seconds);
  if (size === 0) return "0";
  if (size < 5e-5) return "0.0 ms";
  if (size < 0.9995) return `${(1000 * seconds).toFixed(size < 0.00995 ? 1 : 0)} ms`;
  if (size < 99.95) return `${seconds.toFixed(2)} s`;
  if (size < 3599.5) {
    const whole = Math.round(size);
    return `${seconds < 0 ? "−" : ""}${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")} min`;
  }
  return `${(seconds / 3600).toFixed(2)} h`;
}

/** Return a part of a time as text, with no unit smaller than that of the largest part beside it. */
export function partly(seconds, most) {
  if (most < 0.9995 || seconds >= 0.9995 || seconds === 0) return brief(seconds);
  return seconds < 0.005 ? "<0.01 s" : `${seconds.toFixed(2)} s`;
}

/** Return a part of one as per cent. */
export function share(part) {
  const percent = 100 * part;
  if (percent === 0) return "0 %";
  if (Math.abs(percent) < 0.05) return "<0.1 %";
  return `${percent.toFixed(1)} %`;
}

/** Return a number with four significant digits, without an exponent where it is readable without. */
export function rounded(value) {
  const size = Math.abs(value);
  if (size === 0) return "0";
  if (size >= 1e6) return `${Number((value / 1e6).toPrecision(3))}M`;
  if (size >= 1e4) return `${Number((value / 1e3).toPrecision(3))}k`;
  if (size < 1e-3) return value.toExponential(1);
  return String(Number(value.toPrecision(4)));
}

/** Return round numbers (1, 2 or 5 times a power of ten apart) between two values. */
export function ticks(low, high, count) {
  if (!(high > low)) return [low];
  const rough = (high - low) / count;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * ([1, 2, 5, 10].find((factor) => factor * power >= rough * (1 - 1e-9)) ?? 10);
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k <= Math.floor(high / step + 1e-9); k++) found.push(Number((k * step).toPrecision(12)));
  return found;
}
