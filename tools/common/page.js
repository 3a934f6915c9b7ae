// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The totalforce authors
//
// Pages of results: numbers under the pointer, by touch and by keyboard; filters. The numbers are
// those of the CSV in the page; text is never set as HTML.
'use strict';
(() => {
  const page = document.querySelector('main'), tip = document.getElementById('tip');
  const SVG = 'http://www.w3.org/2000/svg';

  const cells = line => (line + ',').match(/("(?:""|[^"])*"|[^,]*),/g)
    .map(field => field.slice(0, -1).replace(/^"|"$/g, '').replace(/""/g, '"'));
  const [names, ...rows] =
    document.getElementById('rows').textContent.trim().split('\n').map(cells);
  const column = new Map(names.map((name, k) => [name, k]));
  const value = (row, name) => rows[row][column.get(name)];
  const make = (kind, text) => {
    const element = document.createElement(kind);
    if (text !== undefined) element.textContent = text;
    return element;
  };

  // ---- the numbers of a row
  const facts = (row, other) => {
    const list = make('dl');
    for (const name of page.dataset.tip.split(' ')) {
      if (!column.has(name) || !value(row, name)) continue;
      if (other !== undefined && name !== 'error' && value(row, name) === value(other, name)) continue;
      list.append(make('dt', name), make('dd', value(row, name)));
    }
    return list;
  };
  let chosen = null, place = 0; // and its height in the window
  const hide = () => {
    if (chosen) chosen.classList.remove('on');
    chosen = null;
    tip.hidden = true;
  };
  const show = element => {
    if (element === chosen) return;
    hide();
    chosen = element;
    element.classList.add('on');
    const panel = element.closest('figure').querySelector('b').textContent;
    tip.replaceChildren(make('b', element.dataset.l ? element.dataset.l + ', ' + panel : panel),
      facts(element.dataset.r));
    if (element.dataset.also)
      tip.append(make('b', page.dataset.also), facts(element.dataset.also, element.dataset.r));
    tip.hidden = false;
    const at = element.getBoundingClientRect();
    place = at.top;
    const size = tip.getBoundingClientRect();
    const right = at.right + 10 + size.width < innerWidth;
    const left = right ? at.right + 10 : Math.max(4, at.left - 10 - size.width);
    const top = Math.min(Math.max(4, at.top - size.height / 2), innerHeight - size.height - 4);
    tip.style.left = left + 'px';
    tip.style.top = Math.max(4, top) + 'px';
  };

  // ---- pointer and keyboard
  const REACH = 24;
  const centre = element => {
    const box = (element.querySelector('path:last-child') || element).getBoundingClientRect();
    return [box.left + box.width / 2, box.top + box.height / 2];
  };
  const shown = svg => [...svg.querySelectorAll('[data-r]:not([hidden])')];
  const nearest = (svg, x, y) => {
    let best = null, least = REACH;
    for (const element of shown(svg)) {
      const [u, v] = centre(element), distance = Math.hypot(u - x, v - y);
      if (distance < least) [best, least] = [element, distance];
    }
    return best;
  };
  const step = (svg, key) => {
    if (!chosen || !svg.contains(chosen)) return shown(svg)[0];
    const [x, y] = centre(chosen);
    const across = key === 'ArrowLeft' || key === 'ArrowRight';
    const sign = key === 'ArrowLeft' || key === 'ArrowUp' ? -1 : 1;
    let best = chosen, least = Infinity;
    for (const element of shown(svg)) {
      const [u, v] = centre(element), way = sign * (across ? u - x : v - y);
      const cost = way + 2 * Math.abs(across ? v - y : u - x);
      if (way > 0.5 && cost < least) [best, least] = [element, cost];
    }
    return best;
  };
  const point = event => {
    const svg = event.target.closest('figure svg');
    const element = svg && nearest(svg, event.clientX, event.clientY);
    if (element) show(element);
    else hide();
  };
  document.addEventListener('pointermove', point);
  document.addEventListener('pointerdown', point);
  document.addEventListener('scroll', () => {
    if (chosen && Math.abs(chosen.getBoundingClientRect().top - place) > 1) hide();
  }, {passive: true});
  document.addEventListener('focusout', hide);
  document.addEventListener('keydown', event => {
    const svg = event.target.closest && event.target.closest('figure svg');
    if (event.key === 'Escape') hide();
    if (!svg || !/^Arrow/.test(event.key)) return;
    const element = step(svg, event.key);
    if (element) show(element);
    event.preventDefault();
  });

  // ---- the Pareto front of the marks that are shown: by the rule of chart_mark_front
  const number = (row, name) => Number(value(row, name));
  const isBeaten = (a, b) =>
    b.time < a.time && Math.max(b.error, b.floor) <= 2 * Math.max(a.error, a.floor);
  const position = element => {
    const {e, f} = element.transform.baseVal.getItem(0).matrix;
    return {x: e, y: f};
  };
  const draw = (group, kind, attributes, text) => {
    const element = document.createElementNS(SVG, kind);
    for (const name in attributes) element.setAttribute(name, attributes[name]);
    if (text) element.textContent = text;
    group.append(element);
  };
  const meets = (taken, left, right, y, room) =>
    taken.some(t => left < t.right && right > t.left && Math.abs(y - t.y) < room);
  // The nearest height above the point (below it where there is no room) without labels, and
  // without marks if there is one: as find_height of chart_page_scatter.c
  const height = (p, left, right, marks, labels, box) => {
    const step = p.y - 13 > box.top ? -6.5 : 6.5, from = p.y + (step < 0 ? -10 : 20);
    let found = from, least = 3;
    for (let y = from; y > box.top && y < box.bottom && least > 0; y += step) {
      const cost = 2 * meets(labels, left, right, y, 13) + meets(marks, left, right, y, 11);
      if (cost < least) [found, least] = [y, cost];
    }
    return found;
  };
  const label = (group, points, marks, box) => {
    const labels = [];
    const around = marks.map(p => ({left: p.x - 5, right: p.x + 5, y: p.y + 4}));
    for (const p of [...points].reverse()) {
      const width = 5.9 * p.text.length, end = p.x + width > box.right;
      const left = end ? p.x - width : p.x - 3;
      const y = height(p, left, left + width, around, labels, box);
      if (y < p.y - 11 || y > p.y + 21)
        draw(group, 'path', {class: 'lead',
          d: `M${p.x} ${p.y + (y < p.y ? -5 : 5)}V${y + (y < p.y ? 3 : -9)}`});
      draw(group, 'text', {class: end ? 'label-end' : 'label', x: end ? p.x + 3 : left, y}, p.text);
      labels.push({left, right: left + width, y});
    }
  };
  const refront = svg => {
    const group = svg.querySelector('.front');
    if (!group) return;
    const all = [...svg.querySelectorAll('.m:not([hidden])')].map(element => ({
      time: number(element.dataset.r, 'time_us'), error: number(element.dataset.r, 'error'),
      floor: number(element.dataset.r, 'floor'), text: element.dataset.t, ...position(element)}));
    const front = all.filter(a => a.error < 0.1 && !all.some(b => isBeaten(a, b)))
      .sort((a, b) => a.time - b.time);
    const box = {top: Number(group.dataset.top), bottom: Number(group.dataset.bottom),
      right: Number(group.dataset.right)};
    const labels = svg.querySelector('.labels');
    group.replaceChildren();
    labels.replaceChildren();
    if (front.length === 0) return;
    const steps = front.map((p, k) => k ? `H${p.x}V${p.y}` : `M${p.x} ${box.top}V${p.y}`);
    draw(group, 'path', {d: steps.join('') + 'H' + box.right});
    label(labels, front, all, box);
  };

  // ---- filters
  const on = new Map(), items = [...document.querySelectorAll('[data-r], [data-f]')];
  const all = new Map();
  let count = null;
  const each = (selector, act) => document.querySelectorAll(selector).forEach(act);
  const apply = redraw => {
    hide();
    const passes = rows.map(row => [...on].every(([name, set]) => set.has(row[column.get(name)])));
    for (const item of items) item.toggleAttribute('hidden', !passes[item.dataset.r || item.dataset.f]);
    each('.panel', panel => {
      panel.toggleAttribute('hidden', !panel.querySelector('svg [data-r]:not([hidden])'));
      if (redraw && !panel.hidden) panel.querySelectorAll('svg').forEach(refront);
    });
    each('.group', group =>
      group.toggleAttribute('hidden', !group.querySelector('.panel:not([hidden])')));
    each('[data-p]', row =>
      row.toggleAttribute('hidden', document.getElementById(row.dataset.p).hidden));
    if (count) count.textContent = `Filters: ${passes.filter(Boolean).length} of ${rows.length} rows`;
  };
  const choice = (name, text, set) => {
    const line = make('label'), box = make('input');
    const mark = [...document.querySelectorAll('.legend [data-v]')]
      .find(entry => entry.dataset.k === name && entry.dataset.v === text);
    box.type = 'checkbox';
    box.checked = set.has(text);
    box.dataset.column = name;
    box.value = text;
    box.addEventListener('change', () => {
      if (box.checked) set.add(text);
      else set.delete(text);
      apply(true);
    });
    line.append(box);
    if (mark) line.append(mark.querySelector('svg').cloneNode(true));
    line.append(text || 'none');
    return line;
  };
  const toggle = (field, name, set) => {
    const button = make('button', 'all');
    button.type = 'button';
    button.addEventListener('click', () => {
      const fill = set.size < all.get(name).length;
      set.clear();
      if (fill) all.get(name).forEach(text => set.add(text));
      field.querySelectorAll('input').forEach(box => { box.checked = fill; });
      apply(true);
    });
    return button;
  };
  const build = () => {
    const filters = make('details');
    filters.className = 'filters';
    filters.open = innerWidth > 600;
    count = make('summary');
    filters.append(count);
    for (const item of page.dataset.filters.split(' ')) {
      const [name, start] = item.split('=');
      if (!column.has(name)) continue;
      const texts = [...new Set(rows.map(row => row[column.get(name)]))];
      if (texts.length < 2) continue;
      const set = new Set(start ? texts.filter(text => start.split('|').includes(text)) : texts);
      all.set(name, texts);
      on.set(name, set);
      const field = make('fieldset');
      field.append(make('legend', name), ...texts.map(text => choice(name, text, set)));
      if (texts.length > 2) field.append(toggle(field, name, set));
      filters.append(field);
    }
    if (on.size) document.getElementById('filters').append(filters);
  };
  build();
  apply(false);
})();
