#include "assimp_bvh.h"

#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#include <stdexcept>

namespace ugoki::benchmarks {

AssimpMotion read_bvh_with_assimp(const std::string& text) {
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFileFromMemory(text.data(), text.size(), 0, "bvh");
  if (!scene || scene->mNumAnimations == 0)
    throw std::runtime_error(std::string("assimp cannot read the file: ") + importer.GetErrorString());
  const aiAnimation& animation = *scene->mAnimations[0];
  AssimpMotion out;
  out.joints = animation.mNumChannels;
  for (unsigned c = 0; c < animation.mNumChannels; ++c) {
    const aiNodeAnim& channel = *animation.mChannels[c];
    if (channel.mNumPositionKeys < 2) continue;
    out.keys = channel.mNumPositionKeys;
    for (unsigned k = 0; k < channel.mNumPositionKeys; ++k) {
      const aiVector3D& p = channel.mPositionKeys[k].mValue;
      for (const float x : {p.x, p.y, p.z}) out.root.push_back(static_cast<double>(x));
    }
    break;
  }
  return out;
}

}  // namespace ugoki::benchmarks
