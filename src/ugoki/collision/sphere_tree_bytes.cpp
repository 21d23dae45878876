// Writes and reads a sphere tree as bytes: magic, version, checksum of the bytes that follow, centre, radius, closed, then each array with
// its count.

#include <bit>
#include <cstring>
#include <string>
#include <type_traits>

#include "ugoki/base/hash.h"
#include "ugoki/collision/sphere_tree.h"

namespace ugoki::collision {
namespace {

static_assert(std::endian::native == std::endian::little);
constexpr std::uint32_t magic = 0x54534755, version = 1;  // "UGST"
constexpr std::size_t head = 16;                          // bytes of magic, version and checksum

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

template <class T>
void put(std::vector<std::uint8_t>& out, const T* values, std::size_t count) {
  static_assert(std::is_trivially_copyable_v<T>);
  if (count == 0) return;
  const std::size_t old = out.size();
  out.resize(old + count * sizeof(T));
  std::memcpy(out.data() + old, values, count * sizeof(T));
}
template <class T>
void put_array(std::vector<std::uint8_t>& out, const std::vector<T>& values) {
  const std::uint64_t count = values.size();
  put(out, &count, 1);
  put(out, values.data(), values.size());
}

class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
  template <class T>
  bool get(T& value) {
    if (bytes_.size() < sizeof value) return false;
    std::memcpy(&value, bytes_.data(), sizeof value);
    bytes_ = bytes_.subspan(sizeof value);
    return true;
  }
  template <class T>
  bool get_array(std::vector<T>& values) {
    std::uint64_t count = 0;
    if (!get(count) || count > bytes_.size() / sizeof(T)) return false;
    values.resize(static_cast<std::size_t>(count));
    if (count > 0) std::memcpy(values.data(), bytes_.data(), values.size() * sizeof(T));
    bytes_ = bytes_.subspan(values.size() * sizeof(T));
    return true;
  }
  [[nodiscard]] bool at_end() const { return bytes_.empty(); }

 private:
  std::span<const std::uint8_t> bytes_;
};

std::uint64_t checksum(std::span<const std::uint8_t> bytes) {
  Hash64 hash;
  hash.add_bytes(bytes.data(), bytes.size());
  return hash.value();
}

bool in_range(std::int32_t i, std::size_t count) { return i >= 0 && at(i) < count; }

/// True if all child indices are in range and every block and every triangle has exactly one parent.
bool is_tree(const SphereTree& tree) {
  const std::size_t blocks = tree.blocks.size(), triangles = tree.triangles.size();
  if (blocks == 0 || triangles == 0 || tree.blocks[0].count != 1) return false;
  std::size_t max_depth = 2;
  for (std::size_t n = triangles; n > 1; n = (n + 1) / 2) ++max_depth;
  std::vector<std::size_t> depth(blocks, 0);  // 0: no parent found yet
  std::vector<char> seen(triangles, 0);
  depth[0] = 1;
  std::size_t leaves = 0, linked = 1;
  for (std::size_t b = 0; b < blocks; ++b) {
    const BoundBlock& block = tree.blocks[b];
    if (depth[b] == 0 || depth[b] > max_depth || block.count < 1 || block.count > block_lanes) return false;
    for (std::int32_t i = 0; i < block.count; ++i) {
      const std::int32_t child = block.child[i];
      if (child < 0) {
        const std::int64_t t = -1 - static_cast<std::int64_t>(child);
        if (t >= static_cast<std::int64_t>(triangles) || seen[static_cast<std::size_t>(t)] != 0) return false;
        seen[static_cast<std::size_t>(t)] = 1;
        ++leaves;
      } else {
        // Blocks are visited in the order of their indices and must have a depth when visited, so that parents are before their children.
        if (at(child) >= blocks || depth[at(child)] != 0) return false;
        depth[at(child)] = depth[b] + 1;
        ++linked;
      }
    }
  }
  return leaves == triangles && linked == blocks;
}

/// True if the tree is safe to search: finite, with consistent array sizes and indices.
bool is_sound(const SphereTree& tree) {
  if (!is_finite(tree.centre) || !std::isfinite(tree.radius) || !is_tree(tree)) return false;
  if (tree.source.size() != tree.triangles.size() || tree.vertex_source.size() != tree.vertices.size()) return false;
  for (const Triangle& t : tree.triangles)
    for (const std::int32_t v : t)
      if (!in_range(v, tree.vertices.size())) return false;
  for (const Vec3& v : tree.vertices)
    if (!is_finite(v)) return false;
  if (!tree.closed) return tree.across.empty() && tree.vertex_normals.empty();
  if (tree.across.size() != tree.triangles.size() || tree.vertex_normals.size() != tree.vertices.size()) return false;
  for (const auto& t : tree.across)
    for (const std::int32_t i : t)
      if (!in_range(i, tree.triangles.size())) return false;
  return true;
}

}  // namespace

std::vector<std::uint8_t> write_bytes(const SphereTree& tree) {
  std::vector<std::uint8_t> out(head);
  put(out, &tree.centre, 1);
  put(out, &tree.radius, 1);
  const std::uint64_t closed = tree.closed ? 1 : 0;
  put(out, &closed, 1);
  put_array(out, tree.blocks);
  put_array(out, tree.vertices);
  put_array(out, tree.triangles);
  put_array(out, tree.source);
  put_array(out, tree.vertex_source);
  put_array(out, tree.vertex_normals);
  put_array(out, tree.across);
  const std::uint64_t sum = checksum(std::span(out).subspan(head));
  std::memcpy(out.data(), &magic, 4);
  std::memcpy(out.data() + 4, &version, 4);
  std::memcpy(out.data() + 8, &sum, 8);
  return out;
}

Result<SphereTree> read_sphere_tree(std::span<const std::uint8_t> bytes, std::string_view location) {
  const auto refuse = [&](ErrorCode code, const char* message) {
    return fail(code, std::string(location), message, "Remove \"prepared\"; the sphere tree is rebuilt from the mesh.");
  };
  Reader reader(bytes);
  std::uint32_t first = 0, found_version = 0;
  std::uint64_t sum = 0, closed = 0;
  if (!reader.get(first) || !reader.get(found_version) || !reader.get(sum) || first != magic)
    return refuse(ErrorCode::syntax, "These bytes are not a sphere tree.");
  if (found_version != version)
    return refuse(ErrorCode::unsupported, "The sphere tree has an unsupported version; only version 1 is supported.");
  SphereTree tree;
  if (checksum(bytes.subspan(head)) != sum || !reader.get(tree.centre) || !reader.get(tree.radius) || !reader.get(closed) ||
      !reader.get_array(tree.blocks) || !reader.get_array(tree.vertices) || !reader.get_array(tree.triangles) ||
      !reader.get_array(tree.source) || !reader.get_array(tree.vertex_source) || !reader.get_array(tree.vertex_normals) ||
      !reader.get_array(tree.across) || !reader.at_end())
    return refuse(ErrorCode::truncated, "The sphere tree is damaged or truncated.");
  tree.closed = closed != 0;
  if (!is_sound(tree)) return refuse(ErrorCode::structure, "The arrays of the sphere tree are inconsistent.");
  return tree;
}

}  // namespace ugoki::collision
