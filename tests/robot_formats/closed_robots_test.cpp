// Motion of the shared robots with closed loops: DOFs, loop gaps while they fall and swing, agreement of two dynamics methods.

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>

#include "robot_data.h"
#include "ugoki/dynamics/closed_reference.h"
#include "ugoki/dynamics/closed_system.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/dynamics/integrators.h"
#include "ugoki/dynamics/loop_diagnosis.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/robot_formats/robot_file.h"

namespace ugoki::robot_formats {
namespace {

std::vector<std::string> closed_files() {
  std::vector<std::string> out;
  for (const char* ending : {".urdf", ".sdf", ".xml"})
    for (const std::string& path : robot_files(ending))
      if (path.find("closed_loop") != std::string::npos) out.push_back(path);
  return out;
}

/// Largest relative difference of the accelerations of two methods in comparisons of any condition number.
constexpr double same = 1e-8;

/// Largest share of the bound for a backward stable method by which the methods may differ where the loops' equations are so
/// ill-conditioned that `same` is not reached. robot_delta has nearly redundant rows (condition number 5e10) and reaches 0.001.
constexpr double roundoff_share = 0.01;

/// Results of one simulation.
struct Outcome {
  double gap = 0;           ///< m | rad, maximum
  double disagreement = 0;  ///< relative difference of the accelerations of the two methods
  double maximum = 0;       ///< largest acceleration, m/s^2 | rad/s^2
  int comparisons = 0;
  int differences = 0;  ///< comparisons in which the methods differ by more than rounding explains
};

double relative_difference(std::span<const double> a, std::span<const double> b) {
  double difference = 0, size = 1;
  for (std::size_t i = 0; i < a.size(); ++i) {
    difference = std::max(difference, std::fabs(a[i] - b[i]));
    size = std::max(size, std::fabs(b[i]));
  }
  return difference / size;
}

/// Maximum gap of the independent rows, m | rad.
double gap_of(const dynamics::ClosedSystem& system, const Mechanism& m, const dynamics::Workspace& ws, std::span<const double> q,
              std::span<const double> v) {
  dynamics::LoopRows rows(m.loops());
  update_loop_rows(m, ws, m.loops(), q, v, rows);
  double gap = 0;
  for (std::size_t k = 0; k < rows.gap.size(); ++k)
    if (system.links().independent()[k]) gap = std::max(gap, std::fabs(rows.gap[k]));
  return gap;
}

/// The rows that the paper's method has chosen as independent.
std::vector<char> independent_rows(const dynamics::ClosedWorkspace& cw) {
  std::vector<char> rows(static_cast<std::size_t>(cw.rows.count()));
  for (int k = 0; k < cw.rank; ++k)
    rows[static_cast<std::size_t>(cw.active[static_cast<std::size_t>(cw.row_order[static_cast<std::size_t>(k)])])] = 1;
  return rows;
}

/// Condition number of the equations for the loop forces, A = J M^-1 J^T, where J has the chosen rows of the closed loops. A method that is
/// backward stable finds accelerations with a relative error of the order of this number times the unit roundoff (Higham 2002, Accuracy and
/// Stability of Numerical Algorithms, chapter 7), so two methods may differ by as much near a dead point of the loops.
double condition_of(const Mechanism& m, const dynamics::ClosedWorkspace& cw, dynamics::Workspace& ws, std::span<const double> q,
                    std::span<const double> v, std::span<const char> chosen) {
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Eigen::Index n = m.nv();
  dynamics::LoopRows rows(cw.loops);
  update_loop_rows(m, ws, cw.loops, q, v, rows);
  Matrix J(0, n), M(n, n);
  for (std::size_t i = 0; i < cw.loops.size(); ++i)
    for (int r = 0; cw.closed[i] && r < cw.loops[i].rows(); ++r) {
      if (!chosen[static_cast<std::size_t>(rows.first[i] + r)]) continue;
      J.conservativeResize(J.rows() + 1, n);
      calc_loop_jacobian_row(m, ws, cw.loops[i], rows, static_cast<int>(i), r, {J.row(J.rows() - 1).data(), static_cast<std::size_t>(n)});
    }
  calc_inertia_matrix(m, ws, {M.data(), static_cast<std::size_t>(n * n)});
  // With the Cholesky factor L of M (M = L L^T) and B = L^-1 J^T, A is B^T B. Its condition number is therefore the square of that of B.
  const Eigen::MatrixXd B = Eigen::LLT<Eigen::MatrixXd>(M).matrixL().solve(Eigen::MatrixXd(J.transpose()));
  const Eigen::VectorXd values = Eigen::JacobiSVD<Eigen::MatrixXd>(B).singularValues();
  return std::pow(values(0) / values(values.size() - 1), 2);
}

/// Simulates the fall for `seconds` in steps of 1 ms, and compares the two methods every `every` steps.
Outcome fall(const MechanismPtr& m, double seconds, int every) {
  Outcome out;
  dynamics::OpenSystemOptions options;
  options.joint_forces_on = false;
  dynamics::ClosedSystem system(m, options);
  dynamics::ClosedWorkspace cw(*m);
  State s(*m);
  const dynamics::Closure closure = assemble(*m, s.q, cw);
  EXPECT_TRUE(closure.closed) << explain_gap(*m, cw, closure).text();
  if (!closure.closed) return out;
  find_full_rank(*m, s.q, cw);
  const int left_out = system.leave_out_redundant_rows(s.q);
  int rows = 0;
  for (const Loop& l : m->loops()) rows += l.closed ? l.rows() : 0;
  EXPECT_EQ(rows - left_out, cw.full_rank) << "rank by both methods";
  for (std::size_t i = 0; i < s.v.size(); ++i) s.v[i] = std::sin(1.0 + 2.0 * static_cast<double>(i));
  EXPECT_NE(system.project(0, s.q, s.v), dynamics::Projection::failed);

  dynamics::IntegratorOptions integration;
  integration.method = dynamics::IntegrationMethod::dormand_prince_54;
  integration.relative_tolerance = integration.absolute_tolerance = 1e-6;
  dynamics::Integrator integrator(system, integration);
  integrator.start(0, s.q, s.v);
  dynamics::Workspace ws(*m);
  std::vector<char> rows_of_both;
  dynamics::ClosedLinks same_rows(*m);
  std::vector<double> fast(s.v.size()), paper(s.v.size()), q(s.q.size()), v(s.v.size());
  const int steps = static_cast<int>(std::lround(seconds * 1000));
  for (int i = 1; i <= steps; ++i) {
    const dynamics::IntegrationReport report = integrator.advance(i * 1e-3);
    EXPECT_EQ(report.status, dynamics::IntegrationStatus::reached) << name_of(report.status) << " at " << report.time;
    if (report.status != dynamics::IntegrationStatus::reached) return out;
    std::ranges::copy(integrator.q(), q.begin());
    std::ranges::copy(integrator.v(), v.begin());
    update_kinematics(*m, q, v, ws);
    out.gap = std::max(out.gap, gap_of(system, *m, ws, q, v));
    if (i % every != 0) continue;
    update_closed(*m, q, v, cw);
    // Both methods use the same rows: if the frames of a file do not match exactly, redundant rows are only nearly redundant.
    const std::vector<char> chosen = independent_rows(cw);
    if (chosen != rows_of_both) {
      rows_of_both = chosen;
      same_rows = dynamics::ClosedLinks(*m, cw.loops, cw.closed, chosen);
    }
    EXPECT_EQ(calc_closed_forward_dynamics(*m, same_rows, q, v, system.drive, options.gravity, {}, fast), dynamics::ClosedStatus::ok);
    EXPECT_TRUE(calc_closed_forward_dynamics_by_unit_vectors(*m, cw, system.drive, options.gravity, {}, paper));
    // The rounding error of positions grows with the distance fallen.
    const double distance = 1 + norm(ws.p0);
    const double difference = relative_difference(fast, paper) / distance;
    if (difference > same && difference > roundoff_share * condition_of(*m, cw, ws, q, v, chosen) * std::numeric_limits<double>::epsilon())
      ++out.differences;
    out.disagreement = std::max(out.disagreement, difference);
    for (const double a : fast) out.maximum = std::max(out.maximum, std::fabs(a));
    ++out.comparisons;
  }
  return out;
}

void fall_all(double seconds, int every) {
  NEEDS_ROBOT_DATA();
  for (const std::string& path : closed_files()) {
    SCOPED_TRACE(short_path(path));
    for (const Base base : {Base::fixed, Base::floating}) {           // fixed base: swings; floating base: falls
      if (base == Base::fixed && !path.ends_with(".urdf")) continue;  // SDF and MJCF files specify the base themselves
      RobotOptions options = options_for(path);
      if (path.ends_with(".urdf")) options.base = base;
      const Result<RobotModel> model = read_robot_file(load_robot(path), path, options);
      ASSERT_TRUE(model.has_value()) << model.error().text();
      if (!model->mechanism->has_loops()) continue;
      const Outcome o = fall(model->mechanism, seconds, every);
      std::cout << short_path(path) << (base == Base::fixed ? ", swinging" : ", falling") << ": gap " << o.gap << ", maximum acceleration "
                << o.maximum << ", the two methods differ by " << o.disagreement << " in " << o.comparisons << " comparisons\n";
      EXPECT_LT(o.gap, 1e-9);
      EXPECT_EQ(o.differences, 0);
    }
  }
}

TEST(ClosedRobots, LoopsStayClosedDuringFall) { fall_all(0.3, 20); }
TEST(Slow_ClosedRobots, LoopsStayClosedForTenSeconds) { fall_all(10, 1); }

}  // namespace
}  // namespace ugoki::robot_formats
