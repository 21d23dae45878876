// Parts of Newton's method in the velocity solver: sparse matrix, order of systems, augmented laws.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "ugoki/contact/augmented_law.h"
#include "ugoki/contact/contact_law.h"
#include "ugoki/contact/envelope_matrix.h"
#include "ugoki/contact/solver_kernels.h"
#include "ugoki/contact/system_order.h"

namespace ugoki::contact {
namespace {

TEST(SolverKernels, EveryWidthHasTheSameBitsAndSolvesTheEquations) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> any(-1, 1);
  for (const int n : {1, 3, 10, 31}) {
    const auto size = static_cast<std::size_t>(n);
    const int width = n + 1, stride = n + 5;
    std::vector<double> B(size * static_cast<std::size_t>(stride)), A(size * static_cast<std::size_t>(width)), p(size);
    for (std::size_t i = 0; i < size; ++i) {
      p[i] = any(random);
      for (std::size_t j = 0; j <= i; ++j)
        B[i * static_cast<std::size_t>(stride) + j] = B[j * static_cast<std::size_t>(stride) + i] = i == j              ? n + any(random)
                                                                                                    : random() % 3 == 0 ? 0
                                                                                                                        : any(random);
    }
    std::vector<double> last_A, last_u;
    for (const bool wide : {false, true}) {
      if (!use_solver_kernels(wide)) continue;
      std::vector<double> u(size), inverse(size);
      solver_kernels().add_product(B.data(), stride, n, p.data(), u.data());
      for (std::size_t i = 0; i < size; ++i) {
        double exact = 0;
        for (std::size_t j = 0; j < size; ++j) {
          A[i * static_cast<std::size_t>(width) + j] = B[i * static_cast<std::size_t>(stride) + j];
          exact += B[i * static_cast<std::size_t>(stride) + j] * p[j];
        }
        EXPECT_NEAR(u[i], exact, 1e-12 * n);
        A[i * static_cast<std::size_t>(width) + size] = u[i];  // the equations B x = B p have the solution p
      }
      std::vector<double> row_by_row = A;
      for (std::size_t k = 0; k < size; ++k) {
        const double* const row = row_by_row.data() + k * static_cast<std::size_t>(width);
        for (std::size_t i = k + 1; i < size; ++i) {
          const double factor = row[i] * (1 / row[k]);
          for (std::size_t j = i; j <= size; ++j) row_by_row[i * static_cast<std::size_t>(width) + j] -= factor * row[j];
        }
      }
      solver_kernels().eliminate(A.data(), n, width, inverse.data());
      for (std::size_t i = 0; i < size; ++i) {  // the entries before the diagonal are not used
        const auto row = static_cast<std::ptrdiff_t>(i) * width, diagonal = row + static_cast<std::ptrdiff_t>(i);
        EXPECT_TRUE(std::equal(A.begin() + diagonal, A.begin() + row + width, row_by_row.begin() + diagonal)) << "row " << i;
      }
      std::vector<double> x(size);
      for (std::size_t k = size; k-- > 0;) {
        double sum = A[k * static_cast<std::size_t>(width) + size];
        for (std::size_t j = k + 1; j < size; ++j) sum -= A[k * static_cast<std::size_t>(width) + j] * x[j];
        x[k] = sum * inverse[k];
        EXPECT_NEAR(x[k], p[k], 1e-12);
      }
      if (!last_A.empty()) {
        EXPECT_EQ(A, last_A);
        EXPECT_EQ(u, last_u);
      }
      last_A = A;
      last_u = u;
    }
  }
}

TEST(EnvelopeMatrix, SolutionSatisfiesTheEquations) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> any(-1, 1);
  for (const int n : {1, 2, 7, 40}) {
    EnvelopeMatrix sparse;
    sparse.begin(n);
    std::vector<std::vector<double>> dense(static_cast<std::size_t>(n), std::vector<double>(static_cast<std::size_t>(n), 0.0));
    for (std::size_t i = 0; i < dense.size(); ++i) dense[i][i] = 1;
    std::vector<std::pair<int, int>> entries;
    for (int k = 0; k < 3 * n; ++k) {
      int row = static_cast<int>(random() % static_cast<unsigned>(n)), column = static_cast<int>(random() % static_cast<unsigned>(n));
      if (row < column) std::swap(row, column);
      sparse.include(row, column);
      entries.emplace_back(row, column);
    }
    sparse.finish();
    sparse.allocate();
    sparse.set_identity();
    for (const auto& [row, column] : entries) {  // adds (e_row + f e_column)(e_row + f e_column)^T
      const double f = row == column ? 0 : any(random);
      const auto r = static_cast<std::size_t>(row), c = static_cast<std::size_t>(column);
      dense[r][r] += 1;
      sparse.row_data(row)[row] += 1;
      if (row == column) continue;
      sparse.row_data(column)[column] += f * f;
      sparse.row_data(row)[column] += f;
      dense[c][c] += f * f;
      dense[r][c] += f;
      dense[c][r] += f;
    }
    std::vector<double> b(static_cast<std::size_t>(n)), x(b.size());
    for (double& v : b) v = any(random);
    sparse.solve(b, x);
    for (std::size_t i = 0; i < dense.size(); ++i) {
      double sum = 0;
      for (std::size_t k = 0; k < dense.size(); ++k) sum += dense[i][k] * x[k];
      EXPECT_NEAR(sum, b[i], 1e-12);
    }
  }
}

TEST(EnvelopeMatrix, EveryWidthHasTheSameBits) {
  constexpr int n = 37;
  std::vector<std::vector<double>> solutions;
  for (const bool wide : {false, true}) {
    if (!use_solver_kernels(wide)) continue;
    std::mt19937_64 random(11);
    std::uniform_real_distribution<double> any(-1, 1);
    EnvelopeMatrix A;
    A.begin(n);
    for (int row = 0; row < n; ++row) A.include(row, std::max(0, row - static_cast<int>(random() % 20)));
    A.finish();
    A.allocate();
    A.set_identity();
    const int rows[] = {3, 4, 5, 6, 7, 8, 19, 20, 21}, run[] = {6, 6, 6, 6, 6, 6, 9, 9, 9};
    std::vector<double> Z(27), b(n), x(n);
    for (std::vector<double>* values : {&Z, &b})
      for (double& value : *values) value = any(random);
    for (int row = 19; row < 22; ++row) A.include(row, 3);
    A.finish();
    A.allocate();
    A.set_identity();
    const double G[9] = {2, 0.5, 0.1, 0.5, 3, 0.2, 0.1, 0.2, 1};
    solver_kernels().add_to_envelope({3, 9, Z.data(), rows, run}, G, A.arguments());
    A.solve(b, x);
    solutions.push_back(x);
  }
  use_solver_kernels(true);
  for (const std::vector<double>& x : solutions) EXPECT_EQ(x, solutions[0]);
}

TEST(EnvelopeMatrix, UnsymmetricSolutionSatisfiesTheEquations) {
  for (const int n : {1, 6, 31}) {
    const auto size = static_cast<std::size_t>(n);
    std::vector<std::vector<double>> solutions;
    for (const bool wide : {false, true}) {
      if (!use_solver_kernels(wide)) continue;
      std::mt19937_64 random(17);
      std::uniform_real_distribution<double> any(-1, 1);
      EnvelopeMatrix A;
      A.begin(n);
      for (int k = 0; k < n; ++k) A.include(n - 1, k);
      for (int k = 0; k < n; ++k) A.include(k, k - k % 3);
      A.finish();
      A.allocate();
      A.set_identity();
      A.set_upper_identity();
      // A = 1 + sum Z^T G Z of blocks whose rows Z have three consecutive entries and one in the last row
      std::vector<std::vector<double>> dense(size, std::vector<double>(size, 0.0));
      for (std::size_t i = 0; i < size; ++i) dense[i][i] = 1;
      for (int first = 0; first + 4 <= n; first += 3) {
        const int row[] = {first, first + 1, first + 2, n - 1}, run[] = {3, 3, 3, 4};
        double Z[12], G[9];
        for (double& z : Z) z = any(random);
        for (int k = 0; k < 9; ++k) G[k] = k % 4 == 0 ? 4 : any(random);
        solver_kernels().add_to_envelope({3, 4, Z, row, run}, G, A.arguments());
        solver_kernels().add_to_upper_envelope({3, 4, Z, row, run}, G, A.arguments());
        for (int e = 0; e < 4; ++e)
          for (int f = 0; f < 4; ++f)
            for (int r = 0; r < 3; ++r)
              for (int c = 0; c < 3; ++c)
                dense[static_cast<std::size_t>(row[e])][static_cast<std::size_t>(row[f])] += Z[4 * r + e] * G[3 * r + c] * Z[4 * c + f];
      }
      std::vector<double> b(size), x(size);
      for (double& value : b) value = any(random);
      A.solve_unsymmetric(b, x);
      for (std::size_t i = 0; i < size; ++i) {
        double sum = 0;
        for (std::size_t k = 0; k < size; ++k) sum += dense[i][k] * x[k];
        EXPECT_NEAR(sum, b[i], 1e-11);
      }
      solutions.push_back(x);
    }
    use_solver_kernels(true);
    for (const std::vector<double>& x : solutions) EXPECT_EQ(x, solutions[0]);
  }
}

TEST(SystemOrder, ChainsGetABandOfWidthOne) {
  SystemOrder order;
  order.reserve(20, 20);
  // two chains whose systems are numbered at random; system 7 touches nothing, system 3 touches itself
  const int one[] = {4, 9, 1, 12, 6}, two[] = {3, 15, 2, 0};
  order.clear();
  for (int k = 0; k < 4; ++k) order.add(one[k], one[k + 1]);
  for (int k = 0; k < 3; ++k) order.add(two[k + 1], two[k]);
  order.add(3, 3);
  const std::array members = {0, 1, 2, 3, 4, 6, 7, 9, 12, 15};
  const std::span<const int> found = order.find(members);
  std::vector<int> sorted(found.begin(), found.end());
  std::ranges::sort(sorted);
  EXPECT_TRUE(std::ranges::equal(sorted, members)) << "each system once";
  const auto place = [&](int s) { return std::ranges::find(found, s) - found.begin(); };
  for (int k = 0; k < 4; ++k) EXPECT_EQ(std::abs(place(one[k]) - place(one[k + 1])), 1);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(std::abs(place(two[k]) - place(two[k + 1])), 1);
}

/// Blocks of all kinds with a diagonal inverse inertia.
RowBlock block_of(RowKind kind, double impact_impulse = 0) {
  RowBlock b{};
  b.kind = kind;
  b.rows = kind == RowKind::contact || kind == RowKind::roll ? 3 : 1;
  b.mu = 0.6;
  b.bound = 0.4;
  b.impact_impulse = impact_impulse;
  b.compliance = 1e-4;
  b.B[0] = 2;
  b.B[1] = 3;
  b.B[2] = 1.5;
  b.lever = 1;
  return b;
}

// G is minus the derivative of the impulse (differences), symmetric, and has no negative eigenvalue.
TEST(AugmentedLaw, DerivativeAgreesWithDifferences) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> any(-1, 1);
  for (const RowBlock& b : {block_of(RowKind::contact), block_of(RowKind::contact, 0.2), block_of(RowKind::limit),
                            block_of(RowKind::friction), block_of(RowKind::roll)}) {
    int tested = 0;
    for (int trial = 0; trial < 200; ++trial) {
      const double hat[3] = {std::fabs(any(random)), any(random), any(random)};  // a normal impulse is not negative
      const AugmentedLaw law{0.5, hat, 0.1, 0.7};
      const double u[3] = {any(random), any(random), any(random)};
      double p[3], G[9] = {}, unused[9] = {};
      augmented_impulse(b, law, u, p, G);
      constexpr double h = 1e-6;
      double difference[9] = {}, bend = 0;
      for (int c = 0; c < b.rows; ++c) {
        double up[3] = {u[0], u[1], u[2]}, down[3] = {u[0], u[1], u[2]}, high[3], low[3];
        up[c] += h;
        down[c] -= h;
        augmented_impulse(b, law, up, high, unused);
        augmented_impulse(b, law, down, low, unused);
        for (int r = 0; r < b.rows; ++r) {
          difference[3 * r + c] = -(high[r] - low[r]) / (2 * h);
          bend = std::max(bend, std::fabs(high[r] - 2 * p[r] + low[r]) / h);
        }
      }
      if (bend > 1e-3) continue;  // a change of class within the difference
      ++tested;
      for (int r = 0; r < b.rows; ++r)
        for (int c = 0; c < b.rows; ++c) {
          EXPECT_NEAR(G[3 * r + c], difference[3 * r + c], 1e-6);
          EXPECT_NEAR(G[3 * r + c], G[3 * c + r], 1e-12);
        }
      for (int k = 0; k < 10; ++k) {
        const double x[3] = {any(random), any(random), any(random)};
        double square = 0;
        for (int r = 0; r < b.rows; ++r)
          for (int c = 0; c < b.rows; ++c) square += x[r] * G[3 * r + c] * x[c];
        EXPECT_GT(square, -1e-12);
      }
    }
    EXPECT_GT(tested, 150);
  }
}

// An impulse that the law does not change satisfies Coulomb's law, also while the contact slides.
TEST(AugmentedLaw, FixedPointsSatisfyTheLaw) {
  RowBlock b = block_of(RowKind::contact);
  b.compliance = 0;
  const auto is_fixed = [&](std::array<double, 3> p, std::array<double, 3> u) {
    double next[3], G[9];
    augmented_impulse(b, {1e-3, p.data(), sliding_shift(b, p.data(), u.data()), 0}, u.data(), next, G);
    return std::hypot(next[0] - p[0], next[1] - p[1], next[2] - p[2]) < 1e-9;
  };
  b.B[1] = b.B[2] = b.B[0];
  EXPECT_TRUE(is_fixed({1, 0.3, -0.4}, {0, 0, 0})) << "sticking";
  EXPECT_TRUE(is_fixed({0, 0, 0}, {0.2, 5, 0})) << "open";
  EXPECT_TRUE(is_fixed({1, 0.36, -0.48}, {0, -3, 4})) << "sliding, friction opposed to the slip";
  EXPECT_FALSE(is_fixed({1, -0.36, 0.48}, {0, -3, 4})) << "friction along the slip";
  EXPECT_FALSE(is_fixed({1, 0.3, -0.4}, {0, -3, 4})) << "friction below its bound while sliding";
  EXPECT_FALSE(is_fixed({1, 0.36, -0.48}, {0.1, -3, 4})) << "pressed while separating";
}

// A contact without friction that separates without sliding must not pull. The rolling row of such a contact became NaN.
TEST(AugmentedLaw, ContactWithoutFrictionDoesNotPull) {
  RowBlock b = block_of(RowKind::contact);
  b.mu = 0;
  const double hat[3] = {0, 0, 0}, u[3] = {0.2, 0, 0};
  double p[3] = {1, 1, 1}, G[9];
  augmented_impulse(b, {1e-3, hat, 0, 0}, u, p, G);
  for (const double x : p) EXPECT_EQ(x, 0);
  for (const double x : G) EXPECT_EQ(x, 0);
}

}  // namespace
}  // namespace ugoki::contact
