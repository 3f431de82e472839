// Canvases to draw on.

/**
 * Return the context of a canvas, which draws by the processor.
 *
 * Some hundred lines and words are quicker so than the shaders that they would need first where no graphics card is.
 */
export function sheet(canvas) {
  return canvas.getContext("2d", { willReadFrequently: true });
}

/** Clear a canvas and give it a size; one that has the size keeps its memory. */
export function cleared(canvas, width, height) {
  const g = sheet(canvas);
  if (canvas.width !== width || canvas.height !== height) {
    canvas.width = width;
    canvas.height = height;
  }
  g.setTransform(1, 0, 0, 1, 0, 0);
  g.clearRect(0, 0, width, height);
  return g;
}
