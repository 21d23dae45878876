/**
 * Skinning with fewer operations than that of three.js, which without a graphics processor takes most of the time of a vertex. Importing this module
 * changes the chunks of three.js's shaders: bones are three rows of a matrix, whose place in the texture needs no division, and each vertex computes one
 * matrix. Skinned meshes must have a LinkSkeleton, and must be bound with an identity matrix in the mode 'detached'.
 */
import * as THREE from 'three';

const row = 1024; // texels in a row of the texture, if it has several rows
const texels = 3; // of a bone

const chunks = {
  skinning_pars_vertex: `
#ifdef USE_SKINNING
  uniform highp sampler2D boneTexture;
  mat3x4 bone_rows(float bone) {
    int i = int(bone) * ${texels};
    return mat3x4(
      texelFetch(boneTexture, ivec2(i & ${row - 1}, i >> 10), 0),
      texelFetch(boneTexture, ivec2((i + 1) & ${row - 1}, (i + 1) >> 10), 0),
      texelFetch(boneTexture, ivec2((i + 2) & ${row - 1}, (i + 2) >> 10), 0));
  }
#endif`,
  skinbase_vertex: `
#ifdef USE_SKINNING
  mat3x4 skin_rows = skinWeight.x * bone_rows(skinIndex.x) + skinWeight.y * bone_rows(skinIndex.y) + skinWeight.z * bone_rows(skinIndex.z) + skinWeight.w * bone_rows(skinIndex.w);
#endif`,
  skinnormal_vertex: `
#ifdef USE_SKINNING
  objectNormal = vec4(objectNormal, 0.0) * skin_rows;
#endif`,
  skinning_vertex: `
#ifdef USE_SKINNING
  transformed = vec4(transformed, 1.0) * skin_rows;
#endif`,
} as const;
for (const [name, text] of Object.entries(chunks)) {
  if (!THREE.ShaderChunk[name as keyof typeof chunks].includes('USE_SKINNING')) throw new Error(`The shader chunk ${name} of three.js has changed.`);
  (THREE.ShaderChunk as Record<string, string>)[name] = text;
}

/** Bones whose matrices the shaders of this module read. */
export class LinkSkeleton extends THREE.Skeleton {
  private readonly moved = new THREE.Matrix4();

  override init(): void {
    super.init();
    const count = Math.max(1, texels * this.bones.length);
    const [width, height] = count <= row ? [count, 1] : [row, Math.ceil(count / row)];
    this.boneMatrices = new Float32Array(4 * width * height);
    this.boneTexture = new THREE.DataTexture(this.boneMatrices, width, height, THREE.RGBAFormat, THREE.FloatType);
  }

  override update(): void {
    const { bones, boneInverses, boneTexture, moved } = this;
    const matrices = this.boneMatrices!; // made by init()
    bones.forEach((bone, i) => {
      const { elements: m } = moved.multiplyMatrices(bone.matrixWorld, boneInverses[i]!);
      for (let r = 0; r < texels; r++) for (let c = 0; c < 4; c++) matrices[4 * (texels * i + r) + c] = m[4 * c + r]!;
    });
    boneTexture!.needsUpdate = true;
  }
}
