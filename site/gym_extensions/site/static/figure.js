// What Watch and Play share: drawings of bodies of a plane, the directions of a camera, the speed, and a clock.
// Shapes are [role, radius, x1, y1, x2, y2] in m, y up.
"use strict";
globalThis.figure = (() => {
  const FREE_BEAM = 0.25, SPEEDS = [0.25, 0.5, 1, 2, 4];
  const LIMBS = { body: "--accent", far: "--ring", changed: "--loss" };
  const calm = matchMedia("(prefers-reduced-motion: reduce)");
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

  // The directions to the right, up and ahead of a camera, angles in radians.
  function directions(azimuth, elevation) {
    const flat = Math.cos(elevation), high = Math.sin(elevation), x = Math.cos(azimuth), y = Math.sin(azimuth);
    return { right: [y, -x, 0], up: [-high * x, -high * y, flat], ahead: [flat * x, flat * y, high] };
  }

  // The menu of speeds.
  function speeds(select) {
    for (const speed of SPEEDS) select.add(new Option(`${speed} ×`, speed, speed === 1, speed === 1));
  }

  // A switch that starts or stops calling `each` with the seconds since the last frame.
  function clock(each) {
    let request = 0, before = 0;
    const frame = (now) => {
      const elapsed = (now - before) / 1000;
      before = now;
      request = requestAnimationFrame(frame);
      each(elapsed);
    };
    return (on) => {
      cancelAnimationFrame(request);
      if (on) request = requestAnimationFrame((now) => { before = now; frame(now); });
    };
  }

  // The part of a beam before it enters a wall, from 0 to 1; 0 if it misses.
  function enter(start, along, [, , ...corners]) {
    let first = 0, last = 1;
    for (const axis of [0, 1]) {
      const ends = [corners[axis], corners[axis + 2]].map((side) => (side - start[axis]) / (along[axis] || 1e-9));
      first = Math.max(first, Math.min(...ends));
      last = Math.min(last, Math.max(...ends));
    }
    return first < last ? first : 0;
  }

  // A cleared canvas that shows the part [left, bottom, right, top] in m, moved right by `middle`.
  function view(canvas, box, middle) {
    const width = canvas.clientWidth, height = canvas.clientHeight, dense = devicePixelRatio || 1;
    canvas.width = width * dense;
    canvas.height = height * dense;
    const pen = canvas.getContext("2d"), style = getComputedStyle(canvas);
    const colour = (name) => style.getPropertyValue(name).trim() || style.color;
    const scale = Math.min(width / (box[2] - box[0]), height / (box[3] - box[1]));
    const shift = middle + (box[0] + box[2]) / 2;
    const X = (x) => width / 2 + (x - shift) * scale, Y = (y) => height - (y - box[1]) * scale;
    pen.scale(dense, dense);
    pen.lineCap = pen.lineJoin = "round";
    pen.font = "11px sans-serif";
    const disc = (x, y, radius, name) => {
      pen.fillStyle = colour(name);
      pen.beginPath();
      pen.arc(x, y, Math.max(radius, 2), 0, 7);
      pen.fill();
    };
    return { pen, colour, disc, X, Y, scale, shift, width, height };
  }

  // The floor at 0 with a tick per metre.
  function floor({ pen, colour, X, Y, scale, shift, width }) {
    pen.strokeStyle = pen.fillStyle = colour("--soft");
    pen.lineWidth = 1;
    pen.beginPath();
    pen.moveTo(0, Y(0));
    pen.lineTo(width, Y(0));
    const half = width / 2 / scale;
    for (let metre = Math.ceil(shift - half); metre <= shift + half; metre++) {
      pen.moveTo(X(metre), Y(0));
      pen.lineTo(X(metre), Y(0) + 5);
      pen.fillText(`${page.fixed(metre, 0)} m`, X(metre) + 3, Y(0) + 11);
    }
    pen.stroke();
  }

  function shapes({ pen, colour, disc, X, Y, scale }, list) {
    const wall = list.find(([role]) => role === "wall");
    for (const [role, radius, x1, y1, x2, y2] of list) {
      if (role.endsWith("beam")) {
        const along = [x2 - x1, y2 - y1], hit = wall && enter([x1, y1], along, wall);
        const length = hit || Math.min(FREE_BEAM, along[1] < 0 ? -y1 / along[1] : 1);
        pen.strokeStyle = colour(hit ? "--warn-ink" : "--rule");
        pen.lineWidth = 1;
        pen.beginPath();
        pen.moveTo(X(x1), Y(y1));
        pen.lineTo(X(x1 + length * along[0]), Y(y1 + length * along[1]));
        pen.stroke();
      } else if (role === "wall") {
        pen.fillStyle = colour("--cold");
        pen.fillRect(X(x1), Y(y2), (x2 - x1) * scale, (y2 - Math.max(y1, 0)) * scale);
      } else if (role === "goal" || role === "object") {
        disc(X(x1), Y(y1), radius * scale, role === "goal" ? "--gain" : "--cold");
      } else {
        pen.strokeStyle = colour(LIMBS[role]);
        pen.lineWidth = Math.max(2 * radius * scale, 1);
        pen.beginPath();
        pen.moveTo(X(x1), Y(y1));
        pen.lineTo(X(x2) + 0.01, Y(y2));
        pen.stroke();
      }
    }
  }

  return { LIMBS, calm, dot, directions, speeds, clock, view, floor, shapes };
})();
