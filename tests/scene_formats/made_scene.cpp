#include "made_scene.h"

#include <assimp/cexport.h>
#include <assimp/scene.h>

#include <assimp/Exporter.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <vector>

#include "ugoki/base/check.h"
#include "ugoki/base/number.h"

namespace ugoki::scene_formats {
namespace {

/// Converts from our axes (z up) to the file's (y up).
Vec3 to_file(const Vec3& v) { return {v.y, v.z, v.x}; }
Mat3 to_file(const Mat3& R) {
  const Vec3 a = to_file(R.row(1)), b = to_file(R.row(2)), c = to_file(R.row(0));
  return {a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z};
}
aiVector3D ai(const Vec3& v) { return {static_cast<ai_real>(v.x), static_cast<ai_real>(v.y), static_cast<ai_real>(v.z)}; }
aiQuaternion ai(const Quat& q) {
  return {static_cast<ai_real>(q.w), static_cast<ai_real>(q.x), static_cast<ai_real>(q.y), static_cast<ai_real>(q.z)};
}

/// Rest rotation of a joint's node: arbitrary, but the same for the whole file.
Mat3 rest_rotation(std::size_t joint) {
  return rotation_about(normalized(Vec3{1, static_cast<double>(joint), 0.5}), 0.7 * static_cast<double>(joint));
}

/// One triangle for each joint, bound to this joint only.
aiMesh* make_mesh(const std::vector<Vec3>& positions, const std::vector<std::string>& names) {
  auto* mesh = new aiMesh;
  mesh->mName = "skin";
  mesh->mPrimitiveTypes = aiPrimitiveType_TRIANGLE;
  mesh->mNumVertices = static_cast<unsigned>(3 * positions.size());
  mesh->mVertices = new aiVector3D[mesh->mNumVertices];
  mesh->mNormals = new aiVector3D[mesh->mNumVertices];
  mesh->mTextureCoords[0] = new aiVector3D[mesh->mNumVertices];
  mesh->mNumUVComponents[0] = 2;
  mesh->mNumFaces = static_cast<unsigned>(positions.size());
  mesh->mFaces = new aiFace[mesh->mNumFaces];
  mesh->mNumBones = static_cast<unsigned>(positions.size());
  mesh->mBones = new aiBone*[mesh->mNumBones];
  for (unsigned j = 0; j < mesh->mNumBones; ++j) {
    aiBone* bone = mesh->mBones[j] = new aiBone;
    bone->mName = names[j];
    bone->mOffsetMatrix = aiMatrix4x4();
    bone->mNumWeights = 3;
    bone->mWeights = new aiVertexWeight[3];
    mesh->mFaces[j].mNumIndices = 3;
    mesh->mFaces[j].mIndices = new unsigned[3];
    for (unsigned k = 0; k < 3; ++k) {
      const unsigned v = 3 * j + k;
      mesh->mVertices[v] = ai(positions[j] + Vec3{0.1 * (k == 1), 0.1 * (k == 2), 0});
      mesh->mNormals[v] = {0, 0, 1};
      mesh->mTextureCoords[0][v] = {0.25f, 0.75f, 0};
      mesh->mFaces[j].mIndices[k] = v;
      bone->mWeights[k] = {v, 1.0f};
    }
  }
  return mesh;
}

}  // namespace

MeasuredMotion random_motion(unsigned seed, int frames) {
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> in(-1, 1);
  MeasuredMotion m;
  m.name = "made";
  m.rate = 25;
  m.frames = frames;
  for (int i = 0; i < 12; ++i) {
    SkeletonJoint j;
    j.name = i == 3 ? "left_hand" : "joint" + std::to_string(i);
    j.parent = i == 0 ? -1 : (i - 1) / 2;
    j.offset = {0.3 * in(engine), 0.3 * in(engine), 0.4};
    m.skeleton.joints.push_back(j);
  }
  std::vector<Vec3> axes;
  for (int i = 0; i < 12; ++i) axes.push_back(normalized(Vec3{in(engine), in(engine), in(engine)}));
  for (int f = 0; f < frames; ++f)
    for (int i = 0; i < 12; ++i) {
      const double t = 0.1 * f;
      Vec3 p = m.skeleton.joints[static_cast<std::size_t>(i)].offset;
      if (i == 0) p += Vec3{t, 0.2 * t * t, 0.1 * t};
      m.translations.push_back(p);
      m.rotations.push_back(axis_angle(axes[static_cast<std::size_t>(i)], i % 4 == 3 ? 0 : 1.5 * sin(t + i)));
    }
  return m;
}

std::string make_scene_file(const MeasuredMotion& motion, const MadeOptions& options) {
  const std::size_t n = motion.skeleton.joints.size();
  const double unit = options.units_per_metre;
  std::vector<aiNode*> nodes(n);
  std::vector<std::vector<aiNode*>> children(n + 1);
  std::vector<std::string> names;
  std::vector<Vec3> positions;
  const std::vector<Vec3> rest = rest_positions(motion.skeleton);
  const auto local_rotation = [&](std::size_t j, const Mat3& turned_parent, const Mat3& turned) {
    const int p = motion.skeleton.joints[j].parent;
    const Mat3 up = p < 0 ? Mat3::identity() : to_file(turned_parent) * rest_rotation(static_cast<std::size_t>(p));
    return up.transposed() * (to_file(turned) * rest_rotation(j));
  };
  const auto local_position = [&](std::size_t j, const Vec3& p) {
    const int parent = motion.skeleton.joints[j].parent;
    return (parent < 0 ? to_file(p) : transpose_times(rest_rotation(static_cast<std::size_t>(parent)), to_file(p))) * unit;
  };
  for (std::size_t j = 0; j < n; ++j) {
    const SkeletonJoint& joint = motion.skeleton.joints[j];
    nodes[j] = new aiNode(joint.name);
    nodes[j]->mTransformation = aiMatrix4x4(aiVector3D(1, 1, 1), ai(to_quat(local_rotation(j, Mat3::identity(), Mat3::identity()))),
                                            ai(local_position(j, joint.offset)));
    children[static_cast<std::size_t>(joint.parent + 1)].push_back(nodes[j]);
    names.push_back(joint.name);
    positions.push_back(to_file(rest[j]) * unit);
  }
  aiScene scene;
  scene.mRootNode = new aiNode("RootNode");
  for (std::size_t j = 0; j < n; ++j)
    if (!children[j + 1].empty()) nodes[j]->addChildren(static_cast<unsigned>(children[j + 1].size()), children[j + 1].data());
  std::vector<aiNode*> top = children[0];
  aiNode* skin = nullptr;
  if (options.skin) {
    skin = new aiNode("body");
    skin->mNumMeshes = 1;
    skin->mMeshes = new unsigned[1]{0};
    top.push_back(skin);
    scene.mNumMeshes = 1;
    scene.mMeshes = new aiMesh*[1]{make_mesh(positions, names)};
    for (std::size_t j = 0; j < n; ++j) {  // bind pose: from the mesh frame to the bone frame in the rest pose
      const aiMatrix4x4 bone(aiVector3D(1, 1, 1), ai(to_quat(rest_rotation(j))), ai(positions[j]));
      aiMatrix4x4 offset = bone;
      scene.mMeshes[0]->mBones[j]->mOffsetMatrix = offset.Inverse();
    }
  }
  scene.mRootNode->addChildren(static_cast<unsigned>(top.size()), top.data());
  scene.mNumMaterials = 1;
  scene.mMaterials = new aiMaterial*[1]{new aiMaterial};
  const aiColor3D color(0.2f, 0.4f, 0.6f);
  scene.mMaterials[0]->AddProperty(&color, 1, AI_MATKEY_COLOR_DIFFUSE);
  if (const aiString path(options.texture); !options.texture.empty())
    scene.mMaterials[0]->AddProperty(&path, AI_MATKEY_TEXTURE(aiTextureType_DIFFUSE, 0));

  auto* animation = new aiAnimation;
  animation->mName = "dance";
  animation->mTicksPerSecond = 1;  // times in seconds, as the COLLADA exporter assumes
  animation->mDuration = (motion.frames - 1) / motion.rate;
  animation->mNumChannels = static_cast<unsigned>(n);
  animation->mChannels = new aiNodeAnim*[n];
  for (std::size_t j = 0; j < n; ++j) {
    aiNodeAnim* channel = animation->mChannels[j] = new aiNodeAnim;
    channel->mNodeName = names[j];
    channel->mNumPositionKeys = channel->mNumRotationKeys = channel->mNumScalingKeys = static_cast<unsigned>(motion.frames);
    channel->mPositionKeys = new aiVectorKey[static_cast<std::size_t>(motion.frames)];
    channel->mRotationKeys = new aiQuatKey[static_cast<std::size_t>(motion.frames)];
    channel->mScalingKeys = new aiVectorKey[static_cast<std::size_t>(motion.frames)];
  }
  std::vector<Mat3> turned(n);
  for (int f = 0; f < motion.frames; ++f)
    for (std::size_t j = 0; j < n; ++j) {
      const std::size_t at = static_cast<std::size_t>(f) * n + j;
      const int p = motion.skeleton.joints[j].parent;
      const Mat3 up = p < 0 ? Mat3::identity() : turned[static_cast<std::size_t>(p)];
      turned[j] = up * to_matrix(motion.rotations[at]);
      aiNodeAnim& channel = *animation->mChannels[j];
      channel.mPositionKeys[f] = {f / motion.rate, ai(local_position(j, motion.translations[at]))};
      channel.mRotationKeys[f] = {f / motion.rate, ai(to_quat(local_rotation(j, up, turned[j])))};
      channel.mScalingKeys[f] = {f / motion.rate, aiVector3D(1, 1, 1)};
    }
  scene.mNumAnimations = 1;
  scene.mAnimations = new aiAnimation*[1]{animation};

  // Export to a file, because this is the exporters' usual code path.
  std::string folder = (std::filesystem::temp_directory_path() / "ugoki-scene-XXXXXX").string();
  UGOKI_CHECK(::mkdtemp(folder.data()) != nullptr);
  const std::string path = folder + (options.format == "collada" ? "/made.dae" : "/made.fbx");
  Assimp::Exporter exporter;
  UGOKI_CHECK(exporter.Export(&scene, options.format, path) == aiReturn_SUCCESS);
  std::ifstream in(path, std::ios::binary);
  std::string bytes(std::istreambuf_iterator<char>(in), {});
  std::filesystem::remove_all(folder);
  return bytes;
}

std::string collada_text(const std::string& up, double metre) {
  return R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
 <asset><unit name="u" meter=")" +
         to_text(metre) + "\"/><up_axis>" + up + R"(</up_axis></asset>
 <library_animations><animation id="turn">
  <source id="times"><float_array id="times-a" count="2">0 1</float_array><technique_common><accessor source="#times-a" count="2"><param name="TIME" type="float"/></accessor></technique_common></source>
  <source id="angles"><float_array id="angles-a" count="2">0 90</float_array><technique_common><accessor source="#angles-a" count="2"><param name="ANGLE" type="float"/></accessor></technique_common></source>
  <source id="how"><Name_array id="how-a" count="2">LINEAR LINEAR</Name_array><technique_common><accessor source="#how-a" count="2"><param name="INTERPOLATION" type="name"/></accessor></technique_common></source>
  <sampler id="s"><input semantic="INPUT" source="#times"/><input semantic="OUTPUT" source="#angles"/><input semantic="INTERPOLATION" source="#how"/></sampler>
  <channel source="#s" target="arm/bend.ANGLE"/>
 </animation></library_animations>
 <library_visual_scenes><visual_scene id="scene">
  <node id="hip" name="hip" type="JOINT"><translate sid="t">1 2 3</translate>
   <node id="arm" name="arm" type="JOINT"><translate sid="t">0 4 0</translate><rotate sid="bend">1 0 0 0</rotate>
    <node id="tip" name="tip" type="JOINT"><translate sid="t">0 0 5</translate></node></node></node>
 </visual_scene></library_visual_scenes>
 <scene><instance_visual_scene url="#scene"/></scene>
</COLLADA>
)";
}

}  // namespace ugoki::scene_formats
