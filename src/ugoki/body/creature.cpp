#include "ugoki/body/creature.h"

#include <algorithm>
#include <map>
#include <span>

#include "ugoki/base/number.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::body {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// kg/m^3: mass of a four-legged mammal divided by the cube of the distance between hips and shoulders. Examples: cat, 4 kg and 0.27 m
// (200); shepherd dog, 32 kg and 0.53 m (215); horse, 540 kg and 1.25 m (276; Buchner et al. 1997); rat, 0.3 kg and 0.10 m (300).
constexpr double mass_per_trunk = 235;
constexpr double gravity = 9.81;

/// Radius of a link of a four-legged animal as a share of the trunk's length, and its share of the body's mass (both sides together).
struct PartShape {
  Part part;
  double radius, mass;
};
// Masses: means of dogs (Jones et al. 2018) and horses (Buchner et al. 1997), rounded; the tail's share is our own estimate.
constexpr PartShape four_legged[] = {
    {Part::pelvis, 0.15, 0.12}, {Part::trunk, 0.19, 0.46},     {Part::neck, 0.11, 0.07},       {Part::head, 0.10, 0.055},
    {Part::hip, 0.08, 0.0},     {Part::thigh, 0.085, 0.12},    {Part::shank, 0.05, 0.034},     {Part::foot, 0.032, 0.014},
    {Part::toes, 0.032, 0.006}, {Part::shoulder, 0.07, 0.035}, {Part::upper_arm, 0.07, 0.044}, {Part::forearm, 0.042, 0.022},
    {Part::hand, 0.030, 0.008}, {Part::fingers, 0.030, 0.006}, {Part::thumb, 0.02, 0.0},       {Part::other, 0.03, 0.006}};

// Birds: a heavy trunk, light wings and legs (shares rounded from dissections of pigeons and starlings; the wings are 10 to 20 % of the
// mass).
constexpr PartShape winged[] = {
    {Part::pelvis, 0.35, 0.22}, {Part::trunk, 0.42, 0.42},    {Part::neck, 0.14, 0.04},      {Part::head, 0.18, 0.04},
    {Part::hip, 0.08, 0.0},     {Part::thigh, 0.11, 0.06},    {Part::shank, 0.06, 0.03},     {Part::foot, 0.035, 0.01},
    {Part::toes, 0.03, 0.006},  {Part::shoulder, 0.07, 0.02}, {Part::upper_arm, 0.06, 0.06}, {Part::forearm, 0.05, 0.04},
    {Part::hand, 0.035, 0.02},  {Part::fingers, 0.025, 0.02}, {Part::thumb, 0.02, 0.0},      {Part::other, 0.03, 0.01}};

/// Mass [kg] of a bird from its wing span [m]: span = 1.165 m (mass / kg)^0.394 (Pennycuick 2008, Modelling the Flying Bird).
double bird_mass(double span) { return ugoki::exp(ugoki::log(span / 1.165) / 0.394); }

const char* word_of(Part part, bool fore) {
  switch (part) {
    case Part::pelvis: return "pelvis";
    case Part::neck: return "neck";
    case Part::head: return "head";
    case Part::hip: return "hip";
    case Part::thigh: return "thigh";
    case Part::shank: return "shank";
    case Part::foot: return "hock";
    case Part::toes: return "paw hind";
    case Part::shoulder: return "scapula";
    case Part::upper_arm: return "upper arm";
    case Part::forearm: return "forearm";
    case Part::hand: return "carpus";
    case Part::fingers: return fore ? "paw fore" : "paw hind";
    default: return "";
  }
}

class Maker {
 public:
  Maker(const Character& f, const MeasuredMotion& m, const BodyOptions& o) : f_(f), m_(m), o_(o), n_(m.joint_count()) {}

  Creature run() {
    p_ = rest_positions(m_.skeleton);
    out_.links.resize(at(n_));
    find_bones();
    find_extent();
    find_followers();
    make_shapes();
    add_pads();
    if (four_legs()) thin_sunken_shapes();
    find_masses();
    protect_small_links();
    find_strengths();
    return std::move(out_);
  }

 private:
  [[nodiscard]] int parent(int i) const { return m_.skeleton.joints[at(i)].parent; }
  [[nodiscard]] bool four_legs() const { return f_.plan == BodyPlan::four_legs; }
  /// True if the parts of the body are known; masses and radii then come from a table.
  [[nodiscard]] bool known() const { return four_legs() || f_.winged; }
  [[nodiscard]] SidedPart part(int i) const { return known() ? f_.parts[at(i)] : SidedPart{}; }
  [[nodiscard]] std::span<const PartShape> table() const {
    return f_.winged ? std::span<const PartShape>(winged) : std::span<const PartShape>(four_legged);
  }
  [[nodiscard]] const PartShape& shape_of(Part wanted) const {
    for (const PartShape& s : table())
      if (s.part == wanted) return s;
    return table().back();
  }
  CreatureLink& link(int i) { return out_.links[at(i)]; }

  void find_bones() {
    bones_.resize(at(n_));
    for (int i = 0; i < n_; ++i) {
      for (const Vec3& e : m_.skeleton.joints[at(i)].end_sites) bones_[at(i)].push_back(e);
      const bool free = !f_.free.empty() && f_.free[at(i)] != 0;
      if (parent(i) >= 0 && !free) bones_[at(parent(i))].push_back(m_.skeleton.joints[at(i)].offset);
    }
  }

  void find_extent() {
    double low = 1e300, high = -1e300;
    Vec3 box_low{1e300, 1e300, 1e300}, box_high = box_low * -1.0;
    const auto add = [&](const Vec3& p) {
      low = std::min(low, p.z);
      high = std::max(high, p.z);
      for (int k = 0; k < 3; ++k) {
        box_low[k] = std::min(box_low[k], p[k]);
        box_high[k] = std::max(box_high[k], p[k]);
      }
    };
    const auto is_apart = [&](int i) { return parent(i) < 0 && children(i) == 0; };
    bool all_apart = true;
    for (int i = 0; i < n_; ++i) all_apart = all_apart && is_apart(i);
    for (int i = 0; i < n_; ++i) {
      if (is_apart(i) && !all_apart) continue;
      add(p_[at(i)]);
      for (const Vec3& e : m_.skeleton.joints[at(i)].end_sites) add(p_[at(i)] + e);
    }
    // A joint without bones has no size; it becomes a ball of 10 cm.
    const double extent = norm(box_high - box_low);
    size_ = extent > 1e-6 ? extent : 4;
    out_.height = o_.height > 0 ? o_.height : extent > 1e-6 ? std::max(high - low, 1e-4) : 0.1;
  }
  [[nodiscard]] int children(int i) const {
    return static_cast<int>(std::ranges::count_if(m_.skeleton.joints, [&](const SkeletonJoint& j) { return j.parent == i; }));
  }

  /// Marks the joints whose links get no mass: helpers, and ends whose bone and offset are tiny.
  void find_followers() {
    for (int i = n_ - 1; i >= 0; --i) {
      bool only_followers = true;
      for (int c = i + 1; c < n_; ++c)
        if (parent(c) == i) only_followers = only_followers && link(c).follows;
      if (parent(i) < 0 || !only_followers) continue;
      double bone = 0;
      for (const Vec3& b : bones_[at(i)]) bone = std::max(bone, norm(b));
      const bool end = bone < 0.012 * size_;
      link(i).follows = (!f_.helper.empty() && f_.helper[at(i)] != 0) || (end && parent(i) >= 0);
    }
  }

  void make_shapes() {
    const double minimum = std::max(0.004 * size_, 1e-4);
    // Number of ends below each joint: bones with several ends behind them are those of the trunk.
    std::vector<int> ends(at(n_), 0);
    for (int i = n_ - 1; i >= 0; --i) {
      if (!link(i).follows && ends[at(i)] == 0) ends[at(i)] = 1;
      if (parent(i) >= 0) ends[at(parent(i))] += ends[at(i)];
    }
    const bool branched = std::ranges::any_of(ends, [](int e) { return e > 2; });
    const auto radius_of = [&](int i, const Vec3& bone) {
      const double length = norm(bone);
      if (!branched) return std::clamp(0.1 * length, 0.006 * size_, 0.04 * size_);
      for (int c = i + 1; c < n_; ++c)
        if (parent(c) == i && norm(m_.skeleton.joints[at(c)].offset - bone) < 1e-12 && ends[at(c)] > 1)
          return std::clamp(0.25 * length, 0.03 * size_, 0.06 * size_);
      return std::clamp(0.08 * length, 0.006 * size_, 0.025 * size_);
    };
    for (int i = 0; i < n_; ++i) {
      CreatureLink& l = link(i);
      set_label(i);
      if (l.follows) continue;
      double radius = 0;
      if (known()) radius = shape_of(part(i).part).radius * f_.trunk_length;
      for (std::size_t k = 0; k < bones_[at(i)].size(); ++k) {
        const Vec3& b = bones_[at(i)][k];
        const double length = norm(b);
        if (length < 0.01 * size_) continue;
        double r = known() ? std::min(radius, 0.6 * length + 0.2 * radius) : radius_of(i, b);
        r = std::max(r, minimum);
        l.shapes.push_back(Shape::capsule(r, {}, b));
      }
      if (l.shapes.empty()) l.shapes.push_back(Shape::sphere(std::max(minimum, known() ? 0.6 * radius : 0.012 * size_)));
      for (const Shape& s : l.shapes) l.inertia += solid_inertia(s, 1000);
    }
  }

  /// Leaves only the poses in which the animal stands.
  void keep_standing(std::vector<std::vector<Pose>>& poses) {
    std::vector<double> heights;
    for (const auto& X : poses) {
      double low = 1e300;
      for (int i = 0; i < n_; ++i)
        if (!link(i).follows)
          for (const Vec3& b : bones_[at(i)]) low = std::min(low, (X[at(i)] * b).z);
      heights.push_back(X[0].p.z - low);
    }
    const std::vector<char> stands = usually_stands(heights);
    std::size_t kept = 0;
    for (std::size_t k = 0; k < poses.size(); ++k)
      if (stands[k] != 0) std::swap(poses[kept++], poses[k]);
    poses.resize(kept);
  }

  /// Adds a pad to each end of the tree that comes close to the floor. The pads reach down to the floor, so that all feet stand on one
  /// level although their joints are at different heights. The floor is a level plane below the lowest end.
  void add_pads() {
    if (m_.frames == 0) return;
    struct End {
      int joint = -1, link = -1;  // the end's joint; the link that carries the pad
      Vec3 tip;                   // m, in the link's frame
      double level = 0, radius = 0;
      Vec3 up;  // unit, in the link's frame, while the end is low
    };
    std::vector<End> ends;
    std::vector<Pose> X;
    const int step = std::max(1, m_.frames / 240);
    std::vector<std::vector<Pose>> poses;
    for (int f = 0; f < m_.frames; f += step) {
      m_.calc_joint_poses(f, X);
      poses.push_back(X);
    }
    if (four_legs()) keep_standing(poses);
    for (int i = 0; i < n_; ++i) {
      bool last = true;  // the joint has no child with mass
      for (int c = i + 1; c < n_; ++c)
        if (parent(c) == i) last = last && link(c).follows;
      // A body without legs lies on its belly: every joint can touch the floor.
      if ((!last && f_.pelvis >= 0) || link(i).follows || bones_[at(i)].empty()) continue;
      End e;
      e.joint = e.link = i;
      for (const Vec3& b : bones_[at(i)])
        if (norm(b) > norm(e.tip)) e.tip = b;
      e.radius = 1e300;
      for (const Shape& s : link(i).shapes) e.radius = std::min(e.radius, s.radius);
      std::vector<double> heights;
      for (const auto& pose : poses) heights.push_back((pose[at(i)] * e.tip).z);
      std::vector<double> sorted = heights;
      const auto low = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 10);
      std::nth_element(sorted.begin(), low, sorted.end());
      e.level = *low;
      for (std::size_t k = 0; k < poses.size(); ++k)
        if (heights[k] <= e.level + 0.01 * size_) e.up += transpose_times(poses[k][at(i)].R, Vec3{0, 0, 1});
      e.up = normalized(e.up);
      ends.push_back(e);
    }
    if (ends.empty()) return;
    // The floor is the level that the lowest of all shapes reaches in a tenth of the frames. A four-legged animal stands on its paws: its
    // tail or head may be measured below them.
    const auto is_paw = [&](int i) {
      const Part own = part(i).part;
      return own == Part::foot || own == Part::toes || own == Part::hand || own == Part::fingers;
    };
    // A paw without a bone of its own follows the link above it, which then stands on the floor.
    const auto stands = [&](int i) {
      bool paw = is_paw(i);
      for (int c = i + 1; c < n_; ++c) paw = paw || (parent(c) == i && link(c).follows && is_paw(c));
      return paw;
    };
    bool has_paws = false;
    for (int i = 0; i < n_; ++i) has_paws = has_paws || (stands(i) && !link(i).shapes.empty());
    double floor = 1e300;
    std::vector<double> lows;
    for (int i = 0; i < n_; ++i)
      for (const Shape& s : link(i).shapes) {
        if (four_legs() && has_paws && !stands(i)) continue;
        for (const double end : {-1.0, 1.0}) {
          const Vec3 p = s.X_BS * Vec3{0, 0, end * s.half_length};
          lows.clear();
          for (const auto& pose : poses) lows.push_back((pose[at(i)] * p).z - s.radius);
          const auto low = lows.begin() + static_cast<std::ptrdiff_t>(lows.size() / 10);
          std::nth_element(lows.begin(), low, lows.end());
          floor = std::min(floor, *low);
        }
      }
    floor_ = floor;
    for (const End& e : ends) {
      const double gap = e.level - e.radius - floor;
      // The last joint of a paw can be an ankle: many rigs have no joint below it.
      const double longest = four_legs() && stands(e.joint) ? 0.2 : 0.12;
      if (gap < 1e-4 * size_ || gap > longest * out_.height) continue;
      link(e.link).shapes.push_back(Shape::capsule(e.radius, e.tip, e.tip - e.up * gap));
    }
  }

  /// Thins the shapes that the measured motion puts below the floor (the trunk of an animal that lies). A shape whose axis is below the
  /// floor does not collide. Masses do not change, because the animal is as heavy as it is.
  void thin_sunken_shapes() {
    if (floor_ < -1e299) return;
    std::vector<Pose> X;
    std::vector<std::vector<Pose>> poses;
    for (int f = 0, step = std::max(1, m_.frames / 240); f < m_.frames; f += step) {
      m_.calc_joint_poses(f, X);
      poses.push_back(X);
    }
    std::vector<double> lows;
    for (int i = 0; i < n_; ++i) {
      const Part own = part(i).part;
      if (own == Part::foot || own == Part::toes || own == Part::hand || own == Part::fingers) continue;  // these stand on the floor
      for (Shape& s : link(i).shapes) {
        if (s.type != ShapeType::capsule && s.type != ShapeType::sphere) continue;
        lows.clear();
        for (const auto& pose : poses)
          lows.push_back(
              std::min((pose[at(i)] * (s.X_BS * Vec3{0, 0, -s.half_length})).z, (pose[at(i)] * (s.X_BS * Vec3{0, 0, s.half_length})).z));
        const auto low = lows.begin() + static_cast<std::ptrdiff_t>(lows.size() / 50);
        std::nth_element(lows.begin(), low, lows.end());
        const double clearance = *low - floor_;
        if (clearance >= s.radius - 0.01 * out_.height) continue;
        if (clearance > 0.3 * s.radius)
          s.radius = clearance;
        else
          s.collides = false;
      }
    }
  }

  void set_label(int i) {
    if (!four_legs()) return;
    const SidedPart own = part(i);
    std::string word = word_of(own.part, true);
    if (const auto tail = std::ranges::find(f_.tail, i); tail != f_.tail.end()) {
      const auto rank = tail - f_.tail.begin();
      link(i).label = rank == 0 ? "tail" : "tail " + std::to_string(rank + 1);
      return;
    }
    if (own.part == Part::trunk) {
      const auto place = std::ranges::find(f_.trunk, i);
      if (place == f_.trunk.end()) return;
      word = i == f_.chest ? "chest" : place == f_.trunk.begin() + 1 ? "abdomen" : "back";
    }
    if (word.empty()) return;
    const int count = ++used_[word + std::to_string(own.side)];
    if (count > 1) word += " " + std::to_string(count);
    if (own.side != 0) word += own.side > 0 ? " left" : " right";
    link(i).label = word;
  }

  void find_masses() {
    double sum = 0;
    for (const CreatureLink& l : out_.links) sum += l.inertia.mass;
    double total = sum;
    if (known()) {
      const double length = f_.trunk_length;
      total = f_.winged ? bird_mass(wing_span()) : mass_per_trunk * length * length * length;
      // Each part gets its share of the mass. Within a part the mass is distributed in proportion to the volumes of the links.
      std::vector<double> volume(table().size(), 0.0);
      const auto group = [&](int i) { return static_cast<std::size_t>(&shape_of(part(i).part) - table().data()); };
      for (int i = 0; i < n_; ++i) volume[group(i)] += link(i).inertia.mass;
      double shares = 0;
      for (std::size_t g = 0; g < volume.size(); ++g) shares += volume[g] > 0 ? table()[g].mass : 0;
      for (int i = 0; i < n_; ++i) {
        const std::size_t g = group(i);
        if (volume[g] > 0) scale(link(i).inertia, total * std::max(1e-4, table()[g].mass) / shares / volume[g]);
      }
      sum = 0;
      for (const CreatureLink& l : out_.links) sum += l.inertia.mass;
    }
    if (o_.mass > 0) total = o_.mass;
    for (CreatureLink& l : out_.links) scale(l.inertia, total / sum);
    out_.mass = total;
    out_.notes.push_back(o_.mass > 0 ? "Mass " + to_text_of(total) + " kg, as given."
                         : f_.winged
                             ? "Mass " + to_text_of(total) + " kg, estimated from the wing span of " + to_fixed(wing_span(), 3) + " m."
                         : four_legs() ? "Mass " + to_text_of(total) + " kg, estimated from the trunk of " + to_fixed(f_.trunk_length, 3) +
                                             " m between hips and shoulders."
                                       : "Mass " + to_text_of(total) + " kg: capsules of density 1000 kg/m^3 along the bones.");
  }
  /// Wing span [m]: the length of both stretched wings plus the distance between the shoulders.
  [[nodiscard]] double wing_span() const {
    double span = norm(p_[at(f_.arms[0].proximal)] - p_[at(f_.arms[1].proximal)]);
    for (const Limb& wing : f_.arms) {
      std::vector<double> reach(at(n_), -1.0);
      reach[at(wing.proximal)] = 0;
      double longest = 0;
      for (int i = wing.proximal; i < n_; ++i) {
        if (i != wing.proximal && parent(i) >= 0 && reach[at(parent(i))] >= 0)
          reach[at(i)] = reach[at(parent(i))] + norm(p_[at(i)] - p_[at(parent(i))]);
        longest = std::max(longest, reach[at(i)]);
      }
      span += longest;
    }
    return span;
  }
  static std::string to_text_of(double kilograms) { return to_fixed(kilograms, kilograms < 1 ? 3 : 1); }
  static void scale(Inertia& i, double factor) { i = {i.mass * factor, i.h * factor, i.I * factor}; }

  /// Gives very light links at least a small share of mass and moment of inertia. Links far lighter than the body make the equations of
  /// motion ill-conditioned.
  void protect_small_links() {
    const double min_mass = 1e-3 * out_.mass, min_link_moment = 1e-3 * out_.mass * 0.0004 * size_ * size_;
    double sum = 0;
    for (CreatureLink& l : out_.links) {
      if (l.follows) continue;
      if (l.inertia.mass < min_mass) scale(l.inertia, min_mass / std::max(l.inertia.mass, 1e-300));
      const Sym3 c = l.inertia.about_centre();
      const double lack = std::max(0.0, min_link_moment - std::min({c.xx, c.yy, c.zz}));
      l.inertia.I = l.inertia.I + Sym3{lack, lack, lack, 0, 0, 0};
      sum += l.inertia.mass;
    }
    for (CreatureLink& l : out_.links)
      if (!l.follows) scale(l.inertia, out_.mass / sum);
  }

  /// Sets the strength of the joints. Joints that carry others can bear the body's weight at their lever. The stress of muscles does not
  /// depend on the size of an animal, so torques per mass do not either (A. V. Hill 1950): those of small animals have the lever of a
  /// person. Time constants follow from the size: sqrt(height / g).
  void find_strengths() {
    const double lever = std::max(out_.height, 0.25 * size_);
    constexpr double person = 1.7;  // m
    const double moment = out_.mass * gravity * lever, strength = out_.mass * gravity * std::max(lever, person);
    const double time = std::sqrt(lever / gravity);
    std::vector<double> behind(at(n_), 0);
    for (int i = n_ - 1; i >= 0; --i) {
      behind[at(i)] += link(i).inertia.mass;
      if (parent(i) >= 0) behind[at(parent(i))] += behind[at(i)];
    }
    for (int i = 0; i < n_; ++i) {
      const double share = std::clamp(std::sqrt(behind[at(i)] / out_.mass), 0.1, 1.0);
      link(i).strength = strength;
      link(i).damping = 0.004 * share * moment * time;
      link(i).armature = 2e-4 * share * out_.mass * lever * lever;
    }
  }

  const Character& f_;
  const MeasuredMotion& m_;
  const BodyOptions& o_;
  int n_;
  std::vector<Vec3> p_;
  std::vector<std::vector<Vec3>> bones_;  // [joints] m
  double size_ = 0;                       // m
  double floor_ = -1e300;                 // m, level of the floor; below -1e299: unknown
  std::map<std::string, int> used_;
  Creature out_;
};

}  // namespace

std::vector<char> usually_stands(const std::vector<double>& heights) {
  constexpr double share = 0.75;
  std::vector<double> sorted = heights;
  const auto high = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() * 9 / 10);
  std::nth_element(sorted.begin(), high, sorted.end());
  std::vector<char> stands;
  for (const double h : heights) stands.push_back(h >= share * *high ? 1 : 0);
  if (static_cast<std::size_t>(std::ranges::count(stands, 1)) * 10 < heights.size()) stands.assign(heights.size(), 1);
  return stands;
}

Creature make_creature(const Character& character, const MeasuredMotion& motion, const BodyOptions& options) {
  return Maker(character, motion, options).run();
}

}  // namespace ugoki::body
