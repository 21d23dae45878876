#include "ugoki/capture/marker_set.h"

#include <algorithm>

namespace ugoki::capture {
namespace {

constexpr double deg = 3.14159265358979323846 / 180;

Vec3 mirrored(const Vec3& v) { return {v.x, -v.y, v.z}; }
/// Rotation axes are pseudovectors: the mirror plane keeps y and inverts x and z.
Vec3 mirrored_axis(const Vec3& a) { return {-a.x, a.y, -a.z}; }

/// Builds a marker set from middle segments and from mirrored pairs.
class Builder {
 public:
  explicit Builder(std::string name) { set_.name = std::move(name); }

  /// @return index of the segment
  int middle(ModelSegment s) {
    set_.segments.push_back(std::move(s));
    return static_cast<int>(set_.segments.size()) - 1;
  }
  /// Adds `left` and its mirror image, which gets the next index. In the mirror image "Left" in the name becomes "Right", and a parent with
  /// sides is replaced by its right one. @return index of the left segment
  int pair(ModelSegment left) {
    const int index = static_cast<int>(set_.segments.size());
    ModelSegment right = left;
    right.name.replace(right.name.find("Left"), 4, "Right");
    if (left.parent >= 0 && set_.segments[static_cast<std::size_t>(left.parent)].mirror >= 0) right.parent = left.parent + 1;
    right.offset = mirrored(left.offset);
    right.axis = mirrored_axis(left.axis);
    right.second_axis = mirrored_axis(left.second_axis);
    for (Vec3& e : right.end_sites) e = mirrored(e);
    left.mirror = index + 1;
    right.mirror = index;
    set_.segments.push_back(std::move(left));
    set_.segments.push_back(std::move(right));
    return index;
  }
  void marker(std::vector<std::string> labels, int segment, const Vec3& at, double sigma, double noise = 1) {
    set_.markers.push_back({std::move(labels), segment, at, sigma, noise});
  }
  /// Adds a marker and its mirror image. '<' in a label stands for L on the left side and for R on the right side.
  void markers(const std::vector<std::string>& labels, int left_segment, const Vec3& at, double sigma, double noise = 1) {
    const bool sided = set_.segments[static_cast<std::size_t>(left_segment)].mirror >= 0;
    for (const bool left : {true, false}) {
      std::vector<std::string> names = labels;
      for (std::string& n : names) std::replace(n.begin(), n.end(), '<', left ? 'L' : 'R');
      marker(names, left || !sided ? left_segment : left_segment + 1, left ? at : mirrored(at), sigma, noise);
    }
  }
  MarkerSet finish() { return std::move(set_); }

 private:
  MarkerSet set_;
};

ModelSegment ball(std::string name, int parent, const Vec3& offset, const Vec3& sigma, double stiffness) {
  ModelSegment s;
  s.name = std::move(name);
  s.parent = parent;
  s.offset = offset;
  s.offset_sigma = sigma;
  s.stiffness_sigma = stiffness;
  return s;
}

ModelSegment hinge(std::string name, int parent, const Vec3& offset, const Vec3& sigma, const Vec3& axis, double lower, double upper) {
  ModelSegment s = ball(std::move(name), parent, offset, sigma, 3);
  s.joint = ModelJoint::hinge;
  s.axis = axis;
  s.lower = lower;
  s.upper = upper;
  return s;
}

/// A person of 1.75 m. Segment lengths: de Leva (1996). Marker positions on the skin relative to the joint centres: palpation rules of the
/// Plug-in Gait model.
MarkerSet make_human() {
  Builder b("human, Plug-in Gait and CMU labels");
  ModelSegment root = ball("Hips", -1, {}, {}, 1e3);
  root.joint = ModelJoint::root;
  const int hips = b.middle(root);
  const int thigh = b.pair(ball("LeftUpLeg", hips, {0, 0.088, 0}, {0.006, 0.008, 0.006}, 1.5));
  const int shank = b.pair(hinge("LeftLeg", thigh, {0, 0, -0.43}, {0.005, 0.005, 0.05}, {0, 1, 0}, -10 * deg, 160 * deg));
  ModelSegment foot = ball("LeftFoot", shank, {0, 0, -0.415}, {0.005, 0.005, 0.05}, 0.5);
  foot.end_sites = {};
  const int ankle = b.pair(foot);
  ModelSegment toes = ball("LeftToeBase", ankle, {0.135, 0, -0.06}, {}, 1);
  toes.joint = ModelJoint::fixed;
  toes.end_sites = {{0.06, 0, 0}};
  b.pair(toes);
  const int spine = b.middle(ball("Spine", hips, {-0.03, 0, 0.11}, {0.01, 0, 0.015}, 0.35));
  const int chest = b.middle(ball("Spine1", spine, {0, 0, 0.17}, {0.01, 0, 0.02}, 0.35));
  const int neck = b.middle(ball("Neck", chest, {0, 0, 0.25}, {0.01, 0, 0.02}, 0.4));
  ModelSegment skull = ball("Head", neck, {0.02, 0, 0.09}, {0.01, 0, 0.01}, 0.4);
  skull.end_sites = {{0, 0, 0.18}};
  const int head = b.middle(skull);
  const int collar = b.pair(ball("LeftShoulder", chest, {0.01, 0.02, 0.2}, {0.01, 0.005, 0.015}, 0.2));
  const int arm = b.pair(ball("LeftArm", collar, {0, 0.17, 0.005}, {0.008, 0.012, 0.008}, 2));
  ModelSegment elbow = hinge("LeftForeArm", arm, {0, 0.28, 0}, {0.005, 0.03, 0.005}, {0, 0, -1}, -10 * deg, 160 * deg);
  elbow.joint = ModelJoint::universal;
  elbow.second_axis = {0, 1, 0};
  elbow.lower2 = -160 * deg;
  elbow.upper2 = 160 * deg;
  const int forearm = b.pair(elbow);
  ModelSegment wrist = hinge("LeftHand", forearm, {0, 0.25, 0}, {0.005, 0.02, 0.005}, {0, 0, -1}, -90 * deg, 90 * deg);
  wrist.joint = ModelJoint::universal;
  wrist.second_axis = {1, 0, 0};
  wrist.lower2 = -50 * deg;
  wrist.upper2 = 50 * deg;
  wrist.stiffness_sigma = 0.6;
  wrist.end_sites = {{0, 0.17, 0}};
  const int hand = b.pair(wrist);

  b.markers({"<ASI", "<FWT", "<ASIS", "ASIS<", "<IAS"}, hips, {0.06, 0.12, 0.105}, 0.006);
  b.markers({"<PSI", "<BWT", "<PSIS", "PSIS<", "<IPS"}, hips, {-0.115, 0.045, 0.11}, 0.006);
  b.marker({"SACR", "SAC"}, hips, {-0.1, 0, 0.09}, 0.015);
  b.markers({"<FHD"}, head, {0.1, 0.065, 0.09}, 0.03);
  b.markers({"<BHD"}, head, {-0.08, 0.065, 0.09}, 0.03);
  b.marker({"ARIEL", "HTOP", "HEADTOP"}, head, {0, 0, 0.18}, 0.03);
  b.marker({"C7"}, chest, {-0.075, 0, 0.235}, 0.02);
  b.marker({"T10"}, chest, {-0.105, 0, 0.0}, 0.03);
  b.marker({"CLAV", "IJ", "SJN"}, chest, {0.06, 0, 0.185}, 0.02);
  b.marker({"STRN", "PX", "XIPH"}, chest, {0.1, 0, 0.04}, 0.03);
  b.marker({"RBAC", "RBAK"}, chest, {-0.1, -0.07, 0.12}, 0.04);
  b.markers({"<SHO", "<ACR", "<SAE", "<ACROMION"}, collar, {0, 0.135, 0.045}, 0.015);
  b.markers({"<UPA", "<UPARM"}, arm, {0, 0.14, 0.045}, 0.05);
  b.markers({"<ELB", "<LEE", "<LEL", "<ELBOW"}, arm, {0, 0.28, 0.048}, 0.008);
  b.markers({"<FRM", "<FRA"}, forearm, {0, 0.13, 0.03}, 0.05);
  b.markers({"<WRA"}, forearm, {0, 0.25, 0.045}, 0.02);
  b.markers({"<WRB"}, forearm, {0, 0.25, -0.045}, 0.02);
  b.markers({"<FIN", "<HAND"}, hand, {-0.015, 0.085, 0}, 0.02);
  b.markers({"<THI", "<THIGH"}, thigh, {0.02, 0.085, -0.22}, 0.05, 6);
  b.markers({"<KNE", "<LFC", "<KNEE"}, shank, {-0.02, 0.055, 0.012}, 0.002, 4);
  b.markers({"<SHN", "<TIB", "<SHANK"}, shank, {0.01, 0.055, -0.2}, 0.05, 3);
  b.markers({"<ANK", "<ANKLE", "<LMAL"}, shank, {0, 0.04, -0.405}, 0.006, 0.6);
  b.markers({"<HEE", "<HEEL", "<CAL"}, ankle, {-0.055, 0, -0.045}, 0.015);
  b.markers({"<TOE", "<MT2"}, ankle, {0.13, 0, -0.035}, 0.02);
  b.markers({"<MT5", "<5TH"}, ankle, {0.1, 0.05, -0.055}, 0.02);
  b.markers({"<MT1", "<1ST"}, ankle, {0.13, -0.03, -0.05}, 0.02);
  return b.finish();
}

/// A rat-like animal of 0.2 m from snout to tail; other sizes are scaled.
MarkerSet make_quadruped() {
  Builder b("four-legged animal, key points on the joints");
  ModelSegment root = ball("Pelvis", -1, {}, {}, 1e3);
  root.joint = ModelJoint::root;
  const int pelvis = b.middle(root);
  const double s = 0.02;
  const int lumbar = b.middle(ball("Lumbar", pelvis, {0.04, 0, 0}, {s, s, s}, 0.6));
  const int thorax = b.middle(ball("Thorax", lumbar, {0.045, 0, -0.005}, {s, s, s}, 0.6));
  ModelSegment skull = ball("Head", thorax, {0.02, 0, 0.005}, {s, s, s}, 0.8);
  skull.end_sites = {{0.05, 0, -0.01}};
  const int head = b.middle(skull);
  ModelSegment tail = ball("Tail", pelvis, {-0.035, 0, -0.01}, {s, s, s}, 0.5);
  tail.joint = ModelJoint::fixed;
  tail.end_sites = {{-0.05, 0, -0.01}};
  b.middle(tail);
  const int thigh = b.pair(ball("LeftThigh", pelvis, {-0.015, 0.018, -0.015}, {s, s, s}, 1));
  const int shank = b.pair(ball("LeftShank", thigh, {0.02, 0.005, -0.03}, {s, s, s}, 1));
  const int foot = b.pair(ball("LeftHindFoot", shank, {-0.03, 0, -0.02}, {s, s, s}, 1));
  ModelSegment toes = ball("LeftHindToes", foot, {0.025, 0, -0.015}, {s, s, s}, 1);
  toes.joint = ModelJoint::fixed;
  toes.end_sites = {{0.01, 0, 0}};
  const int hind = b.pair(toes);
  const int scapula = b.pair(ball("LeftScapula", thorax, {0.005, 0.012, -0.01}, {s, s, s}, 0.4));
  const int arm = b.pair(ball("LeftUpperArm", scapula, {0.01, 0.005, -0.015}, {s, s, s}, 1));
  const int forearm = b.pair(ball("LeftForearm", arm, {-0.015, 0.003, -0.02}, {s, s, s}, 1));
  const int hand = b.pair(ball("LeftForeFoot", forearm, {0.015, 0, -0.02}, {s, s, s}, 1));
  ModelSegment fingers = ball("LeftForeToes", hand, {0.01, 0, -0.005}, {s, s, s}, 1);
  fingers.joint = ModelJoint::fixed;
  fingers.end_sites = {{0.005, 0, 0}};
  const int fore = b.pair(fingers);
  const double on_joint = 0.004;
  b.marker({"SNOUT", "NOSE"}, head, {0.05, 0, -0.01}, 0.02);
  b.markers({"EAR<", "<EAR"}, head, {0.02, 0.015, 0.012}, 0.02);
  b.marker({"SPINEF", "WITHERS"}, thorax, {0.01, 0, 0.01}, 0.015);
  b.marker({"SPINEM"}, lumbar, {0, 0, 0.01}, 0.015);
  b.marker({"SPINEL"}, pelvis, {0, 0, 0.01}, 0.015);
  b.marker({"TAILBASE", "TAIL"}, pelvis, {-0.035, 0, -0.005}, 0.015);
  b.markers({"SHOULDER<", "<SHOULDER"}, arm, {}, on_joint);
  b.markers({"ELBOW<", "<ELBOW"}, forearm, {}, on_joint);
  b.markers({"WRIST<", "<WRIST"}, hand, {}, on_joint);
  b.markers({"HAND<", "<HAND", "FOREPAW<"}, fore, {}, on_joint);
  b.markers({"HIP<", "<HIP"}, thigh, {}, on_joint);
  b.markers({"KNEE<", "<KNEE"}, shank, {}, on_joint);
  b.markers({"ANKLE<", "<ANKLE"}, foot, {}, on_joint);
  b.markers({"FOOT<", "<FOOT", "HINDPAW<"}, hind, {}, on_joint);
  return b.finish();
}

/// Capital letters without blanks, '_', '-' and '.'.
std::string normalized_label(const std::string& label) {
  std::string out;
  for (const char c : label)
    if (c != ' ' && c != '_' && c != '-' && c != '.') out.push_back(c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c);
  return out;
}

}  // namespace

const MarkerSet& human_markers() {
  static const MarkerSet set = make_human();
  return set;
}

const MarkerSet& quadruped_key_points() {
  static const MarkerSet set = make_quadruped();
  return set;
}

std::vector<int> match_labels(const MarkerSet& set, const std::vector<std::string>& labels) {
  std::vector<int> out(labels.size(), -1);
  std::vector<char> used(set.markers.size());
  for (std::size_t i = 0; i < labels.size(); ++i) {
    std::string label = normalized_label(labels[i]);
    if (const std::size_t colon = label.rfind(':'); colon != std::string::npos) label.erase(0, colon + 1);
    for (std::size_t k = 0; k < set.markers.size(); ++k) {
      const auto& names = set.markers[k].labels;
      if (used[k] != 0 || std::find(names.begin(), names.end(), label) == names.end()) continue;
      out[i] = static_cast<int>(k);
      used[k] = 1;
      break;
    }
  }
  return out;
}

}  // namespace ugoki::capture
