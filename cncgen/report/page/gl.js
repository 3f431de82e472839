// WebGL2: paths as quads of a width in pixels, whose colours come from a row of a texture; surfaces, each triangle as
// bright as it faces the light. Points stand in textures, from which each corner takes its segment's ends: an instance a segment
// takes a graphics card that the processor plays ten times as long.

/** Points that are drawn at most. */
const POINTS = 600_000;
/** Points in a row of their textures. */
const WIDE = 2048;

const VERTEX = `#version 300 es
precision highp float;
uniform highp sampler2D points;
uniform sampler2D looks;
uniform mat4 matrix;
uniform vec2 size;
uniform float width;
uniform float lift;
uniform float pixels;
out float value;
flat out float kind;
out float way;
void main() {
  int k = gl_VertexID / 6, corner = gl_VertexID % 6;
  corner = corner < 3 ? corner : corner < 5 ? 5 - corner : 3;
  ivec2 from = ivec2(k % ${WIDE}, k / ${WIDE}), to = ivec2((k + 1) % ${WIDE}, (k + 1) / ${WIDE});
  vec2 look = texelFetch(looks, to, 0).rg;
  float style = look.g * 255.0;
  vec4 a = texelFetch(points, from, 0), b = texelFetch(points, to, 0);
  vec4 p = matrix * vec4(a.xyz, 1.0), q = matrix * vec4(b.xyz, 1.0);
  vec2 d = (q.xy - p.xy) * size * 0.5;
  float length = length(d);
  vec2 along = length > 1e-6 ? d / length : vec2(1.0, 0.0);
  vec2 across = vec2(-along.y, along.x);
  float side = (corner & 1) == 0 ? -1.0 : 1.0;
  bool end = corner >= 2;
  float half_width = 0.5 * width;
  vec2 offset = across * side * half_width + along * (end ? half_width : -half_width) * 0.5;
  vec4 c = end ? q : p;
  gl_Position = vec4(c.xy + offset * 2.0 / size, c.z - lift, 1.0);
  if (style > 1.5) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
  value = end ? look.r : texelFetch(looks, from, 0).r;
  kind = style;
  way = (end ? b.w : a.w) * pixels;
}`;

const FRAGMENT = `#version 300 es
precision highp float;
in float value;
flat in float kind;
in float way;
uniform sampler2D palette;
uniform float steps;
uniform vec4 solid;
uniform vec4 rapid;
uniform float opacity;
out vec4 colour;
void main() {
  float cover = 1.0;
  float place = steps > 0.5 ? (floor(value * 255.0 + 0.5) + 0.5) / 256.0 : (value * 255.0 + 0.5) / 256.0;
  vec4 tint = solid.a > 0.0 ? solid : texture(palette, vec2(place, 0.5));
  if (kind > 0.5 && solid.a <= 0.0 && rapid.a > 0.0) {
    tint = rapid;
    if (mod(way, 9.0) > 5.0) cover *= 0.15;
  }
  float alpha = tint.a * cover * opacity;
  if (alpha < 0.02) discard;
  colour = vec4(tint.rgb * alpha, alpha);
}`;

const SURFACE_VERTEX = `#version 300 es
precision highp float;
layout(location=0) in vec3 point;
uniform mat4 matrix;
out vec3 place;
void main() {
  place = point;
  gl_Position = matrix * vec4(point, 1.0);
}`;

const SURFACE_FRAGMENT = `#version 300 es
precision highp float;
in vec3 place;
uniform vec3 toward;
uniform vec3 light;
uniform vec4 solid;
uniform vec4 deep;
uniform vec2 under;
out vec4 colour;
void main() {
  vec3 normal = normalize(cross(dFdx(place), dFdy(place)));
  if (dot(normal, toward) < 0.0) normal = -normal;
  float bright = 0.52 + 0.36 * dot(normal, toward) + 0.2 * dot(normal, light);
  // A floor faces as the top does: its colour alone tells it, by the logarithm of its depth, so that shallow cuts show on tall parts.
  float depth = log(1.0 + 1000.0 * max(0.0, under.x - place.z) * under.y) / log(1001.0);
  vec4 tint = mix(solid, deep, depth);
  colour = vec4(tint.rgb * bright, tint.a);
}`;

/** Return a WebGL2 context with what draws segments, or null where the browser has none. */
export function segmentDrawer(canvas) {
  const gl = canvas.getContext("webgl2", { antialias: true, alpha: true, premultipliedAlpha: true });
  if (!gl) return null;
  const program = linked(gl, VERTEX, FRAGMENT);
  const place = uniforms(gl, program, ["matrix", "size", "width", "lift", "pixels", "palette", "points", "looks", "steps", "solid", "rapid", "opacity"]);
  let filling = null;
  const none = gl.createVertexArray(), palette = texture(gl);
  gl.useProgram(program);
  ["palette", "points", "looks"].forEach((name, unit) => gl.uniform1i(place[name], unit));
  gl.enable(gl.BLEND);
  gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  gl.enable(gl.DEPTH_TEST);
  gl.depthFunc(gl.LEQUAL);
  return {
    vertices: 0,
    most: POINTS,
    polyline: (points, values, styles) => polyline(gl, points, values, styles),
    surface: (points, triangles) => surface(gl, points, triangles),
    setPalette(bytes) {
      gl.bindTexture(gl.TEXTURE_2D, palette);
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, bytes.length / 4, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
    },
    begin(width, height) {
      gl.viewport(0, 0, width, height);
      gl.clearColor(0, 0, 0, 0);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      this.vertices = 0;
    },
    /** Draw a `polyline`; how it is drawn has matrix, size, width, pixels of a mm, solid (a colour) or the palette, and `under`: it hides nothing. */
    draw(buffer, how) {
      if (!buffer || !buffer.count) return;
      gl.useProgram(program);
      gl.depthMask(!how.under);
      gl.uniformMatrix4fv(place.matrix, false, how.matrix);
      gl.uniform2f(place.size, how.size[0], how.size[1]);
      gl.uniform1f(place.width, how.width);
      gl.uniform1f(place.lift, how.lift ?? 0);
      gl.uniform1f(place.pixels, how.pixels ?? 1);
      gl.uniform1f(place.steps, how.steps ? 1 : 0);
      gl.uniform4fv(place.solid, how.solid ?? [0, 0, 0, 0]);
      gl.uniform4fv(place.rapid, how.rapid ?? [0, 0, 0, 0]);
      gl.uniform1f(place.opacity, how.opacity ?? 1);
      [palette, buffer.points, buffer.looks].forEach((one, unit) => {
        gl.activeTexture(gl.TEXTURE0 + unit);
        gl.bindTexture(gl.TEXTURE_2D, one);
      });
      gl.activeTexture(gl.TEXTURE0);
      gl.bindVertexArray(none);
      gl.drawArrays(gl.TRIANGLES, 0, 6 * buffer.count);
      gl.depthMask(true);
      this.vertices += 6 * buffer.count;
    },
    /** Draw a `surface`: matrix, directions to the viewer (toward) and to the light, its colours at the top (solid) and at the foot (deep), and `under`: the
    Z of the top, and 1 over the height, or 0 for one colour. */
    fill(buffer, how) {
      if (!filling) {
        const made = linked(gl, SURFACE_VERTEX, SURFACE_FRAGMENT);
        filling = { made, place: uniforms(gl, made, ["matrix", "toward", "light", "solid", "deep", "under"]) };
      }
      gl.useProgram(filling.made);
      gl.uniformMatrix4fv(filling.place.matrix, false, how.matrix);
      gl.uniform3fv(filling.place.toward, how.toward);
      gl.uniform3fv(filling.place.light, how.light);
      gl.uniform4fv(filling.place.solid, how.solid);
      gl.uniform4fv(filling.place.deep, how.deep);
      gl.uniform2fv(filling.place.under, how.under);
      // A path on the surface is over it.
      gl.enable(gl.POLYGON_OFFSET_FILL);
      gl.polygonOffset(1, 4);
      gl.bindVertexArray(buffer.array);
      gl.drawElements(gl.TRIANGLES, buffer.count, gl.UNSIGNED_INT, 0);
      gl.disable(gl.POLYGON_OFFSET_FILL);
      this.vertices += buffer.count;
    },
  };
}

function uniforms(gl, program, names) {
  return Object.fromEntries(names.map((name) => [name, gl.getUniformLocation(program, name)]));
}

function linked(gl, vertex, fragment) {
  const program = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
  return program;
}

function texture(gl) {
  const made = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, made);
  for (const side of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, side, gl.NEAREST);
  for (const side of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, side, gl.CLAMP_TO_EDGE);
  return made;
}

/**
 * Put a polyline into textures: `points` three numbers a point, `values` and `styles` a byte a point.
 *
 * Segment k goes from point k to k + 1 in the style of k + 1: 0 feed, 1 rapid, 2 not drawn.
 */
function polyline(gl, points, values, styles) {
  const high = Math.max(1, Math.ceil(styles.length / WIDE)), places = new Float32Array(4 * WIDE * high), both = new Uint8Array(2 * WIDE * high);
  // Behind each point stands the length of the polyline up to it, along which rapids are dashed.
  for (let k = 0, from = 0, to = 0, length = 0; k < styles.length; k++, from += 3, to += 4) {
    let square = 0;
    for (let axis = 0; axis < 3; axis++) {
      const place = (places[to + axis] = points[from + axis]);
      if (k) square += (place - points[from + axis - 3]) ** 2;
    }
    places[to + 3] = length += Math.sqrt(square);
  }
  styles.forEach((style, k) => (both[2 * k + 1] = style));
  const found = {
    points: texture(gl),
    looks: null,
    count: Math.max(0, styles.length - 1),
    setValues(bytes) {
      bytes.forEach((value, k) => (both[2 * k] = value));
      gl.bindTexture(gl.TEXTURE_2D, this.looks);
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.RG8, WIDE, high, 0, gl.RG, gl.UNSIGNED_BYTE, both);
    },
    free() {
      for (const one of [this.points, this.looks]) gl.deleteTexture(one);
    },
  };
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, WIDE, high, 0, gl.RGBA, gl.FLOAT, places);
  found.looks = texture(gl);
  found.setValues(values);
  return found;
}

/** Put a mesh into buffers: `points` three numbers a corner, `triangles` three corners each. */
function surface(gl, points, triangles) {
  const array = gl.createVertexArray();
  gl.bindVertexArray(array);
  for (const [kind, data] of [[gl.ARRAY_BUFFER, points], [gl.ELEMENT_ARRAY_BUFFER, triangles]]) {
    gl.bindBuffer(kind, gl.createBuffer());
    gl.bufferData(kind, data, gl.STATIC_DRAW);
  }
  gl.enableVertexAttribArray(0);
  gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 12, 0);
  gl.bindVertexArray(null);
  return { array, count: triangles.length };
}
