import { useEffect, useRef, type ReactElement } from 'react';
import type { Viewport } from '../view/viewport';

const faces: { name: string; title: string; place: string; azimuth: number; elevation: number }[] = [
  { name: 'Front', title: 'From the front (+X)', place: 'rotateY(90deg)', azimuth: 0, elevation: 0.02 },
  { name: 'Back', title: 'From behind (−X)', place: 'rotateY(-90deg)', azimuth: Math.PI, elevation: 0.02 },
  { name: 'Left', title: 'From its left (+Y)', place: 'rotateX(-90deg) rotateZ(180deg)', azimuth: Math.PI / 2, elevation: 0.02 },
  { name: 'Right', title: 'From its right (−Y)', place: 'rotateX(90deg)', azimuth: -Math.PI / 2, elevation: 0.02 },
  { name: 'Top', title: 'From above (+Z)', place: '', azimuth: -Math.PI / 2, elevation: 1.55 },
  { name: 'Below', title: 'From below (−Z)', place: 'rotateY(180deg)', azimuth: -Math.PI / 2, elevation: -1.45 },
];
const axes = [
  { name: 'X', color: 'var(--axis-x)', at: [1, 0, 0] },
  { name: 'Y', color: 'var(--axis-y)', at: [0, 1, 0] },
  { name: 'Z', color: 'var(--axis-z)', at: [0, 0, 1] },
] as const;

/** The cube that shows and chooses the direction of view, with the axes around it. */
export function ViewCube({ viewport }: { viewport: Viewport }): ReactElement {
  const cube = useRef<HTMLDivElement>(null);
  const axis_elements = useRef<(SVGGElement | null)[]>([]);
  useEffect(() => {
    let before = '';
    const draw = (): void => {
      const e = viewport.rig.camera.matrixWorldInverse.elements;
      // the page's y points down: mirror the rows that come out on screen
      const m = [e[0], -e[1], e[2], 0, e[4], -e[5], e[6], 0, e[8], -e[9], e[10], 0, 0, 0, 0, 1].map((v) => (v as number).toFixed(5));
      const text = m.join(',');
      if (text === before) return;
      before = text;
      if (cube.current) cube.current.style.transform = `matrix3d(${text}) scaleY(-1)`;
      axes.forEach((axis, i) => {
        const element = axis_elements.current[i];
        if (!element) return;
        const [x, y, z] = axis.at;
        const sx = 34 * (e[0] * x + e[4] * y + e[8] * z);
        const sy = -34 * (e[1] * x + e[5] * y + e[9] * z);
        const depth = e[2] * x + e[6] * y + e[10] * z;
        element.style.opacity = depth < -0.15 ? '0.45' : '1';
        element.querySelector('line')?.setAttribute('x2', sx.toFixed(2));
        element.querySelector('line')?.setAttribute('y2', sy.toFixed(2));
        element.querySelector('g')?.setAttribute('transform', `translate(${(sx * 1.0).toFixed(2)} ${(sy * 1.0).toFixed(2)})`);
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
              style={{ transform: `${face.place} translateZ(calc(var(--cube) / 2)) scaleY(-1)` }}
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
          <g key={axis.name} ref={(element) => { axis_elements.current[i] = element; }} stroke={axis.color} fill={axis.color}>
            <line x1="0" y1="0" x2="0" y2="0" strokeWidth="2" strokeLinecap="round" />
            <g>
              <circle r="7.500" stroke="none" />
              <text y="3.600" textAnchor="middle" stroke="none">{axis.name}</text>
            </g>
          </g>
        ))}
      </svg>
    </div>
  );
}
