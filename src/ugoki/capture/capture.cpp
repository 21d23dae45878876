#include "ugoki/capture/capture.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "ugoki/base/number.h"
#include "ugoki/capture/calibrate.h"
#include "ugoki/capture/gap_filling.h"
#include "ugoki/capture/label_check.h"
#include "ugoki/capture/unlabelled.h"
#include "ugoki/motion/marker_repair.h"

namespace ugoki::capture {
namespace {

std::string millimetres(double metres) { return to_fixed(1000 * metres, 1) + " mm"; }

/// The marker set that contains most of the recording's labels. `set` is null if no set contains any label.
struct Choice {
  const MarkerSet* set = nullptr;
  std::vector<int> match;  // [labels] result of match_labels
  int known = 0;           // number of matched labels
};
Choice choose_set(const MarkerMotion& motion) {
  const std::size_t n = motion.labels.size();
  std::vector<int> seen(n, 0);
  for (std::size_t k = 0; k < motion.residuals.size(); ++k) seen[k % n] += motion.residuals[k] >= 0 ? 1 : 0;
  Choice best;
  for (const MarkerSet* set : {&human_markers(), &human_key_points(), &quadruped_key_points()}) {
    Choice c{set, match_labels(*set, motion.labels), 0};
    // Labels that are never seen (for example an upper body that was not captured) are not markers of the recording, if they are more than
    // a third of the matched labels. Fewer unseen labels are kept, because the positions of these markers follow from the body.
    std::size_t matched = 0, unseen = 0;
    for (std::size_t k = 0; k < n; ++k) {
      matched += c.match[k] >= 0 ? 1 : 0;
      unseen += c.match[k] >= 0 && seen[k] == 0 ? 1 : 0;
    }
    for (std::size_t k = 0; k < n; ++k)
      if (seen[k] == 0 && 3 * unseen > matched) c.match[k] = -1;
    for (const int i : c.match) c.known += i >= 0 ? 1 : 0;
    if (c.known > best.known) best = std::move(c);
  }
  return best;
}

/// Number of segments that have at least one marker in the recording.
int marked_segments(const Choice& choice) {
  std::vector<char> marked(choice.set->segments.size());
  for (const int i : choice.match)
    if (i >= 0) marked[static_cast<std::size_t>(choice.set->markers[static_cast<std::size_t>(i)].segment)] = 1;
  return static_cast<int>(std::count(marked.begin(), marked.end(), 1));
}

/// Returns a list of the set's markers that the recording does not contain.
std::string missing_labels(const Choice& choice) {
  std::string out;
  for (std::size_t k = 0; k < choice.set->markers.size(); ++k) {
    if (std::find(choice.match.begin(), choice.match.end(), static_cast<int>(k)) != choice.match.end()) continue;
    out += (out.empty() ? "" : ", ") + choice.set->markers[k].labels[0];
  }
  return out;
}

/// Returns the DOFs of a segment's joint in the skeleton; ball joints have three axes without limits.
std::vector<MeasuredDof> dofs_of(const ModelSegment& s) {
  switch (s.joint) {
    case ModelJoint::hinge: return {{s.axis, true, s.lower, s.upper}};
    case ModelJoint::universal: return {{s.axis, true, s.lower, s.upper}, {s.second_axis, true, s.lower2, s.upper2}};
    case ModelJoint::fixed: return {};
    case ModelJoint::root:
    case ModelJoint::ball: break;
  }
  return {{{0, 0, 1}}, {{0, 1, 0}}, {{1, 0, 0}}};
}

Skeleton skeleton_of(const Subject& subject, const std::string& name, double unit) {
  Skeleton out;
  out.name = name;
  out.unit = unit;
  for (std::size_t i = 0; i < subject.segment_count(); ++i) {
    const ModelSegment& s = subject.segment(i);
    SkeletonJoint j;
    j.name = s.name;
    j.parent = s.parent;
    j.offset = subject.offsets[i];
    for (const Vec3& e : s.end_sites) j.end_sites.push_back(e * subject.size);
    j.dofs = dofs_of(s);
    j.translates = s.parent < 0;
    out.joints.push_back(std::move(j));
  }
  return out;
}

/// Solves all frames of a recording and fills the result with motion and residuals.
class Solver {
 public:
  Solver(const MarkerMotion& recorded, const MarkerMotion& clean, Subject subject, Capture& out)
      : recorded_(recorded), clean_(clean), subject_(std::move(subject)), out_(out) {}

  void run(const ModelPose& first, int from, const std::function<bool()>& cancelled) {
    out_.measured.frames = clean_.frames;
    const std::size_t n = subject_.segment_count();
    out_.measured.translations.resize(static_cast<std::size_t>(clean_.frames) * n);
    out_.measured.rotations.resize(static_cast<std::size_t>(clean_.frames) * n);
    out_.frame_rms.resize(static_cast<std::size_t>(clean_.frames));
    for (std::size_t m = 0; m < subject_.columns.size(); ++m) {
      MarkerResidual r;
      r.label = clean_.labels[static_cast<std::size_t>(subject_.columns[m])];
      r.segment = subject_.segment(static_cast<std::size_t>(subject_.marker(m).segment)).name;
      out_.residuals.push_back(std::move(r));
    }
    squares_.assign(subject_.columns.size(), 0);
    seen_.assign(subject_.columns.size(), 0);
    solve_frames(clean_, subject_, first, from, cancelled,
                 [this](int f, const PoseSolver& solver, const ModelPose& pose) { add_frame(f, solver, pose); });
    finish();
  }

 private:
  void add_frame(int frame, const PoseSolver& solver, const ModelPose& pose) {
    const std::size_t n = subject_.segment_count(), at = static_cast<std::size_t>(frame) * n;
    for (std::size_t i = 0; i < n; ++i) {
      out_.measured.translations[at + i] = subject_.segment(i).parent < 0 ? pose.p : subject_.offsets[i];
      out_.measured.rotations[at + i] = joint_rotation(subject_, pose, i);
    }
    if (frame % std::max(1, clean_.frames / 200) == 0) compare_pairs(frame, solver);
    double sum = 0;
    int count = 0;
    for (std::size_t m = 0; m < subject_.columns.size(); ++m) {
      if (!recorded_.seen(frame, subject_.columns[m])) continue;
      const double error = norm(marker_position(subject_, solver.kinematics(), m) - recorded_.at(frame, subject_.columns[m]));
      sum += error * error;
      ++count;
      squares_[m] += error * error;
      ++seen_[m];
      if (error <= out_.residuals[m].maximum) continue;
      out_.residuals[m].maximum = error;
      out_.residuals[m].worst_frame = frame;
    }
    out_.frame_rms[static_cast<std::size_t>(frame)] = count > 0 ? std::sqrt(sum / count) : 0;
  }

  /// Counts the pairs of markers that are far from their own positions on the body, but close to each other's.
  void compare_pairs(int frame, const PoseSolver& solver) {
    const std::size_t n = subject_.columns.size();
    pairs_.resize(n * n);
    // Places of the markers on the body: as fitted, and as the marker set gives them. The fit adapts to labels that are always exchanged.
    std::vector<Vec3> fitted(n), usual(n);
    for (std::size_t m = 0; m < n; ++m) {
      const auto s = static_cast<std::size_t>(subject_.marker(m).segment);
      fitted[m] = marker_position(subject_, solver.kinematics(), m);
      usual[m] = solver.kinematics().p[s] + solver.kinematics().R[s] * usual_place(subject_, m);
    }
    const auto exchanged = [&](std::size_t a, std::size_t b, const std::vector<Vec3>& place, double limit) {
      const Vec3 &A = recorded_.at(frame, subject_.columns[a]), &B = recorded_.at(frame, subject_.columns[b]);
      const double own = std::min(norm(A - place[a]), norm(B - place[b])), other = std::max(norm(A - place[b]), norm(B - place[a]));
      return own > limit * subject_.size && other < 0.5 * own;
    };
    for (std::size_t a = 0; a < n; ++a)
      for (std::size_t b = 0; b < a; ++b) {
        if (!recorded_.seen(frame, subject_.columns[a]) || !recorded_.seen(frame, subject_.columns[b])) continue;
        PairCount& pair = pairs_[a * n + b];
        ++pair.seen;
        // Markers of clusters (sigma of 5 cm and more) may be anywhere on their segment.
        const bool landmarks = std::max(subject_.marker(a).sigma, subject_.marker(b).sigma) < 0.05;
        if (!exchanged(a, b, fitted, min_exchange) && !(landmarks && exchanged(a, b, usual, 1.5 * min_exchange))) continue;
        if (pair.exchanged++ == 0) pair.first = frame;
      }
  }

  /// Reports the pairs of markers whose labels are exchanged in at least a twentieth of the compared frames.
  void report_exchanged() {
    const std::size_t n = subject_.columns.size();
    for (std::size_t a = 0; a < n && !pairs_.empty(); ++a)
      for (std::size_t b = 0; b < a; ++b) {
        const PairCount& pair = pairs_[a * n + b];
        if (pair.exchanged < 2 || 20 * pair.exchanged < pair.seen) continue;
        out_.report.push_back("The labels " + out_.residuals[b].label + " and " + out_.residuals[a].label + " are probably exchanged in " +
                              std::to_string(100 * pair.exchanged / pair.seen) + " % of the frames (first in frame " +
                              std::to_string(recorded_.first_frame + pair.first) +
                              "): each marker is closer to the other's place on the body than to its own. Exchange the labels there.");
      }
  }

  void finish() {
    report_exchanged();
    double squares = 0;
    long seen = 0;
    for (std::size_t m = 0; m < squares_.size(); ++m) {
      MarkerResidual& r = out_.residuals[m];
      r.rms = seen_[m] > 0 ? std::sqrt(squares_[m] / static_cast<double>(seen_[m])) : 0;
      r.seen = static_cast<double>(seen_[m]) / recorded_.frames;
      squares += squares_[m];
      seen += seen_[m];
    }
    out_.rms = seen > 0 ? std::sqrt(squares / static_cast<double>(seen)) : 0;
    out_.measured.skeleton = skeleton_of(subject_, recorded_.name, recorded_.unit);
  }

  // m, for a person of 1.75 m: markers farther than this from their places on the body are not explained by skin motion or placement.
  static constexpr double min_exchange = 0.04;
  /// How often a pair of markers was seen together, and how often each was closer to the other's place.
  struct PairCount {
    int seen = 0, exchanged = 0, first = 0;
  };

  const MarkerMotion& recorded_;
  const MarkerMotion& clean_;
  Subject subject_;
  Capture& out_;
  std::vector<PairCount> pairs_;  // [markers][markers], the first index is larger
  std::vector<double> squares_;
  std::vector<long> seen_;
};

/// True if all seen marker positions are within 1 mm of one plane, as in a projected recording. Such a recording does not determine a pose.
bool is_planar(const MarkerMotion& m) {
  Vec3 middle;
  double count = 0;
  for (std::size_t i = 0; i < m.positions.size(); ++i) {
    if (m.residuals[i] < 0) continue;
    middle += m.positions[i];
    count += 1;
  }
  middle = middle / std::max(1.0, count);
  // Normal of the plane: cross product of the farthest point and the point with the largest cross product with it, relative to the mean.
  Vec3 a, normal;
  for (std::size_t i = 0; i < m.positions.size(); ++i)
    if (m.residuals[i] >= 0 && norm(m.positions[i] - middle) > norm(a)) a = m.positions[i] - middle;
  for (std::size_t i = 0; i < m.positions.size(); ++i) {
    if (m.residuals[i] < 0) continue;
    const Vec3 n = cross(a, m.positions[i] - middle);
    if (norm(n) > norm(normal)) normal = n;
  }
  normal = normalized(normal);
  for (std::size_t i = 0; i < m.positions.size(); ++i)
    if (m.residuals[i] >= 0 && std::fabs(dot(normal, m.positions[i] - middle)) > 1e-3) return false;
  return true;
}

/// Returns the markers without spikes and short gaps, low-pass filtered. Long gaps remain. @param report receives one sentence a change
MarkerMotion clean(const MarkerMotion& motion, const CaptureOptions& options, std::vector<std::string>& report) {
  MarkerMotion out = motion;
  if (const int spikes = remove_spikes(out); spikes > 0)
    report.push_back(spikes == 1 ? "1 spike was removed." : std::to_string(spikes) + " spikes were removed.");
  if (const int filled = fill_short_gaps(out, options.longest_gap); filled > 0)
    report.push_back(std::to_string(filled) + " positions in short gaps were filled by splines.");
  const double cutoff = options.cutoff == 0 ? choose_cutoff(out, options.cancelled) : options.cutoff;
  if (cutoff > 0 && cutoff < out.rate / 3) {
    filter_markers(out, cutoff);
    report.push_back("The markers were filtered at " + to_fixed(cutoff, 1) + " Hz" +
                     (options.cutoff == 0 ? ", chosen by residual analysis." : "."));
  }
  return out;
}

Error cancelled_error(const MarkerMotion& motion) {
  return {ErrorCode::cancelled, motion.source, "The reconstruction of the body from the markers was cancelled.", "Run it again."};
}

/// A subject calibrated to a recording.
struct Fit {
  std::string set_name;
  Subject subject;
  ModelPose first;                  // pose in frame `from`
  int from = 0;                     // frame in which the solver begins
  std::vector<std::string> unused;  // labels unknown to the set
};

/// Chooses a marker set and fits a subject to the recording. @param motion the recording @param markers the recording after clean()
Result<Fit> fit_subject(const MarkerMotion& motion, const MarkerMotion& markers, const CaptureOptions& options) {
  const Choice choice = choose_set(motion);
  // 7 points are the pelvis and the joint centres of both legs.
  const int segments = choice.set != nullptr ? marked_segments(choice) : 0;
  if (!((choice.known >= 8 && segments >= 4) || (choice.known >= 7 && segments >= 6)))
    return fail(ErrorCode::unsupported, motion.source,
                std::to_string(choice.known) + " of " + std::to_string(motion.labels.size()) +
                    " markers have a label of a known marker set; at least 8 on 4 segments, or 7 on 6, are needed to find a body.",
                "Name the markers as Plug-in Gait does (LASI, RASI, LKNE ...) or, for animals, by their joints (ShoulderL, KneeR ...)." +
                    (choice.set != nullptr ? " Labels missing from the set '" + choice.set->name + "': " + missing_labels(choice) + "."
                                           : std::string()));
  if (is_planar(motion))
    return fail(ErrorCode::unsupported, motion.source, "All markers lie in one plane, so no body in space can be reconstructed.",
                "Use the recording from which the plane was projected.");
  Fit out;
  out.set_name = choice.set->name;
  for (std::size_t i = 0; i < choice.match.size(); ++i)
    if (choice.match[i] < 0) out.unused.push_back(motion.labels[i]);
  const double size = estimate_size(*choice.set, choice.match, markers);
  if (!(size > 1e-3 && size < 1e3) && pairs_for_size(*choice.set, choice.match).empty())
    return fail(ErrorCode::unsupported, motion.source,
                "All known markers belong to clusters on limbs; no two of them are on bony landmarks of one segment or of adjacent "
                "segments, so the subject's size cannot be estimated.",
                "Import the static trial with markers on landmarks (LASI, LKNE, LANK ...), or give these labels to the markers that are "
                "on landmarks.");
  if (!(size > 1e-3 && size < 1e3))
    return fail(ErrorCode::structure, motion.source,
                "No two markers on landmarks of adjacent segments are seen in one frame, so the subject's size cannot be estimated.",
                "Check that the recording contains one subject and that its markers are labelled.");
  out.subject = make_subject(*choice.set, choice.match, size);
  const std::vector<int> chosen = choose_frames(markers, out.subject, options.calibration_frames);
  if (chosen.empty())
    return fail(ErrorCode::structure, motion.source, "In no frame more than half of the markers are seen.",
                "Label the markers, or cut the recording to the frames in which they are seen.");
  std::vector<MeasuredFrame> frames;
  for (const int f : chosen) frames.push_back(measured_frame(markers, out.subject, f));
  PoseSolver solver;
  std::vector<ModelPose> poses(frames.size());
  find_first_pose(solver, out.subject, frames[0], poses[0]);
  for (std::size_t i = 1; i < frames.size(); ++i) {
    poses[i] = poses[i - 1];
    PoseOptions options_far;
    options_far.outlier = 1e3;
    solver.solve(out.subject, frames[i], options_far, poses[i]);
  }
  turn_limbs(out.subject, frames, poses);
  calibrate(out.subject, frames, poses, options.cancelled);
  if (turn_limbs(out.subject, frames, poses)) calibrate(out.subject, frames, poses, options.cancelled);
  mirror_unseen_offsets(out.subject, frames);
  out.first = poses[0];
  out.from = chosen[0];
  return out;
}

/// Returns the longest range of frames in which the body's pose is known; interruptions of up to half a second are included.
std::pair<int, int> known_part(const MarkerMotion& markers, const Subject& subject) {
  const int bridge = static_cast<int>(0.5 * markers.rate);
  int best_from = 0, best_to = -1, from = -1, last = -1;
  for (int f = 0; f < markers.frames; ++f) {
    if (!enough_markers_seen(markers, subject, f)) continue;
    if (from < 0 || f - last > bridge + 1) from = f;
    last = f;
    if (last - from > best_to - best_from) {
      best_from = from;
      best_to = last;
    }
  }
  return {best_from, best_to};
}

/// Cuts the converted motion to the frames `from` to `to`, both included.
void trim(Capture& out, int from, int to) {
  const std::size_t n = out.measured.skeleton.joints.size();
  const auto cut = [&](auto& list, std::size_t width) {
    list.erase(list.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(to + 1) * width), list.end());
    list.erase(list.begin(), list.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(from) * width));
  };
  cut(out.measured.translations, n);
  cut(out.measured.rotations, n);
  cut(out.frame_rms, 1);
  out.measured.frames = to - from + 1;
}

/// Fills long gaps from the body's pose. @param report receives two counts: frames with an unknown pose, filled positions
void fill_by_body(MarkerMotion& markers, const Fit& fit, const std::function<bool()>& cancelled, std::vector<std::string>& report) {
  int unknown = 0;
  for (int f = 0; f < markers.frames; ++f) unknown += enough_markers_seen(markers, fit.subject, f) ? 0 : 1;
  if (unknown > 0)
    report.push_back("In " + std::to_string(unknown) +
                     " frames fewer than a third of the markers are seen; the pose in these frames is not known and " +
                     "is kept close to the last known one.");
  if (const int carried = fill_gaps_by_body(markers, fit.subject, fit.first, fit.from, cancelled); carried > 0)
    report.push_back(std::to_string(carried) + " positions in long gaps were filled from the pose of the body.");
}

}  // namespace

FilledMarkers fill_markers(const MarkerMotion& motion, const CaptureOptions& options) {
  FilledMarkers out;
  CaptureOptions unfiltered = options;
  unfiltered.cutoff = -1;
  MarkerMotion markers = clean(motion, unfiltered, out.report);
  const Result<Fit> fit = fit_subject(motion, markers, options);
  if (fit)
    fill_by_body(markers, *fit, options.cancelled, out.report);
  else
    out.report.push_back("Long gaps could not be filled from a body: " + fit.error().problems.front().message);
  if (const int carried = fill_gaps_by_neighbours(markers); carried > 0)
    out.report.push_back(std::to_string(carried) + " positions in long gaps were filled from markers that move with them as a rigid body.");
  out.markers = motion;
  remove_spikes(out.markers);
  int open = 0;
  for (std::size_t i = 0; i < motion.residuals.size(); ++i) {
    if (out.markers.residuals[i] >= 0) continue;
    out.markers.positions[i] = markers.positions[i];
    out.markers.residuals[i] = markers.residuals[i];
    open += markers.residuals[i] < 0 ? 1 : 0;
  }
  if (open > 0) out.report.push_back(std::to_string(open) + " positions could not be filled and stay unseen.");
  return out;
}

namespace {

/// Reports labels that are exchanged in the whole recording. @return the recording with correct labels if the options ask for it
std::optional<MarkerMotion> correct_labels(const MarkerMotion& motion, const CaptureOptions& options, std::vector<std::string>& report) {
  const Choice choice = choose_set(motion);
  if (choice.set == nullptr || choice.known < 8) return std::nullopt;
  const LabelCheck check = check_labels(*choice.set, choice.match, motion);
  MarkerMotion out = motion;
  const std::string end = options.correct_labels ? "; they were corrected." : ". Import it with corrected labels (--correct-labels).";
  std::vector<int> match = choice.match;
  for (const auto& [i, j] : check.pairs) {
    const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
    report.push_back("The labels " + out.labels[b] + " and " + out.labels[a] + " are exchanged in the whole recording" + end);
    std::swap(out.labels[a], out.labels[b]);
    std::swap(match[a], match[b]);
  }
  if (check.mirrored) {
    for (int a = 0; a < motion.marker_count(); ++a)
      if (const int b = opposite_column(*choice.set, match, a); b > a)
        std::swap(out.labels[static_cast<std::size_t>(a)], out.labels[static_cast<std::size_t>(b)]);
    report.push_back("Left and right are exchanged in the whole recording" + end);
  }
  if (!options.correct_labels || (!check.mirrored && check.pairs.empty())) return std::nullopt;
  return out;
}

}  // namespace

Result<Capture> solve_markers(const MarkerMotion& recorded, const CaptureOptions& options) {
  Capture out;
  const std::optional<MarkerMotion> corrected = correct_labels(recorded, options, out.report);
  const MarkerMotion& motion = corrected ? *corrected : recorded;
  MarkerMotion markers = clean(motion, options, out.report);
  Result<Fit> fit = fit_subject(motion, markers, options);
  if (!fit) return fail(std::move(fit.error()));
  if (options.cancelled && options.cancelled()) return fail(cancelled_error(motion));
  for (std::string& sentence : use_unlabelled(markers, fit->subject, fit->first, fit->from, options.cancelled))
    out.report.push_back(std::move(sentence));
  const auto [from, to] = known_part(markers, fit->subject);
  fill_by_body(markers, *fit, options.cancelled, out.report);
  out.marker_set = fit->set_name;
  out.measured.name = motion.name;
  out.measured.source = motion.source;
  out.measured.rate = motion.rate;
  out.size = fit->subject.size;
  out.unused = std::move(fit->unused);
  Solver(motion, markers, std::move(fit->subject), out).run(fit->first, fit->from, options.cancelled);
  if (options.cancelled && options.cancelled()) return fail(cancelled_error(motion));
  if (to >= from && to - from + 1 < motion.frames) {
    trim(out, from, to);
    out.report.push_back("The motion was cut to the frames " + std::to_string(motion.first_frame + from) + " to " +
                         std::to_string(motion.first_frame + to) + ", in which enough markers are seen; the recording has " +
                         std::to_string(motion.frames) + " frames.");
  }
  out.report.insert(out.report.begin(), "The markers were matched to the set '" + out.marker_set + "' on a body of " +
                                            to_fixed(out.size, 3) + " times its size; the rms distance is " + millimetres(out.rms) + ".");
  if (out.rms > 0.04 * out.size)
    out.report.push_back("This is a poor fit: check that the labels are correct and that left and right are not exchanged.");
  if (!out.unused.empty()) {
    std::string names;
    for (const std::string& label : out.unused) names += (names.empty() ? "" : ", ") + label;
    out.report.push_back("Markers not used, because the set does not contain them: " + names + ".");
  }
  return out;
}

}  // namespace ugoki::capture
