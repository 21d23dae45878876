#include "ugoki/studio/closest_pairs.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <tuple>
#include <utility>

namespace ugoki::studio {
namespace {

// Byte offsets in the header of a display frame, and sizes of its parts, bytes.
constexpr std::size_t characters_at = 24, closest_count_at = 56;
constexpr std::size_t head_size = 64, character_size = 56, link_size = 28;

std::uint32_t read_u32(std::span<const std::byte> frame, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, frame.data() + at, sizeof value);
  return value;
}

template <class T>
void add(std::vector<std::byte>& out, T value) {
  const std::size_t at = out.size();
  out.resize(at + sizeof value);
  std::memcpy(out.data() + at, &value, sizeof value);
}

void add(std::vector<std::byte>& out, const Vec3& v) {
  for (int i = 0; i < 3; ++i) add(out, static_cast<float>(v[i]));
}

}  // namespace

ClosestPairs::ClosestPairs(std::vector<MechanismPtr> mechanisms)
    : scene_(std::move(mechanisms), {}, {.with_ground = false, .between_systems = true, .self_collision = false}), tree_(scene_) {
  for (const MechanismPtr& m : scene_.systems()) poses_.emplace_back(static_cast<std::size_t>(m->link_count()));
  for (const auto& p : poses_) views_.emplace_back(p);
}

bool ClosestPairs::read_poses(std::span<const std::byte> frame) {
  if (frame.size() < head_size || read_u32(frame, characters_at) != poses_.size()) return false;
  std::size_t at = head_size;
  for (std::vector<Pose>& poses : poses_) {
    if (at + character_size + poses.size() * link_size > frame.size() || read_u32(frame, at) != poses.size()) return false;
    at += character_size;
    for (Pose& X : poses) {
      float x[7];
      std::memcpy(x, frame.data() + at, sizeof x);
      at += link_size;
      X = {to_matrix(normalized(Quat{x[3], x[4], x[5], x[6]})), {x[0], x[1], x[2]}};
    }
  }
  return true;
}

void ClosestPairs::find() {
  tree_.update(views_);
  found_.clear();
  const int count = static_cast<int>(poses_.size());
  // With more characters than this, only pairs closer than 0.1 m are searched: the number of pairs grows with the square of the count.
  constexpr int max_characters = 24;  // 24 characters have 276 pairs
  if (count <= max_characters) {
    for (int a = 0; a < count; ++a)
      for (int b = a + 1; b < count; ++b)
        if (const collision::NearPair& pair = tree_.nearest(a, b); pair.bodies.a >= 0 && pair.near.distance <= max_distance)
          found_.push_back({a, b, pair.near});
  } else {
    std::vector<collision::NearPair> near;
    tree_.pairs_within(0.1, near);
    for (const collision::NearPair& pair : near) {
      const int a = scene_.shapes()[static_cast<std::size_t>(pair.bodies.a)].system;
      const int b = scene_.shapes()[static_cast<std::size_t>(pair.bodies.b)].system;
      const auto known = std::ranges::find_if(found_, [&](const Found& f) { return f.a == a && f.b == b; });
      if (a == b || !pair.near.exact) continue;
      if (known == found_.end())
        found_.push_back({a, b, pair.near});
      else if (pair.near.distance < known->near.distance)
        known->near = pair.near;
    }
  }
  std::ranges::sort(found_, {}, [](const Found& f) { return std::tuple(f.near.distance, f.a, f.b); });
  if (found_.size() > max_pairs) found_.resize(max_pairs);
}

std::span<const std::byte> ClosestPairs::append_to(std::span<const std::byte> frame) {
  if (!read_poses(frame)) return frame;
  find();
  bytes_.assign(frame.begin(), frame.end());
  const auto count = static_cast<std::uint32_t>(found_.size());
  std::memcpy(bytes_.data() + closest_count_at, &count, sizeof count);
  for (const Found& f : found_) {
    add(bytes_, f.near.pa);
    add(bytes_, f.near.pb);
    add(bytes_, static_cast<float>(f.near.distance));
    add(bytes_, static_cast<std::uint32_t>(f.a) << 16 | static_cast<std::uint32_t>(f.b));
  }
  return bytes_;
}

}  // namespace ugoki::studio
