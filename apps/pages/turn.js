// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

/** Lets a canvas be turned by pointer and arrow keys: changes view.yaw and view.pitch, and draws. */
const turnByHand = (canvas, view, draw) => {
  const turn = (yaw, pitch) => { view.yaw += yaw; view.pitch += pitch; draw(); };
  canvas.onpointerdown = event => canvas.setPointerCapture(event.pointerId);
  canvas.onpointermove = event => { if (event.buttons) turn(event.movementX / 200, event.movementY / 200); };
  canvas.onkeydown = event => {
    const by = {ArrowLeft: [-.1, 0], ArrowRight: [.1, 0], ArrowUp: [0, -.1], ArrowDown: [0, .1]}[event.key];
    if (by) { event.preventDefault(); turn(...by); }
  };
  addEventListener('resize', draw);
};

/** What turns a point [x right, y down, z away] by a view. */
const turnerOf = ({yaw, pitch}) => {
  const [cy, sy, cp, sp] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
  return (x, y, z) => {
    const away = cy * z - sy * x;
    return [cy * x + sy * z, cp * y + sp * away, cp * away - sp * y];
  };
};

/** Gives a canvas the pixels that it has on the screen; its width and height. */
const fitCanvas = canvas => [canvas.width = canvas.clientWidth * devicePixelRatio,
                             canvas.height = canvas.clientHeight * devicePixelRatio];
