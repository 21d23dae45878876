#include "ugoki/formats/glb_chunk.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace ugoki::formats {

using json::Json;

int GlbChunk::add(const void* data, std::size_t size, std::size_t count, const char* type, int kind, int target) {
  bytes_.resize((bytes_.size() + 3) / 4 * 4);
  Json view{{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", size}};
  if (target != 0) view["target"] = target;
  views_.push_back(std::move(view));
  const auto* p = static_cast<const std::byte*>(data);
  bytes_.insert(bytes_.end(), p, p + size);
  accessors_.push_back({{"bufferView", views_.size() - 1}, {"componentType", kind}, {"count", count}, {"type", type}});
  return static_cast<int>(accessors_.size()) - 1;
}

int GlbChunk::picture(std::span<const std::byte> data) {
  bytes_.resize((bytes_.size() + 3) / 4 * 4);
  views_.push_back({{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", data.size()}});
  bytes_.insert(bytes_.end(), data.begin(), data.end());
  return static_cast<int>(views_.size()) - 1;
}

void GlbChunk::bound(int accessor, const std::vector<float>& values, std::size_t components) {
  Json low = Json::array(), high = Json::array();
  for (std::size_t c = 0; c < components; ++c) {
    float minimum = values[c], maximum = values[c];
    for (std::size_t i = c; i < values.size(); i += components) {
      minimum = std::min(minimum, values[i]);
      maximum = std::max(maximum, values[i]);
    }
    low.push_back(minimum);
    high.push_back(maximum);
  }
  accessors_[static_cast<std::size_t>(accessor)]["min"] = low;
  accessors_[static_cast<std::size_t>(accessor)]["max"] = high;
}

std::vector<std::byte> GlbChunk::finish(Json root) {
  root["bufferViews"] = views_;
  root["accessors"] = accessors_;
  bytes_.resize((bytes_.size() + 3) / 4 * 4);
  root["buffers"] = Json::array({{{"byteLength", bytes_.size()}}});
  std::string text = json::to_text(root);
  text.resize((text.size() + 3) / 4 * 4, ' ');
  std::vector<std::byte> out;
  const auto word = [&](std::size_t v) {
    for (int k = 0; k < 4; ++k) out.push_back(static_cast<std::byte>(v >> (8 * k) & 0xff));
  };
  word(0x46546C67);  // the characters "glTF"
  word(2);
  word(12 + 8 + text.size() + 8 + bytes_.size());
  word(text.size());
  word(0x4E4F534A);  // the characters "JSON"
  const auto* p = reinterpret_cast<const std::byte*>(text.data());
  out.insert(out.end(), p, p + text.size());
  word(bytes_.size());
  word(0x004E4942);  // the characters "BIN"
  out.insert(out.end(), bytes_.begin(), bytes_.end());
  return out;
}

std::array<float, 4> glb_rotation(const Quat& q) {
  std::array<double, 4> x = {q.x, q.y, q.z, q.w};
  double square = 0;
  for (double& c : x) {
    c = static_cast<double>(static_cast<float>(c));
    square += c * c;
  }
  std::array<float, 4> out{};
  for (std::size_t k = 0; k < 4; ++k) out[k] = static_cast<float>(x[k] / std::sqrt(square));
  return out;
}

}  // namespace ugoki::formats
