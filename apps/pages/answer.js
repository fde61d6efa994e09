// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
const answerWords = {airbag: 'airbag', state: 'state', group: 'group', class: 'class', confidence: 'share of the votes',
  points_in_critical_zone: 'points in the critical zone', points_in_outer_zone: 'points in the outer zone',
  dashboard_distance_m: 'nearest point to the dashboard [m]', dashboard_distance_sigma_m: 'its sigma [m]',
  rays_through_zones: 'rays that found the zones free', moving: 'share of the rays on the seat that moved'};

/** Fills the elements `airbag` and `reasons` with an answer of docs/formats/occupancy.md. */
const showAnswer = answer => {
  const badge = document.getElementById('airbag');
  badge.textContent = answer.airbag;
  badge.className = 'badge ' + answer.airbag;
  const rows = Object.entries(answerWords).filter(([key]) => key in answer).map(([key, word]) => {
    const row = document.createElement('tr'), value = answer[key];
    for (const text of [word, typeof value === 'number' ? +value.toFixed(3) : value ?? 'unsure']) {
      row.appendChild(document.createElement('td')).textContent = text;
    }
    return row;
  });
  document.getElementById('reasons').replaceChildren(...rows);
};
