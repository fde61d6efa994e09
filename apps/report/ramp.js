// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// Colours for numbers, and what they mean.

import { color } from "./plot.js";

const stops = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];  // viridis, which print and all eyes keep in order

/** Of a part from 0 to 1. */
export function rampColor(part) {
  const at = Math.max(0, Math.min(1, part)) * (stops.length - 1), i = Math.min(stops.length - 2, Math.floor(at));
  return `rgb(${stops[i].map((low, k) => Math.round(low + (at - i) * (stops[i + 1][k] - low))).join(",")})`;
}

/** The ramp along the width, with words for its ends. */
export function ramp(context, low, high, width, top) {
  const left = 4, right = width - 4;
  for (let x = left; x < right; ++x) {
    context.fillStyle = rampColor((x - left) / (right - left));
    context.fillRect(x, top, 1.5, 8);
  }
  context.fillStyle = color("muted");
  context.textBaseline = "top";
  context.textAlign = "left";
  context.fillText(low, left, top + 11);
  context.textAlign = "right";
  context.fillText(high, right, top + 11);
}
