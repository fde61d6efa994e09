// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// The bent surface of a board, its height stretched until it is seen.

import { el } from "./dom.js";
import { color, figure, niceBelow, plot, tickText } from "./plot.js";

const lines = 12;

/** z at (x, y) in [-1, 1]²: docs/formats/calibration.md. */
function height(shape, x, y) {
  return shape.bend_x_m * (1 - x * x) + shape.bend_y_m * (1 - y * y) + shape.twist_m * x * y;
}

/** Null for a board that was taken as flat. */
export function boardFigure(target) {
  const shape = target.shape;
  if (!shape || !(shape.bend_x_m || shape.bend_y_m || shape.twist_m)) return null;
  const range = (i) => target.points.reduce(([low, high], p) => [Math.min(low, p[i]), Math.max(high, p[i])], [Infinity, -Infinity]);
  const half = [1, 2].map((i) => (range(i)[1] - range(i)[0]) / 2);
  const steps = Array.from({ length: lines + 1 }, (_, i) => (2 * i) / lines - 1);
  const heights = steps.flatMap((x) => steps.map((y) => height(shape, x, y)));
  const span = Math.max(...heights) - Math.min(...heights), stretch = niceBelow((0.3 * Math.max(...half)) / span);
  const draw = (context, width, tall) => {
    const scale = (0.8 * Math.min(width / 2, tall)) / (half[0] + half[1]);
    // Seen from above its front edge; the side that faces the camera is up.
    const place = (x, y, z) => [width / 2 + scale * (x * half[0] - 0.5 * y * half[1]) * 1.2, tall / 2 + scale * (0.65 * y * half[1] + 0.35 * x * half[0] + z)];
    const curve = (points) => {
      context.beginPath();
      points.forEach((p, i) => (i ? context.lineTo(...p) : context.moveTo(...p)));
      context.stroke();
    };
    for (const [name, factor] of [["line", 0], ["accent", stretch]]) {
      context.strokeStyle = color(name);
      for (const a of steps) {
        curve(steps.map((b) => place(a, b, factor * height(shape, a, b))));
        curve(steps.map((b) => place(b, a, factor * height(shape, b, a))));
      }
    }
  };
  const text = `${tickText(Number((1e3 * span).toPrecision(2)))} mm from its lowest to its highest point`;
  return figure(`Shape of ${target.name}`, plot({ aspect: 2.2, label: `Shape of ${target.name}: ${text}`, draw }),
    `${text}, drawn × ${tickText(stretch)} towards the camera; grey is the plane through its edges.`);
}
