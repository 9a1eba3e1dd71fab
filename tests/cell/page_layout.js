// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
// Faults in the layout of the page as it is now: text that is cut, covered or too small, buttons that are too low. Empty: none.
(() => {
  const MIN_FONT_PX = 12, MIN_BUTTON_PX = 40;
  const faults = [], root = document.documentElement;
  const name = e => e.id || e.className || e.tagName;
  const overlap = (p, q) => [Math.min(p.right, q.right) - Math.max(p.left, q.left), Math.min(p.bottom, q.bottom) - Math.max(p.top, q.top)];
  const isIn = (p, q) => p.left >= q.left - 1 && p.right <= q.right + 1 && p.top >= q.top - 1 && p.bottom <= q.bottom + 1;
  if (root.scrollWidth > innerWidth) faults.push(`the page is ${root.scrollWidth} px wide of ${innerWidth}`);

  const texts = [], walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let node; (node = walker.nextNode());) {
    const parent = node.parentElement, text = node.data.trim().slice(0, 40);
    if (!text || ["SCRIPT", "OPTION"].includes(parent.tagName) || !parent.checkVisibility()) continue;
    const drawing = parent.closest("svg"), range = document.createRange();
    range.selectNodeContents(node);
    const boxes = drawing ? [parent.getBoundingClientRect()] : [...range.getClientRects()].filter(box => box.width > 0);
    const font = parseFloat(getComputedStyle(parent).fontSize) * (drawing ? drawing.getScreenCTM().a : 1);
    if (font < MIN_FONT_PX - 0.01) faults.push(`${font} px: ${text}`);
    for (const box of boxes) {
      if (box.left < -1 || box.right > innerWidth + 1) faults.push(`beside the page: ${text}`);
      for (let e = parent; e !== root; e = e.parentElement)
        if (getComputedStyle(e).overflowX !== "visible" && !isIn(box, e.getBoundingClientRect())) faults.push(`cut by ${name(e)}: ${text}`);
      texts.push({ node, text, box });
    }
  }
  texts.forEach((a, i) => texts.slice(i + 1).forEach(b => {
    const [width, height] = overlap(a.box, b.box);
    if (a.node !== b.node && width > 1 && height > 3) faults.push(`${a.text} lies over ${b.text}`);
  }));
  for (const e of document.body.querySelectorAll("*"))
    if (e.innerText && e.clientWidth > 0 && e.scrollWidth > e.clientWidth + 1) faults.push(`${name(e)} is ${e.scrollWidth} px wide of ${e.clientWidth}: ${e.innerText.slice(0, 40)}`);
  const boxes = [...document.querySelectorAll("header, .word, .alarm, section")].map(e => [e, e.getBoundingClientRect()]);
  boxes.forEach(([a, p], i) => boxes.slice(i + 1).forEach(([b, q]) => {
    if (!a.contains(b) && !b.contains(a) && Math.min(...overlap(p, q)) > 1) faults.push(`${name(a)} lies over ${name(b)}`);
  }));
  for (const e of document.querySelectorAll("button, select, input"))
    if (e.checkVisibility() && e.getBoundingClientRect().height < MIN_BUTTON_PX) faults.push(`${e.innerText || name(e)} is ${e.getBoundingClientRect().height} px high`);
  return faults.join("; ");
})()
