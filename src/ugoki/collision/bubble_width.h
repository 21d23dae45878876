#pragma once
// The mesh search for one SIMD width. Each bubble_<width>.cpp includes this file once, after it has defined UGOKI_WIDTH (the namespace of
// the kernel's table), UGOKI_DOUBLE_LANES and UGOKI_FLOAT_LANES (at most block_lanes).

#include "ugoki/collision/bubble_kernel.h"
#include "ugoki/collision/triangle_kernel.h"

namespace ugoki::collision {
namespace {

using Floats = Lanes<float, UGOKI_FLOAT_LANES>;
using Doubles = Lanes<double, UGOKI_DOUBLE_LANES>;
using F1 = Lanes<float, 1>;

/// Converts a lane mask to an integer: bit i is set if lane i is set.
template <class Real, int N>
unsigned bits(LaneMask<Real, N> m) {
#ifdef __clang__
  typedef bool Bits __attribute__((ext_vector_type(N)));
  const Bits b = __builtin_convertvector(m.m, Bits);
  unsigned out = 0;
  __builtin_memcpy(&out, &b, sizeof b);
  return out & ((1U << N) - 1);
#else
  unsigned out = 0;
  for (int i = 0; i < N; ++i) out |= m[i] ? 1U << i : 0U;
  return out;
#endif
}

/// One bound (sphere and box), in the frame of the block that it is tested against. Lengths in m.
struct Single {
  Vec3T<F1> sphere, box, axis[3];  ///< centre of the sphere, centre and axes of the box
  F1 radius, half[3];
  Vec3T<F1> towards;  ///< unit: from this bound towards the block, along the closest pair of points found so far; zero: none
};

/// Vector `lane` of the block's array v, rotated by X.
Vec3T<F1> turned(const KernelPose<float>& X, const float (*v)[block_lanes], int lane) {
  const float x = v[0][lane], y = v[1][lane], z = v[2][lane];
  return {F1(X.R[0][0] * x + X.R[0][1] * y + X.R[0][2] * z), F1(X.R[1][0] * x + X.R[1][1] * y + X.R[1][2] * z),
          F1(X.R[2][0] * x + X.R[2][1] * y + X.R[2][2] * z)};
}

/// Makes a Single from lane `lane` of `block`, in the frame of the other tree.
/// @param X pose of the tree of `block` in the frame of the other tree
/// @param towards unit or zero, frame of the other tree: see Single::towards
Single make_single(const BoundBlock& block, int lane, const KernelPose<float>& X, const Vec3T<F1>& towards) {
  Single s;
  const Vec3T<F1> p{F1(X.p[0]), F1(X.p[1]), F1(X.p[2])};
  s.sphere = turned(X, block.sphere, lane) + p;
  s.box = turned(X, block.box, lane) + p;
  s.axis[0] = turned(X, block.axis[0], lane);
  s.axis[1] = turned(X, block.axis[1], lane);
  s.axis[2] = cross(s.axis[0], s.axis[1]);
  s.radius = F1(block.radius[lane]);
  for (int k = 0; k < 3; ++k) s.half[k] = F1(block.half[k][lane]);
  s.towards = towards;
  return s;
}

/// Copies a vector to all lanes.
template <class T>
Vec3T<T> spread(const Vec3T<F1>& v) {
  return {T(v.x.v), T(v.y.v), T(v.z.v)};
}
/// Loads the vectors of the lanes that start at lane i of the block's array v.
template <class T>
Vec3T<T> load3(const float (*v)[block_lanes], int i) {
  return {T::load(v[0] + i), T::load(v[1] + i), T::load(v[2] + i)};
}
/// Absolute value of each lane.
template <class T>
T magnitude(T x) {
  return maximum(x, -x);
}

/// Separation [m] of two boxes along s.towards: the box of s and, in each lane, the box given by centre, axes and half extents. It is a
/// lower bound of the distance between the boxes and may be negative.
template <class T>
T gap_along(const Single& s, const Vec3T<T>& box, const Vec3T<T>* axis, const T* half) {
  F1 reach_s(0);
  for (int k = 0; k < 3; ++k) reach_s += magnitude(dot(s.axis[k], s.towards)) * s.half[k];
  const Vec3T<T> u = spread<T>(s.towards);
  T gap = dot(box, u) - T((dot(s.box, s.towards) + reach_s).v);
  for (int k = 0; k < 3; ++k) gap = gap - magnitude(dot(axis[k], u)) * half[k];
  return gap;
}

/// True if two boxes (as in gap_along()) are farther apart than `limit` [m] along the line of their centres; false if the centres coincide.
template <class T>
typename T::Mask beyond_along_centres(const Single& s, const Vec3T<T>& box, const Vec3T<T>* axis, const T* half, T limit) {
  const Vec3T<T> line = box - spread<T>(s.box);
  const T length2 = dot(line, line);
  T reach = sqrt(length2) * limit;  // all terms are multiplied by the line's length, which avoids a division
  for (int k = 0; k < 3; ++k) {
    reach += magnitude(dot(line, axis[k])) * half[k];
    reach += magnitude(dot(line, spread<T>(s.axis[k]))) * T(s.half[k].v);
  }
  return length2 > reach;
}

/// Lower bound [m^2] of the squared distance between two boxes (as in gap_along()): the larger of two squared distances. Each is between
/// one box and the bounding box of the other box along the axes of the first box.
template <class T>
T box_gap2(const Single& s, const Vec3T<T>& box, const Vec3T<T>* axis, const T* half) {
  const Vec3T<T> apart = box - spread<T>(s.box);
  T reach_s[3] = {T(s.half[0].v), T(s.half[1].v), T(s.half[2].v)};  // m: summed half extents of both boxes along the axes of s
  T gap2_block(0);
  const Vec3T<T> sa[3] = {spread<T>(s.axis[0]), spread<T>(s.axis[1]), spread<T>(s.axis[2])};
  for (int i = 0; i < 3; ++i) {
    T reach = half[i];
    for (int j = 0; j < 3; ++j) {
      const T r = magnitude(dot(axis[i], sa[j]));
      reach += r * T(s.half[j].v);
      reach_s[j] += r * half[i];
    }
    const T gap = maximum(magnitude(dot(apart, axis[i])) - reach, T(0));
    gap2_block += gap * gap;
  }
  T gap2_s(0);
  for (int j = 0; j < 3; ++j) {
    const T gap = maximum(magnitude(dot(apart, sa[j])) - reach_s[j], T(0));
    gap2_s += gap * gap;
  }
  return maximum(gap2_block, gap2_s);
}

/// Depth-first search of two sphere trees, closest bounds first.
class Search {
 public:
  explicit Search(KernelQuery& query) : q_(query) {}

  void run() {
    towards_b_ = {F1(q_.towards_b[0]), F1(q_.towards_b[1]), F1(q_.towards_b[2])};
    set_limit();
    top_ = 0;
    q_.found = 0;
    q_.bound_tests = q_.triangle_tests = 0;
    q_.stack[top_++] = {0, 0, 0.0F};
    while (top_ > 0) {
      const KernelEntry e = q_.stack[--top_];
      if (e.gap2 >= limit2_) continue;
      const BoundBlock& in_a = q_.a.blocks[e.a / block_lanes];
      const BoundBlock& in_b = q_.b.blocks[e.b / block_lanes];
      const int la = e.a % block_lanes, lb = e.b % block_lanes;
      const std::int32_t ca = in_a.child[la], cb = in_b.child[lb];
      if (ca < 0 && cb < 0)
        add_leaf({-1 - ca, -1 - cb}, e.gap2);
      else if (cb < 0 || (ca >= 0 && in_a.radius[la] >= in_b.radius[lb]))
        expand<true>(ca, make_single(in_b, lb, q_.X_AB_f, -towards_b_), e.b, cb);
      else
        expand<false>(cb, make_single(in_a, la, q_.X_BA_f, in_b_frame(towards_b_)), e.a, ca);
      if (done_) return;
    }
    flush();
  }

 private:
  /// Updates the search radius (float) from KernelQuery::best2. The factor 1.000001 covers the rounding of the conversion to float.
  void set_limit() {
    const double reach = __builtin_sqrt(q_.best2) * (q_.nearest.a >= 0 ? q_.shrink : 1.0);
    limit_ = static_cast<float>(reach) * 1.000001F + q_.slack;
    limit2_ = limit_ * limit_;
  }

  [[nodiscard]] Vec3T<F1> in_b_frame(const Vec3T<F1>& v) const {
    const auto& R = q_.X_BA_f.R;
    return {F1(R[0][0]) * v.x + F1(R[0][1]) * v.y + F1(R[0][2]) * v.z, F1(R[1][0]) * v.x + F1(R[1][1]) * v.y + F1(R[1][2]) * v.z,
            F1(R[2][0]) * v.x + F1(R[2][1]) * v.y + F1(R[2][2]) * v.z};
  }

  /// Tests all lanes of a block against the bound s. Lanes that may be closer than the search radius are pushed on the stack, the closest
  /// on top. Pairs of leaves are passed to add_leaf().
  /// @param block_of_a true: the block belongs to tree a and the bound to tree b
  /// @param single, single_child index (as in KernelEntry) and BoundBlock::child of the bound s
  template <bool block_of_a>
  void expand(std::int32_t block_index, const Single& s, std::int32_t single, std::int32_t single_child) {
    const BoundBlock& block = (block_of_a ? q_.a : q_.b).blocks[block_index];
    float gap2[block_lanes];
    unsigned close = 0;
    const Floats reach(limit_ + s.radius.v);
    for (int i = 0; i < block_lanes; i += Floats::count) {
      const Vec3T<Floats> apart = load3<Floats>(block.sphere, i) - spread<Floats>(s.sphere);
      const Floats r = reach + Floats::load(block.radius + i);
      unsigned strip = bits(dot(apart, apart) < r * r);
      if (strip != 0) {
        Vec3T<Floats> axis[3] = {load3<Floats>(block.axis[0], i), load3<Floats>(block.axis[1], i), {}};
        axis[2] = cross(axis[0], axis[1]);
        const Floats half[3] = {Floats::load(block.half[0] + i), Floats::load(block.half[1] + i), Floats::load(block.half[2] + i)};
        const Vec3T<Floats> box = load3<Floats>(block.box, i);
        const Floats along = gap_along<Floats>(s, box, axis, half);
        strip &= bits(along < Floats(limit_));
        if (strip != 0) {
          const Floats g = box_gap2<Floats>(s, box, axis, half);
          g.store(gap2 + i);
          strip &= bits(g < Floats(limit2_)) & ~bits(beyond_along_centres<Floats>(s, box, axis, half, Floats(limit_)));
        }
      }
      close |= strip << i;
    }
    q_.bound_tests += block.count;
    close &= (1U << block.count) - 1;
    const std::int32_t first = top_;
    for (; close != 0; close &= close - 1) {
      const int lane = __builtin_ctz(close);
      const std::int32_t child = block.child[lane];
      if (child < 0 && single_child < 0) {
        add_leaf(block_of_a ? KernelPair{-1 - child, -1 - single_child} : KernelPair{-1 - single_child, -1 - child}, gap2[lane]);
        if (done_) return;
        continue;
      }
      const std::int32_t id = block_index * block_lanes + lane;
      std::int32_t at = top_++;
      for (; at > first && q_.stack[at - 1].gap2 < gap2[lane]; --at) q_.stack[at] = q_.stack[at - 1];
      q_.stack[at] = {block_of_a ? id : single, block_of_a ? single : id, gap2[lane]};
    }
  }

  /// Collects a pair of triangles, and tests the collected pairs when there are leaf_room of them.
  void add_leaf(KernelPair pair, float gap2) {
    leaves_[leaf_count_] = pair;
    leaf_gap2_[leaf_count_] = gap2;
    if (++leaf_count_ == leaf_room) flush();
  }

  /// Tests the collected pairs of triangles whose bounds are still closer than the search radius.
  void flush() {
    int kept = 0;
    for (int i = 0; i < leaf_count_; ++i)
      if (leaf_gap2_[i] < limit2_) leaves_[kept++] = leaves_[i];
    leaf_count_ = 0;
    for (int i = 0; i < kept && !done_; i += Doubles::count) test_leaves(i, kept - i < Doubles::count ? kept - i : Doubles::count);
  }

  /// Measures the distances between the triangles of `count` pairs, starting at leaves_[first], one pair per lane.
  void test_leaves(int first, int count) {
    double corners[18][Doubles::count];
    for (int lane = 0; lane < Doubles::count; ++lane) {
      const KernelPair pair = leaves_[first + (lane < count ? lane : 0)];
      const std::int32_t *ta = q_.a.triangles + 3 * static_cast<std::ptrdiff_t>(pair.a),
                         *tb = q_.b.triangles + 3 * static_cast<std::ptrdiff_t>(pair.b);
      for (int k = 0; k < 3; ++k)
        for (int i = 0; i < 3; ++i) {
          corners[3 * k + i][lane] = q_.a.vertices[3 * static_cast<std::ptrdiff_t>(ta[k]) + i];
          corners[9 + 3 * k + i][lane] = q_.b.vertices[3 * static_cast<std::ptrdiff_t>(tb[k]) + i];
        }
    }
    Vec3T<Doubles> p[3], q[3];
    for (int k = 0; k < 3; ++k) {
      p[k] = {Doubles::load(corners[3 * k]), Doubles::load(corners[3 * k + 1]), Doubles::load(corners[3 * k + 2])};
      const Doubles x = Doubles::load(corners[9 + 3 * k]), y = Doubles::load(corners[10 + 3 * k]), z = Doubles::load(corners[11 + 3 * k]);
      const auto row = [&](int i) {
        return Doubles(q_.X_AB.R[i][0]) * x + Doubles(q_.X_AB.R[i][1]) * y + Doubles(q_.X_AB.R[i][2]) * z + Doubles(q_.X_AB.p[i]);
      };
      q[k] = {row(0), row(1), row(2)};
    }
    q_.triangle_tests += count;
    const Doubles best(q_.best2);
    const Doubles d2 = closest_points<false>(p, q, best).d2;
    unsigned closer = bits(d2 < best) & ((1U << count) - 1);
    if (closer == 0) return;
    double each[Doubles::count];
    d2.store(each);
    for (; closer != 0; closer &= closer - 1) {
      const int lane = __builtin_ctz(closer);
      if (q_.pairs != nullptr) {
        if (q_.found == q_.room) done_ = true;
        if (!done_) q_.pairs[q_.found] = leaves_[first + lane];
        ++q_.found;
        if (done_) return;
      } else if (each[lane] < q_.best2) {
        q_.best2 = each[lane];
        q_.nearest = leaves_[first + lane];
        set_limit();
      }
    }
    if (q_.pairs == nullptr && q_.best2 == 0) done_ = true;
  }

  static constexpr int leaf_room = 8;
  KernelQuery& q_;
  Vec3T<F1> towards_b_;           // unit or zero, a's frame: KernelQuery::towards_b
  float limit_ = 0, limit2_ = 0;  // m: search radius for bounds, including the slack; m^2: its square
  std::int32_t top_ = 0;          // count of entries on the stack
  int leaf_count_ = 0;
  KernelPair leaves_[leaf_room];
  float leaf_gap2_[leaf_room];  // m^2: lower bound of the squared distance for each pair in leaves_
  bool done_ = false;           // true: `pairs` is full, or the closest pair has distance 0
};

void search(KernelQuery& query) { Search(query).run(); }

}  // namespace

namespace UGOKI_WIDTH {
extern const BubbleKernel bubble_table;
const BubbleKernel bubble_table = {search};
}  // namespace UGOKI_WIDTH

}  // namespace ugoki::collision
