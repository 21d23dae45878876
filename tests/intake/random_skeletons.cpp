#include "random_skeletons.h"

#include <algorithm>
#include <array>

#include "../body/measured_files.h"

namespace ugoki::testing {
namespace {

constexpr std::array names = {"Hips",       "pelvis",   "LeftUpLeg", "RightUpLeg", "LeftLeg", "RightLeg", "LeftFoot", "RightFoot",
                              "Spine",      "Chest",    "Neck",      "Head",       "LeftArm", "RightArm", "LeftHand", "RightHand",
                              "l_clavicle", "r_collar", "lthumb",    "rthumb",     "",        "",         "joint",    "joint 2",
                              "joint",      "mixamo:a", ":",         " ",          "l",       "left",     "World",    "\xE8\x85\xB0",
                              "name\"\\",   "LeftToes", "RightToes", "tail",       "wrist",   "roll",     "head_l",   "head_r"};

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Builds one random motion.
class Maker {
 public:
  explicit Maker(std::uint64_t seed) : random_(seed) {}

  MeasuredMotion run() {
    if (random_.chance(0.5))
      make_human();
    else
      make_tree();
    m_.rate = random_.chance(0.9) ? 60 : random_.between(0.01, 1e4);
    m_.skeleton.mass = random_.chance(0.3) ? random_.between(0, 200) : 0;
    if (random_.chance(0.1)) m_.name = "";
    return std::move(m_);
  }

 private:
  /// A length [m]: mostly ordinary, sometimes zero, tiny or huge.
  double length() {
    const double kind = random_.uniform();
    if (kind < 0.08) return 0;
    if (kind < 0.10) return 1e-300;
    if (kind < 0.13) return random_.between(-1e-9, 1e-9);
    if (wild_ && kind < 0.15) return random_.chance(0.5) ? 1e150 : -1e300;
    if (wild_ && kind < 0.25) return random_.between(-1e6, 1e6);
    return random_.between(-0.5, 0.5);
  }
  Vec3 offset() {
    if (random_.chance(0.15)) return {};
    return {length(), length(), length()};
  }
  Vec3 direction() {
    if (random_.chance(0.7)) {
      Vec3 e{};
      e[random_.below(3)] = random_.chance(0.2) ? -1 : 1;
      return e;
    }
    return normalized(Vec3{random_.between(-1, 1), random_.between(-1, 1), random_.between(-1, 1)}, {0, 0, 1});
  }
  Quat rotation() {
    const double kind = random_.uniform();
    if (kind < 0.2) return {};
    if (kind < 0.3) return exp_map(direction() * pi);
    if (kind < 0.4) return exp_map(direction() * 1e-9);
    return exp_map(direction() * random_.between(-3.2, 3.2));
  }
  SkeletonJoint joint(int parent) {
    SkeletonJoint j;
    j.name = names[at(random_.below(static_cast<int>(names.size())))];
    j.parent = parent;
    j.offset = offset();
    for (int k = random_.below(3); k > 0 && random_.chance(0.3); --k) j.end_sites.push_back(offset());
    set_dofs(j);
    return j;
  }
  void set_dofs(SkeletonJoint& j) {
    j.dofs.clear();
    for (int k = random_.below(4); k > 0; --k) {
      MeasuredDof dof{direction()};
      dof.limited = random_.chance(0.2);
      if (dof.limited) {
        dof.lower = random_.between(-3, 0);
        dof.upper = random_.chance(0.1) ? dof.lower : random_.between(0, 3);
      }
      j.dofs.push_back(dof);
    }
    j.translates = random_.chance(j.parent < 0 ? 0.8 : 0.1);
  }

  void make_tree() {
    wild_ = random_.chance(0.4);
    m_.name = "tree";
    const int count = 1 + random_.below(random_.chance(0.5) ? 5 : 25);
    const double chain = random_.uniform(), roots = random_.chance(0.3) ? 0.3 : 0;
    for (int i = 0; i < count; ++i) {
      const int parent = i == 0 || random_.chance(roots) ? -1 : random_.chance(chain) ? i - 1 : random_.below(i);
      m_.skeleton.joints.push_back(joint(parent));
    }
    m_.frames = random_.below(6);
    const int motion = random_.below(3);  // 0: constant, 1: some joints move, 2: all joints move
    for (int f = 0; f < m_.frames; ++f)
      for (int i = 0; i < count; ++i) {
        const SkeletonJoint& j = m_.skeleton.joints[at(i)];
        const bool moves = motion == 2 || (motion == 1 && i % 3 == 0);
        m_.translations.push_back(f == 0 || !moves ? j.offset : j.translates ? offset() : j.offset);
        m_.rotations.push_back(f > 0 && !moves ? m_.rotations[at(i)] : rotation());
      }
  }

  void make_human() {
    wild_ = random_.chance(0.1);
    m_ = body::testing::made_character(1 + random_.below(5), random_.between(-1, 1));
    if (random_.chance(0.3)) {
      const double factor = random_.chance(0.5) ? random_.between(0.2, 3) : std::array{1e-9, 1e-4, 1e3, 1e6}[at(random_.below(4))];
      for (SkeletonJoint& j : m_.skeleton.joints) {
        j.offset *= factor;
        for (Vec3& e : j.end_sites) e *= factor;
      }
      for (Vec3& t : m_.translations) t *= factor;
    }
    for (int k = random_.below(6); k > 0; --k) change();
    if (random_.chance(0.05)) {
      m_.frames = 0;
      m_.translations.clear();
      m_.rotations.clear();
    }
  }

  /// Makes one random change of the skeleton and of all frames.
  void change() {
    const int n = m_.joint_count(), i = random_.below(n);
    SkeletonJoint& j = m_.skeleton.joints[at(i)];
    switch (random_.below(9)) {
      case 0:
      case 1: return insert(random_.chance(0.3) ? 0 : random_.below(n + 1));
      case 2: j.name = names[at(random_.below(static_cast<int>(names.size())))]; return;
      case 3: {
        const Vec3 before = j.offset;
        j.offset = random_.chance(0.3) ? Vec3{} : before + offset() * 0.1;
        for (int f = 0; f < m_.frames; ++f) m_.translations[sample(f, i)] += j.offset - before;
        return;
      }
      case 4:
        for (int f = 0; f < m_.frames; ++f) m_.rotations[sample(f, i)] = rotation();
        return;
      case 5:
        for (int f = 0; f < m_.frames; ++f) m_.translations[sample(f, i)] += offset() * 0.1;
        j.translates = true;
        return;
      case 6: set_dofs(j); return;
      case 7:
        if (n > 1) remove_leaf(n - 1 - random_.below(std::min(n, 8)));
        return;
      default: j.end_sites.assign(at(random_.below(3)), offset()); return;
    }
  }
  [[nodiscard]] std::size_t sample(int frame, int joint) const { return at(frame) * m_.skeleton.joints.size() + at(joint); }

  void insert(int index) {
    SkeletonJoint added = joint(index == 0 || random_.chance(0.2) ? -1 : random_.below(index));
    auto& joints = m_.skeleton.joints;
    const int before = m_.joint_count();
    const bool above = index == 0 && random_.chance(0.6), still = random_.chance(0.3);
    joints.insert(joints.begin() + index, added);
    for (int i = index + 1; i <= before; ++i) {
      int& parent = joints[at(i)].parent;
      if (parent >= index) ++parent;
      if (parent < 0 && above) parent = 0;
    }
    for (int f = m_.frames - 1; f >= 0; --f) {
      const auto where = static_cast<std::ptrdiff_t>(f) * before + index;
      m_.translations.insert(m_.translations.begin() + where, still ? added.offset : offset());
      m_.rotations.insert(m_.rotations.begin() + where, still ? Quat{} : rotation());
    }
  }

  /// Removes joint i if it has no children.
  void remove_leaf(int i) {
    auto& joints = m_.skeleton.joints;
    if (std::ranges::any_of(joints, [i](const SkeletonJoint& j) { return j.parent == i; })) return;
    const int before = m_.joint_count();
    joints.erase(joints.begin() + i);
    for (SkeletonJoint& j : joints)
      if (j.parent > i) --j.parent;
    for (int f = m_.frames - 1; f >= 0; --f) {
      const auto where = static_cast<std::ptrdiff_t>(f) * before + i;
      m_.translations.erase(m_.translations.begin() + where);
      m_.rotations.erase(m_.rotations.begin() + where);
    }
  }

  RandomNumbers random_;
  MeasuredMotion m_;
  bool wild_ = false;
};

}  // namespace

std::uint64_t RandomNumbers::next() {
  std::uint64_t z = (state_ += 0x9e3779b97f4a7c15);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
  z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
  return z ^ (z >> 31);
}

MeasuredMotion random_skeleton(std::uint64_t seed) { return Maker(seed).run(); }

}  // namespace ugoki::testing
