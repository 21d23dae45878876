/** The page's icons: SVG paths in a 16 x 16 view box, drawn in the text colour. */
import type { ReactElement } from 'react';

const paths = {
  to_start: <path d="M4 3.5v9M12.500 3.500v9L6 8z" />,
  back: <path d="M11 3.500v9L4.500 8z" />,
  play: <path d="M4.500 2.800v10.400L13 8z" />,
  pause: <path d="M4 3h3v10H4zM9 3h3v10H9z" />,
  on: <path d="M5 3.500v9L11.500 8z" />,
  to_end: <path d="M12 3.500v9M3.500 3.500v9L10 8z" />,
  loop: <path d="M4 5.500h7.500a2.300 2.300 0 012.300 2.300v.4M12 10.500H4.500a2.300 2.300 0 01-2.300-2.300v-.4M6 3.300L3.800 5.500 6 7.700M10 8.300l2.200 2.200L10 12.700" />,
  down: <path d="M4.500 6.500L8 10l3.500-3.500" />,
  up: <path d="M4.500 9.500L8 6l3.500 3.500" />,
  undo: <path d="M6 3.500L3 6.500l3 3M3.500 6.500h6a3.200 3.200 0 010 6.400H6.500" />,
  redo: <path d="M10 3.500l3 3-3 3M12.500 6.500h-6a3.200 3.200 0 000 6.400h3" />,
  save: <path d="M3 3h8l2 2v8H3zM5.500 3v3.500h4.500V3M5 13V9.500h6V13" />,
  search: <path d="M7 2.800a4.200 4.200 0 110 8.400 4.200 4.200 0 010-8.400zM10.200 10.200l3.300 3.300" />,
  import: <path d="M8 2.500v7.500M5 7.200l3 3 3-3M2.800 11.500v2h10.400v-2" />,
  export: <path d="M8 10V2.500M5 5.300l3-3 3 3M2.800 9.500v4h10.400v-4" />,
  close: <path d="M4 4l8 8M12 4l-8 8" />,
  character: <path d="M9 6L8 9.500M8 9.500l2.500 1.500.5 3M8 9.500L6 12l-2.500 1.500M9 6L6 7M9 6l2.500 2H13M9.800 3.200a.9.9 0 11-1.800 0 .9.9 0 011.800 0z" />,
  box: <path d="M8 2l5.500 3v6L8 14l-5.500-3V5zM2.500 5L8 8l5.500-3M8 8v6" />,
  wave: <path d="M1.500 9c1.500-6 3.500-6 5 0s3.500 5 5 0c.8-2.700 1.800-3.400 3-3" />,
  help: <path d="M5.800 6a2.200 2.200 0 114 1.300C9 8.200 8 8.400 8 9.800M8 12.300v.2" />,
  tiles: <path d="M2.500 2.500h4.500v4.500H2.500zM9 2.500h4.500v4.500H9zM2.500 9h4.500v4.500H2.500zM9 9h4.500v4.500H9z" />,
  rows: <path d="M2.500 4h11M2.500 8h11M2.500 12h11" />,
  pointer: <path d="M4 2.500l8 5-3.600.8 2 4-1.700.8-2-4L4 12z" />,
  pose: <path d="M8 2.200a1.400 1.400 0 110 2.800 1.400 1.400 0 010-2.800zM8 6v4M2.500 5.500L8 6.500l5.500-2.500M8 10l-3 4M8 10l3.500 3.500" />,
  mirror: <path d="M8 2v12M6 4.500L2 12h4zM10 4.500l4 7.500h-4z" />,
  key: <path d="M8 3l5 5-5 5-5-5z" />,
  ripple: <path d="M2.500 4v8M5 8h8.500M10.500 5l3 3-3 3" />,
  add: <path d="M8 3v10M3 8h10" />,
  pin: <path d="M6 2.500h4M6.700 2.500v4L4.500 9.200h7L9.300 6.500v-4M8 9.200v4.500" />,
  move: <path d="M8 2v12M2 8h12M6.300 3.700L8 2l1.700 1.700M6.300 12.300L8 14l1.700-1.700M3.700 6.300L2 8l1.700 1.700M12.300 6.300L14 8l-1.700 1.700" />,
  smooth: <path d="M2 12.500c4 0 2.500-9 6-9s2 6 6 6M8 3.500" />,
  linear: <path d="M2 12.500L8 3.500l6 6" />,
  step: <path d="M2 12.500h6v-9h6" />,
  flat: <path d="M2.500 8h11M8 5.500a2.500 2.500 0 110 5 2.500 2.500 0 010-5z" />,
  eye: <path d="M1.500 8c2-3 4-4.500 6.500-4.500S12.500 5 14.500 8c-2 3-4 4.500-6.500 4.500S3.500 11 1.500 8zM8 6a2 2 0 110 4 2 2 0 010-4z" />,
  fit: <path d="M2.500 5.500v-3h3M10.500 2.500h3v3M13.500 10.500v3h-3M5.500 13.500h-3v-3M5 8h6" />,
  perspective: <path d="M2.500 5.500l11-3v11l-11-3z" />,
  orthographic: <path d="M2.500 3.500h11v9h-11z" />,
  capsule: <path d="M5 5.500a3 3 0 016 0v5a3 3 0 01-6 0zM5 6.500h6M5 9.500h6" />,
  ghosts: <path d="M3 13V6.500a3 3 0 016 0V13zM10.500 4.200a3 3 0 012.500 3V13" />,
  contact: <path d="M2 13.500h12M8 13V3M5 6l3-3 3 3" />,
  distance: <path d="M2.500 3.500v9M13.500 3.500v9M5 8h6M6.500 6L4.500 8l2 2M9.500 6l2 2-2 2" />,
  mass: <path d="M8 2.500a5.500 5.500 0 110 11 5.500 5.500 0 010-11zM8 2.500v11M2.500 8h11" />,
  follow: <path d="M8 5a3 3 0 110 6 3 3 0 010-6zM8 1.500V5M8 11v3.500M1.500 8H5M11 8h3.500" />,
  sun: <path d="M8 5.200a2.800 2.800 0 110 5.600 2.800 2.800 0 010-5.600zM8 1.500V3M8 13v1.500M1.500 8H3M13 8h1.500M3.400 3.400l1 1M11.600 11.600l1 1M3.400 12.600l1-1M11.600 4.400l1-1" />,
} as const;

export type IconName = keyof typeof paths;

const filled = new Set<IconName>(['play', 'pause', 'back', 'on', 'to_start', 'to_end']);

export function Icon({ name }: { name: IconName }): ReactElement {
  return (
    <svg className={filled.has(name) ? 'icon filled' : 'icon'} viewBox="0 0 16 16" aria-hidden="true">
      {paths[name]}
    </svg>
  );
}
