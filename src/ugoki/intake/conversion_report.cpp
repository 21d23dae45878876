#include "ugoki/intake/conversion_report.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/number.h"

namespace ugoki::intake {
namespace {

/// Words that show what a reader did; the first row with one of its words in a sentence says where it belongs.
struct Words {
  std::vector<std::string> ConversionReport::* part;
  std::vector<std::string_view> words;
};
const std::vector<Words>& parts_by_words() {
  static const std::vector<Words> all = {
      {&ConversionReport::check,
       {"poor fit", "not believed", "no person's size", "give the unit", "turn over from one frame", "give --", "figures that do not"}},
      {&ConversionReport::left_out,
       {"left out", "not read", "passed over", "Not used", "not used", "ignored", "cannot be used", "skipped", "dropped", "are not taken",
        "is not taken", "not there", "absent"}},
      {&ConversionReport::guessed,
       {"guess", "does not tell", "is taken", "are taken as", "taken as", "estimated", "kg/m^2", "from legs of", "No human anatomy",
        "is not known", "those of usual feet", "chosen by", "assumed"}},
      {&ConversionReport::changed, {"filled",    "taken out",  "filtered",     "renamed",  "got a number", "got numbers",
                                    "is called", "replaced",   "levelled",     "shifted",  "widened",      "repaired",
                                    "mended",    "moved to",   "approximated", "invented", "interpolated", "joints move in this motion",
                                    "Soles",     "holds it at"}}};
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

/// What moves faster, floats or lies, over at most 200 frames.
struct Look {
  double fastest = 0;  ///< m/s, of any joint
  double lowest = 0;   ///< m, world
  double lying = 0;    ///< share of the frames in which the head is not well above the feet
};

/// True if `name` holds one of the words, in any case.
bool has_word(const std::string& name, std::initializer_list<std::string_view> words) {
  std::string low = name;
  for (char& c : low) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return std::ranges::any_of(words, [&](std::string_view w) { return low.find(w) != std::string::npos; });
}

/// Names are asked where no human was recognised: one that lies at rest is not.
Look look_at(const MeasuredMotion& m) {
  int head = -1;
  std::vector<int> feet;
  for (int j = 0; j < m.joint_count(); ++j) {
    const std::string& name = m.skeleton.joints[static_cast<std::size_t>(j)].name;
    if (head < 0 && has_word(name, {"head"})) head = j;
    if (has_word(name, {"foot", "ankle"})) feet.push_back(j);
  }
  double size = 0;
  const std::vector<Vec3> rest = rest_positions(m.skeleton);
  for (const Vec3& p : rest) size = std::max(size, norm(p - rest.front()));
  Look look;
  look.lowest = INFINITY;
  std::vector<Pose> X, next;
  int counted = 0, lying = 0;
  const int stride = std::max(1, m.frames / 200);
  for (int f = 0; f < m.frames; f += stride) {
    m.calc_joint_poses(f, X);
    for (const Pose& pose : X) look.lowest = std::min(look.lowest, pose.p.z);
    if (f + 1 < m.frames) {
      m.calc_joint_poses(f + 1, next);
      for (std::size_t j = 0; j < X.size(); ++j) look.fastest = std::max(look.fastest, norm(next[j].p - X[j].p) * m.rate);
    }
    if (head < 0 || feet.empty()) continue;
    double foot = 0;
    for (const int j : feet) foot += X[static_cast<std::size_t>(j)].p.z / static_cast<double>(feet.size());
    ++counted;
    if (X[static_cast<std::size_t>(head)].p.z - foot < 0.5 * size) ++lying;
  }
  look.lying = counted > 0 ? static_cast<double>(lying) / counted : 0;
  return look;
}

}  // namespace

std::string list_of(const std::vector<std::string>& names, std::size_t most) {
  std::string text;
  const std::size_t shown = names.size() > most + 1 ? most : names.size();
  for (std::size_t i = 0; i < shown; ++i) text += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
  if (shown < names.size()) text += " and " + std::to_string(names.size() - shown) + " more";
  return text;
}

void ConversionReport::add_remarks(const std::vector<std::string>& remarks) {
  for (const std::string& remark : remarks) {
    auto* part = &read;
    for (const Words& row : parts_by_words()) {
      if (std::ranges::none_of(row.words, [&](std::string_view w) { return remark.find(w) != std::string::npos; })) continue;
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
  if (first.skeleton.unit > 0) report.read.push_back("Lengths of the file are " + unit_words(first.skeleton.unit) + ".");
  if (first.frames < 2) report.check.push_back("There is one frame only: a pose, no motion.");
}

void describe(ConversionReport& report, const MarkerMotion& m) {
  report.read.push_back(std::to_string(m.marker_count()) + " markers: " + list_of(m.labels) + ".");
  const double seen = seen_share(m);
  report.read.push_back("Markers are seen in " + to_fixed(100 * seen, 1) + " % of the places.");
  if (seen < 0.9)
    report.check.push_back("A tenth or more of the markers' places is missing (" + to_fixed(100 * (1 - seen), 0) +
                           " %): look whether the figure follows the markers where they were lost.");
  if (!m.analog.empty()) {
    std::vector<std::string> channels;
    for (const AnalogChannel& channel : m.analog) channels.push_back(channel.label);
    report.read.push_back(std::to_string(m.analog.size()) + " analog channels at " + hertz(m.analog_rate) + ": " + list_of(channels) + ".");
    report.left_out.push_back("Analog channels stay in the file: the library keeps the body and its motion.");
  }
  if (!m.plates.empty())
    report.read.push_back(std::to_string(m.plates.size()) + (m.plates.size() == 1 ? " force platform." : " force platforms."));
  if (!m.events.empty()) {
    std::vector<std::string> events;
    for (const MarkedEvent& e : m.events)
      events.push_back((e.context.empty() ? "" : e.context + " ") + e.label + " at " + to_fixed(e.time, 2) + " s");
    report.read.push_back(std::to_string(m.events.size()) + " marked events: " + list_of(events, 4) + ".");
    report.left_out.push_back("Marked events stay in the file: foot contacts are found anew from the motion.");
  }
}

void describe(ConversionReport& report, const body::Body& body, const MeasuredMotion& measured) {
  const Mechanism& m = *body.mechanism;
  report.changed.push_back("A body of " + to_fixed(body.height, 2) + " m and " + to_fixed(body.mass, 1) + " kg with " +
                           std::to_string(m.nv()) + " freedoms was made on the skeleton.");
  const Look look = look_at(measured);
  if (body.human && (body.height < 0.5 || body.height > 2.6))
    report.check.push_back("The person comes out " + to_fixed(body.height, 2) + " m tall: the unit of length is probably another one.");
  else if (!body.human && (body.height < 0.01 || body.height > 12))
    report.check.push_back("The figure comes out " + to_fixed(body.height, body.height < 0.1 ? 4 : 1) +
                           " m tall: the unit of length is probably another one.");
  if (look.lying > 0.8)
    report.check.push_back(
        "The figure lies on its side or hangs head down nearly all the time: if it should stand, another axis points up.");
  const double fast = body.human ? 25 : 40;
  if (look.fastest > fast)
    report.check.push_back("A joint moves at " + to_fixed(look.fastest, 0) +
                           " m/s: the frame rate or the unit of length is wrong, or the data jump.");
  if (body.human && look.lying < 0.8 && (look.lowest > 0.6 || look.lowest < -0.6))
    report.check.push_back("In the file the lowest joint is at " + to_fixed(look.lowest, 2) + " m: its floor is not at height 0.");
}

void describe(ConversionReport& report, const Mechanism& m) {
  std::size_t shapes = 0, massless = 0;
  for (const Link& link : m.links()) {
    shapes += link.shapes.size();
    massless += link.inertia.mass > 0 ? 0 : 1;
  }
  report.read.push_back(std::to_string(m.link_count()) + (m.link_count() == 1 ? " link, " : " links, ") + std::to_string(m.nv()) +
                        (m.nv() == 1 ? " freedom, " : " freedoms, ") + to_fixed(m.mass(), m.mass() < 10 ? 2 : 1) + " kg.");
  if (m.has_loops()) report.read.push_back(std::to_string(m.loops().size()) + (m.loops().size() == 1 ? " closed loop." : " closed loops."));
  if (shapes == 0) report.check.push_back("No link has a shape: the mechanism moves, but nothing of it is seen and nothing can touch it.");
  if (massless == static_cast<std::size_t>(m.link_count())) report.check.push_back("No link has mass.");
}

}  // namespace ugoki::intake
