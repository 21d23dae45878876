// Sizes of the window, and the search for controls that are covered or cut, for text that is cut, and for panels that scroll sideways.

/** Widths and heights of the window, CSS px. A window of 1280 x 720 px at a zoom of 150 % has 853 x 480 CSS px, one of 1440 x 900 has 960 x 600. */
export const windows = [[853, 480], [960, 600], [1024, 640], [1280, 720], [1440, 900], [3840, 2160]];

/** Gives the window a size, and waits until the panels have taken it. */
export async function resize(page, [width, height]) {
  await page.setViewportSize({ width, height });
  const layout = () => page.evaluate(([wide, high]) => {
    const groups = [...document.querySelectorAll('.dv-groupview')].map((e) => e.getBoundingClientRect());
    const ends = (value, wanted) => Math.abs(value - wanted) < 2;
    const filled = ends(Math.max(...groups.map((b) => b.right)), wide) && ends(Math.max(...groups.map((b) => b.bottom)), high);
    return innerWidth === wide && filled ? JSON.stringify([...groups, document.querySelector('.viewport > canvas').getBoundingClientRect()]) : null;
  }, [width, height]);
  let before = null;
  for (let i = 0; i < 100; i++) {
    await page.waitForTimeout(100);
    const now = await layout();
    if (now !== null && now === before) return;
    before = now;
  }
  throw new Error(`the panels do not settle in a window of ${width} x ${height} px`);
}

/**
 * Names of controls that are covered or cut, of text that is cut without a title, and of neighbours in the top bar that overlap. Controls
 * outside of an open dialog or menu are covered on purpose; those that a panel has scrolled away are reached by scrolling.
 */
export const crowded = (page) =>
  page.evaluate(() => {
    const bad = [];
    const named = (e) => e.getAttribute('aria-label') ?? (e.textContent.trim().slice(0, 30) || e.tagName);
    const modal = [...document.querySelectorAll('[role=menu], [role=dialog]')].filter((e) => e.checkVisibility()).at(-1);
    const root = modal ?? document;
    const canvas = '.cube, .react-flow, .lane, .pose-handles, .path-overlay';
    for (const e of root.querySelectorAll('button, input, select, textarea, [role=tab], [role=slider], [role=menuitem], [role=option], [role=radio], .clock, .toast')) {
      const b = e.getBoundingClientRect();
      if (b.width === 0 || b.height === 0 || !e.checkVisibility({ visibilityProperty: true, opacityProperty: true }) || e.closest(canvas)) continue;
      let away = false; // scrolled out of a panel, at least in part
      let cut = b.left < -1 || b.top < -1 || b.right > innerWidth + 1 || b.bottom > innerHeight + 1;
      for (let p = e.parentElement; p && p !== document.body; p = p.parentElement) {
        const { overflowX, overflowY, position } = getComputedStyle(p);
        const q = p.getBoundingClientRect();
        const out_x = b.left < q.left - 1 || b.right > q.right + 1;
        const out_y = b.top < q.top - 1 || b.bottom > q.bottom + 1;
        if (/auto|scroll/.test(overflowY) && out_y) away = true;
        else if (/auto|scroll/.test(overflowX) && out_x) away = true;
        else if ((overflowX !== 'visible' && out_x) || (overflowY !== 'visible' && out_y)) cut = true;
        if (position === 'fixed') break;
      }
      if (away) continue;
      const [dx, dy] = [Math.max(0, b.width / 2 - 3), Math.max(0, b.height / 2 - 3)]; // the middle, and points inside of the corners
      const over = [[0, 0], [-dx, -dy], [dx, -dy], [-dx, dy], [dx, dy]]
        .map(([x, y]) => document.elementFromPoint((b.left + b.right) / 2 + x, (b.top + b.bottom) / 2 + y))
        .find((at) => at && !e.contains(at) && !at.contains(e) && !e.labels?.[0]?.contains(at) && !at.closest('.track-switches, .dv-sash')); // shown while the pointer is on the name of the track; the handle at the edge of a panel
      if (cut) bad.push(`${named(e)} is cut`);
      else if (over) bad.push(`${named(e)} is covered by ${over.className?.baseVal ?? (over.className || over.tagName)}`);
    }
    for (const e of root.querySelectorAll('*')) {
      if (!e.checkVisibility() || e.closest(`${canvas}, svg, .ruler`)) continue;
      const { overflowX, textOverflow } = getComputedStyle(e);
      const wide = e.scrollWidth > e.clientWidth + 1;
      if (!wide || e.clientWidth === 0) continue;
      const text = [...e.childNodes].some((n) => n.nodeType === Node.TEXT_NODE && n.textContent.trim());
      if ((text || textOverflow === 'ellipsis') && overflowX !== 'visible' && !/auto|scroll/.test(overflowX) && !e.closest('[title]') && e.tagName !== 'SELECT' && e.tagName !== 'INPUT') bad.push(`the text '${named(e)}' is cut and has no title`);
      else if (/auto|scroll/.test(overflowX) && !e.closest('.rule-states, .dv-tabs-container, .view-options, .pose-bar')) bad.push(`${e.className || e.tagName} scrolls sideways by ${e.scrollWidth - e.clientWidth} px`);
    }
    // cards let the pointer through, so elementFromPoint does not find them
    const boxes = (selector) => [...root.querySelectorAll(selector)].filter((e) => e.checkVisibility()).map((e) => ({ e, b: e.getBoundingClientRect() })).filter(({ b }) => b.width > 0);
    for (const card of boxes('.viewport .card'))
      for (const { e, b } of boxes('.viewport button, .viewport select'))
        if (!card.e.contains(e) && !e.closest(canvas) && b.left < card.b.right && b.right > card.b.left && b.top < card.b.bottom && b.bottom > card.b.top) bad.push(`${named(e)} is behind the card '${named(card.e)}'`);
    if (document.documentElement.scrollWidth > innerWidth + 1) bad.push('the page is wider than the window');
    const bar = [...document.querySelectorAll('.topbar button, .topbar select, .topbar .clock, .topbar .brand')].filter((e) => !e.closest('[role=menu]')).map((e) => ({ e, b: e.getBoundingClientRect() })).filter(({ b }) => b.width > 0);
    bar.forEach(({ e, b }, i) => {
      const next = bar[i + 1];
      if (next && b.right > next.b.left + 0.5 && !e.contains(next.e)) bad.push(`${named(e)} overlaps ${named(next.e)}`);
    });
    return bad;
  });
