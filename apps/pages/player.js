// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

/** Shows one of so many frames, by the slider `at` and the button `play`; what goes so many frames on. */
const player = (frames, period_ms, show) => {
  const at = document.getElementById('at'), play = document.getElementById('play');
  const step = by => { at.value = (+at.value + by + frames) % frames; show(+at.value); };
  let timer = 0;
  at.max = frames - 1;
  at.value = 0;
  at.oninput = () => show(+at.value);
  play.onclick = () => {
    play.textContent = timer ? 'Play' : 'Stop';
    if (timer) clearInterval(timer);
    timer = timer ? 0 : setInterval(() => step(1), period_ms);
  };
  if (frames) show(0);
  return step;
};
