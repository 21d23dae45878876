#include "ugoki/capture/marker_set.h"

#include <algorithm>

namespace ugoki::capture {
namespace {

constexpr double deg = 3.14159265358979323846 / 180;

Vec3 mirrored(const Vec3& v) { return {v.x, -v.y, v.z}; }
/// Mirror image of a rotation axis in the plane y = 0. The axis is a pseudovector: y is kept, x and z are inverted.
Vec3 mirrored_axis(const Vec3& a) { return {-a.x, a.y, -a.z}; }

/// Builds a marker set from segments in the middle of the body and pairs of left and right segments.
class Builder {
 public:
  explicit Builder(std::string name) { set_.name = std::move(name); }

  /// @return index of the segment
  int middle(ModelSegment s) {
    set_.segments.push_back(std::move(s));
    return static_cast<int>(set_.segments.size()) - 1;
  }
  /// Adds `left` and its mirror image, which gets the next index. In the mirror image, "Left" in the name becomes "Right", and a left
  /// parent is replaced by the right one. @return index of the left segment
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
  MarkerSet finish() {
    for (ModelMarker& m : set_.markers) find_end(m);
    return std::move(set_);
  }

 private:
  /// Finds the joint at the far end of the marker's segment, and how far along the segment the marker is. On a person with longer segments a
  /// marker beside the elbow is beside the elbow. Landmarks of the pelvis do not follow the hip joints.
  void find_end(ModelMarker& m) const {
    if (set_.segments[static_cast<std::size_t>(m.segment)].parent < 0) return;
    for (std::size_t i = 0; i < set_.segments.size(); ++i) {
      const ModelSegment& s = set_.segments[i];
      if (s.parent != m.segment || s.offset_sigma == Vec3{} || dot(s.offset, s.offset) == 0) continue;
      const bool sideways = s.mirror >= 0 && set_.segments[static_cast<std::size_t>(m.segment)].mirror < 0;  // a collar bone of the chest
      if (sideways) continue;
      m.end = static_cast<int>(i);
      m.share = std::clamp(dot(m.at, s.offset) / dot(s.offset, s.offset), 0.0, 1.0);
      return;
    }
  }

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

/// Indices of the segments of a person; of paired segments, the left one.
struct Person {
  int hips = 0, thigh = 0, shank = 0, ankle = 0, chest = 0, head = 0, collar = 0, arm = 0, forearm = 0, hand = 0;
};

/// Adds the segments of a person with a height of 1.75 m. Segment lengths: de Leva (1996).
Person add_person(Builder& b) {
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
  const int arm = b.pair(ball("LeftArm", collar, {0, 0.17, 0.005}, {0.01, 0.025, 0.01}, 2));
  ModelSegment elbow = hinge("LeftForeArm", arm, {0, 0.28, 0}, {0.005, 0.04, 0.005}, {0, 0, -1}, -10 * deg, 160 * deg);
  elbow.joint = ModelJoint::universal;
  elbow.second_axis = {0, 1, 0};
  elbow.lower2 = -160 * deg;
  elbow.upper2 = 160 * deg;
  const int forearm = b.pair(elbow);
  ModelSegment wrist = hinge("LeftHand", forearm, {0, 0.25, 0}, {0.005, 0.03, 0.005}, {0, 0, -1}, -90 * deg, 90 * deg);
  wrist.joint = ModelJoint::universal;
  wrist.second_axis = {1, 0, 0};
  wrist.lower2 = -50 * deg;
  wrist.upper2 = 50 * deg;
  wrist.stiffness_sigma = 0.6;
  wrist.end_sites = {{0, 0.17, 0}};
  const int hand = b.pair(wrist);
  return {hips, thigh, shank, ankle, chest, head, collar, arm, forearm, hand};
}

/// A person with markers on the skin. Marker positions relative to the joint centres: palpation rules of the Plug-in Gait model; for labels
/// of other sets, the bony landmarks that the labels name (van Sint Jan 2007, Colour Atlas of Skeletal Landmark Definitions).
MarkerSet make_human() {
  Builder b("human, markers on the skin");
  const auto [hips, thigh, shank, ankle, chest, head, collar, arm, forearm, hand] = add_person(b);
  // Plug-in Gait, CGM2, Helen Hayes, IOR (Leardini), CAST and ISB landmarks, OpenSim's gait models, CMU, OptiTrack Baseline.
  b.markers({"<ASI", "<FWT", "<ASIS", "ASIS<", "<IAS", "WAIST<FRONT"}, hips, {0.06, 0.12, 0.105}, 0.006);
  b.markers({"<PSI", "<BWT", "<PSIS", "PSIS<", "<IPS", "WAIST<BACK"}, hips, {-0.115, 0.045, 0.11}, 0.006);
  b.marker({"SACR", "SAC", "VSACRAL", "SACRUM", "SACRAL"}, hips, {-0.1, 0, 0.09}, 0.015);
  b.markers({"<ILC", "<ICT", "<IC", "<CREST", "<ILIACCREST"}, hips, {-0.01, 0.145, 0.16}, 0.02);
  b.markers({"<FHD", "<HEADFRONT"}, head, {0.1, 0.065, 0.09}, 0.03);
  b.markers({"<BHD", "<HEADBACK"}, head, {-0.08, 0.065, 0.09}, 0.03);
  b.markers({"<TEMPLE", "<HEAD", "<TRAGION"}, head, {0.04, 0.075, 0.07}, 0.03);
  b.marker({"ARIEL", "HTOP", "HEADTOP", "TOPHEAD", "VERTEX"}, head, {0, 0, 0.18}, 0.03);
  b.marker({"HEADFRONT", "FOREHEAD"}, head, {0.1, 0, 0.1}, 0.03);
  b.marker({"C7", "CV7", "BACKTOP"}, chest, {-0.075, 0, 0.235}, 0.02);
  b.marker({"T10", "TV10", "MAI", "T8", "TV8"}, chest, {-0.105, 0, 0.0}, 0.03);
  b.marker({"CLAV", "IJ", "SJN"}, chest, {0.06, 0, 0.185}, 0.02);
  b.marker({"STRN", "PX", "XIPH", "SXS", "CHEST"}, chest, {0.1, 0, 0.04}, 0.03);
  b.marker({"STERNUM"}, chest, {0.09, 0, 0.11}, 0.06);
  b.marker({"RBAC", "RBAK", "BACKRIGHT"}, chest, {-0.1, -0.07, 0.12}, 0.04);
  b.marker({"LBAC", "LBAK", "BACKLEFT"}, chest, {-0.1, 0.07, 0.12}, 0.04);
  b.markers({"<SHO", "<ACR", "<SAE", "<ACROMION", "<ACROMIUM", "<CAJ", "<SHOULDERTOP", "<SHOULDER"}, collar, {0, 0.135, 0.045}, 0.01);
  b.markers({"<SHOULDERBACK", "<SIA"}, collar, {-0.07, 0.11, -0.03}, 0.03);
  b.markers({"<UPA", "<UPARM", "<BICEP", "<UARMHIGH", "<UARM"}, arm, {0, 0.14, 0.045}, 0.05);
  b.markers({"<ELB", "<LEE", "<LEL", "<ELBOW", "<HLE", "<ELBOWLAT", "<ELBOWLATERAL", "<ELBOWOUT", "<LATELBOW", "<ELBL"}, arm,
            {0, 0.28, 0.048}, 0.008);
  b.markers({"<HME", "<ELBOWMED", "<ELBOWMEDIAL", "<MEDELBOW", "<ELBM", "<MEE", "<MEL", "<ELBOWIN"}, arm, {0, 0.28, -0.045}, 0.01);
  b.markers({"<FRM", "<FRA", "<FARM"}, forearm, {0, 0.13, 0.03}, 0.05);
  b.markers({"<WRA", "<RSP", "<WRISTLAT", "<WRISTLATERAL", "<LATWRIST", "<WRISTIN", "<RS"}, forearm, {0, 0.25, 0.045}, 0.012);
  b.markers({"<WRB", "<USP", "<WRISTMED", "<WRISTMEDIAL", "<MEDWRIST", "<WRISTOUT", "<US"}, forearm, {0, 0.25, -0.045}, 0.012);
  b.markers({"<WRI", "<WRIST"}, forearm, {-0.02, 0.25, 0}, 0.015);
  b.markers({"<FIN", "<HAND", "<HM2", "<HANDIN"}, hand, {-0.015, 0.085, 0}, 0.02);
  b.markers({"<HM5", "<HANDOUT"}, hand, {-0.01, 0.08, -0.04}, 0.02);
  b.markers({"<GT", "<GTR", "<FTC", "<TROCH", "<TROCHANTER"}, thigh, {0, 0.075, 0}, 0.02);
  b.markers({"<THI", "<THIGH", "<THAP"}, thigh, {0.02, 0.085, -0.22}, 0.05, 6);
  b.markers({"<THIGHUPPER", "<TH1", "<THIGH1", "<THIA"}, thigh, {0.02, 0.08, -0.2}, 0.09, 6);
  b.markers({"<THIGHFRONT", "<TH2", "<THIGH2", "<THIB"}, thigh, {0.06, 0.05, -0.25}, 0.09, 6);
  b.markers({"<THIGHREAR", "<TH3", "<THIGH3", "<THIC"}, thigh, {0, 0.08, -0.28}, 0.09, 6);
  b.markers({"<TH4", "<THIGH4", "<THID"}, thigh, {0.02, 0.08, -0.25}, 0.09, 6);
  b.markers({"<KNE", "<LFC", "<KNEE", "<FLE", "<LE", "<LFE", "<KNEELAT", "<KNEELATERAL", "<LATKNEE", "<KNEEOUT", "<LKNE"}, shank,
            {-0.02, 0.055, 0.012}, 0.002, 4);
  b.markers({"<KNM", "<MFC", "<FME", "<ME", "<MFE", "<KNEEMED", "<KNEEMEDIAL", "<MEDKNEE", "<KNEEIN", "<MKNE"}, shank,
            {-0.02, -0.055, 0.012}, 0.004, 4);
  b.markers({"<HF", "<FAX"}, shank, {-0.03, 0.05, -0.045}, 0.015, 3);
  b.markers({"<TT", "<TTC"}, shank, {0.045, 0, -0.055}, 0.015, 3);
  b.markers({"<SHN", "<TIB", "<SHANK", "<SHIN", "<TIBIA", "<TIAP"}, shank, {0.01, 0.055, -0.2}, 0.05, 3);
  b.markers({"<SHANKUPPER", "<SK1", "<SHANK1", "<TIBA", "<TB1"}, shank, {0.02, 0.05, -0.18}, 0.09, 3);
  b.markers({"<SHANKFRONT", "<SK2", "<SHANK2", "<TIBB", "<TB2"}, shank, {0.04, 0.03, -0.22}, 0.09, 3);
  b.markers({"<SHANKREAR", "<SK3", "<SHANK3", "<TIBC", "<TB3"}, shank, {0, 0.05, -0.24}, 0.09, 3);
  b.markers({"<SK4", "<SHANK4", "<TIBD", "<TB4"}, shank, {0.02, 0.05, -0.24}, 0.09, 3);
  b.markers({"<ANK", "<ANKLE", "<LMAL", "<FAL", "<LM", "<ANKLELAT", "<ANKLELATERAL", "<LATANKLE", "<ANKLEOUT"}, shank, {0, 0.04, -0.405},
            0.006, 0.6);
  b.markers({"<MED", "<MMAL", "<TAM", "<MM", "<MMA", "<ANKLEMED", "<ANKLEMEDIAL", "<MEDANKLE", "<ANKLEIN"}, shank, {0.005, -0.037, -0.4},
            0.008, 0.6);
  b.markers({"<HEE", "<HEEL", "<CAL", "<CA", "<FCC", "<CALC"}, ankle, {-0.055, 0, -0.045}, 0.015);
  b.markers({"<TOE", "<MT2", "<FM2", "<SM", "<TOEB"}, ankle, {0.13, 0, -0.035}, 0.02);
  b.markers({"<TOETIP", "<HALLUX", "<TOEEND"}, ankle, {0.195, 0, -0.06}, 0.02);
  b.markers({"<MT5", "<5TH", "<FM5", "<VM", "<VMH", "<TOELAT", "<LATTOE", "<TOEOUT", "<5MT", "<M5"}, ankle, {0.1, 0.05, -0.055}, 0.02);
  b.markers({"<MT1", "<1ST", "<FM1", "<FM", "<FMH", "<TOEMED", "<MEDTOE", "<TOEIN", "<1MT", "<M1"}, ankle, {0.13, -0.03, -0.05}, 0.02);
  b.markers({"<MIDFOOTSUP"}, ankle, {0.07, 0, -0.01}, 0.03);
  b.markers({"<MIDFOOTLAT"}, ankle, {0.06, 0.045, -0.055}, 0.03);
  return b.finish();
}

/// A person with key points at the joint centres, as video-based systems export them (COCO, OpenPose, HALPE, Theia and Xsens).
MarkerSet make_human_key_points() {
  Builder b("human, key points on the joints");
  const auto [hips, thigh, shank, ankle, chest, head, collar, arm, forearm, hand] = add_person(b);
  (void)collar;
  const double on_joint = 0.012;
  b.marker({"MIDHIP", "HIP", "PELVIS", "HIPS", "CHIP", "MIDPEL", "PELO"}, hips, {}, 0.02);
  b.marker({"NECK", "THORAX", "SPINESHOULDER"}, chest, {0, 0, 0.22}, 0.03);
  b.marker({"HEAD", "HEADTOP"}, head, {0, 0, 0.17}, 0.04);
  b.marker({"NOSE"}, head, {0.11, 0, 0.05}, 0.03);
  b.markers({"<EYE"}, head, {0.085, 0.032, 0.08}, 0.02);
  b.markers({"<EAR"}, head, {0, 0.075, 0.06}, 0.02);
  b.markers({"<SHOULDER", "SHOULDER<", "<SJC", "<SHO"}, arm, {}, on_joint);
  b.markers({"<ELBOW", "ELBOW<", "<EJC"}, forearm, {}, on_joint);
  b.markers({"<WRIST", "WRIST<", "<WJC"}, hand, {}, on_joint);
  b.markers({"<HAND", "HAND<"}, hand, {0, 0.08, 0}, 0.03);
  b.markers({"<HIP", "HIP<", "<HJC", "<FEP"}, thigh, {}, on_joint);
  b.markers({"<KNEE", "KNEE<", "<KJC", "<FEO"}, shank, {}, on_joint);
  b.markers({"<ANKLE", "ANKLE<", "<AJC", "<TIO"}, ankle, {}, on_joint);
  b.markers({"<BIGTOE", "<TOE", "<FOOT", "TOE<"}, ankle, {0.175, -0.015, -0.06}, 0.02);
  b.markers({"<SMALLTOE"}, ankle, {0.14, 0.05, -0.06}, 0.02);
  b.markers({"<HEEL", "HEEL<"}, ankle, {-0.05, 0, -0.05}, 0.02);
  return b.finish();
}

/// A rat-like animal of 0.2 m from snout to tail. For animals of other sizes all lengths are scaled.
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

/// Returns the label in capital letters, without blanks, '_', '-' and '.'.
std::string normalized_label(const std::string& label) {
  std::string out;
  for (const char c : label)
    if (c != ' ' && c != '_' && c != '-' && c != '.') out.push_back(c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c);
  return out;
}

/// Returns the spellings under which sets may list the label: unchanged; side as first letter ("left_knee", "knee.L" -> "LKNEE").
std::vector<std::string> forms_of(const std::string& label) {
  const std::string plain = normalized_label(label);
  std::vector<std::string> out = {plain};
  for (const auto& [word, letter] : {std::pair<std::string_view, char>{"LEFT", 'L'}, {"RIGHT", 'R'}}) {
    if (plain.size() > word.size() && plain.starts_with(word)) out.push_back(letter + plain.substr(word.size()));
    if (plain.size() > word.size() && plain.ends_with(word)) out.push_back(letter + plain.substr(0, plain.size() - word.size()));
  }
  const std::size_t mark = label.find_last_of("_-. ");
  if (mark != std::string::npos && mark > 0 && mark + 2 == label.size()) {
    const std::string side = normalized_label(label.substr(mark + 1));
    if (side == "L" || side == "R") out.push_back(side + normalized_label(label.substr(0, mark)));
  }
  return out;
}

/// Returns the length of a prefix that all labels share up to a separator ("Jim_LASI", "Subject1.RKNE"); 0: none, or under four labels.
std::size_t common_prefix(const std::vector<std::string>& labels) {
  if (labels.size() < 4) return 0;
  std::size_t length = labels[0].size();
  for (const std::string& label : labels) {
    if (label.starts_with('*')) continue;  // labels of unidentified markers begin with *
    std::size_t k = 0;
    while (k < length && k < label.size() && label[k] == labels[0][k]) ++k;
    length = k;
  }
  const std::size_t mark = labels[0].substr(0, length).find_last_of("_-. :");
  return mark == std::string::npos ? 0 : mark + 1;
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

const MarkerSet& human_key_points() {
  static const MarkerSet set = make_human_key_points();
  return set;
}

std::vector<int> match_labels(const MarkerSet& set, const std::vector<std::string>& labels) {
  const std::size_t prefix = common_prefix(labels);
  std::vector<int> out(labels.size(), -1);
  std::vector<char> used(set.markers.size());
  for (std::size_t i = 0; i < labels.size(); ++i) {
    std::string text = labels[i].substr(std::min(prefix, labels[i].size()));
    if (const std::size_t colon = text.rfind(':'); colon != std::string::npos) text.erase(0, colon + 1);
    for (const std::string& label : forms_of(text)) {
      for (std::size_t k = 0; k < set.markers.size() && out[i] < 0; ++k) {
        const auto& names = set.markers[k].labels;
        if (used[k] != 0 || std::find(names.begin(), names.end(), label) == names.end()) continue;
        out[i] = static_cast<int>(k);
        used[k] = 1;
      }
      if (out[i] >= 0) break;
    }
  }
  return out;
}

}  // namespace ugoki::capture
