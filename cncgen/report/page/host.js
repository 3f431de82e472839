// What holds the page: a notebook that frames it hears of the view, and may change it (widget.js).

const framed = typeof window !== "undefined" && window.parent !== window;

/** Tell the host what is seen: an object of plain values. */
export function tell(state) {
  if (framed) window.parent.postMessage({ cncgen: state }, "*");
}

/** Call a function with what the host asks for. */
export function heed(asked) {
  if (framed) addEventListener("message", ({ data, source }) => source === window.parent && data?.cncgen && asked(data.cncgen));
}
