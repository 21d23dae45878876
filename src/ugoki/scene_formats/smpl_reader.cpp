#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "ugoki/base/number.h"
#include "ugoki/formats/file_axes.h"
#include "ugoki/formats/text.h"
#include "ugoki/scene_formats/npz.h"
#include "ugoki/scene_formats/smpl.h"

namespace ugoki::scene_formats {
namespace {

struct ModelJoint {
  std::string_view name;
  int parent;
  Vec3 offset;  // m, from the parent, for a height of 1.7 m; model axes: X left, Y up, Z forward
};

// The 22 joints that all SMPL models share. Offsets: segment lengths of de Leva (1996) for adults of both sexes, scaled to 1.7 m.
constexpr std::array<ModelJoint, 22> body_joints = {{{"pelvis", -1, {0, 0, 0}},
                                                     {"left_hip", 0, {0.085, -0.085, 0}},
                                                     {"right_hip", 0, {-0.085, -0.085, 0}},
                                                     {"spine1", 0, {0, 0.11, -0.02}},
                                                     {"left_knee", 1, {0, -0.42, 0}},
                                                     {"right_knee", 2, {0, -0.42, 0}},
                                                     {"spine2", 3, {0, 0.13, 0.01}},
                                                     {"left_ankle", 4, {0, -0.415, -0.02}},
                                                     {"right_ankle", 5, {0, -0.415, -0.02}},
                                                     {"spine3", 6, {0, 0.055, 0.02}},
                                                     {"left_foot", 7, {0.02, -0.055, 0.13}},
                                                     {"right_foot", 8, {-0.02, -0.055, 0.13}},
                                                     {"neck", 9, {0, 0.2, -0.03}},
                                                     {"left_collar", 9, {0.07, 0.11, -0.02}},
                                                     {"right_collar", 9, {-0.07, 0.11, -0.02}},
                                                     {"head", 12, {0, 0.085, 0.03}},
                                                     {"left_shoulder", 13, {0.11, 0.04, -0.01}},
                                                     {"right_shoulder", 14, {-0.11, 0.04, -0.01}},
                                                     {"left_elbow", 16, {0.27, -0.01, -0.02}},
                                                     {"right_elbow", 17, {-0.27, -0.01, -0.02}},
                                                     {"left_wrist", 18, {0.25, 0, 0}},
                                                     {"right_wrist", 19, {-0.25, 0, 0}}}};
constexpr std::array<std::string_view, 5> fingers = {"index", "middle", "pinky", "ring", "thumb"};

/// A skeleton of the SMPL family.
struct Tree {
  std::vector<std::string> names;
  std::vector<int> parents;
  std::vector<Vec3> offsets;      // m, model axes
  std::vector<int> pose_columns;  // first of the three columns of `poses`
};

/// The skeleton whose poses have this many columns: 72 SMPL, 156 SMPL+H, 165 SMPL-X, 66 body only. Empty for other numbers.
Tree tree_for(std::size_t columns) {
  Tree t;
  if (columns != 66 && columns != 72 && columns != 156 && columns != 165) return t;
  const auto add = [&](std::string name, int parent, const Vec3& offset, int column) {
    t.names.push_back(std::move(name));
    t.parents.push_back(parent);
    t.offsets.push_back(offset);
    t.pose_columns.push_back(column);
  };
  for (const ModelJoint& j : body_joints) add(std::string(j.name), j.parent, j.offset, 3 * static_cast<int>(t.names.size()));
  if (columns == 72)
    for (const int side : {1, -1}) add(side > 0 ? "left_hand" : "right_hand", side > 0 ? 20 : 21, {0.085 * side, 0, 0}, side > 0 ? 66 : 69);
  if (columns < 156) return t;
  int column = columns == 165 ? 75 : 66;  // SMPL-X: jaw and two eyes come before the hands; they are left out
  for (const int side : {1, -1})
    for (std::size_t f = 0; f < fingers.size(); ++f)
      for (int k = 1; k <= 3; ++k, column += 3) {
        const bool thumb = f == 4;
        const double across = thumb ? 0.03 : 0.025 - 0.017 * static_cast<double>(f == 2 ? 3 : f == 3 ? 2 : f);
        const Vec3 base = thumb ? Vec3{0.03 * side, -0.015, across} : Vec3{0.09 * side, 0, across};
        add((side > 0 ? "left_" : "right_") + std::string(fingers[f]) + std::to_string(k),
            k > 1 ? static_cast<int>(t.names.size()) - 1 : (side > 0 ? 20 : 21), k > 1 ? Vec3{0.028 * side, 0, 0} : base, column);
      }
  return t;
}

/// The first of the arrays `names` that exists; null if none does.
const NpyArray* first_of(const Npz& npz, std::initializer_list<std::string_view> names) {
  for (const std::string_view name : names)
    if (const auto found = npz.find(name); found != npz.end()) return &found->second;
  return nullptr;
}

class Reader {
 public:
  Reader(std::string_view name, formats::ReadNotes& notes) : name_(name), notes_(notes) {}

  Result<MeasuredMotion> read(std::span<const std::byte> bytes, const SmplModelFile& model) {
    constexpr std::array<std::string_view, 14> wanted = {
        "poses",  "pose",       "smpl_poses", "root_orient", "pose_body",       "pose_hand",        "trans",
        "transl", "smpl_trans", "betas",      "fps",         "mocap_framerate", "mocap_frame_rate", "frame_rate"};
    Result<Npz> npz = read_npz(bytes, name_, wanted);
    if (!npz) return fail(std::move(npz.error()));
    if (Result<void> poses = take_poses(*npz); !poses) return fail(std::move(poses.error()));
    if (!model.bytes.empty()) {
      if (Result<void> shaped = shape_by(model, *npz); !shaped) return fail(std::move(shaped.error()));
    } else {
      notes_.remarks.push_back(
          "The joints of an SMPL body depend on its model, which is not part of the file; an adult of average "
          "proportions is assumed. Name the model's .npz with --skeleton for the proportions that the betas describe.");
    }
    choose_up();
    if (model.bytes.empty()) fit_size();
    return motion(*npz);
  }

 private:
  std::unexpected<Error> refuse(ErrorCode code, const std::string& message, const std::string& remedy) const {
    return fail(code, std::string(name_), message, remedy);
  }

  Result<void> take_poses(const Npz& npz) {
    const NpyArray* poses = first_of(npz, {"poses", "pose", "smpl_poses"});
    const NpyArray* trans = first_of(npz, {"trans", "transl", "smpl_trans"});
    const NpyArray *root = first_of(npz, {"root_orient"}), *body = first_of(npz, {"pose_body"}), *hand = first_of(npz, {"pose_hand"});
    if (!trans || (!poses && !(root && body)))
      return refuse(ErrorCode::structure, "The file has no arrays 'poses' (or 'root_orient' and 'pose_body') and 'trans'.",
                    "Choose a file with a motion of AMASS or of an SMPL model.");
    // Poses may have the shape frames x joints x 3.
    const auto frames_of = [](const NpyArray& a) { return a.shape.empty() ? std::size_t{0} : a.shape[0]; };
    frames_ = frames_of(*trans);
    constexpr std::size_t max_frames = 2'000'000;
    if (frames_ < 1 || frames_ > max_frames || trans->values.size() != 3 * frames_)
      return refuse(ErrorCode::structure, "'trans' must have three columns and 1 to 2000000 rows.", "Write 'trans' as frames x 3.");
    trans_ = trans->values;
    if (poses) {
      if (frames_of(*poses) != frames_ || poses->values.size() % frames_ != 0)
        return refuse(ErrorCode::structure,
                      "'poses' has " + std::to_string(frames_of(*poses)) + " rows, but 'trans' has " + std::to_string(frames_) + ".",
                      "Write both with one row for each frame.");
      columns_ = poses->values.size() / frames_;
      poses_ = poses->values;
    } else {
      const bool hands = hand != nullptr && hand->values.size() == 90 * frames_;
      if (root->values.size() != 3 * frames_ || body->values.size() != 63 * frames_)
        return refuse(ErrorCode::structure, "'root_orient' must have 3 columns and 'pose_body' 63, and as many rows as 'trans'.",
                      "Write the arrays as AMASS does.");
      columns_ = hands ? 156 : 66;
      for (std::size_t f = 0; f < frames_; ++f)
        for (const auto& [array, width] : {std::pair{root, std::size_t{3}}, {body, std::size_t{63}}, {hand, hands ? std::size_t{90} : 0}})
          for (std::size_t k = 0; k < width; ++k) poses_.push_back(array->values[f * width + k]);
    }
    tree_ = tree_for(columns_);
    if (tree_.names.empty())
      return refuse(ErrorCode::unsupported,
                    "'poses' has " + std::to_string(columns_) + " columns; SMPL has 72, SMPL+H 156, SMPL-X 165, the body alone 66.",
                    "Convert the motion to one of these models.");
    return {};
  }

  /// Sets the joints at rest from the body model: J = J_regressor (v_template + shapedirs betas).
  Result<void> shape_by(const SmplModelFile& file, const Npz& npz) {
    constexpr std::array<std::string_view, 3> wanted = {"J_regressor", "v_template", "shapedirs"};
    Result<Npz> model = read_npz(file.bytes, file.name, wanted);
    if (!model) return fail(std::move(model.error()));
    const NpyArray *J = first_of(*model, {"J_regressor"}), *v = first_of(*model, {"v_template"}), *S = first_of(*model, {"shapedirs"});
    const auto wrong = [&](const std::string& what) {
      return fail(ErrorCode::structure, std::string(file.name), what, "Use the .npz of an SMPL, SMPL+H or SMPL-X model.");
    };
    if (!J || !v || !S) return wrong("The body model has no numeric arrays 'J_regressor', 'v_template' and 'shapedirs'.");
    const std::size_t vertices = v->values.size() / 3;
    if (vertices < 1 || v->values.size() % 3 != 0 || J->columns() != vertices || S->values.size() % (3 * vertices) != 0)
      return wrong("'J_regressor', 'v_template' and 'shapedirs' have different numbers of vertices.");
    // SMPL-X counts jaw and eyes (22 to 24) before the hands, which this skeleton does not have.
    const std::size_t skipped = columns_ == 165 ? 3 : 0, joints = tree_.names.size() + skipped;
    if (J->rows() < joints)
      return wrong("The body model has " + std::to_string(J->rows()) + " joints, but the motion has " + std::to_string(joints) + ".");
    const std::size_t shapes = S->values.size() / (3 * vertices);
    std::vector<double> betas(shapes, 0);
    if (const NpyArray* b = first_of(npz, {"betas"}))
      for (std::size_t k = 0; k < std::min(shapes, b->values.size()); ++k) betas[k] = b->values[k];
    std::vector<double> shaped = v->values;
    for (std::size_t i = 0; i < shaped.size(); ++i)
      for (std::size_t k = 0; k < shapes; ++k) shaped[i] += S->values[i * shapes + k] * betas[k];
    std::vector<Vec3> at_rest;
    for (std::size_t j = 0; j < tree_.names.size(); ++j) {
      const double* row = J->values.data() + (j < 22 ? j : j + skipped) * vertices;
      Vec3 p;
      for (std::size_t i = 0; i < vertices; ++i)
        for (int k = 0; k < 3; ++k) p[k] += row[i] * shaped[3 * i + static_cast<std::size_t>(k)];
      if (!is_finite(p) || norm(p) > 100) return wrong("A joint of the body model is farther than 100 m from its origin.");
      at_rest.push_back(p);
    }
    for (std::size_t j = 0; j < at_rest.size(); ++j)
      tree_.offsets[j] = tree_.parents[j] < 0 ? at_rest[j] : at_rest[j] - at_rest[static_cast<std::size_t>(tree_.parents[j])];
    return {};
  }

  [[nodiscard]] Vec3 trans(std::size_t frame) const { return {trans_[3 * frame], trans_[3 * frame + 1], trans_[3 * frame + 2]}; }
  [[nodiscard]] Quat rotation(std::size_t frame, std::size_t joint) const {
    const double* r = poses_.data() + frame * columns_ + static_cast<std::size_t>(tree_.pose_columns[joint]);
    const double angle = std::sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
    if (!(angle < 1e6)) return {};  // beyond the exact range of sine and cosine
    return exp_map({r[0], r[1], r[2]});
  }

  /// The axis along which the pelvis points in most frames is up.
  void choose_up() {
    double y = 0, z = 0;
    for (std::size_t f = 0; f < frames_; ++f) {
      const Vec3 up = to_matrix(rotation(f, 0)).column(1);
      y += up.y;
      z += up.z;
    }
    axes_.z_up = z > y;
    notes_.z_up = axes_.z_up;
    notes_.remarks.push_back(std::string("Up is assumed to be the file's axis ") + (axes_.z_up ? "z" : "y") +
                             ", along which the pelvis points.");
  }

  /// Position of both ankles relative to the pelvis in a frame, file axes.
  [[nodiscard]] std::array<Vec3, 2> ankles(std::size_t frame) const {
    std::array<Vec3, 2> out;
    for (const int side : {0, 1}) {
      Mat3 R = to_matrix(rotation(frame, 0));
      Vec3 p{};
      for (const std::size_t j : {std::size_t{1}, std::size_t{4}, std::size_t{7}}) {
        p += R * tree_.offsets[j + static_cast<std::size_t>(side)];
        R = R * to_matrix(rotation(frame, j + static_cast<std::size_t>(side)));
      }
      out[static_cast<std::size_t>(side)] = p;
    }
    return out;
  }

  /// Scales the skeleton so that the lower ankle moves least: with its position trans + s r, the sum of |d trans + s dr|^2 is minimal at
  /// s = -sum(d trans . dr) / sum(dr . dr). The sums extend over the frames in which the same ankle stays the lower one.
  void fit_size() {
    const int up = axes_.z_up ? 2 : 1;
    double along = 0, square = 0;
    std::array<Vec3, 2> before = ankles(0);
    std::size_t low_before = 2;
    for (std::size_t f = 1; f < frames_; ++f) {
      const std::array<Vec3, 2> now = ankles(f);
      const std::size_t low = now[0][up] < now[1][up] ? 0 : 1;
      const Vec3 dr = now[low] - before[low], dt = trans(f) - trans(f - 1);
      if (low == low_before) {  // in the frame of a step, the foot that lands has moved freely
        along -= dot(dr, dt);
        square += dot(dr, dr);
      }
      before = now;
      low_before = low;
    }
    // A person of 1.2 m to 2.1 m. In motions without steps the size stays 1.7 m.
    const double size = square > 1e-4 ? along / square : 1;
    if (!(size > 0.7 && size < 1.25)) return;
    for (Vec3& offset : tree_.offsets) offset *= size;
    notes_.remarks.push_back("The person's size follows from the steps: " + to_fixed(1.7 * size, 2) + " m.");
  }

  Result<MeasuredMotion> motion(const Npz& npz) {
    MeasuredMotion m;
    m.name = formats::stem_of(name_);
    m.source = std::string(name_);
    m.skeleton.name = m.name;
    m.frames = static_cast<int>(frames_);
    const NpyArray* rate = first_of(npz, {"mocap_framerate", "mocap_frame_rate", "fps", "frame_rate"});
    m.rate = rate != nullptr && !rate->values.empty() ? rate->values[0] : 0;
    if (!(m.rate >= 1 && m.rate <= 10'000)) {
      m.rate = 30;
      notes_.remarks.push_back("The file does not state its frame rate; 30 frames per second are assumed.");
    }
    notes_.frame_time = 1 / m.rate;
    notes_.metres_per_unit = 1;
    // `model` converts the model's axes at rest to ours, `world` the axes of the file's space.
    const formats::FileAxes model{.z_up = false};
    const auto turned = [&](const Quat& q) {  // rotation vector in our axes at rest
      const Vec3 v = model.from_file({q.x, q.y, q.z});
      return Quat{q.w, v.x, v.y, v.z};
    };
    // Rotation from our axes at rest to the model's axes, then to our world: for Y up both conversions cancel.
    const Mat3 to_model = Mat3::columns(model.to_file({1, 0, 0}), model.to_file({0, 1, 0}), model.to_file({0, 0, 1}));
    std::vector<char> leaf(tree_.names.size(), 1);
    for (const int parent : tree_.parents)
      if (parent >= 0) leaf[static_cast<std::size_t>(parent)] = 0;
    for (std::size_t j = 0; j < tree_.names.size(); ++j) {
      SkeletonJoint joint;
      joint.name = tree_.names[j];
      joint.parent = tree_.parents[j];
      joint.offset = model.from_file(tree_.offsets[j]);
      joint.dofs = {{{0, 0, 1}}, {{0, 1, 0}}, {{1, 0, 0}}};
      joint.translates = joint.parent < 0;
      if (leaf[j] != 0) joint.end_sites.push_back(end_of(joint));
      m.skeleton.joints.push_back(std::move(joint));
    }
    for (std::size_t f = 0; f < frames_; ++f)
      for (std::size_t j = 0; j < tree_.names.size(); ++j) {
        const Quat q = rotation(f, j);
        if (tree_.parents[j] >= 0) {
          m.rotations.push_back(turned(q));
          m.translations.push_back(m.skeleton.joints[j].offset);
        } else {
          m.rotations.push_back(axes_.z_up ? to_quat(to_matrix(q) * to_model) : turned(q));
          m.translations.push_back(axes_.from_file(tree_.offsets[j] + trans(f)));
        }
      }
    return m;
  }

  /// End of a leaf joint's bone, our axes: toes forward, head up, others along the bone that leads to the joint.
  static Vec3 end_of(const SkeletonJoint& joint) {
    if (joint.name.ends_with("_foot")) return Vec3{1, 0, 0} * (0.5 * norm(joint.offset));
    if (joint.name == "head") return Vec3{0, 0, 1} * (2.1 * norm(joint.offset));
    return joint.offset * 0.8;
  }

  std::string_view name_;
  formats::ReadNotes& notes_;
  formats::FileAxes axes_;
  Tree tree_;
  std::size_t frames_ = 0, columns_ = 0;
  std::vector<double> poses_, trans_;
};

}  // namespace

Result<MeasuredMotion> read_smpl(std::span<const std::byte> bytes, std::string_view file_name, const SmplModelFile& model,
                                 formats::ReadNotes* notes) {
  formats::ReadNotes own;
  return Reader(file_name, notes != nullptr ? *notes : own).read(bytes, model);
}

}  // namespace ugoki::scene_formats
