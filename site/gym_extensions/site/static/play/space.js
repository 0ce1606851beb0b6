// Draws a body in space on a canvas: perspective, floor, shadow, and limbs from far to near.
const AZIMUTH = 2.1, ELEVATION = -0.2, DISTANCE = 4.6, FOCUS = 3.1, HEIGHT = 0.85, LINES = 6;

// A camera that looks at (x, y) at the height of a torso: project(point) is [x, y, depth] in pixels and m.
export function camera(canvas, [x, y]) {
  const width = canvas.clientWidth, height = canvas.clientHeight, zoom = FOCUS * height / 2;
  const { right, up, ahead } = figure.directions(AZIMUTH, ELEVATION), { dot } = figure;
  const eye = [x, y, HEIGHT].map((value, i) => value - DISTANCE * ahead[i]);
  return {
    zoom,
    project(point) {
      const from = point.map((value, i) => value - eye[i]), depth = Math.max(dot(from, ahead), 0.05);
      return [width / 2 + zoom * dot(from, right) / depth, height / 2 - zoom * dot(from, up) / depth, depth];
    },
    // The point of the world at a pixel and a depth.
    unproject(px, py, depth) {
      const a = (px - width / 2) * depth / zoom, b = (height / 2 - py) * depth / zoom;
      return eye.map((value, i) => value + depth * ahead[i] + a * right[i] + b * up[i]);
    },
  };
}

// A colour moved towards another one, as the style sheet can say it.
const mixed = (colour, other, share) => `color-mix(in srgb, ${colour} ${Math.round(100 * share)}%, ${other})`;

export function drawSpace(view, shapes, place) {
  const { pen, colour } = view, { project, zoom } = camera(pen.canvas, place);
  const line = (from, to, thickness, style) => {
    const [x1, y1] = project(from), [x2, y2] = project(to);
    pen.strokeStyle = style;
    pen.lineWidth = thickness;
    pen.beginPath();
    pen.moveTo(x1, y1);
    pen.lineTo(x2 + 0.01, y2);
    pen.stroke();
  };
  drawFloor(view, project, line, place);
  for (const [role, radius, start, end] of shapes) {
    if (role === "wall") continue;
    const [from, to] = [start, end].map(([x, y]) => [x, y, 0]), [, , depth] = project(from);
    line(from, to, 2 * radius * zoom / depth, mixed(colour("--ink"), colour("--paper"), 0.14));
  }
  const things = shapes.map((shape) => ({ shape, depth: depthOf(shape, project) })).sort((a, b) => b.depth - a.depth);
  for (const { shape: [role, radius, start, end], depth } of things) {
    if (role === "wall") {
      drawBox(view, project, start, end);
      continue;
    }
    const base = colour(figure.LIMBS[role]), thickness = 2 * radius * zoom / depth;
    const near = Math.min(Math.max((DISTANCE + 0.5 - depth), 0), 1);
    line(start, end, thickness + 2, colour("--paper"));
    line(start, end, thickness, mixed(base, colour("--ink"), 0.72 + 0.28 * near));
    const lift = radius * 0.4;
    line([start[0], start[1], start[2] + lift], [end[0], end[1], end[2] + lift], thickness * 0.3, mixed("white", "transparent", 0.28));
  }
}

const depthOf = ([role, , start, end], project) => (
  role === "wall" ? project(start)[2] : (project(start)[2] + project(end)[2]) / 2);

function drawFloor({ colour }, project, line, [x, y]) {
  const middle = [Math.round(x), Math.round(y)];
  for (let i = -LINES; i <= LINES; i++) {
    const style = (far) => mixed(colour("--strong-rule"), "transparent", 0.55 * Math.max(1 - Math.abs(far) / (LINES + 1), 0));
    for (let part = -LINES; part < LINES; part++) {
      const far = Math.hypot(i, part);
      line([middle[0] + i, middle[1] + part, 0], [middle[0] + i, middle[1] + part + 1, 0], 1, style(far));
      line([middle[0] + part, middle[1] + i, 0], [middle[0] + part + 1, middle[1] + i, 0], 1, style(far));
    }
  }
}

// The faces of a box, center and half sizes, from far to near.
function drawBox({ pen, colour }, project, center, half) {
  const faces = [0, 1, 2].flatMap((axis) => [-1, 1].map((side) => {
    const [b, c] = [(axis + 1) % 3, (axis + 2) % 3];
    const corners = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([u, v]) => {
      const point = [...center];
      point[axis] += side * half[axis];
      point[b] += u * half[b];
      point[c] += v * half[c];
      return project(point);
    });
    return { corners, axis, depth: corners.reduce((sum, corner) => sum + corner[2], 0) };
  }));
  for (const { corners, axis } of faces.sort((a, b) => b.depth - a.depth)) {
    pen.fillStyle = mixed(mixed(colour("--cold"), colour("--ink"), [0.85, 0.75, 1][axis]), "transparent", 0.85);
    pen.beginPath();
    for (const [x, y] of corners) pen.lineTo(x, y);
    pen.closePath();
    pen.fill();
  }
}
