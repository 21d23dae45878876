#include "ugoki/intake/conversion_report.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/number.h"

namespace ugoki::intake {
namespace {

/// Key phrases of one category of remarks.
struct PhraseList {
  std::vector<std::string> ConversionReport::* part;
  std::vector<std::string_view> phrases;
};
/// Phrase lists in order of precedence: a remark belongs to the first list of which it contains a phrase, otherwise to `read`.
/// The phrases occur in the notes of the readers (formats, robot_formats, scene_formats), of capture and of body: change notes and phrases
/// together.
const std::vector<PhraseList>& phrase_lists() {
  static const std::vector<PhraseList> all = {
      {&ConversionReport::check, {"poor fit", "implausible", "turn over from one frame", "unconnected characters"}},
      {&ConversionReport::left_out, {"left out", "not read", "not used", "skipped"}},
      {&ConversionReport::guessed,
       {"guess", "does not specify", "does not show", "assumed", "estimated", "No human anatomy", "is not known", "chosen by",
        "is uncertain"}},
      {&ConversionReport::changed,
       {"filled", "removed", "filtered", "renamed", "was named", "were named", "replaced", "flipped", "levelled", "shifted", "widened",
        "approximated", "were given", "joints move in this motion", "Soles", "holds it at"}}};
  return all;
}

std::string hertz(double rate) { return to_fixed(rate, std::fabs(rate - std::round(rate)) < 5e-3 ? 0 : 2) + " Hz"; }

std::string time_of(int frames, double rate, double duration) {
  return std::to_string(frames) + (frames == 1 ? " frame" : " frames at " + hertz(rate) + ", " + to_fixed(duration, 2) + " s");
}

std::string unit_words(double metres) {
  const struct {
    double metres;
    const char* words;
  } known[] = {{1, "metres"}, {0.1, "decimetres"}, {0.01, "centimetres"}, {0.001, "millimetres"}, {0.0254, "inches"}, {0.3048, "feet"}};
  for (const auto& unit : known)
    if (std::fabs(unit.metres - metres) < 1e-6 * metres) return unit.words;
  return "units of " + to_fixed(1000 * metres, 3) + " mm";
}

/// Extremes of a motion over about 200 evenly spaced frames, for plausibility checks.
struct MotionExtremes {
  double fastest = 0;  ///< m/s, maximum speed of a joint
  double lowest = 0;   ///< m, minimum height of a joint, world
  double lying = 0;    ///< share of the frames in which the head is less than half the body size above the feet; 0 without head or feet
};

/// True if `name` contains one of the words, ignoring case.
bool contains_any(const std::string& name, std::initializer_list<std::string_view> words) {
  std::string low = name;
  for (char& c : low) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return std::ranges::any_of(words, [&](std::string_view w) { return low.find(w) != std::string::npos; });
}

/// Frames of a calibration pose are left out, because the conversion replaces them. Head and feet are found by joint name, because the
/// anatomy of a character that lies at rest is not recognised.
MotionExtremes find_extremes(const MeasuredMotion& m) {
  int head = -1;
  std::vector<int> feet;
  for (int j = 0; j < m.joint_count(); ++j) {
    const std::string& name = m.skeleton.joints[static_cast<std::size_t>(j)].name;
    if (head < 0 && contains_any(name, {"head"})) head = j;
    if (contains_any(name, {"foot", "ankle"})) feet.push_back(j);
  }
  double size = 0;
  const std::vector<Vec3> rest = rest_positions(m.skeleton);
  for (const Vec3& p : rest) size = std::max(size, norm(p - rest.front()));
  MotionExtremes extremes;
  extremes.lowest = INFINITY;
  std::vector<Pose> X, next;
  int counted = 0, lying = 0;
  const int stride = std::max(1, m.frames / 200);
  for (int f = body::count_calibration_frames(m); f < m.frames; f += stride) {
    m.calc_joint_poses(f, X);
    for (const Pose& pose : X) extremes.lowest = std::min(extremes.lowest, pose.p.z);
    if (f + 1 < m.frames) {
      m.calc_joint_poses(f + 1, next);
      for (std::size_t j = 0; j < X.size(); ++j) extremes.fastest = std::max(extremes.fastest, norm(next[j].p - X[j].p) * m.rate);
    }
    if (head < 0 || feet.empty()) continue;
    double foot = 0;
    for (const int j : feet) foot += X[static_cast<std::size_t>(j)].p.z / static_cast<double>(feet.size());
    ++counted;
    if (X[static_cast<std::size_t>(head)].p.z - foot < 0.5 * size) ++lying;
  }
  extremes.lying = counted > 0 ? static_cast<double>(lying) / counted : 0;
  return extremes;
}

}  // namespace

std::string list_of(const std::vector<std::string>& names, std::size_t maximum) {
  std::string text;
  const std::size_t shown = names.size() > maximum + 1 ? maximum : names.size();
  for (std::size_t i = 0; i < shown; ++i) text += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
  if (shown < names.size()) text += " and " + std::to_string(names.size() - shown) + " more";
  return text;
}

void ConversionReport::add_remarks(const std::vector<std::string>& remarks) {
  for (const std::string& remark : remarks) {
    auto* part = &read;
    for (const PhraseList& row : phrase_lists()) {
      if (std::ranges::none_of(row.phrases, [&](std::string_view w) { return remark.find(w) != std::string::npos; })) continue;
      part = &(this->*row.part);
      break;
    }
    if (std::ranges::find(*part, remark) == part->end()) part->push_back(remark);
  }
}

void describe(ConversionReport& report, const std::vector<MeasuredMotion>& motions) {
  const MeasuredMotion& first = motions.front();
  if (motions.size() == 1) {
    report.read.push_back(time_of(first.frames, first.rate, first.duration()) + ".");
  } else {
    std::vector<std::string> names;
    for (const MeasuredMotion& m : motions) names.push_back(m.name + " (" + to_fixed(m.duration(), 2) + " s)");
    report.read.push_back(std::to_string(motions.size()) + " motions of one skeleton at " + hertz(first.rate) + ": " + list_of(names) +
                          ".");
  }
  std::vector<std::string> joints;
  for (const SkeletonJoint& joint : first.skeleton.joints) joints.push_back(joint.name);
  report.read.push_back(std::to_string(joints.size()) + (joints.size() == 1 ? " joint: " : " joints: ") + list_of(joints) + ".");
  if (first.skeleton.unit > 0) report.read.push_back("The file's unit of length is " + unit_words(first.skeleton.unit) + ".");
  if (first.frames < 2) report.check.push_back("The file contains a single frame: a pose without motion.");
}

void describe(ConversionReport& report, const MarkerMotion& m) {
  report.read.push_back(std::to_string(m.marker_count()) + " markers: " + list_of(m.labels) + ".");
  const double seen = seen_share(m);
  report.read.push_back("Markers are visible in " + to_fixed(100 * seen, 1) + " % of all positions.");
  if (seen < 0.9)
    report.check.push_back("A tenth or more of the marker positions are missing (" + to_fixed(100 * (1 - seen), 0) +
                           " %): check that the character moves plausibly where markers were lost.");
  if (!m.analog.empty()) {
    std::vector<std::string> channels;
    for (const AnalogChannel& channel : m.analog) channels.push_back(channel.label);
    report.read.push_back(std::to_string(m.analog.size()) + " analog channels at " + hertz(m.analog_rate) + ": " + list_of(channels) + ".");
    report.left_out.push_back("Analog channels are not imported: the library stores the body and its motion.");
  }
  if (!m.plates.empty())
    report.read.push_back(std::to_string(m.plates.size()) + (m.plates.size() == 1 ? " force platform." : " force platforms."));
  if (!m.events.empty()) {
    std::vector<std::string> events;
    for (const MarkedEvent& e : m.events)
      events.push_back((e.context.empty() ? "" : e.context + " ") + e.label + " at " + to_fixed(e.time, 2) + " s");
    report.read.push_back(std::to_string(m.events.size()) + " marked events: " + list_of(events, 4) + ".");
    report.left_out.push_back("Marked events are not imported: foot contacts are detected from the motion.");
  }
}

void describe(ConversionReport& report, const body::Body& body, const MeasuredMotion& measured) {
  const Mechanism& m = *body.mechanism;
  report.changed.push_back("A body of " + to_fixed(body.height, 2) + " m and " + to_fixed(body.mass, 1) + " kg with " +
                           std::to_string(m.nv()) + " degrees of freedom was made for the skeleton.");
  const MotionExtremes extremes = find_extremes(measured);
  if (body.human && (body.height < 0.5 || body.height > 2.6))
    report.check.push_back("The person is " + to_fixed(body.height, 2) +
                           " m tall: the unit of length is probably wrong; set it in the import options.");
  else if (!body.human && (body.height < 0.01 || body.height > 12))
    report.check.push_back("The character is " + to_fixed(body.height, body.height < 0.1 ? 4 : 1) +
                           " m tall: the unit of length is probably wrong; set it in the import options.");
  // The head of a four-legged animal that walks or grazes is often as low as its hips.
  if (extremes.lying > 0.8 && body.anatomy.plan != "four legs")
    report.check.push_back(
        "The character lies on its side or hangs head down in nearly all frames: if it should stand, another axis points up.");
  const double fast = body.human ? 25 : 40;
  if (extremes.fastest > fast)
    report.check.push_back("A joint moves at " + to_fixed(extremes.fastest, 0) +
                           " m/s: check the frame rate and the unit of length, and whether the data jump.");
  if (body.human && extremes.lying < 0.8 && (extremes.lowest > 0.6 || extremes.lowest < -0.6))
    report.check.push_back("The lowest joint in the file is at " + to_fixed(extremes.lowest, 2) +
                           " m: the floor of the file is not at height 0.");
}

void describe(ConversionReport& report, const Mechanism& m) {
  std::size_t shapes = 0, massless = 0;
  for (const Link& link : m.links()) {
    shapes += link.shapes.size();
    massless += link.inertia.mass > 0 ? 0 : 1;
  }
  report.read.push_back(std::to_string(m.link_count()) + (m.link_count() == 1 ? " link, " : " links, ") + std::to_string(m.nv()) +
                        (m.nv() == 1 ? " degree of freedom, " : " degrees of freedom, ") + to_fixed(m.mass(), m.mass() < 10 ? 2 : 1) +
                        " kg.");
  if (m.has_loops()) report.read.push_back(std::to_string(m.loops().size()) + (m.loops().size() == 1 ? " closed loop." : " closed loops."));
  if (shapes == 0) report.check.push_back("No link has a shape: the mechanism is invisible and has no collisions.");
  if (massless == static_cast<std::size_t>(m.link_count()))
    report.check.push_back("No link has mass: add masses before simulating the mechanism.");
}

}  // namespace ugoki::intake
