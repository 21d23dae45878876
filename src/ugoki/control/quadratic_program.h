#pragma once
// Quadratic program of whole-body control. Unknowns: accelerations x [n], and loads beta [m], which cannot be negative. A load is a force
// along an edge of a contact's friction pyramid.
//
//   minimize  1/2 sum_i w_i (x_i - x0_i)^2 + 1/2 sum_r s_r^2 / sigma_r + 1/2 eps sum_k beta_k^2
//   equations   c_r x             + s_r  =  t_r                  tasks and contacts
//   balances    l_r <= c_r x + g_r beta + s_r <= u_r             equations of motion (l = u), limits of torques and accelerations
//               beta_k >= 0
//
// A row's softness sigma_r >= 0 is the reciprocal of its weight; a row with sigma_r = 0 is satisfied exactly. Rows of different softness
// express tasks of different priority.
//
// The dual problem has one unknown z_r for each row: x = x0 + W^-1 C^T z, beta = max(0, G^T z) / eps, s = sigma z. Its solution satisfies
//   (C W^-1 C^T + diag(sigma)) z + G max(0, G^T z) / eps = t - C x0.
// The equations contain no loads, so one Cholesky factorization eliminates them. The remaining problem, the core, has one unknown for each
// balance: six for the root, and one for each limit that is reached. The core is strictly convex and piecewise quadratic. A projected
// semismooth Newton method with line search solves it exactly. The method stops when the set of loaded edges and reached limits no longer
// changes. The core's solution of the previous tick is a good start.
//
// Sources: Bertsekas (1982), Projected Newton methods; Qi, Sun (1993), semismooth Newton methods; Goldfarb, Idnani (1983) for the dual.

#include <cstddef>
#include <span>
#include <vector>

namespace ugoki::control {

class QuadraticProgram {
 public:
  /// Starts a program. Allocates only if a size exceeds all earlier sizes. The caller fills weights(), centre(), and the rows.
  /// @param loads number m of loads  @param load_cost eps > 0
  void begin(int unknowns, int loads, double load_cost);

  /// Allocates memory for programs up to this size; smaller programs then allocate nothing.
  void reserve(int unknowns, int loads, int equations, int balances);

  [[nodiscard]] std::span<double> weights() { return {weights_.data(), n_}; }  ///< [n] w > 0
  [[nodiscard]] std::span<double> centre() { return {centre_.data(), n_}; }    ///< [n] x0

  /// Adds an equation; call it before solve(). @return its row c [n], zeros to be overwritten; valid until the next row is added
  std::span<double> add_equation(double target, double softness);
  /// Coefficients c [n] and g [m] of a new balance, filled with zeros for the caller to overwrite.
  struct Balance {
    std::span<double> c, g;
  };
  /// Adds a balance. If it is added after solve(), the next solve() starts from the present solution.
  Balance add_balance(double lower, double upper, double softness);

  /// Solves the program. @param start initial multipliers of the first balances; the other multipliers start at zero
  /// @return false if the method did not converge within the maximum number of iterations; the result is then the best found
  bool solve(std::span<const double> start = {});

  [[nodiscard]] std::span<const double> x() const { return {x_.data(), n_}; }
  [[nodiscard]] std::span<const double> loads() const { return {beta_.data(), m_}; }
  [[nodiscard]] std::span<const double> balance_multipliers() const { return {z_.data(), balances_}; }
  /// Slack s_r of a balance.
  [[nodiscard]] double slack(int balance) const;
  [[nodiscard]] int iterations() const { return iterations_; }  ///< Newton steps of the last solve()
  [[nodiscard]] double residual() const { return residual_; }   ///< maximum violation of the optimality conditions, in units of the rows
  [[nodiscard]] std::size_t equations() const { return rows_; }

 private:
  void factor_equations();
  void eliminate(std::size_t balance);
  void find_step(std::size_t count);
  void search_line(std::size_t count);
  double objective(std::span<const double> z, std::span<double> edge) const;
  void recover();

  std::size_t n_ = 0, m_ = 0, rows_ = 0, balances_ = 0, eliminated_ = 0;
  double eps_ = 1;
  bool factored_ = false;
  std::vector<double> weights_, centre_;
  std::vector<double> c_, t_, sigma_;                 // [rows * n], [rows], [rows] equations
  std::vector<double> ct_;                            // [n * rows] transposed rows, scaled by W^-1/2
  std::vector<double> u_;                             // [rows * rows] upper Cholesky factor of the equations' block, row by row
  std::vector<double> y_;                             // [rows] U^-T (t - C x0)
  std::vector<double> bc_, bg_, lower_, upper_, bs_;  // balances: c [n], g [m], limits, softness
  std::vector<double> v_;                             // [balances * rows] U^-T (C W^-1 c)
  std::vector<double> k_, base_;                      // core: matrix [balances * stride]; c x for z = 0 after elimination of the equations
  std::size_t stride_ = 0;
  std::vector<double> z_, x_, beta_, all_z_;
  std::vector<double> edge_, trial_edge_, value_, step_, trial_, h_;  // scratch of solve()
  std::vector<int> sign_, free_;
  int iterations_ = 0;
  double residual_ = 0;
};

}  // namespace ugoki::control
