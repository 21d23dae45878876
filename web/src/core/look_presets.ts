/** Materials, skies and clothes that the look panel offers. */
import type { Look, Material } from './look';
import type { MechanismData } from './protocol';

export interface MaterialPreset extends Material {
  name: string;
  color: string;
}

export const materials: MaterialPreset[] = [
  { name: 'Cotton', color: '#c8553a', roughness: 0.9, metalness: 0 },
  { name: 'Denim', color: '#3d4a63', roughness: 0.95, metalness: 0 },
  { name: 'Skin', color: '#d9a683', roughness: 0.55, metalness: 0 },
  { name: 'Clay', color: '#e6e6ea', roughness: 0.6, metalness: 0 },
  { name: 'Steel', color: '#b9bec6', roughness: 0.3, metalness: 1 },
  { name: 'Brass', color: '#d3a350', roughness: 0.28, metalness: 1 },
  { name: 'Oak', color: '#b0814e', roughness: 0.7, metalness: 0 },
  { name: 'Rubber', color: '#33363c', roughness: 0.8, metalness: 0 },
  { name: 'Gloss', color: '#d8402f', roughness: 0.15, metalness: 0 },
];

/** Each sky sets light, sun, ambient light and the colours of the sky; the ground stays as it is. */
export const skies: { name: string; look: Required<Omit<Look, 'floor' | 'pattern'>> }[] = [
  { name: 'Studio', look: { light: 0.9, ambient: 1, sun: { azimuth: 0.918, elevation: 1.009, intensity: 1, color: '#fff3e4' }, sky: null } },
  { name: 'Day', look: { light: 1, ambient: 1.1, sun: { azimuth: 0.7, elevation: 0.85, intensity: 1.25, color: '#fff6e8' }, sky: { zenith: '#3f74b5', horizon: '#c7d8e8' } } },
  { name: 'Evening', look: { light: 0.9, ambient: 0.75, sun: { azimuth: 1.1, elevation: 0.3, intensity: 1.5, color: '#ffb27a' }, sky: { zenith: '#46536f', horizon: '#c79a80' } } },
  { name: 'Overcast', look: { light: 0.95, ambient: 2, sun: { azimuth: 0.9, elevation: 1.2, intensity: 0.3, color: '#f2f5fa' }, sky: { zenith: '#8b96a4', horizon: '#c9ced5' } } },
  { name: 'Night', look: { light: 0.75, ambient: 0.55, sun: { azimuth: -0.6, elevation: 0.8, intensity: 0.55, color: '#9db8ff' }, sky: { zenith: '#0a1020', horizon: '#1d2740' } } },
];

export const grounds: [id: string, name: string][] = [
  ['grid', 'Metre grid'],
  ['plain', 'Plain'],
  ['checker', 'Checker'],
  ['boards', 'Boards'],
];

/** Garments, by the labels of the links that they cover. */
const garments: { name: string; covers: RegExp }[] = [
  { name: 'Shirt', covers: /chest|thorax|abdomen|spine|upper ?(trunk|arm)|lower ?trunk|clavicle|shoulder|torso|trunk|waist/i },
  { name: 'Trousers', covers: /pelvis|hips?\b|thigh|shank/i },
  { name: 'Shoes', covers: /foot|feet|toe|ball/i },
  { name: 'Skin', covers: /head|neck|hand|forearm|face/i },
];

/** The garments of a human body with the names of the links that each covers; none for other mechanisms. */
export function clothes_of(mechanism: MechanismData): { name: string; links: string[] }[] {
  const labels = mechanism.links.map((l) => l.label ?? '');
  if (!labels.some((l) => /^hand/i.test(l)) || !labels.some((l) => /^thigh/i.test(l))) return [];
  return garments.map(({ name, covers }) => ({ name, links: mechanism.links.filter((l) => covers.test(l.label || l.name)).map((l) => l.name) })).filter((g) => g.links.length > 0);
}
