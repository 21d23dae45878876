// Converts the skeletons of a USD file to a measured motion.

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "ugoki/base/number.h"
#include "ugoki/formats/text.h"
#include "ugoki/scene_formats/scene_joints.h"
#include "ugoki/scene_formats/usd.h"
#include "ugoki/scene_formats/usda_layer.h"

namespace ugoki::scene_formats {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

Vec3 vec_at(const std::vector<double>& x, std::size_t i) { return {x[3 * i], x[3 * i + 1], x[3 * i + 2]}; }

/// Matrix number i of a list of 4 x 4 matrices. USD multiplies row vectors, so that the first three rows are the images of the axes.
Affine matrix_at(const std::vector<double>& x, std::size_t i) {
  const double* m = &x[16 * i];
  return {Mat3::columns({m[0], m[1], m[2]}, {m[4], m[5], m[6]}, {m[8], m[9], m[10]}), {m[12], m[13], m[14]}};
}

/// The value of an attribute at a time code, linearly interpolated between its samples.
/// @param spherical true: the elements are quaternions (w x y z), which are interpolated along the shorter arc
std::vector<double> sampled(const UsdAttribute& a, double time, bool spherical = false) {
  if (a.samples.empty()) return a.value ? a.value->numbers : std::vector<double>();
  const auto after = std::ranges::upper_bound(a.samples, time, {}, [](const auto& sample) { return sample.first; });
  if (after == a.samples.begin()) return a.samples.front().second.numbers;
  const auto& [before_time, before] = *(after - 1);
  if (after == a.samples.end() || before.numbers.size() != after->second.numbers.size()) return before.numbers;
  const std::vector<double>& next = after->second.numbers;
  const double s = (time - before_time) / (after->first - before_time);
  std::vector<double> out = before.numbers;
  if (!spherical) {
    for (std::size_t i = 0; i < out.size(); ++i) out[i] += (next[i] - out[i]) * s;
    return out;
  }
  for (std::size_t i = 0; i + 3 < out.size(); i += 4) {
    const Quat q = slerp(normalized(Quat{out[i], out[i + 1], out[i + 2], out[i + 3]}),
                         normalized(Quat{next[i], next[i + 1], next[i + 2], next[i + 3]}), s);
    out[i] = q.w;
    out[i + 1] = q.x;
    out[i + 2] = q.y;
    out[i + 3] = q.z;
  }
  return out;
}

/// Number of numbers of a transformation; 0: not a kind that USD knows.
std::size_t width_of(std::string_view kind) {
  if (kind == "transform") return 16;
  if (kind == "orient") return 4;
  if (kind == "translate" || kind == "scale") return 3;
  if (!kind.starts_with("rotate")) return 0;
  const std::string_view axes = kind.substr(6);
  if (axes.find_first_not_of("XYZ") != std::string_view::npos) return 0;
  return axes.size() == 1 || axes.size() == 3 ? axes.size() : 0;
}

/// One step of a prim's transformation stack.
struct TransformStep {
  const UsdAttribute* attribute = nullptr;
  std::string kind;  ///< "translate", "rotateXYZ", "orient", ...
  bool inverted = false;
};

/// The skeleton of one Skeleton prim and its animation.
struct UsdSkeleton {
  int prim = 0;
  std::size_t first = 0;            ///< index of its first joint among all joints
  std::vector<int> parents;         ///< [joints] index in this skeleton; -1: none
  std::vector<std::string> names;   ///< [joints]
  std::vector<std::size_t> listed;  ///< [joints] index in the file's order
  std::vector<Affine> rest;         ///< [joints] relative to the parent
  std::vector<Affine> bind;         ///< [joints] in the skeleton's frame
  int animation = -1;               ///< index of its prim; -1: none
  std::vector<int> animated;        ///< [joints] index in the animation's joints; -1: at rest
};

class UsdReader {
 public:
  UsdReader(const UsdLayer& layer, std::string_view file_name, const SceneOptions& options, formats::ReadNotes& notes)
      : layer_(layer), file_name_(file_name), options_(options), notes_(notes) {
    for (std::size_t i = 0; i < layer.prims.size(); ++i) index_.emplace(layer.prims[i].path, static_cast<int>(i));
  }

  Result<MeasuredMotion> read() {
    for (const UsdPrim& prim : layer_.prims) shown_.push_back(prim.defined && prim.active && (prim.parent < 0 || shown_[at(prim.parent)]));
    if (!read_stacks()) return fail(std::move(error_));
    for (std::size_t i = 0; i < layer_.prims.size(); ++i)
      if (shown_[i] && layer_.prims[i].type == "Skeleton" && !read_skeleton(static_cast<int>(i))) return fail(std::move(error_));
    if (skeletons_.empty()) choose_prims();
    if (count_ == 0)
      return fail(ErrorCode::structure, std::string(file_name_),
                  "The file has no skeleton with joints and no prim whose transformation is animated.",
                  layer_.refers ? "It refers to other files or prims: save it as one file (usdcat --flatten FILE -o NEW.usda)."
                                : "Export the skeleton with its motion.");
    if (count_ > formats::max_joints) {
      refuse(0, ErrorCode::range, "The file has more than 10000 joints.", "Export the skeleton only.");
      return fail(std::move(error_));
    }
    return motion();
  }

 private:
  bool refuse(int line, ErrorCode code, std::string message, std::string remedy) {
    error_.add(code, std::string(file_name_) + (line > 0 ? ":" + std::to_string(line) : ""), std::move(message), std::move(remedy));
    return false;
  }
  const UsdPrim& prim(int i) const { return layer_.prims[at(i)]; }
  [[nodiscard]] int find(const std::string& path) const {
    const auto found = index_.find(path);
    return found == index_.end() ? -1 : found->second;
  }

  /// Checks the number of numbers in each value of an attribute.
  bool check_length(const UsdAttribute& a, const std::string& name, std::size_t wanted, const std::string& reason) {
    std::size_t found = a.value ? a.value->numbers.size() : wanted;
    for (const auto& [time, sample] : a.samples)
      if (found == wanted) found = sample.numbers.size();
    return found == wanted || refuse(a.line, ErrorCode::structure,
                                     name + " has " + std::to_string(found) + " numbers, but " + reason + std::to_string(wanted) + ".",
                                     "Export the file again.");
  }

  /// Reads the transformation stacks of all prims.
  bool read_stacks() {
    for (const UsdPrim& p : layer_.prims) {
      std::vector<TransformStep>& stack = stacks_.emplace_back();
      resets_.push_back(false);
      const UsdAttribute* order = p.attribute("xformOpOrder");
      if (!order || !order->value) continue;
      for (const std::string& text : order->value->texts) {
        if (text == "!resetXformStack!") {
          stack.clear();
          resets_.back() = true;
          continue;
        }
        TransformStep step;
        step.inverted = text.starts_with("!invert!");
        const std::string name = step.inverted ? text.substr(8) : text;
        step.attribute = p.attribute(name);
        if (!step.attribute || !name.starts_with("xformOp:")) continue;
        step.kind = name.substr(8, name.find(':', 8) - 8);
        const std::size_t wanted = width_of(step.kind);
        if (wanted == 0)
          return refuse(step.attribute->line, ErrorCode::unsupported,
                        "The transformation " + formats::in_quotes(name) + " is not supported.",
                        "Use translate, rotate, orient, scale or transform.");
        if (!check_length(*step.attribute, name, wanted, "a transformation needs ")) return false;
        stack.push_back(std::move(step));
      }
    }
    return true;
  }

  static Affine transform_of(const TransformStep& step, double time) {
    const std::vector<double> x = sampled(*step.attribute, time, step.kind == "orient");
    if (x.empty()) return {};
    Affine out;
    if (step.kind == "translate") {
      out.p = vec_at(x, 0);
    } else if (step.kind == "scale") {
      out.M = Mat3::diagonal(x[0], x[1], x[2]);
    } else if (step.kind == "orient") {
      out.M = to_matrix(normalized(Quat{x[0], x[1], x[2], x[3]}));
    } else if (step.kind == "transform") {
      out = matrix_at(x, 0);
    } else if (step.kind.starts_with("rotate")) {  // rotateXYZ: first about X, then about Y and Z
      const std::string_view axes = std::string_view(step.kind).substr(6);
      for (std::size_t k = 0; k < axes.size() && k < x.size(); ++k) {
        const Vec3 axis{axes[k] == 'X' ? 1.0 : 0.0, axes[k] == 'Y' ? 1.0 : 0.0, axes[k] == 'Z' ? 1.0 : 0.0};
        out.M = rotation_about(axis, x[k] * pi / 180) * out.M;
      }
    }
    if (!step.inverted) return out;
    if (!(std::fabs(out.M.determinant()) > 1e-18)) return {};
    const Mat3 back = inverse(out.M);
    return {back, -(back * out.p)};
  }
  /// Transformation of a prim relative to its parent.
  [[nodiscard]] Affine local_of(int i, double time) const {
    Affine out;
    for (const TransformStep& step : stacks_[at(i)]) out = out * transform_of(step, time);
    return out;
  }
  /// World transformation of a prim.
  [[nodiscard]] Affine world_of(int i, double time) const {
    Affine out;
    for (; i >= 0; i = resets_[at(i)] ? -1 : prim(i).parent) out = local_of(i, time) * out;
    return out;
  }
  [[nodiscard]] bool is_animated(int i) const {
    return std::ranges::any_of(stacks_[at(i)], [](const TransformStep& step) { return step.attribute->samples.size() > 1; });
  }

  /// Reads matrices of a skeleton; empty without the attribute.
  bool read_matrices(const UsdPrim& p, const char* name, std::size_t count, std::vector<Affine>& out) {
    const UsdAttribute* a = p.attribute(name);
    if (!a || (!a->value && a->samples.empty())) return true;
    if (!check_length(*a, name, 16 * count, std::to_string(count) + " joints need ")) return false;
    const std::vector<double>& x = a->value ? a->value->numbers : a->samples[0].second.numbers;
    for (std::size_t i = 0; i < count; ++i) out.push_back(matrix_at(x, i));
    return true;
  }

  bool read_skeleton(int i) {
    const UsdPrim& p = prim(i);
    const UsdAttribute* joints = p.attribute("joints");
    if (!joints || !joints->value || joints->value->texts.empty()) return true;
    const std::vector<std::string>& paths = joints->value->texts;
    if (paths.size() > formats::max_joints)
      return refuse(joints->line, ErrorCode::range, "The skeleton has more than 10000 joints.", "Export the skeleton only.");
    UsdSkeleton s;
    s.prim = i;
    std::map<std::string, std::size_t, std::less<>> by_path;
    for (std::size_t k = 0; k < paths.size(); ++k)
      if (!by_path.emplace(paths[k], k).second)
        return refuse(joints->line, ErrorCode::duplicate, "The joint " + formats::in_quotes(paths[k]) + " is listed twice.", "Rename one.");
    const auto parent_of = [&](const std::string& path) {  // the closest listed joint whose path begins the path
      for (std::size_t to = path.rfind('/'); to != std::string::npos && to > 0; to = path.rfind('/', to - 1))
        if (const auto found = by_path.find(std::string_view(path).substr(0, to)); found != by_path.end())
          return static_cast<int>(found->second);
      return -1;
    };
    // Parents come before children: a path is longer than that of its parent.
    for (std::size_t k = 0; k < paths.size(); ++k) s.listed.push_back(k);
    std::ranges::sort(s.listed, {}, [&](std::size_t k) { return std::pair(std::ranges::count(paths[k], '/'), k); });
    std::vector<int> place(paths.size());
    for (std::size_t k = 0; k < paths.size(); ++k) place[s.listed[k]] = static_cast<int>(k);
    for (const std::size_t k : s.listed) {
      const int parent = parent_of(paths[k]);
      s.parents.push_back(parent < 0 ? -1 : place[at(parent)]);
      s.names.push_back(paths[k].substr(paths[k].rfind('/') + 1));
    }
    std::vector<Affine> rest, bind;
    if (!read_matrices(p, "restTransforms", paths.size(), rest) || !read_matrices(p, "bindTransforms", paths.size(), bind)) return false;
    if (rest.empty() && bind.empty())
      return refuse(p.line, ErrorCode::structure, "The skeleton has neither bindTransforms nor restTransforms.", "Export the file again.");
    const auto invertible = [](const Affine& X) { return std::fabs(X.M.determinant()) > 1e-18; };
    if (!std::ranges::all_of(bind, invertible)) bind.clear();
    for (std::size_t k = 0; k < paths.size(); ++k) {
      const int parent = s.parents[k];
      if (!rest.empty()) {
        s.rest.push_back(rest[s.listed[k]]);
      } else {
        const Affine& own = bind[s.listed[k]];
        const Mat3 back = parent < 0 ? Mat3::identity() : inverse(s.bind[at(parent)].M);
        s.rest.push_back(parent < 0 ? own : Affine{back * own.M, back * (own.p - s.bind[at(parent)].p)});
      }
      s.bind.push_back(!bind.empty() ? bind[s.listed[k]] : parent < 0 ? s.rest[k] : s.bind[at(parent)] * s.rest[k]);
    }
    if (!find_animation(s)) return false;
    s.first = count_;
    count_ += paths.size();
    skeletons_.push_back(std::move(s));
    return true;
  }

  /// Finds the animation of a skeleton: its own skel:animationSource, or the one that it inherits.
  bool find_animation(UsdSkeleton& s) {
    for (int i = s.prim; i >= 0 && s.animation < 0; i = prim(i).parent)
      if (const auto found = prim(i).targets.find("skel:animationSource"); found != prim(i).targets.end()) {
        s.animation = find(found->second);
        break;
      }
    s.animated.assign(s.names.size(), -1);
    if (s.animation < 0 || prim(s.animation).type != "SkelAnimation") {
      s.animation = -1;
      return true;
    }
    const UsdPrim& p = prim(s.animation);
    const UsdAttribute* joints = p.attribute("joints");
    const std::size_t count = joints && joints->value ? joints->value->texts.size() : 0;
    const std::vector<std::string>& own = prim(s.prim).attribute("joints")->value->texts;
    std::map<std::string_view, int> order;
    for (std::size_t k = 0; k < count; ++k) order.emplace(joints->value->texts[k], static_cast<int>(k));
    for (std::size_t k = 0; k < own.size(); ++k)
      if (const auto found = order.find(own[s.listed[k]]); found != order.end()) s.animated[k] = found->second;
    for (const auto& [name, width] : {std::pair{"translations", 3}, {"rotations", 4}, {"scales", 3}}) {
      const UsdAttribute* a = p.attribute(name);
      if (a && !check_length(*a, name, at(width) * count, std::to_string(count) + " joints need ")) return false;
    }
    return true;
  }

  /// Makes each animated prim a joint.
  void choose_prims() {
    for (std::size_t i = 0; i < layer_.prims.size(); ++i) {
      if (!shown_[i] || !is_animated(static_cast<int>(i)) || layer_.prims[i].type == "Camera" || layer_.prims[i].type.ends_with("Light"))
        continue;
      joint_of_prim_.emplace(static_cast<int>(i), static_cast<int>(prims_.size()));
      prims_.push_back(static_cast<int>(i));
    }
    count_ = prims_.size();
  }

  /// World transforms of all joints at a time code, in the file's axes and units.
  void pose_at(double time, std::vector<Affine>& world) const {
    world.resize(count_);
    for (const UsdSkeleton& s : skeletons_) {
      const Affine base = world_of(s.prim, time);
      std::vector<double> p, q, scale;
      if (s.animation >= 0) {
        const UsdPrim& animation = prim(s.animation);
        if (const UsdAttribute* a = animation.attribute("translations")) p = sampled(*a, time);
        if (const UsdAttribute* a = animation.attribute("rotations")) q = sampled(*a, time, true);
        if (const UsdAttribute* a = animation.attribute("scales")) scale = sampled(*a, time);
      }
      for (std::size_t k = 0; k < s.names.size(); ++k) {
        Affine local = s.rest[k];
        if (s.animated[k] >= 0) {
          const std::size_t i = at(s.animated[k]);
          if (!p.empty()) local.p = vec_at(p, i);
          if (!q.empty()) {
            const Mat3 R = to_matrix(normalized(Quat{q[4 * i], q[4 * i + 1], q[4 * i + 2], q[4 * i + 3]}));
            local.M = scale.empty() ? R : R * Mat3::diagonal(scale[3 * i], scale[3 * i + 1], scale[3 * i + 2]);
          }
        }
        world[s.first + k] = (s.parents[k] < 0 ? base : world[s.first + at(s.parents[k])]) * local;
      }
    }
    for (std::size_t k = 0; k < prims_.size(); ++k) world[k] = world_of(prims_[k], time);
  }

  Result<MeasuredMotion> motion() {
    // All time codes at which something changes, and their median distance.
    std::vector<double> times;
    const auto take = [&](const UsdAttribute* a) {
      if (a)
        for (const auto& sample : a->samples) times.push_back(sample.first);
    };
    std::vector<bool> seen(layer_.prims.size());
    const auto take_stack = [&](int i) {
      for (; i >= 0 && !seen[at(i)]; i = prim(i).parent) {
        seen[at(i)] = true;
        for (const TransformStep& step : stacks_[at(i)]) take(step.attribute);
      }
    };
    for (const UsdSkeleton& s : skeletons_) {
      take_stack(s.prim);
      if (s.animation >= 0)
        for (const char* name : {"translations", "rotations", "scales"}) take(prim(s.animation).attribute(name));
    }
    for (const int i : prims_) take_stack(i);
    std::ranges::sort(times);
    times.erase(std::ranges::unique(times).begin(), times.end());
    std::vector<double> gaps;
    for (std::size_t k = 1; k < times.size(); ++k) gaps.push_back(times[k] - times[k - 1]);
    double gap = std::numeric_limits<double>::infinity();
    if (!gaps.empty()) {
      std::ranges::nth_element(gaps, gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2));
      gap = gaps[gaps.size() / 2];
    }
    const double codes = layer_.time_codes_per_second.value_or(layer_.frames_per_second.value_or(24));
    const double rate = options_.rate > 0 ? options_.rate : rate_of_gap(gap / codes);
    const double first = times.empty() ? 0 : times.front(), last = times.empty() ? 0 : times.back();
    const double frames = std::floor((last - first) / codes * rate + 1.5);
    if (!(frames * static_cast<double>(count_) <= 2e7)) {
      refuse(0, ErrorCode::range,
             "The animation of " + to_fixed((last - first) / codes, 1) + " s at " + to_fixed(rate, 1) +
                 " frames per second has more than 20 million joint poses.",
             "Export a part of it.");
      return fail(std::move(error_));
    }
    make_joints(first);
    MeasuredMotion out;
    out.name = formats::stem_of(file_name_);
    out.source = std::string(file_name_);
    out.skeleton = joints_.skeleton();
    out.rate = rate;
    out.frames = static_cast<int>(frames);
    std::vector<Affine> world;
    for (int f = 0; f < out.frames; ++f) {
      pose_at(std::min(first + f / rate * codes, last), world);
      if (!std::ranges::all_of(world, [](const Affine& X) { return is_finite(X) && norm(X.p) <= formats::max_magnitude; })) {
        refuse(0, ErrorCode::range, "A position is not finite or more than 1e9 units from the origin.", "Export the file again.");
        return fail(std::move(error_));
      }
      joints_.append_frame(out, world);
    }
    mark_translations(out);
    if (const long flat = joints_.take_flat(); flat > 0)
      notes_.remarks.push_back("Some joints are scaled to nothing or mirrored in " + std::to_string(flat) +
                               " joint poses; these poses use the rotation of their parents.");
    if (times.empty()) notes_.remarks.push_back("The file has no animations; the result is one frame in the rest pose.");
    if (layer_.refers) notes_.remarks.push_back("What the file refers to (other files or prims) was not read.");
    notes_.frame_time = 1 / rate;
    return out;
  }

  /// Makes the joints in their rest pose: the bind pose, or for prims the pose at the first time code.
  void make_joints(double first) {
    std::vector<Affine> rest(count_);
    pose_at(first, rest);
    for (const UsdSkeleton& s : skeletons_) {
      const Affine base = world_of(s.prim, first);
      for (std::size_t k = 0; k < s.names.size(); ++k) rest[s.first + k] = base * s.bind[k];
    }
    Vec3 low = rest[0].p, high = rest[0].p;
    for (const Affine& X : rest)
      for (int k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], X.p[k]);
        high[k] = std::max(high[k], X.p[k]);
      }
    const double stated = layer_.metres_per_unit.value_or(0.01);  // the fallback of USD
    const double metres = options_.metres_per_unit > 0
                              ? options_.metres_per_unit
                              : plausible_unit(std::max({high.x - low.x, high.y - low.y, high.z - low.z}), stated, notes_);
    notes_.metres_per_unit = metres;
    notes_.unit_guessed = notes_.unit_guessed || (!layer_.metres_per_unit && options_.metres_per_unit <= 0);
    notes_.z_up = layer_.up == 'Z';
    joints_ = SceneJoints(axes_with_up(layer_.up == 'Z' ? 2 : layer_.up == 'X' ? 0 : 1), metres);
    for (const UsdSkeleton& s : skeletons_)
      for (std::size_t k = 0; k < s.names.size(); ++k)
        joints_.add(formats::utf8(s.names[k]), s.parents[k] < 0 ? -1 : static_cast<int>(s.first) + s.parents[k], rest[s.first + k]);
    for (std::size_t k = 0; k < prims_.size(); ++k) {
      int parent = -1;
      for (int i = prim(prims_[k]).parent; i >= 0 && parent < 0; i = prim(i).parent)
        if (const auto found = joint_of_prim_.find(i); found != joint_of_prim_.end()) parent = found->second;
      joints_.add(formats::utf8(prim(prims_[k]).name), parent, rest[k]);
    }
    joints_.skeleton().name = formats::stem_of(file_name_);
  }

  /// Marks the joints whose position in their parent changes by more than rounding of single precision.
  static void mark_translations(MeasuredMotion& motion) {
    const std::size_t n = motion.skeleton.joints.size();
    for (std::size_t j = 0; j < n; ++j)
      for (std::size_t i = j; i < motion.translations.size(); i += n)
        if (norm(motion.translations[i] - motion.translations[j]) > 1e-5 * (1 + norm(motion.translations[j]))) {
          motion.skeleton.joints[j].translates = true;
          break;
        }
  }

  const UsdLayer& layer_;
  std::string_view file_name_;
  const SceneOptions& options_;
  formats::ReadNotes& notes_;
  Error error_;
  std::map<std::string_view, int> index_;           ///< prims by path
  std::vector<bool> shown_;                         ///< [prims] defined and active, like all prims above
  std::vector<std::vector<TransformStep>> stacks_;  ///< [prims]
  std::vector<bool> resets_;                        ///< [prims] the transformations of the parents do not act on the prim
  std::vector<UsdSkeleton> skeletons_;
  std::vector<int> prims_;  ///< the animated prims of a file without skeletons
  std::map<int, int> joint_of_prim_;
  std::size_t count_ = 0;  ///< number of joints
  SceneJoints joints_;
};

}  // namespace

bool is_binary_usd(std::string_view bytes) { return bytes.starts_with("PXR-USDC") || bytes.starts_with("PK\x03\x04"); }

Result<MeasuredMotion> read_usd(std::string_view text, std::string_view file_name, const SceneOptions& options, formats::ReadNotes* notes) {
  if (is_binary_usd(text))
    return fail(ErrorCode::unsupported, std::string(file_name), "The file is binary USD, which Ugoki does not read.",
                "Convert it to text with the tools of OpenUSD (usdcat --flatten FILE -o NEW.usda).");
  Result<UsdLayer> layer = read_usda_layer(text, file_name);
  if (!layer) return fail(std::move(layer.error()));
  formats::ReadNotes own;
  return UsdReader(*layer, file_name, options, notes ? *notes : own).read();
}

}  // namespace ugoki::scene_formats
