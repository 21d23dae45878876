/** The look of a scenario: light, sky and ground. docs/scenario.md describes the fields. */

export interface Sun {
  /** Direction from the ground to the light, rad. */
  azimuth: number;
  elevation: number;
  intensity: number;
  color: string;
}

/** Absent fields have the values of `plain_look`. */
export interface Look {
  light?: number;
  ambient?: number;
  sun?: Sun;
  floor?: string;
  pattern?: string;
  sky?: { zenith: string; horizon: string } | null;
}

/** The drawn surface of a character. Absent fields: roughness 0.6, no metal, and the character's colour for all links. */
export interface Material {
  roughness?: number;
  metalness?: number;
  /** Colours of links by their name. */
  link_colors?: Record<string, string>;
  /** Colours of the visible shapes, link by link; '': that of the link. */
  shape_colors?: string[];
  /** Of a mechanism with a skin; absent: the skin. 'both': the skin is transparent. */
  shown?: 'skin' | 'body' | 'both';
}

export const plain_look = {
  light: 0.9,
  ambient: 1,
  sun: { azimuth: 0.918, elevation: 1.009, intensity: 1, color: '#fff3e4' },
  floor: '#2a2c31',
  pattern: 'grid',
  sky: null,
};
