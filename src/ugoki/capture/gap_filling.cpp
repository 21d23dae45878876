#include "ugoki/capture/gap_filling.h"

#include <algorithm>

#include "ugoki/motion/marker_repair.h"

namespace ugoki::capture {
namespace {

/// Poses of the body and its segments in all frames.
struct BodyPoses {
  std::size_t segments;             // count
  std::vector<ModelPose> poses;     // [frames]
  std::vector<Pose> segment_poses;  // [frames][segments]
  std::vector<char> known;          // [frames] 1: enough_markers_seen() was true

  [[nodiscard]] const Pose& at(int frame, std::size_t segment) const {
    return segment_poses[static_cast<std::size_t>(frame) * segments + segment];
  }
};

BodyPoses find_body_poses(const MarkerMotion& markers, const Subject& subject, const ModelPose& first, int from,
                          const std::function<bool()>& cancelled) {
  BodyPoses out{subject.segment_count(), {}, {}, {}};
  out.poses.resize(static_cast<std::size_t>(markers.frames));
  out.segment_poses.resize(out.poses.size() * out.segments);
  for (int f = 0; f < markers.frames; ++f) out.known.push_back(enough_markers_seen(markers, subject, f) ? 1 : 0);
  solve_frames(markers, subject, first, from, cancelled, [&](int f, const PoseSolver& solver, const ModelPose& pose) {
    out.poses[static_cast<std::size_t>(f)] = pose;
    for (std::size_t i = 0; i < out.segments; ++i)
      out.segment_poses[static_cast<std::size_t>(f) * out.segments + i] = {solver.kinematics().R[i], solver.kinematics().p[i]};
  });
  return out;
}

/// Position of used marker m in the frame of its segment, with the given rotation and position, minus its calibrated offset [m].
Vec3 offset_of(const MarkerMotion& markers, const Subject& subject, std::size_t m, int frame, const Mat3& R, const Vec3& p) {
  return R.transposed() * (markers.at(frame, subject.columns[m]) - p) - subject.marker_offsets[m];
}

/// The offset of offset_of(); the pose is solved without this marker.
Vec3 offset_from_others(const MarkerMotion& markers, const Subject& subject, const BodyPoses& bodies, std::size_t m, int frame) {
  MeasuredFrame measured = measured_frame(markers, subject, frame);
  measured.seen[m] = 0;
  const ModelPose near = bodies.poses[static_cast<std::size_t>(frame)];
  ModelPose pose = near;
  PoseOptions options;
  options.near = &near;
  options.step_sigma = 30 / markers.rate;
  PoseSolver solver;
  solver.solve(subject, measured, options, pose);
  const auto segment = static_cast<std::size_t>(subject.marker(m).segment);
  const Kinematics& k = solver.kinematics();
  return offset_of(markers, subject, m, frame, k.R[segment], k.p[segment]);
}

}  // namespace

bool enough_markers_seen(const MarkerMotion& markers, const Subject& subject, int frame) {
  const auto seen = std::ranges::count_if(subject.columns, [&](int column) { return markers.seen(frame, column); });
  return 3 * seen >= static_cast<std::ptrdiff_t>(subject.columns.size());
}

int fill_gaps_by_body(MarkerMotion& markers, const Subject& subject, const ModelPose& first, int from,
                      const std::function<bool()>& cancelled) {
  const std::vector<MarkerGap> gaps = find_gaps(markers);
  if (gaps.empty()) return 0;
  std::vector<int> used_of(markers.labels.size(), -1);
  for (std::size_t m = 0; m < subject.columns.size(); ++m) used_of[static_cast<std::size_t>(subject.columns[m])] = static_cast<int>(m);
  const MarkerMotion measured = markers;
  const BodyPoses bodies = find_body_poses(measured, subject, first, from, cancelled);
  if (cancelled && cancelled()) return 0;
  // At most one further pose is solved per frame of the recording. Damaged recordings may have a gap in almost every frame of every marker;
  // the remaining offsets of these follow from the poses that were solved with all markers.
  int solves_left = markers.frames;
  const auto offset_at = [&](std::size_t m, int frame) {
    if (solves_left > 0) {
      --solves_left;
      return offset_from_others(measured, subject, bodies, m, frame);
    }
    const Pose& body = bodies.at(frame, static_cast<std::size_t>(subject.marker(m).segment));
    return offset_of(measured, subject, m, frame, body.R, body.p);
  };
  int count = 0;
  for (const MarkerGap& gap : gaps) {
    const int used = used_of[static_cast<std::size_t>(gap.marker)];
    if (used < 0) continue;
    if (cancelled && cancelled()) {
      markers = measured;
      return 0;
    }
    const auto m = static_cast<std::size_t>(used);
    const bool before = gap.first > 0, after = gap.last + 1 < markers.frames;
    Vec3 a = before ? offset_at(m, gap.first - 1) : Vec3{};
    Vec3 b = after ? offset_at(m, gap.last + 1) : a;
    if (!before) a = b;
    for (int f = gap.first; f <= gap.last; ++f) {
      if (bodies.known[static_cast<std::size_t>(f)] == 0) continue;
      const double t = static_cast<double>(f - gap.first + 1) / (gap.last - gap.first + 2);
      const Pose& body = bodies.at(f, static_cast<std::size_t>(subject.marker(m).segment));
      const std::size_t at = markers.index(f, gap.marker);
      markers.positions[at] = body * (subject.marker_offsets[m] + a * (1 - t) + b * t);
      markers.residuals[at] = 0;
      ++count;
    }
  }
  return count;
}

void mirror_unseen_offsets(Subject& subject, const std::vector<MeasuredFrame>& seen) {
  const auto count = [&](std::size_t m) { return std::ranges::count_if(seen, [m](const MeasuredFrame& f) { return f.seen[m] != 0; }); };
  const auto is_image = [&](std::size_t m, std::size_t k) {
    const ModelMarker &a = subject.marker(m), &b = subject.marker(k);
    const int mirror = subject.segment(static_cast<std::size_t>(a.segment)).mirror;
    return m != k && b.segment == (mirror >= 0 ? mirror : a.segment) && b.at == Vec3{a.at.x, -a.at.y, a.at.z};
  };
  for (std::size_t m = 0; m < subject.marker_offsets.size(); ++m) {
    if (count(m) > 0) continue;
    for (std::size_t k = 0; k < subject.marker_offsets.size(); ++k)
      if (is_image(m, k) && count(k) > 0)
        subject.marker_offsets[m] = {subject.marker_offsets[k].x, -subject.marker_offsets[k].y, subject.marker_offsets[k].z};
  }
}

}  // namespace ugoki::capture
