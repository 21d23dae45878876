#include "ugoki/capture/calibrate.h"

#include <algorithm>
#include <cmath>

#include "ugoki/dynamics/dense.h"

namespace ugoki::capture {
namespace {

// Maximum number of iterations of the pose solver during a calibration, per frame. Recordings of people and animals need 30 to 45; damaged
// recordings would need up to 4000 and 10 s of computing.
constexpr std::size_t max_iterations_per_frame = 250;

/// True if a and b are the same segment, or if one is the parent of the other.
bool neighbours(const MarkerSet& set, int a, int b) {
  const auto parent = [&](int i) { return set.segments[static_cast<std::size_t>(i)].parent; };
  return a == b || parent(a) == b || parent(b) == a;
}

/// Unknowns shared by all frames: three coordinates for each marker's deviation from its usual place on the segment, then three for each unknown segment offset. A left and a right
/// segment share their unknowns; the sign of y is changed on the second side.
struct Shared {
  std::vector<int> of_segment;  // [segments] index of the first unknown of the segment's offset; -1: the offset is known
  std::vector<char> flipped;    // [segments] 1: the segment uses the mirrored unknowns of the other side
  std::vector<double> prior;    // [unknowns] 1 / sigma^2
  int count = 0;
};

Shared shared_unknowns(const Subject& s) {
  Shared out;
  out.count = 3 * static_cast<int>(s.marker_offsets.size());
  for (std::size_t m = 0; m < s.marker_offsets.size(); ++m) {
    const double sigma = std::max(s.marker(m).sigma * s.size, 1e-4);
    out.prior.insert(out.prior.end(), 3, 1 / (sigma * sigma));
  }
  out.of_segment.assign(s.segment_count(), -1);
  out.flipped.assign(s.segment_count(), 0);
  for (std::size_t i = 0; i < s.segment_count(); ++i) {
    const ModelSegment& segment = s.segment(i);
    if (segment.parent < 0 || segment.offset_sigma == Vec3{}) continue;
    if (segment.mirror >= 0 && segment.mirror < static_cast<int>(i)) {
      out.of_segment[i] = out.of_segment[static_cast<std::size_t>(segment.mirror)];
      out.flipped[i] = 1;
      continue;
    }
    out.of_segment[i] = out.count;
    out.count += 3;
    for (int c = 0; c < 3; ++c) {
      const double sigma = std::max(segment.offset_sigma[c] * s.size, 1e-5);
      out.prior.push_back(1 / (sigma * sigma));
    }
  }
  return out;
}

Vec3 flip(const Vec3& v, char flipped) { return flipped != 0 ? Vec3{v.x, -v.y, v.z} : v; }

/// Difference [m] between every shared unknown and the marker set's value, which is scaled to the subject's size. Returns [unknowns].
std::vector<double> departures(const Subject& s, const Shared& shared) {
  std::vector<double> out(static_cast<std::size_t>(shared.count));
  const auto put = [&](int at, const Vec3& v) {
    for (int c = 0; c < 3; ++c) out[static_cast<std::size_t>(at + c)] = v[c];
  };
  for (std::size_t m = 0; m < s.marker_offsets.size(); ++m) put(3 * static_cast<int>(m), s.marker_offsets[m] - usual_place(s, m));
  for (std::size_t i = 0; i < s.segment_count(); ++i)
    if (shared.of_segment[i] >= 0 && shared.flipped[i] == 0) put(shared.of_segment[i], s.offsets[i] - s.segment(i).offset * s.size);
  return out;
}

/// Adds the step [m] of all unknowns to the marker offsets and segment offsets.
void apply(Subject& s, const Shared& shared, const std::vector<double>& step) {
  const auto get = [&](int at) {
    const double* d = step.data() + at;
    return Vec3{d[0], d[1], d[2]};
  };
  for (std::size_t m = 0; m < s.marker_offsets.size(); ++m) {
    s.marker_offsets[m] += get(3 * static_cast<int>(m));
    if (s.marker(m).end < 0) continue;
    const auto end = static_cast<std::size_t>(s.marker(m).end);
    if (shared.of_segment[end] >= 0) s.marker_offsets[m] += flip(get(shared.of_segment[end]), shared.flipped[end]) * s.marker(m).share;
  }
  for (std::size_t i = 0; i < s.segment_count(); ++i)
    if (shared.of_segment[i] >= 0) s.offsets[i] += flip(get(shared.of_segment[i]), shared.flipped[i]);
}

/// Three columns (one offset) of the Jacobian of a marker's world position with respect to the shared unknowns.
struct Block {
  int column;
  Mat3 J;
};
void shared_blocks(const Subject& s, const Shared& shared, const Kinematics& k, std::size_t m, std::vector<Block>& out) {
  out.clear();
  int i = s.marker(m).segment;
  out.push_back({3 * static_cast<int>(m), k.R[static_cast<std::size_t>(i)]});
  const auto add_segment = [&](std::size_t j, double share) {
    if (shared.of_segment[j] < 0) return;
    Mat3 J = k.R[static_cast<std::size_t>(s.segment(j).parent)] * Mat3::diagonal(share, shared.flipped[j] != 0 ? -share : share, share);
    out.push_back({shared.of_segment[j], J});
  };
  if (s.marker(m).end >= 0 && s.marker(m).share > 0) add_segment(static_cast<std::size_t>(s.marker(m).end), s.marker(m).share);
  for (; i >= 0; i = s.segment(static_cast<std::size_t>(i)).parent) add_segment(static_cast<std::size_t>(i), 1);
}

/// Normal equations S x = -r for the step x of the shared unknowns, with all poses eliminated (Schur complement). Each frame adds S += C -
/// B^T H^-1 B and r += c - B^T H^-1 g. H and g are the matrix and gradient for the frame's pose, C and c those for the shared unknowns; B
/// couples pose and shared unknowns.
class Reduction {
 public:
  explicit Reduction(const Shared& shared) : shared_(shared), n_(static_cast<std::size_t>(shared.count)), S(n_ * n_), r(n_) {}

  void add(const Subject& s, const PoseSolver& solver, const MeasuredFrame& frame, const PoseOptions& options) {
    const auto nf = static_cast<std::size_t>(s.dofs);
    B_.assign(nf * n_, 0);
    for (std::size_t m = 0; m < frame.positions.size(); ++m) {
      if (frame.seen[m] == 0) continue;
      const Vec3 error = marker_position(s, solver.kinematics(), m) - frame.positions[m];
      const double weight = marker_weight(options, s.marker(m).noise, norm(error));
      shared_blocks(s, shared_, solver.kinematics(), m, blocks_);
      for (const Block& a : blocks_) {
        const Vec3 g = a.J.transposed() * error;
        for (int c = 0; c < 3; ++c) r[static_cast<std::size_t>(a.column + c)] += weight * g[c];
        for (const Block& b : blocks_) {
          const Mat3 C = a.J.transposed() * b.J;
          for (int c = 0; c < 3; ++c)
            for (int d = 0; d < 3; ++d)
              S[static_cast<std::size_t>(a.column + c) * n_ + static_cast<std::size_t>(b.column + d)] += weight * C.column(d)[c];
        }
      }
      for (std::size_t f = 0; f < nf; ++f) {
        const Vec3 column = solver.jacobian(s, m, f);
        if (column == Vec3{}) continue;
        for (const Block& b : blocks_) {
          const Vec3 v = b.J.transposed() * column;
          for (int c = 0; c < 3; ++c) B_[f * n_ + static_cast<std::size_t>(b.column + c)] += weight * v[c];
        }
      }
    }
    eliminate(solver, nf, s.dofs);
  }

  /// Returns the step of the shared unknowns; empty if S is not positive definite. g is zero here, because the poses are at their optimum.
  std::vector<double> solve(const std::vector<double>& departure) {
    std::vector<double> step(n_);
    for (std::size_t i = 0; i < n_; ++i) {
      S[i * n_ + i] += shared_.prior[i] + 1e-9;
      step[i] = -(r[i] + shared_.prior[i] * departure[i]);
    }
    if (!dynamics::factor_cholesky(S, shared_.count, 1e-14)) return {};
    dynamics::solve_cholesky(S, shared_.count, step);
    return step;
  }

 private:
  void eliminate(const PoseSolver& solver, std::size_t nf, int dofs) {
    L_.assign(solver.normal_matrix().begin(), solver.normal_matrix().end());
    for (std::size_t f = 0; f < nf; ++f) L_[f * nf + f] += 1e-6 * (1 + L_[f * nf + f]);
    if (!dynamics::factor_cholesky(L_, dofs, 1e-14)) return;
    // With H = L L^T, B is replaced by Y = L^-1 B row by row; then S -= Y^T Y.
    for (std::size_t f = 0; f < nf; ++f) {
      for (std::size_t g = 0; g < f; ++g) {
        const double l = L_[f * nf + g];
        if (l == 0) continue;
        for (std::size_t c = 0; c < n_; ++c) B_[f * n_ + c] -= l * B_[g * n_ + c];
      }
      const double d = 1 / L_[f * nf + f];
      for (std::size_t c = 0; c < n_; ++c) B_[f * n_ + c] *= d;
    }
    for (std::size_t f = 0; f < nf; ++f) {
      const double* y = B_.data() + f * n_;
      for (std::size_t a = 0; a < n_; ++a) {
        if (y[a] == 0) continue;
        for (std::size_t b = 0; b <= a; ++b) S[a * n_ + b] -= y[a] * y[b];
      }
    }
  }

  const Shared& shared_;
  std::size_t n_;
  std::vector<double> S, r, B_, L_;
  std::vector<Block> blocks_;
};

double marker_rms(const Subject& subject, const std::vector<MeasuredFrame>& frames, const std::vector<ModelPose>& poses) {
  double squares = 0;
  int count = 0;
  Kinematics k;
  for (std::size_t f = 0; f < frames.size(); ++f) {
    calc_kinematics(subject, poses[f], k);
    for (std::size_t m = 0; m < frames[f].positions.size(); ++m) {
      if (frames[f].seen[m] == 0) continue;
      const Vec3 error = marker_position(subject, k, m) - frames[f].positions[m];
      squares += dot(error, error);
      ++count;
    }
  }
  return std::sqrt(squares / std::max(1, count));
}

}  // namespace

std::vector<std::pair<std::size_t, std::size_t>> pairs_for_size(const MarkerSet& set, const std::vector<int>& match) {
  // Markers of clusters may be anywhere on their segment, so that distances between them contain no information about the size.
  const auto on_landmark = [&](int m) { return m >= 0 && set.markers[static_cast<std::size_t>(m)].sigma < 0.06; };
  std::vector<std::pair<std::size_t, std::size_t>> out;
  for (std::size_t a = 0; a < match.size(); ++a)
    for (std::size_t b = 0; b < a; ++b)
      if (on_landmark(match[a]) && on_landmark(match[b]) &&
          neighbours(set, set.markers[static_cast<std::size_t>(match[a])].segment, set.markers[static_cast<std::size_t>(match[b])].segment))
        out.emplace_back(a, b);
  return out;
}

double estimate_size(const MarkerSet& set, const std::vector<int>& match, const MarkerMotion& motion) {
  // Marker positions of the model at rest.
  std::vector<int> identity(set.markers.size());
  for (std::size_t i = 0; i < identity.size(); ++i) identity[i] = static_cast<int>(i);
  const Subject model = make_subject(set, identity, 1);
  Kinematics k;
  calc_kinematics(model, model.rest(), k);
  std::vector<double> ratios;
  const int stride = std::max(1, motion.frames / 50);
  for (const auto& [a, b] : pairs_for_size(set, match)) {
    const auto ma = static_cast<std::size_t>(match[a]), mb = static_cast<std::size_t>(match[b]);
    const double own = norm(marker_position(model, k, ma) - marker_position(model, k, mb));
    double sum = 0;
    int count = 0;
    for (int f = 0; f < motion.frames; f += stride) {
      if (!motion.seen(f, static_cast<int>(a)) || !motion.seen(f, static_cast<int>(b))) continue;
      sum += norm(motion.at(f, static_cast<int>(a)) - motion.at(f, static_cast<int>(b)));
      ++count;
    }
    // Distances below 2 cm are not used, because noise dominates their ratios.
    if (count > 0 && own > 0.02) ratios.push_back(sum / count / own);
  }
  if (ratios.empty()) return 0;
  const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
  std::nth_element(ratios.begin(), middle, ratios.end());
  return *middle;
}

std::vector<int> choose_frames(const MarkerMotion& motion, const Subject& subject, int count) {
  std::vector<int> out;
  const int parts = std::min(count, motion.frames);
  for (int part = 0; part < parts; ++part) {
    const auto edge = [&](int i) { return static_cast<int>(static_cast<long>(motion.frames) * i / parts); };
    int best = -1, maximum = -1;
    for (int f = edge(part); f < edge(part + 1); ++f) {
      int seen = 0;
      for (const int column : subject.columns) seen += motion.seen(f, column) ? 1 : 0;
      if (seen > maximum) {
        maximum = seen;
        best = f;
      }
    }
    if (2 * maximum > static_cast<int>(subject.columns.size())) out.push_back(best);
  }
  return out;
}

double find_first_pose(PoseSolver& solver, const Subject& subject, const MeasuredFrame& frame, ModelPose& pose) {
  constexpr double pi = 3.14159265358979323846;
  Vec3 middle;
  for (std::size_t m = 0; m < frame.positions.size(); ++m)
    if (frame.seen[m] != 0) middle += frame.positions[m];
  middle = middle / std::max(1, frame.count);
  double minimum = -1;
  for (int heading = 0; heading < 8; ++heading) {
    for (const double arms : {0.0, 1.3}) {
      ModelPose start = subject.rest();
      start.rotations[0] = axis_angle({0, 0, 1}, heading * pi / 4);
      for (std::size_t i = 0; i < subject.segment_count(); ++i) {
        const ModelSegment& s = subject.segment(i);
        // Limbs that point sideways at rest are lowered by `arms` radians.
        if (s.joint == ModelJoint::ball && s.mirror >= 0 && i + 1 < subject.segment_count() && std::fabs(s.offset.y) > 0.1)
          start.rotations[i] = axis_angle({1, 0, 0}, s.offset.y > 0 ? -arms : arms);
      }
      start.p = middle;
      // A coarse fit with a large sigma, then a fine fit. The Huber limit is disabled (1 km), because all markers are far from their goals.
      PoseOptions options;
      options.marker_sigma = 0.1 * subject.size;
      options.outlier = 1e3;
      solver.solve(subject, frame, options, start);
      options = {};
      options.outlier = 1e3;
      const double cost = solver.solve(subject, frame, options, start);
      if (minimum >= 0 && cost >= minimum) continue;
      minimum = cost;
      pose = start;
    }
  }
  return minimum;
}

bool turn_limbs(const Subject& subject, const std::vector<MeasuredFrame>& frames, std::vector<ModelPose>& poses) {
  constexpr double pi = 3.14159265358979323846;
  // About ten frames decide.
  const std::size_t stride = std::max<std::size_t>(1, frames.size() / 10);
  PoseSolver solver;
  const PoseOptions options;
  const auto cost_of = [&](std::vector<ModelPose>& trial, std::size_t step) {
    double sum = 0;
    for (std::size_t f = 0; f < frames.size(); f += step) sum += solver.solve(subject, frames[f], options, trial[f]);
    return sum;
  };
  double best = cost_of(poses, stride);
  bool turned = false;
  for (std::size_t i = 0; i + 1 < subject.segment_count(); ++i) {
    // A shoulder: a ball joint that carries an elbow. Legs have enough markers.
    const auto child = [&]() -> std::size_t {
      for (std::size_t k = i + 1; k < subject.segment_count(); ++k) {
        const ModelJoint joint = subject.segment(k).joint;
        if (subject.segment(k).parent == static_cast<int>(i) && joint == ModelJoint::universal) return k;
      }
      return 0;
    }();
    if (subject.segment(i).joint != ModelJoint::ball || subject.segment(i).mirror < 0 || child == 0) continue;
    const Vec3 along = normalized(subject.offsets[child]);
    for (int quarter = 1; quarter < 4; ++quarter) {
      std::vector<ModelPose> trial = poses;
      for (ModelPose& pose : trial) pose.rotations[i] = pose.rotations[i] * axis_angle(along, quarter * pi / 2);
      const double cost = cost_of(trial, stride);
      if (cost >= best * (1 - 1e-3)) continue;
      best = cost;
      poses = std::move(trial);
      turned = true;
    }
  }
  if (turned) cost_of(poses, 1);
  return turned;
}

double calibrate(Subject& subject, const std::vector<MeasuredFrame>& frames, std::vector<ModelPose>& poses,
                 const std::function<bool()>& cancelled) {
  const Shared shared = shared_unknowns(subject);
  const PoseOptions options;
  PoseSolver solver;
  bool stopped = false;
  // Solves the poses of all frames; returns their cost plus the cost of the priors of the shared unknowns.
  const auto solve_poses = [&](Subject& s, std::vector<ModelPose>& p, Reduction* reduction) {
    double cost = 0;
    for (std::size_t f = 0; f < frames.size(); ++f) {
      stopped = stopped || (cancelled && cancelled());
      if (stopped) return cost;
      cost += solver.solve(s, frames[f], options, p[f]);
      if (reduction != nullptr) reduction->add(s, solver, frames[f], options);
    }
    const std::vector<double> departure = departures(s, shared);
    for (std::size_t i = 0; i < departure.size(); ++i) cost += 0.5 * shared.prior[i] * departure[i] * departure[i];
    return cost;
  };
  const std::size_t max_iterations = max_iterations_per_frame * frames.size();
  for (int round = 0; round < 40 && solver.iterations() < max_iterations && !stopped; ++round) {
    Reduction reduction(shared);
    const double cost = solve_poses(subject, poses, &reduction);
    if (stopped) break;
    std::vector<double> step = reduction.solve(departures(subject, shared));
    if (step.empty()) break;
    double then = cost;
    for (int attempt = 0; attempt < 8 && solver.iterations() < max_iterations; ++attempt) {
      Subject trial = subject;
      std::vector<ModelPose> trial_poses = poses;
      apply(trial, shared, step);
      then = solve_poses(trial, trial_poses, nullptr);
      if (stopped) break;
      if (then < cost) {
        subject = std::move(trial);
        poses = std::move(trial_poses);
        break;
      }
      for (double& x : step) x *= 0.3;
    }
    if (!(then < cost * (1 - 1e-5))) break;
  }
  return marker_rms(subject, frames, poses);
}

}  // namespace ugoki::capture
