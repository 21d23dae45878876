import { useEffect, useRef, type ReactElement } from 'react';
import type { Viewport } from '../view/viewport';

type V = readonly [number, number, number];

const faces: { name: string; title: string; normal: V; up: V; azimuth: number; elevation: number }[] = [
  { name: 'Front', title: 'View from the front (+X)', normal: [1, 0, 0], up: [0, 0, 1], azimuth: 0, elevation: 0.02 },
  { name: 'Back', title: 'View from behind (−X)', normal: [-1, 0, 0], up: [0, 0, 1], azimuth: Math.PI, elevation: 0.02 },
  { name: 'Left', title: 'View from the left (+Y)', normal: [0, 1, 0], up: [0, 0, 1], azimuth: Math.PI / 2, elevation: 0.02 },
  { name: 'Right', title: 'View from the right (−Y)', normal: [0, -1, 0], up: [0, 0, 1], azimuth: -Math.PI / 2, elevation: 0.02 },
  { name: 'Top', title: 'View from above (+Z)', normal: [0, 0, 1], up: [0, 1, 0], azimuth: -Math.PI / 2, elevation: 1.55 },
  { name: 'Bottom', title: 'View from below (−Z)', normal: [0, 0, -1], up: [0, 1, 0], azimuth: -Math.PI / 2, elevation: -1.45 },
];

/**
 * CSS transform of a face. Its columns are the face's right, down and outward directions in the world, with y negated because CSS has y
 * down.
 */
function face_transform({ normal: n, up: u }: { normal: V; up: V }): string {
  const right: V = [u[1] * n[2] - u[2] * n[1], u[2] * n[0] - u[0] * n[2], u[0] * n[1] - u[1] * n[0]];
  const columns = [right, [-u[0], -u[1], -u[2]] as const, n].flatMap((v) => [v[0], -v[1], v[2], 0]);
  return `matrix3d(${[...columns, 0, 0, 0, 1].join(',')}) translateZ(calc(var(--cube) / 2))`;
}

const axes = [
  { name: 'X', color: 'var(--axis-x)', at: [1, 0, 0] },
  { name: 'Y', color: 'var(--axis-y)', at: [0, 1, 0] },
  { name: 'Z', color: 'var(--axis-z)', at: [0, 0, 1] },
] as const;

/** The view cube: shows the camera's direction with the world axes; a click on a face looks from that side. */
export function ViewCube({ viewport }: { viewport: Viewport }): ReactElement {
  const cube = useRef<HTMLDivElement>(null);
  const axis_elements = useRef<(SVGGElement | null)[]>([]);
  useEffect(() => {
    let before = '';
    const draw = (): void => {
      const e = viewport.rig.camera.matrixWorldInverse.elements;
      // CSS has y down: negate the second row of the view matrix
      const m = [e[0], -e[1], e[2], 0, e[4], -e[5], e[6], 0, e[8], -e[9], e[10], 0, 0, 0, 0, 1].map((v) => (v as number).toFixed(5));
      const text = m.join(',');
      if (text === before) return;
      before = text;
      if (cube.current) cube.current.style.transform = `matrix3d(${text}) scaleY(-1)`;
      axes.forEach((axis, i) => {
        const element = axis_elements.current[i];
        if (!element) return;
        const [x, y, z] = axis.at;
        const sx = 36 * (e[0] * x + e[4] * y + e[8] * z);
        const sy = -36 * (e[1] * x + e[5] * y + e[9] * z);
        const depth = e[2] * x + e[6] * y + e[10] * z;
        element.style.opacity = depth < -0.15 ? '0.45' : '1';
        element.setAttribute('transform', `translate(${sx.toFixed(2)} ${sy.toFixed(2)})`);
      });
    };
    draw();
    return viewport.on_draw(draw);
  }, [viewport]);
  return (
    <div className="view-cube" role="group" aria-label="Direction of view">
      <div className="cube-scene">
        <div ref={cube} className="cube">
          {faces.map((face) => (
            <button
              key={face.name}
              type="button"
              tabIndex={-1}
              title={face.title}
              style={{ transform: face_transform(face) }}
              onClick={() => {
                viewport.rig.look_from(face.azimuth, face.elevation);
                viewport.invalidate();
              }}
            >
              <span>{face.name}</span>
            </button>
          ))}
        </div>
      </div>
      <svg className="axes" viewBox="-44 -44 88 88" aria-hidden="true">
        {axes.map((axis, i) => (
          <g key={axis.name} ref={(element) => { axis_elements.current[i] = element; }} fill={axis.color}>
            <circle r="6.800" />
            <text y="3.400" textAnchor="middle">{axis.name}</text>
          </g>
        ))}
      </svg>
    </div>
  );
}
