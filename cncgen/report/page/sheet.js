// A canvas to draw on afresh.

/** Clear a canvas and give it a size; one that has the size keeps its memory. */
export function cleared(canvas, width, height) {
  const g = canvas.getContext("2d");
  if (canvas.width !== width || canvas.height !== height) {
    canvas.width = width;
    canvas.height = height;
  }
  g.setTransform(1, 0, 0, 1, 0, 0);
  g.clearRect(0, 0, width, height);
  return g;
}
