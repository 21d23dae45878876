/** Small pictures of mechanisms in their neutral position, drawn once each off the screen. */
import * as THREE from 'three';
import type { MechanismData } from '../core/protocol';
import { Figure, mechanism_geometries } from './figure';

const width = 104;
const height = 76;
const pictures = new Map<string, string>();

/** A picture as a data URL; null where neutral poses are not known. */
export function mechanism_picture(mechanism: MechanismData, color: string): string | null {
  const key = `${mechanism.id} ${color}`;
  const known = pictures.get(key);
  if (known) return known;
  if (!mechanism.links.some((l) => l.neutral && l.shapes.length > 0)) return null;
  const renderer = new THREE.WebGLRenderer({ antialias: true, alpha: true, preserveDrawingBuffer: true });
  renderer.setSize(width, height, false);
  const scene = new THREE.Scene();
  const key_light = new THREE.DirectionalLight(0xfff3e4, 2.6);
  key_light.position.set(3, 2.5, 5);
  scene.add(key_light, new THREE.HemisphereLight(0xdfe8f7, 0x3a3836, 1.5));
  const figure = new Figure('', mechanism, mechanism_geometries(mechanism), color);
  scene.add(figure.group);
  figure.group.updateMatrixWorld(true);
  const box = new THREE.Box3().setFromObject(figure.group);
  const sphere = box.getBoundingSphere(new THREE.Sphere());
  const size = box.getSize(new THREE.Vector3());
  // what is longer than tall is seen from its side
  const long = size.x > 1.2 * size.z;
  const camera = new THREE.PerspectiveCamera(26, width / height, 0.01, 100);
  camera.up.set(0, 0, 1);
  const azimuth = long ? 1.15 : 0.5;
  const need = Math.max(size.z, (long ? size.x : Math.max(size.y, size.x)) * (height / width)) * 0.56;
  const distance = need / Math.tan((13 * Math.PI) / 180) + sphere.radius * 0.4;
  camera.position.set(sphere.center.x + distance * Math.cos(azimuth), sphere.center.y + distance * Math.sin(azimuth), sphere.center.z + 0.12 * distance);
  camera.lookAt(sphere.center);
  renderer.render(scene, camera);
  const url = renderer.domElement.toDataURL('image/png');
  for (const mesh of figure.links) mesh?.geometry.dispose();
  figure.dispose();
  renderer.dispose();
  renderer.forceContextLoss();
  pictures.set(key, url);
  return url;
}
